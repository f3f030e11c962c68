//! `check`: looks at an FMU before it is used.
//!
//! What the model description says, by the rules of [`rules`]; then two short simulations, in a worker
//! process: a fresh instance, and a reset one, must agree, and keep to the declared ranges.

mod rules;

use std::ops::ControlFlow;
use std::process::ExitCode;
use std::time::Duration;

use super::{CommandError, output};
use crate::cli::Check;
use crate::engine::process::{Limits, Process};
use crate::engine::{Answer, Job, Worker};
use crate::fmu::{Causality, Description, FmuError, Package, Variable};
use crate::results::ResultsError;
use crate::study::Statistic;
use crate::task::{Probe, Schedule, Storage, Task};

/// What a pre-flight may use.
const LIMITS: Limits = Limits {
    time: Duration::from_secs(60),
    memory: 8 << 30,
};

pub(super) fn run(options: &Check) -> Result<ExitCode, CommandError> {
    let findings = match Package::open(&options.fmu) {
        Ok(package) => findings(package)?,
        // What is no FMU of this version is a finding; what is no archive, a mistake.
        Err(FmuError::Description { source, .. }) => {
            vec![format!("modelDescription.xml: {source}")]
        }
        Err(error) => return Err(error.into()),
    };
    let verdict = if findings.is_empty() {
        "nothing found"
    } else {
        "findings:"
    };
    output::print(&format!("{}: {verdict}\n", options.fmu.display()));
    for finding in &findings {
        output::print(&format!("  {finding}\n"));
    }
    Ok(if findings.is_empty() {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}

fn findings(mut package: Package) -> Result<Vec<String>, CommandError> {
    let fmu = package.description();
    let mut findings = fmu.remarks.clone();
    findings.extend(rules::broken(fmu));
    if fmu.with(Causality::Output).next().is_none() {
        findings.push("the FMU has no outputs".to_owned());
    }
    let folder = tempfile::tempdir().map_err(ResultsError::io(&std::env::temp_dir()))?;
    let unpacked = match package.unpack(folder.path()) {
        Ok(unpacked) => unpacked,
        Err(error) => {
            findings.push(error.to_string());
            return Ok(findings);
        }
    };
    let task = task(&package);
    let mut worker = Process::new(&unpacked, &task, LIMITS, folder.path(), 0)?;
    let jobs = [0, 1].map(|index| Job {
        index,
        values: Vec::new(),
    });
    let mut answers: Vec<Answer> = Vec::new();
    worker.run(&jobs, &mut |_, answer| {
        answers.push(answer);
        ControlFlow::Continue(())
    })?;
    findings.extend(compare(&answers, &task));
    findings.extend(outside(&answers, &task, package.description()));
    Ok(findings)
}

/// A few steps of the suggested experiment, with all numeric outputs.
fn task(package: &Package) -> Task {
    const STEPS: f64 = 10.0;
    let fmu = package.description();
    let suggested = usable(Schedule::suggested(fmu));
    let probe = |variable: &Variable, statistic| {
        Some(Probe {
            name: variable.name.clone(),
            reference: variable.value_reference,
            storage: Storage::of(variable)?,
            statistic,
        })
    };
    let extremes = |variable| [Statistic::Min, Statistic::Max].map(|of| probe(variable, of));
    Task {
        schedule: Schedule {
            stop: suggested.stop.min(suggested.start + STEPS * suggested.step),
            ..suggested
        },
        fixed: Vec::new(),
        varied: Vec::new(),
        inputs: Vec::new(),
        observed: fmu
            .with(Causality::Output)
            .flat_map(extremes)
            .flatten()
            .collect(),
    }
}

/// The suggested times, or others where those are of no use (which is a finding of its own).
fn usable(suggested: Schedule) -> Schedule {
    let mut schedule = suggested;
    let passes = schedule.stop > schedule.start;
    if !passes {
        schedule.stop = schedule.start + 1.0;
    }
    if !(schedule.step > 0.0 && schedule.step.is_finite()) {
        schedule.step = (schedule.stop - schedule.start) / 500.0;
    }
    schedule.tolerance = schedule.tolerance.filter(|tolerance| *tolerance > 0.0);
    schedule
}

/// Outputs that leave the range that the FMU declares for them.
fn outside(answers: &[Answer], task: &Task, fmu: &Description) -> Vec<String> {
    let Some(Ok(sampled)) = answers.first() else {
        return Vec::new();
    };
    let pairs = task.observed.iter().zip(sampled);
    pairs
        .filter_map(|(probe, value)| {
            let (min, max) = fmu.variables.get(&probe.name)?.kind.range();
            let (bound, name) = match probe.statistic {
                Statistic::Min => (min.filter(|min| value < min)?, "min"),
                _ => (max.filter(|max| value > max)?, "max"),
            };
            Some(format!(
                "{}: {value} in a simulation, beyond its {name} of {bound}",
                probe.name
            ))
        })
        .collect()
}

/// What is wrong with the answers of a fresh and a reset instance.
fn compare(answers: &[Answer], task: &Task) -> Vec<String> {
    match answers {
        [Ok(fresh), Ok(again)] => {
            let pairs = task.observed.iter().zip(fresh.iter().zip(again));
            pairs
                .filter(|(_, (fresh, again))| fresh.to_bits() != again.to_bits())
                .map(|(probe, (fresh, again))| {
                    format!(
                        "after fmi2Reset, {} is {again} instead of {fresh}",
                        probe.name
                    )
                })
                .collect()
        }
        [Err(failure), ..] => vec![format!("a simulation with the start values: {failure}")],
        [Ok(_), Err(failure)] => vec![format!("a simulation after fmi2Reset: {failure}")],
        _ => vec!["the simulations gave no answer".to_owned()],
    }
}
