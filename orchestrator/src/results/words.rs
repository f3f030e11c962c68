//! The verdict in sentences, for the terminal and the page.

use super::Summary;
use super::resampled::presumed;
use conformity::conclusion::{Conclusion, Requirement, grouped};
use conformity::risk::Risk;

/// The first lines for a reader: the verdict, how firmly it stands, and how many of the accepted points conform.
pub fn sentences(summary: &Summary) -> Vec<String> {
    let Some(conclusion) = &summary.conclusion else {
        return Vec::new();
    };
    let verdict = capitalised(&format!("{}.", conclusion.verdict_words));
    if summary.failed == summary.points || summary.has_own_values() {
        return vec![verdict];
    }
    let mut sentences = vec![verdict];
    sentences.extend(beyond_validity(summary));
    sentences.push(firmness(conclusion, summary));
    sentences.extend(looked(conclusion));
    sentences.extend(guard(conclusion));
    sentences.push(match &conclusion.risk {
        Some(risk) => accepted(conclusion.accepted, risk, summary),
        None => unknown(summary),
    });
    let curves = presumed(summary);
    sentences.extend(curves);
    sentences.retain(|sentence| !sentence.is_empty());
    sentences
}

/// How many of the points on which the verdict rests went beyond what the model is valid for.
fn beyond_validity(summary: &Summary) -> Option<String> {
    let validity = summary.asides.as_ref()?.validity.as_ref()?;
    (validity.verified > 0).then(|| {
        format!(
            "Of the {} points that meet all criteria {} went beyond what the model says it is valid for.",
            grouped(summary.verified),
            grouped(validity.verified)
        )
    })
}

/// Whether other points would say the same.
fn firmness(conclusion: &Conclusion, summary: &Summary) -> String {
    if let Some(interval) = conclusion.other_verdict_interval {
        return other_verdict(interval, &summary.provenance.method);
    }
    match &conclusion.required {
        Some(Requirement {
            points_needed: Some(once),
            points_needed_going_on: Some(going_on),
            ..
        }) => format!(
            "If the share stays what it is, about {} independent points decide in another study, which is judged once; \
             this one takes about {} if it goes on (--resume with more --points or --until verdict), since it may \
             then be looked at again and again.",
            grouped(*once),
            grouped(*going_on)
        ),
        _ => String::new(),
    }
}

/// How probably other points come to the other verdict.
fn other_verdict([least, most]: [f64; 2], method: &str) -> String {
    const LITTLE: f64 = 0.001;
    let points = match method {
        "table" => "other points from the same source",
        "monte-carlo" => "other random points",
        // The points of other designs are not independent, and nothing is known of how their seeds differ.
        _ => return String::new(),
    };
    let other = |probability: String| {
        format!("be the other one with a probability of {probability} (at a confidence of 95 %)")
    };
    let verdict = match (least, most) {
        (_, most) if most < LITTLE => "almost surely (more than 99.9 %) be the same".to_owned(),
        (least, most) if least < LITTLE => other(format!("at most {} %", short(100.0 * most))),
        (least, most) => other(format!(
            "{} to {} %",
            short(100.0 * least),
            short(100.0 * most)
        )),
    };
    format!("If the study were repeated with {points}, the verdict would {verdict}.")
}

/// How often the study was judged with other numbers of points.
fn looked(conclusion: &Conclusion) -> Option<String> {
    let looks = conclusion.required.as_ref()?.looks;
    (looks > 1).then(|| {
        format!(
            "The study was looked at {looks} times; its interval is right however often one looks."
        )
    })
}

fn guard(conclusion: &Conclusion) -> Option<String> {
    match conclusion.guard_band {
        Some(0.0) if bands(conclusion).is_empty() => None,
        Some(band) => Some(format!(
            "Every tolerance is drawn in by a guard band of {} expanded uncertainties; {} points are accepted.{}",
            short(band),
            grouped(conclusion.accepted),
            bands(conclusion)
        )),
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
    let widest = match widest {
        Some(widest) => format!("one from {narrowest:.3} to {widest:.3}"),
        None => format!("any from {narrowest:.3} on: the points show of none that it is enough"),
    };
    format!(
        " It comes from the same points; for the whole space it may be {widest}, and the interval of the share holds for \
         all of these."
    )
}

fn accepted(accepted: u64, risk: &Risk, summary: &Summary) -> String {
    let Some(share) = risk.not_conforming_given_accepted else {
        let expected = summary.expected_verified.unwrap_or(0.0);
        return format!(
            "Of all points {} are expected to conform, since the measured values are uncertain, too.",
            counted(expected)
        );
    };
    let interval = risk.intervals.map_or_else(String::new, |intervals| {
        let [low, high] = intervals.not_conforming_given_accepted;
        let [low, high] = [low, high].map(|limit| short(100.0 * limit));
        format!("; 95 % interval {low} .. {high} %")
    });
    match accepted {
        1 => format!(
            "The accepted point conforms with a probability of {} %, since the measured values are uncertain, too.",
            short(100.0 * (1.0 - share))
        ),
        n => format!(
            "About {} of the {} accepted points ({} %{interval}) probably do not conform, since the measured values are \
             uncertain, too.",
            counted(share * n as f64),
            grouped(n),
            short(100.0 * share)
        ),
    }
}

fn unknown(summary: &Summary) -> String {
    let mut reasons = Vec::new();
    let without = summary.criteria.iter().filter(|(_, entry)| {
        entry.criterion.uncertainty.is_none() && entry.criterion.row_correlation.is_none()
    });
    let names: Vec<&str> = without.map(|(name, _)| name.as_str()).collect();
    if !names.is_empty() {
        reasons.push(format!(
            "the study states no uncertainty of {}, and nothing is assumed",
            names.join(", ")
        ));
    }
    let curves = summary.criteria.iter().filter_map(|(name, entry)| {
        entry.criterion.row_correlation?;
        let reason = entry.risk_not_stated.as_ref()?;
        Some(format!("of the curve {name}, {reason}"))
    });
    reasons.extend(curves);
    format!(
        "How many of the accepted points conform is not known: {}.",
        reasons.join("; ")
    )
}

/// A number of points that need not be whole.
fn counted(points: f64) -> String {
    if points < 1000.0 {
        format!("{points:.1}")
    } else {
        grouped(points.round() as u64)
    }
}

/// Two significant digits, or all of the whole number.
fn short(value: f64) -> String {
    let decimals = match value.abs() {
        0.0 => 0,
        v if v < 0.01 => 4,
        v if v < 0.1 => 3,
        v if v < 1.0 => 2,
        v if v < 10.0 => 1,
        _ => 0,
    };
    format!("{value:.decimals$}")
}

/// The same with a capital first letter.
pub fn capitalised(sentence: &str) -> String {
    let mut letters = sentence.chars();
    let first = letters.next().map(|first| first.to_uppercase().to_string());
    first.unwrap_or_default() + letters.as_str()
}

#[cfg(test)]
mod tests;
