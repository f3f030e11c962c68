//! `identify --surrogate`: polynomials in place of the model.

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

/// The most runs that the fit of a polynomial uses.
const MOST: u64 = 4000;

/// Refuses numbers of runs from which no surrogate can be made.
pub(super) fn check(study: &Study, settings: &Identification, bound: &Bound, options: &Asked) -> Result<(), Error> {
    let Some(runs) = &settings.surrogate else {
        return Ok(());
    };
    let (number, fewest) = (*runs.as_ref(), fewest(&bound.problem));
    if (fewest..=MOST).contains(&number) {
        return Ok(());
    }
    let message = format!("{number} runs: give {fewest} or more for these unknowns, and at most {MOST}");
    Err(match options.surrogate.is_some() {
        true => Error::option("surrogate", message),
        false => study.error_at(runs, message).into(),
    })
}

/// Makes surrogates where the study or the call wants them.
pub(super) fn replaced(
    study: &Study,
    settings: &Identification,
    search: &rounds::Task<'_>,
    model: &dyn Simulate,
    say: &dyn Fn(String),
) -> Result<Option<Replaced>, SearchError> {
    let Some(runs) = &settings.surrogate else {
        return Ok(None);
    };
    let unknowns = search.problem.unknowns();
    let evenly = |count: usize, round: u64| {
        // A net has as many dimensions as there are unknowns; the seeds of rounds follow that of the starts.
        let seed = settings.seed.wrapping_add(1 + round);
        cube(unknowns, count as u64, seed, 1)
    };
    // Whether there is a net of so many dimensions shows at the first one.
    evenly(1, 0).map_err(|message| SearchError::Surrogate(study.error(format!("[identify] {message}")).to_string()))?;
    let task = Task {
        search: *search,
        runs: *runs.as_ref() as usize,
        spread: &|count, round| {
            evenly(count, round).expect("a net of these dimensions was made above, and so few points fit in it")
        },
        seed: settings.seed,
    };
    made(&task, model, say).map(Some)
}

/// Runs the optima again in the model, whose predictions take the place of the surrogates'.
pub(super) fn run_again(
    objective: &Objective<'_>,
    replaced: &Replaced,
    optima: &mut [Optimum],
) -> Result<SurrogateOutcome, SearchError> {
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
