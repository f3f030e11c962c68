//! `init`: a starting study that runs at once, from what an FMU says of itself and does in one run.

mod measured;
mod run;
mod write;

use std::{path::Path, process::ExitCode};

use super::{isolated::Isolated, output, simulate};
use crate::{
    cli::Init,
    error::{Error, Result},
    options::relative,
};
use fmu_import::{Causality, Description, Kind, Package, Variability, Variable};
use fmu_points::task::{Schedule, Task};
use measured::MeasuredTable;
use point_journal::files::write_text;
use study::{Setting, plan::value_of};
use write::{Criteria, Shown};

pub fn run(options: &Init) -> Result<ExitCode> {
    if let Some(path) = options.output.as_ref().filter(|path| path.exists()) {
        let message = format!("{} exists already; choose another name", path.display());
        return Err(Error::option("output", message));
    }
    let mut package = Package::open(&options.fmu)?;
    let fixed = simulate::settings(&options.set, &mut package)?;
    let isolated = Isolated::new(&mut package)?;
    let fmu = package.description();
    let set = options.set.iter().map(|text| simulate::setting(text, fmu));
    let mut set: Vec<_> = set.collect::<Result<_, _>>().map_err(|message| Error::option("set", message))?;
    let mut table = options.measured.as_ref().map(|path| MeasuredTable::read(path, fmu)).transpose()?;
    let schedule = schedule(options, fmu, table.as_ref())?;
    let variables = match &table {
        Some(table) => table.columns.iter().map(|c| c.variable).collect(),
        None => measurable(fmu),
    };
    let task = Task { fixed, sizes: fmu.sizes.clone(), ..Task::new(schedule) };
    let signals =
        run::signals(&isolated, &task, &variables).map_err(|error| run::advice(error, options, fmu, schedule.step))?;
    let criteria = match &mut table {
        Some(table) => {
            table.leave_out_infinite(&signals);
            table.tell()?;
            Criteria::of_table(table, &relative(&table.file, options.output.as_deref()))
        }
        None => Criteria::of_model(&signals, fmu, &options.fmu)?,
    };
    let driven = table.iter().flat_map(|table| &table.inputs).map(|column| &*column.variable.name);
    let driven: Vec<&str> = driven.collect();
    let parameters = parameters(fmu, &options.fmu, &driven, &set)?;
    set.retain(|(variable, _)| !parameters.iter().any(|(varied, _)| varied.name == variable.name));
    let study = write::Study {
        fmu,
        path: relative(&options.fmu, options.output.as_deref()),
        schedule,
        parameters,
        set,
        criteria,
    };
    match &options.output {
        None => output::print(&study.text()),
        Some(path) => {
            write_text(path, study.text())?;
            output::print(&study.told(path));
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// As the user asks, else as long as the measured curves, else as the FMU suggests.
fn schedule(options: &Init, fmu: &Description, table: Option<&MeasuredTable>) -> Result<Schedule> {
    const STEPS: f64 = 500.0;
    let [first, last] = table.and_then(|table| table.span).map_or([None; 2], |span| span.map(Some));
    let suggested = Schedule::suggested(fmu);
    let start = first.map(|first| first.min(suggested.start));
    let stop = options.stop.or(last);
    // Without a step of its own an FMU takes a part of the run.
    let ours = fmu.default_experiment.step.is_none();
    let length = stop.unwrap_or(suggested.stop) - start.unwrap_or(suggested.start);
    let step = options.step.or(ours.then_some(length / STEPS));
    simulate::schedule(fmu, start, stop, step)
}

/// The variables that can be compared with a measurement: the outputs, or else what the FMU shows of its inside.
fn measurable(fmu: &Description) -> Vec<&Variable> {
    const MOST: usize = 1000;
    let of = |causality| -> Vec<&Variable> {
        let all = fmu.with(causality).filter(|variable| is_number(variable));
        all.take(MOST).collect()
    };
    let found = [Causality::Output, Causality::Local].map(of);
    let found = found.into_iter().find(|found| !found.is_empty());
    let found = found.unwrap_or_default();
    // Whole numbers count something.
    let reals = found.iter().copied().filter(|variable| is_real(variable));
    if found.iter().any(|variable| is_real(variable)) { reals.collect() } else { found }
}

fn is_real(variable: &Variable) -> bool {
    matches!(variable.kind, Kind::Real { .. })
}

fn is_number(variable: &Variable) -> bool {
    (is_real(variable) || matches!(variable.kind, Kind::Integer { .. }))
        && variable.variability != Variability::Constant
}

/// The parameters that can vary about their start values: `parameter`s, or where there are none inputs, or else what the user sets.
fn parameters<'a>(
    fmu: &'a Description,
    path: &Path,
    driven: &[&str],
    set: &[(&'a Variable, String)],
) -> Result<Vec<(&'a Variable, Shown<'a>)>> {
    let is_set = |variable: &Variable| set.iter().any(|(set, _)| set.name == variable.name);
    for causality in [Causality::Parameter, Causality::Input] {
        // What was measured drives the model.
        let all = fmu.with(causality).filter(|variable| !driven.contains(&&*variable.name) && !is_set(variable));
        let all: Vec<_> = all.filter_map(|v| Some((v, Shown::about_start(fmu, v)?))).collect();
        if !all.is_empty() {
            return Ok(all);
        }
    }
    let about = |(variable, setting): &(&'a Variable, String)| {
        let value = value_of(fmu, variable, &Setting::Text(setting.clone())).ok()?.number();
        Some((*variable, Shown::about(fmu, variable, value)?))
    };
    let all: Vec<_> = set.iter().filter_map(about).collect();
    if !all.is_empty() {
        return Ok(all);
    }
    let message = "no parameter and no input of type Real has a start value other than 0 about which it could vary; give one with \
                   --set NAME=VALUE";
    Err(Error::content(path, message))
}
