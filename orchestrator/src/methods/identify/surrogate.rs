//! `identify --budget N`: at most N runs of an FMU whose runs are dear, by a surrogate.

use super::Asked;
use crate::error::Error;
use crate::identify::bind::Bound;
use calibration::objective::{Misfit, Objective};
use calibration::optima::Optimum;
use calibration::problem::Simulate;
use calibration::rounds;
use calibration::search::SearchError;
use calibration::surrogate::outcome::{RunAgain, SurrogateOutcome};
use calibration::surrogate::{Replaced, Task, fewest, replaced as made};
use sampling::design::cube;
use study::{Identification, Study};

/// Runs of each case beside those of the surrogate: one before the first, one once more, half the steps, and two optima.
const BESIDE: u64 = 5;
/// The fit of more runs takes minutes.
const MOST: u64 = 1000;
/// Those of them that are not asked for by the search.
const UNASKED: u64 = 3;

/// Places, each with all cases, of which a budget makes surrogates.
fn places(runs: u64, bound: &Bound) -> u64 {
    (runs / bound.problem.cases.len().max(1) as u64).saturating_sub(BESIDE)
}

/// Runs that a search may ask for.
pub(super) fn asked(runs: u64, bound: &Bound) -> u64 {
    runs.saturating_sub(UNASKED * bound.problem.cases.len() as u64)
}

/// Refuses numbers of runs from which no surrogate can be made.
pub(super) fn check(bound: &Bound, options: &Asked) -> Result<(), Error> {
    let Some(runs) = options.budget else { return Ok(()) };
    let cases = bound.problem.cases.len() as u64;
    let least = cases * (fewest(&bound.problem) as u64 + BESIDE);
    if (least..=MOST * cases).contains(&runs) {
        return Ok(());
    }
    let each = if cases > 1 { format!(" of {cases} cases") } else { String::new() };
    let message = format!("{runs} runs: give {least} or more for these unknowns{each}, and at most {}", MOST * cases);
    Err(Error::option("budget", message))
}

/// Makes surrogates where a budget wants them.
pub(super) fn replaced(
    (study, settings, bound): (&Study, &Identification, &Bound),
    budget: Option<u64>,
    search: &rounds::Task<'_>,
    model: &dyn Simulate,
    say: &dyn Fn(String),
) -> Result<Option<Replaced>, SearchError> {
    let Some(runs) = budget else { return Ok(None) };
    let unknowns = search.problem.unknowns();
    let evenly = |count: usize| cube(unknowns, count as u64, settings.seed.wrapping_add(1), 1);
    // Whether there is a net of so many dimensions shows at the first one.
    evenly(1).map_err(|message| SearchError::Surrogate(study.error(format!("[identify] {message}")).to_string()))?;
    let task = Task {
        search: *search,
        places: places(runs, bound) as usize,
        spread: &|count| evenly(count).expect("a net of these dimensions was made above, and so few points fit in it"),
        seed: settings.seed,
    };
    made(&task, model, say).map(Some)
}

/// Runs the optima in the model, whose predictions take the place of the surrogates'. Those for which the budget has no run left
/// are left out, but for the first.
pub(super) fn run_again(
    objective: &Objective<'_>,
    replaced: &Replaced,
    (optima, left): (&mut Vec<Optimum>, u64),
) -> Result<SurrogateOutcome, SearchError> {
    let cases = objective.problem.cases.len().max(1) as u64;
    optima.truncate(((left / cases) as usize).max(1));
    let places: Vec<&[f64]> = optima.iter().map(|optimum| &optimum.minimum.places[..]).collect();
    let misfits = objective.misfits(&places)?;
    let mut told = replaced.told.clone();
    for (Optimum { minimum, .. }, misfit) in optima.iter_mut().zip(misfits) {
        told.optima.push(RunAgain { surrogate: minimum.misfit.cost(), model: misfit.as_ref().ok().map(Misfit::cost) });
        if let Ok(misfit) = misfit {
            minimum.misfit = misfit;
        }
    }
    Ok(told)
}
