//! A study that fits an FMU: its points in the FMU's units, their results in those of the study.

mod concerns;
mod places;

use std::{ops::Range, sync::Arc};

use fmu_import::{Description, units::Conversion};
use fmu_points::task::{Case, Measure, Probe, Slot};
use sampling::{
    design::{Joint, correlation::Correlation},
    distribution::Distribution,
};

use super::{
    CaseText, Study,
    bind::{Binder, Bound},
    inputs::{InputError, taken_as_exact},
    points,
};
use crate::{Result, concern::Concern};

pub use super::{
    input::Input,
    values::{bare, find, size_of, slot_of, value_of},
};

/// A study that fits an FMU.
#[derive(Debug)]
pub struct Plan {
    /// The simulations of a point, in the FMU's own terms: one, or one a case of the study. Their results, one after the
    /// other, are those of the criteria in the order of the study.
    pub cases: Vec<Case>,
    /// The variables that take the parameters' values.
    pub slots: Vec<Slot>,
    /// The parameters, in the order of the study; after them the errors of recorded inputs.
    pub inputs: Vec<Input>,
    /// From the FMU's unit to the study's, a criterion each.
    pub outputs: Vec<Conversion>,
    /// How the parameters are correlated, if they are, by their places among the inputs.
    pub correlation: Option<Correlation>,
    /// The parameters that are drawn from samples, by file; those of one file together.
    pub joints: Vec<Joint>,
    /// What the sensors of recorded inputs may read wrong.
    pub input_errors: Vec<InputError>,
    /// Doubts about recordings.
    of_inputs: Vec<Concern>,
}

impl Plan {
    /// Ties the study to the FMU.
    ///
    /// # Errors
    /// With line and column, when a name, a unit or a number of the study doesn't fit.
    pub fn new(study: &Study, fmu: &Description) -> Result<Self> {
        let mut from_case_to_case = study.parameters.values().filter_map(|text| text.varies.as_ref());
        if let Some(varies) = from_case_to_case.next() {
            return Err(study.error_at(
                varies,
                "only identify gives each case its own value; remove `varies`, and the cases have one value in common",
            ));
        }
        let binder = Binder { study, fmu };
        let (mut inputs, slots) = binder.parameters()?;
        let joints = binder.samples(&mut inputs)?;
        binder.within(&inputs, &slots)?;
        let mut plan = Self {
            cases: Vec::new(),
            slots,
            inputs,
            outputs: Vec::new(),
            correlation: None,
            joints,
            input_errors: Vec::new(),
            of_inputs: Vec::new(),
        };
        for (case, study) in study.by_case() {
            study.once(fmu, study.set())?;
            let bound = Binder { study: &study, fmu }.task(case, plan.slots.clone())?;
            plan.add_case(case, &study, bound);
        }
        plan.add_input_errors();
        plan.correlation = points::correlation(study, plan.inputs.len())?;
        Ok(plan)
    }

    /// Adds a simulation, with the errors of its recorded inputs and the doubts about them.
    fn add_case(&mut self, case: Option<&CaseText>, study: &Study, bound: Bound) {
        let Bound { outputs, task, errors, concerns } = bound;
        self.outputs.extend(outputs);
        for error in errors {
            let pairs = study.criteria.iter().zip(&task.observed);
            for ((name, _), _) in pairs.filter(|((_, text), probe)| error.is_missed(text, probe)) {
                self.of_inputs.push(taken_as_exact(&error.name, &format!("the product {}", name.as_ref())));
            }
            error.join(&mut self.input_errors, self.cases.len(), case);
        }
        self.of_inputs.extend(match case {
            None => concerns,
            Some(case) => concerns::of_case(case, concerns),
        });
        self.cases.push(Case { name: case.map(|case| case.name.as_ref().clone()), task });
    }

    /// Adds what the sensors of recorded inputs may read wrong as inputs of their own.
    fn add_input_errors(&mut self) {
        for error in &self.input_errors {
            for (number, case) in self.cases.iter_mut().enumerate() {
                case.task.varied.push(error.slot_of(number));
            }
            self.slots.push(error.slot.clone());
            self.inputs.push(Input {
                name: error.name.clone(),
                unit: error.unit.clone(),
                distribution: Distribution::Normal { mean: 0.0, deviation: error.spread },
                conversion: error.conversion,
                is_whole: false,
            });
        }
    }

    /// Leaves out the draws of measured curves, which nothing but the risk of a verdict needs.
    pub fn forget_resampling(&mut self) {
        let observed = self.cases.iter_mut().flat_map(|case| &mut case.task.observed);
        for probe in observed {
            if let Measure::Curve(curve) = &mut probe.measure {
                Arc::make_mut(curve).resampling = None;
            }
        }
    }

    /// The parameters that vary, by their places among the inputs.
    pub fn varied(&self) -> Vec<usize> {
        (0..self.inputs.len()).filter(|&k| self.inputs[k].distribution.varies()).collect()
    }

    /// The parameters that have a tolerance, by their places among the inputs: those that vary, and come from no sample, which
    /// is as wide as it is.
    pub fn with_tolerances(&self) -> Vec<usize> {
        let sampled = |k: &usize| self.joints.iter().any(|joint| joint.inputs().contains(k));
        let mut varied = self.varied();
        varied.retain(|k| !sampled(k));
        varied
    }

    /// Whether every parameter varies on its own.
    pub fn is_independent(&self) -> bool {
        self.correlation.is_none() && !self.joints.iter().any(Joint::binds)
    }

    /// The names of parameters that are drawn together with others from a sample.
    pub fn together(&self) -> Vec<&str> {
        self.joints
            .iter()
            .filter(|joint| joint.binds())
            .flat_map(Joint::inputs)
            .map(|&k| self.inputs[k].name.as_str())
            .collect()
    }

    /// The observations of each criterion, in the order of the study.
    pub fn probes(&self) -> impl Iterator<Item = &Probe> {
        self.cases.iter().flat_map(|case| &case.task.observed)
    }

    /// The same, each with the number of its case.
    pub fn placed_probes(&self) -> impl Iterator<Item = (usize, &Probe)> {
        self.cases
            .iter()
            .enumerate()
            .flat_map(|(number, case)| case.task.observed.iter().map(move |probe| (number, probe)))
    }

    /// Which of the study's criteria a case has.
    pub fn criteria_of(&self, case: usize) -> Range<usize> {
        let first = self.cases.iter().take(case).map(|case| case.task.observed.len()).sum();
        first..first + self.cases[case].task.observed.len()
    }

    /// A point's parameters in the FMU's units.
    pub fn to_fmu(&self, parameters: &[f64], into: &mut Vec<f64>) {
        assert_eq!(parameters.len(), self.inputs.len(), "a value for each parameter");
        into.clear();
        let pairs = self.inputs.iter().zip(parameters);
        into.extend(pairs.map(|(input, &value)| input.conversion.value(value)));
    }

    /// The FMU's results in the study's units.
    pub fn to_study(&self, values: &mut [f64]) {
        assert_eq!(values.len(), self.outputs.len(), "a value for each criterion");
        for ((value, conversion), probe) in values.iter_mut().zip(&self.outputs).zip(self.probes()) {
            let measure = &probe.measure;
            // A curve's number is in the study's unit already.
            if measure.curve().is_none() {
                *value = if measure.is_difference() { conversion.difference(*value) } else { conversion.value(*value) };
            }
        }
    }
}
