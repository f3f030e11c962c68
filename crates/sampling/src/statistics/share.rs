//! Counted shares with their uncertainty.

use crate::distribution::normal_quantile;

/// The interval of a probability that was seen in a share of independent trials, of which there may be any number: the
/// score interval of Wilson (1927), "Probable inference, the law of succession, and statistical inference", J. Am. Stat.
/// Assoc. 22. Of no trials at all the interval is 0 to 1.
pub fn wilson(share: f64, trials: f64, confidence: f64) -> [f64; 2] {
    score(share, trials, normal_quantile(0.5 + 0.5 * confidence))
}

fn score(p: f64, n: f64, z: f64) -> [f64; 2] {
    if n <= 0.0 {
        return [0.0, 1.0];
    }
    let z2 = z * z;
    let centre = (p + z2 / (2.0 * n)) / (1.0 + z2 / n);
    let half = z / (1.0 + z2 / n) * (p * (1.0 - p) / n + z2 / (4.0 * n * n)).sqrt();
    // At the ends rounding must not leave a rest.
    let low = if p <= 0.0 { 0.0 } else { centre - half };
    let high = if p >= 1.0 { 1.0 } else { centre + half };
    [low.max(0.0), high.min(1.0)]
}

/// A counted fraction with its 95 % interval.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Fraction {
    /// How many.
    pub count: usize,
    /// Number of trials.
    pub of: usize,
    /// Lower end of the 95 % interval, 0 to 1.
    pub low: f64,
    /// Upper end of the 95 % interval, 0 to 1.
    pub high: f64,
}

impl Fraction {
    /// A fraction of independent trials, with [Wilson's interval](wilson).
    pub fn wilson(count: usize, of: usize) -> Self {
        // The two-sided 95 % point of the standard normal distribution.
        const Z95: f64 = 1.959_963_984_540_054;
        let [low, high] = score(count as f64 / of as f64, of as f64, Z95);
        Self { count, of, low, high }
    }

    /// The fraction itself; 0 of no trials.
    pub fn value(&self) -> f64 {
        if self.of == 0 { 0.0 } else { self.count as f64 / self.of as f64 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Newcombe (1998), "Two-sided confidence intervals for the single proportion", table I.
    #[test]
    fn wilson_matches_published_values() {
        for (count, of, low, high) in
            [(81, 263, 0.2553, 0.3662), (15, 148, 0.0624, 0.1605), (0, 20, 0.0, 0.1611), (1, 29, 0.0061, 0.1718)]
        {
            let f = Fraction::wilson(count, of);
            assert!((f.low - low).abs() < 5e-5, "{f:?}");
            assert!((f.high - high).abs() < 5e-5, "{f:?}");
        }
    }

    #[test]
    fn a_fraction_of_nothing_is_zero() {
        assert_eq!(Fraction::wilson(0, 0).value(), 0.0);
        assert_eq!(Fraction::wilson(3, 4).value(), 0.75);
    }

    #[test]
    fn wilson_at_the_ends() {
        assert_eq!(Fraction::wilson(7, 7).high, 1.0);
        assert_eq!(Fraction::wilson(0, 0), Fraction { count: 0, of: 0, low: 0.0, high: 1.0 });
    }
}
