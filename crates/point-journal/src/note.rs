//! Lines of the journal about many points: how they were computed, and which count no more.

use serde::{Deserialize, Serialize};

use fmu_points::failure::Failure;
use fmu_points::{Conduct, Separation};

/// A point's values, or why there are none.
pub type Outcome = Result<Vec<f64>, Failure>;

/// A line about many points.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Note {
    /// How points were computed since the last such note.
    Conduct(Conduct),
    /// How the points of a part were computed that was joined, in place of what was noted of that part before.
    Part(String, Conduct),
    /// The points so far that were computed in such processes, or in less strictly separated ones, do not count.
    Void(Separation),
    /// The same once more, for the case that its line is damaged.
    StillVoid(Separation),
    /// The point of this index failed while others ran: it may come again.
    Crowded(u64),
    /// Such points do not come again: how many were repeated alone, and how many of them passed.
    Settled {
        /// All of them.
        repeated: u64,
        /// Those with results.
        passed: u64,
    },
}

/// Begins a line that says which points a set has.
pub(crate) const SET: &str = "set";
/// Begins the same line once more, for the case that the first one is damaged.
pub(crate) const SAME_SET: &str = "same-set";

/// How a line names the process of a point that has results.
pub(crate) fn word(separation: Separation) -> &'static str {
    match separation {
        Separation::Apart => "apart",
        Separation::New => "ok",
        Separation::Forked => "forked",
        Separation::Used => "used",
    }
}

/// The process that a line names.
pub(crate) fn separation(word: &str) -> Option<Separation> {
    use Separation::{Apart, Forked, New, Used};
    let mut all = [Apart, New, Forked, Used].into_iter();
    all.find(|separation| self::word(*separation) == word)
}
