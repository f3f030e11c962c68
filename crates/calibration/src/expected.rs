//! By how much a right model misses measured values whose noise is known, or an estimate.

use statrs::{
    distribution::{ChiSquared, ContinuousCDF, FisherSnedecor},
    statistics::Distribution,
};

use super::problem::{Estimate, Problem};

/// The distribution of a right model's sum of squares.
///
/// Rows that share their noise count for fewer. Each curve's part of the sum, over its degrees of freedom, has Snedecor's
/// distribution; so has the whole, nearly, with the degrees of freedom that give its variance (Welch & Satterthwaite) and
/// scaled to its mean.
pub struct Expected {
    /// The sum's degrees of freedom.
    pub freedom: f64,
    /// Those of the noise that it is compared with; infinite where that is known.
    of_noise: f64,
    /// The mean of the sum.
    mean: f64,
}

impl Expected {
    /// That of so many squares, with so many unknowns.
    pub fn new(problem: &Problem, squares: usize, unknowns: usize) -> Self {
        let count = |noise: &Estimate| (problem.cases.len() * noise.quantities.len()) as f64;
        let independent = |noise: &Estimate| count(noise) / noise.rows;
        let estimates = || problem.estimates.iter();
        let lost = estimates().map(|noise| count(noise) - independent(noise));
        let freedom = (squares as f64 - lost.sum::<f64>() - unknowns as f64).round();
        let of_noise = estimates().map(|noise| independent(noise).powi(2) / noise.freedom);
        let more = estimates().map(|noise| 2.0 * independent(noise) / (noise.freedom - 2.0).max(1.0));
        Self { freedom, of_noise: freedom.powi(2) / of_noise.sum::<f64>(), mean: freedom + more.sum::<f64>() }
    }

    /// The probability that a right model misses by a larger sum; none without degrees of freedom.
    pub fn chance(&self, sum: f64) -> Option<f64> {
        const POSITIVE: &str = "degrees of freedom are positive numbers";
        let Self { freedom, of_noise, mean } = *self;
        if freedom <= 0.0 {
            return None;
        }
        if of_noise.is_infinite() {
            return Some(ChiSquared::new(freedom).expect(POSITIVE).sf(sum));
        }
        let law = FisherSnedecor::new(freedom, of_noise).expect(POSITIVE);
        let of_law = law.mean().unwrap_or(1.0);
        Some(law.sf(sum / mean * of_law))
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{measured, problem};
    use super::*;
    use rand::rngs::StdRng;
    use rand::{RngExt, SeedableRng};
    use rand_distr::StandardNormal;

    /// A right model with estimated noise has Snedecor's distribution of its sum of squares, and of three such curves nearly so. Rows
    /// that share their noise count for fewer.
    #[test]
    fn a_noise_that_is_an_estimate_doubts_a_right_model_as_seldom() {
        let estimate = |from, freedom, rows| Estimate { quantities: from..from + 100, freedom, correlation: 0.0, rows };
        let mut problem = problem(Vec::new(), vec![measured(&[0.0; 300], 1.0)]);
        // SciPy: `f(100, 60).sf(1.2)`, `chi2(100).sf(120)`.
        let known = Expected::new(&problem, 100, 0);
        assert!((known.chance(120.0).unwrap() - 0.084_407).abs() < 1e-5);
        problem.estimates = vec![estimate(0, 60.0, 1.0)];
        let estimated = Expected::new(&problem, 100, 0);
        assert!((estimated.chance(120.0).unwrap() - 0.223_257).abs() < 1e-5);
        // Sums of three curves, drawn from their true distributions: 5 % of them must have a chance below 5 %.
        problem.estimates = (0..3).map(|k| estimate(100 * k, 60.0, 2.0)).collect();
        let three = Expected::new(&problem, 300, 2);
        assert_eq!(three.freedom, 148.0);
        let mut random = StdRng::seed_from_u64(1);
        let mut square = |count: usize| -> f64 {
            let normal = (0..count).map(|_| random.sample::<f64, _>(StandardNormal).powi(2));
            normal.sum()
        };
        let mut sum = || (0..3).map(|_| square(50) / square(60) * 60.0).sum::<f64>();
        let doubted = (0..2000).filter(|_| three.chance(sum()).unwrap() < 0.05).count();
        assert!((70..=135).contains(&doubted), "{doubted}");
        assert_eq!(Expected::new(&problem, 2, 2).chance(1.0), None);
    }
}
