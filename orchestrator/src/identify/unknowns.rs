//! The unknowns of a study whose criteria are the data.

use super::bind::{Bound, Input, REACH, reach};
use calibration::problem::{Free, Population, Prior};
use fmu_import::{Description, units::Conversion};
use fmu_points::task::Slot;
use sampling::distribution::Distribution;
use study::{
    Identification, Name, Result, Study,
    cases::SEPARATOR,
    plan::{self, Plan},
};

/// The parameters of a study: those to be found, and those that are fixed.
pub struct Unknowns<'a> {
    pub study: &'a Study,
    pub settings: &'a Identification,
    pub fmu: &'a Description,
    pub plan: &'a Plan,
}

impl Unknowns<'_> {
    pub fn bind(&self, bound: &mut Bound) -> Result {
        let named = self.study.parameters.keys().zip(&self.plan.inputs).zip(&self.plan.slots);
        for ((name, input), slot) in named.clone() {
            if let (Distribution::Fixed { value }, false) = (&input.distribution, self.is_free(name)) {
                bound.known[0].push(input.conversion.value(*value));
                bound.vary(slot.clone());
            }
        }
        self.refuse_doubles()?;
        for (name, text) in &self.settings.free {
            let (free, input) = Input::free(self.study, self.fmu, name, text)?;
            self.add(bound, name, free, input.slot, input.scale.conversion)?;
        }
        for ((name, input), slot) in named {
            if self.is_free(name) || !input.distribution.varies() {
                continue;
            }
            if !self.settings.free.is_empty() {
                return Err(self.study.error_of(
                    name,
                    "varies under [parameters], but is not under [identify.free]; add it there, or give it the \
                               distribution `fixed`",
                ));
            }
            let free = prior(input, slot).map_err(|message| self.study.error_of(name, message))?;
            self.add(bound, name, free, slot.clone(), input.conversion)?;
        }
        if bound.problem.free.is_empty() {
            Err(self.study.error_near(
                "parameters",
                "identify needs at least one parameter: one that varies under [parameters], or [identify.free.NAME]",
            ))
        } else {
            Ok(())
        }
    }

    /// Whether a name stands under `[identify.free]`.
    fn is_free(&self, name: &Name) -> bool {
        self.settings.free.contains_key(name.as_ref().as_str())
    }

    /// Adds an unknown, or one for each case.
    fn add(&self, bound: &mut Bound, name: &Name, free: Free, slot: Slot, conversion: Conversion) -> Result {
        let text = self.study.parameters.get(name.as_ref().as_str());
        let Some(varies) = text.and_then(|text| text.varies.as_ref()) else {
            return bound.add_free(self.study, name, free, slot, conversion);
        };
        let cases: Vec<String> = bound.simulations.iter().filter_map(|case| case.name.clone()).collect();
        if cases.len() < 2 {
            return Err(self.study.error_at(
                varies,
                "one case that is fitted shows no spread from case to case; give more, or remove `varies`",
            ));
        }
        let first = bound.problem.free.len();
        for (number, case) in cases.iter().enumerate() {
            let of_case = Free { name: format!("{case}{SEPARATOR}{}", free.name), ..free.clone() };
            bound.add_free(self.study, name, of_case, slot.clone(), conversion)?;
            for (other, simulation) in bound.simulations.iter_mut().enumerate() {
                if let Some(slot) = simulation.task.varied.last_mut() {
                    slot.idle = other != number;
                }
            }
        }
        bound
            .problem
            .populations
            .push(Population { name: free.name, members: (first..bound.problem.free.len()).collect() });
        Ok(())
    }

    /// A parameter may be free too: then it is sought between other bounds than it is drawn from.
    fn refuse_doubles(&self) -> Result {
        for (_, study) in self.study.by_case() {
            let others = study.set().filter(|(name, section)| *section != "[parameters]" || !self.is_free(name));
            let names = self.settings.free.keys().map(|name| (name, "[identify.free]"));
            self.study.once(self.fmu, others.chain(names))?;
        }
        Ok(())
    }
}

/// A sampled parameter as an unknown: its distribution is what was known before.
fn prior(input: &plan::Input, slot: &Slot) -> Result<Free, String> {
    let about = |mean: f64, deviation: f64| [-1.0, 1.0].map(|side| mean + side * REACH * deviation);
    let known = |centre, spread| Some(Prior { centre, spread });
    let ([low, high], prior) = match *input.distribution.continuous() {
        Distribution::Uniform { min, max } => ([min, max], None),
        Distribution::Normal { mean, deviation } => (about(mean, deviation), known(mean, deviation)),
        Distribution::TruncatedNormal { mean, deviation, min, max } => {
            let [low, high] = about(mean, deviation);
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
    let [least, most] = reach(slot, input.conversion);
    let bounds = [low.max(least), high.min(most)];
    let free = Free { prior, ..Free::linear(input.name.clone(), input.unit.clone(), bounds) };
    free.check()?;
    Ok(free)
}
