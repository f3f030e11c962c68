//! Which parameter, sensor or constant would explain that the model misses the measured values.

use std::collections::BTreeSet;

use calibration::{
    fit::Fit,
    influence::Group,
    local::End,
    outcome::{FreeOutcome, IdentificationOutcome},
    problem::{Free, NoPrediction, Prior, Problem, Query, SharedKind, Simulate, Spacing},
    remembered::Remembered,
    rounds::{Searched, Task},
    suspects::{Confusion, Constant, Fault, Inquiry, Sensor, Suspect},
};
use fmu_import::{Content, Description, Value, units::Conversion};
use fmu_points::{
    names::behind,
    task::{SensorError, Slot},
};
use indexmap::IndexMap;
use result_document::{Document, format::number};
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
        .map(|Known { free, value, .. }| {
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
        .filter_map(|((Known { slot, free, value, fault, usual }, other), by_case)| {
            let moved: Result<Vec<Vec<f64>>, _> = by_case.iter().cloned().collect();
            let model = Box::new(Extended { model, slots: vec![slot] });
            Some(Constant { fault, usual, free, value, moved: (other, moved.ok()?), model })
        })
        .collect())
}

/// What a study takes as given, with a range around the value that it has.
struct Known {
    slot: Slot,
    free: Free,
    value: f64,
    fault: Fault,
    usual: f64,
}

/// What the sensors of recorded inputs read wrong, where that is no unknown already.
fn of_inputs(bound: &Bound, fmu: &Description) -> Vec<Known> {
    /// So large a part is as odd as the whole of what was stated of another.
    const ODD: f64 = 0.02;
    let mut all: Vec<Known> = Vec::new();
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
            (Fault::Offset, SensorError::Offset, most, unit),
            (Fault::Gain, SensorError::Gain { about: 0.0 }, 0.5, None),
        ];
        all.extend(errors.map(|(fault, error, width, unit)| Known {
            slot: Slot { error: Some(error), ..series.slot.clone() },
            free: Free::linear(series.slot.name.clone(), unit, [-width, width]),
            value: 0.0,
            usual: ODD * if fault == Fault::Gain { 1.0 } else { most },
            fault,
        }));
    }
    all.retain(|known| known.free.check().is_ok());
    all
}

/// The real parameters and start values of the FMU that the study does not vary.
fn found(bound: &Bound, fmu: &Description) -> Vec<Known> {
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
            all.push(Known { slot, free, value, fault: Fault::Constant, usual: ODD * value.abs() });
        }
    }
    all
}

/// What would explain the misfit, for people.
pub fn document(outcome: &IdentificationOutcome) -> Option<Document> {
    const SHOWN: usize = 4;
    let suspects = outcome.suspects.as_ref()?;
    let first = suspects.first()?;
    // What leaves far more than the first is no rival.
    let rivals: Vec<&Suspect> = suspects.iter().filter(|other| other.explains() == first.explains()).collect();
    // The only one stands in the headline, as does that nothing was found.
    if rivals.len() < 2 && coarse(outcome).is_none() {
        return None;
    }
    let mut told = Document::new("causes", "Causes", "What would explain the misfit");
    told.say(if first.explains() {
        "Each of these alone, the likeliest first, with the parameters fitted again."
    } else {
        "Nothing that was tried explains all of it. Most of it goes with these, each alone."
    });
    let sentences = rivals.into_iter().take(SHOWN).map(|suspect| format!("{}: {}.", sentence(suspect), falls(suspect)));
    told.list(sentences.collect());
    Some(told)
}

/// What speaks for a cause.
fn falls(suspect: &Suspect) -> String {
    let [before, after] = suspect.cost.map(|cost| number(cost, 3));
    format!("the sum of squares of the misfits falls from {before} to {after}")
}

const NOTHING: &str = "Nothing that was tried explains it: no parameter beyond its range, no other constant of the model, no zero \
                       error, gain, delay or unit of a sensor. Something is probably missing in the model, or in the stated uncertainties.";

/// The likeliest cause in a sentence.
pub fn headline(outcome: &IdentificationOutcome) -> Option<String> {
    /// Sums of squares this near do not tell causes apart.
    const NEAR: f64 = 4.0;
    let Some(suspects) = &outcome.suspects else {
        return strained(outcome).filter(|_| outcome.end == End::Converged && !outcome.has_several());
    };
    if let Some(step) = coarse(outcome) {
        return Some(step);
    }
    let Some(first) = suspects.first() else { return strained(outcome).or_else(|| Some(NOTHING.to_owned())) };
    let part = if first.explains() {
        "Likeliest cause"
    } else {
        "Nothing that was tried explains all of it: two things may be wrong, or the model lacks something. Likeliest cause of \
             most of it"
    };
    let mut equals: Vec<String> = suspects[1..]
        .iter()
        .filter(|other| other.cost[1] - first.cost[1] < NEAR)
        .map(|other| match other.fault {
            Fault::Range | Fault::Constant => other.name.clone(),
            Fault::Offset | Fault::Gain => format!("the sensor of {}", other.name),
            Fault::Delay => format!("the times of {}", other.name),
            Fault::Unit(_) => format!("the unit of {}", other.name),
        })
        .collect();
    equals.dedup();
    let as_well = match equals[..] {
        [] => String::new(),
        _ => format!(" The data do not tell it from other causes: {}.", equals.join(", ")),
    };
    Some(format!("{part}: {}; with it {}.{as_well}", sentence(first), falls(first)))
}

/// That the step is too coarse, where half of it changes the misfit as much as what is to be explained, and does not only make a fit
/// worse that something else explains.
fn coarse(outcome: &IdentificationOutcome) -> Option<String> {
    let error = outcome.numerical_error.as_ref()?;
    let excess = outcome.cost - outcome.degrees_of_freedom as f64;
    let is_worse = error.cost > outcome.cost && outcome.is_explained();
    ((error.cost - outcome.cost).abs() > 0.5 * excess && !is_worse).then(|| {
        let [now, finer] = [outcome.cost, error.cost].map(|cost| number(cost, 3));
        let steps: Vec<String> = error.steps.iter().map(f64::to_string).collect();
        format!(
            "Likeliest cause: the communication step of {} s is too coarse, as half of it changes the sum of squares from {now} to \
             {finer}. Shorten `step` (of a system `system --step`) before you look for others.",
            steps.join(" and ")
        )
    })
}

/// What explains that points miss the measured values, for the first screen of the study: a cause, that nothing was found, or
/// that the parameters alone do. Nothing where the search has no one answer.
pub fn causes(outcome: &IdentificationOutcome) -> Vec<String> {
    /// Of a parameter that the data determine they leave less of the prior's deviation.
    const DETERMINED: f64 = 0.5;
    if outcome.end != End::Converged || outcome.fit() != Fit::Good || outcome.has_several() {
        return headline(outcome).into_iter().collect();
    }
    if let Some(strained) = strained(outcome) {
        return vec![strained];
    }
    let values: Vec<String> = outcome
        .free
        .iter()
        .filter(|free| free.left < DETERMINED)
        .map(|free| {
            let unit = behind(free.unit.as_deref().filter(|unit| *unit != "1"));
            let [low, high] = free.interval.map(|end| number(end, 4));
            format!("{} = {}{unit} ({low} .. {high}, 95 %)", free.name, number(free.value, 4))
        })
        .collect();
    if values.is_empty() {
        Vec::new()
    } else {
        vec![format!("The parameters alone would explain it: the model fits at {}.", values.join(", "))]
    }
}

/// Sensors and parameters without which the model would not fit, so far beyond what is stated of them.
fn strained(outcome: &IdentificationOutcome) -> Option<String> {
    /// So many standard uncertainties.
    const FAR: f64 = 3.0;
    let suspect = |fault, name: &str, value, unit: &Option<String>, [low, high]: [f64; 2]| Suspect {
        fault,
        name: name.to_owned(),
        value,
        unit: unit.clone(),
        allowed: Some([low, high]),
        departure: 0.0,
        cost: [outcome.cost; 2],
        probability: None,
    };
    let far = || outcome.shared.iter().filter(|error| error.value.abs() * error.coverage > FAR * error.limit);
    let sensors = far().map(|error| {
        let fault = if error.kind == SharedKind::Gain { Fault::Gain } else { Fault::Offset };
        sentence(&suspect(fault, &error.name, error.value, &error.unit, [-error.limit, error.limit]))
    });
    // A study's distribution is its drawing. Of what the data tell nothing, the value is that of the prior.
    let off = || outcome.free.iter().filter(|free| free.strain().abs() > FAR);
    let parameters = off().filter_map(|free| {
        let Prior { centre, spread } = free.prior?;
        let allowed = match free.scale {
            Spacing::Linear => [centre - 2.0 * spread, centre + 2.0 * spread],
            Spacing::Log => [centre / spread.powi(2), centre * spread.powi(2)],
        };
        let told = sentence(&suspect(Fault::Range, &free.name, free.value, &free.unit, allowed));
        Some(format!("{told} ({} standard deviations from {})", number(free.strain().abs(), 2), number(centre, 4)))
    });
    let all: Vec<String> = sensors.chain(parameters).collect();
    // Without what the strain itself adds, the rest may be as of a right model.
    let of_sensors = far().map(|error| error.value * error.coverage / error.limit);
    let strain: f64 = of_sensors.chain(off().map(FreeOutcome::strain)).map(|strain| strain * strain).sum();
    let freedom = outcome.degrees_of_freedom as f64;
    let fits = match outcome.fit() {
        Fit::Misses if outcome.cost - strain > freedom + FAR * (2.0 * freedom).sqrt() => {
            "Even with that the model misses: something else is missing in it, or in the stated uncertainties"
        }
        _ => "The model fits only with that",
    };
    (!all.is_empty()).then(|| format!("Likeliest cause: {}. {fits}.", all.join(", and ")))
}

fn sentence(suspect: &Suspect) -> String {
    let unit = behind(suspect.unit.as_deref().filter(|unit| *unit != "1"));
    let (name, value) = (&suspect.name, number(suspect.value, 4));
    let percent = |part: f64| number(100.0 * part.abs(), 3);
    let stated = suspect
        .allowed
        .map(|[_, limit]| match suspect.fault {
            Fault::Gain => format!(" (stated: at most {} %)", percent(limit)),
            _ => format!(" (stated: at most {}{unit})", number(limit, 3)),
        })
        .unwrap_or_default();
    let (high, late) = if suspect.value > 0.0 { ("high", "late") } else { ("low", "early") };
    match &suspect.fault {
        Fault::Range => {
            let [low, high] = suspect.allowed.unwrap_or([f64::NAN; 2]);
            let (side, end) = if suspect.value > high { ("above", high) } else { ("below", low) };
            let far = if end == 0.0 {
                String::new()
            } else {
                format!(", {} % {side} it", percent(suspect.value / end - 1.0))
            };
            format!("{name} is {value}{unit} instead of {} .. {}{unit}{far}", number(low, 4), number(high, 4))
        }
        Fault::Constant => {
            let [given, _] = suspect.allowed.unwrap_or([f64::NAN; 2]);
            format!("{name}, which the study does not vary, is {value}{unit} instead of {}{unit}", number(given, 4))
        }
        Fault::Offset => {
            format!("the sensor of {name} reads {}{unit} too {high}{stated}", number(suspect.value.abs(), 3))
        }
        Fault::Gain => format!("the sensor of {name} reads {} % too {high}{stated}", percent(suspect.value)),
        Fault::Delay => format!("{name} is recorded {} s too {late}", number(suspect.value.abs(), 3)),
        Fault::Unit(words) => format!("{name} would fit if {words}"),
    }
}
