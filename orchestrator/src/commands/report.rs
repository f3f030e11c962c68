//! `report`: the page that tells the result of a study.

use std::fs;
use std::path::Path;
use std::process::ExitCode;
use std::time::Duration;

use super::{CommandError, output};
use crate::cli;
use crate::engine::process::Limits;
use crate::engine::trajectory::Recorder;
use crate::fmu::{Package, Value};
use crate::report::{Report, history};
use crate::results::summary::{BestPoint, Summary};
use crate::results::{ResultsError, write_atomically};
use crate::study::Study;
use crate::study::plan::Plan;
use crate::task::{Column, Content, Schedule, Storage, Task};

/// What the best point's trajectory may use: the point itself has come to its end before.
const LIMITS: Limits = Limits {
    time: Duration::from_secs(60),
    memory: 16 << 30,
};

pub(super) fn run(options: &cli::Report) -> Result<ExitCode, CommandError> {
    let report = Report::from_folder(&options.folder)?;
    let page = report.write(&options.folder)?;
    if options.png {
        report.write_png(&options.folder)?;
    }
    output::print(&format!("{}\n", page.display()));
    Ok(ExitCode::SUCCESS)
}

/// Completes a folder of results: the study's text, the best point's trajectory, the page.
pub(super) fn complete(
    folder: &Path,
    study: &Study,
    plan: &Plan,
    package: &Package,
    summary: &Summary,
) -> Result<(), CommandError> {
    keep_study(folder, study)?;
    let trajectory = folder.join(history::FILE);
    // A failure here takes nothing away from the verdict: the page then shows no trajectory.
    let recorded = summary
        .best_point
        .as_ref()
        .map(|best| record(best, plan, package))
        .transpose();
    match recorded {
        Ok(Some(text)) => fs::write(&trajectory, text).map_err(ResultsError::io(&trajectory))?,
        other => {
            let _ = fs::remove_file(&trajectory);
            if let Err(error) = other {
                eprintln!("note: the page shows no trajectory of the best point: {error}");
            }
        }
    }
    Report::from_folder(folder)?.write(folder)?;
    Ok(())
}

/// Keeps the study beside its results.
pub(super) fn keep_study(folder: &Path, study: &Study) -> Result<(), CommandError> {
    let path = folder.join("study.toml");
    write_atomically(&path, |out| out.write_all(study.text().as_bytes()))?;
    Ok(())
}

/// The best point's criteria over time, as a table.
fn record(best: &BestPoint, plan: &Plan, package: &Package) -> Result<String, CommandError> {
    let parameters: Vec<f64> = best.parameters.values().copied().collect();
    let mut values = Vec::new();
    plan.to_fmu(&parameters, &mut values);
    let task = Task {
        schedule: fine(plan.task.schedule),
        ..plan.task.clone()
    };
    let probes: Vec<usize> = (0..task.observed.len())
        .filter(|&k| task.observed[k].storage == Storage::Real)
        .collect();
    let column = |&k: &usize| Column {
        reference: task.observed[k].reference,
        content: Content::Real,
    };
    let columns: Vec<Column> = probes.iter().map(column).collect();
    let names: Vec<&String> = best.values.keys().collect();
    let mut text = String::from("time");
    probes.iter().for_each(|&k| {
        text.push(',');
        text.push_str(names[k]);
    });
    text.push('\n');
    let scratch = tempfile::tempdir().map_err(ResultsError::io(&std::env::temp_dir()))?;
    // The run's own copy of the FMU may be gone by now.
    let mut own = Package::open(package.path())?;
    let fmu = own.unpack(scratch.path())?;
    let recorder = Recorder {
        fmu: &fmu,
        name: package.path(),
        scratch: scratch.path(),
        limits: LIMITS,
        echo: false,
    };
    recorder.record(&task, &values, &columns, |time, row| {
        text.push_str(&time.to_string());
        for (value, &k) in row.iter().zip(&probes) {
            let Value::Real(value) = value else { continue };
            text.push_str(&format!(",{:.7e}", plan.outputs[k].value(*value)));
        }
        text.push('\n');
        Ok::<_, CommandError>(())
    })?;
    Ok(text)
}

/// Communication points close enough to see what happens between the study's.
fn fine(schedule: Schedule) -> Schedule {
    const ENOUGH: f64 = 15_000.0;
    let step = (schedule.stop - schedule.start) / ENOUGH;
    Schedule {
        step: schedule.step.min(step),
        ..schedule
    }
}
