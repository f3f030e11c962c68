//! Intervals of means, from a sample of numbers that lie between 0 and 1.

use statrs::distribution::{ContinuousCDF, Normal, StudentsT};
use statrs::function::beta::beta_reg;

/// The fewest independent samples whose scatter is trusted: the means of fewer need not be normal,
/// and Student's interval of two or three of them rests on that.
pub const LEAST_SAMPLES: usize = 8;

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
}

/// The interval of the mean of independent numbers, or of several samples of about equal size that are independent of each
/// other, while the numbers within each need not be (randomised designs).
///
/// Independent numbers between 0 and 1 scatter no more than zeros and ones of the same mean: they have the interval of
/// [Clopper and Pearson](clopper_pearson), with their sum as the count. Several samples have the one [of their
/// means](of_samples), whatever hangs together within each.
///
/// Fewer than [`LEAST_SAMPLES`] count as one sample of independent numbers.
pub fn of_mean(parts: &[Moments], confidence: f64) -> [f64; 2] {
    let total = Moments::total(parts);
    if parts.len() < LEAST_SAMPLES || parts.iter().any(|part| part.count == 0) {
        return independent(total, confidence);
    }
    let means: Vec<f64> = parts.iter().map(Moments::mean).collect();
    of_samples(total.mean(), &means, total.count, confidence)
}

/// The interval of the mean of the numbers of a random part of the sample, such as the accepted
/// points.
///
/// Given how many there are, they are a sample of their own (see [`of_mean`]). Of several samples
/// the interval is that of a ratio of means by its linearisation (Cochran 1977, "Sampling
/// Techniques", 6.4); where they are too few for it, the wider ends of it and of independent numbers hold.
pub fn of_part(parts: &[Moments], confidence: f64) -> [f64; 2] {
    const FEW: u64 = 4;
    let total = Moments::total(parts);
    let samples = parts.len() as u64;
    if parts.len() < LEAST_SAMPLES || total.count == 0 {
        return independent(total, confidence);
    }
    let (ratio, mean_count) = (total.mean(), total.count as f64 / samples as f64);
    let linear = |part: &Moments| ratio + (part.sum - ratio * part.count as f64) / mean_count;
    let values: Vec<f64> = parts.iter().map(linear).collect();
    let ends = of_samples(ratio, &values, total.count, confidence);
    if total.count < FEW * samples { wider(ends, independent(total, confidence)) } else { ends }
}

fn independent(total: Moments, confidence: f64) -> [f64; 2] {
    clopper_pearson(total.sum, total.count as f64, confidence)
}

/// The wider ends of two intervals.
pub(super) fn wider(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0].min(b[0]), a[1].max(b[1])]
}

/// The interval about a mean from values of independent samples that scatter about it, drawn out by what so many numbers may
/// have missed.
///
/// The samples scatter as so many independent zeros and ones would: these have the interval of Clopper and Pearson, their
/// number made smaller for the few samples that tell the scatter (Korn and Graubard 1998, "Confidence intervals for
/// proportions with small expected number of positive counts estimated from survey data", Survey Methodology 24). It leans
/// as the distribution of a share near 0 or 1 does, which Student's interval does not. Where the number is large, both are
/// the same.
pub(super) fn of_samples(mean: f64, values: &[f64], numbers: u64, confidence: f64) -> [f64; 2] {
    const MANY: f64 = 1e4;
    let n = values.len() as f64;
    let centre = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|value| (value - centre).powi(2)).sum::<f64>() / (n - 1.0) / n;
    let shrunk = (normal_limit(confidence) / student_limit(confidence, n - 1.0)).powi(2);
    let effective = shrunk * mean * (1.0 - mean) / variance;
    let ends = if effective < MANY {
        clopper_pearson(mean * effective, effective, confidence)
    } else {
        student(mean, values, confidence)
    };
    drawn_out(ends, numbers, confidence)
}

/// Draws an interval out by the largest part of a population that so many numbers miss with a
/// probability that is not below the one for each end of the interval. What was missed is 0 or 1 at worst.
fn drawn_out(ends: [f64; 2], numbers: u64, confidence: f64) -> [f64; 2] {
    let missed = clopper_pearson(0.0, numbers as f64, confidence)[1];
    let [low, high] = ends.map(|end| end.clamp(0.0, 1.0));
    [(low - missed).max(0.0), high + missed * (1.0 - high)]
}

/// The interval of a share from independent trials, whose number was fixed beforehand: no share
/// outside of it makes the count, or a more extreme one, probable (Clopper and Pearson 1934, "The use
/// of confidence or fiducial limits illustrated in the case of the binomial", Biometrika 26). Counts
/// need not be whole.
///
/// Wilson's interval is narrower, but at small shares its lower limit is too high too often: one of
/// 100 points would show a share of 0.18 %, which by chance has that point in 16 % of the studies.
pub fn clopper_pearson(hits: f64, trials: f64, confidence: f64) -> [f64; 2] {
    // Of less than a tenth of a hit the limit is below 1e-15.
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

/// Student's interval about a centre, from independent values that scatter about it.
fn student(centre: f64, values: &[f64], confidence: f64) -> [f64; 2] {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    let half = student_limit(confidence, n - 1.0) * (squares / (n - 1.0) / n).sqrt();
    [(centre - half).max(0.0), (centre + half).min(1.0)]
}

/// Within this many standard deviations a normal number lies with the given probability.
pub(super) fn normal_limit(confidence: f64) -> f64 {
    Normal::standard().inverse_cdf(0.5 + 0.5 * confidence)
}

/// The same for Student's distribution.
pub(super) fn student_limit(confidence: f64, freedom: f64) -> f64 {
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
            let counted = moments((0..263).map(|i| f64::from(u8::from(i < hits))));
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
        assert_eq!([low, high], clopper_pearson(0.8, 5.0, 0.95));
        let parts = vec![moments([0.16; 5]); 16];
        let [low, high] = of_mean(&parts, 0.95);
        assert!(low < 0.155 && high > 0.19, "{low} {high}");
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

    /// 16 samples that hardly scatter: Student's interval by hand, and what 16,000 numbers may have missed.
    #[test]
    fn several_samples_have_students_interval() {
        let part = |k: usize| moments((0..1000).map(move |i| if i < 400 + k % 3 { 0.5 } else { 0.1 }));
        let parts: Vec<Moments> = (0..16).map(part).collect();
        let means: Vec<f64> = parts.iter().map(Moments::mean).collect();
        let mean = means.iter().sum::<f64>() / 16.0;
        let variance = means.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / 15.0;
        let half = 2.131_449_5 * (variance / 16.0).sqrt();
        let missed = 1.0 - 0.025_f64.powf(1.0 / 16_000.0);
        let [low, high] = of_mean(&parts, 0.95);
        let to = mean + half;
        assert!((low - (mean - half - missed)).abs() < 1e-8);
        assert!((high - (to + (1.0 - to) * missed)).abs() < 1e-8);
    }

    #[test]
    fn few_numbers_of_a_part_make_one_sample() {
        let accepted = [moments([0.2, 0.4]), moments([0.3])];
        let one = of_mean(&[Moments::total(&accepted)], 0.95);
        assert_eq!(of_part(&accepted, 0.95), one);
        // Eight samples, and too few numbers to tell how these scatter: no narrower than independent ones.
        let rare: Vec<Moments> = (0..8).map(|k| moments((k < 3).then_some(0.2 * f64::from(k)))).collect();
        let [low, high] = of_part(&rare, 0.95);
        let [least, most] = clopper_pearson(0.6, 3.0, 0.95);
        assert!(low <= least && high >= most, "{low} {high}");
        let none = [moments([0.2, 0.4]), Moments::default()];
        assert_eq!(of_mean(&none, 0.95), clopper_pearson(none[0].sum, 2.0, 0.95));
    }
}

#[cfg(test)]
mod coverage_tests;
