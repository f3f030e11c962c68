//! `identify --budget N`: at most N runs of an FMU whose runs are dear, by a surrogate, which has the runs of the study's points
//! in the same folder, too.

use std::path::Path;

use super::{
    super::known::{digest_of, points_of},
    BoundStudy,
};
use crate::{error::Result, identify::bind::Bound};
use calibration::{
    objective::{Misfit, Objective},
    optima::Optimum,
    problem::{Prediction, Query, Simulate},
    rounds,
    search::SearchError,
    surrogate::{
        Replaced, Task, fewest,
        outcome::{RunAgain, SurrogateOutcome},
        replaced as made,
    },
};
use sampling::design::cube;

/// Runs of each case beside those of the surrogate: one before the first, one once more, half the steps, and two optima.
const BESIDE: u64 = 5;
/// The fit of more runs takes minutes.
const MOST: u64 = 1000;
/// Those of them that are not asked for by the search.
const UNASKED: u64 = 3;

/// The fit takes the cube of the number of places; more points of a study tell little more.
const POINTS: usize = 250;

/// The study's points in the folder of the results, as runs that need not be made again.
#[derive(Debug, Default)]
pub struct KnownPoints {
    /// A digest of the points; none where there are none.
    pub digest: Option<String>,
    places: Vec<Vec<f64>>,
    predictions: Vec<Prediction>,
}

impl KnownPoints {
    /// The points of a folder whose values are those that a search asks for: the same FMU and study, each varied parameter an
    /// unknown, each measured value that of a criterion. A curve has more rows than the points tell.
    pub fn of(fit: &BoundStudy, folder: &Path) -> Result<Self> {
        let BoundStudy { study, package, bound, .. } = fit;
        let problem = &bound.problem;
        let is_plain = bound.curves.is_empty()
            && bound.others().is_empty()
            && problem.latents.is_empty()
            && problem.populations.is_empty()
            && problem.cases.len() == 1;
        let Some((summary, table)) = is_plain.then(|| points_of(folder, study).ok()).flatten() else {
            return Ok(Self::default());
        };
        if summary.provenance.fmu_sha256.as_deref() != Some(&package.digest()?) {
            return Ok(Self::default());
        }
        let told = |unit: &Option<String>, column: &str| unit.as_deref().unwrap_or_default() == column;
        let inputs = problem.free.iter().map(|free| {
            let column = table.parameters.iter().find(|column| column.name == free.name);
            column.filter(|column| told(&free.unit, &column.unit))
        });
        let outputs = problem.quantities.iter().map(|quantity| {
            let column = table.criteria.iter().find(|column| column.name == quantity.name);
            column.filter(|column| told(&quantity.unit, &column.unit))
        });
        let (Some(inputs), Some(outputs)) = (inputs.collect::<Option<Vec<_>>>(), outputs.collect::<Option<Vec<_>>>())
        else {
            return Ok(Self::default());
        };
        // What else varies, a search holds.
        let mut varied =
            table.parameters.iter().filter(|column| column.values.windows(2).any(|pair| pair[0] != pair[1]));
        if varied.any(|column| problem.free.iter().all(|free| free.name != column.name)) {
            return Ok(Self::default());
        }
        let mut known = Self { digest: Some(digest_of(folder)?), ..Self::default() };
        for row in 0..table.len().min(POINTS) {
            let places: Vec<f64> =
                problem.free.iter().zip(&inputs).map(|(free, column)| free.place(column.values[row])).collect();
            if places.iter().all(|place| (0.0..=1.0).contains(place)) {
                known.places.push(places);
                known.predictions.push(if table.completed(row) {
                    Ok(outputs.iter().map(|column| column.values[row]).collect())
                } else {
                    Err(table.status[row].to_string())
                });
            }
        }
        Ok(known)
    }

    /// The answers, as a search asks for them.
    pub fn answers<'a>(&'a self, bound: &'a Bound) -> impl Iterator<Item = (Query, Prediction)> + 'a {
        self.places
            .iter()
            .map(|places| Query { case: 0, free: bound.problem.free_values(places), latents: Vec::new() })
            .zip(self.predictions.iter().cloned())
    }
}

/// Runs of each query of the search, and those that it does not ask for. A place is asked for with all cases of the table, and
/// those of the study run together.
pub fn cost(bound: &Bound) -> [u64; 2] {
    let each = bound.simulations.len().max(1) as u64;
    [each, UNASKED * cases(bound)]
}

/// Runs of each place.
fn cases(Bound { problem, simulations, .. }: &Bound) -> u64 {
    (problem.cases.len().max(1) * simulations.len().max(1)) as u64
}

/// Refuses numbers of runs from which no surrogate can be made. The study's points may be enough for one.
pub fn check(BoundStudy { bound, known, request, .. }: &BoundStudy) -> Result {
    let Some(account) = &request.account else { return Ok(()) };
    let cases = cases(bound);
    let fewest = fewest(&bound.problem, known.places.len()) as u64;
    let least = if fewest > 0 { cases * (fewest + BESIDE) } else { 0 };
    if (least..=MOST * cases).contains(&account.left()) {
        return Ok(());
    }
    let each = if cases > 1 { format!(" of {cases} cases") } else { String::new() };
    Err(account.too_few(least, &format!(" for these unknowns{each}, and at most {}", MOST * cases)))
}

/// Makes surrogates where a budget wants them.
pub fn replaced(
    BoundStudy { request, study, settings, bound, known, .. }: &BoundStudy,
    search: &rounds::Task,
    model: &dyn Simulate,
    say: &dyn Fn(String),
) -> Result<Option<Replaced>, SearchError> {
    let Some(account) = &request.account else { return Ok(None) };
    let unknowns = search.problem.unknowns();
    let evenly = |count: usize| cube(unknowns, count as u64, settings.seed.wrapping_add(1), 1);
    // Whether there is a net of so many dimensions shows at the first one.
    evenly(1).map_err(|message| SearchError::Surrogate(study.error_in("identify", &[], message).to_string()))?;
    let task = Task {
        search: *search,
        known: &known.places,
        places: (account.left() / cases(bound)).saturating_sub(BESIDE) as usize,
        spread: &|count| match count {
            0 => Vec::new(),
            count => evenly(count).expect("a net of these dimensions was made above, and so few points fit in it"),
        },
        seed: settings.seed,
    };
    made(&task, model, say).map(Some)
}

/// Runs the optima in the model, whose predictions take the place of the surrogates'. Those for which the budget has no run left
/// are left out, but for the first.
pub fn run_again(
    objective: &Objective,
    replaced: &Replaced,
    (optima, left): (&mut Vec<Optimum>, u64),
) -> Result<SurrogateOutcome, SearchError> {
    let cases = objective.problem.cases.len().max(1) as u64;
    optima.truncate(((left / cases) as usize).max(1));
    if left < cases {
        return Ok(replaced.told.clone());
    }
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
