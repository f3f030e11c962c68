//! Places at which runs failed: nothing is known of them, so neither a search nor a sample can tell what lies there.

use result_document::format::{shown, significant};
use serde::Serialize;

use super::problem::Problem;

/// The places that were asked for, and those of them at which a run failed.
#[derive(Clone, Debug, Default)]
pub struct Failures {
    /// Places that were asked for.
    pub asked: u64,
    /// Those at which a run failed.
    pub failed: u64,
    /// The least and the largest place of each free parameter among those that failed.
    reach: Vec<[f64; 2]>,
    /// Why the last one failed.
    message: String,
}

impl Failures {
    /// Takes note of a place, and of why its run failed, if it did.
    pub fn note(&mut self, problem: &Problem, places: &[f64], failure: Option<&str>) {
        self.asked += 1;
        let Some(message) = failure else { return };
        self.failed += 1;
        message.clone_into(&mut self.message);
        self.reach.resize(problem.free.len(), [f64::INFINITY, f64::NEG_INFINITY]);
        for ([low, high], place) in self.reach.iter_mut().zip(places) {
            *low = low.min(*place);
            *high = high.max(*place);
        }
    }

    /// The smallest box that holds all places at which a run failed.
    pub fn ranges(&self, problem: &Problem) -> Vec<Range> {
        Range::all(problem, &self.reach)
    }
}

/// The region that a search avoids because runs failed there.
#[derive(Serialize)]
pub struct Excluded {
    /// Places that were asked for.
    pub asked: u64,
    /// Those at which a run failed.
    pub failed: u64,
    /// Starts, which are spread evenly between the bounds, and those at which a run failed.
    pub starts: [usize; 2],
    /// The smallest box that holds all places at which a run failed. Runs that end may lie in it, too.
    pub within: Vec<Range>,
    /// Why the last run failed.
    pub message: String,
}

/// A range of a free parameter.
#[derive(Clone, Debug, Serialize)]
pub struct Range {
    /// The parameter.
    pub name: String,
    /// The unit of its numbers.
    pub unit: Option<String>,
    /// The ends.
    pub range: [f64; 2],
}

impl Excluded {
    /// What a search has excluded; `None` where no run failed. `screened` says of each start whether its runs ended.
    pub fn new(problem: &Problem, failures: &Failures, screened: impl Iterator<Item = bool> + Clone) -> Option<Self> {
        (failures.failed > 0).then(|| Self {
            asked: failures.asked,
            failed: failures.failed,
            starts: [screened.clone().count(), screened.filter(|ended| !ended).count()],
            within: failures.ranges(problem),
            message: failures.message.clone(),
        })
    }
}

impl Range {
    /// The sides of a box, given the places of its ends.
    pub fn all(problem: &Problem, ends: &[[f64; 2]]) -> Vec<Self> {
        problem
            .free
            .iter()
            .zip(ends)
            .map(|(free, ends)| Self {
                name: free.name.clone(),
                unit: free.unit.clone(),
                range: ends.map(|place| free.value(place)),
            })
            .collect()
    }
}

/// A box in words.
pub fn words(within: &[Range]) -> String {
    within
        .iter()
        .map(|side| {
            let [low, high] = side.range.map(|end| significant(end, 4));
            format!("{} {low} .. {high} {}", side.name, shown(&side.unit)).trim_end().to_owned()
        })
        .collect::<Vec<_>>()
        .join(", ")
}

/// Failed runs around an optimum: it may lie beyond them.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Edge {
    /// Whether the last way down led to runs that failed: the sum of squares may be less beyond.
    pub blocked: bool,
    /// Places at the ends of the 95 % region that were asked for.
    pub asked: usize,
    /// Those at which a run failed: the region is cut there.
    pub failed: usize,
}

impl Edge {
    /// Whether the optimum and its interval stand as they are.
    pub fn is_clear(&self) -> bool {
        !self.blocked && self.failed == 0
    }
}
