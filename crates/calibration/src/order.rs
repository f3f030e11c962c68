//! Whether residuals follow each other along a curve.

use serde::Serialize;
use statrs::distribution::{ContinuousCDF, Normal};

use super::problem::Estimate;

/// The order of the residuals along a curve.
#[derive(Serialize)]
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
    /// The order of residuals, which stand in the order of the curve; none where they are too few to tell.
    ///
    /// The correlation is Durbin & Watson's statistic in another form (1950, Testing for serial correlation in least squares
    /// regression I, Biometrika 37, 409-428), with the variance of Ljung & Box (1978, On a measure of lack of fit in time series
    /// models, Biometrika 65, 297-303), less what a correlation of the noise takes off it (Bartlett 1946, On the theoretical
    /// specification and sampling properties of autocorrelated time-series, J. R. Stat. Soc. Suppl. 8, 27-41, for noise of which
    /// each row holds a part of the one before). That of the noise is known as from as many rows as its estimate has degrees of freedom.
    pub fn of(name: &str, residuals: &[f64], noise: Option<&Estimate>) -> Option<Self> {
        const FEWEST: usize = 10;
        if residuals.len() < FEWEST {
            return None;
        }
        let n = residuals.len() as f64;
        let squares: f64 = residuals.iter().map(|r| r * r).sum();
        let products = residuals.windows(2).map(|pair| pair[0] * pair[1]);
        let correlation = products.sum::<f64>() / squares;
        let of_noise = noise.map_or(0.0, |noise| noise.correlation.clamp(0.0, 1.0));
        // Where no recording told a correlation, none is assumed, and its estimate has no error.
        let known = noise.filter(|noise| noise.correlation != 0.0).map_or(0.0, |noise| noise.freedom.recip());
        let variance = (1.0 - of_noise * of_noise) * (n - 1.0) / (n * (n + 2.0));
        let deviation = (variance + known).sqrt();
        correlation.is_finite().then(|| Self {
            name: name.to_owned(),
            correlation,
            of_noise,
            probability: Normal::standard().sf((correlation - of_noise) / deviation),
        })
    }

    /// Whether it is more than chance at this level, and enough to matter: errors with a correlation of 0.1 that are taken as
    /// independent make intervals a tenth too narrow.
    pub fn is_doubtful(&self, level: f64) -> bool {
        const MATTERS: f64 = 0.1;
        self.correlation - self.of_noise > MATTERS && self.probability < level
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::rngs::StdRng;
    use rand::{RngExt, SeedableRng};
    use rand_distr::StandardNormal;

    /// How many of 200 records of so many residuals are doubted, of which each holds this part of the one before, where that of
    /// the noise is `known`.
    fn doubted(count: usize, memory: f64, known: f64) -> usize {
        let noise = Estimate { quantities: 0..count, freedom: f64::INFINITY, correlation: known, rows: 1.0 };
        let mut random = StdRng::seed_from_u64(23);
        let records = (0..200).filter(|_| {
            let mut last: f64 = random.sample(StandardNormal);
            let record = (0..count).map(|_| {
                last = memory * last + (1.0 - memory * memory).sqrt() * random.sample::<f64, _>(StandardNormal);
                last
            });
            let record: Vec<f64> = record.collect();
            let mean = record.iter().sum::<f64>() / count as f64;
            let residuals: Vec<f64> = record.iter().map(|value| value - mean).collect();
            Order::of("curve", &residuals, Some(&noise)).unwrap().is_doubtful(0.05 / 3.0)
        });
        records.count()
    }

    /// Autoregressive noise that nobody stated is no good fit; independent noise hardly ever is none.
    #[test]
    fn noise_that_remembers_is_told_where_nobody_stated_it() {
        for (count, least) in [(25, 160), (50, 190), (200, 200)] {
            assert!(doubted(count, 0.8, 0.0) >= least, "{count}: {}", doubted(count, 0.8, 0.0));
            assert!(doubted(count, 0.0, 0.0) <= 10, "{count}: {}", doubted(count, 0.0, 0.0));
        }
    }

    /// Of noise that remembers the correlation scatters less than of independent noise, which would show the first of these in
    /// about 40 records.
    #[test]
    fn more_order_than_that_of_the_noise_is_told() {
        assert!(doubted(200, 0.95, 0.8) >= 130, "{}", doubted(200, 0.95, 0.8));
        assert!(doubted(200, 0.8, 0.8) <= 5, "{}", doubted(200, 0.8, 0.8));
    }
}
