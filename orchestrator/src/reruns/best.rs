//! The best point once more: longer and with finer communication steps, to see whether its values had settled, and for its
//! picture on the page; with the study's own steps where there is no time for that, or the FMU takes no finer ones.

use std::{fs, path::Path};

use super::{
    Budget, Halt, Reruns, Signals,
    finer::{golden, longer},
    settled::{Moves, concerns, moves_of},
};
use crate::{
    report::history,
    results::{
        Summary,
        points::number,
        settled::{Moved, Settled},
    },
};
use fmu_points::task::{Schedule, Task};
use point_journal::files::write_table;
use study::concern::{Code, Concern};

/// So many numbers are held at a time: of more communication points some are left out.
const HELD: u64 = 1 << 24;

/// So many a file holds at the most, more or less.
const WRITTEN: usize = 1_000_000;

/// A run of the best point in one case.
struct Run {
    schedule: Schedule,
    signals: Signals,
    /// Of so many communication points one is held.
    every: usize,
    time: Vec<f64>,
    /// A column a signal, in the criteria's units.
    columns: Vec<Vec<f64>>,
}

/// Adds to the summary whether the best point's values had settled, and writes its trajectory, a file a case; says what is left
/// out. A failure here takes nothing away from the verdict.
pub fn observe(reruns: &Reruns<'_>, folder: &Path, summary: &mut Summary) -> Vec<String> {
    let plan = reruns.plan();
    // An earlier run may have left files, which are of another point or of another case.
    [history::file(None), history::file(Some(0))]
        .into_iter()
        .chain((1..plan.cases.len()).map(|case| history::file(Some(case))))
        .for_each(|file| drop(fs::remove_file(folder.join(file))));
    // Where every point failed, that is told already.
    let Some(point) = summary.best_point.as_ref().map(|best| best.point) else { return Vec::new() };
    let Some(values) = reruns.values(point) else {
        return vec![format!("the study has no point {point} any more")];
    };
    let shown = summary.pictured();
    let mut left_out = Vec::new();
    if shown.len() < summary.criteria.len() {
        left_out.push(format!(
            "the best point's trajectory shows the {} criteria that the fewest points meet, of {}",
            shown.len(),
            summary.criteria.len()
        ));
    }
    let none = |reason: &str| Some(Halt::Failed(reason.to_owned()));
    let mut why = match (reruns.wish.most, reruns.wish.dear) {
        (0, true) => none("the budget has no runs for it"),
        (0, false) => none("--extra-runs 0 asked for none"),
        _ => None,
    };
    let is_asked = why.is_none();
    let mut settled = Settled { point, ..Settled::default() };
    let mut moves = Moves::new();
    for (number, case) in plan.cases.iter().enumerate() {
        let file = history::file(case.name.as_ref().map(|_| number));
        let further = match why {
            Some(_) => None,
            None => further(reruns, number, &values).map_err(|halt| why = Some(halt)).ok(),
        };
        let run = match further {
            Some(run) => {
                let later = |known: Option<f64>, new: f64| Some(known.unwrap_or(0.0).max(new));
                settled.step = later(settled.step, run.schedule.step);
                settled.until = later(settled.until, run.time.last().copied().unwrap_or_default());
                Ok(run)
            }
            // A picture is never missing for want of time: with the study's own steps it takes as long as the point did.
            None => {
                left_out.extend(
                    why.iter()
                        .filter(|_| is_asked)
                        .map(|why| format!("{file} holds the study's own steps: with finer ones {why}")),
                );
                let (run, ended) = record(reruns, number, case.task.schedule, &values, None);
                ended.map(|()| run)
            }
        };
        let written = run.and_then(|run| {
            let of_signals = run.signals.criteria.iter().zip(&run.columns);
            moves.extend(of_signals.filter_map(|(&k, signal)| Some((k, moves_of(plan, k, &run.time, signal)?))));
            write(&run, &shown, (case.task.schedule.stop, summary), &folder.join(&file))
        });
        match written {
            Ok(1) => {}
            Ok(every) => left_out.push(format!("{file} holds one of {every} communication points")),
            Err(halt) => left_out.push(format!("no trajectory of the best point in {file}: {halt}")),
        }
    }
    if let Some(halt) = why {
        (settled.step, settled.until) = (None, None);
        let text = "the best point was not re-run longer and finer";
        left_out.extend(matches!(halt, Halt::Late).then(|| format!("{text}: {halt}")));
        summary.concerns.push(Concern::new(
            Code::NotReRun,
            format!("{text}, so whether results swing or had settled is not known: {halt}"),
        ));
    }
    for (k, count) in summary.criteria.values().enumerate() {
        let motion = moves.iter().find(|(criterion, _)| *criterion == k).map(|(_, motion)| *motion);
        let moved = Moved::new(motion.unwrap_or_default());
        summary.concerns.extend(concerns(&count.criterion, &moved, settled.until.is_none()));
        settled.criteria.insert(count.criterion.name.clone(), moved);
    }
    summary.settled = Some(settled);
    left_out
}

/// Runs a point in one case; hands over what it has recorded, and how that ended.
fn record(
    reruns: &Reruns<'_>,
    case: usize,
    schedule: Schedule,
    values: &[f64],
    budget: Option<&Budget>,
) -> (Run, Result<(), Halt>) {
    let plan = reruns.plan();
    let signals = reruns.signals(case);
    let task = Task { schedule, ..plan.cases[case].task.clone() };
    let every = held(&schedule, &signals).div_ceil(HELD).max(1) as usize;
    let (mut time, mut columns) = (Vec::new(), vec![Vec::new(); signals.criteria.len()]);
    let mut place = 0;
    let ended = reruns.record(&task, values, &signals, budget, &mut |at, row| {
        if place % every == 0 || place as u64 == schedule.steps() {
            time.push(at);
            for ((column, &value), &k) in columns.iter_mut().zip(row).zip(&signals.criteria) {
                column.push(plan.outputs[k].value(value));
            }
        }
        place += 1;
    });
    (Run { schedule, signals, every, time, columns }, ended)
}

/// How many numbers a run records.
fn held(schedule: &Schedule, signals: &Signals) -> u64 {
    schedule.steps() * (1 + signals.criteria.len() as u64)
}

/// Runs a point in one case with finer steps: on to a later end where the FMU allows it, else to its own.
fn further(reruns: &Reruns<'_>, case: usize, values: &[f64]) -> Result<Run, Halt> {
    let task = &reruns.plan().cases[case].task;
    let finer = golden(&task.schedule)
        .filter(|finer| held(finer, &reruns.signals(case)) < HELD)
        .ok_or_else(|| Halt::Failed("there are too many".to_owned()))?;
    // After the end of a recording its last value would hold for ever.
    let ends = if task.inputs.is_empty() { vec![longer(&finer), finer] } else { vec![finer] };
    let mut failure = Halt::Late;
    for schedule in ends {
        let (run, ended) = record(reruns, case, schedule, values, Some(&reruns.budget));
        let until = run.time.last().copied().unwrap_or(f64::NEG_INFINITY);
        failure = match ended {
            Ok(()) => return Ok(run),
            // A run that the clock cuts counts as none: it would tell another drift each time.
            Err(Halt::Late) => return Err(Halt::Late),
            // Further than the study is enough where the FMU goes no further.
            Err(_) if until >= finer.stop * (1.0 - 1e-9) => return Ok(run),
            Err(Halt::Failed(reason)) => Halt::Failed(format!("(of {:.4} s) the FMU fails: {reason}", finer.step)),
        };
    }
    Err(failure)
}

/// Writes the trajectory of a case up to the study's end; of how many communication points it holds one.
fn write(run: &Run, shown: &[usize], (stop, summary): (f64, &Summary), path: &Path) -> Result<usize, Halt> {
    let is_shown = |(k, _): &(&usize, &Vec<f64>)| shown.binary_search(k).is_ok();
    let (criteria, columns): (Vec<usize>, Vec<&Vec<f64>>) =
        run.signals.criteria.iter().zip(&run.columns).filter(is_shown).unzip();
    let names = criteria.iter().filter_map(|&k| Some(&**summary.criteria.get_index(k)?.0));
    let rows = run.time.partition_point(|time| *time <= stop + 1e-9 * stop.abs());
    let every = (rows * (1 + columns.len())).div_ceil(WRITTEN).max(1);
    let written = write_table(path, std::iter::once("time").chain(names), |table| {
        for row in (0..rows).filter(|row| row % every == 0 || row + 1 == rows) {
            table.write_field(number(run.time[row]))?;
            // Seven digits are plenty for a plot, but for a number that so short a one cannot hold.
            let short = |value: f64| match value as f32 {
                short if short.is_finite() => short.to_string(),
                _ => number(value),
            };
            table.write_record(columns.iter().map(|column| short(column[row])))?;
        }
        Ok(())
    });
    written.map(|()| every * run.every).map_err(|error| Halt::Failed(error.to_string()))
}
