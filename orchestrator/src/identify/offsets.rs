//! Offsets and gains of recorded inputs: by how much a sensor reads too high is an unknown, and the model gets the recording
//! less that.

use std::collections::BTreeSet;

use indexmap::IndexSet;

use super::bind::{Bound, REACH};
use calibration::problem::{Free, Prior};
use fmu_points::task::Series;
use study::{Result, Study, plan::Plan};

/// Adds the errors of the recorded inputs of a study's cases to its unknowns, and says which inputs count as exact.
///
/// # Errors
/// When the FMU does not allow one.
pub(super) fn add(study: &Study, plan: &Plan, bound: &mut Bound) -> Result {
    let (noisy, unknown): (Vec<_>, Vec<_>) = plan.input_errors.iter().partition(|error| error.is_noise());
    let noisy: BTreeSet<&str> = noisy.iter().map(|error| error.name.as_str()).collect();
    if !noisy.is_empty() {
        bound.notes.push(format!(
            "The intervals are too narrow by what {} does to the model, as `verify` shows: add it to the `noise` of the criteria.",
            Vec::from_iter(noisy).join(", ")
        ));
    }
    for error in unknown {
        bound.offsets.insert(error.name.clone(), error.taken);
        let far = REACH * error.spread;
        let prior = Some(Prior { centre: 0.0, spread: error.spread });
        let free = Free { prior, ..Free::linear(error.name.clone(), error.unit.clone(), [-far, far]) };
        bound.add_free(study, &error.key, free, error.slot.clone(), error.conversion)?;
        for (case, simulation) in bound.simulations.iter_mut().enumerate() {
            *simulation.task.varied.last_mut().expect("it was added just now") = error.slot_of(case);
        }
    }
    let cases = study.by_case();
    let all = cases.iter().flat_map(|(_, of_case)| &of_case.inputs);
    let exact = all.filter(|(_, recording)| recording.uncertainty.is_none() && recording.gain_uncertainty.is_none());
    let exact: BTreeSet<&str> = exact.map(|(name, _)| name.as_ref().as_str()).collect();
    if !exact.is_empty() {
        bound.notes.push(format!(
            "Recorded inputs without an `uncertainty` count as exact: {}. What their sensors read wrong goes into the parameters.",
            Vec::from_iter(exact).join(", ")
        ));
    }
    Ok(())
}

/// What a misfit may come from where recorded inputs are held for whole steps.
pub fn held(bound: &Bound) -> Option<String> {
    let is_held = |series: &&Series| {
        let moves = series.values.iter().any(|value| *value != series.values[0]);
        moves && !series.hold && !series.ramp
    };
    let names: IndexSet<&str> = bound
        .tasks()
        .flat_map(|task| task.inputs.iter().filter(is_held))
        .map(|series| series.slot.name.as_str())
        .collect();
    let step = bound.tasks().map(|task| task.schedule.step).reduce(f64::max)?;
    (!names.is_empty()).then(|| {
        format!(
            "{} is held for each step of {step} s, so the model sees it half a step late on average, and an output that follows it \
             at once is as late: see whether the misfit stays with `ramp = true`, where the FMU can interpolate inputs, or with \
             a shorter `step`",
            Vec::from_iter(names).join(", ")
        )
    })
}
