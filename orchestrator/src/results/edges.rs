//! The points that are simulated once more to see whether their values had come to rest: the best one, and those at
//! which it matters most.

use super::Outcome;
use crate::judge::Judge;

/// The largest number of points that are simulated once more.
pub const MOST_EXTRA_RUNS: usize = 10;
/// One of so many points is simulated once more at the most, but at least one.
const OF: u64 = 10;

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
        Self {
            judge,
            points: 0,
            near: [Vec::new(), Vec::new()],
        }
    }

    /// Looks at a point.
    pub fn add(&mut self, label: u64, outcome: &Outcome) {
        self.points += 1;
        let Ok(values) = outcome else { return };
        let pairs = self.judge.criteria.iter().zip(values);
        let largest = pairs
            .map(|(criterion, value)| (value - criterion.nominal).abs() / criterion.tolerance)
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
        let near = self.near.iter().flatten().map(|(_, label)| *label);
        let others = near.filter(|label| Some(*label) != best);
        best.into_iter().chain(others).take(most).collect()
    }
}
