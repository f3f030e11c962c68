//! Whether the best point's values had settled: it is run once more, longer and with finer communication steps.

use std::path::Path;

use super::{
    Halt, Reruns,
    finer::{golden, longer},
};
use crate::{
    report::history,
    results::{
        Summary,
        settled::{Moved, Settled},
    },
};
use fmu_points::task::{Probe, Schedule, Task};
use result_document::format::number;
use rig_signals::motion::{Motion, motion};
use sampling::statistics::{Accumulator, Statistic, Trend};
use study::{
    concern::{Code, Concern},
    judge::Criterion,
    plan::Plan,
};

/// So many numbers are held at a time; more would only take memory.
const MOST_NUMBERS: u64 = 1 << 24;

/// How far the signals of a run move at the end of the study, by their criteria.
type Moves = Vec<(usize, Motion)>;

/// Adds to the summary whether the best point's values had settled; says what is left out.
pub fn observe(reruns: &Reruns, folder: &Path, summary: &mut Summary) -> Option<String> {
    // Where every point failed, that is told already.
    let point = summary.best_point.as_ref()?.point;
    let mut settled = Settled { point, ..Settled::default() };
    let none = |reason: &str| Err(Halt::Failed(reason.to_owned()));
    let runs: Result<Vec<Again>, Halt> = match (reruns.wish.most, reruns.wish.dear) {
        (0, true) => none("the budget has no runs for it"),
        (0, false) => none("--extra-runs 0 asked for none"),
        _ => (0..reruns.plan().cases.len()).map(|case| again(reruns, point, case)).collect(),
    };
    let (mut moves, mut left_out) = (Moves::new(), None);
    match runs {
        Ok(runs) => {
            for run in runs {
                settled.step = Some(settled.step.unwrap_or(0.0).max(run.step));
                settled.until = Some(settled.until.unwrap_or(0.0).max(run.until));
                moves.extend(run.moves);
            }
        }
        Err(halt) => {
            let text = "the best point was not re-run longer and finer";
            left_out = (!matches!(halt, Halt::Failed(_))).then(|| format!("{text}: {halt}"));
            summary.concerns.push(Concern::new(
                Code::NotReRun,
                format!("{text}, so whether results swing or had settled is not known: {halt}"),
            ));
            moves = recorded(reruns.plan(), folder, summary);
        }
    }
    moves.sort_by_key(|(k, _)| *k);
    for (k, motion) in moves {
        let count = &summary.criteria[k];
        let moved = Moved::new(motion);
        summary.concerns.extend(concerns(&count.criterion, &moved, settled.until.is_none()));
        settled.criteria.insert(count.criterion.name.clone(), moved);
    }
    summary.settled = Some(settled);
    left_out
}

/// A run that came at least as far as the study's end.
struct Again {
    step: f64,
    until: f64,
    moves: Moves,
}

/// Runs a point in one case with finer steps: on to a later end where the FMU allows it, else to its own.
fn again(reruns: &Reruns, point: u64, case: usize) -> Result<Again, Halt> {
    let failed = |reason: &str| Halt::Failed(reason.to_owned());
    let plan = reruns.plan();
    let values = reruns.values(point).ok_or_else(|| failed("the study has no such point any more"))?;
    let task = &plan.cases[case].task;
    let signals = reruns.signals(case, |_| true);
    let finer = golden(&task.schedule)
        .filter(|finer| (finer.steps() * (1 + signals.criteria.len() as u64)) < MOST_NUMBERS)
        .ok_or_else(|| failed("the study's communication steps are too many to be made finer"))?;
    // After the end of a recording its last value would hold for ever.
    let ends = if task.inputs.is_empty() { vec![longer(&finer), finer] } else { vec![finer] };
    let mut failure = String::new();
    for schedule in ends {
        let task = Task { schedule, ..task.clone() };
        let mut time = Vec::new();
        let mut columns = vec![Vec::new(); signals.criteria.len()];
        let ended = reruns.record(&task, &values, &signals, Some(&reruns.budget), &mut |at, row| {
            time.push(at);
            for ((column, &value), &k) in columns.iter_mut().zip(row).zip(&signals.criteria) {
                column.push(plan.outputs[k].value(value));
            }
            Ok(())
        });
        let until = time.last().copied().unwrap_or(task.schedule.start);
        let end = match ended {
            Ok(()) => format!("ends at {} s", number(until, 4)),
            Err(Halt::Failed(reason)) => format!("fails: {reason}"),
            // It would tell another drift each time.
            Err(cut) => return Err(cut),
        };
        // Further than the study is enough where the FMU goes no further.
        if until >= finer.stop * (1.0 - 1e-9) {
            let moves = signals
                .criteria
                .iter()
                .zip(&columns)
                .filter_map(|(&k, values)| Some((k, moves_of(plan, k, &time, values)?)));
            return Ok(Again { step: finer.step, until, moves: moves.collect() });
        }
        failure = format!("with steps of {:.4} s the FMU {end}", finer.step);
    }
    Err(Halt::Failed(failure))
}

/// How far the best point's signals move as its trajectories show it, where these were recorded.
fn recorded(plan: &Plan, folder: &Path, summary: &Summary) -> Moves {
    let mut moves = Vec::new();
    for (time, signals) in history::trajectories(folder) {
        for (name, values) in signals {
            let criterion = summary.criteria.get_index_of(&name);
            moves.extend(criterion.and_then(|k| Some((k, moves_of(plan, k, &time, &values)?))));
        }
    }
    moves
}

fn moves_of(plan: &Plan, criterion: usize, time: &[f64], signal: &[f64]) -> Option<Motion> {
    let (case, probe) = plan.placed_probes().nth(criterion)?;
    moves(time, signal, plan.cases[case].task.schedule, probe)
}

/// The motion of a criterion's value at the end of its window.
fn moves(time: &[f64], signal: &[f64], schedule: Schedule, probe: &Probe) -> Option<Motion> {
    let [from, to] = probe.window.unwrap_or([schedule.window_start, schedule.stop]);
    let run = [schedule.start, to];
    if signal.len() != time.len() || probe.measure.has_own_times() {
        return None;
    }
    let statistic = probe.measure.statistic()?;
    match statistic.trend() {
        Trend::Unknown => None,
        Trend::OfSignal => {
            let mut motion = motion(time, signal, run)?;
            // At a moment of its own, a value may be on its way.
            if to < schedule.stop {
                motion.drift = 0.0;
            }
            Some(motion)
        }
        Trend::OfExtremes => {
            let later = (to >= schedule.stop).then(|| growth(time, signal, statistic, [from, to]));
            Some(Motion { swing: 0.0, drift: later.flatten().unwrap_or(0.0) * (to - schedule.start) })
        }
    }
}

/// The rate at which an extreme value still grows after a window, or, where nothing is known of that, in its last fifth.
fn growth(time: &[f64], signal: &[f64], statistic: Statistic, [from, to]: [f64; 2]) -> Option<f64> {
    const PART: f64 = 0.2;
    let rounding = 1e-9 * (from.abs() + to.abs());
    let last = *time.last()?;
    let [first, end] = if last > to + rounding { [to, last] } else { [to - PART * (to - from), to] };
    let mut accumulator = Accumulator::new(statistic);
    let mut before = None;
    for (&t, &value) in time.iter().zip(signal).filter(|(t, _)| **t >= from - rounding) {
        if t > first + rounding && before.is_none() {
            before = Some(accumulator.result(first - from));
        }
        accumulator.add(0.0, value);
    }
    let grown = accumulator.result(end - from) - before?;
    (end > first && grown.is_finite()).then(|| grown / (end - first))
}

/// The meaning of a motion for the number that is compared with the measured value. Without extra runs the drift is that
/// at the rate of the end.
fn concerns(criterion: &Criterion, moved: &Moved, without_runs: bool) -> Vec<Concern> {
    let Criterion { name, statistic, .. } = criterion;
    let (tolerance, stated) = (criterion.room(), criterion.allowed());
    let unit = criterion.unit_behind();
    let mut doubts = Vec::new();
    if *statistic == Statistic::Final && moved.swing > 0.1 * tolerance {
        doubts.push(Concern::new(Code::Swings, format!(
            "{name}: its signal swings by {}{unit} in its last period, and `final` takes one instant of it ({stated})",
            number(moved.swing, 3)
        )).remedied("Compare means where a signal swings (`statistic = \"mean\"` with a `window`)."));
    }
    if moved.drift.abs() > 0.5 * tolerance {
        doubts.push(Concern::new(Code::StillMoves, format!(
            "{name}: its value still moves when the run ends: in a run twice as long it {} by another {}{unit} ({stated})",
            if without_runs { "would change" } else { "changes" },
            number(moved.drift, 3)
        )).remedied("Simulate to the moment of the measurement, or until the values rest (`stop`)."));
    }
    doubts
}

#[cfg(test)]
mod tests {
    use super::*;

    fn criterion(statistic: Statistic) -> Criterion {
        Criterion {
            name: "T".into(),
            variable: "t".into(),
            statistic,
            unit: Some("degC".into()),
            limits: conformity::measured::Limits::within(82.0, 0.6),
            stated_tolerance: "0.6 degC".into(),
            ..Criterion::default()
        }
    }

    #[test]
    fn swing_and_drift_count_against_the_tolerance() {
        let of = |statistic, swing, drift| concerns(&criterion(statistic), &Moved { swing, drift }, false);
        assert!(of(Statistic::Final, 0.05, 0.2).is_empty());
        let doubts = of(Statistic::Final, 0.07, -0.4);
        assert!(doubts[0].text.starts_with("T: its signal swings by 0.07"), "{doubts:?}");
        assert!(
            doubts[1].text.contains("in a run twice as long it changes by another −0.4 degC (tolerance 0.6 degC)"),
            "{doubts:?}"
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
