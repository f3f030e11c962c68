//! `report`: the page that tells the result of a study.

use std::fs;
use std::path::Path;
use std::process::ExitCode;
use std::time::Duration;

use super::bands::{self, Bands};
use super::{CommandError, output};
use crate::cli;
use crate::engine::process::Limits;
use crate::engine::single::Recorder;
use crate::engine::working_directory;
use crate::pipeline::stop;
use crate::report::live::Live;
use crate::report::{Report, history};
use crate::results::summary::{BestPoint, Summary};
use crate::results::{ResultsError, write_atomically};
use crate::run::{Runner, Trouble};
use crate::session::Verification;
use crate::study::Study;
use crate::study::plan::Plan;
use crate::table::csv_file;
use crate::task::{Schedule, Task};
use fmu_import::{Content, Handle, Package, Value};

/// Limits for the best point's trajectory. They may be short: the point itself has finished before.
const LIMITS: Limits = Limits {
    time: Duration::from_secs(60),
    memory: 16 << 30,
};

pub(super) fn run(options: &cli::Report) -> Result<ExitCode, CommandError> {
    let mut report = Report::from_folder(&options.folder)?;
    if options.live {
        report.live = Some(live(options, &report)?);
    }
    let page = report.write(&options.folder)?;
    if options.png {
        report.write_png(&options.folder)?;
    }
    output::print(&format!("{}\n", page.display()));
    Ok(ExitCode::SUCCESS)
}

/// The FMU's module and a point's simulation, for the page.
fn live(options: &cli::Report, report: &Report) -> Result<Live, CommandError> {
    let cannot = |message| CommandError::Option {
        option: "live",
        message,
    };
    match &report.whatif {
        None => return Err(cannot("the points cannot be judged in the page".to_owned())),
        Some(study) => study.can_be_drawn().map_err(cannot)?,
    }
    let verification = Verification::reopen(&options.folder, options.fmu.clone())?;
    let mut session = verification.session;
    Live::new(&session.plan, &mut session.package, &report.table).map_err(cannot)
}

/// Keeps the study's text and the best point's trajectory in a folder of results. `trusted`: the points ran in this
/// process. `most` are the extra runs that are allowed.
pub(super) fn keep_trajectory(
    folder: &Path,
    study: &Study,
    plan: &Plan,
    package: &mut Package,
    summary: &Summary,
    trusted: bool,
    most: usize,
) -> Result<(), CommandError> {
    keep_study(folder, study)?;
    let bands = bands::found(folder, plan, package, summary, most, LIMITS);
    keep_measured(folder, study, plan, &bands)?;
    for number in 0..plan.cases.len() {
        keep_case(folder, plan, number, package, summary, trusted)?;
    }
    Ok(())
}

/// Keeps the best point's trajectory in one case.
fn keep_case(
    folder: &Path,
    plan: &Plan,
    number: usize,
    package: &mut Package,
    summary: &Summary,
    trusted: bool,
) -> Result<(), CommandError> {
    let case = &plan.cases[number];
    let trajectory = folder.join(history::file(case.name.as_ref().map(|_| number)));
    // A failure here takes nothing away from the verdict: the page then shows no trajectory.
    let recorded = summary
        .best_point
        .as_ref()
        .map(|best| {
            // Only what has already come to its end in this process, which no failed point has touched.
            let once = package.description().capabilities;
            let once = once.can_be_instantiated_only_once_per_process;
            let same = fine(case.task.schedule) == case.task.schedule;
            let here = trusted && same && !once && summary.failed == 0;
            record(best, plan, number, package, here)
        })
        .transpose();
    match recorded {
        Ok(Some(text)) => fs::write(&trajectory, text).map_err(ResultsError::io(&trajectory))?,
        other => {
            let _ = fs::remove_file(&trajectory);
            if let Err(error) = other {
                crate::tell::line!("note: the page shows no trajectory of the best point: {error}");
            }
        }
    }
    Ok(())
}

/// Keeps the measured curves beside the results, where there are any.
fn keep_measured(
    folder: &Path,
    study: &Study,
    plan: &Plan,
    bands: &Bands,
) -> Result<(), CommandError> {
    let path = folder.join(history::MEASURED);
    let probes = study.criteria.keys().zip(plan.probes()).enumerate();
    let curves: Vec<_> = probes
        .filter_map(|(k, (name, probe))| {
            let band = bands.of.get(k).and_then(Option::as_ref);
            Some((name.as_ref(), probe.curve.as_ref()?, band))
        })
        .collect();
    if curves.is_empty() {
        let _ = fs::remove_file(&path);
        return Ok(());
    }
    write_atomically(&path, |out| {
        let mut table = csv::Writer::from_writer(out);
        table.write_record(history::MEASURED_COLUMNS)?;
        for (name, curve, band) in curves {
            let times = curve.shown_times().zip(&curve.values);
            for (row, (time, value)) in times.enumerate() {
                let text = |number: Option<&f64>| number.map_or_else(String::new, f64::to_string);
                let [low, high] = [0, 1].map(|side| band.and_then(|band| band[side].get(row)));
                table.write_record([
                    &*csv_file::cell(name),
                    time.to_string().as_str(),
                    value.to_string().as_str(),
                    text(curve.uncertainty.get(row)).as_str(),
                    text(low).as_str(),
                    text(high).as_str(),
                    match band {
                        Some(_) => bands.points.to_string(),
                        None => String::new(),
                    }
                    .as_str(),
                ])?;
            }
        }
        table.flush()
    })?;
    Ok(())
}

/// Keeps the study beside its results.
pub(super) fn keep_study(folder: &Path, study: &Study) -> Result<(), CommandError> {
    let path = folder.join("study.toml");
    write_atomically(&path, |out| out.write_all(study.text().as_bytes()))?;
    Ok(())
}

/// The best point's criteria over time in one case, as a table.
fn record(
    best: &BestPoint,
    plan: &Plan,
    case: usize,
    package: &mut Package,
    here: bool,
) -> Result<Vec<u8>, CommandError> {
    let parameters: Vec<f64> = best.parameters.values().copied().collect();
    let mut values = Vec::new();
    plan.to_fmu(&parameters, &mut values);
    let first = plan.criteria_of(case).start;
    let mut task = plan.cases[case].task.clone();
    task.schedule = fine(task.schedule);
    let probes: Vec<usize> = (0..task.observed.len())
        .filter(|&k| task.observed[k].handle.content == Content::Real)
        .collect();
    let columns: Vec<Handle> = probes.iter().map(|&k| task.observed[k].handle).collect();
    let names: Vec<&String> = best.values.keys().collect();
    let names = probes.iter().map(|&k| csv_file::cell(names[first + k]));
    let head: Vec<_> = std::iter::once("time".into()).chain(names).collect();
    let mut write = |here: bool| -> Result<Vec<u8>, CommandError> {
        let mut table = csv::Writer::from_writer(Vec::new());
        let failed =
            |error: csv::Error| ResultsError::io(history::file(None).as_ref())(error.into());
        table
            .write_record(head.iter().map(|name| name.as_bytes()))
            .map_err(failed)?;
        let mut number = zmij::Buffer::new();
        let put = |time: f64, row: &[Value]| {
            table.write_field(number.format(time)).map_err(failed)?;
            for (value, &k) in row.iter().zip(&probes) {
                let Value::Real(value) = value else { continue };
                // Seven digits are plenty for a plot.
                let value = plan.outputs[first + k].value(*value) as f32;
                table.write_field(number.format(value)).map_err(failed)?;
            }
            table.write_record(None::<&[u8]>).map_err(failed)?;
            Ok::<_, CommandError>(())
        };
        if here {
            record_here(package, task.clone(), &values, &columns, put)?;
        } else {
            record_apart(package, &task, &values, &columns, put)?;
        }
        Ok(table.into_inner().unwrap_or_default())
    };
    if here && let Ok(text) = write(true) {
        return Ok(text);
    }
    // A simulation that fails in this process has its second try in a fresh one.
    write(false)
}

/// Simulates a point in this process.
fn record_here(
    package: &mut Package,
    task: Task,
    values: &[f64],
    columns: &[Handle],
    mut put: impl FnMut(f64, &[Value]) -> Result<(), CommandError>,
) -> Result<(), CommandError> {
    let mut runner = Runner::new(package.load()?, task);
    let mut row = Vec::new();
    runner.trajectory(values, |time, instance| {
        row.clear();
        for &column in columns {
            row.push(instance.value(column)?);
        }
        put(time, &row).map_err(Trouble::Other)
    })?;
    runner.end();
    Ok(())
}

/// Simulates a point in a process of its own.
fn record_apart(
    package: &mut Package,
    task: &Task,
    values: &[f64],
    columns: &[Handle],
    put: impl FnMut(f64, &[Value]) -> Result<(), CommandError>,
) -> Result<(), CommandError> {
    let scratch = stop::scratch()?;
    let fmu = package.unpack(scratch.path())?;
    let recorder = Recorder {
        fmu: &fmu,
        name: package.path(),
        home: working_directory::home(scratch.path(), package.description(), [task]),
        limits: LIMITS,
        echo: false,
    };
    recorder.record(task, values, columns, put)
}

/// The study's own communication points where they are enough for a plot, else closer ones: what happens
/// between them is to be seen.
fn fine(schedule: Schedule) -> Schedule {
    const ENOUGH: u64 = 1000;
    const PLENTY: f64 = 15_000.0;
    if schedule.steps() >= ENOUGH {
        return schedule;
    }
    Schedule {
        step: schedule.step.min((schedule.stop - schedule.start) / PLENTY),
        ..schedule
    }
}
