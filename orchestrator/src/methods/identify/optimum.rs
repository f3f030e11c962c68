//! The study at an optimum: what the search has found in place of what was known, so that `verify` judges it as it is.

use std::{f64::consts::E, path::Path};

use calibration::{
    fit::FitVerdict,
    outcome::{FreeOutcome, IdentificationOutcome},
    problem::Spacing,
    text::digits,
};
use fmu_import::quantity::Quantity;
use study::{
    CaseText, Study,
    cases::SEPARATOR,
    inputs::{GAIN, OFFSET},
};
use toml::{Table, Value};

use crate::{error::Result, identify::bind::Bound, options::relative, results::words::unit_behind};

/// The text of the study at an optimum, for a file. Each parameter that the data tell has what they leave of it, and recorded
/// inputs have the errors of their sensors taken off.
///
/// # Errors
/// When the study's text cannot be read.
pub fn study(
    (study, fmu): (&Study, &Path),
    outcome: &IdentificationOutcome,
    (place, bound): (usize, &Bound),
    file: &Path,
) -> Result<String> {
    let mut table: Table = study.section()?;
    // They speak of the parameters as they were.
    for section in ["identify", "tolerances", "correlations"] {
        table.remove(section);
    }
    let seen = |path: &Path| {
        let text = relative(path, Some(file)).display().to_string();
        Value::String(if cfg!(windows) { text.replace('\\', "/") } else { text })
    };
    place_files(&mut table, &|path| seen(&study.path_of(path.as_ref())));
    table.insert("fmu".to_owned(), seen(fmu));
    let all = &outcome.optima[place].free;
    let others = bound.others();
    let told: Vec<usize> = (0..all.len()).filter(|&k| is_told(&all[k], &others)).collect();
    for free in told.iter().map(|&k| &all[k]) {
        within(&mut table, "parameters").insert(free.name.clone(), Value::Table(distribution(free)));
    }
    // Those of the other optima are not known.
    if place == 0 {
        let pairs: Vec<Value> = told
            .iter()
            .enumerate()
            .flat_map(|(k, &a)| told[k + 1..].iter().map(move |&b| [a, b]))
            .map(|[a, b]| {
                // A nearly singular correlation matrix may stop being positive definite by rounding. Slightly smaller
                // coefficients prevent that.
                const LESS: f64 = 0.999;
                let names = [a, b].map(|k| Value::from(all[k].name.clone()));
                let coefficient = Value::from(LESS * outcome.correlations[a][b]);
                let entries = [("between", Value::Array(names.to_vec())), ("coefficient", coefficient)];
                Value::Table(entries.map(|(key, value)| (key.to_owned(), value)).into_iter().collect())
            })
            .collect();
        if !pairs.is_empty() {
            table.insert("correlations".to_owned(), Value::Array(pairs));
        }
    }
    take_errors_off(&mut table, study, all, bound);
    let name = number_tables::files::name(study.path());
    let which = match outcome.optima.len() {
        0 | 1 => "The optimum".to_owned(),
        of => format!("Optimum {} of {of}", place + 1),
    };
    let misses = match outcome.fit() {
        FitVerdict::Misses => ", which misses the measured values",
        _ if outcome.optima.len() > 1 => ", of which the data do not tell the right one",
        _ => "",
    };
    let text = toml::to_string(&table).map_err(|error| study.error(error.to_string()))?;
    Ok(format!(
        "# {which} of {name}{misses}: a study, with what the data leave of each parameter that they tell.\n\n{text}"
    ))
}

/// Whether the data tell a parameter of the model, the same in all cases.
fn is_told(free: &FreeOutcome, others: &[String]) -> bool {
    const NOTHING: f64 = 0.9;
    let is_known = free.left <= NOTHING && free.deviation.is_finite() && free.deviation > 0.0;
    is_known && !free.of_case && !free.surrounded && !others.contains(&free.name)
}

/// What the data leave of a parameter.
fn distribution(free: &FreeOutcome) -> Table {
    let number = |value: f64| Value::Float(digits(value).parse().unwrap_or(value));
    let mut table = Table::new();
    let mut set = |key: &str, value: Value| table.insert(key.to_owned(), value);
    match free.scale {
        Spacing::Linear => {
            set("distribution", "truncated-normal".into());
            set("mean", number(free.value));
            set("deviation", number(free.deviation));
            set("min", free.bounds[0].into());
            set("max", free.bounds[1].into());
        }
        // The most probable value is the median on that scale.
        Spacing::Log => {
            let square = free.deviation.ln().powi(2);
            let mean = free.value * E.powf(square / 2.0);
            set("distribution", "lognormal".into());
            set("mean", number(mean));
            set("deviation", number(mean * square.exp_m1().sqrt()));
        }
    }
    if let Some(unit) = &free.unit {
        set("unit", unit.clone().into());
    }
    table
}

/// A table in a table, which is made where there is none.
fn within<'a>(table: &'a mut Table, key: &str) -> &'a mut Table {
    let inner = table.entry(key).or_insert_with(|| Value::Table(Table::new()));
    match inner {
        Value::Table(inner) => inner,
        _ => unreachable!("the study was read, and `{key}` is a table there"),
    }
}

/// Names the files as they are seen from elsewhere.
fn place_files(table: &mut Table, placed: &dyn Fn(&str) -> Value) {
    for (key, value) in table.iter_mut().filter(|(key, _)| *key != "fixed") {
        match value {
            Value::String(file) if ["file", "fixed-from"].contains(&key.as_str()) => *value = placed(file),
            Value::Table(inner) => place_files(inner, placed),
            Value::Array(all) => {
                all.iter_mut().filter_map(Value::as_table_mut).for_each(|inner| place_files(inner, placed));
            }
            _ => {}
        }
    }
}

/// What a study states of the sensor of a recorded input.
fn of_sensor(study: &Study, key: &str) -> Option<[Option<Quantity>; 4]> {
    let (_, text) = study.inputs.iter().find(|(name, _)| name.as_ref().as_str() == key)?;
    Some([&text.offset, &text.gain, &text.uncertainty, &text.gain_uncertainty].map(Clone::clone))
}

/// Takes the offsets and gains of recorded inputs off them, with what is left of their uncertainty.
fn take_errors_off(table: &mut Table, study: &Study, all: &[FreeOutcome], bound: &Bound) {
    let fitted = study.fitted();
    let (fitted, cases) = (fitted.by_case(), study.by_case());
    for free in all {
        let Some([offset, gain]) = bound.offsets.get(&free.name) else { continue };
        let Some((path, what)) = free.name.rsplit_once('/').filter(|(_, what)| [OFFSET, GAIN].contains(what)) else {
            continue;
        };
        // The first case that was fitted with the input says which sensor it is.
        let stated = fitted.iter().find_map(|(case, of_case)| {
            let own = case.and_then(|case| path.strip_prefix(case.name.as_ref().as_str())?.strip_prefix(SEPARATOR));
            let key = own.unwrap_or(path);
            Some((key, of_sensor(of_case, key)?))
        });
        let Some((key, sensor)) = stated else { continue };
        let is_its = |of: &Study| of_sensor(of, key).as_ref() == Some(&sensor);
        // One after the other they are taken off the recording.
        let (found, uncertainty) = match what {
            GAIN => (100.0 * gain + (1.0 + gain) * free.value, "gain-uncertainty"),
            _ => (offset + (1.0 + gain) * free.value, "uncertainty"),
        };
        let unit = unit_behind(free.unit.as_deref());
        let half = (free.interval[1] - free.interval[0]) / 2.0;
        let set = |of: &mut Table| {
            let input = of.get_mut("inputs").and_then(|inputs| inputs.get_mut(key)).and_then(Value::as_table_mut);
            if let Some(input) = input {
                input.insert(what.to_owned(), format!("{}{unit}", digits(found)).into());
                input.insert(uncertainty.to_owned(), format!("{}{unit}", digits(half)).into());
            }
        };
        if is_its(study) {
            set(table);
        }
        let of_cases = table.get_mut("cases").and_then(Value::as_array_mut);
        for case in of_cases.into_iter().flatten().filter_map(Value::as_table_mut) {
            let name = case.get("name").and_then(Value::as_str).unwrap_or_default();
            let is_named = |case: &&CaseText| case.name.as_ref().as_str() == name;
            if cases.iter().any(|(case, of_case)| case.as_ref().is_some_and(is_named) && is_its(of_case)) {
                set(case);
            }
        }
    }
}
