//! A variable that takes a point's value.

use serde::{Deserialize, Serialize};

use fmu_import::{Content, Handle, Kind, Value, Variable};

/// A variable that takes a point's value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Slot {
    /// Its name.
    pub name: String,
    /// How calls reach it.
    pub handle: Handle,
    /// The smallest value that the FMU allows.
    pub min: Option<f64>,
    /// The largest value that the FMU allows.
    pub max: Option<f64>,
    /// The values of an enumeration's items, growing; empty for other types.
    pub items: Vec<i128>,
    /// Whether the value is that of another case, and this simulation leaves the variable as it is.
    pub idle: bool,
    /// What the value says of the sensor that recorded this input, where it is no value of the variable.
    pub error: Option<SensorError>,
}

/// An error of the sensor that recorded an input: the model gets the recording without it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum SensorError {
    /// The value is by how much all rows are too high.
    Offset,
    /// The value is by what part of their distance from `about`, the zero of the recording's unit, all rows are too high.
    Gain {
        /// In the FMU's unit.
        about: f64,
    },
    /// The value is a number by which the errors of the single rows are drawn; 0: they have none.
    Noise {
        /// The standard deviation of one row, in the FMU's unit.
        deviation: f64,
    },
}

impl Slot {
    /// How a variable takes a number; none where it is a text.
    pub fn of(variable: &Variable) -> Option<Self> {
        let (min, max) = variable.kind.range();
        let mut items = match &variable.kind {
            Kind::Enumeration { items, .. } => items.iter().map(|(_, value)| *value).collect(),
            _ => Vec::new(),
        };
        items.sort_unstable();
        items.dedup();
        Some(Self {
            name: variable.name.clone(),
            handle: variable.number_handle()?,
            min,
            max,
            items,
            idle: false,
            error: None,
        })
    }

    /// Whether the FMU allows the value.
    ///
    /// # Errors
    /// Says which limit is violated.
    pub fn check(&self, value: f64) -> Result<(), String> {
        let name = &self.name;
        if !value.is_finite() {
            return Err(format!("{name} = {value} is not a finite number"));
        }
        if self.error.is_some() {
            let is_gain = matches!(self.error, Some(SensorError::Gain { .. }));
            return if is_gain && value <= -1.0 {
                Err(format!("a gain error of {value} leaves nothing of the recording of {name}"))
            } else {
                Ok(())
            };
        }
        let stored = self.stored(value);
        if !self.items.is_empty() && !self.items.iter().any(|&item| item as f64 == stored) {
            return Err(format!(
                "{name} = {value} is none of the enumeration's items {}: give a `sample` of them",
                self.allowed_text(|limit| limit)
            ));
        }
        let limit = match (self.min, self.max) {
            (Some(min), _) if stored < min => format!("less than the smallest value {min}"),
            (_, Some(max)) if stored > max => format!("more than the largest value {max}"),
            _ => return Ok(()),
        };
        Err(format!("{name} = {value} is {limit} that the FMU allows"))
    }

    /// The intervals of numbers that the FMU allows, growing and apart from each other. Whole numbers are rounded, so
    /// each stands for half a unit to both sides.
    pub fn allowed(&self) -> Vec<[f64; 2]> {
        let half = match self.handle.content {
            Content::Integer => 0.5,
            Content::Real | Content::Boolean | Content::Text => 0.0,
        };
        if self.items.is_empty() {
            let low = self.min.map_or(f64::NEG_INFINITY, |min| min - half);
            let high = self.max.map_or(f64::INFINITY, |max| max + half);
            return vec![[low, high]];
        }
        let mut allowed: Vec<[f64; 2]> = Vec::new();
        for item in self.items.iter().copied().map(|item| item as f64) {
            match allowed.last_mut() {
                Some(last) if last[1] == item - half => last[1] = item + half,
                _ => allowed.push([item - half, item + half]),
            }
        }
        allowed
    }

    /// The allowed values for people: an enumeration's items, or both limits after a conversion of units.
    pub fn allowed_text(&self, convert: impl Fn(f64) -> f64) -> String {
        if !self.items.is_empty() {
            let items: Vec<String> = self.items.iter().map(i128::to_string).collect();
            return items.join(", ");
        }
        let limit = |limit: Option<f64>| limit.map_or_else(|| "..".to_owned(), |limit| convert(limit).to_string());
        format!("{} to {}", limit(self.min), limit(self.max))
    }

    /// The value as the FMU gets it.
    pub fn value(&self, value: f64) -> Value {
        self.handle.content.value(self.stored(value))
    }

    /// The number that the FMU gets, to which its limits apply: whole numbers are rounded, and what differs from a limit by the
    /// rounding of a conversion (20 um are 1.9999999999999998e-5 m) is the limit.
    fn stored(&self, value: f64) -> f64 {
        const ROUNDING: f64 = 32.0 * f64::EPSILON;
        if self.handle.content == Content::Integer {
            return value.round();
        }
        [self.min, self.max]
            .into_iter()
            .flatten()
            .find(|limit| (value - limit).abs() <= ROUNDING * limit.abs())
            .unwrap_or(value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn handle(content: Content) -> Handle {
        Handle { reference: 1, content }
    }

    #[test]
    fn whole_numbers_count_as_rounded() {
        let slot = Slot {
            name: "n".to_owned(),
            handle: handle(Content::Integer),
            min: Some(1.0),
            max: Some(4.0),
            items: Vec::new(),
            idle: false,
            error: None,
        };
        for (value, allowed) in [(0.51, true), (4.49, true), (0.49, false), (4.51, false)] {
            assert_eq!(slot.check(value).is_ok(), allowed, "{value}");
        }
        assert!(matches!(slot.value(0.51), Value::Integer(1)));
        assert_eq!(slot.allowed(), [[0.5, 4.5]]);
    }

    /// 20 times 1e-6 is less than 2e-5 in binary, and 333.25 K less 273.15 K are no 60.1 degC.
    #[test]
    fn a_limit_in_another_unit_is_the_limit() {
        let mut slot = Slot {
            name: "c".to_owned(),
            handle: handle(Content::Real),
            min: Some(2e-5),
            max: Some(60.1),
            items: Vec::new(),
            idle: false,
            error: None,
        };
        for (converted, limit) in [(20.0 * 1e-6, 2e-5), (333.25 - 273.15, 60.1)] {
            assert_ne!(converted, limit);
            assert_eq!(slot.check(converted), Ok(()));
            assert!(matches!(slot.value(converted), Value::Real(value) if value == limit));
        }
        assert!(slot.check(2e-5 * (1.0 - 1e-13)).is_err() && slot.check(60.1 * (1.0 + 1e-13)).is_err());
        // A limit of 0 is exact in each unit without an offset.
        slot.min = Some(0.0);
        assert!(slot.check(-f64::MIN_POSITIVE).is_err() && slot.check(0.0).is_ok());
    }

    #[test]
    fn an_enumeration_allows_its_items_only() {
        let slot = Slot {
            name: "e".to_owned(),
            handle: handle(Content::Integer),
            min: None,
            max: None,
            items: vec![1, 2, 5],
            idle: false,
            error: None,
        };
        for (value, allowed) in [(0.4, false), (0.6, true), (2.4, true), (3.0, false), (5.4, true), (5.6, false)] {
            assert_eq!(slot.check(value).is_ok(), allowed, "{value}");
        }
        assert_eq!(
            slot.check(4.2).unwrap_err(),
            "e = 4.2 is none of the enumeration's items 1, 2, 5: give a `sample` of them"
        );
        assert_eq!(slot.allowed(), [[0.5, 2.5], [4.5, 5.5]]);
    }
}
