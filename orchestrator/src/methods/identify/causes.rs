//! What explains that the model misses the measured values, in sentences.

use calibration::{
    fit::FitVerdict,
    local::End,
    outcome::{FreeOutcome, IdentificationOutcome},
    problem::{Prior, SharedKind, Spacing},
    suspects::{Suspect, Suspicion},
};
use result_document::{Document, format::number};

use crate::results::words::unit_behind;

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
            Suspicion::Range | Suspicion::Constant => other.name.clone(),
            Suspicion::Offset | Suspicion::Gain => format!("the sensor of {}", other.name),
            Suspicion::Delay => format!("the times of {}", other.name),
            Suspicion::Unit(_) => format!("the unit of {}", other.name),
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
    if outcome.end != End::Converged || outcome.fit() != FitVerdict::Good || outcome.has_several() {
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
            let unit = unit_behind(free.unit.as_deref());
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
        let fault = if error.kind == SharedKind::Gain { Suspicion::Gain } else { Suspicion::Offset };
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
        let told = sentence(&suspect(Suspicion::Range, &free.name, free.value, &free.unit, allowed));
        Some(format!("{told} ({} standard deviations from {})", number(free.strain().abs(), 2), number(centre, 4)))
    });
    let all: Vec<String> = sensors.chain(parameters).collect();
    // Without what the strain itself adds, the rest may be as of a right model.
    let of_sensors = far().map(|error| error.value * error.coverage / error.limit);
    let strain: f64 = of_sensors.chain(off().map(FreeOutcome::strain)).map(|strain| strain * strain).sum();
    let freedom = outcome.degrees_of_freedom as f64;
    let fits = match outcome.fit() {
        FitVerdict::Misses if outcome.cost - strain > freedom + FAR * (2.0 * freedom).sqrt() => {
            "Even with that the model misses: something else is missing in it, or in the stated uncertainties"
        }
        _ => "The model fits only with that",
    };
    (!all.is_empty()).then(|| format!("Likeliest cause: {}. {fits}.", all.join(", and ")))
}

fn sentence(suspect: &Suspect) -> String {
    let unit = unit_behind(suspect.unit.as_deref());
    let (name, value) = (&suspect.name, number(suspect.value, 4));
    let percent = |part: f64| number(100.0 * part.abs(), 3);
    let stated = suspect
        .allowed
        .map(|[_, limit]| match suspect.fault {
            Suspicion::Gain => format!(" (stated: at most {} %)", percent(limit)),
            _ => format!(" (stated: at most {}{unit})", number(limit, 3)),
        })
        .unwrap_or_default();
    let (high, late) = if suspect.value > 0.0 { ("high", "late") } else { ("low", "early") };
    match &suspect.fault {
        Suspicion::Range => {
            let [low, high] = suspect.allowed.unwrap_or([f64::NAN; 2]);
            let (side, end) = if suspect.value > high { ("above", high) } else { ("below", low) };
            let far = if end == 0.0 {
                String::new()
            } else {
                format!(", {} % {side} it", percent(suspect.value / end - 1.0))
            };
            format!("{name} is {value}{unit} instead of {} .. {}{unit}{far}", number(low, 4), number(high, 4))
        }
        Suspicion::Constant => {
            let [given, _] = suspect.allowed.unwrap_or([f64::NAN; 2]);
            format!("{name}, which the study does not vary, is {value}{unit} instead of {}{unit}", number(given, 4))
        }
        Suspicion::Offset => {
            format!("the sensor of {name} reads {}{unit} too {high}{stated}", number(suspect.value.abs(), 3))
        }
        Suspicion::Gain => format!("the sensor of {name} reads {} % too {high}{stated}", percent(suspect.value)),
        Suspicion::Delay => format!("{name} is recorded {} s too {late}", number(suspect.value.abs(), 3)),
        Suspicion::Unit(words) => format!("{name} would fit if {words}"),
    }
}
