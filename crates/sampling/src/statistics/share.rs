//! Counted shares with their uncertainty.

use statrs::distribution::{ContinuousCDF, StudentsT};

use super::moments::variance;

/// The two-sided 95 % point of the standard normal distribution.
pub const Z95: f64 = 1.959_963_984_540_054;

/// The 95 % interval of a probability of which `hits` of `total` trials are known: the score interval of Wilson
/// (1927), "Probable inference, the law of succession, and statistical inference", J. Am. Stat. Assoc. 22. Of no
/// trials at all the interval is 0 to 1.
pub fn wilson(hits: u64, total: u64) -> [f64; 2] {
    if total == 0 {
        return [0.0, 1.0];
    }
    let (n, p, z2) = (total as f64, hits as f64 / total as f64, Z95 * Z95);
    let centre = (p + z2 / (2.0 * n)) / (1.0 + z2 / n);
    let half = Z95 / (1.0 + z2 / n) * (p * (1.0 - p) / n + z2 / (4.0 * n * n)).sqrt();
    let low = if hits == 0 {
        0.0
    } else {
        (centre - half).max(0.0)
    };
    let high = if hits == total {
        1.0
    } else {
        (centre + half).min(1.0)
    };
    [low, high]
}

/// A counted fraction with its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq)]
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
        let [low, high] = wilson(count as u64, of as u64);
        Self {
            count,
            of,
            low,
            high,
        }
    }

    /// The fraction itself; 0 of no trials.
    pub fn value(&self) -> f64 {
        if self.of == 0 {
            0.0
        } else {
            self.count as f64 / self.of as f64
        }
    }
}

/// The 95 % interval of a share of points that belong in turn to independent randomisations of a
/// quasi-random design, given the count of each: Student's about the mean of their shares (Owen 1997,
/// "Monte Carlo variance of scrambled net quadrature", SIAM J. Numerical Analysis 34; L'Ecuyer,
/// Nakayama, Owen & Tuffin 2023, "Confidence intervals for randomized quasi-Monte Carlo estimators",
/// Winter Simulation Conference). Narrower than [`wilson`], which does not know that the
/// points were spread evenly.
///
/// Where fewer points pass (or fail) than there are randomisations, most shares are equal and their
/// scatter tells nothing: then, and for a single randomisation, the interval is Wilson's.
pub fn randomised_share(counts: &[u64], points: u64) -> [f64; 2] {
    let (n, total) = (counts.len() as u64, counts.iter().sum::<u64>());
    let wilson = Fraction::wilson(total as usize, points as usize);
    let rare = total < n || points.saturating_sub(total) < n;
    let student = StudentsT::new(0.0, 1.0, n as f64 - 1.0);
    let (false, Ok(student)) = (rare, student) else {
        return [wilson.low, wilson.high];
    };
    let size = |k: usize| points / n + u64::from((k as u64) < points % n);
    let shares: Vec<f64> = counts
        .iter()
        .enumerate()
        .map(|(k, c)| *c as f64 / size(k) as f64)
        .collect();
    let half = student.inverse_cdf(0.975) * (variance(&shares, 1) / n as f64).sqrt();
    let share = wilson.value();
    [(share - half).max(0.0), (share + half).min(1.0)]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Newcombe (1998), "Two-sided confidence intervals for the single proportion", table I.
    #[test]
    fn wilson_matches_published_values() {
        for (count, of, low, high) in [
            (81, 263, 0.2553, 0.3662),
            (15, 148, 0.0624, 0.1605),
            (0, 20, 0.0, 0.1611),
            (1, 29, 0.0061, 0.1718),
        ] {
            let f = Fraction::wilson(count, of);
            assert!((f.low - low).abs() < 5e-5, "{f:?}");
            assert!((f.high - high).abs() < 5e-5, "{f:?}");
        }
    }

    /// The short form of `cargo run --release --example coverage`.
    #[test]
    fn randomised_intervals_hold_the_share_in_95_per_cent_of_repetitions() {
        use crate::design::{Design, Method, Sampling};
        use crate::distribution::Distribution;
        const POINTS: u64 = 512;
        const REPETITIONS: u64 = 400;
        let unit = Distribution::Uniform { min: 0.0, max: 1.0 };
        let (mut held, mut narrower) = (0, 0);
        for seed in 0..REPETITIONS {
            let settings = Sampling {
                method: Method::Sobol,
                points: POINTS,
                seed,
                replicates: 16,
            };
            let design = Design::new(&settings, vec![unit; 3]).unwrap();
            let mut counts = [0; 16];
            for index in 0..POINTS {
                let u = design.point(index);
                counts[index as usize % 16] += u64::from(u[0] + u[1] < 1.0 && u[2] < 0.4);
            }
            let [low, high] = randomised_share(&counts, POINTS);
            held += u64::from(low <= 0.2 && 0.2 <= high);
            let wilson = Fraction::wilson(counts.iter().sum::<u64>() as usize, POINTS as usize);
            narrower += u64::from(high - low < wilson.high - wilson.low);
        }
        let coverage = held as f64 / REPETITIONS as f64;
        assert!((coverage - 0.95).abs() <= 0.03, "{coverage}");
        assert!(narrower > REPETITIONS * 9 / 10, "{narrower}");
    }

    #[test]
    fn rare_points_and_single_designs_have_wilsons_interval() {
        for (counts, points) in [(vec![0; 16], 160), (vec![10; 16], 160), (vec![30], 100)] {
            let total = counts.iter().sum::<u64>() as usize;
            let wilson = Fraction::wilson(total, points as usize);
            assert_eq!(randomised_share(&counts, points), [wilson.low, wilson.high]);
        }
    }

    #[track_caller]
    fn assert_close(found: [f64; 2], expected: [f64; 2]) {
        let close = |k: usize| (found[k] - expected[k]).abs() < 1e-9;
        assert!(close(0) && close(1), "{found:?}, expected {expected:?}");
    }

    /// Student's factor for three degrees of freedom is 3.182446305.
    #[test]
    fn the_interval_of_four_randomisations_is_students() {
        let even = randomised_share(&[20, 22, 24, 26], 200);
        assert_close(even, [0.3778295897, 0.5421704103]);
        // Two more points: the first two randomisations have 51.
        let uneven = randomised_share(&[20, 22, 24, 26], 202);
        assert_close(uneven, [0.3665912383, 0.5442998508]);
    }

    #[test]
    fn as_many_hits_as_randomisations_are_enough() {
        assert_close(randomised_share(&[1; 4], 40), [0.1; 2]);
        assert_close(randomised_share(&[9; 4], 40), [0.9; 2]);
        for (counts, points) in [([1, 1, 1, 0], 40), ([9, 9, 9, 10], 40)] {
            assert_eq!(
                randomised_share(&counts, points),
                wilson(counts.iter().sum(), points)
            );
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
        assert_eq!(
            Fraction::wilson(0, 0),
            Fraction {
                count: 0,
                of: 0,
                low: 0.0,
                high: 1.0
            }
        );
    }
}
