//! The table of counts, as the paper prints it.

use std::fmt::Write;

use indexmap::IndexMap;

use crate::concern::{Code, Concern};
use crate::report::counted::{readings, risks};
use crate::report::outlook::improve_first;
use crate::results::asides::Asides;
use crate::results::summary::{Count, FailedPoint};
use crate::results::{Summary, words};
use fmu_points::Conduct;

/// The summary for people.
pub(super) fn told(summary: &Summary) -> String {
    let first = improve_first(summary).map_or_else(String::new, |first| format!("{first}\n"));
    format!("{}{}{first}", remarks(summary), counts(summary))
}

/// The counts of points by criterion.
fn counts(summary: &Summary) -> String {
    let mut text = String::new();
    let failed = match summary.failed {
        0 => String::new(),
        failed => format!(", {failed} of them failed ({})", reasons(&summary.failures)),
    };
    // Writing to a String cannot fail.
    let plural = if summary.points == 1 { "" } else { "s" };
    let _ = writeln!(text, "{} point{plural}{failed}", summary.points);
    if let Some(FailedPoint { point, status }) = &summary.first_failure {
        let _ = writeln!(text, "point {point}: {status}");
    }
    text.push('\n');
    let heading = match summary.verified_interval {
        Some(_) => "   95 % interval",
        None => "",
    };
    let _ = writeln!(
        text,
        "{:<34}{:>10}{:>10}{heading}",
        "meets", "points", "share"
    );
    let criteria = summary
        .criteria
        .iter()
        .map(|(name, entry)| (format!("{name}  {}", entry.criterion.wanted()), entry.count));
    for (condition, count) in criteria {
        line(&mut text, &condition, &count);
    }
    groups(&mut text, &summary.groups);
    for (name, case) in &summary.cases {
        let held_out = if case.held_out { ", held out" } else { "" };
        line(&mut text, &format!("case {name}{held_out}"), &case.count);
    }
    let all = Count {
        passed: summary.verified,
        fraction: summary.verified_fraction,
        interval: summary.verified_interval,
    };
    // Where a share is required, points within the tolerances need neither be accepted nor verify the model.
    let conclusion = summary.conclusion.as_ref();
    let met = match conclusion.and_then(|conclusion| conclusion.required.as_ref()) {
        Some(_) => "within all tolerances".to_owned(),
        None => format!("all criteria: {}", summary.met()),
    };
    line(&mut text, &met, &all);
    text += &result_document::text(&[risks(summary), readings(summary)].concat());
    text.push('\n');
    for sentence in words::sentences(summary) {
        let _ = writeln!(text, "{sentence}");
    }
    text
}

fn groups(text: &mut String, groups: &IndexMap<String, Count>) {
    for (name, count) in groups {
        line(text, &format!("group {name}"), count);
    }
}

fn line(text: &mut String, what: &str, count: &Count) {
    let share = 100.0 * count.fraction;
    let _ = write!(text, "{what:<34}{:>10}{share:>8.1} %", count.passed);
    if let Some([low, high]) = count.interval.map(|ends| ends.map(|end| 100.0 * end)) {
        let _ = write!(text, "   {low:.1} .. {high:.1} %");
    }
    text.push('\n');
}

fn reasons(failures: &IndexMap<String, u64>) -> String {
    let reasons: Vec<String> = failures
        .iter()
        .map(|(reason, count)| format!("{reason}: {count}"))
        .collect();
    reasons.join(", ")
}

/// The point with the largest product of prior density and likelihood, which need not be the nearest.
fn most_probable(summary: &Summary) -> String {
    match &summary.most_probable_point {
        _ if summary.has_own_values() => String::new(),
        Some(point) => {
            let verified = if point.verified { "" } else { "not " };
            format!(
                "most probable point: {} ({verified}verified)\n",
                point.point
            )
        }
        None if summary.has_samples() => {
            "most probable point: unknown, since the density of a sample of parameters is unknown\n".to_owned()
        }
        None => {
            "most probable point: unknown, since not every measured value has an uncertainty of its own\n"
                .to_owned()
        }
    }
}

/// The first lines for a reader.
fn remarks(summary: &Summary) -> String {
    let conduct = summary.conduct.iter().flat_map(Conduct::remarks);
    let asides = summary.asides.iter().flat_map(Asides::remarks);
    // That nothing is measured makes all the rest something else.
    let is_first = |concern: &&Concern| concern.code == Code::NominalFromModel;
    let (first, others): (Vec<&Concern>, Vec<&Concern>) =
        summary.concerns.iter().partition(is_first);
    let doubts = |concerns: Vec<&Concern>| -> String {
        let line = |concern: &Concern| format!("{}: {}\n", concern.severity.name(), concern.text);
        concerns.into_iter().map(line).collect()
    };
    let remarks = conduct.chain(asides).chain(summary.left_out_remark());
    let remarks: String = remarks.map(|remark| format!("{remark}\n")).collect();
    doubts(first) + &remarks + &doubts(others)
}

/// The best point for people.
pub(super) fn best(summary: &Summary) -> String {
    let Some(best) = &summary.best_point else {
        return String::new();
    };
    let with_unit = |name: &str, value: f64, unit: Option<&str>| {
        let unit = unit.map_or_else(String::new, |unit| format!(" {unit}"));
        // Five places would leave nothing of a coefficient of expansion.
        if value != 0.0 && value.abs() < 0.01 {
            return format!("{name} {value:.4e}{unit}");
        }
        format!("{name} {value:.5}{unit}")
    };
    let parameters = summary.parameters.iter().map(|parameter| {
        let value = best
            .parameters
            .get(&parameter.name)
            .copied()
            .unwrap_or(f64::NAN);
        with_unit(&parameter.name, value, parameter.unit.as_deref())
    });
    let values = best.values.iter().map(|(name, &value)| {
        let unit = summary
            .criteria
            .get(name)
            .and_then(|entry| entry.criterion.unit.as_deref());
        with_unit(name, value, unit)
    });
    let kind = match best.verified {
        true => format!("nearest {} point", summary.met()),
        false => "nearest point".to_owned(),
    };
    let parts: Vec<String> = values.chain(parameters).collect();
    format!(
        "\n{kind}: {}\n  {}\n{}",
        best.point,
        parts.join("\n  "),
        most_probable(summary)
    )
}
