//! Ties a study with cases to identification: the criteria of the cases that are not held out are the data.
//!
//! A criterion's measured value is data with its standard uncertainty. A measured curve is data at each of its times, each
//! with its own uncertainty: so the sum of squares has every sample, and tells parameters apart that one metric of the whole
//! curve could not. Tolerances play no part: they say what is accepted, not how well it was measured.

use super::bind::{Bound, free};
use crate::judge::Judge;
use crate::study::plan::{Input, Plan, find, slot_of};
use crate::study::quantity::Scale;
use crate::study::{CriterionText, Identification, Name, Study, StudyError};
use calibration::problem::{Case, Free, Measured, Prior, Problem, Quantity, Spacing};
use fmu_import::Description;
use fmu_import::units::Conversion;
use fmu_points::task::{Case as Simulation, Delay, MeasuredCurve, Probe, Slot};
use sampling::distribution::Distribution;

/// How many standard uncertainties a curve's uncertainty is.
const COVERAGE: f64 = 2.0;
/// How far the bounds of a normal parameter are from its mean, in standard deviations.
const REACH: f64 = 5.0;

/// The unknowns and the data of a study with cases.
///
/// # Errors
/// When a criterion or a parameter does not say what identification needs, with its place and the remedy.
pub fn bind(
    study: &Study,
    settings: &Identification,
    fmu: &Description,
) -> Result<Bound, StudyError> {
    check(study, settings)?;
    let fitted = study.fitted();
    if fitted.cases.is_empty() {
        let message =
            "every case is held out, so there is nothing to fit; remove `held-out` from one";
        return Err(study.error_at(&study.cases[0].name, message));
    }
    let plan = Plan::new(&fitted, fmu)?;
    plan.tell_of_inputs();
    let judge = Judge::new(&fitted, Some(fmu))?;
    let mut bound = Bound {
        problem: Problem::default(),
        simulations: plan.cases.iter().map(without_probes).collect(),
        known: vec![Vec::new()],
        inputs: Vec::new(),
        outputs: Vec::new(),
        discrepancies: Vec::new(),
    };
    let names: Vec<&str> = fitted
        .cases
        .iter()
        .map(|case| case.name.as_ref().as_str())
        .collect();
    bound.problem.cases.push(Case {
        label: names.join(", "),
        latents: Vec::new(),
        measured: Vec::new(),
    });
    Unknowns {
        study,
        settings,
        fmu,
        plan: &plan,
    }
    .bind(&mut bound)?;
    let criteria = fitted.criteria.iter().zip(&judge.criteria);
    let probes = plan.placed_probes().zip(&plan.outputs);
    for (((name, text), criterion), ((case, probe), conversion)) in criteria.zip(probes) {
        let data = match &probe.curve {
            Some(curve) => {
                samples(name.as_ref(), probe, curve).map_err(|message| at(study, name, &message))?
            }
            None => {
                let found = criterion.uncertainty.as_ref().map(|u| u.standard());
                let accuracy = found.ok_or_else(|| without_uncertainty(study, name, text))?;
                let difference = probe.statistic.is_difference();
                vec![Datum {
                    name: name.as_ref().clone(),
                    probe: probe.clone(),
                    conversion: match difference {
                        true => conversion.of_differences(),
                        false => *conversion,
                    },
                    measured: Measured {
                        value: criterion.nominal,
                        accuracy,
                    },
                }]
            }
        };
        for datum in data {
            bound.problem.quantities.push(Quantity {
                name: datum.name,
                unit: criterion.unit.clone(),
            });
            bound.problem.cases[0].measured.push(datum.measured);
            bound.outputs.push(datum.conversion);
            bound.simulations[case].task.observed.push(datum.probe);
        }
    }
    Ok(bound)
}

/// A measured number, and how the model gets it.
struct Datum {
    name: String,
    probe: Probe,
    /// From the FMU's unit to the criterion's.
    conversion: Conversion,
    measured: Measured,
}

fn at(study: &Study, name: &Name, message: &str) -> StudyError {
    study.error_at(name, format!("{}: {message}", name.as_ref()))
}

/// Refuses other data beside the cases, and errors that identification would take for independent.
fn check(study: &Study, settings: &Identification) -> Result<(), StudyError> {
    let beside = "the cases of the study are the data of identify; remove";
    if let Some(table) = &settings.cases {
        return Err(study.error_at(
            table,
            format!("{beside} `cases` from [identify], or [[cases]]"),
        ));
    }
    let measured = settings.measured.keys().map(|name| (name, "measured"));
    let known = settings.known.keys().map(|name| (name, "known"));
    let latent = settings.latent.keys().map(|name| (name, "latent"));
    if let Some((name, section)) = measured.chain(known).chain(latent).next() {
        return Err(study.error_at(name, format!("{beside} [identify.{section}]")));
    }
    if !(settings.difference > 0.0 && settings.difference < 0.5) {
        return Err(study.error("[identify] difference must lie between 0 and 0.5"));
    }
    if let Some(pair) = study.uncertainty_correlations.first() {
        let message = "identify takes the errors of the measured values as independent; use it with a study that has no \
                       [[uncertainty-correlations]]";
        return Err(study.error_at(pair, message));
    }
    let references = study
        .criteria
        .values()
        .filter_map(|text| text.reference.as_ref());
    let mut stated = references.filter_map(|reference| reference.correlation.as_ref());
    if let Some(correlation) = stated.find(|correlation| *correlation.as_ref() != 0.0) {
        let message = "identify takes the errors of a curve's rows as independent; set correlation = 0 where they are noise, or leave \
                       this criterion out";
        return Err(study.error_at(correlation, message));
    }
    Ok(())
}

fn without_uncertainty(study: &Study, name: &Name, text: &CriterionText) -> StudyError {
    let stated = text.tolerance.as_ref();
    let stated = stated.map_or_else(String::new, |tolerance| format!(" {tolerance}"));
    let message = format!(
        "identify weighs each measured value by its uncertainty: add `uncertainty`; the tolerance{stated} says what is \
         accepted, not how well it was measured"
    );
    at(study, name, &message)
}

fn without_probes(case: &Simulation) -> Simulation {
    let mut case = case.clone();
    case.task.varied.clear();
    case.task.observed.clear();
    case
}

/// A datum for each time of a measured curve.
fn samples(name: &str, probe: &Probe, curve: &MeasuredCurve) -> Result<Vec<Datum>, String> {
    let Delay::Known(_) = curve.delay else {
        return Err("identify needs a known delay, not a range of delays".to_owned());
    };
    if curve.uncertainty.len() != curve.times.len() {
        let message = "identify weighs each value of a curve by its uncertainty: add `uncertainty` or `uncertainty-column` to \
                       the reference (one that is resampled to even times has none)";
        return Err(message.to_owned());
    }
    let rows = curve
        .times
        .iter()
        .zip(&curve.values)
        .zip(&curve.uncertainty);
    rows.map(|((&time, &value), &expanded)| {
        if expanded <= 0.0 {
            return Err(format!(
                "the uncertainty at {time} s is {expanded}; it must be positive"
            ));
        }
        let single = MeasuredCurve {
            times: vec![time],
            values: vec![value],
            band: Vec::new(),
            uncertainty: Vec::new(),
            resampling: None,
            reads: true,
            ..curve.clone()
        };
        Ok(Datum {
            // Without the rounding of times that were shifted by a delay.
            name: format!("{name} at {} s", (time * 1e9).round() / 1e9),
            probe: Probe {
                curve: Some(Box::new(single)),
                ..probe.clone()
            },
            // It comes in the criterion's unit.
            conversion: Conversion::IDENTITY,
            measured: Measured {
                value,
                accuracy: expanded / COVERAGE,
            },
        })
    })
    .collect()
}

/// The parameters of a study: those to be found, and those that are fixed.
struct Unknowns<'a> {
    study: &'a Study,
    settings: &'a Identification,
    fmu: &'a Description,
    plan: &'a Plan,
}

impl Unknowns<'_> {
    fn bind(&self, bound: &mut Bound) -> Result<(), StudyError> {
        let named = self
            .study
            .parameters
            .keys()
            .zip(&self.plan.inputs)
            .zip(&self.plan.slots);
        for ((name, input), slot) in named.clone() {
            let is_free = self.settings.free.contains_key(name.as_ref().as_str());
            if let (Distribution::Fixed { value }, false) = (&input.distribution, is_free) {
                bound.known[0].push(input.conversion.value(*value));
                bound.vary(slot.clone());
            }
        }
        self.refuse_doubles()?;
        for (name, text) in &self.settings.free {
            let own = name.as_ref().as_str();
            let variable =
                find(self.fmu, own).map_err(|message| self.study.error_at(name, message))?;
            let at = |message: String| at(self.study, name, &message);
            let slot = slot_of(variable).map_err(at)?;
            let unit = text.unit.as_deref().or(text.min.unit.as_deref());
            let scale = Scale::new(unit, self.fmu, variable).map_err(at)?;
            let free = free(own, text, &scale).map_err(at)?;
            self.add(bound, name, free, scale.conversion, slot)?;
        }
        for ((name, input), slot) in named {
            let is_free = self.settings.free.contains_key(name.as_ref().as_str());
            if is_free || !input.distribution.varies() {
                continue;
            }
            if !self.settings.free.is_empty() {
                let message = "varies under [parameters], but is not under [identify.free]; add it there, or give it the \
                               distribution `fixed`";
                return Err(at(self.study, name, message));
            }
            let free = prior(input, slot).map_err(|message| at(self.study, name, &message))?;
            self.add(bound, name, free, input.conversion, slot.clone())?;
        }
        match bound.problem.free.is_empty() {
            true => Err(self.study.error(
                "identify needs at least one parameter: one that varies under [parameters], or [identify.free.NAME]",
            )),
            false => Ok(()),
        }
    }

    fn add(
        &self,
        bound: &mut Bound,
        name: &Name,
        free: Free,
        conversion: Conversion,
        slot: Slot,
    ) -> Result<(), StudyError> {
        for end in [free.min, free.max] {
            let allowed = slot.check(conversion.value(end));
            allowed.map_err(|message| at(self.study, name, &message))?;
        }
        bound.problem.free.push(free);
        bound.inputs.push(conversion);
        bound.vary(slot);
        Ok(())
    }

    /// A parameter may be free too: then it is sought between other bounds than it is drawn from.
    fn refuse_doubles(&self) -> Result<(), StudyError> {
        let free = || self.settings.free.keys();
        let is_free = |name: &Name| self.settings.free.contains_key(name.as_ref().as_str());
        for (_, study) in self.study.by_case() {
            let others = study.set();
            let others =
                others.filter(|(name, section)| *section != "[parameters]" || !is_free(name));
            let own = free().map(|name| (name, "[identify.free]"));
            self.study.once(self.fmu, others.chain(own))?;
        }
        Ok(())
    }
}

/// A sampled parameter as an unknown: its distribution is what was known before.
fn prior(input: &Input, slot: &Slot) -> Result<Free, String> {
    let free = |min: f64, max: f64, prior: Option<Prior>| Free {
        name: input.name.clone(),
        unit: input.unit.clone(),
        scale: Spacing::Linear,
        min,
        max,
        prior,
    };
    // Within what the FMU allows, in the study's unit.
    let back = input.conversion.inverse();
    let allowed = |limit: Option<f64>, otherwise: f64| limit.map_or(otherwise, |x| back.value(x));
    let (low, high) = (
        allowed(slot.min, f64::NEG_INFINITY),
        allowed(slot.max, f64::INFINITY),
    );
    let found = match input.distribution {
        Distribution::Uniform { min, max } => free(min.max(low), max.min(high), None),
        Distribution::Normal { mean, deviation } => {
            let ends = [mean - REACH * deviation, mean + REACH * deviation];
            let prior = Prior {
                centre: mean,
                spread: deviation,
            };
            free(ends[0].max(low), ends[1].min(high), Some(prior))
        }
        Distribution::TruncatedNormal {
            mean,
            deviation,
            min,
            max,
        } => {
            let ends = [
                min.unwrap_or(mean - REACH * deviation),
                max.unwrap_or(mean + REACH * deviation),
            ];
            let prior = Prior {
                centre: mean,
                spread: deviation,
            };
            free(ends[0].max(low), ends[1].min(high), Some(prior))
        }
        _ => {
            return Err(
                "identify takes uniform and normal parameters as unknowns; give this one under [identify.free] with min, max \
                 and what is known of it"
                    .to_owned(),
            );
        }
    };
    found.check()?;
    Ok(found)
}
