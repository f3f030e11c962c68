//! Sentences on how firmly a verdict stands, and on how many of the accepted points conform.

use super::Summary;
use conformity::{
    conclusion::{Conclusion, grouped, in_percent},
    decision::Decision,
    risk::Risk,
};
use fmu_points::names::behind;
use result_document::format::significant;

/// How many of the points on which the verdict rests went beyond what the model is valid for.
pub(super) fn beyond_validity(summary: &Summary) -> Option<String> {
    let validity = summary.asides.as_ref()?.validity.as_ref()?;
    (validity.verified > 0).then(|| {
        format!(
            "Of the {} points that meet all criteria {} went beyond what the model says it is valid for.",
            grouped(summary.verified),
            grouped(validity.verified)
        )
    })
}

/// That a verdict of the one-point rule rests on few points.
pub(super) fn few(conclusion: &Conclusion, summary: &Summary) -> Option<String> {
    /// From so many on, other points have none with a probability below 5 %, even at the share's lower limit (Clopper and
    /// Pearson).
    const ENOUGH: u64 = 8;
    let is_few =
        conclusion.required.is_none() && conclusion.verdict == Decision::Verified && conclusion.accepted < ENOUGH;
    let is_independent = summary.verified_interval.is_some() && summary.provenance.replicates.is_none();
    (is_few && is_independent).then(|| {
        format!(
            "The verdict rests on {} of {} points: of others, with another seed, none may be accepted.{}",
            conclusion.accepted,
            grouped(summary.points),
            enough(summary).map_or_else(String::new, |points| format!(
                " About {} points tell the share to +-30 %.",
                grouped(points)
            ))
        )
    })
}

/// How many independent points would tell the share of the accepted ones within 30 % of it; none where these are enough, or
/// none is accepted.
fn enough(summary: &Summary) -> Option<u64> {
    const WITHIN: f64 = 0.3;
    const NINETY_FIVE: f64 = 1.96;
    let accepted = summary.conclusion.as_ref()?.accepted as f64;
    let share = accepted / summary.points as f64;
    let points = (NINETY_FIVE / WITHIN).powi(2) * (1.0 - share) / share;
    let rounded: f64 = format!("{points:.1e}").parse().ok()?;
    (rounded.is_finite() && rounded > summary.points as f64).then_some(rounded as u64)
}

/// How often the study was judged with other numbers of points.
pub(super) fn looked(conclusion: &Conclusion) -> Option<String> {
    let looks = conclusion.required.as_ref()?.looks;
    (looks > 1)
        .then(|| format!("The study was looked at {looks} times; its interval is right however often one looks."))
}

pub(super) fn guard(conclusion: &Conclusion) -> Option<String> {
    if let Some(risk) = conclusion.point_risk {
        return Some(format!(
            "A point is accepted where it conforms with a probability of {} % or more; {} points are accepted.",
            in_percent(1.0 - risk),
            grouped(conclusion.accepted)
        ));
    }
    let bands = bands(conclusion);
    match conclusion.guard_band {
        Some(0.0) if bands.is_empty() => None,
        Some(band) => Some(format!(
            "Every tolerance is drawn in by a guard band of {} expanded uncertainties; {} points are accepted.{bands}",
            short(band),
            grouped(conclusion.accepted)
        )),
        None if !bands.is_empty() => Some(format!("Nothing is accepted:{bands}")),
        None => Some(
            "No guard band keeps the risk as low as required, so nothing is accepted: measure better or widen the \
             tolerances."
                .to_owned(),
        ),
    }
}

/// Which guard bands may be the right one of the whole space.
fn bands(conclusion: &Conclusion) -> String {
    let required = conclusion.required.as_ref();
    let Some([Some(narrowest), widest]) = required.and_then(|required| required.guard_bands) else {
        return String::new();
    };
    match widest {
        Some(_) => format!(
            " The points show that this band keeps the risk over the whole space; one from {narrowest:.3} on may be enough, and \
             the interval of the share holds for all of these."
        ),
        None => " the points show of no guard band that it keeps the risk over the whole space; simulate more points."
            .to_owned(),
    }
}

pub(super) fn accepted(accepted: u64, risk: &Risk, summary: &Summary) -> String {
    let Some(share) = risk.not_conforming_given_accepted else {
        let expected = counted(summary.expected_verified.unwrap_or(0.0));
        return match &*expected {
            "0.0" => "No point is likely to agree with the true values.".to_owned(),
            some => format!("Of all points {some} are expected to agree with the true values."),
        };
    };
    let interval = risk
        .intervals
        .map(|intervals| {
            let [low, high] = intervals.not_conforming_given_accepted.map(|limit| short(100.0 * limit));
            format!("95 % interval {low} .. {high} %")
        })
        .unwrap_or_default();
    let share_of = short(100.0 * share);
    let behind = |before: &str| match (before, &*interval) {
        ("", "") => String::new(),
        ("", interval) => format!(" ({interval})"),
        (before, "") => format!(" ({before})"),
        (before, interval) => format!(" ({before}; {interval})"),
    };
    let wrong = "outside of a tolerance of the true values, since the measured values are uncertain";
    if let Some(told) = &summary.surrogate {
        return format!(
            "Of all accepted points of the space {share_of} % ({}) are expected to be {wrong}.",
            told.way()
        );
    }
    match accepted {
        1 => format!("With a probability of {share_of} %{} the accepted point is {wrong}.", behind("")),
        n => format!(
            "Of the {} accepted points {}{} are expected to be {wrong}.",
            grouped(n),
            counted(share * n as f64),
            behind(&format!("{share_of} %"))
        ),
    }
}

pub(super) fn unknown(summary: &Summary) -> String {
    let mut reasons = Vec::new();
    let names: Vec<&str> = summary
        .criteria
        .iter()
        .filter(|(_, entry)| entry.criterion.uncertainty.is_none() && entry.criterion.row_correlation.is_none())
        .map(|(name, _)| name.as_str())
        .collect();
    if !names.is_empty() {
        reasons.push(format!("the study states no uncertainty of {}, and nothing is assumed", names.join(", ")));
    }
    let curves = summary.criteria.iter().filter_map(|(name, entry)| {
        entry.criterion.row_correlation?;
        let reason = entry.risk_not_stated.as_ref()?;
        Some(format!("of the curve {name}, {reason}"))
    });
    reasons.extend(curves);
    format!("How many of the accepted points conform is not known: {}.", reasons.join("; "))
}

/// A number of points that need not be whole.
pub fn counted(points: f64) -> String {
    if points < 1000.0 { format!("{points:.1}") } else { grouped(points.round() as u64) }
}

/// Two significant digits, or all of the whole number.
fn short(value: f64) -> String {
    if value != 0.0 && value.abs() < 5e-5 { "under 0.0001".to_owned() } else { significant(value, 2) }
}

/// A unit as it stands behind a number, with a blank; nothing where there is none, or it is 1.
pub fn unit_behind(unit: Option<&str>) -> String {
    behind(unit.filter(|unit| !["", "1"].contains(unit)))
}

/// The same with a capital first letter.
pub fn capitalised(sentence: &str) -> String {
    let mut letters = sentence.chars();
    let first = letters.next().map(|first| first.to_uppercase().to_string());
    first.unwrap_or_default() + letters.as_str()
}
