//! Why no tolerances would do.

use super::goal::Goal;
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
        Some(values) => {
            let off = judge
                .criteria
                .iter()
                .zip(values)
                .filter(|(c, v)| !c.accepts(**v));
            found.extend(off.map(|(criterion, &value)| nominal_is_off(criterion, value)));
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
