//! `check`: looks at an FMU before it is used.
//!
//! Two short simulations, in a worker process: a fresh instance, and a reset one, must agree.

use std::ops::ControlFlow;
use std::process::ExitCode;
use std::time::Duration;

use super::{CommandError, output};
use crate::cli::Check;
use crate::engine::process::{Limits, Process};
use crate::engine::{Answer, Job, Worker};
use crate::fmu::{Causality, Package};
use crate::results::ResultsError;
use crate::study::Statistic;
use crate::task::{Probe, Schedule, Storage, Task};

/// What a pre-flight may use.
const LIMITS: Limits = Limits {
    time: Duration::from_secs(60),
    memory: 8 << 30,
};

pub(super) fn run(options: &Check) -> Result<ExitCode, CommandError> {
    let mut package = Package::open(&options.fmu)?;
    let mut findings = package.description().remarks.clone();
    if package
        .description()
        .with(Causality::Output)
        .next()
        .is_none()
    {
        findings.push("the FMU has no outputs".to_owned());
    }
    let folder = tempfile::tempdir().map_err(ResultsError::io(&std::env::temp_dir()))?;
    let unpacked = package.unpack(folder.path())?;
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

/// A few steps of the suggested experiment, with all numeric outputs.
fn task(package: &Package) -> Task {
    const STEPS: f64 = 10.0;
    let fmu = package.description();
    let suggested = Schedule::suggested(fmu);
    let probe = |variable: &crate::fmu::Variable| {
        Some(Probe {
            name: variable.name.clone(),
            reference: variable.value_reference,
            storage: Storage::of(variable)?,
            statistic: Statistic::Final,
        })
    };
    Task {
        schedule: Schedule {
            stop: suggested.stop.min(suggested.start + STEPS * suggested.step),
            ..suggested
        },
        fixed: Vec::new(),
        varied: Vec::new(),
        inputs: Vec::new(),
        observed: fmu.with(Causality::Output).filter_map(probe).collect(),
    }
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
