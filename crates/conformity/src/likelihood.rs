//! How probable the measured values are, if a point's model values were the true ones.

use super::genz::cholesky;
use super::measured::Measurement;

/// The joint density of the measured values' errors.
#[derive(Clone, Debug)]
pub struct Likelihood {
    /// The measured value and its standard uncertainty, a criterion each.
    criteria: Vec<[f64; 2]>,
    /// The Cholesky factor of the errors' correlations.
    factor: Vec<Vec<f64>>,
}

impl Likelihood {
    /// `None` where an uncertainty is not known, or where one error follows from others.
    pub fn new(measurement: &Measurement) -> Option<Self> {
        let criteria = measurement.criteria().iter();
        let criteria = criteria.map(|c| Some([c.nominal, c.uncertainty?.standard()]));
        let criteria: Vec<[f64; 2]> = criteria.collect::<Option<_>>()?;
        let mut matrix = vec![vec![0.0; criteria.len()]; criteria.len()];
        (0..criteria.len()).for_each(|k| matrix[k][k] = 1.0);
        for &(a, b, coefficient) in measurement.correlations() {
            (matrix[a][b], matrix[b][a]) = (coefficient, coefficient);
        }
        let factor = cholesky(&matrix)?;
        (!criteria.is_empty()).then_some(Self { criteria, factor })
    }

    /// The logarithm of the likelihood of a point's model values, but for a constant: minus half the sum of the
    /// squared errors, each in standard uncertainties and freed from what it shares with the others.
    pub fn ln(&self, values: &[f64]) -> f64 {
        let mut scores: Vec<f64> = Vec::with_capacity(self.criteria.len());
        for ((&[nominal, standard], value), row) in
            self.criteria.iter().zip(values).zip(&self.factor)
        {
            let known: f64 = row.iter().zip(&scores).map(|(c, score)| c * score).sum();
            scores.push(((value - nominal) / standard - known) / row[scores.len()]);
        }
        -0.5 * scores.iter().map(|score| score * score).sum::<f64>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measured::{Measured, Uncertainty};

    fn likelihood(correlation: &[(usize, usize, f64)]) -> Option<Likelihood> {
        let measured = |nominal, expanded| Measured {
            nominal,
            tolerance: 1.0,
            uncertainty: Some(Uncertainty {
                expanded,
                coverage: 2.0,
            }),
        };
        let criteria = vec![measured(10.0, 1.0), measured(-3.0, 4.0)];
        Likelihood::new(&Measurement::new(criteria, correlation).unwrap())
    }

    /// For two correlated errors x and y: -(x^2 - 2 r x y + y^2) / (2 (1 - r^2)).
    #[test]
    fn correlated_errors_have_the_bivariate_density() {
        let (x, y, r) = (0.8, -1.5, 0.6);
        let values = [10.0 + 0.5 * x, -3.0 + 2.0 * y];
        let found = likelihood(&[(0, 1, r)]).unwrap().ln(&values);
        let expected = -(x * x - 2.0 * r * x * y + y * y) / (2.0 * (1.0 - r * r));
        assert!((found - expected).abs() < 1e-12);
        let alone = likelihood(&[]).unwrap().ln(&values);
        assert!((alone + 0.5 * (x * x + y * y)).abs() < 1e-12);
    }

    #[test]
    fn an_error_that_follows_from_another_has_no_density() {
        assert!(likelihood(&[(0, 1, 1.0)]).is_none());
    }
}
