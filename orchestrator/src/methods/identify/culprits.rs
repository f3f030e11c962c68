//! Which parameter, sensor or constant would explain that the model misses the measured values.

use std::collections::BTreeSet;

use calibration::{
    influence::Group,
    problem::{Free, NoPrediction, Problem, Query, Simulate},
    remembered::Remembered,
    rounds::{Searched, Task},
    suspects::{Confusion, Constant, Inquiry, Sensor, Suspect, Suspicion},
};
use fmu_import::{Content, Description, Value, units::Conversion};
use fmu_points::task::{SensorError, Slot};
use indexmap::IndexMap;
use study::cases::SEPARATOR;

use crate::{
    identify::{
        bind::{self, Bound},
        model::{Extended, FmuModel},
    },
    results::confusions,
};

/// Looks for what would explain the misfit at the first optimum, by further runs.
///
/// # Errors
/// When the run was stopped.
pub fn ask(
    (bound, fmu): (&Bound, &Description),
    task: &Task,
    searched: &Searched,
    (remembered, model): (&Remembered, &FmuModel),
) -> Result<Vec<Suspect>, NoPrediction> {
    model.say("what would explain the misfit".to_owned());
    let Searched { problem, optima, progress } = searched;
    // Looking takes no more runs than the search has.
    let most = usize::try_from(progress.failures.asked).unwrap_or(usize::MAX);
    let constants = constants((bound, fmu), problem, &optima[0].minimum.places, (model, most))?;
    let inquiry = Inquiry {
        problem,
        difference: task.difference,
        starts: task.starts,
        optimum: &optima[0],
        model: remembered,
        sensors: &sensors(bound),
        reach: &reach(bound),
        constants: &constants,
    };
    inquiry.suspects()
}

/// How far the FMU lets each unknown go, in the study's unit. What is none of its parameters stays within its bounds.
fn reach(bound: &Bound) -> Vec<[f64; 2]> {
    let known = bound.known.first().map_or(0, Vec::len);
    let slots = bound.simulations.first().map_or(&[][..], |simulation| &simulation.task.varied[known..]);
    let free = bound.problem.free.iter().enumerate();
    free.map(|(k, free)| match (slots.get(k), bound.inputs.get(k)) {
        _ if bound.lags.contains(&free.name) => [free.min, free.max],
        (Some(slot), Some(conversion)) if slot.error.is_none() => bind::reach(slot, *conversion),
        _ => [f64::NEG_INFINITY, f64::INFINITY],
    })
    .collect()
}

/// The sensors: one for each criterion, whatever the case.
fn sensors(bound: &Bound) -> Vec<Sensor> {
    let problem = &bound.problem;
    let mut sensors: IndexMap<(&str, bool), Sensor> = IndexMap::new();
    let of_curve = |quantity: usize| bound.curves.iter().find(|curve| curve.quantities.contains(&quantity));
    for (quantity, named) in problem.quantities.iter().enumerate() {
        let curve = of_curve(quantity);
        let name = curve.map_or(&named.name, |curve| &curve.name);
        let base = name.rsplit(SEPARATOR).next().unwrap_or(name);
        let sensor = sensors.entry((base, curve.is_some())).or_insert_with(|| Sensor {
            group: Group { name: base.to_owned(), values: Vec::new() },
            criteria: Vec::new(),
            unit: named.unit.clone(),
            times: Vec::new(),
            confusions: readings(named.unit.as_deref(), curve.is_some()),
        });
        sensor.group.values.extend((0..problem.cases.len()).map(|case| [case, quantity]));
        if !sensor.criteria.contains(name) {
            sensor.criteria.push(name.clone());
        }
        let first = curve.filter(|curve| curve.quantities.start == quantity);
        sensor.times.extend(first.map(|curve| curve.times.clone()));
    }
    sensors.into_values().collect()
}

/// What values may be mistaken for. A signal that changes from row to row is late by whole rows: no line through it tells.
fn readings(unit: Option<&str>, is_curve: bool) -> Vec<Confusion> {
    let same = Confusion { factor: 1.0, offset: 0.0, rows: 0, words: String::new() };
    let sign = Confusion { factor: -1.0, words: "its sign were the other one".to_owned(), ..same.clone() };
    let late = [-8, -5, -3, -2, -1, 1, 2, 3, 5, 8]
        .into_iter()
        .filter(|_| is_curve)
        .map(|rows| Confusion { rows, ..same.clone() });
    let units = confusions(unit).into_iter().map(|(Conversion { factor, offset }, units)| Confusion {
        factor,
        offset,
        rows: 0,
        words: format!("{units} were mixed up"),
    });
    [sign].into_iter().chain(late).chain(units).collect()
}

/// The constants of the FMU that may be other ones, each tried with another value at an optimum; none where these are more runs
/// than `most`.
fn constants<'m>(
    (bound, fmu): (&Bound, &Description),
    problem: &Problem,
    places: &[f64],
    (model, most): (&'m FmuModel, usize),
) -> Result<Vec<Constant<'m>>, NoPrediction> {
    /// So far apart stand the values of a derivative, as a part of the range.
    const STEP: f64 = 0.02;
    let all = found(bound, fmu);
    let cases = problem.cases.len();
    if all.is_empty() || all.len() * cases > most {
        return Ok(Vec::new());
    }
    let extended = Extended { model, slots: all.iter().map(|known| known.slot.clone()).collect() };
    let values: Vec<f64> = all.iter().map(|known| known.value).collect();
    let others: Vec<f64> = all
        .iter()
        .map(|Given { free, value, .. }| {
            let place = free.place(*value);
            free.value(if place > 0.5 { place - STEP } else { place + STEP })
        })
        .collect();
    let queries: Vec<Query> = others
        .iter()
        .enumerate()
        .flat_map(|(k, other)| {
            let mut moved = values.clone();
            moved[k] = *other;
            let free = [problem.free_values(places), moved].concat();
            (0..cases).map(move |case| Query { case, free: free.clone(), latents: problem.latent_values(case, places) })
        })
        .collect();
    let predicted = match extended.simulate(&queries) {
        Ok(predicted) => predicted,
        Err(NoPrediction::Here(_)) => return Ok(Vec::new()),
        Err(stopped) => return Err(stopped),
    };
    Ok(all
        .into_iter()
        .zip(others)
        .zip(predicted.chunks(cases))
        .filter_map(|((Given { slot, free, value, fault, usual }, other), by_case)| {
            let moved: Result<Vec<Vec<f64>>, _> = by_case.iter().cloned().collect();
            let model = Box::new(Extended { model, slots: vec![slot] });
            Some(Constant { fault, usual, free, value, moved: (other, moved.ok()?), model })
        })
        .collect())
}

/// What a study takes as given, with a range around the value that it has.
struct Given {
    slot: Slot,
    free: Free,
    value: f64,
    fault: Suspicion,
    usual: f64,
}

/// What the sensors of recorded inputs read wrong, where that is no unknown already.
fn of_inputs(bound: &Bound, fmu: &Description) -> Vec<Given> {
    /// So large a part is as odd as the whole of what was stated of another.
    const ODD: f64 = 0.02;
    let mut all: Vec<Given> = Vec::new();
    for series in bound.tasks().flat_map(|task| &task.inputs) {
        let handle = series.slot.handle;
        let is_unknown = |slot: &Slot| slot.handle == handle;
        let is_told = all.iter().any(|known| known.slot.handle == handle);
        if is_told
            || !bound.tasks().all(|task| task.inputs.iter().any(|other| other.slot.handle == handle))
            || bound.tasks().flat_map(|task| &task.varied).any(is_unknown)
        {
            continue;
        }
        let most = series.values.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
        let unit = fmu.variables.get(&series.slot.name).and_then(|variable| variable.unit().map(str::to_owned));
        let errors = [
            (Suspicion::Offset, SensorError::Offset, most, unit),
            (Suspicion::Gain, SensorError::Gain { about: 0.0 }, 0.5, None),
        ];
        all.extend(errors.map(|(fault, error, width, unit)| Given {
            slot: Slot { error: Some(error), ..series.slot.clone() },
            free: Free::linear(series.slot.name.clone(), unit, [-width, width]),
            value: 0.0,
            usual: ODD * if fault == Suspicion::Gain { 1.0 } else { most },
            fault,
        }));
    }
    all.retain(|known| known.free.check().is_ok());
    all
}

/// The real parameters and start values of the FMU that the study does not vary.
fn found(bound: &Bound, fmu: &Description) -> Vec<Given> {
    const ODD: f64 = 0.05;
    let mut seen: BTreeSet<u32> =
        bound.tasks().flat_map(|task| &task.varied).map(|slot| slot.handle.reference).collect();
    seen.extend(bound.tasks().flat_map(|task| &task.inputs).map(|series| series.slot.handle.reference));
    let mut all = of_inputs(bound, fmu);
    for variable in fmu.variables.values() {
        let Some(slot) = Slot::of(variable).filter(|slot| slot.handle.content == Content::Real) else { continue };
        if !variable.is_settable() || !seen.insert(variable.value_reference) {
            continue;
        }
        let fixed = |(reference, value): &(u32, Value)| match value {
            Value::Real(value) if *reference == variable.value_reference => Some(*value),
            _ => None,
        };
        let start = variable.kind.start();
        let mut values = bound.tasks().map(|task| task.fixed.iter().find_map(fixed).or(start));
        let Some(Some(value)) = values.next() else { continue };
        if values.any(|other| other != Some(value)) {
            continue;
        }
        let width = if value == 0.0 { 1.0 } else { 0.9 * value.abs() };
        let [least, most] = bind::reach(&slot, Conversion::IDENTITY);
        let bounds = [least.max(value - width), most.min(value + width)];
        let free = Free::linear(variable.name.clone(), variable.unit().map(str::to_owned), bounds);
        if free.check().is_ok() {
            all.push(Given { slot, free, value, fault: Suspicion::Constant, usual: ODD * value.abs() });
        }
    }
    all
}
