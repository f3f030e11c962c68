//! The page's counts: how many points pass, and what decides.

use super::judgement::Judgement;
use crate::results::{Summary, summary::Count};
use conformity::conclusion::grouped;
use curves::{Kind, Metric};
use parameter_regions::table::{CriterionColumn, PointTable};
use result_document::format::{DASH, number};
use sampling::statistics::moments::sorted;
use serde::Serialize;

#[derive(Default, Serialize)]
pub struct CountRow {
    name: String,
    kind: &'static str,
    note: String,
    nominal: String,
    accepted: String,
    /// The tolerance interval drawn in by the guard band, where one acts.
    drawn_in: Option<String>,
    #[serde(flatten)]
    count: Count,
    binds: String,
    only: String,
    miss: String,
}

/// How the range was computed that decided, where one did.
#[derive(Serialize)]
pub struct Headline {
    /// Of the range, per cent.
    confidence: String,
    method: String,
}

impl Headline {
    pub fn new(judgement: &Judgement) -> Option<Self> {
        let (required, _) = judgement.required()?;
        required.interval?;
        Some(Self {
            confidence: number(100.0 * required.rule.confidence, 4),
            method: match required.guard_bands {
                Some(_) => format!("{}, over all guard bands that may be the right one", required.method),
                None => required.method.clone(),
            },
        })
    }
}

/// The share of the accepted points, where a guard band makes them fewer than those within all tolerances, and a note on
/// the guard band.
fn guarded(judgement: &Judgement, total: usize) -> Option<(String, Count)> {
    let (required, accepted) = judgement.required()?;
    // Of nothing accepted without an interval there is no row.
    let interval = Some(required.interval?);
    let note = judgement.rule_of_acceptance()?;
    let share = Count { passed: accepted as u64, fraction: accepted as f64 / total.max(1) as f64, interval };
    Some((note, share))
}

pub fn count_rows(table: &PointTable, summary: &Summary, judgement: &Judgement) -> Vec<CountRow> {
    let row = |name: &str, kind, count| CountRow { name: name.to_owned(), kind, count, ..CountRow::default() };
    let criterion = |k: usize| {
        let (c, v) = (&table.criteria[k], &summary.criteria[k]);
        CountRow {
            note: v.criterion.source(),
            nominal: match v.criterion.metric {
                Some(_) => "curve".to_owned(),
                None if v.criterion.nominal_from.is_some() => "none yet".to_owned(),
                None => v.criterion.measured().value.map_or(DASH.into(), |value| quantity(value, &c.unit)),
            },
            accepted: match v.criterion.metric.map(Metric::kind) {
                Some(Kind::Rating) => format!("at least {}", number(c.lower, 6)),
                Some(_) => format!("at most {}", quantity(c.upper, &c.unit)),
                None => interval([c.lower, c.upper], &c.unit),
            },
            drawn_in: judgement
                .drawn_in(k, [c.lower, c.upper])
                .map(|[low, high]| if low <= high { interval([low, high], &c.unit) } else { "nothing".to_owned() }),
            binds: grouped(v.binds),
            only: grouped(v.only_failure),
            miss: median_miss(c).map_or(DASH.into(), |m| format!("{} ×", number(m, 3))),
            ..row(&c.name, "criterion", v.count)
        }
    };
    let mut rows = Vec::new();
    for (group, passes) in &summary.groups {
        let members = table.members(Some(group));
        rows.extend(members.iter().map(|&k| criterion(k)));
        if members.len() > 1 {
            rows.push(CountRow { note: format!("group of {}", members.len()), ..row(group, "group", *passes) });
        }
    }
    rows.extend(table.members(None).into_iter().map(criterion));
    let accepted = guarded(judgement, summary.points as usize);
    let name = if accepted.is_some() || judgement.guard.is_some() { "within all tolerances" } else { "all criteria" };
    rows.push(row(name, "total", summary.whole()));
    rows.extend(accepted.map(|(note, count)| CountRow { note, ..row("accepted", "total", count) }));
    rows
}

pub fn quantity(value: f64, unit: &str) -> String {
    if unit.is_empty() || unit == "1" { number(value, 6) } else { format!("{} {unit}", number(value, 6)) }
}

/// The accepted values, of which one end may be open.
fn interval([low, high]: [f64; 2], unit: &str) -> String {
    match (low.is_finite(), high.is_finite()) {
        (true, true) => format!("{} .. {}", number(low, 6), quantity(high, unit)),
        (true, false) => format!("at least {}", quantity(low, unit)),
        _ => format!("at most {}", quantity(high, unit)),
    }
}

/// The median deviation of the points that fail a criterion, in units of its tolerance.
fn median_miss(criterion: &CriterionColumn) -> Option<f64> {
    let misses = criterion
        .values
        .iter()
        .zip(&criterion.ok)
        .filter(|(_, ok)| !**ok)
        .map(|(value, _)| criterion.deviation(*value))
        .filter(|miss| !miss.is_nan())
        .collect();
    let misses = sorted(misses);
    misses.get(misses.len() / 2).copied()
}
