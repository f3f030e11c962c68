//! The table of counts, as the paper prints it.

use std::fmt::Write;

use indexmap::IndexMap;

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

/// What meets which criterion.
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
    let criteria = summary.criteria.iter().map(|(name, entry)| {
        let unit = entry
            .criterion
            .unit
            .as_deref()
            .map_or_else(String::new, |u| format!(" {u}"));
        let criterion = &entry.criterion;
        let condition = match criterion.metric {
            Some(_) => format!("{name}  {}", criterion.stated_tolerance),
            None => format!(
                "{name}  {}{unit} +-{}",
                criterion.nominal, criterion.stated_tolerance
            ),
        };
        (condition, entry.count)
    });
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
    let met = match conclusion.and_then(|found| found.required.as_ref()) {
        Some(_) => "within all tolerances",
        None => "all criteria: verified",
    };
    line(&mut text, met, &all);
    for (name, variant) in &summary.variants {
        let about = variant.about.as_deref().unwrap_or(name);
        let _ = writeln!(text, "\n{about}{}", unguarded(summary));
        for (criterion, count) in &variant.criteria {
            let own = &summary.criteria[criterion].criterion;
            if own.tolerance != variant.tolerances[criterion] {
                let unit = own
                    .unit
                    .as_deref()
                    .map_or_else(String::new, |unit| format!(" {unit}"));
                let tolerance = variant.tolerances[criterion];
                let condition = format!("{criterion}  {}{unit} +-{tolerance}{unit}", own.nominal);
                line(&mut text, &condition, count);
            }
        }
        groups(&mut text, &variant.groups);
        line(&mut text, met, &variant.verified);
    }
    risks(&mut text, summary);
    text.push('\n');
    for sentence in words::sentences(summary) {
        let _ = writeln!(text, "{sentence}");
    }
    text
}

/// Other readings of the tolerances count without the guard band.
fn unguarded(summary: &Summary) -> &'static str {
    match summary.conclusion.as_ref().map(|found| found.guard_band) {
        Some(Some(0.0)) | None => "",
        Some(_) => " (the guard band is not applied here)",
    }
}

/// The risks of accepting, of every criterion and of all, where they are known.
fn risks(text: &mut String, summary: &Summary) {
    let criteria = summary.criteria.iter();
    let own = criteria.filter_map(|(name, entry)| Some((name.as_str(), entry.risk.as_ref()?)));
    let conclusion = summary.conclusion.as_ref();
    let all = conclusion.and_then(|found| Some(("all criteria", found.risk.as_ref()?)));
    let rows: Vec<_> = own.chain(all).collect();
    let Some(longest) = rows.iter().map(|(name, _)| name.chars().count()).max() else {
        return;
    };
    let width = longest.max(22);
    let _ = writeln!(
        text,
        "\n{:<width$}{:>24}{:>26}{:>26}",
        match summary.verified_interval {
            Some(_) => "risk, 95 % interval",
            None => "risk",
        },
        "accepted, not conforming",
        "rejected, conforming",
        "not conforming / accepted"
    );
    for (name, risk) in rows {
        let intervals = risk.intervals.as_ref();
        let _ = writeln!(
            text,
            "{name:<width$}{:>24}{:>26}{:>26}",
            with_interval(Some(risk.consumer), intervals.map(|of| of.consumer)),
            with_interval(Some(risk.producer), intervals.map(|of| of.producer)),
            with_interval(
                risk.not_conforming_given_accepted,
                intervals.map(|of| of.not_conforming_given_accepted)
            ),
        );
    }
}

fn with_interval(share: Option<f64>, interval: Option<[f64; 2]>) -> String {
    let Some(share) = share.map(|share| 100.0 * share) else {
        return "-".to_owned();
    };
    match interval.map(|interval| interval.map(|limit| 100.0 * limit)) {
        Some([low, high]) => format!("{share:.2} % ({low:.1} .. {high:.1})"),
        None => format!("{share:.2} %"),
    }
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
        Some(point) => {
            let verified = if point.verified { "" } else { "not " };
            format!(
                "most probable point: {} ({verified}verified)\n",
                point.point
            )
        }
        None if summary.has_samples() => {
            "most probable point: not known; a sample does not tell the density that it was drawn from\n".to_owned()
        }
        None => {
            "most probable point: not known; it needs the uncertainty of every measured value, of which no error may \
             follow from others\n"
                .to_owned()
        }
    }
}

/// The first lines for a reader.
fn remarks(summary: &Summary) -> String {
    let conduct = summary.conduct.iter().flat_map(Conduct::remarks);
    let asides = summary.asides.iter().flat_map(Asides::remarks);
    let concerns = summary
        .concerns
        .iter()
        .map(|concern| format!("{}: {}\n", concern.severity.name(), concern.text));
    conduct
        .chain(asides)
        .chain(summary.left_out_remark())
        .map(|remark| format!("{remark}\n"))
        .chain(concerns)
        .collect()
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
    let kind = if best.verified {
        "nearest verified point"
    } else {
        "nearest point"
    };
    let parts: Vec<String> = values.chain(parameters).collect();
    format!(
        "\n{kind}: {}\n  {}\n{}",
        best.point,
        parts.join("\n  "),
        most_probable(summary)
    )
}
