//! The document of the widest tolerances.

use conformity::decision::Decision;
use parameter_regions::tolerances::stated::{Parameter, Tolerances, Wanted};
use result_document::{Document, Table, format::number, numbers, words};

/// The document of a result.
pub fn document(result: &Tolerances) -> Document {
    let mut told = Document::new("tolerances", "Tolerances", "Widest tolerances");
    told.say(wanted(result));
    if !result.reasons.is_empty() {
        told.say("No tolerances would do.");
        told.list(result.reasons.clone());
        return told;
    }
    if let Some(widest) = result.widest {
        let by = result
            .surrogate
            .map(|runs| {
                format!(", which a surrogate of {runs} runs judged; beyond the study's tolerances it extrapolates")
            })
            .unwrap_or_default();
        told.say(format!(
            "At the widest tolerances it is {} % by {} weighted points, an effective sample size of {}{by}.",
            number(100.0 * widest.share, 4),
            result.points,
            number(widest.effective_points, 3)
        ));
    }
    told.table(table(result));
    told.say(confirmed(result));
    told.hint(
        "At the widest tolerances the share is just the wanted one; the stated ones are so much narrower that fresh runs can \
         show it.",
    );
    told
}

fn table(result: &Tolerances) -> Table {
    let row = |p: &Parameter| {
        let limited = if p.limited { " (the search went no further)" } else { "" };
        vec![
            p.name.clone(),
            p.own.clone(),
            number(p.widest_scale, 3),
            format!("{}{limited}", p.widest),
            number(p.scale, 3),
            p.stated.clone(),
        ]
    };
    let columns = [
        words("Parameter"),
        words("Study"),
        numbers("Widest, times"),
        words("Widest"),
        numbers("Stated, times"),
        words("Stated"),
    ];
    let table = Table::new("Widest tolerances", columns, result.parameters.iter().map(row).collect());
    Table { class: "stack".into(), ..table }
}

fn wanted(result: &Tolerances) -> String {
    let what = match result.wanted {
        Wanted::Accepted => "of all points accepted",
        Wanted::Conforming => "conformance probability",
    };
    let [share, confidence] = [result.share, result.confidence].map(|part| number(100.0 * part, 4));
    format!("Wanted: {share} % {what}, at a confidence of {confidence} %.")
}

/// The result of the fresh runs; nothing where there are none.
fn confirmed(result: &Tolerances) -> String {
    let (Some(stated), Some(confirmed)) = (result.stated, result.confirmed) else { return String::new() };
    let ([low, high], [least, most]) = (confirmed.interval, stated.interval);
    let [low, high, least, most, came] = [low, high, least, most, confirmed.share].map(|part| number(100.0 * part, 4));
    let judged = match confirmed.decision {
        Decision::Verified => "confirmed",
        Decision::NotVerified => "not confirmed",
        Decision::Inconclusive => "not decided; more runs decide (`--confirm`, or a larger `--budget`)",
    };
    format!(
        "At the stated tolerances {least} to {most} % were expected of {} fresh runs, and {came} % came (interval {low} to \
         {high} %): {judged}.",
        confirmed.runs
    )
}
