//! The time of an event: a signal's first crossing of a level.

use serde::{Deserialize, Serialize};

use super::collect::Collect;

/// The way in which a signal passes a level.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Direction {
    /// Upwards or downwards.
    #[default]
    Either,
    /// From below it to it.
    Rising,
    /// From above it to it.
    Falling,
}

impl Direction {
    /// Whether a signal that goes from one value to another comes to the level in this direction.
    fn passes(self, level: f64, before: f64, after: f64) -> bool {
        let (rises, falls) = (before < level && after >= level, before > level && after <= level);
        match self {
            Self::Either => rises || falls,
            Self::Rising => rises,
            Self::Falling => falls,
        }
    }
}

/// A signal on straight lines, until it comes to the level.
#[derive(Clone, Copy, Debug, Default)]
pub struct Crossing {
    level: f64,
    direction: Direction,
    last: Option<f64>,
    /// Time since the first value.
    time: f64,
    /// When it came there; not a number where a value up to then was none, or infinite.
    passed: Option<f64>,
    /// The least and the greatest value up to then.
    range: Option<[f64; 2]>,
}

impl Crossing {
    /// The first time at which a signal passes the level in this direction.
    pub fn new(level: f64, direction: Direction) -> Self {
        Self { level, direction, ..Self::default() }
    }

    /// The range of a signal that never came to the level.
    pub fn uncrossed(&self) -> Option<[f64; 2]> {
        self.range.filter(|_| self.passed.is_none())
    }
}

impl Collect for Crossing {
    const LABEL: &'static str = "first crossing";
    const UNIT: Option<&'static str> = Some("s");
    const SINCE_FIRST: bool = true;

    fn add_all(&mut self, values: impl Iterator<Item = (f64, f64)>) {
        for (elapsed, value) in values {
            if self.passed.is_some() {
                return;
            }
            let before = *self.last.get_or_insert(value);
            if !value.is_finite() {
                self.passed = Some(f64::NAN);
            } else if self.direction.passes(self.level, before, value) {
                let share = (self.level - before) / (value - before);
                self.passed = Some(self.time + share * elapsed);
            }
            self.last = Some(value);
            let [low, high] = self.range.unwrap_or([value; 2]);
            self.range = Some([low.min(value), high.max(value)]);
            self.time += elapsed;
        }
    }

    /// The time since the first value; not a number where the signal does not come to the level.
    fn result(&self, _: f64) -> f64 {
        self.passed.unwrap_or(f64::NAN)
    }
}
