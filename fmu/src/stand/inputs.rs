//! The stand's inputs, which may vary linearly within a step.

use super::Stand;
use fmu_export::model::{Fault, Kind, Model, Role};
use serde::{Deserialize, Serialize};

/// An input during a step.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Input {
    /// Value at the start of the step.
    pub value: f64,
    /// Time derivative during the step.
    pub slope: f64,
}

impl Input {
    const fn constant(value: f64) -> Self {
        Self { value, slope: 0.0 }
    }

    pub(super) fn at(&self, tau: f64) -> f64 {
        self.value + self.slope * tau
    }
}

/// The number of inputs.
pub const INPUTS: usize = 6;

/// The inputs, which the host sets.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Inputs {
    /// Mean shaft speed, rad/s.
    pub speed: Input,
    /// Force added to the load mechanism's, N.
    pub external_force: Input,
    /// Force along the load mechanism's, N.
    pub external_force_x: Input,
    /// Force a quarter turn ahead of it in the direction of rotation, N.
    pub external_force_y: Input,
    /// Temperature of the surroundings, K.
    pub ambient_temperature: Input,
    /// Speed of the bush, rad/s.
    pub bush_speed: Input,
}

impl Inputs {
    /// All of them.
    pub(super) fn all(mut self) -> [Input; INPUTS] {
        self.each_of().map(|input| *input)
    }

    /// Changes each of them.
    pub(super) fn each(&mut self, change: impl Fn(&mut Input)) {
        self.each_of().into_iter().for_each(change);
    }

    fn each_of(&mut self) -> [&mut Input; INPUTS] {
        let Self { speed, external_force, external_force_x, external_force_y, ambient_temperature, bush_speed } = self;
        [speed, external_force, external_force_x, external_force_y, ambient_temperature, bush_speed]
    }
}

impl Default for Inputs {
    fn default() -> Self {
        Self {
            speed: Input::constant(10.0 * std::f64::consts::PI),
            external_force: Input::constant(0.0),
            external_force_x: Input::constant(0.0),
            external_force_y: Input::constant(0.0),
            ambient_temperature: Input::constant(295.15),
            bush_speed: Input::constant(0.0),
        }
    }
}

impl Stand {
    /// Refuses times so far from zero that rounding would blur the drive's phase.
    pub(super) fn check_time(time: f64) -> Result<(), String> {
        /// Some 30,000 years, s. Here neighbouring numbers are 0.1 ms apart.
        const FARTHEST: f64 = 1e12;
        if time.abs() <= FARTHEST {
            return Ok(());
        }
        Err(format!(
            "a time of {time:e} s: it must lie between {:e} and {FARTHEST:e} s; start nearer to zero",
            -FARTHEST
        ))
    }

    /// Refuses a step at whose end an input would be out of its range.
    pub(super) fn check_inputs_after(&mut self, span: f64) -> Result<(), Fault> {
        // A ramp that is meant to end at the bound may pass it by a rounding error.
        const ROUNDING: f64 = 1e-9;
        let now = self.inputs;
        if now.all().iter().all(|input| input.slope == 0.0) {
            return Ok(());
        }
        self.inputs.each(|input| input.value = input.at(span));
        let mut inputs = Self::variables().iter().filter(|v| v.role == Role::Input);
        let left = inputs.find_map(|variable| {
            let Kind::Real(real) = &variable.kind else {
                return None;
            };
            let (min, max) = (real.min?, real.max?);
            let (value, unit) = ((real.access.get)(self), real.unit.name);
            let slack = ROUNDING * (max - min);
            let within = (min - slack..=max + slack).contains(&value);
            (!within).then(|| {
                Fault::Failed(format!(
                    "the step over {span:?} s would take {} to {value:?} {unit}: it must lie between {min:?} and {max:?} \
                     {unit}; set a smaller input derivative or take a shorter step",
                    variable.name
                ))
            })
        });
        self.inputs = now;
        left.map_or(Ok(()), Err)
    }
}
