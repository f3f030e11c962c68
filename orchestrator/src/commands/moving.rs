//! Whether the values that were compared had come to rest: seen on extra runs of some points.

use std::path::Path;

use super::CommandError;
use super::extra::{Extra, Watched};
use crate::analysis::motion::{Motion, motion};
use crate::judge::Criterion;
use crate::report::format::number;
use crate::report::history;
use crate::results::rest::Moved;
use crate::results::{Summary, write_atomically};
use crate::study::plan::Plan;
use crate::task::{Probe, Schedule};
use sampling::statistics::{Accumulator, Statistic, Trend};

/// The summary with what the extra runs tell of swing and drift, which is written again.
pub(super) fn observed(
    folder: &Path,
    summary: &Summary,
    plan: &Plan,
    extra: Extra,
) -> Result<Summary, CommandError> {
    let mut summary = summary.clone();
    // Where every point failed, that is told already.
    let Some(mut rest) = summary.rest.take().filter(|rest| !rest.points.is_empty()) else {
        return Ok(summary);
    };
    rest.observed = extra.runs.iter().map(|run| run.point).collect();
    // Each case has a run of its own.
    rest.observed.dedup();
    rest.step = extra.step;
    let ends = extra.runs.iter().filter_map(|run| run.time.last());
    rest.until = ends.copied().fold(0.0, f64::max);
    rest.reason = extra.reason;
    let mut runs = extra.runs;
    if runs.is_empty() {
        let reason = rest.reason.as_deref().unwrap_or("no run was made");
        summary.concerns.push(format!(
            "whether values swing between the communication points, or still move at the end of the run, was not \
             observed on extra runs: {reason}"
        ));
        runs.extend(recorded(folder, &summary));
    }
    let judged: Vec<&Criterion> = summary.criteria.values().map(|c| &c.criterion).collect();
    for (k, criterion) in judged.iter().enumerate() {
        let mut moved = Moved::default();
        for run in &runs {
            let found = run
                .signals
                .get(k)
                .zip(plan.placed_probes().nth(k))
                .and_then(|(signal, (case, probe))| {
                    moves(&run.time, signal, plan.cases[case].task.schedule, probe)
                });
            if let Some(Motion { swing, drift }) = found {
                moved.add(run.point, swing, drift);
            }
        }
        rest.criteria.insert(criterion.name.clone(), moved);
    }
    let found: Vec<String> = judged
        .iter()
        .filter_map(|criterion| {
            let moved = rest.criteria.get(&criterion.name)?;
            Some(concerns(criterion, moved, rest.observed.is_empty()))
        })
        .flatten()
        .collect();
    summary.concerns.extend(found);
    summary.rest = Some(rest);
    write_atomically(&folder.join("summary.json"), |out| {
        serde_json::to_writer_pretty(&mut *out, &summary)?;
        writeln!(out)
    })?;
    Ok(summary)
}

/// The best point's trajectories as the page shows them, one a case, where they were recorded.
fn recorded(folder: &Path, summary: &Summary) -> Vec<Watched> {
    let Some(best) = &summary.best_point else {
        return Vec::new();
    };
    let watched = |(time, mut signals): history::Trajectory| {
        let signal = |name: &String| {
            let found = signals.iter_mut().find(|(other, _)| other == name);
            found.map_or_else(Vec::new, |(_, values)| std::mem::take(values))
        };
        Watched {
            point: best.point,
            signals: summary.criteria.keys().map(signal).collect(),
            time,
        }
    };
    history::trajectories(folder)
        .into_iter()
        .map(watched)
        .collect()
}

/// The motion of a criterion's value at the end of its window.
fn moves(time: &[f64], signal: &[f64], schedule: Schedule, probe: &Probe) -> Option<Motion> {
    let [from, to] = probe
        .window
        .unwrap_or([schedule.window_start, schedule.stop]);
    let run = [schedule.start, to];
    if signal.len() != time.len() || probe.has_own_times() {
        return None;
    }
    match probe.statistic.trend() {
        Trend::Unknown => None,
        Trend::OfSignal => {
            let mut found = motion(time, signal, run)?;
            // At a moment of its own, a value may be on its way.
            if to < schedule.stop {
                found.drift = 0.0;
            }
            Some(found)
        }
        Trend::OfExtremes => {
            let later =
                (to >= schedule.stop).then(|| growth(time, signal, probe.statistic, [from, to]));
            Some(Motion {
                swing: 0.0,
                drift: later.flatten().unwrap_or(0.0) * (to - schedule.start),
            })
        }
    }
}

/// The rate at which an extreme value still grows after a window, or, where nothing is known of that, in its last fifth.
fn growth(time: &[f64], signal: &[f64], statistic: Statistic, [from, to]: [f64; 2]) -> Option<f64> {
    const PART: f64 = 0.2;
    let rounding = 1e-9 * (from.abs() + to.abs());
    let last = *time.last()?;
    let [first, end] = if last > to + rounding {
        [to, last]
    } else {
        [to - PART * (to - from), to]
    };
    let mut accumulator = Accumulator::new(statistic);
    let mut before = None;
    for (&t, &value) in time
        .iter()
        .zip(signal)
        .filter(|(t, _)| **t >= from - rounding)
    {
        if t > first + rounding && before.is_none() {
            before = Some(accumulator.result(first - from));
        }
        accumulator.add(0.0, value);
    }
    let grown = accumulator.result(end - from) - before?;
    (end > first && grown.is_finite()).then(|| grown / (end - first))
}

/// What a motion means for the number that is compared with the measured value. Without extra runs the drift is that at
/// the rate of the end.
fn concerns(criterion: &Criterion, moved: &Moved, without_runs: bool) -> Vec<String> {
    let Criterion {
        name,
        statistic,
        tolerance,
        stated_tolerance,
        ..
    } = criterion;
    let unit = criterion
        .unit
        .as_deref()
        .map_or_else(String::new, |unit| format!(" {unit}"));
    let at = |point: Option<u64>| point.map_or_else(String::new, |p| format!(" at point {p}"));
    let mut found = Vec::new();
    if *statistic == Statistic::Final && moved.swing > 0.1 * tolerance {
        found.push(format!(
            "{name}: its signal swings by {}{unit} in its last period{}, and the final value is only one instant of it \
             (tolerance {stated_tolerance}): use `statistic = \"mean\"` with a `window`, or make sure that the \
             measured value was taken at the same phase",
            number(moved.swing, 3),
            at(moved.swing_at)
        ));
    }
    if moved.drift.abs() > 0.5 * tolerance {
        found.push(format!(
            "{name}: its value still moves when the run ends, by {}{unit} in a time as long as the run{}{} (tolerance \
             {stated_tolerance}), so the verdict depends on `stop`: simulate longer, or up to the moment of the \
             measurement",
            number(moved.drift, 3),
            if without_runs { ", at the rate of its end" } else { "" },
            at(moved.drift_at)
        ));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn criterion(statistic: Statistic) -> Criterion {
        Criterion {
            name: "T".into(),
            variable: "t".into(),
            statistic,
            detail: None,
            level: None,
            metric: None,
            row_correlation: None,
            unit: Some("degC".into()),
            nominal: 82.0,
            tolerance: 0.6,
            stated_tolerance: "0.6 degC".into(),
            uncertainty: None,
            group: None,
        }
    }

    #[test]
    fn swing_and_drift_count_against_the_tolerance() {
        let of = |statistic, swing, drift| {
            let mut moved = Moved::default();
            moved.add(7, swing, drift);
            concerns(&criterion(statistic), &moved, false)
        };
        assert!(of(Statistic::Final, 0.05, 0.2).is_empty());
        let found = of(Statistic::Final, 0.07, -0.4);
        assert!(
            found[0].starts_with("T: its signal swings by 0.07"),
            "{found:?}"
        );
        assert!(
            found[1].contains("0.4 degC in a time as long as the run at point 7"),
            "{found:?}"
        );
        assert_eq!(of(Statistic::Mean, 0.07, -0.4).len(), 1);
        assert!(of(Statistic::Amplitude, 0.07, 0.2).is_empty());
    }

    /// The greatest value of 2 t after a second grows by 2 a second; that of a swing does not grow.
    #[test]
    fn an_extreme_value_that_grows_is_found() {
        let time: Vec<f64> = (0..=2000).map(|k| f64::from(k) * 1e-3).collect();
        let of = |signal: &dyn Fn(f64) -> f64, statistic, until: usize| {
            let values: Vec<f64> = time.iter().map(|&t| signal(t)).collect();
            growth(&time[..=until], &values[..=until], statistic, [0.2, 1.0]).unwrap()
        };
        let rise = |t: f64| 2.0 * t;
        for until in [1000, 2000] {
            assert!((of(&rise, Statistic::Max, until) - 2.0).abs() < 0.02);
            assert!((of(&rise, Statistic::Amplitude, until) - 1.0).abs() < 0.02);
            assert_eq!(of(&rise, Statistic::Min, until), 0.0);
            let swing = |t: f64| (20.0 * t).sin();
            assert!(of(&swing, Statistic::Max, until).abs() < 1e-3);
        }
    }
}
