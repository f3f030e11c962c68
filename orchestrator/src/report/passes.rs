//! How many points pass, how sure that share is, and which criterion decides.

use crate::results::Summary;
use crate::results::summary::{Count, CriterionCount};
use parameter_regions::table::{CriterionColumn, PointTable};
use sampling::statistics::share::Fraction;

/// How many points one criterion accepts and rejects.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CriterionPasses {
    /// Points that meet it.
    pub passes: Fraction,
    /// Points at which it deviates most of all criteria, in units of the tolerances.
    pub binds: usize,
    /// Points that fail this criterion and no other: verified, were it not for this one.
    pub only_failure: usize,
    /// Median deviation, in units of the tolerance, of the points that fail it.
    pub median_miss: Option<f64>,
}

/// Counts over all points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Passes {
    /// Points that meet all criteria.
    pub verified: Fraction,
    /// Points that were not simulated to their end; they count as not verified.
    pub failed: usize,
    /// One count a criterion.
    pub criteria: Vec<CriterionPasses>,
    /// Passes of all criteria of a group, by group name.
    pub groups: Vec<(String, Fraction)>,
}

impl Passes {
    /// The counts of a finished study; `table` may hold only some of its points.
    pub fn new(summary: &Summary, table: &PointTable) -> Self {
        let fraction = |passed: u64, interval: Option<[f64; 2]>| {
            let count = passed as usize;
            let of = summary.points as usize;
            let share = count as f64 / of.max(1) as f64;
            // Where there is none, the page has no column for it.
            let [low, high] = interval.unwrap_or([share; 2]);
            Fraction {
                count,
                of,
                low,
                high,
            }
        };
        let of = |count: &Count| fraction(count.passed, count.interval);
        let criterion = |(entry, column): (&CriterionCount, &CriterionColumn)| CriterionPasses {
            passes: of(&entry.count),
            binds: entry.binds as usize,
            only_failure: entry.only_failure as usize,
            median_miss: median_miss(column),
        };
        let groups = summary.groups.iter();
        Self {
            verified: fraction(summary.verified, summary.verified_interval),
            failed: summary.failed as usize,
            criteria: summary
                .criteria
                .values()
                .zip(&table.criteria)
                .map(criterion)
                .collect(),
            groups: groups
                .map(|(name, count)| (name.clone(), of(count)))
                .collect(),
        }
    }
}

/// The median deviation of the points that fail a criterion, in units of its tolerance.
pub fn median_miss(criterion: &CriterionColumn) -> Option<f64> {
    let failed = criterion.values.iter().zip(&criterion.ok);
    let failed = failed.filter(|(_, ok)| !**ok);
    let misses = failed.map(|(value, _)| criterion.deviation(*value));
    let mut misses: Vec<f64> = misses.filter(|miss| !miss.is_nan()).collect();
    misses.sort_by(f64::total_cmp);
    misses.get(misses.len() / 2).copied()
}
