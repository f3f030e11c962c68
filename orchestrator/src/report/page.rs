//! Puts the page together: the numbers of the report as the template wants them.

use super::figures;
use super::format::{count, number, percent, with_unit};
use super::payload::{self, PlotColumn};
use super::{Report, ReportError};
use crate::analysis::pareto;
use crate::analysis::table::{PointTable, Ranked};
use crate::analysis::verdict::{Fraction, Verdict, truly_inside, verdict};
use minijinja::{Environment, value::Serde};
use serde::Serialize;
use std::collections::BTreeMap;

/// So many points are listed as the best ones.
const BEST: usize = 12;
/// So many planes of two criteria are shown at most.
const PLANES: usize = 4;

/// What the template reads.
#[derive(Serialize)]
struct Page<'a> {
    study: &'a str,
    description: &'a str,
    model: &'a str,
    date: &'a str,
    style: &'static str,
    script: &'static str,
    data: String,
    verified: bool,
    n: String,
    count: String,
    fraction: FractionText,
    failed: String,
    drawn: String,
    sampled: bool,
    rows: Vec<CountRow>,
    decisive: String,
    readings: Vec<ReadingRow>,
    expected: String,
    planes: Vec<Plane>,
    parameters: Vec<Small>,
    criteria: Vec<Small>,
    best_columns: Vec<(&'a str, &'a str, &'a str)>,
    first_criterion: usize,
    best: Vec<BestRow>,
    failures: Vec<(String, String, String)>,
    histories: Vec<History>,
    sensitivity: Option<super::sensitivity::View>,
    robustness: Option<super::robustness::View>,
    provenance: &'a [(String, String)],
    command: &'a str,
    study_text: &'a str,
}

/// One quantity over time: the whole run, and its last periods where it oscillates fast.
#[derive(Serialize)]
struct History {
    name: String,
    svg: String,
    detail: Option<String>,
}

/// A plane of two columns.
#[derive(Serialize)]
struct Plane {
    x: usize,
    y: usize,
    title: String,
    svg: String,
}

#[derive(Serialize)]
struct CountRow {
    name: String,
    kind: &'static str,
    note: String,
    nominal: String,
    accepted: String,
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

/// Another reading of the tolerances, and how its counts differ from the study's own.
#[derive(Serialize)]
struct ReadingRow {
    name: String,
    about: String,
    verified: String,
    percent: String,
    interval: String,
    changes: String,
}

#[derive(Serialize)]
struct Cell {
    text: String,
    note: String,
    bad: bool,
    /// Signed deviation, clipped to -1.5 to 1.5, for the little bar.
    bar: Option<f64>,
}

#[derive(Serialize)]
struct BestRow {
    id: u64,
    verified: bool,
    distance: String,
    deviation: String,
    binding: String,
    sure: String,
    pareto: bool,
    cells: Vec<Cell>,
}

#[derive(Serialize)]
struct Small {
    name: String,
    svg: String,
    rows: Vec<(String, String, String)>,
    column: usize,
}

/// Renders the page.
pub fn render(report: &Report) -> Result<String, ReportError> {
    let table = &report.table;
    let columns = payload::columns(table);
    let ranking = table.ranking();
    let order: Vec<usize> = ranking.iter().map(|r| r.point).collect();
    let points = payload::embedded(table, &order, columns.len());
    let counted = verdict(table);
    let sure = truly_inside(table);
    let data = serde_json::to_string(&payload::payload(table, &points))?;

    let mut environment = Environment::new();
    environment.add_template("report.html", include_str!("assets/report.html"))?;
    let page = Page {
        study: &report.study,
        description: &report.description,
        model: &report.model,
        date: &report.date,
        style: concat!(
            include_str!("assets/plot.css"),
            include_str!("assets/report.css")
        ),
        script: include_str!("assets/report.js"),
        data: script_safe(&data),
        verified: counted.verified.count > 0,
        n: count(table.len()),
        count: count(counted.verified.count),
        fraction: fraction(&counted.verified),
        failed: match counted.failed {
            0 => String::new(),
            1 => "1 point could not be simulated and counts as not verified.".into(),
            n => format!(
                "{} points could not be simulated and count as not verified.",
                count(n)
            ),
        },
        drawn: count(points.len()),
        sampled: points.len() < table.len(),
        rows: count_rows(table, &counted),
        decisive: decisive(table, &counted),
        readings: readings(report, &counted),
        expected: number(sure.iter().sum(), 4),
        planes: planes(table, &columns, &points),
        parameters: distributions(table, &columns[..table.parameters.len()], 0),
        criteria: distributions(
            table,
            &columns[table.parameters.len()..],
            table.parameters.len(),
        ),
        best_columns: columns.iter().map(heading).collect(),
        first_criterion: table.parameters.len(),
        best: best_rows(table, &ranking, &sure),
        failures: failures(table),
        histories: histories(report),
        sensitivity: report.sensitivity.as_ref().map(super::sensitivity::view),
        robustness: report.robustness.as_ref().map(super::robustness::view),
        provenance: &report.provenance,
        command: &report.command,
        study_text: &report.study_text,
    };
    let html = environment
        .get_template("report.html")?
        .render(Serde(&page))?;
    Ok(html)
}

/// The plots that are written as files: name and picture.
pub fn plots(report: &Report) -> Vec<(String, String)> {
    let table = &report.table;
    let columns = payload::columns(table);
    let order: Vec<usize> = table.ranking().iter().map(|r| r.point).collect();
    let points = payload::embedded(table, &order, columns.len());
    let mut plots: Vec<(String, String)> = planes(table, &columns, &points)
        .into_iter()
        .map(|p| {
            (
                format!("plane-{}-{}", columns[p.x].name, columns[p.y].name),
                p.svg,
            )
        })
        .collect();
    plots.extend(columns.iter().map(|c| {
        (
            format!("distribution-{}", c.name),
            figures::distribution(table, c),
        )
    }));
    plots.extend(
        report
            .history
            .iter()
            .filter_map(|s| Some((format!("history-{}", s.name), figures::history(s)?))),
    );
    for (name, _) in &mut plots {
        *name = name
            .chars()
            .map(|c| {
                if c.is_alphanumeric() || "-_.".contains(c) {
                    c
                } else {
                    '_'
                }
            })
            .collect();
    }
    plots
}

/// JSON that cannot end the script element it stands in.
fn script_safe(json: &str) -> String {
    json.replace('<', "\\u003c")
        .replace('\u{2028}', "\\u2028")
        .replace('\u{2029}', "\\u2029")
}

#[derive(Serialize)]
struct FractionText {
    percent: String,
    low: String,
    high: String,
}

fn fraction(f: &Fraction) -> FractionText {
    FractionText {
        percent: percent(f.value()),
        low: percent(f.low),
        high: percent(f.high),
    }
}

fn count_rows(table: &PointTable, counted: &Verdict) -> Vec<CountRow> {
    let row = |name: &str, kind, f: &Fraction| CountRow {
        name: name.to_owned(),
        kind,
        note: String::new(),
        nominal: String::new(),
        accepted: String::new(),
        count: count(f.count),
        percent: percent(f.value()),
        interval: format!("{} – {}", percent(f.low), percent(f.high)),
        value: 100.0 * f.value(),
        low: 100.0 * f.low,
        high: 100.0 * f.high,
        binds: String::new(),
        only: String::new(),
        miss: String::new(),
    };
    let criterion = |k: usize| {
        let (c, v) = (&table.criteria[k], &counted.criteria[k]);
        CountRow {
            note: c.source.clone(),
            nominal: quantity(c.nominal, &c.unit),
            accepted: format!("{} … {}", number(c.lower, 6), quantity(c.upper, &c.unit)),
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
    rows.push(row("all criteria", "total", &counted.verified));
    rows
}

fn readings(report: &Report, counted: &Verdict) -> Vec<ReadingRow> {
    let own = |name: &str| {
        let criterion = report.table.criteria.iter().position(|c| c.name == name);
        criterion.map(|k| counted.criteria[k].passes.count)
    };
    let row = |reading: &super::Reading| {
        let share = Fraction::wilson(reading.verified, report.table.len());
        let changed = reading
            .criteria
            .iter()
            .filter(|(name, passed)| own(name) != Some(*passed));
        let words: Vec<String> = changed
            .map(|(name, passed)| format!("{name} {}", count(*passed)))
            .collect();
        ReadingRow {
            name: reading.name.clone(),
            about: reading.about.clone(),
            verified: count(reading.verified),
            percent: percent(share.value()),
            interval: format!("{} – {}", percent(share.low), percent(share.high)),
            changes: if words.is_empty() {
                "as above".into()
            } else {
                words.join(", ")
            },
        }
    };
    report.readings.iter().map(row).collect()
}

fn quantity(value: f64, unit: &str) -> String {
    if unit.is_empty() || unit == "1" {
        number(value, 6)
    } else {
        format!("{} {unit}", number(value, 6))
    }
}

/// One sentence on what decides the verdict.
fn decisive(table: &PointTable, counted: &Verdict) -> String {
    let binding = counted
        .criteria
        .iter()
        .enumerate()
        .max_by_key(|(_, c)| c.binds);
    let alone = counted
        .criteria
        .iter()
        .enumerate()
        .max_by_key(|(_, c)| c.only_failure);
    let completed = table.len() - counted.failed;
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
                    " {} alone keeps {} further point{} from being verified.",
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

/// The planes to start with: neighbouring criteria of every group, then the criteria left over in
/// pairs, and at the end the parameter and criterion that go together most.
fn planes(table: &PointTable, columns: &[PlotColumn<'_>], points: &[usize]) -> Vec<Plane> {
    let first = table.parameters.len();
    let mut pairs: Vec<(usize, usize, String)> = Vec::new();
    let mut left_over = Vec::new();
    for group in table.groups().into_iter().map(Some).chain([None]) {
        let members: Vec<usize> = (0..table.criteria.len())
            .filter(|&k| table.criteria[k].group.as_deref() == group)
            .collect();
        match (group, members.as_slice()) {
            (Some(name), [_, _, ..]) => pairs.extend(
                members
                    .windows(2)
                    .map(|w| (first + w[0], first + w[1], name.to_owned())),
            ),
            _ => left_over.extend(members),
        }
    }
    pairs.extend(
        left_over
            .chunks(2)
            .filter(|w| w.len() == 2)
            .map(|w| (first + w[0], first + w[1], "criteria".to_owned())),
    );
    pairs.truncate(PLANES - 1);
    let room = if pairs.len().is_multiple_of(2) { 2 } else { 1 };
    let strongest = strongest_pairs(table).into_iter().take(room);
    pairs.extend(strongest.map(|(x, y)| {
        (
            x,
            first + y,
            format!("strongest on {}", table.criteria[y].name),
        )
    }));
    pairs
        .into_iter()
        .map(|(x, y, title)| Plane {
            svg: figures::plane(table, &columns[x], &columns[y], points),
            x,
            y,
            title,
        })
        .collect()
}

/// For every criterion the parameter with the largest linear correlation, the strongest first,
/// every parameter once.
fn strongest_pairs(table: &PointTable) -> Vec<(usize, usize)> {
    let mut all: Vec<(f64, usize, usize)> = Vec::new();
    for (p, parameter) in table.parameters.iter().enumerate() {
        for (c, criterion) in table.criteria.iter().enumerate() {
            let r = correlation(&parameter.values, &criterion.values).abs();
            if r.is_finite() {
                all.push((r, p, c));
            }
        }
    }
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut chosen: Vec<(usize, usize)> = Vec::new();
    for (_, p, c) in all {
        if chosen.iter().all(|&(q, d)| p != q && c != d) {
            chosen.push((p, c));
        }
    }
    chosen
}

fn correlation(x: &[f64], y: &[f64]) -> f64 {
    let pairs: Vec<(f64, f64)> = x
        .iter()
        .copied()
        .zip(y.iter().copied())
        .filter(|(a, b)| a.is_finite() && b.is_finite())
        .collect();
    let n = pairs.len() as f64;
    let (mx, my) = (
        pairs.iter().map(|p| p.0).sum::<f64>() / n,
        pairs.iter().map(|p| p.1).sum::<f64>() / n,
    );
    let (mut xx, mut yy, mut xy) = (0.0, 0.0, 0.0);
    for (a, b) in pairs {
        xx += (a - mx).powi(2);
        yy += (b - my).powi(2);
        xy += (a - mx) * (b - my);
    }
    xy / (xx * yy).sqrt()
}

fn distributions(table: &PointTable, columns: &[PlotColumn<'_>], first: usize) -> Vec<Small> {
    let row = |name: &str, values: &mut dyn Iterator<Item = f64>| {
        let finite: Vec<f64> = values.filter(|v| v.is_finite()).collect();
        let n = finite.len() as f64;
        let mean = finite.iter().sum::<f64>() / n;
        let deviation = (finite.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
        (
            name.to_owned(),
            number(mean, 4),
            number(if n > 1.0 { deviation } else { f64::NAN }, 3),
        )
    };
    columns
        .iter()
        .enumerate()
        .map(|(k, c)| Small {
            name: with_unit(c.name, c.unit),
            svg: figures::distribution(table, c),
            rows: vec![
                row("all", &mut c.values.iter().copied()),
                row(
                    "verified",
                    &mut (0..table.len())
                        .filter(|&i| table.verified[i])
                        .map(|i| c.values[i]),
                ),
            ],
            column: first + k,
        })
        .collect()
}

/// A structured name in its two parts, and the unit.
fn heading<'a>(c: &PlotColumn<'a>) -> (&'a str, &'a str, &'a str) {
    let (path, name) = c.name.rsplit_once('.').unwrap_or(("", c.name));
    (path, name, c.unit)
}

fn best_rows(table: &PointTable, ranking: &[Ranked], sure: &[f64]) -> Vec<BestRow> {
    let shown: Vec<usize> = ranking.iter().take(BEST).map(|r| r.point).collect();
    let unbeaten = pareto::unbeaten(table, &shown);
    ranking
        .iter()
        .zip(unbeaten)
        .map(|(ranked, beaten_by_none)| {
            let Ranked {
                point: i,
                distance,
                binding,
            } = *ranked;
            let plain = |text| Cell {
                text,
                note: String::new(),
                bad: false,
                bar: None,
            };
            let parameters = table
                .parameters
                .iter()
                .map(|p| plain(number(p.values[i], 5)));
            let criteria = table.criteria.iter().map(|c| {
                let deviation = c.deviation(c.values[i]);
                Cell {
                    text: number(c.values[i], 5),
                    note: format!("{} of the tolerance", number(deviation, 2)),
                    bad: !c.ok[i],
                    bar: Some(
                        (deviation.min(1.5) * (c.values[i] - c.nominal).signum() * 100.0).round()
                            / 100.0,
                    ),
                }
            });
            BestRow {
                id: table.ids[i],
                verified: table.verified[i],
                distance: number(distance, 3),
                deviation: number(binding.deviation, 2),
                binding: table.criteria[binding.criterion].name.clone(),
                sure: percent(sure[i]),
                pareto: beaten_by_none,
                cells: parameters.chain(criteria).collect(),
            }
        })
        .collect()
}

fn histories(report: &Report) -> Vec<History> {
    let history = |s: &figures::Series| {
        Some(History {
            name: s.name.clone(),
            svg: figures::history(s)?,
            detail: s.last_periods().as_ref().and_then(figures::history),
        })
    };
    report.history.iter().filter_map(history).collect()
}

/// Reasons of failure, how often, and the first points of each.
fn failures(table: &PointTable) -> Vec<(String, String, String)> {
    const LISTED: usize = 12;
    let mut reasons: BTreeMap<&str, Vec<u64>> = BTreeMap::new();
    for i in (0..table.len()).filter(|&i| !table.completed(i)) {
        reasons
            .entry(&table.status[i])
            .or_default()
            .push(table.ids[i]);
    }
    let mut rows: Vec<_> = reasons.into_iter().collect();
    rows.sort_by_key(|(_, ids)| std::cmp::Reverse(ids.len()));
    rows.into_iter()
        .map(|(reason, ids)| {
            let mut list: Vec<String> = ids.iter().take(LISTED).map(u64::to_string).collect();
            if ids.len() > LISTED {
                list.push("…".into());
            }
            (reason.to_owned(), count(ids.len()), list.join(", "))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn data_cannot_end_its_script() {
        assert_eq!(script_safe("[\"</script>\"]"), "[\"\\u003c/script>\"]");
    }
}
