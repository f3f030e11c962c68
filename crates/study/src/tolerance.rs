//! How far a model value may be from the measured one, as a study writes it.

use std::{collections::HashMap, fmt};

use fmu_import::quantity::Quantity;
use serde::Deserialize;

/// How far from the measured value a model value may be.
#[derive(Clone, Debug, Deserialize)]
#[serde(try_from = "ToleranceForm")]
pub enum ToleranceText {
    /// As far to both sides.
    Even(Quantity),
    /// Down and up.
    Uneven {
        /// How far below.
        minus: Quantity,
        /// How far above.
        plus: Quantity,
    },
}

#[derive(Deserialize)]
#[serde(
    untagged,
    expecting = "expected a number, a text such as \"0.02 mm\", or { minus = \"1 mm\", plus = \"2 mm\" }"
)]
enum ToleranceForm {
    Number(f64),
    Text(String),
    Uneven(HashMap<String, Quantity>),
}

impl TryFrom<ToleranceForm> for ToleranceText {
    type Error = String;

    fn try_from(form: ToleranceForm) -> Result<Self, String> {
        Ok(match form {
            ToleranceForm::Number(number) => Self::Even(number.into()),
            ToleranceForm::Text(text) => Self::Even(text.parse()?),
            ToleranceForm::Uneven(mut sides) => match (sides.remove("minus"), sides.remove("plus")) {
                (Some(minus), Some(plus)) if sides.is_empty() => Self::Uneven { minus, plus },
                _ => return Err("expected both sides, { minus = \"1 mm\", plus = \"2 mm\" }".to_owned()),
            },
        })
    }
}

impl ToleranceText {
    /// The largest error of a curve, which has one limit.
    pub fn of_curve(&self) -> Result<&Quantity, String> {
        match self {
            Self::Even(quantity) => Ok(quantity),
            Self::Uneven { .. } => Err(format!(
                "the tolerance {self} is that of a measured value; the error of a curve has one limit, such as \"0.02 N.m\""
            )),
        }
    }
}

impl fmt::Display for ToleranceText {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Even(quantity) => quantity.fmt(f),
            Self::Uneven { minus, plus } => write!(f, "-{minus}/+{plus}"),
        }
    }
}
