//! The distribution of a parameter, from the numbers that the study gives.

use super::quantity::{Quantity, Scale, Sense};
use super::{ParameterText, Shape};
use sampling::distribution::Distribution;

impl ParameterText {
    /// The unit of its first number that has one.
    pub(super) fn first_unit(&self) -> Option<&str> {
        let numbers = [&self.mean, &self.value, &self.min, &self.mode, &self.max];
        numbers
            .into_iter()
            .flatten()
            .find_map(|number| number.unit.as_deref())
    }

    /// The distribution in the study's unit.
    pub(super) fn distribution(&self, scale: &Scale<'_>) -> Result<Distribution, String> {
        let shape = self.distribution;
        let maybe = |number: &Option<Quantity>, sense| {
            number
                .as_ref()
                .map(|number| scale.number(number, sense))
                .transpose()
        };
        let need = |number: &Option<Quantity>, key: &str| {
            let sense = if key == "deviation" {
                Sense::Difference
            } else {
                Sense::Value
            };
            maybe(number, sense)?
                .ok_or_else(|| format!("`{key}` is missing for the distribution {}", shape.name()))
        };
        self.refuse_others()?;
        let [mean, deviation] = [(&self.mean, "mean"), (&self.deviation, "deviation")];
        Ok(match shape {
            Shape::Normal => Distribution::Normal {
                mean: need(mean.0, mean.1)?,
                deviation: need(deviation.0, deviation.1)?,
            },
            Shape::TruncatedNormal => Distribution::TruncatedNormal {
                mean: need(mean.0, mean.1)?,
                deviation: need(deviation.0, deviation.1)?,
                min: maybe(&self.min, Sense::Value)?,
                max: maybe(&self.max, Sense::Value)?,
            },
            Shape::Uniform => Distribution::Uniform {
                min: need(&self.min, "min")?,
                max: need(&self.max, "max")?,
            },
            Shape::Triangular => Distribution::Triangular {
                min: need(&self.min, "min")?,
                mode: need(&self.mode, "mode")?,
                max: need(&self.max, "max")?,
            },
            Shape::Lognormal => Distribution::Lognormal {
                mean: need(mean.0, mean.1)?,
                deviation: need(deviation.0, deviation.1)?,
            },
            // Its values come when the file is read.
            Shape::Sample if self.file.is_some() => Distribution::sample(vec![0.0]),
            Shape::Sample => {
                let message = "`file` is missing for the distribution sample: a table with a column of its values, \
                               such as the posterior.csv of identify";
                return Err(message.to_owned());
            }
            Shape::Fixed => Distribution::Fixed {
                value: need(&self.value, "value")?,
            },
        })
    }

    /// A number that the distribution would ignore is an error: it was meant to do something.
    fn refuse_others(&self) -> Result<(), String> {
        let wanted: &[&str] = match self.distribution {
            Shape::Normal | Shape::Lognormal => &["mean", "deviation"],
            Shape::TruncatedNormal => &["mean", "deviation", "min", "max"],
            Shape::Uniform => &["min", "max"],
            Shape::Triangular => &["min", "mode", "max"],
            Shape::Sample => &["file"],
            Shape::Fixed => &["value"],
        };
        if self.file.is_some() && self.distribution != Shape::Sample {
            let name = self.distribution.name();
            return Err(format!(
                "the distribution {name} does not use `file`; write distribution = \"sample\", or remove it"
            ));
        }
        let given = [
            ("mean", &self.mean),
            ("deviation", &self.deviation),
            ("min", &self.min),
            ("mode", &self.mode),
            ("max", &self.max),
            ("value", &self.value),
        ];
        let stray = given
            .iter()
            .find(|(key, number)| number.is_some() && !wanted.contains(key));
        match stray {
            Some((key, _)) => Err(format!(
                "the distribution {} does not use `{key}`; it takes {}",
                self.distribution.name(),
                wanted.join(", ")
            )),
            None => Ok(()),
        }
    }
}

impl Shape {
    fn name(self) -> &'static str {
        match self {
            Self::Normal => "normal",
            Self::TruncatedNormal => "truncated-normal",
            Self::Uniform => "uniform",
            Self::Triangular => "triangular",
            Self::Lognormal => "lognormal",
            Self::Sample => "sample",
            Self::Fixed => "fixed",
        }
    }
}
