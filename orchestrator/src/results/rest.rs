//! Whether the values that were judged had come to rest, as extra runs of some points showed.

use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

/// How the extra runs were made, and what they showed.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Rest {
    /// The points chosen for it.
    pub points: Vec<u64>,
    /// Those of them that were simulated once more as far as their end, or further.
    pub observed: Vec<u64>,
    /// The communication step of these runs, s.
    pub step: f64,
    /// Their end, s: later than that of the study, where the FMU allowed it.
    pub until: f64,
    /// Why some points were not observed, where that is so.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// The largest motion of each criterion's value.
    pub criteria: IndexMap<String, Moved>,
}

/// The largest motion of a criterion's value over the extra runs, in the criterion's unit.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Moved {
    /// From the least to the greatest value in the last period of its signal.
    pub swing: f64,
    /// The point with this swing.
    pub swing_at: Option<u64>,
    /// How far the value goes on in a time as long as the run.
    pub drift: f64,
    /// The point with this drift.
    pub drift_at: Option<u64>,
}

impl Moved {
    /// Counts the motion at a point.
    pub fn add(&mut self, point: u64, swing: f64, drift: f64) {
        if swing > self.swing {
            (self.swing, self.swing_at) = (swing, Some(point));
        }
        if drift.abs() > self.drift.abs() {
            (self.drift, self.drift_at) = (drift, Some(point));
        }
    }
}

impl Rest {
    /// A sentence on what was looked at.
    pub fn remark(&self) -> Option<String> {
        let list = |points: &[u64]| {
            let texts: Vec<String> = points.iter().map(u64::to_string).collect();
            texts.join(", ")
        };
        let step = match self.step {
            short if short < 0.001 => format!("{short:.2e}"),
            step => format!("{step:.4}"),
        };
        (!self.observed.is_empty()).then(|| {
            format!(
                "Whether values still move at the end of the run was looked at on extra runs of the points {}, with \
                 steps of {step} s up to {} s.",
                list(&self.observed),
                (1e6 * self.until).round() / 1e6
            )
        })
    }
}
