//! The page's counts: how many points pass, and what decides.

use super::judgement::Judgement;
use super::overlay::metric_of;
use super::passes::Passes;
use crate::document::format::{count, number, percent};
use curves::{Kind, Metric};
use parameter_regions::table::PointTable;
use sampling::statistics::share::Fraction;
use serde::Serialize;

#[derive(Default, Serialize)]
pub(super) struct CountRow {
    name: String,
    kind: &'static str,
    note: String,
    nominal: String,
    accepted: String,
    /// The tolerance interval drawn in by the guard band, where one acts.
    drawn_in: Option<String>,
    count: String,
    percent: String,
    interval: String,
    /// Per cent, for the bar.
    value: f64,
    low: f64,
    high: f64,
    binds: String,
    only: String,
    miss: String,
}

/// The share that the verdict rests on: that of the accepted points with the interval that decided, or of the points that
/// meet all criteria.
#[derive(Serialize)]
pub(super) struct Headline {
    count: String,
    percent: String,
    /// Both ends of the interval; none where nothing can be said of the share.
    interval: Option<[String; 2]>,
    /// Of the interval, per cent.
    confidence: String,
    /// How it was computed, where it decided.
    method: Option<String>,
}

impl Headline {
    pub(super) fn new(judgement: &Judgement, total: usize, meets_all: &Fraction) -> Self {
        const USUAL: f64 = 95.0;
        let Some((required, accepted)) = judgement.required() else {
            return Self {
                count: count(meets_all.count),
                percent: percent(meets_all.value()),
                interval: Some([meets_all.low, meets_all.high].map(percent)),
                confidence: number(USUAL, 4),
                method: None,
            };
        };
        Self {
            count: count(accepted),
            percent: percent(accepted as f64 / total.max(1) as f64),
            interval: required.interval.map(|ends| ends.map(percent)),
            confidence: number(100.0 * required.rule.confidence, 4),
            method: Some(match required.guard_bands {
                Some(_) => format!(
                    "{}, over all guard bands that may be the right one",
                    required.method
                ),
                None => required.method.clone(),
            }),
        }
    }
}

/// The share of the accepted points, where a guard band makes them fewer than those within all tolerances, and a note on
/// the guard band.
fn guarded(judgement: &Judgement, total: usize) -> Option<(String, Fraction)> {
    let (required, accepted) = judgement.required()?;
    // Of nothing accepted without an interval there is no row.
    let [low, high] = required.interval?;
    let band = judgement.guard?;
    let note = if band.is_finite() {
        format!(
            "each tolerance drawn in by {} expanded uncertainties (guard band)",
            number(band, 3)
        )
    } else {
        "no guard band keeps the risk as low as required".into()
    };
    let share = Fraction {
        count: accepted,
        of: total,
        low,
        high,
    };
    Some((note, share))
}

pub(super) fn count_rows(
    table: &PointTable,
    counted: &Passes,
    judgement: &Judgement,
    total: usize,
) -> Vec<CountRow> {
    let row = |name: &str, kind, f: &Fraction| CountRow {
        name: name.to_owned(),
        kind,
        count: count(f.count),
        percent: percent(f.value()),
        interval: format!("{} – {}", percent(f.low), percent(f.high)),
        value: 100.0 * f.value(),
        low: 100.0 * f.low,
        high: 100.0 * f.high,
        ..CountRow::default()
    };
    let criterion = |k: usize| {
        let (c, v) = (&table.criteria[k], &counted.criteria[k]);
        CountRow {
            note: c.source.clone(),
            nominal: match metric_of(&c.source) {
                Some(_) => "curve".to_owned(),
                None => quantity(c.nominal, &c.unit),
            },
            accepted: match metric_of(&c.source).map(Metric::kind) {
                Some(Kind::Rating) => format!("at least {}", number(c.lower, 6)),
                Some(_) => format!("at most {}", quantity(c.upper, &c.unit)),
                None => format!("{} … {}", number(c.lower, 6), quantity(c.upper, &c.unit)),
            },
            drawn_in: judgement
                .drawn_in(k, [c.lower, c.upper])
                .map(|[low, high]| match low <= high {
                    true => format!("{} … {}", number(low, 6), quantity(high, &c.unit)),
                    false => "nothing".to_owned(),
                }),
            binds: count(v.binds),
            only: count(v.only_failure),
            miss: v
                .median_miss
                .map_or_else(|| "–".into(), |m| format!("{} ×", number(m, 3))),
            ..row(&c.name, "criterion", &v.passes)
        }
    };
    let mut rows = Vec::new();
    for (group, passes) in &counted.groups {
        let members: Vec<usize> = (0..table.criteria.len())
            .filter(|&k| table.criteria[k].group.as_deref() == Some(group))
            .collect();
        rows.extend(members.iter().map(|&k| criterion(k)));
        if members.len() > 1 {
            rows.push(CountRow {
                note: format!("group of {}", members.len()),
                ..row(group, "group", passes)
            });
        }
    }
    rows.extend(
        (0..table.criteria.len())
            .filter(|&k| table.criteria[k].group.is_none())
            .map(criterion),
    );
    let Some((note, accepted)) = guarded(judgement, total) else {
        let name = match judgement.guard {
            Some(_) => "within all tolerances",
            None => "all criteria",
        };
        rows.push(row(name, "total", &counted.verified));
        return rows;
    };
    rows.push(row("within all tolerances", "total", &counted.verified));
    rows.push(CountRow {
        note,
        ..row("accepted", "total", &accepted)
    });
    rows
}

pub(super) fn quantity(value: f64, unit: &str) -> String {
    if unit.is_empty() || unit == "1" {
        number(value, 6)
    } else {
        format!("{} {unit}", number(value, 6))
    }
}

/// A sentence that names the criterion which decides the verdict.
pub(super) fn decisive(table: &PointTable, counted: &Passes, total: usize) -> String {
    let criteria = || counted.criteria.iter().enumerate();
    let binding = criteria().max_by_key(|(_, c)| c.binds);
    let alone = criteria().max_by_key(|(_, c)| c.only_failure);
    let completed = total - counted.failed;
    match (binding, alone) {
        (Some((b, binds)), Some((a, only))) if completed > 0 => {
            let mut text = format!(
                "{} is the criterion that deviates most, in units of its tolerance, at {} of {} simulated points.",
                table.criteria[b].name,
                count(binds.binds),
                count(completed)
            );
            if only.only_failure > 0 {
                text += &format!(
                    " {} alone keeps {} further point{} from meeting all.",
                    table.criteria[a].name,
                    count(only.only_failure),
                    if only.only_failure == 1 { "" } else { "s" }
                );
            }
            text
        }
        _ => "No point was simulated to its end.".into(),
    }
}
