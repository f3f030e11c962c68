//! Tables of counts that the terminal and the page share: the risk of accepting, and the cases.

use super::outlook::of_freedom;
use crate::results::{
    Summary,
    summary::{CaseCount, CriterionCount},
    words::unit_behind,
};
use conformity::{
    conclusion::grouped,
    measured::{Limits, Measured},
    risk::Risk,
};
use result_document::{
    Block, Table,
    format::{DASH, number, percent_text},
    numbers, words,
};
use study::cases::SEPARATOR;

fn range([low, high]: [f64; 2]) -> String {
    format!("{} .. {}", percent_text(low), percent_text(high))
}

/// The risk of accepting, of every criterion and of all; nothing where none is known.
pub fn risks(summary: &Summary) -> Vec<Block> {
    let criteria = || summary.criteria.iter();
    let measurement = summary.measurement();
    let Ok(measurement) = measurement else { return Vec::new() };
    if criteria().all(|(_, entry)| entry.risk.is_none()) {
        return Vec::new();
    }
    let all = summary.conclusion.as_ref().and_then(|c| c.risk.as_ref());
    let rows = criteria().zip(measurement.criteria()).map(|((name, entry), measured)| risk(name, entry, measured));
    let total = ["all criteria", "", "", ""].map(str::to_owned).into_iter().chain(shares(all)).collect();
    let columns = [
        words("Criterion"),
        numbers("Tolerance"),
        numbers("Uncertainty"),
        numbers("C_{m}"),
        numbers("Consumer's risk %"),
        numbers("Producer's risk %"),
        numbers("Not conforming % of accepted"),
    ];
    let table = Table::new("Risks", columns, rows.chain([total]).collect());
    let table = Table { class: "risks stack".into(), ..table };
    let intervals = match summary.verified_interval {
        Some(_) => " The intervals hold the error of the sample of points.",
        None => "",
    };
    let hint = format!(
        "*Tolerance*: how far the model may be from the true value. *Uncertainty*: how far the measured value may be from it, \
         expanded by k, or to 95 % where it is not normal. *C_{{m}}*: measurement capability index, the tolerance interval over four standard uncertainties. \
         *Consumer's risk*: probability that a point is accepted and does not conform. *Producer's risk*: that it is rejected \
         and conforms (JCGM 106).{intervals} All points share one measurement: if it is off, it is off for all of them."
    );
    vec![Block::Heading("The risk of accepting".into()), Block::Table(table), Block::Hint(hint)]
}

fn risk(name: &str, entry: &CriterionCount, measured: &Measured) -> Vec<String> {
    let unit = unit_behind(entry.criterion.unit.as_deref());
    let uncertainty = match (measured.error.zip(entry.criterion.uncertainty), &entry.risk) {
        (Some((error, stated)), _) => {
            let expanded = number(error.expanded, 4);
            if error.is_normal() {
                format!("{expanded}{unit} (k = {})", number(stated.coverage, 3))
            } else {
                let freedom = error
                    .freedom_within(error.standard())
                    .map(|f| format!(", {} degrees of freedom", of_freedom(f)))
                    .unwrap_or_default();
                format!("{expanded}{unit} (95.45 %: k = {}{freedom})", number(error.expanded / error.standard(), 3))
            }
        }
        (None, Some(_)) => "that of the rows".to_owned(),
        (None, None) => "not stated".to_owned(),
    };
    let Limits { minus, plus, .. } = measured.limits;
    let capability = measured.capability().map(|c| number(c, 3));
    let is_one_sided = entry.criterion.metric.is_some() || measured.limits.is_one_sided();
    [
        name.to_owned(),
        match (is_one_sided, minus == plus) {
            (true, _) => entry.criterion.stated_tolerance.clone(),
            (false, true) => format!("±{}{unit}", number(plus, 4)),
            (false, false) => format!("−{} / +{}{unit}", number(minus, 4), number(plus, 4)),
        },
        uncertainty,
        capability.unwrap_or_default(),
    ]
    .into_iter()
    .chain(shares(entry.risk.as_ref()))
    .collect()
}

/// Per cent, with their intervals: the consumer's risk, the producer's, and that of an accepted point.
fn shares(risk: Option<&Risk>) -> [String; 3] {
    let Some(risk) = risk else { return [DASH; 3].map(str::to_owned) };
    let intervals = risk.intervals.as_ref();
    let given = risk.not_conforming_given_accepted;
    let cell = |value: Option<f64>, interval: Option<[f64; 2]>| {
        let interval = interval.map(|ends| format!(" ({})", range(ends)));
        value.map_or(DASH.into(), |value| format!("{}{}", percent_text(value), interval.unwrap_or_default()))
    };
    [
        cell(Some(risk.consumer), intervals.map(|of| of.consumer)),
        cell(Some(risk.producer), intervals.map(|of| of.producer)),
        cell(given, intervals.map(|of| of.not_conforming_given_accepted)),
    ]
}

/// Cases against criteria; nothing where the study has no cases.
pub fn cases(summary: &Summary) -> Vec<Block> {
    if summary.cases.is_empty() {
        return Vec::new();
    }
    let intervals = summary.verified_interval.is_some();
    let mut criteria: Vec<&str> = Vec::new();
    for name in summary.criteria.keys() {
        let short = name.split_once(SEPARATOR).map_or(&**name, |(_, short)| short);
        if !criteria.contains(&short) {
            criteria.push(short);
        }
    }
    let row = |(name, case): (&String, &CaseCount)| {
        let held_out = if case.held_out { ", held out" } else { "" };
        let criterion = |criterion: &&str| {
            let full = format!("{name}{SEPARATOR}{criterion}");
            let entry = summary.criteria.get(&full);
            entry.map_or(DASH.into(), |entry| percent_text(entry.count.fraction))
        };
        let mut cells = vec![format!("{name}{held_out}")];
        cells.extend(criteria.iter().map(criterion));
        cells.push(grouped(case.count.passed));
        cells.push(percent_text(case.count.fraction));
        cells.extend(intervals.then(|| case.count.interval.map(range).unwrap_or_default()));
        cells.push(grouped(case.failed));
        cells
    };
    let mut columns = vec![words("Case")];
    columns.extend(criteria.iter().map(|name| numbers(format!("{name} %"))));
    columns.extend([numbers("Points"), numbers("Share %")]);
    columns.extend(intervals.then(|| words("95 % interval")));
    columns.push(numbers("Failed"));
    let table = Table::new("Shares by case", columns, summary.cases.iter().map(row).collect());
    let table = Table { class: "cases".into(), ..table };
    let hint = "Share of the points that meet each criterion in each case, and points that hold in the case: meet all its \
                criteria. A point is verified when it holds in every case. *Held out*: judged as any other case, but not used \
                by `identify`.";
    vec![Block::Heading("By case".into()), Block::Table(table), Block::Hint(hint.to_owned())]
}
