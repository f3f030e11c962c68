//! Whether the results of a study had settled: some points are run once more, longer and with finer communication steps.

use std::{
    path::Path,
    sync::{
        Mutex,
        atomic::{AtomicUsize, Ordering},
    },
    thread,
};

use super::{
    Halt, Reruns,
    finer::{golden, longer},
};
use crate::{
    judge::Criterion,
    report::history,
    results::{Summary, settled::Moved},
};
use fmu_points::{
    single::Recording,
    task::{Probe, Schedule, Task},
};
use result_document::format::number;
use rig_signals::motion::{Motion, motion};
use sampling::statistics::{Accumulator, Statistic, Trend};
use study::{
    concern::{Code, Concern},
    plan::Plan,
};

/// So many numbers are held at a time; more would only take memory.
const MOST_NUMBERS: u64 = 1 << 24;

/// How far the signals of a run move at the end of the study, by their criteria.
type Moves = Vec<(usize, Motion)>;

/// Adds to the summary whether the results had settled; says what is left out.
pub(super) fn observe(reruns: &Reruns<'_>, folder: &Path, summary: &mut Summary) -> Option<String> {
    // Where every point failed, that is told already.
    let mut settled = summary.settled.take().filter(|settled| !settled.points.is_empty())?;
    let most = reruns.wish.most.min(settled.points.len());
    let plan = reruns.plan();
    let (mut step, mut until, mut late) = (0.0_f64, 0.0_f64, false);
    let mut runs: Vec<(u64, Moves)> = Vec::new();
    for (point, run) in again(reruns, &settled.points[..most]) {
        match run {
            Ok(run) => {
                (step, until) = (step.max(run.step), until.max(run.until));
                // Each case has a run of its own.
                if settled.observed.last() != Some(&point) {
                    settled.observed.push(point);
                }
                runs.push((point, run.moves));
            }
            Err(halt) => {
                late |= matches!(halt, Halt::Late);
                settled.reason.get_or_insert(halt.to_string());
            }
        }
    }
    (settled.step, settled.until) = (step, until);
    if most == 0 {
        settled.reason = Some(if reruns.wish.dear {
            "the budget has no runs for it".to_owned()
        } else {
            "--extra-runs 0 asked for none".to_owned()
        });
    }
    if runs.is_empty() {
        let reason = settled.reason.as_deref().unwrap_or("no run was made");
        summary.concerns.push(Concern::new(
            Code::NotReRun,
            format!(
                "no point was re-run longer and finer, so whether results swing or had settled is not known: {reason}"
            ),
        ));
        let best = summary.best_point.as_ref().map(|best| best.point);
        runs.extend(best.map(|best| (best, recorded(plan, folder, summary))));
    }
    for (k, count) in summary.criteria.values().enumerate() {
        let mut moved = Moved::default();
        for (point, moves) in &runs {
            moves
                .iter()
                .filter(|(criterion, _)| *criterion == k)
                .for_each(|(_, Motion { swing, drift })| moved.add(*point, *swing, *drift));
        }
        summary.concerns.extend(concerns(&count.criterion, &moved, settled.observed.is_empty()));
        settled.criteria.insert(count.criterion.name.clone(), moved);
    }
    let left_out = late.then(|| {
        let (some, all) = (settled.observed.len(), most);
        format!("{some} of {all} points were re-run to see whether their results had settled")
    });
    summary.settled = Some(settled);
    left_out
}

/// A run that came at least as far as the study's end.
struct Again {
    step: f64,
    until: f64,
    moves: Moves,
}

/// Runs points once more in every case, in processes of their own, in the order in which they were chosen.
fn again(reruns: &Reruns<'_>, points: &[u64]) -> Vec<(u64, Result<Again, Halt>)> {
    let count = reruns.plan().cases.len().max(1);
    let numbers = (0..count).map(|case| {
        let schedule = reruns.plan().cases[case].task.schedule;
        let signals = reruns.plan().criteria_of(case).len() as u64;
        golden(&schedule).map_or(0, |finer| longer(&finer).steps() * (1 + signals))
    });
    let at_once = (MOST_NUMBERS / numbers.max().unwrap_or(0).max(1)).max(1);
    let workers = (at_once as usize).min(reruns.wish.jobs).min(points.len() * count);
    let (next, runs) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    let work = || {
        // Points of one case have the same worker.
        let mut recordings: Vec<Option<Recording>> = Vec::new();
        recordings.resize_with(count, || None);
        loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            let Some(&point) = points.get(number / count) else { return };
            let case = number % count;
            let run = one(reruns, point, case, &mut recordings[case]);
            let mut runs = runs.lock().expect("no thread fails while it holds the list");
            runs.push((number, (point, run)));
        }
    };
    thread::scope(|scope| {
        for _ in 0..workers {
            scope.spawn(work);
        }
    });
    let mut runs = runs.into_inner().expect("no thread fails while it holds the list");
    runs.sort_by_key(|(number, _)| *number);
    runs.into_iter().map(|(_, run)| run).collect()
}

/// Runs a point in one case with finer steps: on to a later end where the FMU allows it, else to its own.
fn one(reruns: &Reruns<'_>, point: u64, case: usize, recording: &mut Option<Recording>) -> Result<Again, Halt> {
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
    let mut failure = Halt::Late;
    for (place, schedule) in ends.into_iter().enumerate() {
        let task = Task { schedule, ..task.clone() };
        let mut later = None;
        let recording = match place {
            0 => &mut *recording,
            _ => &mut later,
        };
        if recording.is_none() {
            *recording = reruns.recording(&task);
        }
        let mut time = Vec::new();
        let mut columns = vec![Vec::new(); signals.criteria.len()];
        let ended =
            reruns.record(recording.as_mut(), &task, &values, &signals, Some(&reruns.budget), &mut |at, row| {
                time.push(at);
                for ((column, &value), &k) in columns.iter_mut().zip(row).zip(&signals.criteria) {
                    column.push(plan.outputs[k].value(value));
                }
                Ok(())
            });
        let until = time.last().copied().unwrap_or(f64::NEG_INFINITY);
        // Further than the study is enough where the FMU goes no further. A run that the clock cuts counts as none: it would
        // tell another drift each time.
        let is_late = matches!(ended, Err(Halt::Late));
        if ended.is_ok() || (!is_late && until >= finer.stop * (1.0 - 1e-9)) {
            let moves = signals
                .criteria
                .iter()
                .zip(&columns)
                .filter_map(|(&k, values)| Some((k, moves_of(plan, k, &time, values)?)));
            return Ok(Again { step: finer.step, until, moves: moves.collect() });
        }
        failure = match ended {
            Err(Halt::Failed(reason)) => {
                Halt::Failed(format!("with steps of {:.4} s the FMU fails: {reason}", finer.step))
            }
            _ => Halt::Late,
        };
        if let Halt::Late = failure {
            break;
        }
    }
    Err(failure)
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
    if signal.len() != time.len() || probe.has_own_times() {
        return None;
    }
    match probe.statistic.trend() {
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
            let later = (to >= schedule.stop).then(|| growth(time, signal, probe.statistic, [from, to]));
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
    let at = |point: Option<u64>| point.map(|p| format!(" at point {p}")).unwrap_or_default();
    let mut doubts = Vec::new();
    if *statistic == Statistic::Final && moved.swing > 0.1 * tolerance {
        doubts.push(Concern::new(Code::Swings, format!(
            "{name}: its signal swings by {}{unit} in its last period{}, and `final` takes one instant of it ({stated})",
            number(moved.swing, 3),
            at(moved.swing_at)
        )).remedied("Compare means where a signal swings (`statistic = \"mean\"` with a `window`)."));
    }
    if moved.drift.abs() > 0.5 * tolerance {
        doubts.push(Concern::new(Code::StillMoves, format!(
            "{name}: its value still moves when the run ends: in a run twice as long it {} by another {}{unit}{} ({stated})",
            if without_runs { "would change" } else { "changes" },
            number(moved.drift, 3),
            at(moved.drift_at)
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
        let of = |statistic, swing, drift| {
            let mut moved = Moved::default();
            moved.add(7, swing, drift);
            concerns(&criterion(statistic), &moved, false)
        };
        assert!(of(Statistic::Final, 0.05, 0.2).is_empty());
        let doubts = of(Statistic::Final, 0.07, -0.4);
        assert!(doubts[0].text.starts_with("T: its signal swings by 0.07"), "{doubts:?}");
        assert!(
            doubts[1]
                .text
                .contains("in a run twice as long it changes by another −0.4 degC at point 7 (tolerance 0.6 degC)"),
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
