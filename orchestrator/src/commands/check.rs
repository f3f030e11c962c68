//! `check`: looks at an FMU before it is used.
//!
//! What the archive holds ([`files`]) and the model description says ([`schema`], [`rules`], [`variables`],
//! [`structure`]); then two short simulations, in a worker process: a fresh instance, and a reset one, must
//! agree, and keep to the declared ranges.

mod definitions;
mod document;
mod files;
mod rules;
mod schema;
mod structure;
mod variables;

use std::path::Path;
use std::process::ExitCode;
use std::time::Duration;

use super::{CommandError, output};
use crate::cli::Check;
use crate::engine::process::Limits;
use crate::engine::single::Recorder;
use crate::engine::{Answer, Job};
use crate::results::ResultsError;
use crate::statistics::Statistic;
use crate::task::{Probe, Schedule, Task};
use fmu_import::{ArchiveError, Causality, Description, FmuError, Package, Variable};

/// The most memory that a pre-flight may use, bytes.
const MEMORY: u64 = 8 << 30;

pub(super) fn run(options: &Check) -> Result<ExitCode, CommandError> {
    let findings = match Package::open(&options.fmu) {
        Ok(package) => findings(package, options.patience)?,
        // An archive that is no FMU of this version, or damaged, is a finding; what is no archive, a mistake.
        Err(FmuError::Description { source, .. }) => {
            vec![format!("modelDescription.xml: {source}")]
        }
        Err(FmuError::Archive {
            source: ArchiveError::NoDescription,
            ..
        }) => vec![
            "modelDescription.xml is not there: it belongs to the top of the archive (pack the files, not \
             the folder around them)"
                .to_owned(),
        ],
        Err(FmuError::Archive { source, .. }) if source.is_a_fault() => vec![source.to_string()],
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

fn findings(mut package: Package, patience: f64) -> Result<Vec<String>, CommandError> {
    let mut findings = described(&mut package)?;
    let files = files::broken(&mut package)?;
    findings.extend(files.findings);
    // Without a GUID it would be refused.
    if !files.fatal && !package.description().guid.is_empty() {
        // What the description says wrongly, the binary cannot confirm.
        let described_well = findings.is_empty();
        findings.extend(simulated(&mut package, patience, described_well)?);
    }
    Ok(findings)
}

/// What the model description says.
fn described(package: &mut Package) -> Result<Vec<String>, CommandError> {
    let strict = package.with_document(|root| {
        let scalars = document::scalars(root);
        let mut findings = schema::broken(root);
        findings.extend(definitions::broken(root, &scalars));
        findings.extend(variables::broken(root, &scalars));
        findings.extend(structure::broken(root, &scalars));
        findings
    })?;
    let fmu = package.description();
    let remarks = fmu.remarks.iter();
    let mut findings: Vec<String> = remarks
        .map(|remark| format!("modelDescription.xml, {remark}"))
        .collect();
    findings.extend(rules::broken(fmu));
    findings.extend(strict);
    if fmu.with(Causality::Output).next().is_none() {
        findings.push("modelDescription.xml: the FMU has no outputs".to_owned());
    }
    Ok(findings)
}

/// What two short simulations show.
fn simulated(
    package: &mut Package,
    patience: f64,
    described_well: bool,
) -> Result<Vec<String>, CommandError> {
    let folder = tempfile::tempdir().map_err(ResultsError::io(&std::env::temp_dir()))?;
    let unpacked = match package.unpack(folder.path()) {
        Ok(unpacked) => unpacked,
        Err(FmuError::Archive { source, .. }) => return Ok(vec![source.to_string()]),
        Err(error) => return Err(error.into()),
    };
    let task = task(package);
    let limits = Limits {
        time: Duration::try_from_secs_f64(patience).unwrap_or(Duration::MAX),
        memory: MEMORY,
    };
    let recorder = Recorder {
        fmu: &unpacked,
        name: package.path(),
        limits,
        echo: false,
    };
    let jobs = [0, 1].map(|index| Job {
        index,
        values: Vec::new(),
    });
    let answers = match recorder.run_reset(&task, &jobs) {
        Ok(answers) => answers,
        Err(error) => return Ok(vec![unloadable(&error.to_string(), &unpacked)]),
    };
    let mut findings = compare(&answers, &task);
    findings.extend(outside(&answers, &task, package.description()));
    if described_well {
        findings.extend(other_starts(&answers, &task, package.description()));
    }
    Ok(findings)
}

/// Why a binary cannot be loaded, without the folder into which it was unpacked.
fn unloadable(error: &str, unpacked: &Path) -> String {
    let folder = unpacked.display();
    let short = error
        .replace(&format!("{folder}/"), "")
        .replace(&format!("{folder}: "), "");
    format!("the binary cannot be loaded: {short}")
}

/// A few steps of the suggested experiment, with all numeric outputs and parameters.
fn task(package: &Package) -> Task {
    const STEPS: f64 = 10.0;
    let fmu = package.description();
    let suggested = usable(Schedule::suggested(fmu));
    let probe = |variable: &Variable, statistic| {
        Some(Probe {
            name: variable.name.clone(),
            handle: variable.number_handle()?,
            statistic,
        })
    };
    let extremes = |variable| [Statistic::Min, Statistic::Max].map(|of| probe(variable, of));
    let parameters = fmu.with(Causality::Parameter);
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
            .chain(parameters.map(|variable| probe(variable, Statistic::Final)))
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
            // A range that is none is a finding of its own.
            if min.zip(max).is_some_and(|(min, max)| min > max) {
                return None;
            }
            let (bound, name) = match probe.statistic {
                Statistic::Final => return None,
                Statistic::Min => (min.filter(|min| value < min)?, "min"),
                _ => (max.filter(|max| value > max)?, "max"),
            };
            Some(format!(
                "{}: {value} in a simulation, beyond its {name} of {bound}: correct the range or the model",
                probe.name
            ))
        })
        .collect()
}

/// Parameters that the binary starts with another value than the description says.
fn other_starts(answers: &[Answer], task: &Task, fmu: &Description) -> Option<String> {
    const ROUNDING: f64 = 1e-6;
    let Some(Ok(sampled)) = answers.first() else {
        return None;
    };
    let parameters = task.observed.iter().zip(sampled);
    let others: Vec<String> = parameters
        .filter(|(probe, _)| probe.statistic == Statistic::Final)
        .filter_map(|(probe, value)| {
            let Variable {
                name, line, kind, ..
            } = fmu.variables.get(&probe.name)?;
            let start = kind.start()?;
            let differs = (value - start).abs() > ROUNDING * start.abs().max(value.abs());
            differs.then(|| {
                format!("{name} (line {line}): start is {start}, but the binary's is {value}")
            })
        })
        .collect();
    (!others.is_empty()).then(|| {
        let text = structure::short(&others);
        format!("modelDescription.xml: {text}: correct the description or the binary")
    })
}

/// What is wrong with the answers of a fresh and a reset instance.
fn compare(answers: &[Answer], task: &Task) -> Vec<String> {
    match answers {
        [Ok(fresh), Ok(again)] => {
            let pairs = task.observed.iter().zip(fresh.iter().zip(again));
            let first = pairs
                .filter(|(_, (fresh, again))| fresh.to_bits() != again.to_bits())
                .map(|(probe, (fresh, again))| {
                    format!(
                        "after fmi2Reset, {} is {again} instead of {fresh}: it must begin anew, as all others",
                        probe.name
                    )
                })
                .next();
            first.into_iter().collect()
        }
        [Err(failure), ..] => vec![format!(
            "a simulation with the start values failed: {failure}"
        )],
        [Ok(_), Err(failure)] => vec![format!("a simulation after fmi2Reset failed: {failure}")],
        _ => vec!["the simulations gave no answer".to_owned()],
    }
}
