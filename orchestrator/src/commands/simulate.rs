//! `simulate`: one run, in a process of its own.

mod recorded;

use std::borrow::Cow;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use super::output;
use crate::cli::Simulate;
use crate::error::Error;
use crate::results::points::number;
use crate::study::plan::{bare, find, value_of};
use crate::study::{Setting, ssv};
use crate::table::csv_file;
use fmu_import::{Causality, Description, Handle, Package, Value, Variable};
use fmu_points::Limits;
use fmu_points::failure::Failure;
use fmu_points::scratch::Scratch;
use fmu_points::single::Recorder;
use fmu_points::stop;
use fmu_points::task::{Case, Schedule, Task};
use fmu_points::working_directory;
use fmu_points::{Answer, Job, RunError};

pub(super) fn run(options: &Simulate) -> Result<ExitCode, Error> {
    let mut package = Package::open(&options.fmu)?;
    let fmu = package.description();
    let set = settings(&options.set, fmu)?;
    let from = match &options.set_from {
        Some(path) => {
            let named = ssv::read(path, fmu)?.into_iter();
            named
                .map(|(_, reference, value)| (reference, value))
                .collect()
        }
        None => Vec::new(),
    };
    // The command line overrides the file.
    let kept = |(reference, value): &(u32, Value)| {
        !set.iter()
            .any(|(other, new)| other == reference && new.content() == value.content())
    };
    let schedule = schedule(options, fmu)?;
    let task = Task {
        schedule,
        fixed: from
            .into_iter()
            .filter(kept)
            .chain(set.iter().cloned())
            .collect(),
        varied: Vec::new(),
        inputs: match &options.input {
            Some(path) => recorded::inputs(path, options.extrapolate.is_some(), fmu, &schedule)?,
            None => Vec::new(),
        },
        observed: Vec::new(),
    };
    let columns = match &options.record[..] {
        [] => Columns::usual(fmu, true),
        names => recorded::columns(names, fmu)?,
    };
    // An FMU may refuse a step that it has not suggested.
    let ours = options.step.is_none() && fmu.default_experiment.step.is_none();
    let step = ours.then_some(task.schedule.step);
    let run = Isolated::new(&mut package)?;
    match options
        .output
        .as_deref()
        .filter(|path| *path != Path::new("-"))
    {
        None => {
            let out = io::stdout().lock();
            match run.trajectory(&task, &[], &columns, out, "standard output".as_ref()) {
                // A reader that has gone, such as `head`, is no error.
                Err(Error::File(error)) if error.kind == Some(io::ErrorKind::BrokenPipe) => {}
                Err(error) => return Err(of_step(error, step)),
                Ok(_) => {}
            }
        }
        Some(path) => {
            let file = File::create(path).map_err(Error::io(path))?;
            let last = run
                .trajectory(&task, &[], &columns, file, path)
                .map_err(|error| of_step(error, step))?;
            output::print(&summary(&columns, &last));
        }
    }
    Ok(ExitCode::SUCCESS)
}

fn schedule(options: &Simulate, fmu: &Description) -> Result<Schedule, Error> {
    let suggested = Schedule::suggested(fmu);
    let start = options.start.unwrap_or(suggested.start);
    let stop = options.stop.unwrap_or(suggested.stop);
    let schedule = Schedule {
        start,
        stop,
        step: options.step.unwrap_or(suggested.step.min(stop - start)),
        window_start: start,
        leap: false,
        tolerance: suggested.tolerance,
    };
    let checked = schedule.check();
    checked.map_err(|message| Error::option("stop/--step", message))?;
    Ok(schedule)
}

/// Start values from `NAME=VALUE`.
pub(super) fn settings(texts: &[String], fmu: &Description) -> Result<Vec<(u32, Value)>, Error> {
    let setting = |text: &String| {
        // A name may hold the sign itself: take the longest one that the FMU knows.
        let known = |place: &usize| fmu.variables.contains_key(text[..*place].trim());
        let places: Vec<usize> = text.match_indices('=').map(|(place, _)| place).collect();
        let place = places.iter().rfind(|place| known(place)).or(places.first());
        let (name, value) = place
            .map(|&place| (&text[..place], &text[place + 1..]))
            .ok_or_else(|| format!("`{text}` is not NAME=VALUE"))?;
        let variable = find(fmu, name.trim())?;
        let setting = Setting::Text(value.trim().to_owned());
        let value = value_of(fmu, variable, &setting)?;
        if let Some(read) = bare(fmu, variable, &setting) {
            fmu_points::tell::line!("{read}");
        }
        Ok((variable.handle().reference, value))
    };
    let set = |text| setting(text).map_err(|message: String| Error::option("set", message));
    texts.iter().map(set).collect()
}

/// The variables that a trajectory shows.
#[derive(Debug)]
pub(super) struct Columns {
    variables: Vec<Variable>,
    handles: Vec<Handle>,
}

impl Columns {
    pub(super) fn of(variables: Vec<Variable>) -> Self {
        Self {
            handles: variables.iter().map(Variable::handle).collect(),
            variables,
        }
    }

    /// The outputs, or where there are none the local variables, of which `aloud` tells the user.
    pub(super) fn usual(fmu: &Description, aloud: bool) -> Self {
        let all = |causality| fmu.with(causality).cloned().collect::<Vec<Variable>>();
        let outputs = all(Causality::Output);
        if !outputs.is_empty() {
            return Self::of(outputs);
        }
        let locals = all(Causality::Local);
        match locals.len() {
            _ if !aloud => {}
            0 => fmu_points::tell::line!(
                "note: the FMU has neither outputs nor local variables, so only the time is recorded; --record \
                 chooses others"
            ),
            count => fmu_points::tell::line!(
                "note: the FMU has no outputs, so its {count} local variables are recorded; --record chooses others"
            ),
        }
        Self::of(locals)
    }
}

fn cell(value: &Value) -> String {
    match value {
        Value::Real(value) => number(*value),
        Value::Integer(value) => value.to_string(),
        Value::Boolean(value) => u8::from(*value).to_string(),
        Value::String(text) => csv_file::cell(text).into_owned(),
    }
}

/// The error with advice where the FMU refused a step that nobody has asked for.
fn of_step(error: Error, step: Option<f64>) -> Error {
    match (error, step) {
        (Error::Simulation(failure @ Failure::Discard(_)), Some(step)) => {
            Error::Step { failure, step }
        }
        (other, _) => other,
    }
}

/// An FMU of which single points run in a process of its own.
#[derive(Debug)]
pub(super) struct Isolated {
    fmu: PathBuf,
    name: PathBuf,
    scratch: Scratch,
    /// Whether the FMU gets an empty working directory.
    apart: bool,
}

impl Isolated {
    pub(super) fn new(package: &mut Package) -> Result<Self, Error> {
        let scratch = stop::scratch().map_err(Error::from)?;
        Ok(Self {
            fmu: package.unpack(scratch.path())?,
            name: package.path().to_owned(),
            scratch,
            apart: false,
        })
    }

    /// The same with the working directory of the points of a study.
    pub(super) fn in_a_study(mut self, package: &Package, cases: &[Case]) -> Self {
        let tasks = cases.iter().map(|case| &case.task);
        let home = working_directory::home(self.scratch.path(), package.description(), tasks);
        self.apart = home.is_some();
        self
    }

    /// How single points are recorded: without a limit of time, as a person watches and can press Ctrl-C.
    fn recorder(&self) -> Recorder<'_> {
        Recorder {
            fmu: &self.fmu,
            name: &self.name,
            home: self.apart.then_some(self.scratch.path()),
            limits: Limits::NONE,
            echo: true,
        }
    }

    /// Simulates, writes the trajectory as csv into what is called `path`, and returns the last row.
    pub(super) fn trajectory(
        &self,
        task: &Task,
        values: &[f64],
        columns: &Columns,
        into: impl Write,
        path: &Path,
    ) -> Result<Vec<String>, Error> {
        let failed = |error: csv::Error| Error::io(path)(error.into());
        let mut csv = csv::Writer::from_writer(BufWriter::new(into));
        let names = columns
            .variables
            .iter()
            .map(|variable| csv_file::cell(&variable.name));
        let head = std::iter::once("time".into()).chain(names);
        csv.write_record(head.map(Cow::into_owned))
            .map_err(failed)?;
        let mut last = Vec::new();
        let mut recording = self.recorder().of(task);
        let recorded = recording.record(values, &columns.handles, None, |time, values| {
            last = values.iter().map(cell).collect();
            csv.write_field(number(time)).map_err(failed)?;
            csv.write_record(&last).map_err(failed)
        });
        stop::give_way();
        // Rows before the failure are kept.
        let flushed = csv.flush().map_err(Error::io(path));
        recorded.and(flushed).map(|()| last)
    }

    /// Simulates a point as `verify` does.
    pub(super) fn run(&self, cases: &[Case], job: &Job) -> Result<Answer, RunError> {
        let silent = Recorder {
            echo: false,
            ..self.recorder()
        };
        silent.run(cases, job)
    }
}

/// The values at the end, for people.
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
