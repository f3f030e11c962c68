//! A study that fits an FMU: its points in the FMU's units, their results in those of the study.

use crate::{
    Result,
    concern::{Code, Concern},
};
use std::{
    collections::BTreeSet,
    ops::Range,
    sync::{Arc, Mutex},
};

use super::{
    Study,
    bind::Binder,
    inputs::{InputError, taken_as_exact},
    points,
};
use fmu_import::{Description, units::Conversion};
use fmu_points::{
    names::behind,
    task::{Case, Measure, Probe, Slot},
};
use sampling::{
    design::{self, Design, Joint, Sampling, correlation::Correlation},
    distribution::Distribution,
};

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
        let (mut inputs, varied) = binder.parameters()?;
        let joints = binder.samples(&mut inputs)?;
        binder.within(&inputs, &varied)?;
        let (mut cases, mut outputs, mut of_inputs) = (Vec::new(), Vec::new(), Vec::new());
        let mut input_errors = Vec::new();
        for (case, study) in study.by_case() {
            study.once(fmu, study.set())?;
            let binder = Binder { study: &study, fmu };
            let bound = binder.task(case, varied.clone())?;
            outputs.extend(bound.outputs);
            for error in bound.errors {
                let pairs = study.criteria.iter().zip(&bound.task.observed);
                for ((name, _), _) in pairs.filter(|((_, text), probe)| error.is_missed(text, probe)) {
                    of_inputs.push(taken_as_exact(&error.name, &format!("the product {}", name.as_ref())));
                }
                error.join(&mut input_errors, cases.len(), case);
            }
            let stated = case.iter().flat_map(|case| &case.concerns);
            let remedy =
                "Look at the recordings that `synchronise` doubts, and measure again where a sensor was at fault.";
            let stated = stated.map(|text| Concern::new(Code::Doubtful, text).remedied(remedy));
            of_inputs.extend(bound.concerns.into_iter().chain(stated).map(|doubt| match case {
                Some(case) => Concern { text: format!("case {}: {}", case.name.as_ref(), doubt.text), ..doubt },
                None => doubt,
            }));
            cases.push(Case { name: case.map(|case| case.name.as_ref().clone()), task: bound.task });
        }
        let mut slots = varied;
        for error in &input_errors {
            for (number, case) in cases.iter_mut().enumerate() {
                case.task.varied.push(error.slot_of(number));
            }
            slots.push(error.slot.clone());
            inputs.push(Input {
                name: error.name.clone(),
                unit: error.unit.clone(),
                distribution: Distribution::Normal { mean: 0.0, deviation: error.spread },
                conversion: error.conversion,
                is_whole: false,
            });
        }
        Ok(Self {
            correlation: points::correlation(study, inputs.len())?,
            cases,
            slots,
            inputs,
            outputs,
            input_errors,
            joints,
            of_inputs,
        })
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

    /// The points of a design over the parameters.
    ///
    /// # Errors
    /// When the method cannot serve this number of parameters or points.
    pub fn design(&self, design: &Sampling) -> Result<Design, String> {
        let inputs = design::Inputs {
            distributions: self.distributions(),
            correlation: self.correlation.clone(),
            joints: self.joints.clone(),
        };
        Design::new(design, inputs)
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

    /// The parameters at a point of the unit cube. Its axes are the parameters that vary; the others have their medians.
    pub fn from_cube(&self, cube: &[f64]) -> Vec<f64> {
        // Away from the ends of the unit interval where a distribution reaches to infinity.
        let given = self.varied().into_iter().zip(cube).map(|(k, &u)| match self.inputs[k].distribution.is_bounded() {
            [true, true] => u,
            _ => u.clamp(1e-6, 1.0 - 1e-6),
        });
        let places = self.with_fixed(given, 0.5);
        let point = self.inputs.iter().zip(&places).map(|(input, &u)| input.distribution.quantile(u));
        self.with_samples(&places, point.collect())
    }

    /// A number for each parameter: those that are given for the ones that vary, and `otherwise`.
    fn with_fixed(&self, mut given: impl Iterator<Item = f64>, otherwise: f64) -> Vec<f64> {
        let mut next = || given.next().expect("a number for each that varies");
        self.inputs.iter().map(|input| if input.distribution.varies() { next() } else { otherwise }).collect()
    }

    fn distributions(&self) -> Vec<Distribution> {
        self.inputs.iter().map(|input| input.distribution.clone()).collect()
    }

    /// Puts the rows of the samples into a point.
    fn with_samples(&self, places: &[f64], mut point: Vec<f64>) -> Vec<f64> {
        for joint in &self.joints {
            joint.fill(places, &mut point);
        }
        point
    }

    /// The parameters at independent standard normal scores of those that vary, correlated as the study says.
    pub fn at_scores(&self, scores: &[f64]) -> Vec<f64> {
        let all = self.with_fixed(scores.iter().copied(), 0.0);
        let inputs = self.distributions();
        let point: Vec<f64> = match &self.correlation {
            Some(correlation) => correlation.at_scores(&all, &inputs),
            None => inputs.iter().zip(&all).map(|(input, &z)| input.at_score(z)).collect(),
        };
        let unit = Distribution::Uniform { min: 0.0, max: 1.0 };
        let places: Vec<f64> = all.iter().map(|&z| unit.at_score(z)).collect();
        self.with_samples(&places, point)
    }

    /// A point as a surrogate sees it: a model changes evenly with the logarithm of a quantity that is normal in it.
    pub fn coordinates(&self, point: &[f64]) -> Vec<f64> {
        self.inputs
            .iter()
            .zip(point)
            .map(|(input, &value)| match &input.distribution {
                Distribution::Lognormal { .. } => value.ln(),
                _ => value,
            })
            .collect()
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

    /// Doubts about the study's numbers: parameters of which the FMU refuses a large part of the
    /// distribution, recorded inputs that it cannot follow.
    pub fn concerns(&self) -> Vec<Concern> {
        const LARGE: f64 = 0.05;
        self.inputs
            .iter()
            .zip(&self.slots)
            .filter_map(|(input, slot)| {
                let inverse = input.conversion.inverse();
                let below = |limit: f64| match limit {
                    f64::INFINITY => 1.0,
                    f64::NEG_INFINITY => 0.0,
                    limit => input.distribution.below(inverse.value(limit)),
                };
                let inside: f64 = slot.allowed().into_iter().map(|[low, high]| below(high) - below(low)).sum();
                let unit = behind(input.unit.as_deref());
                (1.0 - inside >= LARGE && input.distribution.varies()).then(|| {
                    Concern::new(Code::RefusedDistribution, format!(
                    "{}: {:.0} % of the distribution lies outside of what the FMU allows ({}{unit}); such points \
                     fail and count as not verified",
                    input.name,
                    100.0 * (1.0 - inside),
                    slot.allowed_text(|limit| inverse.value(limit)),
                )).remedied(format!(
                    "Cut the distribution of {} to what the FMU allows (`truncated-normal`), or correct it.",
                    input.name
                ))
                })
            })
            .chain(self.of_inputs.iter().cloned())
            .collect()
    }

    /// Tells at once of recorded inputs that the FMU gets otherwise, or at a great cost: every analysis rests on them.
    pub fn tell_of_inputs(&self) {
        // Who looks for causes reads the study once more.
        static TOLD: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());
        for doubt in &self.of_inputs {
            let text = format!("{}: {doubt}", doubt.severity.name());
            if TOLD.lock().is_ok_and(|mut told| told.insert(text.clone())) {
                fmu_points::tell::line!("{text}");
            }
        }
    }

    /// Concerns about parameters from samples of so few points.
    pub fn concerns_of_samples(&self, points: u64) -> Vec<Concern> {
        self.joints.iter().filter(|joint| (joint.count() as u64) < points).map(|joint| {
            let names = joint.inputs().iter().map(|&k| self.inputs[k].name.as_str()).collect::<Vec<_>>().join(", ");
            Concern::new(Code::RepeatedSample, format!(
                "{names}: {points} points repeat the {} rows of the sample, so the interval of the verified share is too narrow",
                joint.count()
            )).remedied(format!("Give {names} a sample of {points} rows or more."))
        }).collect()
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
        for (value, (conversion, probe)) in values
            .iter_mut()
            .zip(self.outputs.iter().zip(self.probes()))
            // A curve's number is in the study's unit already.
            .filter(|(_, (_, probe))| probe.measure.curve().is_none())
        {
            *value =
                if probe.measure.is_difference() { conversion.difference(*value) } else { conversion.value(*value) };
        }
    }
}
