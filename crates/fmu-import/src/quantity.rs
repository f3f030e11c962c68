//! Numbers with units as people write them, such as `0.02 mm`, and their way to the unit of a variable.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::{
    description::{Description, Variable},
    units::{Conversion, known, split},
};

/// A number in the unit of its table, or a number with a unit of its own.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(try_from = "Form")]
pub struct Quantity {
    /// The number.
    pub number: f64,
    /// Its own unit.
    pub unit: Option<String>,
}

impl From<f64> for Quantity {
    fn from(number: f64) -> Self {
        Self { number, unit: None }
    }
}

impl std::str::FromStr for Quantity {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (number, unit) = split(text)?;
        Ok(Self { number, unit: unit.map(str::to_owned) })
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match &self.unit {
            Some(unit) => write!(f, "{} {unit}", self.number),
            None => write!(f, "{}", self.number),
        }
    }
}

/// A quantity as a study writes it.
#[derive(Deserialize)]
#[serde(untagged, expecting = "expected a number, or a text such as \"0.02 mm\"")]
enum Form {
    Number(f64),
    Text(String),
}

impl TryFrom<Form> for Quantity {
    type Error = String;

    fn try_from(form: Form) -> Result<Self, String> {
        match form {
            Form::Number(number) => Ok(number.into()),
            Form::Text(text) => text.parse(),
        }
    }
}

/// The unit in which a study gives a quantity, and its way to the FMU's.
#[derive(Clone, Debug)]
pub struct Scale<'a> {
    /// The study's unit.
    pub unit: Option<String>,
    /// Whether the study states it; otherwise it is the variable's.
    is_stated: bool,
    /// From the study's unit to the variable's.
    pub conversion: Conversion,
    base: ScaleTarget<'a>,
}

/// That to which a scale converts.
#[derive(Clone, Copy, Debug)]
enum ScaleTarget<'a> {
    /// A variable's unit.
    Variable(&'a Description, &'a Variable),
    /// Seconds or hertz.
    Own(&'static str),
    /// The FMU is missing.
    Unknown,
}

/// From a unit of time to seconds, or from one of frequency to hertz.
///
/// # Errors
/// When the unit is none of them.
pub fn to_own(unit: &str, si_unit: &'static str) -> Result<Conversion, String> {
    known::between(unit, si_unit).ok_or_else(|| match si_unit {
        "s" => format!("`{unit}` is no unit of time: use s, ms, min or h"),
        _ => format!("`{unit}` is no unit of frequency: use Hz, kHz, 1/s or rpm"),
    })
}

/// Whether a study's number is a value or a difference: temperatures convert differently.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Sense {
    /// A value, such as a nominal temperature.
    Value,
    /// A difference of values, such as a tolerance or a standard deviation.
    Difference,
}

impl<'a> Scale<'a> {
    /// The scale of a quantity that the study gives in `unit`, of an FMU's variable.
    ///
    /// # Errors
    /// When the units don't fit.
    pub fn new(unit: Option<&str>, fmu: &'a Description, variable: &'a Variable) -> Result<Self, String> {
        let conversion = match unit {
            Some(unit) => fmu.conversion(unit, variable).map_err(|error| error.to_string())?,
            None => Conversion::IDENTITY,
        };
        Ok(Self {
            unit: unit.or(variable.unit()).map(str::to_owned),
            is_stated: unit.is_some(),
            conversion,
            base: ScaleTarget::Variable(fmu, variable),
        })
    }

    /// The scale of a time or a frequency, whatever the FMU's variable is measured in; `si_unit` is "s" or "Hz".
    ///
    /// # Errors
    /// When the unit is none of time, or none of frequency.
    pub fn in_si(unit: Option<&str>, si_unit: &'static str) -> Result<Self, String> {
        Ok(Self {
            unit: Some(unit.unwrap_or(si_unit).to_owned()),
            is_stated: unit.is_some(),
            conversion: unit.map_or(Ok(Conversion::IDENTITY), |unit| to_own(unit, si_unit))?,
            base: ScaleTarget::Own(si_unit),
        })
    }

    /// The scale of a quantity of which no FMU knows: all numbers must be in `unit`.
    pub fn alone(unit: Option<&str>) -> Self {
        Self {
            unit: unit.map(str::to_owned),
            is_stated: unit.is_some(),
            conversion: Conversion::IDENTITY,
            base: ScaleTarget::Unknown,
        }
    }

    /// A quantity's number in the study's unit.
    ///
    /// # Errors
    /// When the quantity's own unit doesn't fit, or cannot be converted without an FMU.
    pub fn number(&self, quantity: &Quantity, sense: Sense) -> Result<f64, String> {
        let conversion = match &quantity.unit {
            None => Conversion::IDENTITY,
            Some(unit) => self.from(unit)?,
        };
        Ok(match sense {
            Sense::Value => conversion.value(quantity.number),
            Sense::Difference => conversion.difference(quantity.number),
        })
    }

    /// A part of a quantity's amount, such as 1 % of 82 degC, as a difference in the study's unit. It is a part of the
    /// number as written: 1 % of 82 degC is 0.82 degC, not 1 % of 355.15 K.
    ///
    /// # Errors
    /// As [`number`](Self::number), and when the study states another unit with another zero, so that the part could
    /// be one of either number.
    pub fn part(&self, part: f64, of: &Quantity) -> Result<f64, String> {
        let amount = part * of.number.abs();
        let Some(of_unit) = &of.unit else { return Ok(amount) };
        let conversion = self.from(of_unit)?;
        if self.is_stated && conversion.value(0.0) != 0.0 {
            let unit = self.unit.as_deref().unwrap_or_default();
            let converted = conversion.value(of.number);
            let percent = 100.0 * part;
            return Err(format!(
                "{percent} % could be that of {of} or of {converted:.6} {unit}; give it with a unit, such as \
                 \"{amount:.6} {of_unit}\" or \"{:.6} {unit}\"",
                part * converted.abs()
            ));
        }
        Ok(conversion.difference(amount))
    }

    /// From `unit` to the study's unit.
    ///
    /// # Errors
    /// When the units don't fit, or cannot be converted without an FMU.
    pub fn from(&self, unit: &str) -> Result<Conversion, String> {
        if self.unit.as_deref() == Some(unit) {
            return Ok(Conversion::IDENTITY);
        }
        let to_base = match self.base {
            ScaleTarget::Variable(fmu, variable) => {
                fmu.conversion(unit, variable).map_err(|error| error.to_string())?
            }
            ScaleTarget::Own(si_unit) => to_own(unit, si_unit)?,
            ScaleTarget::Unknown => {
                let target = self.unit.as_deref().unwrap_or("no unit");
                return Err(format!("unit `{unit}` cannot be converted to {target} without the FMU, which is missing"));
            }
        };
        Ok(to_base.then(self.conversion.inverse()))
    }
}
