//! The widest tolerances, on the page and in words.

use std::fmt::Write;

use serde::Serialize;

use super::format::number;
use conformity::decision::Decision;
use parameter_regions::tolerances::stated::{Parameter, Tolerances, Wanted};

/// The result's file in a folder of results.
pub const FILE: &str = "tolerances.json";

/// Values that the template shows.
#[derive(Serialize)]
pub struct View {
    reasons: Vec<String>,
    rows: Vec<[String; 6]>,
    summary: String,
}

/// Prepares a result for the template.
pub fn view(found: &Tolerances) -> View {
    let row = |p: &Parameter| {
        [
            p.name.clone(),
            p.own.clone(),
            number(p.widest_scale, 3),
            p.widest.clone(),
            number(p.scale, 3),
            p.stated.clone(),
        ]
    };
    View {
        reasons: found.reasons.clone(),
        rows: found.parameters.iter().map(row).collect(),
        summary: format!("{} {}", wanted(found), confirmed(found)),
    }
}

fn percent(share: f64) -> String {
    number(100.0 * share, 4)
}

fn wanted(found: &Tolerances) -> String {
    let what = match found.wanted {
        Wanted::Accepted => "of all points accepted",
        Wanted::Conforming => "conformance probability",
    };
    format!(
        "Wanted: {} % {what}, at a confidence of {} %.",
        percent(found.share),
        percent(found.confidence)
    )
}

/// The result of the fresh runs; nothing where there are none.
fn confirmed(found: &Tolerances) -> String {
    let (Some(stated), Some(confirmed)) = (found.stated, found.confirmed) else {
        return String::new();
    };
    let [low, high] = confirmed.interval.map(percent);
    let [least, most] = stated.interval.map(percent);
    let judged = match confirmed.decision {
        Decision::Verified => "confirmed",
        Decision::NotVerified => "not confirmed",
        Decision::Inconclusive => "not decided; more runs with `--confirm N`",
    };
    format!(
        "At the stated tolerances {least} to {most} % were expected of {} fresh runs, and {} % came (interval {low} to \
         {high} %): {judged}.",
        confirmed.runs,
        percent(confirmed.share)
    )
}

/// The result for the terminal.
pub fn text(found: &Tolerances) -> String {
    let mut out = wanted(found) + "\n";
    // Writing to a String cannot fail.
    if !found.reasons.is_empty() {
        out += "no tolerances would do\n";
        for reason in &found.reasons {
            let _ = writeln!(out, "  {reason}");
        }
        return out;
    }
    if let Some(widest) = found.widest {
        let _ = writeln!(
            out,
            "\nwidest tolerances: {} % by {} weighted points, worth {}",
            percent(widest.share),
            found.points,
            number(widest.effective_points, 3)
        );
    }
    for p in &found.parameters {
        let limited = if p.limited {
            " (the search went no further)"
        } else {
            ""
        };
        let _ = writeln!(
            out,
            "  {}: {} times the study's: {}{limited}",
            p.name,
            number(p.widest_scale, 4),
            p.widest
        );
    }
    out += "\nstated tolerances, so much narrower that fresh runs can show it\n";
    for p in &found.parameters {
        let _ = writeln!(
            out,
            "  {}: {} times the study's: {}",
            p.name,
            number(p.scale, 4),
            p.stated
        );
    }
    let _ = writeln!(out, "\n{}", confirmed(found));
    out
}
