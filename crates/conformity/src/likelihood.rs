//! How probable the measured values are, if a point's model values were the true ones.

use super::genz::cholesky;
use super::joint::blocks;
use super::measured::Measurement;
use super::uncertainty::Law;

/// The joint density of the measured values' errors.
#[derive(Clone, Debug)]
pub struct Likelihood {
    /// The number of a criterion with a measured value, that value and the distribution of its error.
    measured: Vec<(usize, f64, Law)>,
    /// Those with errors that depend on each other, and the Cholesky factor of these errors' correlations.
    blocks: Vec<(Vec<usize>, Vec<Vec<f64>>)>,
}

impl Likelihood {
    /// `None` where nothing is measured, an uncertainty is not known, or one error follows from others. A limit that
    /// stands alone is no measured value.
    pub fn new(measurement: &Measurement) -> Option<Self> {
        let criteria = measurement.criteria().iter().enumerate();
        let criteria = criteria.filter_map(|(number, c)| Some((number, c.value?, c.error)));
        let measured = criteria.map(|(number, value, error)| Some((number, value, error?)));
        let measured: Vec<(usize, f64, Law)> = measured.collect::<Option<_>>()?;
        let place = |number: usize| measured.iter().position(|(of, ..)| *of == number);
        let pairs = measurement.correlations().iter();
        let pairs: Vec<_> =
            pairs.filter_map(|&(a, b, coefficient)| Some((place(a)?, place(b)?, coefficient))).collect();
        let blocks = blocks(measured.len(), &pairs).ok()?.into_iter();
        let factors = blocks.map(|block| Some((block.members, cholesky(&block.correlation)?)));
        let blocks: Vec<_> = factors.collect::<Option<_>>()?;
        (!measured.is_empty()).then_some(Self { measured, blocks })
    }

    /// The logarithm of the likelihood of a point's model values, but for a constant. For normal errors it is minus half
    /// the sum of the squared errors, each in standard uncertainties and freed from what it shares with the others; other
    /// errors have their own density, and a Gaussian copula joins them.
    pub fn ln(&self, values: &[f64]) -> f64 {
        let mut sum = 0.0;
        for (members, factor) in &self.blocks {
            let mut scores: Vec<f64> = Vec::with_capacity(members.len());
            for (&member, row) in members.iter().zip(factor) {
                let (number, value, law) = self.measured[member];
                let known: f64 = row.iter().zip(&scores).map(|(c, score)| c * score).sum();
                let error = values[number] - value;
                let score = law.score(error);
                sum += 2.0 * law.ln_against_normal(error);
                scores.push((score - known) / row[scores.len()]);
            }
            sum -= scores.iter().map(|score| score * score).sum::<f64>();
        }
        match sum.is_nan() {
            true => f64::NEG_INFINITY,
            false => 0.5 * sum,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measured::Measured;
    use crate::uncertainty::Uncertainty;

    fn likelihood(correlation: &[(usize, usize, f64)]) -> Option<Likelihood> {
        let measured =
            |nominal, expanded| Measured::within(nominal, 1.0, Some(Uncertainty::normal(expanded, 2.0).law(0.0)));
        let criteria = vec![measured(10.0, 1.0), measured(-3.0, 4.0)];
        Likelihood::new(&Measurement::new(criteria, correlation).unwrap())
    }

    /// For two correlated errors x and y: -(x^2 - 2 r x y + y^2) / (2 (1 - r^2)).
    #[test]
    fn correlated_errors_have_the_bivariate_density() {
        let (x, y, r) = (0.8, -1.5, 0.6);
        let values = [10.0 + 0.5 * x, -3.0 + 2.0 * y];
        let density = likelihood(&[(0, 1, r)]).unwrap().ln(&values);
        let expected = -(x * x - 2.0 * r * x * y + y * y) / (2.0 * (1.0 - r * r));
        assert!((density - expected).abs() < 1e-12);
        let alone = likelihood(&[]).unwrap().ln(&values);
        assert!((alone + 0.5 * (x * x + y * y)).abs() < 1e-12);
    }

    #[test]
    fn an_error_that_follows_from_another_has_no_density() {
        assert!(likelihood(&[(0, 1, 1.0)]).is_none());
    }
}
