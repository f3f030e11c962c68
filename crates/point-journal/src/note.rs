//! Lines of the journal about many points: how they were computed.

use serde::{Deserialize, Serialize};

use fmu_points::{Conduct, failure::Failure};

/// A point's values, or why there are none.
pub type PointOutcome = Result<Vec<f64>, Failure>;

/// A line about many points.
#[derive(Serialize, Deserialize)]
pub enum Note {
    /// How the points so far were computed.
    Conduct(Conduct),
    /// How the points of a part were computed that was joined, in place of what was noted of that part before.
    Part(String, Conduct),
}

/// Begins a line that says which points a set has.
pub const SET: &str = "set";
/// Begins the same line once more, for the case that the first one is damaged.
pub const SAME_SET: &str = "same-set";
/// Stands behind the index of a point that has results.
pub const PASSED: &str = "ok";
