//! `inspect`: what an FMU is.

use std::{fmt::Write, process::ExitCode};

use serde_json::json;

use super::output;
use crate::{cli::Inspect, error::Result, results::points::number};
use fmu_import::{Causality, Description, Kind, Package, Variable, units::Conversion};
use fmu_points::tell::one_line;

pub fn run(options: &Inspect) -> Result<ExitCode> {
    let package = Package::open(&options.fmu)?;
    let fmu = package.description();
    let platforms = package.platforms();
    if options.json {
        let mut value = json!(fmu);
        value["platforms"] = json!(platforms);
        value["variables"] = fmu.variables.values().map(|variable| json!(variable)).collect();
        output::print(&format!("{value:#}\n"));
    } else {
        output::print(&text(fmu, &platforms));
    }
    Ok(ExitCode::SUCCESS)
}

fn text(fmu: &Description, platforms: &[String]) -> String {
    let mut text = String::new();
    // Writing to a String cannot fail.
    let _ = writeln!(text, "{} (FMI {} for {})", fmu.model_name, fmu.fmi_version, fmu.interface.name());
    if let Some(description) = &fmu.description {
        let _ = writeln!(text, "{}", one_line(description));
    }
    let mut row = |key: &str, value: &str| {
        if !value.is_empty() {
            let _ = writeln!(text, "  {key:<14}{}", one_line(value));
        }
    };
    row("version", fmu.version.as_deref().unwrap_or(""));
    row("written by", fmu.generation_tool.as_deref().unwrap_or(""));
    row("platforms", &platforms.join(", "));
    row("experiment", &experiment(fmu));
    row("capabilities", &capabilities(fmu));
    let unusable: Vec<String> = fmu.unusable.iter().map(|(name, why)| format!("{name} ({why})")).collect();
    row("not usable", &unusable.join("; "));
    let remarks: Vec<String> = fmu.remarks.iter().map(ToString::to_string).collect();
    row("remarks", &remarks.join("; "));
    let sections = [
        ("Inputs", Causality::Input),
        ("Sizes of arrays", Causality::StructuralParameter),
        ("Parameters", Causality::Parameter),
        ("Outputs", Causality::Output),
    ];
    for (title, causality) in sections {
        section(&mut text, fmu, title, causality);
    }
    let locals = fmu.with(Causality::Local).count();
    if locals > 0 {
        let _ = writeln!(text, "\nand {locals} local variables (--json lists them)");
    }
    text
}

fn experiment(fmu: &Description) -> String {
    let experiment = &fmu.default_experiment;
    [("start", experiment.start), ("stop", experiment.stop), ("step", experiment.step)]
        .iter()
        .filter_map(|(name, time)| Some(format!("{name} {} s", (*time)?)))
        .collect::<Vec<_>>()
        .join(", ")
}

fn capabilities(fmu: &Description) -> String {
    let names: Vec<String> = json!(fmu.capabilities)
        .as_object()
        .into_iter()
        .flatten()
        .filter(|(_, flag)| flag.as_bool() == Some(true))
        .map(|(name, _)| name.replace('_', " "))
        .collect();
    names.join(", ")
}

fn section(text: &mut String, fmu: &Description, title: &str, causality: Causality) {
    let variables: Vec<&Variable> = fmu.with(causality).collect();
    if variables.is_empty() {
        return;
    }
    let width = variables.iter().map(|variable| variable.name.chars().count()).max().unwrap_or(0).min(48);
    let values: Vec<String> = variables.iter().map(|variable| value(fmu, variable)).collect();
    let widest = values.iter().map(|value| value.chars().count()).max().unwrap_or(0).clamp(24, 36);
    let _ = writeln!(text, "\n{title}");
    for (variable, value) in variables.iter().zip(values) {
        let description = variable.description.as_deref().unwrap_or("");
        let line = format!("  {:width$}  {value:<widest$}  {description}", variable.name);
        let _ = writeln!(text, "{}", one_line(line.trim_end()));
    }
}

/// The start value as it can be set, with its unit, and in the unit for people; or these units alone, or the type.
fn value(fmu: &Description, variable: &Variable) -> String {
    match &variable.kind {
        Kind::Real { start, unit, .. } => {
            // Twelve digits hide what a conversion rounds.
            let rounded = |value: f64| format!("{value:.11e}").parse().unwrap_or(value);
            let with = |value: Option<f64>, unit: Option<&str>| {
                [value.map(rounded).map(number), unit.map(str::to_owned)]
                    .into_iter()
                    .flatten()
                    .collect::<Vec<_>>()
                    .join(" ")
            };
            let text = with(*start, unit.as_deref());
            let shown = variable.display_unit().filter(|shown| unit.as_deref() != Some(shown));
            match shown.and_then(|shown| fmu.conversion(shown, variable).ok()).map(Conversion::inverse) {
                Some(way) => format!("{text} ({})", with(start.map(|start| way.value(start)), shown)),
                None => text,
            }
        }
        Kind::Integer { start, .. } => start.map_or("Integer".to_owned(), |v| v.to_string()),
        Kind::Clock(timing) => {
            let period = timing.interval.map(|interval| format!(" {} s", number(interval)));
            let by = serde_json::json!(timing.by);
            format!("{} clock{}", by.as_str().unwrap_or_default(), period.unwrap_or_default())
        }
        Kind::Boolean { start } => start.map_or("Boolean".to_owned(), |v| v.to_string()),
        Kind::String { start } => start.as_ref().map_or("String".to_owned(), |v| format!("{v:?}")),
        Kind::Enumeration { start, items } => items
            .iter()
            .find(|(_, value)| Some(*value) == *start)
            .map_or("Enumeration".to_owned(), |(name, _)| name.clone()),
    }
}
