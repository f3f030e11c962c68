//! The points that are run once more, longer and finer, to see whether their results had settled: the best one, and those at
//! which it matters most; and what these runs showed.

use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

use crate::judge::Judge;
use point_journal::Outcome;

/// The largest number of points that are run once more.
pub const MOST_EXTRA_RUNS: usize = 10;
/// One of so many points is run once more at the most, but at least one.
const OF: u64 = 10;

/// Which points were run once more, how, and what that showed.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Settled {
    /// The points chosen for it.
    pub points: Vec<u64>,
    /// Those of them that were simulated once more as far as their end, or further.
    pub observed: Vec<u64>,
    /// The communication step of these runs, s.
    pub step: f64,
    /// Their end, s: later than that of the study, where the FMU allowed it.
    pub until: f64,
    /// Why some points were not observed, where that is so.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// The largest motion of each criterion's value.
    pub criteria: IndexMap<String, Moved>,
}

/// The largest motion of a criterion's value over these runs, in the criterion's unit.
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
        // Beyond the largest number there is none for the summary.
        let [swing, drift] = [swing, drift].map(|moved| moved.clamp(-f64::MAX, f64::MAX));
        if swing > self.swing {
            (self.swing, self.swing_at) = (swing, Some(point));
        }
        if drift.abs() > self.drift.abs() {
            (self.drift, self.drift_at) = (drift, Some(point));
        }
    }
}

impl Settled {
    /// A sentence on which points were run once more.
    pub fn remark(&self) -> Option<String> {
        let points: Vec<String> = self.observed.iter().map(u64::to_string).collect();
        let step = match self.step {
            short if short < 0.001 => format!("{short:.2e}"),
            step => format!("{step:.4}"),
        };
        (!points.is_empty()).then(|| {
            format!(
                "We re-ran {} {} longer and finer (steps of {step} s, to {} s) to see whether their results had settled.",
                if points.len() == 1 { "point" } else { "points" },
                points.join(", "),
                (1e6 * self.until).round() / 1e6
            )
        })
    }
}

/// The points nearest the limits, of those that come one by one.
#[derive(Debug)]
pub struct Edges<'a> {
    judge: &'a Judge,
    points: u64,
    /// Accepted and rejected points with their distances from the limits, the least first.
    near: [Vec<(f64, u64)>; 2],
}

impl<'a> Edges<'a> {
    /// No points yet.
    pub fn new(judge: &'a Judge) -> Self {
        Self { judge, points: 0, near: [Vec::new(), Vec::new()] }
    }

    /// Looks at a point.
    pub fn add(&mut self, label: u64, outcome: &Outcome) {
        self.points += 1;
        let Ok(values) = outcome else { return };
        let largest = self
            .judge
            .criteria
            .iter()
            .zip(values)
            .map(|(criterion, &value)| criterion.deviation(value))
            .fold(0.0, f64::max);
        let accepted = self.judge.verdict(Some(values)).verified();
        let near = &mut self.near[usize::from(!accepted)];
        let distance = (largest - 1.0).abs();
        // Of equal ones the first one stays.
        let place = near.partition_point(|(other, _)| *other <= distance);
        if place < MOST_EXTRA_RUNS {
            near.insert(place, (distance, label));
            near.truncate(MOST_EXTRA_RUNS);
        }
    }

    /// The best point, the accepted ones nearest the limits, and, where these are few, the rejected ones nearest the
    /// limits: ten, or a tenth of all points.
    pub fn chosen(&self, best: Option<u64>) -> Vec<u64> {
        let most = (self.points / OF).clamp(1, MOST_EXTRA_RUNS as u64) as usize;
        let others = self.near.iter().flatten().map(|(_, label)| *label).filter(|label| Some(*label) != best);
        best.into_iter().chain(others).take(most).collect()
    }
}
