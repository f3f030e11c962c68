//! `simulate`: one run, in a process of its own.

pub mod recorded;

use std::{fs::File, io, path::Path, process::ExitCode};

use super::{
    isolated::{Columns, Isolated},
    output,
};
use crate::{
    cli::Simulate,
    error::{Error, Result},
};
use fmu_import::{Causality, Description, Package, Value, Variable};
use fmu_points::task::{Schedule, Task};
use study::{
    Setting,
    inputs::takes_any_step,
    plan::{bare, find, size_of, value_of},
    ssv,
};

pub fn run(options: &Simulate) -> Result<ExitCode> {
    let mut package = Package::open(&options.fmu)?;
    let set = settings(&options.set, &mut package)?;
    let fmu = package.description();
    let from = match &options.set_from {
        Some(path) => ssv::read(path, fmu)?.into_iter().map(|(_, reference, value)| (reference, value)).collect(),
        None => Vec::new(),
    };
    // The command line overrides the file.
    let kept = |(reference, value): &(u32, Value)| {
        !set.iter().any(|(other, new)| other == reference && new.content() == value.content())
    };
    let schedule = schedule(fmu, options.start, options.stop, options.step)?;
    let task = Task {
        sizes: fmu.sizes.clone(),
        fixed: from.into_iter().filter(kept).chain(set.iter().cloned()).collect(),
        inputs: match &options.input {
            Some(path) => recorded::inputs(path, options.extrapolate.is_some(), fmu, &schedule)?,
            None => Vec::new(),
        },
        ..Task::new(schedule)
    };
    let columns = match &options.record[..] {
        [] => Columns::usual(fmu, true),
        names => recorded::columns(names, fmu)?,
    };
    // An FMU may refuse a step that it has not suggested.
    let ours = options.step.is_none() && fmu.default_experiment.step.is_none();
    let step = ours.then_some(task.schedule.step);
    let run = Isolated::new(&mut package)?;
    match options.output.as_deref().filter(|path| *path != Path::new("-")) {
        None => {
            let out = io::stdout().lock();
            match run.trajectory(&task, &[], &columns, out, "standard output".as_ref()) {
                // A reader that has gone, such as `head`, is no error.
                Err(Error::File(error)) if error.kind == Some(io::ErrorKind::BrokenPipe) => {}
                Err(error) => return Err(advised(error, step)),
                Ok(_) => {}
            }
        }
        Some(path) => {
            let file = File::create(path).map_err(Error::io(path))?;
            let last = run.trajectory(&task, &[], &columns, file, path).map_err(|error| advised(error, step))?;
            output::print(&columns.summary(&last));
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// What the user asks for, and else what the FMU suggests.
pub fn schedule(fmu: &Description, start: Option<f64>, stop: Option<f64>, step: Option<f64>) -> Result<Schedule> {
    let suggested = Schedule::suggested(fmu);
    let start = start.unwrap_or(suggested.start);
    let stop = stop.unwrap_or(suggested.stop);
    let mut schedule = Schedule {
        start,
        stop,
        step: step.unwrap_or(suggested.step.min(stop - start)),
        window_start: start,
        leap: false,
        tolerance: suggested.tolerance,
    };
    schedule.check().map_err(|error| Error::option("stop/--step", error.message))?;
    if step.is_none() {
        schedule.check_suggested().map_err(|error| Error::option("step", error.message))?;
    }
    if !takes_any_step(fmu) {
        schedule = schedule.in_whole_steps();
    }
    Ok(schedule)
}

/// Start values from `NAME=VALUE`; the package gets the sizes of arrays among them.
pub fn settings(texts: &[String], package: &mut Package) -> Result<Vec<(u32, Value)>> {
    let wrong = |message| Error::option("set", message);
    let mut sizes = Vec::new();
    for text in texts {
        // A name may be one that only these sizes give.
        if let Ok((variable, setting)) = setting(text, package.description()) {
            let size = size_of(package.description(), variable, &Setting::Text(setting));
            sizes.extend(size.map_err(wrong)?);
        }
    }
    package.resize(&sizes)?;
    let fmu = package.description();
    let mut values = Vec::new();
    for text in texts {
        let (variable, setting) = setting(text, fmu).map_err(wrong)?;
        let setting = Setting::Text(setting);
        if variable.causality == Causality::StructuralParameter {
            continue;
        }
        let value = value_of(fmu, variable, &setting).map_err(wrong)?;
        if let Some(read) = bare(fmu, variable, &setting) {
            output::line!("{read}");
        }
        values.push((variable.handle().reference, value));
    }
    Ok(values)
}

/// The variable and the value of `NAME=VALUE`.
pub fn setting<'a>(text: &str, fmu: &'a Description) -> Result<(&'a Variable, String), String> {
    // A name may hold the sign itself: take the longest one that the FMU knows.
    let known = |place: &usize| fmu.variables.contains_key(text[..*place].trim());
    let places: Vec<usize> = text.match_indices('=').map(|(place, _)| place).collect();
    let place = places.iter().rfind(|place| known(place)).or(places.first());
    let (name, value) = place
        .map(|&place| (&text[..place], &text[place + 1..]))
        .ok_or_else(|| format!("`{text}` is not NAME=VALUE"))?;
    let variable = find(fmu, name.trim())?;
    Ok((variable, value.trim().to_owned()))
}

/// The error with advice where the FMU refused its start values, or a step that nobody has asked for.
pub fn advised(error: Error, step: Option<f64>) -> Error {
    let Error::Simulation(failure) = error else { return error };
    let is = |name: &str| failure.refused().is_some_and(|function| function.ends_with(name));
    match step {
        Some(step) if is("DoStep") => Error::Step { failure, step },
        _ if is("InitializationMode") => {
            Error::Refused(format!("{}; set other start values by --set NAME=VALUE", Error::Simulation(failure)))
        }
        _ => failure.into(),
    }
}
