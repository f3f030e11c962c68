//! Intervals of means, from a sample of numbers that lie between 0 and 1.

use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

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
        self.merge(Self {
            count: 1,
            sum: number,
            squares: number * number,
        });
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
        Self {
            count: self.count,
            sum: (n - self.sum).max(0.0),
            squares: (n - 2.0 * self.sum + self.squares).max(0.0),
        }
    }

    /// The same sample with zeros added until there are `count` numbers.
    pub fn among(self, count: u64) -> Self {
        Self { count, ..self }
    }

    /// How many ones and zeros would tell as much about their mean as these numbers do about
    /// theirs; without a scatter to judge by, as many as there are numbers.
    ///
    /// Korn and Graubard (1998), "Confidence intervals for proportions with small expected number of
    /// positive counts estimated from survey data", Survey Methodology 24, with their correction for
    /// the few degrees of freedom of a small sample.
    fn effective_count(&self, confidence: f64) -> f64 {
        let (n, mean) = (self.count as f64, self.mean());
        if self.count < 2 || mean <= 0.0 || mean >= 1.0 {
            return n;
        }
        let variance = ((self.squares - n * mean * mean) / (n - 1.0)).max(0.0);
        let few = normal_limit(confidence) / student_limit(confidence, n - 1.0);
        n * mean * (1.0 - mean) / variance * few * few
    }
}

/// The interval of the mean of a sample, or of several samples of about equal size that are
/// independent of each other, while the numbers within each need not be (randomised designs).
///
/// One sample: Wilson's score interval (1927) at the effective number of trials. Several:
/// Student's interval about the mean of their means, as long as enough numbers differ from 0 and
/// from 1 to let these means scatter; otherwise the samples count as one.
pub fn of_mean(parts: &[Moments], confidence: f64) -> [f64; 2] {
    let total = Moments::total(parts);
    if parts.len() > 1 && scatters(total, parts.len()) && scatters(total.complement(), parts.len())
    {
        let means: Vec<f64> = parts.iter().map(Moments::mean).collect();
        return student(total.mean(), &means, confidence);
    }
    wilson(total.mean(), total.effective_count(confidence), confidence)
}

/// Whether there are enough numbers other than 0, counted by their weight, for so many samples.
fn scatters(numbers: Moments, samples: usize) -> bool {
    numbers.sum * numbers.sum >= samples as f64 * numbers.squares && numbers.sum > 0.0
}

/// The interval of the mean of the numbers of a random part of the sample, such as the accepted
/// points.
///
/// One sample: given how many there are, they are a sample of their own. Several: Student's
/// interval of a ratio of means by its linearisation (Cochran 1977, "Sampling Techniques", 6.4).
pub fn of_part(parts: &[Moments], confidence: f64) -> [f64; 2] {
    const FEW: u64 = 4;
    let total = Moments::total(parts);
    let samples = parts.len() as u64;
    if samples > 1 && total.count >= FEW * samples && scatters(total, parts.len()) {
        let (ratio, mean_count) = (total.mean(), total.count as f64 / samples as f64);
        let linear = |part: &Moments| ratio + (part.sum - ratio * part.count as f64) / mean_count;
        let values: Vec<f64> = parts.iter().map(linear).collect();
        return student(ratio, &values, confidence);
    }
    wilson(total.mean(), total.effective_count(confidence), confidence)
}

/// Wilson's score interval of a share of trials, of which there may be any number.
pub fn wilson(share: f64, trials: f64, confidence: f64) -> [f64; 2] {
    if trials <= 0.0 {
        return [0.0, 1.0];
    }
    if trials.is_infinite() {
        return [share, share];
    }
    let z2 = normal_limit(confidence).powi(2);
    let centre = share + z2 / (2.0 * trials);
    let spread = (z2 * (share * (1.0 - share) / trials + z2 / (4.0 * trials * trials))).sqrt();
    let scale = 1.0 + z2 / trials;
    let low = if share <= 0.0 {
        0.0
    } else {
        (centre - spread) / scale
    };
    let high = if share >= 1.0 {
        1.0
    } else {
        (centre + spread) / scale
    };
    [low.max(0.0), high.min(1.0)]
}

/// Student's interval about a centre, from independent values that scatter about it.
pub(super) fn student(centre: f64, values: &[f64], confidence: f64) -> [f64; 2] {
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
fn student_limit(confidence: f64, freedom: f64) -> f64 {
    if freedom > 1e5 {
        return normal_limit(confidence);
    }
    StudentsT::new(0.0, 1.0, freedom).map_or(f64::INFINITY, |student| {
        student.inverse_cdf(0.5 + 0.5 * confidence)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng, rngs::StdRng};

    fn moments(numbers: impl IntoIterator<Item = f64>) -> Moments {
        let mut moments = Moments::default();
        numbers.into_iter().for_each(|number| moments.add(number));
        moments
    }

    #[test]
    fn counts_have_nearly_wilsons_interval() {
        // Newcombe (1998), table I: 81 of 263 gives 0.2553..0.3662.
        let [low, high] = wilson(81.0 / 263.0, 263.0, 0.95);
        assert!((low - 0.2553).abs() < 5e-5 && (high - 0.3662).abs() < 5e-5);
        let counted = moments((0..263).map(|i| f64::from(u8::from(i < 81))));
        let [below, above] = of_mean(&[counted], 0.95);
        assert!(below < low && below > low - 5e-4, "{below} {low}");
        assert!(above > high && above < high + 5e-4, "{above} {high}");
        assert_eq!(
            of_mean(&[moments([0.0; 20])], 0.95),
            wilson(0.0, 20.0, 0.95)
        );
        assert_eq!(
            of_mean(&[moments([1.0; 20])], 0.95),
            wilson(1.0, 20.0, 0.95)
        );
        assert_eq!(of_mean(&[Moments::default()], 0.95), [0.0, 1.0]);
    }

    /// For many numbers the interval is the normal one of the mean.
    #[test]
    fn many_numbers_have_the_normal_interval() {
        let numbers = || (0..10_000).map(|i| 0.3 + 0.1 * f64::from(i % 5));
        let deviation = 0.1 * 2.0_f64.sqrt();
        let half = 1.959_964 * deviation / 100.0;
        let [low, high] = of_mean(&[moments(numbers())], 0.95);
        assert!((low - (0.5 - half)).abs() < 2e-6, "{low}");
        assert!((high - (0.5 + half)).abs() < 2e-6, "{high}");
    }

    #[test]
    fn complements_and_zeros() {
        let numbers = [0.1, 0.5, 1.0];
        let expected = moments(numbers.map(|x| 1.0 - x));
        let found = moments(numbers).complement();
        assert!((found.sum - expected.sum).abs() < 1e-15);
        assert!((found.squares - expected.squares).abs() < 1e-15);
        let found = moments(numbers).among(5);
        assert_eq!(found, moments([0.1, 0.5, 1.0, 0.0, 0.0]));
    }

    /// 16 samples whose means are known: Student's interval by hand.
    #[test]
    fn several_samples_have_students_interval() {
        let part = |k: usize| moments((0..10).map(move |i| if i < 4 + k % 3 { 0.5 } else { 0.1 }));
        let parts: Vec<Moments> = (0..16).map(part).collect();
        let means: Vec<f64> = parts.iter().map(Moments::mean).collect();
        let mean = means.iter().sum::<f64>() / 16.0;
        let variance = means.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / 15.0;
        let half = 2.131_449_5 * (variance / 16.0).sqrt();
        let [low, high] = of_mean(&parts, 0.95);
        assert!((low - (mean - half)).abs() < 1e-8 && (high - (mean + half)).abs() < 1e-8);
    }

    #[test]
    fn rare_numbers_make_one_sample() {
        let mut parts = vec![moments([0.0; 10]); 16];
        parts[3] = moments([0.0, 0.0, 0.4, 0.4]).among(10);
        let one = of_mean(&[Moments::total(&parts)], 0.95);
        assert_eq!(of_mean(&parts, 0.95), one);
        assert!(one[1] > 0.005);
        let accepted = [moments([0.2, 0.4]), moments([0.3])];
        assert_eq!(
            of_part(&accepted, 0.95),
            of_mean(&[Moments::total(&accepted)], 0.95)
        );
    }

    /// Of 2,000 samples about 95 % hold the mean of the population, of the part as well.
    #[test]
    fn intervals_hold_the_mean_as_often_as_they_say() {
        let mut random = StdRng::seed_from_u64(1);
        for (size, accepted) in [(50, 0.5), (200, 0.1), (1000, 0.9)] {
            let (mut of_all, mut of_accepted) = (0, 0);
            for _ in 0..2000 {
                let mut part = Moments::default();
                for _ in 0..size {
                    // Accepted numbers are squares of uniform ones: their mean is 1/3.
                    let (u, v): (f64, f64) = (random.random(), random.random());
                    if v < accepted {
                        part.add(u * u);
                    }
                }
                let holds = |[low, high]: [f64; 2], value| low <= value && value <= high;
                of_all += u32::from(holds(of_mean(&[part.among(size)], 0.95), accepted / 3.0));
                of_accepted += u32::from(holds(of_part(&[part], 0.95), 1.0 / 3.0));
            }
            for held in [of_all, of_accepted] {
                let coverage = f64::from(held) / 2000.0;
                assert!(
                    (coverage - 0.95).abs() < 0.02,
                    "{size} {accepted}: {coverage}"
                );
            }
        }
    }

    /// The samples share a random shift, as those of a randomised design share its numbers.
    #[test]
    fn intervals_of_dependent_numbers_hold_as_often_too() {
        let mut random = StdRng::seed_from_u64(2);
        let (mut of_all, mut of_accepted) = (0, 0);
        for _ in 0..2000 {
            let parts: Vec<Moments> = (0..16)
                .map(|_| {
                    let shift: f64 = random.random();
                    let place = |i: u32| (f64::from(i) / 20.0 + shift).fract();
                    moments((0..20).map(place).filter(|&u| u < 0.61))
                })
                .collect();
            let holds = |[low, high]: [f64; 2], value| low <= value && value <= high;
            let zeros: Vec<Moments> = parts.iter().map(|part| part.among(20)).collect();
            of_all += u32::from(holds(of_mean(&zeros, 0.95), 0.61 * 0.61 / 2.0));
            of_accepted += u32::from(holds(of_part(&parts, 0.95), 0.305));
        }
        for held in [of_all, of_accepted] {
            let coverage = f64::from(held) / 2000.0;
            assert!((coverage - 0.95).abs() < 0.03, "{coverage}");
        }
    }
}
