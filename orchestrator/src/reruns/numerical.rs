//! The numerical error of the criteria's values: the best point, and some others of many, with half the communication steps;
//! with `--validation` some points with finer steps and with finer tolerances of the FMU's solver. The user asks for these, so
//! they take their time: only each run is limited.

use super::{Halt, Reruns, finer::refined_case};
use crate::results::Summary;
use conformity::validation::{Comparison, Numerical, Refined, Scatter, refined};
use fmu_points::task::Case;
use point_journal::pipeline::Model;
use result_document::format::number;
use study::{
    concern::{Code, Concern},
    judge::Criterion,
};

/// So many points are refined.
const POINTS: u64 = 3;
/// A point with half the steps takes as long as two: 4 % of so many.
const AFFORDABLE: u64 = 50;
/// Of so many points another one is tried: three simulations more.
const AMONG: u64 = 100;
/// A larger part of an accuracy is notable.
const PART: f64 = 1.0 / 3.0;

/// Adds to the summary what the refinement shows; says what is left out.
pub fn observe(reruns: &Reruns, summary: &mut Summary) -> Option<String> {
    let asked = reruns.wish.validation;
    let is_affordable = reruns.wish.dear || summary.points >= AFFORDABLE && reruns.wish.most > 0;
    let is_random = summary.conduct.as_ref().and_then(|c| c.reproducible) == Some(false);
    let halved = ((asked || is_affordable) && !is_random).then(|| with_half_the_step(reruns, summary));
    let (mut doubts, left_out) = match halved {
        Some(Ok(doubts)) => (doubts, None),
        Some(Err(halt)) => (Vec::new(), Some(format!("half the communication step was not tried: {halt}"))),
        None => (Vec::new(), None),
    };
    if asked {
        let known = validate(reruns, summary);
        let others: Vec<_> = summary
            .criteria
            .values()
            .map(|count| &count.criterion)
            .zip(&known)
            .filter(|(criterion, _)| doubts.iter().all(|(name, _)| *name != criterion.name))
            .filter_map(|(criterion, known)| uncertain(criterion, known.standard?))
            .collect();
        doubts.extend(others);
    }
    let doubts = doubts.into_iter().map(|(_, doubt)| doubt);
    // Wrong values come before what they mean.
    summary.concerns.splice(0..0, doubts);
    left_out
}

/// A doubt about a criterion, with its name.
type Doubt = (String, Concern);

/// Runs points with half the communication steps: the best one, as its values decide most, and of a large study some others,
/// as a single one may happen to be right. The error that this changes by halves with the step, or falls faster, so twice
/// the change is the error.
fn with_half_the_step(reruns: &Reruns, summary: &Summary) -> Result<Vec<Doubt>, Halt> {
    let session = &reruns.verification.session;
    let cases = &reruns.plan().cases;
    let finer: Vec<Case> = cases.iter().map(|case| refined_case(case, Refined::Step, 1)).collect();
    let run = |cases: &[Case], values: &[f64]| -> Result<_, Halt> {
        Ok(session.outcome(reruns.answer(cases, values.to_vec())?)?)
    };
    let criteria = || session.judge.criteria.iter();
    // Points with their values in the criteria's order, with the study's steps and with half of them.
    let mut tried = Vec::new();
    let best = summary.best_point.as_ref();
    if let Some((best, values)) = best.and_then(|best| Some((best, reruns.values(best.point)?))) {
        let coarse = criteria()
            .map(|criterion| best.values.get(&criterion.name).copied())
            .map(|value| value.unwrap_or(f64::NAN))
            .collect();
        tried.push((best.point, coarse, run(&finer, &values)?));
    }
    let others = (summary.points / AMONG).min(reruns.wish.most.saturating_sub(1) as u64);
    for number in 0..others {
        let index = number * reruns.verification.source.len() / others;
        let job = reruns.verification.job(index);
        // What fails here failed in the study, too, or is the finer run's own trouble.
        if let Ok(coarse) = run(cases, &job.values)
            && let Ok(finer) = run(&finer, &job.values)
        {
            tried.push((job.index, coarse, finer));
        }
    }
    Ok(criteria().zip(reruns.plan().placed_probes()).enumerate().filter_map(|(k, (criterion, (case, _)))| {
        let change = |(_, coarse, finer): &&(u64, Vec<f64>, Vec<f64>)| (finer[k] - coarse[k]).abs();
        let most = tried.iter().filter(|tried| change(tried).is_finite()).max_by(|a, b| change(a).total_cmp(&change(b)))?;
        let is_notable = 2.0 * change(&most) > PART * criterion.room();
        is_notable.then(|| {
            let (point, coarse, finer) = most;
            let unit = criterion.unit_behind();
            let [finer, coarse] = [finer[k], coarse[k]].map(|value| number(value, 4));
            let concern = Concern::new(Code::CoarseStep, format!(
                "{}: the communication step of {} s is too coarse: with half of it point {point} gives {finer}{unit}, not {coarse}{unit} \
                 ({})",
                criterion.name, cases[case].task.schedule.step, criterion.allowed()
            ));
            (criterion.name.clone(), concern.remedied("Choose a shorter `step` under [simulation], for a system `--step` of `system`."))
        })
    }).collect())
}

/// A doubt where the numerical uncertainty is a notable part of the accuracy.
fn uncertain(criterion: &Criterion, standard: f64) -> Option<Doubt> {
    let concern = Concern::new(
        Code::CoarseStep,
        format!(
            "{}: the numerical uncertainty u_num of {}{} is more than a third of what is allowed ({})",
            criterion.name,
            number(standard, 3),
            criterion.unit_behind(),
            criterion.allowed()
        ),
    )
    .remedied("Choose a shorter `step` under [simulation], or a smaller tolerance of the FMU's solver.");
    (standard > PART * criterion.room()).then(|| (criterion.name.clone(), concern))
}

/// Adds the numerical uncertainties to the comparisons.
fn validate(reruns: &Reruns, summary: &mut Summary) -> Vec<Numerical> {
    let all = numerical(reruns);
    // Curves are all among the criteria, but have no comparison.
    for (name, comparison) in &mut summary.validation {
        let place = summary.criteria.get_full(name);
        let numerical = place.and_then(|(number, ..)| all.get(number));
        if let (Some((_, _, count)), Some(numerical)) = (place, numerical) {
            let Comparison { model: mean, u_input: deviation, points, .. } = *comparison;
            let values = Scatter { mean, deviation, points };
            let refined = Comparison::new(&count.criterion.measured(), values, numerical.clone());
            *comparison = refined.unwrap_or_else(|| comparison.clone());
        }
    }
    all
}

/// The numerical uncertainty of each criterion: the largest of some points.
fn numerical(reruns: &Reruns) -> Vec<Numerical> {
    let verification = reruns.verification;
    let (session, cases) = (&verification.session, &reruns.plan().cases);
    let tolerance = cases.iter().all(|case| case.task.schedule.tolerance.is_some());
    let mut largest = vec![Numerical::default(); session.judge.criteria.len()];
    for index in 0..POINTS.min(verification.source.len()) {
        let values = verification.job(index).values;
        let run = |by, times: u32| {
            let finer: Vec<Case> = cases.iter().map(|case| refined_case(case, by, times)).collect();
            let answer = reruns.answer(&finer, values.clone()).ok()?;
            session.outcome(answer).ok()
        };
        let Some(coarse) = run(Refined::Step, 0) else { continue };
        let runs = |by| Some([run(by, 1)?, run(by, 2)?]);
        let steps = runs(Refined::Step);
        // Without a tolerance the FMU chooses its own, which nobody knows.
        let tolerances = tolerance.then(|| runs(Refined::Tolerance)).flatten();
        let parts = [(Refined::Step, steps), (Refined::Tolerance, tolerances)];
        for (k, known) in largest.iter_mut().enumerate() {
            let Some(here) = parts
                .iter()
                .filter_map(|(by, finer)| {
                    let [middle, fine] = finer.as_ref()?;
                    Some(refined([coarse[k], middle[k], fine[k]], *by))
                })
                .reduce(Numerical::and)
            else {
                continue;
            };
            // One that is known beats one that is not, and of those the larger one counts.
            if here.standard >= known.standard {
                *known = here;
            }
        }
    }
    largest
}
