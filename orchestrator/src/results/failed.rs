//! Points without a result: what they leave open of a verdict, and where among the parameters they lie.

use super::Summary;
use conformity::{
    conclusion::{Conclusion, grouped},
    decision::Decision,
};
use fmu_points::{failure::Failure, names::behind};
use result_document::format::number;
use sampling::statistics::moments::{ks_distance, sorted};
use study::concern::{Code, Concern};

/// Warns of points without a result. They count as not verified and not conforming, and are missing elsewhere, so that
/// the shares and the means of one study tell of different points.
pub fn concern(summary: &Summary, place: impl FnOnce() -> Option<String>) -> Option<Concern> {
    let Summary { failed, points: all, .. } = *summary;
    if failed == 0 {
        return None;
    }
    let reasons: Vec<String> =
        summary.failures.iter().map(|(reason, count)| format!("{reason}: {}", grouped(*count))).collect();
    let reasons = reasons.join(", ");
    let time = match summary.failures.contains_key(Failure::Timeout.class()) {
        true => " Points that run out of time need a longer `--point-timeout`.",
        false => "",
    };
    if failed == all {
        return Some(
            Concern::new(
                Code::FailedPoints,
                format!("no point has a result ({reasons}), so the model was not compared with the measurement"),
            )
            .remedied(format!("Find out why all points fail: `orchestrator check` looks at the FMU.{time}")),
        );
    }
    let place = place().map(|place| format!(", mostly where {place}")).unwrap_or_default();
    let text = format!(
        "{} of {} points failed ({reasons}){place}; they count as not {}, and comparisons and sensitivities leave them out",
        grouped(failed),
        grouped(all),
        summary.met()
    );
    let which = match failed {
        1 => "a point fails".to_owned(),
        n => format!("{} points fail", grouped(n)),
    };
    Some(
        Concern::new(Code::FailedPoints, text)
            .remedied(format!("Find out why {which}, or cut the distributions to where the model works.{time}")),
    )
}

/// The parameter that sets marked points, such as failed ones, apart most, if any does: the largest distance between the
/// distribution functions of marked and other points (Kolmogorov and Smirnov), where that is not chance. `varied` has the
/// parameters by number, with names and units.
pub fn place(varied: &[(usize, &str, Option<&str>)], points: &[(impl AsRef<[f64]>, bool)]) -> Option<String> {
    const CLEAR: f64 = 0.5;
    let of = |&(k, name, unit): &(usize, _, _)| {
        let values = |of: bool| {
            let rows = points.iter().filter(|(_, marked)| *marked == of);
            sorted(rows.map(|(parameters, _)| parameters.as_ref()[k]).collect())
        };
        let [marked, others] = [values(true), values(false)];
        (ks_distance(&marked, &others), name, unit, marked, others)
    };
    let chance = |marked: usize, others: usize| {
        // The probability of a larger distance by chance is about 2 exp(-2 d^2 n m / (n + m)), for each parameter.
        let tail = 0.01 / varied.len() as f64;
        (0.5 * (2.0 / tail).ln() * (1.0 / marked as f64 + 1.0 / others as f64)).sqrt()
    };
    let ((distance, split), name, unit, marked, others): (_, &str, _, Vec<f64>, Vec<f64>) =
        varied.iter().map(of).max_by(|a, b| a.0.0.total_cmp(&b.0.0))?;
    if distance < CLEAR.max(chance(marked.len(), others.len())) {
        return None;
    }
    let part = |values: &[f64]| values.partition_point(|value| *value <= split) as f64 / values.len() as f64;
    let parts = [&marked, &others].map(|values| part(values));
    let (side, parts) = if parts[0] > parts[1] { ("at most", parts) } else { ("above", parts.map(|part| 1.0 - part)) };
    let [marked, others] = parts.map(|part| number(100.0 * part, 2));
    Some(format!(
        "{name} is {side} {}{} (so are {marked} % of these and {others} % of the others)",
        number(split, 4),
        behind(unit)
    ))
}

/// The conclusion where no point has a result: there is nothing to decide by.
pub fn nothing_compared(conclusion: &mut Conclusion, points: u64) {
    let Conclusion { verdict, verdict_words, required, risk, .. } = conclusion;
    *verdict = Decision::Inconclusive;
    *verdict_words = match points {
        1 => "inconclusive: the only point failed, so nothing was compared with the measurement".to_owned(),
        n => format!("inconclusive: all {} points failed, so nothing was compared with the measurement", grouped(n)),
    };
    if let Some(required) = required {
        required.interval = None;
        required.guard_bands = None;
        required.points_needed = None;
        required.points_needed_going_on = None;
        "none: no point has a result".clone_into(&mut required.method);
    }
    *risk = None;
}
