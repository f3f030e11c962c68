//! Ties a study with cases to identification: the criteria of the cases that are not held out are the data.
//!
//! A criterion's measured value is data with its standard uncertainty. A measured curve is data at each of its times, each
//! with its own uncertainty: so the sum of squares has every sample, and tells parameters apart that one metric of the whole
//! curve could not. Tolerances play no part: they say what is accepted, not how well it was measured.

use std::sync::Arc;

use super::bind::{Bound, Input, bare, check_difference, free};
use crate::files::FileError;
use crate::judge::Judge;
use crate::study::plan::{self, Plan};
use crate::study::{CriterionText, Identification, Name, Study};
use calibration::problem::{Case, Free, Measured, Prior, Quantity, Spacing};
use fmu_import::Description;
use fmu_import::units::Conversion;
use fmu_points::task::{Delay, MeasuredCurve, Probe, Slot};
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
) -> Result<Bound, FileError> {
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
        simulations: plan.cases.iter().cloned().map(bare).collect(),
        known: vec![Vec::new()],
        ..Bound::default()
    };
    let names = fitted.cases.iter().map(|case| case.name.as_ref().as_str());
    let names: Vec<&str> = names.collect();
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
            Some(curve) => samples(name.as_ref(), probe, curve)
                .map_err(|message| study.error_of(name, message))?,
            None => {
                let standard = criterion.measured().error.map(|error| error.standard());
                let accuracy = standard.ok_or_else(|| without_uncertainty(study, name, text))?;
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

/// Refuses other data beside the cases, and errors that identification would take for independent.
fn check(study: &Study, settings: &Identification) -> Result<(), FileError> {
    let advice = "the cases of the study are the data of identify; remove";
    if let Some(table) = &settings.cases {
        return Err(study.error_at(
            table,
            format!("{advice} `cases` from [identify], or [[cases]]"),
        ));
    }
    let measured = settings.measured.keys().map(|name| (name, "measured"));
    let known = settings.known.keys().map(|name| (name, "known"));
    let latent = settings.latent.keys().map(|name| (name, "latent"));
    if let Some((name, section)) = measured.chain(known).chain(latent).next() {
        return Err(study.error_at(name, format!("{advice} [identify.{section}]")));
    }
    check_difference(study, settings)?;
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

fn without_uncertainty(study: &Study, name: &Name, text: &CriterionText) -> FileError {
    let stated = text.tolerance.as_ref();
    let stated = stated.map_or_else(String::new, |tolerance| format!(" {tolerance}"));
    let message = format!(
        "identify weighs each measured value by its uncertainty: add `uncertainty`; the tolerance{stated} says what is \
         accepted, not how well it was measured"
    );
    study.error_of(name, message)
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
            ..MeasuredCurve::clone(curve)
        };
        Ok(Datum {
            // Without the rounding of times that were shifted by a delay.
            name: format!("{name} at {} s", (time * 1e9).round() / 1e9),
            probe: Probe {
                curve: Some(Arc::new(single)),
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
    fn bind(&self, bound: &mut Bound) -> Result<(), FileError> {
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
            let unit = text.unit.as_deref().or(text.min.unit.as_deref());
            let Input { slot, scale } = Input::new(self.study, self.fmu, name, unit)?;
            let free = free(name.as_ref(), text, &scale)
                .map_err(|message| self.study.error_of(name, message))?;
            bound.add_free(self.study, name, free, slot, scale.conversion)?;
        }
        for ((name, input), slot) in named {
            let is_free = self.settings.free.contains_key(name.as_ref().as_str());
            if is_free || !input.distribution.varies() {
                continue;
            }
            if !self.settings.free.is_empty() {
                let message = "varies under [parameters], but is not under [identify.free]; add it there, or give it the \
                               distribution `fixed`";
                return Err(self.study.error_of(name, message));
            }
            let free = prior(input, slot).map_err(|message| self.study.error_of(name, message))?;
            bound.add_free(self.study, name, free, slot.clone(), input.conversion)?;
        }
        match bound.problem.free.is_empty() {
            true => Err(self.study.error(
                "identify needs at least one parameter: one that varies under [parameters], or [identify.free.NAME]",
            )),
            false => Ok(()),
        }
    }

    /// A parameter may be free too: then it is sought between other bounds than it is drawn from.
    fn refuse_doubles(&self) -> Result<(), FileError> {
        let free = || self.settings.free.keys();
        let is_free = |name: &Name| self.settings.free.contains_key(name.as_ref().as_str());
        for (_, study) in self.study.by_case() {
            let others = study.set();
            let others =
                others.filter(|(name, section)| *section != "[parameters]" || !is_free(name));
            let names = free().map(|name| (name, "[identify.free]"));
            self.study.once(self.fmu, others.chain(names))?;
        }
        Ok(())
    }
}

/// A sampled parameter as an unknown: its distribution is what was known before.
fn prior(input: &plan::Input, slot: &Slot) -> Result<Free, String> {
    let reach = |mean: f64, deviation: f64| [-1.0, 1.0].map(|side| mean + side * REACH * deviation);
    let known = |centre, spread| Some(Prior { centre, spread });
    let ([low, high], prior) = match input.distribution {
        Distribution::Uniform { min, max } => ([min, max], None),
        Distribution::Normal { mean, deviation } => {
            (reach(mean, deviation), known(mean, deviation))
        }
        Distribution::TruncatedNormal {
            mean,
            deviation,
            min,
            max,
        } => {
            let [low, high] = reach(mean, deviation);
            let ends = [min.unwrap_or(low), max.unwrap_or(high)];
            (ends, known(mean, deviation))
        }
        _ => {
            return Err(
                "identify takes uniform and normal parameters as unknowns; give this one under [identify.free] with min, max \
                 and what is known of it"
                    .to_owned(),
            );
        }
    };
    // Within what the FMU allows, in the study's unit.
    let back = input.conversion.inverse();
    let allowed = |limit: Option<f64>, otherwise: f64| limit.map_or(otherwise, |x| back.value(x));
    let free = Free {
        name: input.name.clone(),
        unit: input.unit.clone(),
        scale: Spacing::Linear,
        min: low.max(allowed(slot.min, f64::NEG_INFINITY)),
        max: high.min(allowed(slot.max, f64::INFINITY)),
        prior,
    };
    free.check()?;
    Ok(free)
}
