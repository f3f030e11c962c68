//! The simulation of a point in the FMU's own terms: plain data that can be sent to
//! another process.

mod curve;
mod inputs;
mod schedule;

pub use curve::{Delay, MeasuredCurve};
pub use inputs::{Series, Unseen, place};
pub use schedule::{CommunicationPoints, Schedule};

use serde::{Deserialize, Serialize};

use fmu_import::{Content, Handle, Value};
use sampling::statistics::{Accumulator, Direction, Statistic};

/// A simulation without the values that vary from point to point.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Task {
    /// When.
    pub schedule: Schedule,
    /// Start values that stay as they are, by value reference.
    pub fixed: Vec<(u32, Value)>,
    /// The variables that take a point's values, in the order of those values.
    pub varied: Vec<Slot>,
    /// The inputs that change over time.
    #[serde(default)]
    pub inputs: Vec<Series>,
    /// Observed statistics, in the order of the results.
    pub observed: Vec<Probe>,
}

/// One of the simulations of a point. A point of a study without cases has one; else it has one a case.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Case {
    /// The case's name; none where the study has no cases.
    pub name: Option<String>,
    /// The simulation.
    pub task: Task,
}

impl Case {
    /// The only simulation of a point.
    pub fn only(task: Task) -> Self {
        Self { name: None, task }
    }
}

/// A point that is run with its trajectory.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Record {
    /// The point's values.
    pub values: Vec<f64>,
    /// Variables that are read at every communication point.
    pub columns: Vec<Handle>,
}

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
    #[serde(default)]
    pub items: Vec<i64>,
}

/// A variable that is observed.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Probe {
    /// Its name.
    pub name: String,
    /// How calls reach it.
    pub handle: Handle,
    /// Statistic that turns the signal into one number.
    pub statistic: Statistic,
    /// From when to when the statistic is taken, s, where that is not the schedule's window.
    #[serde(default)]
    pub window: Option<[f64; 2]>,
    /// The measured curve with which the whole signal is compared; no statistic is taken then.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub curve: Option<Box<MeasuredCurve>>,
    /// A number that the statistic needs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub detail: Option<Detail>,
}

/// A number without which a statistic is not complete.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Detail {
    /// The percent of the time that a percentile leaves below.
    Percent(f64),
    /// The time of a value, s.
    At(f64),
    /// The level that a signal crosses, in the FMU's unit, and the way in which it does.
    Level(f64, Direction),
    /// The angle whose whole turns count, and how much it changes in a turn, in the FMU's unit.
    Turns(Handle, f64),
}

impl Detail {
    /// Words for the statistic.
    pub fn label(self) -> String {
        match self {
            Self::Percent(percent) => format!("{percent} % percentile"),
            Self::At(time) => format!("value at {time} s"),
            Self::Turns(..) => "mean over whole turns".to_owned(),
            Self::Level(..) => Statistic::Crossing.label().to_owned(),
        }
    }
}

impl Probe {
    /// Whether only the value at the end is asked for.
    pub fn is_final(&self) -> bool {
        self.statistic == Statistic::Final && self.curve.is_none() && self.detail.is_none()
    }

    /// Whether it has times of its own, and so looks at the whole run.
    pub fn has_own_times(&self) -> bool {
        self.curve.is_some() || matches!(self.detail, Some(Detail::At(_)))
    }

    /// The angle that is read beside it.
    pub fn angle(&self) -> Option<Handle> {
        match self.detail {
            Some(Detail::Turns(angle, _)) => Some(angle),
            _ => None,
        }
    }

    /// An accumulator of its statistic.
    pub fn accumulator(&self) -> Accumulator {
        match self.detail {
            Some(Detail::Percent(percent)) => Accumulator::percentile(percent),
            Some(Detail::Level(level, direction)) => Accumulator::crossing(level, direction),
            _ => Accumulator::new(self.statistic),
        }
    }
}

impl Slot {
    /// Whether the FMU allows the value.
    ///
    /// # Errors
    /// Says which limit is violated.
    pub fn check(&self, value: f64) -> Result<(), String> {
        let name = &self.name;
        if !value.is_finite() {
            return Err(format!("{name} = {value} is not a finite number"));
        }
        // The limits apply to the number that the FMU gets, after rounding.
        let stored = match self.handle.content {
            Content::Integer => value.round(),
            Content::Real | Content::Boolean | Content::Text => value,
        };
        if !self.items.is_empty() && !self.items.iter().any(|&item| item as f64 == stored) {
            return Err(format!(
                "{name} = {value} is none of the enumeration's items {}",
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
            let items: Vec<String> = self.items.iter().map(i64::to_string).collect();
            return items.join(", ");
        }
        let limit = |limit: Option<f64>| {
            limit.map_or_else(|| "..".to_owned(), |limit| convert(limit).to_string())
        };
        format!("{} to {}", limit(self.min), limit(self.max))
    }

    /// The value as the FMU stores it; whole numbers are rounded.
    pub fn value(&self, value: f64) -> Value {
        self.handle.content.value(value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn handle(content: Content) -> Handle {
        Handle {
            reference: 1,
            content,
        }
    }

    #[test]
    fn whole_numbers_count_as_rounded() {
        let slot = Slot {
            name: "n".to_owned(),
            handle: handle(Content::Integer),
            min: Some(1.0),
            max: Some(4.0),
            items: Vec::new(),
        };
        for (value, allowed) in [(0.51, true), (4.49, true), (0.49, false), (4.51, false)] {
            assert_eq!(slot.check(value).is_ok(), allowed, "{value}");
        }
        assert!(matches!(slot.value(0.51), Value::Integer(1)));
        assert_eq!(slot.allowed(), [[0.5, 4.5]]);
    }

    #[test]
    fn an_enumeration_allows_its_items_only() {
        let slot = Slot {
            name: "e".to_owned(),
            handle: handle(Content::Integer),
            min: None,
            max: None,
            items: vec![1, 2, 5],
        };
        for (value, allowed) in [
            (0.4, false),
            (0.6, true),
            (2.4, true),
            (3.0, false),
            (5.4, true),
            (5.6, false),
        ] {
            assert_eq!(slot.check(value).is_ok(), allowed, "{value}");
        }
        assert_eq!(
            slot.check(4.2).unwrap_err(),
            "e = 4.2 is none of the enumeration's items 1, 2, 5"
        );
        assert_eq!(slot.allowed(), [[0.5, 2.5], [4.5, 5.5]]);
    }
}
