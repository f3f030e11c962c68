//! What a model description says that cannot be right.

use crate::fmu::description::{DefaultExperiment, Kind};
use crate::fmu::{Causality, Description, Variable};
use crate::units::Units;

/// All that is wrong in a model description by itself.
pub(super) fn broken(fmu: &Description) -> Vec<String> {
    let mut findings = experiment(&fmu.default_experiment);
    findings.extend(
        fmu.variables
            .values()
            .flat_map(|variable| of_variable(variable, &fmu.units)),
    );
    findings.extend(structure(fmu));
    findings
}

fn experiment(experiment: &DefaultExperiment) -> Vec<String> {
    let mut findings = Vec::new();
    for (name, value) in [
        ("stepSize", experiment.step),
        ("tolerance", experiment.tolerance),
    ] {
        if let Some(value) = value
            && !(value > 0.0 && value.is_finite())
        {
            findings.push(format!(
                "DefaultExperiment: {name} is {value}; it must be greater than 0"
            ));
        }
    }
    let start = experiment.start.unwrap_or(0.0);
    if let Some(stop) = experiment.stop
        && (stop <= start || !(stop - start).is_finite())
    {
        findings.push(format!(
            "DefaultExperiment: stopTime is {stop}; it must be later than startTime, {start}"
        ));
    }
    findings
}

fn of_variable(variable: &Variable, units: &Units) -> Vec<String> {
    let mut findings = match &variable.kind {
        Kind::Real {
            start, min, max, ..
        } => range(*start, *min, *max),
        Kind::Integer { start, min, max } => range(*start, *min, *max),
        Kind::Enumeration {
            start: Some(start),
            items,
        } if !items.is_empty() && items.iter().all(|(_, value)| value != start) => {
            vec![format!("start {start} is none of its type's items")]
        }
        _ => Vec::new(),
    };
    findings.extend(unit(variable, units));
    findings
        .into_iter()
        .map(|finding| format!("{}: {finding}", variable.name))
        .collect()
}

fn range<T: PartialOrd + std::fmt::Display>(
    start: Option<T>,
    min: Option<T>,
    max: Option<T>,
) -> Vec<String> {
    let mut findings = Vec::new();
    if let (Some(min), Some(max)) = (&min, &max)
        && min > max
    {
        findings.push(format!("min {min} is greater than max {max}"));
    }
    if let Some(start) = &start {
        if let Some(min) = min.filter(|min| start < min) {
            findings.push(format!("start {start} is less than min {min}"));
        }
        if let Some(max) = max.filter(|max| start > max) {
            findings.push(format!("start {start} is greater than max {max}"));
        }
    }
    findings
}

fn unit(variable: &Variable, units: &Units) -> Option<String> {
    let Kind::Real {
        unit, display_unit, ..
    } = &variable.kind
    else {
        return None;
    };
    let Some(unit) = unit else {
        return display_unit
            .as_ref()
            .map(|shown| format!("displayUnit \"{shown}\" without a unit"));
    };
    let Some((_, defined)) = units.iter().find(|(name, _)| name == unit) else {
        return Some(format!("unit \"{unit}\" is not defined"));
    };
    let shown = display_unit.as_ref()?;
    let known = shown == unit || defined.display.iter().any(|other| other.name == *shown);
    (!known).then(|| format!("displayUnit \"{shown}\" is not defined for unit \"{unit}\""))
}

/// `ModelStructure` lists the outputs, all of them and nothing else (FMI 2.0.4, section 2.2.8).
fn structure(fmu: &Description) -> Vec<String> {
    let listed = |index: usize| fmu.listed_outputs.contains(&(index + 1));
    let variables = fmu.variables.values().enumerate();
    variables
        .filter_map(|(index, variable)| {
            let output = variable.causality == Causality::Output;
            let wrong = match (output, listed(index)) {
                (true, false) => "an output that ModelStructure does not list",
                (false, true) => "no output, but ModelStructure lists it as one",
                _ => return None,
            };
            Some(format!("{}: {wrong}", variable.name))
        })
        .collect()
}
