//! The share of the event by independent searches, where no mixture follows its shape.
//!
//! The estimate of one search is a product of many fractions, so its logarithm is nearly normal. The mean of such
//! estimates has Cox's interval (Zhou and Gao 1997, "Confidence intervals for the log-normal mean"), with Student's factor.

use statrs::distribution::{ContinuousCDF, StudentsT};

use super::Weighted;
use super::explore::explore;
use super::random::Random;
use super::runs::Runs;

/// Independent searches.
const SEARCHES: u64 = 8;
/// A search with fewer points at a level loses its way too easily.
const FEWEST: u64 = 200;

/// The share by several searches.
#[derive(Debug)]
pub(super) struct Repeated {
    pub(super) share: f64,
    pub(super) interval: [f64; 2],
    pub(super) error: f64,
    pub(super) sample: Vec<Weighted>,
}

/// Spends the runs that are left on independent searches down so many levels. None where they do not all arrive.
pub(super) fn repeat<E>(
    dimensions: usize,
    levels: usize,
    confidence: f64,
    runs: &mut Runs<'_, E>,
    random: &mut Random,
) -> Result<Option<Repeated>, E> {
    // A search may need one level more than the first one did.
    let size = runs.left() / SEARCHES / (levels as u64 + 2);
    if size < FEWEST {
        return Ok(None);
    }
    let mut shares = Vec::new();
    let mut sample = Vec::new();
    for _ in 0..SEARCHES {
        let points: Vec<Vec<f64>> = (0..size).map(|_| random.normals(dimensions)).collect();
        let results = runs.levels(&points)?;
        let found = explore((points, results), u64::MAX / 2, false, runs, random)?;
        let Some(region) = found.regions.into_iter().next() else {
            return Ok(None);
        };
        shares.push(region.share.ln());
        let each = region.share / region.points.len() as f64 / SEARCHES as f64;
        sample.extend(region.points.into_iter().map(|scores| Weighted {
            scores,
            weight: each,
        }));
    }
    let (share, interval, error) = of_logarithms(&shares, confidence);
    Ok(Some(Repeated {
        share,
        interval,
        error,
        sample,
    }))
}

/// The mean of lognormal numbers with its interval and its relative standard error, from their logarithms.
fn of_logarithms(logarithms: &[f64], confidence: f64) -> (f64, [f64; 2], f64) {
    let count = logarithms.len() as f64;
    let mean = logarithms.iter().sum::<f64>() / count;
    let squares: f64 = logarithms.iter().map(|x| (x - mean).powi(2)).sum();
    let variance = squares / (count - 1.0);
    let centre = mean + 0.5 * variance;
    let error = (variance / count + variance * variance / (2.0 * (count - 1.0))).sqrt();
    let factor = StudentsT::new(0.0, 1.0, count - 1.0).map_or(f64::INFINITY, |student| {
        student.inverse_cdf(0.5 + 0.5 * confidence)
    });
    let ends = [centre - factor * error, centre + factor * error];
    (centre.exp().min(1.0), ends.map(|e| e.exp().min(1.0)), error)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::distribution::normal_quantile;

    /// Logarithms with mean -20 and deviation 0.6: the mean of the numbers is exp(-20 + 0.18). The interval of eight
    /// of them holds it in about 95 % of the cases.
    #[test]
    fn the_interval_of_a_lognormal_mean_holds() {
        let mut random = Random::new(4);
        let exact = (-20.0_f64 + 0.18).exp();
        let mut held = 0;
        for _ in 0..1000 {
            let logarithms: Vec<f64> = (0..8).map(|_| -20.0 + 0.6 * random.normal()).collect();
            let (_, [low, high], _) = of_logarithms(&logarithms, 0.95);
            held += u32::from((low..=high).contains(&exact));
        }
        assert!((935..=985).contains(&held), "{held}");
        // Student's factor of seven degrees of freedom.
        let one = [normal_quantile(0.9) - 20.0, -normal_quantile(0.9) - 20.0];
        let (_, [low, high], error) = of_logarithms(&[&one[..]; 4].concat(), 0.95);
        assert!(((high / low).ln() / error / 2.0 - 2.364_624).abs() < 1e-5);
    }
}
