//! Findings in a simulation that ended soundly: warnings, values that cannot be right.

use crate::{
    hit::{Breach, Hit, breach},
    probe::{Report, Run},
    structure::short,
};
use fmu_import::{Causality, Description, Variable, Version};

/// The FMU's declarations and remarks, apart from its values.
pub fn remarks(fmu: &Description, report: Option<&Report>) -> Vec<Breach> {
    let mut breaches = Vec::new();
    let mut tell = |rule, text| breaches.push(breach(rule, text));
    if fmu.capabilities.needs_execution_tool {
        tell("execution-tool", "it needs the tool that wrote it (needsExecutionTool)".to_owned());
    }
    let Some(report) = report else { return breaches };
    let (prefix, number) = (fmu.standard.prefix(), fmu.standard.number());
    for (rule, function, usual, told) in [
        ("binary-version", "GetVersion", number, &report.version),
        ("binary-types", "GetTypesPlatform", "default", &report.types_platform),
    ] {
        let function = format!("{prefix}{function}");
        // FMI 3.0.1 and 3.0.2 are 3.0, too.
        let same = |told: &str| match fmu.standard {
            Version::Two => told == usual,
            Version::Three => told.starts_with(usual),
        };
        if let Some(other) = told.as_deref().filter(|told| !same(told)) {
            tell(
                rule,
                format!("{function} returns \"{other}\", not \"{usual}\": build it with the standard's headers"),
            );
        }
    }
    if report.strays > 0 {
        tell(
            "logger-environment",
            format!(
                "the logger is called with an environment that is not the one of {prefix}Instantiate: pass {} on",
                match fmu.standard {
                    Version::Two => "componentEnvironment",
                    Version::Three => "instanceEnvironment",
                }
            ),
        );
    }
    if let Some(held) = &report.held {
        tell(
            "held",
            format!("it holds a {held}, where points that run at the same time meet: run them one after the other"),
        );
    }
    for run in &report.runs {
        if run.warnings > 0 {
            let first = run.first_warning.as_deref().unwrap_or_default();
            tell("warnings", format!("calls that returned {prefix}Warning: {}; the first: {first}", run.warnings));
        }
        if let Some(time) = run.ended {
            tell(
                "early-end",
                format!(
                    "it ends the simulation by itself, at {time} s ({})",
                    match fmu.standard {
                        Version::Two => "fmi2Terminated",
                        Version::Three => "terminateSimulation",
                    }
                ),
            );
        }
    }
    breaches
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
        // Before the first step, some are not known yet.
        if let Some(value) = values.clone().skip(1).find(|value| !value.is_finite()) {
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
