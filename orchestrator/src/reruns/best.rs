//! The best point's trajectory, for its picture on the page.

use std::{fs, path::Path};

use super::{Budget, Halt, Reruns, finer::for_a_plot};
use crate::{report::history, results::Summary};
use fmu_points::task::Task;
use number_tables::csv_file;
use point_journal::files::write_atomically;
use result_document::format;

/// So many numbers a file holds at the most, more or less: of more communication points some are left out.
const MOST_NUMBERS: u64 = 1_000_000;

/// Writes the trajectory, a file a case; says what is left out. A failure here takes nothing away from the verdict.
pub fn write(reruns: &Reruns, folder: &Path, summary: &Summary) -> Vec<String> {
    let plan = reruns.plan();
    // An earlier run may have left files, which are of another point or of another case.
    for case in std::iter::once(None).chain((0..plan.cases.len()).map(Some)) {
        let _ = fs::remove_file(folder.join(history::file(case)));
    }
    let Some(best) = &summary.best_point else { return Vec::new() };
    let Some(values) = reruns.values(best.point) else {
        return vec![format!("the study has no point {} any more", best.point)];
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
    // Half of the time is for the other points that run again.
    let budget = reruns.budget.part(0.5);
    for (number, case) in plan.cases.iter().enumerate() {
        let file = history::file(case.name.as_ref().map(|_| number));
        let write = |schedule, budget: Option<&Budget>| {
            let task = Task { schedule, ..case.task.clone() };
            write_case(reruns, number, &task, &values, &shown, budget, &folder.join(&file))
        };
        let schedule = case.task.schedule;
        let finer = Some(for_a_plot(schedule)).filter(|finer| *finer != schedule && !reruns.wish.dear);
        let share = budget.part(1.0 / (plan.cases.len() - number) as f64);
        let in_time = finer.map(|finer| write(finer, Some(&share)));
        // A picture is never for want of time missing: with the study's own steps it takes as long as the point did.
        let (written, why) = match in_time {
            Some(Err(halt)) => (write(schedule, None), Some(halt)),
            Some(written) => (written, None),
            None => (write(schedule, None), None),
        };
        match written {
            Ok(kept) => {
                left_out.extend(why.map(|why| {
                    let why = match why {
                        Halt::Failed(reason) => format!("the FMU fails in finer ones: {reason}"),
                        cut => format!("with finer ones {cut}"),
                    };
                    format!("{file} holds the study's own steps: {why}")
                }));
                left_out.extend(kept.map(|every| format!("{file} holds one of {every} communication points")));
            }
            Err(halt) => left_out.push(format!("no trajectory of the best point in {file}: {halt}")),
        }
    }
    left_out
}

/// Writes the trajectory of one case; where only some communication points are kept, one of how many.
fn write_case(
    reruns: &Reruns,
    case: usize,
    task: &Task,
    values: &[f64],
    shown: &[usize],
    budget: Option<&Budget>,
    path: &Path,
) -> Result<Option<u64>, Halt> {
    let plan = reruns.plan();
    let signals = reruns.signals(case, |criterion| shown.binary_search(&criterion).is_ok());
    let steps = task.schedule.steps();
    let every = steps.div_ceil(MOST_NUMBERS / (1 + signals.criteria.len() as u64));
    let names = &reruns.verification.session.judge.criteria;
    let names = signals.criteria.iter().map(|&k| csv_file::cell(&names[k].name));
    let head: Vec<_> = std::iter::once("time".into()).chain(names).collect();
    let mut halt = None;
    let written = write_atomically(path, |out| {
        let mut table = csv::Writer::from_writer(out);
        table.write_record(head.iter().map(|name| name.as_bytes()))?;
        let mut number = zmij::Buffer::new();
        let mut place = 0;
        let mut until = task.schedule.start;
        let ended = reruns.record(task, values, &signals, budget, &mut |time, row| {
            until = time;
            let kept = place % every == 0 || place == steps;
            place += 1;
            if !kept {
                return Ok(());
            }
            table.write_field(number.format(time))?;
            for (&value, &k) in row.iter().zip(&signals.criteria) {
                let value = plan.outputs[k].value(value);
                // Seven digits are plenty for a plot, but for a number that so short a one cannot hold.
                let short = value as f32;
                let text = if short.is_finite() { number.format(short) } else { number.format(value) };
                table.write_field(text)?;
            }
            Ok(table.write_record(None::<&[u8]>)?)
        });
        // With the study's own steps the point may have ended early, too.
        let early = (budget.is_some() && until < task.schedule.stop * (1.0 - 1e-9))
            .then(|| Halt::Failed(format!("it ends at {} s", format::number(until, 4))));
        if let Some(why) = ended.err().or(early) {
            halt = Some(why);
            return Err(std::io::Error::other("the run has no end"));
        }
        table.flush()
    });
    match (written, halt) {
        (Ok(()), _) => Ok((every > 1).then_some(every)),
        (Err(_), Some(halt)) => Err(halt),
        (Err(error), None) => Err(error.into()),
    }
}
