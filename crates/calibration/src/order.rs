//! Whether residuals follow each other along a curve.

use serde::Serialize;
use statrs::distribution::{ContinuousCDF, Normal};

use super::problem::Estimate;

/// The order of the residuals along a curve.
#[derive(Clone, Debug, Serialize)]
pub struct Order {
    /// The curve.
    pub name: String,
    /// The correlation of each residual with the next one.
    pub correlation: f64,
    /// That of the noise, as far as a recording told it.
    pub of_noise: f64,
    /// The probability of a larger one, if the residuals were that noise.
    pub probability: f64,
}

impl Order {
    /// That of residuals as they follow each other; none where they are too few to tell.
    ///
    /// The correlation is Durbin & Watson's statistic in another form (1950, Testing for serial correlation in least squares
    /// regression I, Biometrika 37, 409-428), with the variance of Ljung & Box (1978, On a measure of lack of fit in time series
    /// models, Biometrika 65, 297-303). That of the noise is known as from as many rows as its estimate has degrees of freedom.
    pub(crate) fn of(name: &str, residuals: &[f64], noise: Option<&Estimate>) -> Option<Self> {
        const FEWEST: usize = 10;
        if residuals.len() < FEWEST {
            return None;
        }
        let n = residuals.len() as f64;
        let squares: f64 = residuals.iter().map(|r| r * r).sum();
        let products = residuals.windows(2).map(|pair| pair[0] * pair[1]);
        let correlation = products.sum::<f64>() / squares;
        let of_noise = noise.map_or(0.0, |noise| noise.correlation.max(0.0));
        // Where no recording told a correlation, none is assumed, and its estimate has no error.
        let known = noise.filter(|noise| noise.correlation != 0.0).map_or(0.0, |noise| noise.freedom.recip());
        let deviation = ((n - 1.0) / (n * (n + 2.0)) + known).sqrt();
        correlation.is_finite().then(|| Self {
            name: name.to_owned(),
            correlation,
            of_noise,
            probability: Normal::standard().sf((correlation - of_noise) / deviation),
        })
    }

    /// Whether it is more than chance at this level, and enough to matter: errors with a correlation of 0.1 that are taken as
    /// independent make intervals a tenth too narrow.
    pub(crate) fn is_doubtful(&self, level: f64) -> bool {
        const MATTERS: f64 = 0.1;
        self.correlation - self.of_noise > MATTERS && self.probability < level
    }
}
