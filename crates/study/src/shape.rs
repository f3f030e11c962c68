//! The distribution of a parameter, from the numbers that the study gives.

use super::{ParameterText, Shape};
use fmu_import::quantity::{Quantity, Scale, Sense};
use sampling::{distribution::Distribution, word};

impl ParameterText {
    /// Its numbers, by their keys.
    fn numbers(&self) -> [(&'static str, &Option<Quantity>); 6] {
        [
            ("mean", &self.mean),
            ("value", &self.value),
            ("min", &self.min),
            ("mode", &self.mode),
            ("max", &self.max),
            ("deviation", &self.deviation),
        ]
    }

    /// The unit of its first number that has one; a deviation is a difference, which may have another one.
    pub fn first_unit(&self) -> Option<&str> {
        let mut given = self.numbers().into_iter().take(5).filter_map(|(_, number)| number.as_ref());
        given.find_map(|number| number.unit.as_deref())
    }

    /// The distribution in the study's unit.
    pub fn distribution(&self, scale: &Scale) -> Result<Distribution, String> {
        self.refuse_others()?;
        let maybe = |key: &str| {
            let sense = match key {
                "deviation" => Sense::Difference,
                _ => Sense::Value,
            };
            let (_, number) = self.numbers().into_iter().find(|(name, _)| *name == key)?;
            number.as_ref().map(|number| scale.number(number, sense))
        };
        let need = |key: &str| {
            maybe(key).unwrap_or_else(|| {
                let name = word(&self.distribution);
                Err(format!("`{key}` is missing for the distribution {name}"))
            })
        };
        Ok(match self.distribution {
            Shape::Normal => Distribution::Normal { mean: need("mean")?, deviation: need("deviation")? },
            Shape::TruncatedNormal => Distribution::TruncatedNormal {
                mean: need("mean")?,
                deviation: need("deviation")?,
                min: maybe("min").transpose()?,
                max: maybe("max").transpose()?,
            },
            Shape::Uniform => Distribution::Uniform { min: need("min")?, max: need("max")? },
            Shape::Triangular => Distribution::Triangular { min: need("min")?, mode: need("mode")?, max: need("max")? },
            Shape::Lognormal => Distribution::Lognormal { mean: need("mean")?, deviation: need("deviation")? },
            // Its values come when the file is read.
            Shape::Sample if self.file.is_some() => Distribution::sample(vec![0.0]),
            Shape::Sample => {
                return Err("`file` is missing for the distribution sample: a table with a column of its values, \
                               such as the posterior.csv of identify"
                    .to_owned());
            }
            Shape::Fixed => Distribution::Fixed { value: need("value")? },
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
        let name = word(&self.distribution);
        if self.file.is_some() && self.distribution != Shape::Sample {
            return Err(format!(
                "the distribution {name} does not use `file`; write distribution = \"sample\", or remove it"
            ));
        }
        let is_stray = |(key, number): &(&str, &Option<Quantity>)| number.is_some() && !wanted.contains(key);
        match self.numbers().iter().find(|given| is_stray(given)) {
            Some((key, _)) => {
                Err(format!("the distribution {name} does not use `{key}`; it takes {}", wanted.join(", ")))
            }
            None => Ok(()),
        }
    }
}
