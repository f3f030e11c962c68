//! Zero errors of recorded inputs: by how much a sensor reads too high is an unknown, and the model gets the recording less
//! that.

use indexmap::{IndexMap, IndexSet};

use super::bind::{Bound, REACH};
use calibration::problem::{Free, Prior, Spacing};
use conformity::uncertainty::Uncertainty;
use fmu_import::quantity::{Scale, Sense};
use fmu_import::{Content, Description};
use fmu_points::task::{Series, Slot};
use number_tables::files::FileError;
use study::cases::SEPARATOR;
use study::plan::find;
use study::{Name, RecordingText, Study};

/// A zero error: all cases have it in which the same uncertainty is stated of the same input.
struct Offset<'a> {
    name: &'a Name,
    scale: Scale<'a>,
    slot: Slot,
    cases: Vec<usize>,
}

/// Adds the zero errors of the recorded inputs of a study's cases to its unknowns, and says which inputs count as exact.
///
/// # Errors
/// When an uncertainty is no positive number in the input's unit, or the input takes no zero error.
pub(super) fn add(study: &Study, fmu: &Description, bound: &mut Bound) -> Result<(), FileError> {
    let cases = study.by_case();
    let mut offsets: IndexMap<(&str, u64), Offset<'_>> = IndexMap::new();
    let mut exact: Vec<&str> = Vec::new();
    for (case, (_, of_case)) in cases.iter().enumerate() {
        let series = &bound.simulations[case].task.inputs;
        for ((name, recording), series) in of_case.inputs.iter().zip(series) {
            let key = name.as_ref().as_str();
            if recording.uncertainty.is_none() {
                exact.push(key);
                continue;
            }
            let (scale, standard) =
                standard(key, recording, fmu, &series.slot).map_err(|message| study.error_of(name, message))?;
            let offset = offsets.entry((key, standard.to_bits()));
            let offset = offset.or_insert_with(|| Offset {
                name,
                scale,
                slot: Slot { shifts: true, ..series.slot.clone() },
                cases: Vec::new(),
            });
            offset.cases.push(case);
        }
    }
    for ((key, bits), offset) in offsets {
        let mut name = format!("{key}/offset");
        if bound.offsets.contains(&name) {
            // Another sensor.
            let case = bound.simulations[offset.cases[0]].name.as_deref();
            name = format!("{}{SEPARATOR}{name}", case.unwrap_or_default());
        }
        let spread = f64::from_bits(bits);
        bound.offsets.push(name.clone());
        let free = Free {
            name,
            unit: offset.scale.unit.clone(),
            scale: Spacing::Linear,
            min: -REACH * spread,
            max: REACH * spread,
            prior: Some(Prior { centre: 0.0, spread }),
        };
        let conversion = offset.scale.conversion.of_differences();
        bound.add_free(study, offset.name, free, offset.slot, conversion)?;
        for (case, simulation) in bound.simulations.iter_mut().enumerate() {
            let slot = simulation.task.varied.last_mut();
            slot.expect("it was added just now").idle = !offset.cases.contains(&case);
        }
    }
    exact.sort_unstable();
    exact.dedup();
    if !exact.is_empty() {
        bound.notes.push(format!(
            "Recorded inputs without an `uncertainty` count as exact: {}. What their sensors read wrong goes into the parameters.",
            exact.join(", ")
        ));
    }
    Ok(())
}

/// The standard uncertainty of an input's zero error in the recording's unit.
fn standard<'a>(
    key: &str,
    recording: &RecordingText,
    fmu: &'a Description,
    slot: &Slot,
) -> Result<(Scale<'a>, f64), String> {
    if slot.handle.content != Content::Real {
        return Err("only a real input has a zero error; remove `uncertainty`".to_owned());
    }
    let scale = Scale::new(recording.unit.as_deref(), fmu, find(fmu, key)?)?;
    let stated = recording.uncertainty.as_ref().expect("inputs without one were left out");
    let expanded = match stated.unit.as_deref() {
        Some("%") => None,
        _ => Some(scale.number(stated, Sense::Difference)?),
    };
    let expanded = expanded.filter(|number| *number > 0.0 && number.is_finite());
    let expanded =
        expanded.ok_or_else(|| format!("the uncertainty {stated} must be a positive number in the input's unit"))?;
    Ok((scale, expanded / Uncertainty::USUAL))
}

/// What a misfit may come from where recorded inputs are held for whole steps.
pub fn held(bound: &Bound) -> Option<String> {
    let tasks = || bound.simulations.iter().map(|simulation| &simulation.task);
    let is_held = |series: &&Series| {
        let moves = series.values.iter().any(|value| *value != series.values[0]);
        moves && !series.hold && !series.ramp
    };
    let held = tasks().flat_map(|task| task.inputs.iter().filter(is_held));
    let names: IndexSet<&str> = held.map(|series| series.slot.name.as_str()).collect();
    let step = tasks().map(|task| task.schedule.step).reduce(f64::max)?;
    (!names.is_empty()).then(|| {
        format!(
            "{} is held for each step of {step} s, so the model sees it half a step late on average, and an output that follows it \
             at once is as late: see whether the misfit stays with `ramp = true`, where the FMU can interpolate inputs, or with \
             a shorter `step`",
            Vec::from_iter(names).join(", ")
        )
    })
}
