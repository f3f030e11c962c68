//! How an FMU is simulated for a check.

use std::time::Duration;

use fmu_import::Value;

/// How the short simulations of a check are run.
#[derive(Debug)]
pub struct Conditions {
    /// How long each may take.
    pub patience: Duration,
    /// The communication step, s; as the FMU suggests otherwise.
    pub step: Option<f64>,
    /// Start values, by value reference.
    pub set: Vec<(u32, Value)>,
}

impl Default for Conditions {
    /// A minute each, as the FMU suggests.
    fn default() -> Self {
        Self { patience: Duration::from_secs(60), step: None, set: Vec::new() }
    }
}
