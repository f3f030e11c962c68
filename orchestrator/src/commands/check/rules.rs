//! What a model description says that cannot be right.

use fmu_import::description::{DefaultExperiment, Kind};
use fmu_import::units::Units;
use fmu_import::{Description, Variable};

/// All that is wrong in a model description by itself.
pub(super) fn broken(fmu: &Description) -> Vec<String> {
    let mut findings = experiment(&fmu.default_experiment);
    if fmu.fmi_version != "2.0" {
        findings.push(format!(
            "modelDescription.xml: fmiVersion is {}; FMI 2.0 is needed, which calls itself 2.0",
            fmu.fmi_version
        ));
    }
    findings.extend(
        fmu.variables
            .values()
            .flat_map(|variable| of_variable(variable, &fmu.units)),
    );
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
                "modelDescription.xml: DefaultExperiment: {name} is {value}; it must be greater than 0"
            ));
        }
    }
    let start = experiment.start.unwrap_or(0.0);
    if let Some(stop) = experiment.stop
        && (stop <= start || !(stop - start).is_finite())
    {
        findings.push(format!(
            "modelDescription.xml: DefaultExperiment: stopTime is {stop}; it must be later than startTime, {start}"
        ));
    }
    let length = experiment.stop.map(|stop| stop - start);
    if let (Some(step), Some(length)) = (experiment.step, length)
        && length > 0.0
        && step > length
        && step.is_finite()
    {
        findings.push(format!(
            "modelDescription.xml: DefaultExperiment: stepSize is {step}, but the experiment lasts {length} s only: \
             shorten the step"
        ));
    }
    findings
}

fn of_variable(variable: &Variable, units: &Units) -> Vec<String> {
    let mut findings = match &variable.kind {
        Kind::Real {
            start,
            min,
            max,
            nominal,
            ..
        } => real(*start, *min, *max, *nominal),
        Kind::Integer { start, min, max } => range(*start, *min, *max),
        Kind::Enumeration {
            start: Some(start),
            items,
        } if !items.is_empty() && items.iter().all(|(_, value)| value != start) => {
            vec![format!(
                "start {start} is none of its type's items: choose one of them"
            )]
        }
        _ => Vec::new(),
    };
    findings.extend(unit(variable, units));
    findings
        .into_iter()
        .map(|finding| {
            let Variable { name, line, .. } = variable;
            format!("modelDescription.xml, line {line}: {name}: {finding}")
        })
        .collect()
}

fn real(
    start: Option<f64>,
    min: Option<f64>,
    max: Option<f64>,
    nominal: Option<f64>,
) -> Vec<String> {
    let mut findings = range(start, min, max);
    if let Some(start) = start.filter(|start| !start.is_finite()) {
        findings.push(format!("start is {start}: it must be a finite number"));
    }
    if let Some(nominal) = nominal.filter(|nominal| nominal.is_nan() || *nominal <= 0.0) {
        findings.push(format!(
            "nominal is {nominal}: it must be greater than 0, as importers divide by it"
        ));
    }
    findings
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
        return vec![format!(
            "min {min} is greater than max {max}: exchange or correct them"
        )];
    }
    if let Some(start) = &start {
        if let Some(min) = min.filter(|min| start < min) {
            findings.push(format!(
                "start {start} is less than min {min}: correct one of them"
            ));
        }
        if let Some(max) = max.filter(|max| start > max) {
            findings.push(format!(
                "start {start} is greater than max {max}: correct one of them"
            ));
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
            .map(|shown| format!("displayUnit \"{shown}\" without a unit: add the unit"));
    };
    let Some((_, defined)) = units.iter().find(|(name, _)| name == unit) else {
        return Some(format!(
            "unit \"{unit}\" is not defined: add it to UnitDefinitions"
        ));
    };
    let shown = display_unit.as_ref()?;
    let known = shown == unit || defined.display.iter().any(|other| other.name == *shown);
    (!known).then(|| {
        format!("displayUnit \"{shown}\" is not defined for unit \"{unit}\": add it there")
    })
}
