//! Doubts about the numbers of a plan.

use std::{collections::BTreeSet, sync::Mutex};

use fmu_points::{names::behind, task::Slot};

use super::Plan;
use crate::{
    CaseText,
    concern::{Code, Concern},
    input::Input,
};

impl Plan {
    /// Doubts about the study's numbers: parameters of which the FMU refuses a large part of the distribution, recorded inputs
    /// that it cannot follow.
    pub fn concerns(&self) -> Vec<Concern> {
        let refused = self.inputs.iter().zip(&self.slots).filter_map(|(input, slot)| refused(input, slot));
        refused.chain(self.of_inputs.iter().cloned()).collect()
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
        let short = self.joints.iter().filter(|joint| (joint.count() as u64) < points);
        short
            .map(|joint| {
                let names = joint.inputs().iter().map(|&k| self.inputs[k].name.as_str()).collect::<Vec<_>>().join(", ");
                let text = format!(
                    "{names}: {points} points repeat the {} rows of the sample, so the interval of the verified share is too \
                     narrow",
                    joint.count()
                );
                let remedy = format!("Give {names} a sample of {points} rows or more.");
                Concern::new(Code::RepeatedSample, text).remedied(remedy)
            })
            .collect()
    }
}

/// A parameter of which the FMU refuses a large part of the distribution.
fn refused(input: &Input, slot: &Slot) -> Option<Concern> {
    const LARGE: f64 = 0.05;
    let inverse = input.conversion.inverse();
    let below = |limit: f64| match limit {
        f64::INFINITY => 1.0,
        f64::NEG_INFINITY => 0.0,
        limit => input.distribution.below(inverse.value(limit)),
    };
    let inside: f64 = slot.allowed().into_iter().map(|[low, high]| below(high) - below(low)).sum();
    let outside = 1.0 - inside;
    let is_large = outside >= LARGE;
    if !is_large || !input.distribution.varies() {
        return None;
    }
    let (name, unit) = (&input.name, behind(input.unit.as_deref()));
    let text = format!(
        "{name}: {:.0} % of the distribution lies outside of what the FMU allows ({}{unit}); such points fail and count as not \
         verified",
        100.0 * outside,
        slot.allowed_text(|limit| inverse.value(limit)),
    );
    let remedy = format!("Cut the distribution of {name} to what the FMU allows (`truncated-normal`), or correct it.");
    Some(Concern::new(Code::RefusedDistribution, text).remedied(remedy))
}

/// The doubts about the recordings of a case, with those that its file states.
pub(super) fn of_case(case: &CaseText, found: Vec<Concern>) -> Vec<Concern> {
    const REMEDY: &str =
        "Look at the recordings that `synchronise` doubts, and measure again where a sensor was at fault.";
    let stated = case.concerns.iter().map(|text| Concern::new(Code::Doubtful, text).remedied(REMEDY));
    let named = |doubt: Concern| Concern { text: format!("case {}: {}", case.name.as_ref(), doubt.text), ..doubt };
    found.into_iter().chain(stated).map(named).collect()
}
