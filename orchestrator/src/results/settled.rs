//! What a longer and finer run of the best point showed.

use indexmap::IndexMap;
use rig_signals::motion::Motion;
use serde::{Deserialize, Serialize};

/// The largest number of points that are run once more.
pub const MOST_EXTRA_RUNS: usize = 10;

/// How the best point was run once more, and what that showed.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Settled {
    /// The point.
    pub point: u64,
    /// The communication step of this run, s; none where there was none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub step: Option<f64>,
    /// Its end, s: later than that of the study, where the FMU allowed it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub until: Option<f64>,
    /// The motion of each criterion's value, where it is known.
    pub criteria: IndexMap<String, Moved>,
}

/// The motion of a criterion's value at the end of the run, in the criterion's unit.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Moved {
    /// From the least to the greatest value in the last period of its signal.
    pub swing: f64,
    /// How far the value goes on in a time as long as the run.
    pub drift: f64,
}

impl Moved {
    /// That of a motion.
    pub fn new(motion: Motion) -> Self {
        // Beyond the largest number there is none for the summary.
        let [swing, drift] = [motion.swing, motion.drift].map(|moved| moved.clamp(-f64::MAX, f64::MAX));
        Self { swing, drift }
    }
}

impl Settled {
    /// A sentence on the run.
    pub fn remark(&self) -> Option<String> {
        let step = match self.step? {
            short if short < 0.001 => format!("{short:.2e}"),
            step => format!("{step:.4}"),
        };
        Some(format!(
            "We re-ran point {} longer and finer (steps of {step} s, to {} s) to see whether its values had settled.",
            self.point,
            (1e6 * self.until?).round() / 1e6
        ))
    }
}
