//! `simulate`: one run.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::process::ExitCode;

use super::{CommandError, output};
use crate::cli::Simulate;
use crate::failure::Failure;
use crate::fmu::{Call, Causality, Description, Instance, Kind, Package, Value, Variable};
use crate::results::ResultsError;
use crate::results::points::number;
use crate::run::{Runner, Trouble};
use crate::study::Setting;
use crate::study::plan::{find, value_of};
use crate::task::{Schedule, Task};

pub(super) fn run(options: &Simulate) -> Result<ExitCode, CommandError> {
    let mut package = Package::open(&options.fmu)?;
    let task = Task {
        schedule: schedule(options, package.description())?,
        fixed: settings(&options.set, package.description())?,
        varied: Vec::new(),
        observed: Vec::new(),
    };
    let library = package.load()?;
    let columns = Columns::new(package.description());
    let mut runner = Runner::new(library, task);
    match &options.output {
        None => {
            let out = io::stdout().lock();
            let result = trajectory(&mut runner, &[], &columns, out);
            match result {
                // A reader that has gone, such as `head`, is no error.
                Err(TrajectoryError::Write(error)) if error.kind() == io::ErrorKind::BrokenPipe => {
                }
                Err(error) => return Err(error.into_command("standard output".as_ref())),
                Ok(_) => {}
            }
        }
        Some(path) => {
            let file = File::create(path).map_err(ResultsError::io(path))?;
            let last = trajectory(&mut runner, &[], &columns, file)
                .map_err(|error| error.into_command(path))?;
            output::print(&summary(&columns, &last));
        }
    }
    Ok(ExitCode::SUCCESS)
}

fn schedule(options: &Simulate, fmu: &Description) -> Result<Schedule, CommandError> {
    let suggested = Schedule::suggested(fmu);
    let start = options.start.unwrap_or(suggested.start);
    let schedule = Schedule {
        start,
        stop: options.stop.unwrap_or(suggested.stop),
        step: options.step.unwrap_or(suggested.step),
        window_start: start,
        leap: false,
        tolerance: suggested.tolerance,
    };
    schedule.check().map_err(|message| CommandError::Option {
        option: "stop/--step",
        message,
    })?;
    Ok(schedule)
}

/// Start values from `NAME=VALUE`.
pub(super) fn settings(
    texts: &[String],
    fmu: &Description,
) -> Result<Vec<(u32, Value)>, CommandError> {
    let setting = |text: &String| {
        let (name, value) = text
            .split_once('=')
            .ok_or_else(|| format!("`{text}` is not NAME=VALUE"))?;
        let variable = find(fmu, name.trim())?;
        let value = value_of(fmu, variable, &Setting::Text(value.trim().to_owned()))?;
        Ok((variable.value_reference, value))
    };
    let set = |text| {
        setting(text).map_err(|message: String| CommandError::Option {
            option: "set",
            message,
        })
    };
    texts.iter().map(set).collect()
}

/// The outputs that a trajectory shows.
#[derive(Debug)]
pub(super) struct Columns {
    variables: Vec<Variable>,
    /// The references of those that are real, in order.
    reals: Vec<u32>,
}

impl Columns {
    pub(super) fn new(fmu: &Description) -> Self {
        let variables: Vec<Variable> = fmu.with(Causality::Output).cloned().collect();
        let real = |variable: &&Variable| matches!(variable.kind, Kind::Real { .. });
        let reals = variables
            .iter()
            .filter(real)
            .map(|variable| variable.value_reference);
        Self {
            reals: reals.collect(),
            variables,
        }
    }

    /// The cells of the present communication point.
    fn read(&self, instance: &mut Instance, reals: &mut [f64]) -> Result<Vec<String>, Call> {
        if !reals.is_empty() {
            instance.reals(&self.reals, reals)?;
        }
        let mut reals = reals.iter();
        let mut cell = |variable: &Variable| {
            let reference = variable.value_reference;
            Ok(match variable.kind {
                Kind::Real { .. } => reals.next().copied().map_or_else(String::new, number),
                Kind::Integer { .. } | Kind::Enumeration { .. } => {
                    instance.integer(reference)?.to_string()
                }
                Kind::Boolean { .. } => u8::from(instance.boolean(reference)?).to_string(),
                Kind::String { .. } => instance.string(reference)?,
            })
        };
        self.variables.iter().map(&mut cell).collect()
    }
}

/// What interrupts the writing of a trajectory.
#[derive(Debug)]
pub(super) enum TrajectoryError {
    Simulation(Failure),
    Write(io::Error),
}

impl From<Failure> for TrajectoryError {
    fn from(failure: Failure) -> Self {
        Self::Simulation(failure)
    }
}

impl From<csv::Error> for Trouble<TrajectoryError> {
    fn from(error: csv::Error) -> Self {
        Self::Other(TrajectoryError::Write(error.into()))
    }
}

impl TrajectoryError {
    pub(super) fn into_command(self, path: &std::path::Path) -> CommandError {
        match self {
            Self::Simulation(failure) => failure.into(),
            Self::Write(error) => ResultsError::io(path)(error).into(),
        }
    }
}

/// Simulates, writes the trajectory as csv, and returns the last row.
pub(super) fn trajectory(
    runner: &mut Runner,
    values: &[f64],
    columns: &Columns,
    into: impl Write,
) -> Result<Vec<String>, TrajectoryError> {
    let mut csv = csv::Writer::from_writer(BufWriter::new(into));
    let names = columns
        .variables
        .iter()
        .map(|variable| variable.name.as_str());
    let header = csv.write_record(std::iter::once("time").chain(names));
    header.map_err(|error| TrajectoryError::Write(error.into()))?;
    let mut reals = vec![0.0; columns.reals.len()];
    let mut last = Vec::new();
    runner.trajectory(values, |time, instance| {
        last = columns.read(instance, &mut reals)?;
        csv.write_field(number(time))?;
        csv.write_record(&last)?;
        Ok(())
    })?;
    csv.flush().map_err(TrajectoryError::Write)?;
    Ok(last)
}

/// The outputs at the end, for people.
fn summary(columns: &Columns, last: &[String]) -> String {
    let lines = columns.variables.iter().zip(last).map(|(variable, value)| {
        let unit = variable.unit().unwrap_or("");
        format!("{} = {value} {unit}", variable.name)
            .trim_end()
            .to_owned()
            + "\n"
    });
    lines.collect()
}
