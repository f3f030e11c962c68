//! Findings in a simulation that ended soundly: warnings, values that cannot be right.

use crate::{
    hit::{Breach, Hit, breach},
    probe::{Report, Run},
    structure::short,
};
use fmu_import::{Causality, Description, Variable, Version};

/// What the FMU declares, and what its binary and its simulations show, apart from values.
pub fn remarks(fmu: &Description, report: Option<&Report>) -> Vec<Breach> {
    let mut breaches = Vec::new();
    if fmu.capabilities.needs_execution_tool {
        breaches.push(breach("execution-tool", "it needs the tool that wrote it (needsExecutionTool)"));
    }
    if let Some(report) = report {
        breaches.extend(other_headers(fmu.standard, report));
        breaches.extend(foreign_environment(fmu.standard, report));
        breaches.extend(held(report));
        breaches
            .extend(report.runs.iter().flat_map(|run| [warned(fmu.standard, run), ended(fmu.standard, run)]).flatten());
    }
    breaches
}

/// A binary that names another version, or other types, than the headers of the standard make it name.
fn other_headers(standard: Version, report: &Report) -> impl Iterator<Item = Breach> {
    let of_function = move |rule, function, usual: &str, named: &Option<String>| {
        let named = named.as_deref()?;
        let same = match standard {
            Version::Two => named == usual,
            // FMI 3.0.1 and 3.0.2 are 3.0, too.
            Version::Three => named.starts_with(usual),
        };
        let prefix = standard.prefix();
        let text =
            || format!("{prefix}{function} returns \"{named}\", not \"{usual}\": build it with the standard's headers");
        (!same).then(|| breach(rule, text()))
    };
    [
        of_function("binary-version", "GetVersion", standard.number(), &report.version),
        of_function("binary-types", "GetTypesPlatform", "default", &report.types_platform),
    ]
    .into_iter()
    .flatten()
}

/// Messages that the FMU passes to the logger with another environment than it was given.
fn foreign_environment(standard: Version, report: &Report) -> Option<Breach> {
    let environment = match standard {
        Version::Two => "componentEnvironment",
        Version::Three => "instanceEnvironment",
    };
    let text = || {
        let prefix = standard.prefix();
        format!(
            "the logger is called with an environment that is not the one of {prefix}Instantiate: pass {environment} on"
        )
    };
    (report.strays > 0).then(|| breach("logger-environment", text()))
}

/// What only one process of the machine can have at a time.
fn held(report: &Report) -> Option<Breach> {
    let held = report.held.as_ref()?;
    let text = format!("it holds a {held}, where points that run at the same time meet: run them one after the other");
    Some(breach("held", text))
}

/// Warnings of the functions in a simulation.
fn warned(standard: Version, run: &Run) -> Option<Breach> {
    let first = run.first_warning.as_deref().unwrap_or_default();
    let (prefix, count) = (standard.prefix(), run.warnings);
    let text = || format!("calls that returned {prefix}Warning: {count}; the first: {first}");
    (count > 0).then(|| breach("warnings", text()))
}

/// The end of a simulation before its stop time by the FMU's own will.
fn ended(standard: Version, run: &Run) -> Option<Breach> {
    let time = run.ended?;
    let by = match standard {
        Version::Two => "fmi2Terminated",
        Version::Three => "terminateSimulation",
    };
    Some(breach("early-end", format!("it ends the simulation by itself, at {time} s ({by})")))
}

/// Values that cannot be right: infinite ones, ones beyond their range, and, where the description counts, start values
/// that are not the binary's.
pub fn values(columns: &[&Variable], run: &Run, described_well: bool) -> Vec<Breach> {
    let (mut breaches, mut infinite) = (Vec::new(), Vec::new());
    for (place, variable) in columns.iter().enumerate() {
        if variable.causality == Causality::Parameter || variable.number_handle().is_none() {
            continue;
        }
        let values = run.rows.iter().map(|row| row[place].number());
        // A variable of a clock has no value before its first tick.
        let is_unset = |value: &f64| !variable.clocks.is_empty() && !value.is_finite();
        if let Some(value) = values.clone().skip_while(is_unset).find(|value| !value.is_finite()) {
            infinite.push(format!("{} is {value}", variable.name));
        }
        breaches.extend(beyond(variable, values));
    }
    if !infinite.is_empty() {
        breaches
            .push(breach("output-finite", format!("{} in a simulation: no criterion can use it", short(&infinite))));
    }
    if described_well {
        breaches.extend(other_starts(columns, run));
    }
    breaches
}

/// Parameters that the binary starts with another value than the description says.
fn other_starts(columns: &[&Variable], run: &Run) -> Option<Breach> {
    const ROUNDING: f64 = 1e-6;
    let others: Vec<String> = columns
        .iter()
        .zip(run.rows.first()?)
        .filter(|(variable, _)| variable.causality == Causality::Parameter)
        .filter_map(|(variable, value)| {
            let (start, value) = (variable.kind.start()?, value.number());
            let near = (value - start).abs() <= ROUNDING * start.abs().max(value.abs());
            let differs = value != start && !(near && value.is_finite());
            let Variable { name, line, .. } = variable;
            differs.then(|| format!("{name} (line {line}): start is {start}, but the binary's is {value}"))
        })
        .collect();
    let text = || format!("{}: correct the description or the binary", short(&others));
    (!others.is_empty()).then(|| ("start-agrees", Hit::of(crate::document::NAME, text())))
}

/// A variable that leaves the range that the FMU declares for it.
fn beyond(variable: &Variable, values: impl Iterator<Item = f64> + Clone) -> Option<Breach> {
    let (min, max) = variable.kind.range();
    // A range with its min above its max is a finding of its own.
    if min.zip(max).is_some_and(|(min, max)| min > max) {
        return None;
    }
    let beyond = min
        .and_then(|min| Some((values.clone().find(|value| *value < min)?, min, "min")))
        .or_else(|| max.and_then(|max| Some((values.clone().find(|value| *value > max)?, max, "max"))));
    let (value, bound, name) = beyond?;
    Some(breach(
        "output-range",
        format!(
            "{}: {value} in a simulation, beyond its {name} of {bound}: correct the range or the model",
            variable.name
        ),
    ))
}
