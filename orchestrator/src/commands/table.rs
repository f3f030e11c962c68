//! The result on the terminal: the first screen, or all of it with the table of counts that the paper prints.

use std::{fmt::Write, path::Path};

use crate::{
    methods::{self, known::Finished},
    report::counted::risks,
    results::{
        Summary,
        answer::{Answer, Names, remarks},
        summary::{Count, FailedPoint, FailureKind},
        surrogate,
    },
};
use fmu_points::names::behind;
use result_document::wrapped;

/// The result for people: what fits a screen, or all of it. The page is in `folder`.
pub fn told(summary: &Summary, folder: Option<&Path>, verbose: bool) -> String {
    let of = folder.map(|folder| Finished { folder, summary });
    let names = of.map_or_else(|| Names::of(summary), |of| of.names());
    let documents = of.map(|of| methods::shown(&of)).unwrap_or_default();
    let answer = Answer::new(summary).beside(summary, (&names, &documents), "Found as well (report.html)");
    let place = folder.map_or_else(String::new, |place| format!("results in {}", place.display()));
    let all = [answer.decides.len(), answer.next.len()];
    if verbose || folder.is_none() {
        let line = |label: &str, sentence: &str| format!("{label:<9}{sentence}\n");
        let remarks: String = remarks(summary).iter().map(|remark| format!("{remark}\n")).collect();
        let parts = [screen(&answer, all, line), remarks, counts(summary), best(summary)];
        return format!("{}\n{place}\n", parts.join("\n"));
    }
    // Of what does not fit, the less important is left out: first of what decides, down to its warnings, then of what to do next,
    // then warnings, down to two sentences, and at last criteria.
    let warned = answer.decides.iter().rposition(|sentence| sentence.starts_with("Warning: ")).map_or(0, |k| k + 1);
    let ([mut decides, mut next], mut rows) = (all, MOST_ROWS);
    loop {
        let more = match all[0] + all[1] - decides - next {
            0 => String::new(),
            left => format!(" tells {left} more"),
        };
        let screen = screen(&answer, [decides, next], clipped);
        let rest = least_met(summary, rows);
        let text = format!("{screen}\n{rest}{place} (report.html; here: --verbose{more})\n");
        match () {
            () if height(&text) <= LINES => return text,
            () if decides > warned.max(2) => decides -= 1,
            () if next > 1 => next -= 1,
            () if decides > 2 => decides -= 1,
            () if rows > 1 => rows -= 1,
            () => return text,
        }
    }
}

/// So many criteria have a line of their own.
const MOST_ROWS: usize = 4;

/// A sentence beside its label, in a few lines at most.
fn clipped(label: &str, sentence: &str) -> String {
    const MOST: usize = 4;
    let whole = wrapped(label, sentence);
    let lines: Vec<&str> = whole.lines().take(MOST).collect();
    if lines.len() < whole.lines().count() { lines.join("\n") + " …\n" } else { whole }
}

/// The lines of a terminal.
const LINES: usize = 24;

/// How many lines a terminal of 80 columns takes for a text.
fn height(text: &str) -> usize {
    const WIDTH: usize = 80;
    text.lines().map(|line| line.chars().count().div_ceil(WIDTH).max(1)).sum()
}

/// The first screen with so many sentences on what decides and on what to do next.
fn screen(answer: &Answer, [decides, next]: [usize; 2], line: impl Fn(&str, &str) -> String) -> String {
    let one = std::slice::from_ref;
    let parts = [
        ("Asked", one(&answer.asked)),
        ("Answer", one(&answer.answer)),
        ("Decides", &answer.decides[..decides]),
        ("Next", &answer.next[..next]),
    ];
    let lines = |(label, sentences): (&str, &[String])| -> String {
        std::iter::once(label)
            .chain(std::iter::repeat(""))
            .zip(sentences)
            .map(|(label, sentence)| line(label, sentence))
            .collect()
    };
    let parts: String = parts.into_iter().map(lines).collect();
    format!("{} {}\n{parts}", answer.sign.mark(), answer.title)
}

/// The criteria that the fewest points meet, a line each.
fn least_met(summary: &Summary, most: usize) -> String {
    let all = summary.criteria.len();
    let shown = summary.least_met(if all > most + 1 { most } else { all });
    let mut text = if shown.is_empty() { String::new() } else { heads(summary) };
    for k in &shown {
        let (name, entry) = summary.criteria.get_index(*k).expect("a criterion's number");
        line(&mut text, &format!("{name}  {}", entry.criterion.wanted()), &entry.count);
    }
    if all > shown.len() {
        text += &format!("and {} more criteria\n", all - shown.len());
    }
    text
}

/// The heads of the lines of criteria.
fn heads(summary: &Summary) -> String {
    let interval = summary.verified_interval.map_or("", |_| "   95 % interval");
    let way = surrogate::way(summary);
    format!("{:<34}{:>10}{:>10}{interval}{way}\n", "meets", "points", "share")
}

/// The counts of points by criterion.
fn counts(summary: &Summary) -> String {
    let mut text = String::new();
    let failed = match summary.failed {
        0 => String::new(),
        failed => format!(", {failed} of them failed"),
    };
    // Writing to a String cannot fail.
    let plural = if summary.points == 1 { "" } else { "s" };
    let _ = writeln!(text, "{} point{plural}{failed}", summary.points);
    for FailureKind { points, first } in &summary.failure_kinds {
        let FailedPoint { point, status } = first;
        let _ = writeln!(text, "{points:>8} as point {point}: {status}");
    }
    text.push('\n');
    text += &heads(summary);
    for (name, entry) in &summary.criteria {
        line(&mut text, &format!("{name}  {}", entry.criterion.wanted()), &entry.count);
    }
    for (name, count) in &summary.groups {
        line(&mut text, &format!("group {name}"), count);
    }
    for (name, case) in &summary.cases {
        let held_out = if case.held_out { ", held out" } else { "" };
        line(&mut text, &format!("case {name}{held_out}"), &case.count);
    }
    // Where a share is required, points within the tolerances need neither be accepted nor verify the model.
    let met = match summary.required() {
        Some(_) => "within all tolerances".to_owned(),
        None => format!("all criteria: {}", summary.met()),
    };
    line(&mut text, &met, &summary.whole());
    text += &result_document::text(&risks(summary));
    text
}

fn line(text: &mut String, what: &str, count: &Count) {
    let share = 100.0 * count.fraction;
    let _ = write!(text, "{what:<34}{:>10}{share:>8.1} %", count.passed);
    if let Some([low, high]) = count.interval.map(|ends| ends.map(|end| 100.0 * end)) {
        let _ = write!(text, "   {low:.1} .. {high:.1} %");
    }
    text.push('\n');
}

/// The best point for people.
fn best(summary: &Summary) -> String {
    let Some(best) = &summary.best_point else { return String::new() };
    let with_unit = |name: &str, value: f64, unit: Option<&str>| {
        // Five places would leave nothing of a coefficient of expansion.
        let is_small = value != 0.0 && value.abs() < 0.01;
        let number = if is_small { format!("{value:.4e}") } else { format!("{value:.5}") };
        format!("{name} {number}{}", behind(unit))
    };
    let parameters = summary.parameters.iter().map(|parameter| {
        let value = best.parameters.get(&parameter.name).copied().unwrap_or(f64::NAN);
        with_unit(&parameter.name, value, parameter.unit.as_deref())
    });
    let values = best.values.iter().map(|(name, &value)| {
        let unit = summary.criteria.get(name).and_then(|entry| entry.criterion.unit.as_deref());
        with_unit(name, value, unit)
    });
    let kind = if best.verified { format!("nearest {} point", summary.met()) } else { "nearest point".to_owned() };
    let parts: Vec<String> = values.chain(parameters).collect();
    format!("\n{kind}: {}\n  {}\n", best.point, parts.join("\n  "))
}
