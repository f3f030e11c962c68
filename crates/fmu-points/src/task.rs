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
use sampling::statistics::Direction;

pub use sampling::statistics::Statistic;

/// A simulation without the values that vary from point to point.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Task {
    /// When.
    pub schedule: Schedule,
    /// The sizes of arrays: structural parameters by value reference, as [`Description::sizes`](fmu_import::Description::sizes)
    /// has them.
    pub sizes: Vec<(u32, u64)>,
    /// Start values that stay as they are, by value reference.
    pub fixed: Vec<(u32, Value)>,
    /// Of an FMU made of several: when they exchange values. No communication step from outside changes that.
    pub exchange: Option<InnerExchange>,
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
        self.schedule.step *= 0.5_f64.powi(i32::try_from(times).unwrap_or(i32::MAX));
        let Some(InnerExchange { reference, start }) = self.exchange else { return };
        let set = self.fixed.iter().find_map(|(fixed, value)| match value {
            Value::Integer(steps) if *fixed == reference => Some(*steps),
            _ => None,
        });
        if let Some(steps) = set.or(start) {
            let steps = steps.checked_shr(times).unwrap_or(0).max(1);
            self.fixed.retain(|(fixed, _)| *fixed != reference);
            self.fixed.push((reference, Value::Integer(steps)));
        }
    }
}

/// The variable of an FMU made of several that says how many of its finest steps lie between two exchanges of values inside of it.
/// Its value is that in [`Task::fixed`], or where that has none, the FMU's own.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct InnerExchange {
    /// Its value reference.
    pub reference: u32,
    /// The value that it has in the FMU, where that states one.
    pub start: Option<i128>,
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
    /// What turns the signal into one number.
    pub measure: Measure,
    /// From when to when the signal is looked at, s, where that is not the schedule's window.
    pub window: Option<[f64; 2]>,
    /// The variable's unit, for people.
    pub unit: Option<String>,
    /// The variable is (another variable) x (a recorded input). The rig computed it with the sensor's reading, errors included, so
    /// the model's value is computed with that reading, too.
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

/// What turns a signal into one number.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Measure {
    /// A statistic that needs no number.
    Statistic(Statistic),
    /// The value that so many percent of the time are below.
    Percentile(f64),
    /// The value at a time, s.
    At(f64),
    /// The time from the begin of the window to the first crossing of a level.
    Crossing {
        /// The level, in the FMU's unit.
        level: f64,
        /// The way in which the signal crosses it.
        direction: Direction,
    },
    /// The mean over the whole turns of an angle.
    MeanOverTurns {
        /// The angle.
        angle: Handle,
        /// How much it changes in a turn, in the FMU's unit.
        turn: f64,
    },
    /// The comparison of the whole signal with a measured curve.
    Curve(Arc<MeasuredCurve>),
    /// The value at the time of a curve's row, in the unit of the curve: `factor * value + offset`.
    Row {
        /// When, on the model's clock, s.
        time: f64,
        /// From the FMU's unit to the curve's.
        factor: f64,
        /// See `factor`.
        offset: f64,
    },
}

impl Measure {
    /// Whether only the value at the end is asked for.
    pub fn is_final(&self) -> bool {
        matches!(self, Self::Statistic(Statistic::Final))
    }

    /// Whether it has times of its own, and so looks at the whole run.
    pub fn has_own_times(&self) -> bool {
        matches!(self, Self::At(_) | Self::Curve(_) | Self::Row { .. })
    }

    /// The angle that is read beside the signal.
    pub fn companion(&self) -> Option<Handle> {
        match self {
            Self::MeanOverTurns { angle, .. } => Some(*angle),
            _ => None,
        }
    }

    /// The statistic; none of a measured curve.
    pub fn statistic(&self) -> Option<Statistic> {
        match self {
            Self::Statistic(statistic) => Some(*statistic),
            Self::Percentile(_) => Some(Statistic::Percentile),
            Self::At(_) => Some(Statistic::Final),
            Self::Crossing { .. } => Some(Statistic::Crossing),
            Self::MeanOverTurns { .. } => Some(Statistic::Mean),
            Self::Curve(_) | Self::Row { .. } => None,
        }
    }

    /// Whether it is a difference of two values, which has no offset when units convert.
    pub fn is_difference(&self) -> bool {
        self.statistic().is_some_and(Statistic::is_difference)
    }

    /// The measured curve with which the signal is compared.
    pub fn curve(&self) -> Option<&MeasuredCurve> {
        match self {
            Self::Curve(curve) => Some(curve),
            _ => None,
        }
    }
}

impl Probe {
    /// A statistic of a variable; none where that is a text.
    pub fn of(variable: &Variable, statistic: Statistic) -> Option<Self> {
        Some(Self {
            name: variable.name.clone(),
            handle: variable.number_handle()?,
            measure: Measure::Statistic(statistic),
            window: None,
            unit: variable.unit().map(str::to_owned),
            product: None,
        })
    }

    /// One that reads the variable at a time of the model's clock, s, in the unit of a measured curve.
    pub fn at_row(&self, curve: &MeasuredCurve, time: f64) -> Self {
        Self { measure: Measure::Row { time, factor: curve.factor, offset: curve.offset }, ..self.clone() }
    }

    /// Whether another one takes the same statistic of the same part of the run.
    pub fn takes_same_statistic(&self, other: &Self) -> bool {
        self.measure.statistic().is_some() && (&self.measure, self.window) == (&other.measure, other.window)
    }

    /// Whether the other one reads a later row of the same curve.
    pub(crate) fn is_followed_by(&self, next: &Self) -> bool {
        let (Measure::Row { time, factor, offset }, Measure::Row { time: later, factor: f, offset: o }) =
            (&self.measure, &next.measure)
        else {
            return false;
        };
        time < later && (factor, offset, self.handle, self.window) == (f, o, next.handle, next.window)
    }
}

#[cfg(test)]
mod exchange_tests {
    use super::*;

    #[test]
    fn steps_inside_are_halved_with_those_outside() {
        let schedule = Schedule { start: 0.0, stop: 8.0, step: 0.8, window_start: 0.0, leap: false, tolerance: None };
        let other = (8, Value::Real(1.0));
        let exchange = |start| Some(InnerExchange { reference: 7, start });
        let set = vec![(7, Value::Integer(4)), other.clone()];
        for (exchange, fixed) in [(exchange(Some(9)), set), (exchange(Some(4)), vec![other.clone()])] {
            for (times, steps) in [(1, 2), (2, 1), (40, 1), (200, 1)] {
                let mut task = Task { exchange, fixed: fixed.clone(), ..Task::new(schedule) };
                task.halve_steps(times);
                assert_eq!(task.schedule.step, 0.8 / f64::from(times).exp2());
                assert_eq!(task.fixed, [other.clone(), (7, Value::Integer(steps))]);
            }
        }
        let mut task = Task { exchange: exchange(None), ..Task::new(schedule) };
        task.halve_steps(1);
        assert_eq!(task.fixed, []);
    }
}
