//! Correlated inputs: independent normal scores are mixed by the Cholesky factor of the correlation matrix
//! (a Gaussian copula; Nataf 1962). For normal inputs the coefficients are
//! the usual ones of Pearson; for others they are those of the normal scores.

use nalgebra::DMatrix;

use crate::distribution::{BELOW_ONE, Distribution, normal_quantile};

/// A matrix that mixes independent scores.
#[derive(Clone, Debug)]
pub struct Correlation {
    /// The lower triangle of the Cholesky factor over all inputs, row after row.
    rows: Vec<Vec<f64>>,
}

impl Correlation {
    /// Correlations of pairs of `inputs` inputs; all others are uncorrelated.
    ///
    /// # Errors
    /// When no random numbers have these correlations.
    pub fn new(inputs: usize, pairs: &[(usize, usize, f64)]) -> Result<Self, String> {
        let mut matrix = DMatrix::identity(inputs, inputs);
        for &(a, b, coefficient) in pairs {
            matrix[(a, b)] = coefficient;
            matrix[(b, a)] = coefficient;
        }
        let factor = matrix
            .cholesky()
            .ok_or_else(|| {
                "no random numbers have these correlations: their matrix is not positive definite; \
             bring the coefficients nearer to 0"
                    .to_owned()
            })?
            .l();
        Ok(Self { rows: (0..inputs).map(|i| (0..=i).map(|j| factor[(i, j)]).collect()).collect() })
    }

    /// The correlation coefficient of the normal scores of two inputs.
    pub fn coefficient(&self, a: usize, b: usize) -> f64 {
        self.rows[a].iter().zip(&self.rows[b]).map(|(x, y)| x * y).sum()
    }

    /// The logarithm of what the correlations change at the density of independent inputs, at these values: that of the
    /// Gaussian copula.
    pub fn ln_density(&self, values: &[f64], inputs: &[Distribution]) -> f64 {
        let score = |(input, &value): (&Distribution, &f64)| {
            let below = input.below(value);
            normal_quantile(below.clamp(f64::MIN_POSITIVE, BELOW_ONE))
        };
        let mut free: Vec<f64> = Vec::with_capacity(values.len());
        let mut sum = 0.0;
        for (row, score) in self.rows.iter().zip(inputs.iter().zip(values).map(score)) {
            let diagonal = row[free.len()];
            let known = mixed(row, &free);
            let rest = (score - known) / diagonal;
            sum += 0.5 * (score * score - rest * rest) - diagonal.ln();
            free.push(rest);
        }
        sum
    }

    /// The inputs' values from independent standard normal scores, one for each input.
    pub fn at_scores(&self, scores: &[f64], inputs: &[Distribution]) -> Vec<f64> {
        self.rows.iter().zip(inputs).map(|(row, input)| input.at_score(mixed(row, scores))).collect()
    }

    /// The inputs' values from independent numbers in (0, 1), one for each input.
    pub(super) fn values(&self, uniform: &[f64], inputs: &[Distribution]) -> Vec<f64> {
        let scores: Vec<f64> = uniform.iter().map(|&u| normal_quantile(u)).collect();
        let value = |(i, (row, input)): (usize, (&Vec<f64>, &Distribution))| {
            // A row without others keeps the number as it is.
            if row[..i].iter().all(|&weight| weight == 0.0) {
                return input.quantile(uniform[i]);
            }
            input.at_score(mixed(row, &scores))
        };
        self.rows.iter().zip(inputs).enumerate().map(value).collect()
    }
}

/// The weighted sum of as many scores as there are; a row's own weight is left out where its score is missing.
fn mixed(row: &[f64], scores: &[f64]) -> f64 {
    row.iter().zip(scores).map(|(weight, score)| weight * score).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contradictions_are_refused() {
        let pairs = [(0, 1, 0.9), (1, 2, 0.9), (0, 2, -0.9)];
        for (inputs, pairs) in [(3, &pairs[..]), (2, &[(0, 1, 1.0)])] {
            let error = Correlation::new(inputs, pairs).unwrap_err();
            assert!(error.starts_with("no random numbers have these correlations"), "{error}");
        }
    }

    #[test]
    fn coefficients_are_the_given_ones() {
        let mixed = Correlation::new(3, &[(0, 1, 0.6), (1, 2, -0.3)]).unwrap();
        let expected = [[1.0, 0.6, 0.0], [0.6, 1.0, -0.3], [0.0, -0.3, 1.0]];
        for (a, row) in expected.iter().enumerate() {
            for (b, coefficient) in row.iter().enumerate() {
                assert!((mixed.coefficient(a, b) - coefficient).abs() < 1e-12);
            }
        }
    }

    /// The density of two normal numbers with the correlation 0.6, over that of independent ones.
    #[test]
    fn correlated_inputs_have_the_density_of_the_copula() {
        let normal = Distribution::Normal { mean: 1.0, deviation: 2.0 };
        let mixed = Correlation::new(2, &[(0, 1, 0.6)]).unwrap();
        let density = mixed.ln_density(&[3.0, 0.0], &[normal.clone(), normal.clone()]);
        let (x, y, r) = (1.0, -0.5, 0.6_f64);
        let square = (x * x - 2.0 * r * x * y + y * y) / (1.0 - r * r);
        let expected = -0.5 * (square - x * x - y * y) - 0.5 * (1.0 - r * r).ln();
        assert!((density - expected).abs() < 1e-9, "{density} {expected}");
    }

    /// At the end of its range a quantity counts as far out as numbers below 1 tell: its score is 8.209536.
    #[test]
    fn the_density_at_an_end_of_the_range_is_finite() {
        let unit = Distribution::Uniform { min: 0.0, max: 1.0 };
        let mixed = Correlation::new(2, &[(0, 1, 0.6)]).unwrap();
        let density = mixed.ln_density(&[1.0, 0.5], &[unit.clone(), unit]);
        let expected = -0.5 * 8.209_536_f64.powi(2) * 0.36 / 0.64 - 0.5 * 0.64_f64.ln();
        assert!((density - expected).abs() < 1e-5, "{density} {expected}");
    }

    #[test]
    fn scores_are_mixed_as_asked_for() {
        let normal = Distribution::Normal { mean: 0.0, deviation: 1.0 };
        let mixed = Correlation::new(2, &[(0, 1, 0.6)]).unwrap();
        let [a, b] = [0.3, 0.9].map(normal_quantile);
        let values = mixed.values(&[0.3, 0.9], &[normal.clone(), normal.clone()]);
        assert!((values[0] - a).abs() < 1e-12);
        assert!((values[1] - (0.6 * a + 0.8 * b)).abs() < 1e-12);
        assert_eq!(mixed.at_scores(&[a, b], &[normal.clone(), normal.clone()]), values);
    }
}
