//! The evidence of a model, by a sample of the posterior.

use sampling::distribution::ln_sum;
use serde::{Deserialize, Serialize};

use super::{super::problem::Problem, Sample};

/// Fewer independent particles say too little of a 95 % interval: with 100 it holds 91 to 99 %.
pub(super) const ENOUGH: f64 = 100.0;

/// Standard errors of the evidence's logarithm to each side for 95 %: Student's factor with seven degrees of freedom. The
/// draws are many, but few of them have most of the weight, so their scatter is known about as well as that of so few numbers.
const REACH: f64 = 2.365;

/// The evidence of a model with its prior: the mean likelihood of the measured values over the prior.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Evidence {
    /// Its logarithm; the evidence is in the inverse units of the measured values.
    pub log: f64,
    /// The standard error of the logarithm.
    pub error: f64,
    /// The interval that holds the logarithm with 95 % probability.
    pub interval: [f64; 2],
    /// Whether the sample can be relied on.
    pub trusted: bool,
    /// A digest of the measured values: evidences of other data cannot be compared.
    pub data: String,
    /// How much more probable these data are here than in another result, where that was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub against: Option<Ratio>,
}

/// The ratio of two evidences: Bayes' factor.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Ratio {
    /// Its logarithm.
    pub log: f64,
    /// The interval that holds the logarithm with 95 % probability.
    pub interval: [f64; 2],
}

impl Evidence {
    /// That of a problem, by a sample that can be relied on or not.
    pub fn new(problem: &Problem, sample: &Sample, trusted: bool) -> Self {
        let count = sample.weights.len() as f64;
        let log = ln_sum(&sample.weights) - count.ln();
        let error = (effective_draws(&sample.weights).recip() - count.recip()).max(0.0).sqrt();
        Self {
            log,
            error,
            interval: around(log, error),
            // With fewer effective draws their scatter is not known well.
            trusted: trusted && effective_draws(&sample.weights) >= ENOUGH,
            data: problem.digest(),
            against: None,
        }
    }

    /// Whether it is that of the same measured values.
    ///
    /// # Errors
    /// Says that they are others.
    pub fn is_of(&self, problem: &Problem) -> Result<(), String> {
        if self.data == problem.digest() {
            Ok(())
        } else {
            Err(
                "its evidence is that of other measured values, or of the same in another order or unit, and cannot be compared"
                    .to_owned(),
            )
        }
    }

    /// Notes the ratio to the evidence of another result on the same data.
    ///
    /// # Errors
    /// When one of the samples cannot be relied on.
    pub fn compare(&mut self, other: &Self) -> Result<(), String> {
        if !(self.trusted && other.trusted) {
            let which = if self.trusted { "its" } else { "this" };
            return Err(format!("{which} sample of the posterior is not to be relied on; draw more"));
        }
        let log = self.log - other.log;
        self.against = Some(Ratio { log, interval: around(log, self.error.hypot(other.error)) });
        Ok(())
    }
}

/// As many equal weights would tell as much as these, given their logarithms.
pub(super) fn effective_draws(logs: &[f64]) -> f64 {
    let all = ln_sum(logs);
    logs.iter().map(|log| (2.0 * (log - all)).exp()).sum::<f64>().recip()
}

/// The interval that holds a number of this standard error with 95 % probability.
fn around(centre: f64, error: f64) -> [f64; 2] {
    [-1.0, 1.0].map(|side| centre + side * REACH * error)
}
