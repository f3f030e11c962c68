//! Why no tolerances would do.

use super::goal::Goal;
use crate::judge::{Criterion, Judge};
use parameter_regions::tolerances::Problem;
use result_document::format::number;

/// The obstacles, a sentence each: given what comes of the centre of all tolerances, one point or one for each of some rows
/// of the samples.
pub(super) fn of(judge: &Judge, goal: &Goal<'_>, centres: &[Option<Vec<f64>>]) -> Vec<String> {
    let mut reasons = Vec::new();
    match centres {
        [None] => reasons.push("the model fails with all parameters at their nominal values".to_owned()),
        [..] => {
            reasons.extend(off(judge, goal, centres));
            if let ([centre], true) = (centres, reasons.is_empty()) {
                reasons.push(format!(
                    "with all parameters at their nominal values the model meets all criteria, but conforms as wanted \
                     only to {} %: the measured values' uncertainties are too large for it",
                    number(100.0 * goal.good(centre.as_deref()), 3)
                ));
            }
        }
    }
    reasons
}

/// The criteria that the centre of all tolerances misses, a sentence each; with samples, how many of their rows conform.
pub(super) fn off(judge: &Judge, goal: &Goal<'_>, centres: &[Option<Vec<f64>>]) -> Vec<String> {
    let centre = match centres {
        [centre] => centre.as_deref().unwrap_or_default(),
        _ => return vec![of_rows(goal, centres)],
    };
    judge
        .criteria
        .iter()
        .zip(centre)
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

/// How many rows of the samples conform with all tolerances at their centres.
fn of_rows(goal: &Goal<'_>, centres: &[Option<Vec<f64>>]) -> String {
    let goods: f64 = centres.iter().map(|one| goal.good(one.as_deref())).sum();
    format!(
        "with all tolerances at nothing, {} % of {} rows of the sample conform as wanted, and a tolerance does not change \
         the sample",
        number(100.0 * goods / centres.len().max(1) as f64, 3),
        centres.len()
    )
}

/// Narrower tolerances bring all points nearer to the nominal one.
fn nominal_is_off(criterion: &Criterion, value: f64) -> String {
    let unit = criterion.unit_behind();
    let beyond = -criterion.limits.rest(value);
    format!(
        "{}: with all parameters at their nominal values it is {}{unit}, {}{unit} beyond the tolerance, and narrower \
         tolerances only bring the other points nearer to that: shift a parameter's nominal value",
        criterion.name,
        number(value, 5),
        number(beyond, 3)
    )
}
