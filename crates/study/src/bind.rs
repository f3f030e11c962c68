//! Ties a study to an FMU: names become variables, units convert, numbers are checked.

mod criteria;
mod simulation;

use fmu_import::{Content, Description, Variable, quantity::Scale, units::Conversion};
use fmu_points::task::{Probe, Slot, Task};
use sampling::design::Joint;
use toml::Spanned;

use crate::{
    CaseText, ParameterText, Result, Study,
    concern::Concern,
    input::Input,
    inputs::{self, Recordings},
    limit::limit,
    measured,
    samples::{self, Together},
    values::{find, slot_of},
};

/// Finds variables and checks values for one FMU.
pub struct Binder<'a> {
    pub study: &'a Study,
    pub fmu: &'a Description,
}

/// A simulation with what belongs to it.
pub struct Bound {
    /// From the FMU's units to the study's, a criterion each.
    pub outputs: Vec<Conversion>,
    /// The simulation.
    pub task: Task,
    /// The errors of its inputs' sensors.
    pub errors: Vec<inputs::InputError>,
    /// Doubts about its inputs.
    pub concerns: Vec<Concern>,
}

impl Binder<'_> {
    /// The simulation of a point, or of one of its cases.
    pub fn task(&self, case: Option<&CaseText>, varied: Vec<Slot>) -> Result<Bound> {
        let mut schedule = self.schedule().map_err(|error| match case {
            None => self.study.error_in("simulation", error.settings, error),
            Some(case) => {
                let name = case.name.as_ref();
                self.study.error_at(&case.name, format!("the simulation of the case `{name}`: {error}"))
            }
        })?;
        let (outputs, observed) = self.criteria(&schedule)?;
        let observed = self.windows(&mut schedule, observed)?;
        let Recordings { series: inputs, errors, mut concerns } = inputs::series(self.study, self.fmu, &schedule)?;
        concerns.extend(self.doubts_of_curves(&observed));
        let (sizes, fixed, exchange) = (self.fmu.sizes.clone(), self.fixed()?, self.exchange());
        let task = Task { schedule, sizes, fixed, exchange, varied, inputs, observed };
        Ok(Bound { outputs, task, errors, concerns })
    }

    /// Doubts about the measured curves of the criteria.
    fn doubts_of_curves(&self, observed: &[Probe]) -> impl Iterator<Item = Concern> {
        self.study.criteria.iter().zip(observed).filter_map(|((name, text), probe)| {
            let curve = probe.measure.curve()?;
            let scale = text.scale(Some((self.fmu, self.variable(&text.variable).ok()?))).ok()?;
            measured::doubt(name.as_ref(), curve, limit(text, curve.metric, &scale).ok()?)
        })
    }

    fn variable<T: AsRef<str>>(&self, name: &Spanned<T>) -> Result<&Variable> {
        find(self.fmu, name.as_ref().as_ref()).map_err(|message| self.study.error_at(name, message))
    }

    /// The parameters, and the variables that take their values, in the order of the study.
    pub fn parameters(&self) -> Result<(Vec<Input>, Vec<Slot>)> {
        self.study
            .parameters
            .iter()
            .map(|(name, parameter)| {
                let variable = self.variable(name)?;
                let at = |message| self.study.error_of(name, message);
                let slot = slot_of(variable).map_err(at)?;
                let input = self.parameter(variable, parameter).map_err(at)?;
                Ok((input, slot))
            })
            .collect()
    }

    /// Reads the parameters that come from samples, and gives each its distribution.
    pub fn samples(&self, inputs: &mut [Input]) -> Result<Vec<Joint>> {
        let samples = samples::read(self.study, inputs)?;
        let mut joints = Vec::new();
        for Together { joint, alone } in samples {
            for (index, distribution) in alone {
                inputs[index].distribution = distribution;
            }
            joints.push(joint);
        }
        Ok(joints)
    }

    /// Checks that the FMU takes the middle of each distribution.
    pub fn within(&self, inputs: &[Input], slots: &[Slot]) -> Result {
        let pairs = inputs.iter().zip(slots);
        for ((input, slot), name) in pairs.zip(self.study.parameters.keys()) {
            let value = input.conversion.value(input.distribution.median());
            slot.check(value).map_err(|message| self.study.error_of(name, message))?;
        }
        Ok(())
    }

    fn parameter(&self, variable: &Variable, parameter: &ParameterText) -> Result<Input, String> {
        let unit = parameter.unit.as_deref().or(parameter.first_unit());
        let scale = Scale::new(unit, self.fmu, variable)?;
        let distribution = parameter.distribution(&scale)?;
        let is_whole = variable.handle().content == Content::Integer;
        let distribution = if is_whole { distribution.whole() } else { distribution };
        distribution.check()?;
        Ok(Input {
            name: variable.name.clone(),
            unit: scale.unit.clone(),
            distribution,
            is_whole,
            conversion: scale.conversion,
        })
    }
}
