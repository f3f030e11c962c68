//! Start values for an FMU's variables: found by name, converted, checked.

use super::Setting;
use fmu_import::{
    Causality, Description, Kind, StoragePlace, Value, Variability, Variable, bytes_of,
    description::Storage,
    quantity::{Quantity, Scale, Sense},
};
use fmu_points::{
    names::{behind, did_you_mean, nearest},
    task::Slot,
};

/// The variable of this name.
///
/// # Errors
/// Suggests the nearest name.
pub fn find<'a>(fmu: &'a Description, name: &str) -> Result<&'a Variable, String> {
    fmu.variables.get(name).ok_or_else(|| {
        if let Some(why) = fmu.unusable.get(name) {
            return format!("`{name}` cannot be used: {why}");
        }
        let suggestion = did_you_mean(nearest(name, fmu.variables.keys().map(String::as_str)));
        format!("the FMU has no variable `{name}`{suggestion}")
    })
}

/// How a variable takes a number before a simulation.
///
/// # Errors
/// When it cannot be set, or is a text.
pub fn slot_of(variable: &Variable) -> Result<Slot, String> {
    settable(variable)?;
    Slot::of(variable).ok_or_else(|| "a text cannot vary; set it under [fixed]".to_owned())
}

/// How a number without a unit was read, where people see its variable in another unit.
pub fn bare(fmu: &Description, variable: &Variable, setting: &Setting) -> Option<String> {
    let number: f64 = match setting {
        Setting::Number(number) => *number,
        Setting::Integer(number) => *number as f64,
        Setting::Text(text) => text.trim().parse().ok()?,
        Setting::Boolean(_) => return None,
    };
    let (name, unit, shown) = (&variable.name, variable.unit()?, variable.display_unit()?);
    let conversion = fmu.conversion(shown, variable).ok()?;
    (conversion.value(number) != number).then(|| {
        format!("{name} = {number:?} {unit}; its display unit is {shown}: write \"{number:?} {shown}\" for that")
    })
}

fn settable(variable: &Variable) -> Result<(), String> {
    if variable.is_settable() {
        return Ok(());
    }
    let reason = match (variable.variability, variable.causality) {
        (Variability::Constant, _) => "a constant",
        (_, Causality::StructuralParameter) => "the size of arrays, which is set under [fixed] or by --set",
        _ if matches!(variable.kind, Kind::Clock(_)) => "a clock that ticks by itself",
        _ => "computed by the FMU",
    };
    Err(format!("it is {reason}; only parameters, inputs and start values can be set"))
}

/// The size of arrays that a setting gives, with the value reference of its parameter; none where the variable is another.
///
/// # Errors
/// When it is no size.
pub fn size_of(fmu: &Description, variable: &Variable, setting: &Setting) -> Result<Option<(u32, u64)>, String> {
    if variable.causality != Causality::StructuralParameter {
        return Ok(None);
    }
    let size = match value(fmu, variable, setting) {
        Ok(Value::Integer(size)) => u64::try_from(size).map_err(|_| format!("{size} is no size")),
        Ok(_) => Err("only a whole number is a size".to_owned()),
        Err(message) => Err(message),
    };
    let size = size.map_err(|message| format!("{}: {message}", variable.name))?;
    Ok(Some((variable.value_reference, size)))
}

/// A start value for a variable.
///
/// # Errors
/// When the type, the unit or the number doesn't fit.
pub fn value_of(fmu: &Description, variable: &Variable, setting: &Setting) -> Result<Value, String> {
    let named = |message| format!("{}: {message}", variable.name);
    settable(variable).map_err(named)?;
    value(fmu, variable, setting).map_err(named)
}

fn value(fmu: &Description, variable: &Variable, setting: &Setting) -> Result<Value, String> {
    let text = match setting {
        Setting::Boolean(flag) => flag.to_string(),
        Setting::Integer(number) => number.to_string(),
        Setting::Number(number) => number.to_string(),
        Setting::Text(text) => text.clone(),
    };
    let whole = || text.trim().parse::<i128>().map_err(|_| format!("`{text}` is not a whole number"));
    match &variable.kind {
        Kind::Real { .. } => {
            let quantity: Quantity = text.parse()?;
            let number = Scale::new(None, fmu, variable)?.number(&quantity, Sense::Value)?;
            check_limits(variable, number)?;
            Ok(Value::Real(number))
        }
        Kind::Integer { .. } => {
            let number = whole()?;
            check_limits(variable, number as f64)?;
            Ok(Value::Integer(number))
        }
        Kind::Boolean { .. } | Kind::Clock(_) => match text.trim() {
            "true" | "1" => Ok(Value::Boolean(true)),
            "false" | "0" => Ok(Value::Boolean(false)),
            _ => Err(format!("`{text}` is neither true nor false")),
        },
        Kind::String { .. } => match variable.place {
            Some(StoragePlace { storage: Storage::Binary, .. }) if bytes_of(&text).is_none() => {
                Err(format!("`{text}` is not bytes as hexadecimal digits"))
            }
            _ => Ok(Value::String(text)),
        },
        Kind::Enumeration { items, .. } => {
            if let Some((_, number)) = items.iter().find(|(name, _)| *name == text.trim()) {
                return Ok(Value::Integer(*number));
            }
            let number = whole().ok();
            number
                .filter(|number| items.is_empty() || items.iter().any(|(_, value)| value == number))
                .map(Value::Integer)
                .ok_or_else(|| {
                    let names: Vec<&str> = items.iter().map(|(name, _)| name.as_str()).collect();
                    format!("`{text}` is none of {}", names.join(", "))
                })
        }
    }
}

fn check_limits(variable: &Variable, number: f64) -> Result<(), String> {
    let unit = behind(variable.unit());
    match variable.kind.range() {
        _ if !number.is_finite() => Err(format!("{number} is not a finite number")),
        (Some(min), _) if number < min => Err(format!("{number}{unit} is less than the smallest value {min}{unit}")),
        (_, Some(max)) if number > max => Err(format!("{number}{unit} is more than the largest value {max}{unit}")),
        _ => Ok(()),
    }
}
