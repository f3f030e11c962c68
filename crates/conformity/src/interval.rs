//! Intervals of means, from a sample of numbers that lie between 0 and 1.

use statrs::{
    distribution::{ContinuousCDF, Normal, StudentsT},
    function::beta::beta_reg,
};

/// The fewest independent nets whose mean has an interval. Each counts as one trial, so that fewer tell next to nothing.
pub const LEAST_SAMPLES: usize = 16;

/// Sums over a sample of numbers from 0 to 1, from which intervals are computed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moments {
    /// How many.
    pub count: u64,
    /// Their sum.
    pub sum: f64,
    /// The sum of their squares.
    pub squares: f64,
}

impl Moments {
    /// Takes one more number.
    pub fn add(&mut self, number: f64) {
        self.merge(Self { count: 1, sum: number, squares: number * number });
    }

    /// Takes the numbers of another sample.
    pub fn merge(&mut self, other: Self) {
        self.count += other.count;
        self.sum += other.sum;
        self.squares += other.squares;
    }

    /// All samples as one.
    pub fn total(parts: &[Self]) -> Self {
        let mut total = Self::default();
        parts.iter().for_each(|part| total.merge(*part));
        total
    }

    /// The mean; 0 of no numbers.
    pub fn mean(&self) -> f64 {
        self.sum / (self.count.max(1) as f64)
    }

    /// The moments of 1 - x, for all x of the sample.
    pub fn complement(&self) -> Self {
        let n = self.count as f64;
        Self { count: self.count, sum: (n - self.sum).max(0.0), squares: (n - 2.0 * self.sum + self.squares).max(0.0) }
    }

    /// The moments of `factor` times x, for all x of the sample.
    pub fn scaled(&self, factor: f64) -> Self {
        Self { count: self.count, sum: factor * self.sum, squares: factor * factor * self.squares }
    }

    /// Student's interval about the mean of independent numbers; that of fewer than two is unknown.
    fn student(&self, confidence: f64) -> [f64; 2] {
        let (n, mean) = (self.count as f64, self.mean());
        let variance = ((self.squares - n * mean * mean) / (n - 1.0)).max(0.0);
        let half = student_limit(confidence, n - 1.0) * (variance / n).sqrt();
        [mean - half, mean + half]
    }
}

/// The interval of the mean of independent numbers between 0 and 1, or of several samples of about equal size that are
/// independent of each other, while the numbers within each need not be (nets). Of one net, or too few ([`LEAST_SAMPLES`]),
/// nothing tells how far their mean is off: do not ask.
///
/// Few of the numbers may carry the whole mean, as those near a limit carry a risk. A sample that has missed them scatters
/// little, so that its scatter alone promises too much. So independent numbers have the narrower ends of two intervals:
/// Clopper and Pearson's with the sum as the count (numbers between 0 and 1 scatter no more than zeros and ones of the same
/// mean), and Student's, drawn out by what so many numbers may have missed. Their narrower ends are no theorem; `coverage_tests`
/// tries them.
///
/// The points of a net may lie in clumps, of which no net says how large they are: in small nets some coordinates share their
/// first digits, so that a corner of five of them holds half of one net and no point of sixteen others. Scatter over the nets
/// that were drawn says nothing of it, so each net is one trial, whose mean is a number between 0 and 1.
pub fn of_mean(parts: &[Moments], confidence: f64) -> [f64; 2] {
    let total = Moments::total(parts);
    if parts.len() > 1 {
        let nets = parts.len() as f64;
        return if parts.iter().all(|part| part.count > 0) {
            clopper_pearson(parts.iter().map(Moments::mean).sum(), nets, confidence)
        } else {
            [0.0, 1.0]
        };
    }
    if total.count < 2 {
        return clopper_pearson(total.sum, total.count as f64, confidence);
    }
    let scattering = drawn_out(total.student(confidence), total, confidence);
    let counted = clopper_pearson(total.sum, total.count as f64, confidence);
    [counted[0].max(scattering[0]), counted[1].min(scattering[1])]
}

/// The interval of the mean of the numbers of a random part of the sample, such as the accepted points.
///
/// Given how many there are, they are a sample of their own (see [`of_mean`]). Of several nets a rare one may hold most of the part,
/// of which the others say nothing.
pub fn of_part(parts: &[Moments], confidence: f64) -> [f64; 2] {
    if parts.len() > 1 { [0.0, 1.0] } else { of_mean(parts, confidence) }
}

/// Draws an interval out by the largest part of a population that so many independent numbers miss with a probability that
/// is not below the one for each end of the interval. Numbers that were missed are 0 or 1 at worst; each would lower the
/// mean by no more than the mean.
fn drawn_out(ends: [f64; 2], numbers: Moments, confidence: f64) -> [f64; 2] {
    let missed = clopper_pearson(0.0, numbers.count as f64, confidence)[1];
    let [low, high] = ends.map(|end| end.clamp(0.0, 1.0));
    [(low - missed * numbers.mean()).max(0.0), high + missed * (1.0 - high)]
}

/// The interval of a share from independent trials, whose number was fixed beforehand: no share
/// outside of it makes the count, or a more extreme one, probable (Clopper and Pearson 1934, "The use
/// of confidence or fiducial limits illustrated in the case of the binomial", Biometrika 26). Counts
/// need not be whole.
///
/// Wilson's interval is narrower, but at small shares its lower limit is too high too often: one of
/// 100 points would show a share of 0.18 %, which by chance has that point in 16 % of the studies.
pub fn clopper_pearson(hits: f64, trials: f64, confidence: f64) -> [f64; 2] {
    // Below a tenth of a hit the limit is next to nothing; 0 is on the safe side.
    const NONE: f64 = 0.1;
    let tail = 0.5 * (1.0 - confidence);
    let misses = trials - hits;
    // The probability of at least `hits` grows with the share, that of at most `hits` falls.
    let low = if hits < NONE { 0.0 } else { crossing(|share| beta_reg(hits, misses.max(0.0) + 1.0, share) - tail)[0] };
    let high = if misses < NONE {
        1.0
    } else {
        crossing(|share| beta_reg(hits.max(0.0) + 1.0, misses, share) - 1.0 + tail)[1]
    };
    [low, high]
}

/// The end points of a small interval in which a function that grows from below 0 to above 0
/// between 0 and 1 changes its sign.
pub(super) fn crossing(grows: impl Fn(f64) -> f64) -> [f64; 2] {
    let (mut low, mut high) = (0.0_f64, 1.0_f64);
    while high - low > 1e-14 * high {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if grows(middle) < 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    [low, high]
}

/// Within this many standard deviations a normal number lies with the given probability.
pub(super) fn normal_limit(confidence: f64) -> f64 {
    Normal::standard().inverse_cdf(0.5 + 0.5 * confidence)
}

/// The same for Student's distribution.
fn student_limit(confidence: f64, freedom: f64) -> f64 {
    if freedom > 1e5 {
        return normal_limit(confidence);
    }
    StudentsT::new(0.0, 1.0, freedom).map_or(f64::INFINITY, |student| student.inverse_cdf(0.5 + 0.5 * confidence))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn moments(numbers: impl IntoIterator<Item = f64>) -> Moments {
        let mut moments = Moments::default();
        numbers.into_iter().for_each(|number| moments.add(number));
        moments
    }

    /// Newcombe (1998), "Two-sided confidence intervals for the single proportion", table I.
    #[test]
    fn clopper_pearson_matches_published_values() {
        for (hits, trials, published) in [
            (81.0, 263.0, [0.2527, 0.3676]),
            (15.0, 148.0, [0.0578, 0.1617]),
            (0.0, 20.0, [0.0, 0.1684]),
            (1.0, 29.0, [0.0009, 0.1776]),
        ] {
            let interval = clopper_pearson(hits, trials, 0.95);
            for (end, published) in interval.iter().zip(published) {
                assert!((end - published).abs() < 5.1e-5, "{hits}");
            }
        }
        assert_eq!(clopper_pearson(20.0, 20.0, 0.95)[1], 1.0);
        assert_eq!(clopper_pearson(0.0, 0.0, 0.95), [0.0, 1.0]);
        // Exact by hand: 1 - 0.025^(1/n).
        let [low, high] = clopper_pearson(0.0, 50_000.0, 0.95);
        let expected = 1.0 - 0.025_f64.powf(1.0 / 50_000.0);
        assert!(low == 0.0 && (high - expected).abs() < 1e-12, "{low} {high}");
    }

    /// The limits of half a hit of ten trials are quantiles of beta distributions: 2.5 % of B(0.5,
    /// 10.5) and 97.5 % of B(1.5, 9.5).
    #[test]
    fn counts_need_not_be_whole() {
        let [low, high] = clopper_pearson(0.5, 10.0, 0.95);
        assert!((beta_reg(0.5, 10.5, low) - 0.025).abs() < 1e-9, "{low}");
        assert!((beta_reg(1.5, 9.5, high) - 0.975).abs() < 1e-9, "{high}");
    }

    #[test]
    fn counts_have_clopper_and_pearsons_interval() {
        for hits in [0, 1, 2, 5, 20, 80, 131, 200, 262, 263] {
            let counted = moments((0..263).map(|i| f64::from(i < hits)));
            let interval = of_mean(&[counted], 0.95);
            let expected = clopper_pearson(f64::from(hits), 263.0, 0.95);
            for k in 0..2 {
                assert!((interval[k] - expected[k]).abs() < 1e-12, "{hits}");
            }
        }
        assert_eq!(of_mean(&[Moments::default()], 0.95), [0.0, 1.0]);
        assert_eq!(of_mean(&[], 0.95), [0.0, 1.0]);
    }

    /// Five numbers that happen to be equal tell little of what else there is.
    #[test]
    fn equal_numbers_have_no_interval_of_width_zero() {
        let [low, high] = of_mean(&[moments([0.16; 5])], 0.95);
        assert!(low < 0.08 && high > 0.5, "{low} {high}");
    }

    /// For many numbers the interval is the normal one of the mean, but for what they may have
    /// missed: 3.7 of them.
    #[test]
    fn many_numbers_have_the_normal_interval() {
        const N: u32 = 1_000_000;
        let numbers = (0..N).map(|i| 0.3 + 0.1 * f64::from(i % 5));
        let half = 1.959_964 * 0.1 * 2.0_f64.sqrt() / f64::from(N).sqrt();
        let missed = -0.025_f64.ln() / f64::from(N);
        let [low, high] = of_mean(&[moments(numbers)], 0.95);
        let expected = [0.5 - half - 0.5 * missed, 0.5 + half + (0.5 - half) * missed];
        assert!((low - expected[0]).abs() < 1e-9, "{low}");
        assert!((high - expected[1]).abs() < 1e-9, "{high}");
    }

    #[test]
    fn complements_and_zeros() {
        let numbers = [0.1, 0.5, 1.0];
        let expected = moments(numbers.map(|x| 1.0 - x));
        let complement = moments(numbers).complement();
        assert!((complement.sum - expected.sum).abs() < 1e-15);
        assert!((complement.squares - expected.squares).abs() < 1e-15);
        let with_zeros = Moments { count: 5, ..moments(numbers) };
        assert_eq!(with_zeros, moments([0.1, 0.5, 1.0, 0.0, 0.0]));
    }

    /// Eight nets without a hit, or with all hits in one of them, are eight trials.
    #[test]
    fn hits_of_few_nets_count_each_net_once() {
        let none = vec![moments([0.0; 64]); 8];
        assert_eq!(of_mean(&none, 0.95), clopper_pearson(0.0, 8.0, 0.95));
        let mut one = none;
        one[3] = moments([1.0; 64]);
        assert_eq!(of_mean(&one, 0.95), clopper_pearson(1.0, 8.0, 0.95));
    }

    /// However equal the nets are: another one may hold none of the points that count, or all.
    #[test]
    fn each_net_is_one_trial() {
        let half = |k: usize| f64::from(k < 32);
        let nets = vec![moments((0..64).map(half)); 8];
        assert_eq!(of_mean(&nets, 0.95), clopper_pearson(4.0, 8.0, 0.95));
        // In small nets five coordinates share their first digits: half of one net lies in a corner, and of 16 others no point.
        assert_eq!(of_part(&nets, 0.95), [0.0, 1.0]);
        let empty = [moments([0.2, 0.4]), Moments::default()];
        assert_eq!(of_mean(&empty, 0.95), [0.0, 1.0]);
    }
}

#[cfg(test)]
mod coverage_tests;
