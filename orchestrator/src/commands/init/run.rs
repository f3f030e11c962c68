//! One run of the FMU as it is: what its outputs do.

use std::time::{Duration, Instant};

use crate::{
    cli::Init,
    commands::{isolated::Isolated, simulate::advised},
    error::Error,
};
use fmu_import::{Description, Handle, Value, Variable};
use fmu_points::{failure::Failure, task::Task};
use sampling::statistics::{Accumulator, Statistic};

/// The longest time of the run.
const PATIENCE: Duration = Duration::from_secs(60);

/// The tolerance of the study that is written, as a part of the value.
pub const TOLERANCE: f64 = 0.05;
/// Less than this part of its range is next to nothing.
pub const SMALL: f64 = 0.01;

/// What a variable did, in its own unit.
pub struct Signal<'a> {
    pub variable: &'a Variable,
    pub least: f64,
    pub most: f64,
    pub is_finite: bool,
    last: f64,
    mean: Accumulator,
    rms: Accumulator,
    span: f64,
    /// How often it turned in the second half of the run.
    turns: u32,
    way: f64,
}

impl<'a> Signal<'a> {
    fn new(variable: &'a Variable) -> Self {
        Self {
            variable,
            least: f64::INFINITY,
            most: f64::NEG_INFINITY,
            is_finite: true,
            last: f64::NAN,
            mean: Accumulator::new(Statistic::Mean),
            rms: Accumulator::new(Statistic::Rms),
            span: 0.0,
            turns: 0,
            way: 0.0,
        }
    }

    fn add(&mut self, elapsed: f64, value: f64, counts: bool) {
        self.is_finite &= value.is_finite();
        let way = value - self.last;
        if way * self.way < 0.0 && counts {
            self.turns += 1;
        }
        if way != 0.0 && way.is_finite() {
            self.way = way;
        }
        (self.least, self.most) = (self.least.min(value), self.most.max(value));
        self.mean.add(elapsed, value);
        self.rms.add(elapsed, value);
        self.span += elapsed;
        self.last = value;
    }

    pub fn moves(&self) -> bool {
        self.is_finite && self.least < self.most
    }

    /// A statistic that tells of it, and its value. Of what still swings at the end, one instant says little; of what is next
    /// to nothing, its tolerance could be no part.
    pub fn value(&self) -> (Statistic, f64) {
        let mut statistic = if self.turns > 1 { Statistic::Mean } else { Statistic::Final };
        if self.of(statistic).abs() < SMALL * (self.most - self.least) {
            statistic = Statistic::Rms;
        }
        (statistic, self.of(statistic))
    }

    fn of(&self, statistic: Statistic) -> f64 {
        match statistic {
            Statistic::Mean => self.mean.result(self.span),
            Statistic::Rms => self.rms.result(self.span),
            _ => self.last,
        }
    }
}

/// Runs the FMU once and looks at these variables.
pub fn signals<'a>(isolated: &Isolated, task: &Task, variables: &[&'a Variable]) -> Result<Vec<Signal<'a>>, Error> {
    let handles: Vec<Handle> = variables.iter().map(|variable| variable.handle()).collect();
    let mut signals: Vec<Signal> = variables.iter().map(|v| Signal::new(v)).collect();
    let middle = 0.5 * (task.schedule.start + task.schedule.stop);
    let mut before = None;
    isolated.observe(task, &handles, Instant::now().checked_add(PATIENCE), |time, values| {
        let elapsed = time - before.replace(time).unwrap_or(time);
        for (signal, value) in signals.iter_mut().zip(values) {
            let value = match value {
                Value::Real(value) => *value,
                Value::Integer(value) => *value as f64,
                Value::Boolean(_) | Value::String(_) => f64::NAN,
            };
            signal.add(elapsed, value, time > middle);
        }
    })?;
    Ok(signals)
}

/// What to do about a run that failed.
pub fn advice(error: Error, options: &Init, fmu: &Description, step: f64) -> Error {
    match error {
        Error::Simulation(Failure::Timeout) => {
            let message = format!(
                "one run takes longer than {} s, which is too long for a first study: give an earlier end or a longer --step",
                PATIENCE.as_secs()
            );
            Error::option("stop", message)
        }
        other => {
            let ours = options.step.is_none() && fmu.default_experiment.step.is_none();
            advised(other, ours.then_some(step))
        }
    }
}
