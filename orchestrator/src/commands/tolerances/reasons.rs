//! Why no tolerances would do.

use super::goal::Goal;
use crate::analysis::tolerances::Problem;
use crate::judge::{Criterion, Judge};
use crate::report::format::number;

/// The obstacles, a sentence each: given what comes of the centre of all parameters, and of the points drawn at
/// the study's own tolerances.
pub(super) fn of(
    judge: &Judge,
    goal: &Goal<'_>,
    centre: Option<&[f64]>,
    points: &[Option<Vec<f64>>],
) -> Vec<String> {
    let mut found = Vec::new();
    match centre {
        None => {
            found.push("the model fails with all parameters at their nominal values".to_owned())
        }
        Some(_) => {
            found.extend(off(judge, centre));
            if found.is_empty() {
                found.push(format!(
                    "with all parameters at their nominal values the model meets all criteria, but conforms as wanted \
                     only to {} %: the measured values' uncertainties are too large for it",
                    number(100.0 * goal.good(centre), 3)
                ));
            }
        }
    }
    found.extend(contradictions(judge, points));
    found
}

/// The criteria that the centre of all parameters misses, a sentence each.
pub(super) fn off(judge: &Judge, centre: Option<&[f64]>) -> Vec<String> {
    let pairs = judge.criteria.iter().zip(centre.unwrap_or_default());
    pairs
        .filter(|(criterion, value)| !criterion.accepts(**value))
        .map(|(criterion, &value)| nominal_is_off(criterion, value))
        .collect()
}

/// That the wanted share is too near the largest one to be shown.
pub(super) fn not_shown(problem: &Problem) -> String {
    format!(
        "{} % may be reached, but no tolerances are expected to show it at a confidence of {} % in {} fresh runs: want \
         less, or confirm with more runs (`--confirm N`)",
        number(100.0 * problem.target, 4),
        number(100.0 * problem.confidence, 4),
        problem.confirm
    )
}

/// Narrower tolerances bring all points nearer to the nominal one.
fn nominal_is_off(criterion: &Criterion, value: f64) -> String {
    let unit = criterion
        .unit
        .as_deref()
        .map_or_else(String::new, |unit| format!(" {unit}"));
    let beyond = (value - criterion.nominal).abs() - criterion.tolerance;
    format!(
        "{}: with all parameters at their nominal values it is {}{unit}, {}{unit} beyond the tolerance, and narrower \
         tolerances only bring the other points nearer to that: shift a parameter's nominal value",
        criterion.name,
        number(value, 5),
        number(beyond, 3)
    )
}

/// Criteria that no point meets, and pairs of criteria of which points meet one or the other, but none meets both.
fn contradictions(judge: &Judge, points: &[Option<Vec<f64>>]) -> Vec<String> {
    const EXPECTED: f64 = 5.0;
    let completed: Vec<&Vec<f64>> = points.iter().flatten().collect();
    let meets = |k: usize, values: &[f64]| judge.criteria[k].accepts(values[k]);
    let count = |condition: &dyn Fn(&[f64]) -> bool| {
        completed.iter().filter(|values| condition(values)).count() as f64
    };
    let alone: Vec<f64> = (0..judge.criteria.len())
        .map(|k| count(&|values| meets(k, values)))
        .collect();
    let name = |k: usize| &judge.criteria[k].name;
    let all = completed.len().max(1) as f64;
    let mut found = Vec::new();
    for a in 0..alone.len() {
        if alone[a] == 0.0 {
            found.push(format!("{}: not one of {all} points meets it", name(a)));
        }
        for b in a + 1..alone.len() {
            // Of independent criteria some points would meet both by chance.
            let expected = alone[a] * alone[b] / all;
            if expected >= EXPECTED && count(&|values| meets(a, values) && meets(b, values)) == 0.0
            {
                found.push(format!(
                    "{} and {} contradict each other: {} points meet the first, {} the second, and none meets both",
                    name(a),
                    name(b),
                    alone[a],
                    alone[b]
                ));
            }
        }
    }
    found
}
