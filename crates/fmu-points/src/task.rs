//! The simulation of a point in the FMU's own terms: plain data that can be sent to
//! another process.

mod curve;
mod inputs;
mod schedule;
mod slot;

pub use curve::{CurveErrors, MeasuredCurve, Resampling};
pub use inputs::{Series, Unseen, place};
pub use schedule::{CommunicationPoints, Schedule, ScheduleError};
pub use slot::{SensorError, Slot};

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use fmu_import::{Handle, Value, Variable};
use sampling::statistics::{Accumulator, Direction};

pub use sampling::statistics::Statistic;

/// A simulation without the values that vary from point to point.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Task {
    /// When.
    pub schedule: Schedule,
    /// The sizes of arrays: structural parameters by value reference, as [`Description::sizes`](fmu_import::Description::sizes)
    /// has them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sizes: Vec<(u32, u64)>,
    /// Start values that stay as they are, by value reference.
    pub fixed: Vec<(u32, Value)>,
    /// Of an FMU made of several: the variable that says how many of its finest steps lie between two exchanges of values inside of
    /// it, by value reference, and its value. No communication step from outside changes those.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub exchange: Option<(u32, i128)>,
    /// The variables that take a point's values, in the order of those values.
    pub varied: Vec<Slot>,
    /// The inputs that change over time.
    pub inputs: Vec<Series>,
    /// Observed statistics, in the order of the results.
    pub observed: Vec<Probe>,
}

impl Task {
    /// A simulation in which nothing varies, and nothing is observed.
    pub fn new(schedule: Schedule) -> Self {
        Self {
            schedule,
            sizes: Vec::new(),
            fixed: Vec::new(),
            exchange: None,
            varied: Vec::new(),
            inputs: Vec::new(),
            observed: Vec::new(),
        }
    }

    /// Halves the communication step so many times, and with it the time between the exchanges of values inside of the FMU.
    pub fn halve_steps(&mut self, times: u32) {
        self.schedule.step /= f64::from(2_u32.pow(times));
        if let Some((reference, steps)) = self.exchange {
            let steps = (steps >> times).max(1);
            self.exchange = Some((reference, steps));
            self.fixed.retain(|(fixed, _)| *fixed != reference);
            self.fixed.push((reference, Value::Integer(steps)));
        }
    }
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
    pub window: Option<[f64; 2]>,
    /// The measured curve with which the whole signal is compared; no statistic is taken then.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub curve: Option<Arc<MeasuredCurve>>,
    /// A number that the statistic needs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub detail: Option<Detail>,
    /// The variable's unit, for people.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// Where it is the product of another variable and a recorded input: the rig multiplied by the reading, errors and all, and so
    /// does the result.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub product: Option<Product>,
}

/// The factors of a variable.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Product {
    /// The other variable.
    pub of: Handle,
    /// The recorded input.
    pub by: Handle,
    /// The variable over the product of both, which is 1 where their units are coherent.
    pub factor: f64,
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
    /// A statistic of a variable; none where that is a text.
    pub fn of(variable: &Variable, statistic: Statistic) -> Option<Self> {
        Some(Self {
            name: variable.name.clone(),
            handle: variable.number_handle()?,
            statistic,
            window: None,
            curve: None,
            detail: None,
            unit: variable.unit().map(str::to_owned),
            product: None,
        })
    }

    /// Whether only the value at the end is asked for.
    pub fn is_final(&self) -> bool {
        self.statistic == Statistic::Final && self.curve.is_none() && self.detail.is_none()
    }

    /// Whether it has times of its own, and so looks at the whole run.
    pub fn has_own_times(&self) -> bool {
        self.curve.is_some() || matches!(self.detail, Some(Detail::At(_)))
    }

    /// The angle that is read beside it.
    pub fn companion(&self) -> Option<Handle> {
        match self.detail {
            Some(Detail::Turns(angle, _)) => Some(angle),
            _ => None,
        }
    }

    /// One that reads the variable at a time of the model's clock, s, in the unit of a measured curve.
    pub fn at_row(&self, curve: &MeasuredCurve, time: f64) -> Self {
        Self { curve: Some(Arc::new(curve.read_at(time))), ..self.clone() }
    }

    /// Whether another one takes the same statistic of the same part of the run.
    pub fn looks_as(&self, other: &Self) -> bool {
        self.curve.is_none()
            && other.curve.is_none()
            && (self.statistic, self.window, self.detail) == (other.statistic, other.window, other.detail)
    }

    /// When it reads a row of a curve, on the model's clock, s.
    pub(crate) fn row(&self) -> Option<f64> {
        self.curve.as_ref().filter(|curve| curve.reads)?.times.first().copied()
    }

    /// Whether the other one reads a later row of the same curve.
    pub(crate) fn goes_on_in(&self, next: &Self) -> bool {
        let conversion = |probe: &Self| {
            let curve = probe.curve.as_ref();
            curve.map(|curve| [curve.factor, curve.offset])
        };
        let rows = self.row().zip(next.row());
        rows.is_some_and(|(row, later)| row < later)
            && self.handle == next.handle
            && self.window == next.window
            && conversion(self) == conversion(next)
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

#[cfg(test)]
mod exchange_tests {
    use super::*;

    #[test]
    fn steps_inside_are_halved_with_those_outside() {
        let schedule = Schedule { start: 0.0, stop: 8.0, step: 0.8, window_start: 0.0, leap: false, tolerance: None };
        let other = (8, Value::Real(1.0));
        let given =
            Task { exchange: Some((7, 4)), fixed: vec![(7, Value::Integer(4)), other.clone()], ..Task::new(schedule) };
        for (times, steps) in [(1, 2), (2, 1)] {
            let mut task = given.clone();
            task.halve_steps(times);
            assert_eq!(task.schedule.step, 0.8 / f64::from(4 / steps));
            assert_eq!(task.fixed, [other.clone(), (7, Value::Integer(steps.into()))]);
        }
    }
}
