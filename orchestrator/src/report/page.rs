//! Puts the page together: the numbers of the report as the template wants them.

use super::{
    Report,
    best::{best_rows, heading},
    counted::{cases, risks},
    counts::{Headline, count_rows},
    figures,
    from_results::{provenance, remarks},
    payload::{self, PlotColumn},
    planes::{Plane, planes},
};
use crate::{
    error::Error,
    results::{Summary, answer::Sign, summary::FailureKind, words::counted},
};
use base64::{Engine, engine::general_purpose::STANDARD};
use conformity::{conclusion::grouped, risk::Risk};
use fmu_points::tell::is_hidden;
use minijinja::{Environment, Value, context, value::Serde};
use parameter_regions::table::PointTable;
use result_document::{
    Document,
    format::{number, percent_text, with_unit},
    marked,
};
use sampling::statistics::moments::{deviation, mean};
use std::borrow::Cow;

/// More bytes are packed. Fewer are read at once, and in browsers that cannot unpack, too.
const MOST_PLAIN: usize = 300_000;

/// The plots that are written as files: name and picture.
type Plots = Vec<(String, String)>;

/// The styles of figures and page.
fn style() -> String {
    [result_document::svg::STYLE, include_str!("assets/report.css"), include_str!("assets/whatif.css")].concat()
}

/// What the page does by itself.
const SCRIPT: &str = concat!(
    include_str!("assets/packed.js"),
    include_str!("assets/numbers.js"),
    include_str!("assets/moments.js"),
    include_str!("assets/judge.js"),
    include_str!("assets/weights.js"),
    include_str!("assets/reweigh.js"),
    include_str!("assets/toml.js"),
    include_str!("assets/whatif.js"),
    include_str!("assets/report.js")
);

/// Renders the page, and its plots.
pub fn render(report: &Report) -> Result<(String, Plots), Error> {
    let whole = &report.table;
    let judgement = &report.judgement;
    let table = &*judgement.as_accepted(whole);
    let (drawn, columns) = pictured(report, table);
    let drawn = &*drawn;
    let ranking = table.best(payload::MOST_POINTS);
    let order: Vec<usize> = ranking.iter().map(|r| r.point).collect();
    let points = payload::embedded(table, &order, columns.len());
    let summary = &report.summary;
    let from = &summary.provenance;
    let conformance = judgement.conformance(table);
    let counts = report.counts();
    let [total, _] = counts;
    let bytes = payload::Bytes::default();
    let data =
        payload::payload(drawn, &columns, &points, counts, conformance.as_deref(), report.whatif.as_ref(), &bytes);
    let data = script_safe(&serde_json::to_string(&data)?);
    let bytes = bytes.all();
    let packed = bytes.len() > MOST_PLAIN;
    let answer = &report.answer;
    let planes = planes(drawn, &columns, &points, counts);
    let plots = plots(report, table, &columns, &planes);
    let (parameters, criteria) = columns.split_at(table.parameters.len());
    let page = context! {
        study => summary.title.as_deref().or(from.fmu.as_deref()).unwrap_or(&from.study),
        model => from.fmu.as_deref().filter(|_| summary.title.is_some()),
        date => summary.run.as_ref().map(|run| run.date.as_str()),
        style => style(),
        script => SCRIPT,
        whatif => report.whatif.is_some(),
        data,
        bytes => if packed { super::packed(&bytes).map_err(serde_json::Error::io)? } else { STANDARD.encode(&bytes) },
        packed,
        remarks => Serde(remarks(summary, whole.len())),
        sign => outline(answer.sign),
        answer => Serde(answer),
        word => if judgement.is_guarded() { "accepted" } else { summary.met() },
        guarded => judgement.is_guarded(),
        n => grouped(total),
        headline => Serde(Headline::new(judgement)),
        failed => summary.failed,
        drawn => grouped(points.len()),
        sampled => points.len() < total,
        rows => Serde(count_rows(table, summary, judgement)),
        counted => result_document::html(&[risks(summary), cases(summary)].concat()),
        interval_method => &summary.interval_method,
        intervals => summary.verified_interval.is_some(),
        expected => summary
            .expected_verified
            .or_else(|| Some(conformance.as_ref()?.iter().sum()))
            .map(counted),
        planes => Serde(planes),
        parameters => distributions(table, parameters, 0, counts),
        criteria => distributions(table, criteria, parameters.len(), counts),
        best_columns => Serde(columns.iter().map(heading).collect::<Vec<_>>()),
        first_criterion => parameters.len(),
        best => Serde(best_rows(
            table,
            &ranking,
            conformance.as_deref(),
            report.pictured().as_deref(),
        )),
        failures => Serde(failures(summary)),
        histories => histories(report),
        curves => report.history.iter().any(|series| series.measured.is_some()),
        documents => report.documents.iter().map(section).collect::<Vec<_>>(),
        provenance => Serde(provenance(summary)),
        command => report.command.as_str(),
        study_text => report.study_text.as_str(),
    };
    let mut environment = Environment::new();
    environment.add_filter("marked", |text: &str| Value::from_safe_string(marked(text)));
    environment.add_filter("count", grouped::<u64>);
    environment.add_filter("percent", percent_text);
    let html = environment.render_named_str("report.html", include_str!("assets/report.html"), page)?;
    Ok((html, plots))
}

/// The pictures of the page as files.
fn plots(report: &Report, table: &PointTable, columns: &[PlotColumn], planes: &[Plane]) -> Plots {
    let planes = planes.iter().map(|p| (format!("plane-{}-{}", columns[p.x].name, columns[p.y].name), p.svg.clone()));
    let distribution = |c: &PlotColumn| figures::distribution(table, c, report.counts());
    let distributions = columns.iter().map(|c| (format!("distribution-{}", c.name), distribution(c)));
    let histories = report.history.iter().filter_map(|s| Some((format!("history-{}", s.name), figures::history(s)?)));
    let figures = report.documents.iter().flat_map(Document::figures);
    let figures = figures.map(|figure| (figure.file.clone(), figure.svg.clone()));
    let all = planes.chain(distributions).chain(histories).chain(figures);
    all.map(|(name, svg)| (file_name(&name), svg)).collect()
}

/// The path of the picture that stands for an answer.
fn outline(sign: Sign) -> &'static str {
    match sign {
        Sign::Yes => "M4 12.5l5.5 5.5L20 6.5",
        Sign::Doubt => "M12 3.5v11M12 20.2v.3",
        Sign::No => "M5 5l14 14M19 5L5 19",
        Sign::Open => "M7.5 9.2a4.6 4.6 0 1 1 6.7 4.1c-1.5.8-2.2 1.5-2.2 3.2M12 20.2v.3",
    }
}

fn section(document: &Document) -> Value {
    context! {
        id => &*document.id,
        link => &*document.link,
        html => document.as_html(),
    }
}

/// A name that every system takes as that of a file. Of a long one the beginning is left, with a sum of all of it.
fn file_name(name: &str) -> String {
    const LONGEST: usize = 180;
    let plain = |c: char| {
        if c.is_alphanumeric() || "-_.".contains(c) { c } else { '_' }
    };
    let file: String = name.chars().map(plain).collect();
    if file.len() <= LONGEST {
        return file;
    }
    let end = (0..=LONGEST).rfind(|&end| file.is_char_boundary(end)).unwrap_or(0);
    format!("{}-{:08x}", &file[..end], crc32fast::hash(name.as_bytes()))
}

/// The table and its columns with the criteria that have pictures.
fn pictured<'a>(report: &Report, table: &'a PointTable) -> (Cow<'a, PointTable>, Vec<PlotColumn<'a>>) {
    let mut columns = payload::columns(table, &report.judgement);
    let Some(chosen) = report.pictured() else {
        return (Cow::Borrowed(table), columns);
    };
    let mut place = 0_usize;
    columns.retain(|_| {
        let criterion = place.checked_sub(table.parameters.len());
        place += 1;
        criterion.is_none_or(|k| chosen.contains(&k))
    });
    let criteria = chosen.iter().map(|&k| table.criteria[k].clone());
    let drawn = PointTable {
        criteria: criteria.collect(),
        ids: table.ids.clone(),
        parameters: table.parameters.clone(),
        verified: table.verified.clone(),
        status: table.status.clone(),
    };
    (Cow::Owned(drawn), columns)
}

/// JSON that cannot end the script element it stands in, and whose texts are visible to the last character in the page.
fn script_safe(json: &str) -> String {
    let mut safe = String::new();
    let mut rest = json;
    while let Some(c) = rest.chars().next() {
        // A character that JSON has escaped is one that the script sees.
        let (seen, length) = match rest.get(..6).and_then(|start| start.strip_prefix("\\u")) {
            Some(code) => (u32::from_str_radix(code, 16).ok().and_then(char::from_u32), 6),
            None if rest.starts_with("\\r\\n") => (None, 4),
            None if rest.starts_with("\\r") => (Some('\r'), 2),
            None if rest.starts_with("\\b") => (Some('\x08'), 2),
            None if rest.starts_with("\\f") => (Some('\x0c'), 2),
            None if c == '\\' => (None, 2),
            None => (Some(c), c.len_utf8()),
        };
        match seen.filter(|seen| is_hidden(*seen)) {
            Some(hidden) => safe += &format!("\\\\u{:04x}", u32::from(hidden)),
            None if c == '<' => safe += "\\u003c",
            None => safe += &rest[..length],
        }
        rest = &rest[length..];
    }
    safe
}

fn distributions(table: &PointTable, columns: &[PlotColumn], first: usize, counts: [usize; 2]) -> Vec<Value> {
    let row = |name: &str, values: Vec<f64>| {
        let finite: Vec<f64> = values.into_iter().filter(|v| v.is_finite()).collect();
        let deviation = match finite.len() {
            0 | 1 => f64::NAN,
            _ => deviation(&finite, 1),
        };
        vec![name.to_owned(), number(mean(&finite), 4), number(deviation, 3)]
    };
    let accepted = |c: &PlotColumn| {
        let accepted = c.values.iter().zip(&table.verified);
        accepted.filter(|(_, ok)| **ok).map(|(v, _)| *v).collect()
    };
    let numbered = columns.iter().enumerate();
    let shown = numbered.map(|(k, c)| {
        context! {
            name => with_unit(c.name, c.unit),
            svg => figures::distribution(table, c, counts),
            rows => vec![row("all", c.values.to_vec()), row("accepted", accepted(c))],
            column => first + k,
        }
    });
    shown.collect()
}

/// The quantities over time: the whole run each, its last periods where they oscillate fast, and the deviations from a measured
/// curve.
fn histories(report: &Report) -> Vec<Value> {
    let history = |s: &figures::Series| {
        Some(context! {
            name => s.name.as_str(),
            svg => figures::history(s)?,
            judged => judged(s),
            risk => risk(&report.summary, &s.name),
            detail => s.last_periods().as_ref().and_then(figures::history),
            residuals => figures::residuals(s),
        })
    };
    report.history.iter().filter_map(history).collect()
}

/// The risk of a curve, or why it is not known; none of other signals.
fn risk(summary: &Summary, name: &str) -> Option<String> {
    let entry = summary.criteria.get(name)?;
    entry.criterion.metric?;
    let given = |risk: &Risk| risk.not_conforming_given_accepted;
    match (entry.risk.as_ref().and_then(given), &entry.risk_not_stated) {
        (Some(share), _) => Some(format!(
            "Of the points that meet it {} % are expected to be outside of the tolerance of the true curve.",
            percent_text(share)
        )),
        (None, Some(reason)) => Some(format!("Its risk is not known: {reason}.")),
        (None, None) => Some("No point meets it, so there is no risk of accepting one.".to_owned()),
    }
}

/// When the criterion of a signal with a band looks at it.
fn judged(series: &figures::Series) -> Option<String> {
    let [from, to] = series.judged.filter(|_| series.accepted.is_some())?;
    let [from_text, to_text] = [from, to].map(|time| number(time, 6));
    Some(if from < to {
        format!("judged from {from_text} s to {to_text} s")
    } else {
        format!("judged at {to_text} s only")
    })
}

/// Reasons of failure that differ in their numbers alone: that of the first point, how often, and which that is.
fn failures(summary: &Summary) -> Vec<(&str, String, u64)> {
    let kinds = summary.failure_kinds.iter();
    kinds.map(|FailureKind { points, first }| (&*first.status, grouped(*points), first.point)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A name in Modelica may have hundreds of characters; most systems take 255 bytes.
    #[test]
    fn files_have_names_that_a_system_takes() {
        assert_eq!(file_name("plane-a b/c.d"), "plane-a_b_c.d");
        let long = "plane-".to_owned() + &"\u{e9}".repeat(500);
        let [one, other] = [file_name(&long), file_name(&(long + "x"))];
        assert!(one.len() < 200 && one != other, "{one}");
    }

    #[test]
    fn data_cannot_end_its_script() {
        assert_eq!(script_safe("[\"</script>\"]"), "[\"\\u003c/script>\"]");
    }

    #[test]
    fn the_script_sees_no_hidden_character() {
        let text = "\x1b[2J\u{202e}\u{9b}\r\r\n\x08\x0c\\u001b\\\x1b\u{2028}\u{e9}";
        let json = script_safe(&serde_json::to_string(text).unwrap());
        let seen: String = serde_json::from_str(&json).unwrap();
        assert_eq!(seen, "\\u001b[2J\\u202e\\u009b\\u000d\r\n\\u0008\\u000c\\u001b\\\\u001b\\u2028\u{e9}");
    }
}
