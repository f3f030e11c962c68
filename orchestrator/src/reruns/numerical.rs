//! `verify --validation`: the numerical uncertainty of the criteria's values, by some points with finer communication
//! steps, and with finer tolerances of the FMU's solver. The user asks for it, so it takes its time: only each run is limited.

use super::Reruns;
use super::finer::refined_case;
use crate::results::Summary;
use conformity::validation::{Comparison, Numerical, Refined, refined};
use fmu_points::task::Case;
use point_journal::pipeline::Model;

/// So many points are refined.
const POINTS: u64 = 3;

/// Adds to the summary what the refinement shows.
pub(super) fn observe(reruns: &Reruns<'_>, summary: &mut Summary) {
    let all = numerical(reruns);
    // Curves are all among the criteria, but have no comparison.
    for (name, comparison) in &mut summary.validation {
        let place = summary.criteria.get_full(name);
        let numerical = place.and_then(|(number, ..)| all.get(number));
        if let (Some((_, _, count)), Some(numerical)) = (place, numerical) {
            let spread = [comparison.model, comparison.u_input];
            let refined = Comparison::new(&count.criterion.measured(), spread, numerical.clone());
            *comparison = refined.unwrap_or_else(|| comparison.clone());
        }
    }
}

/// The numerical uncertainty of each criterion: the largest of some points.
fn numerical(reruns: &Reruns<'_>) -> Vec<Numerical> {
    let verification = reruns.verification;
    let (session, cases) = (&verification.session, &reruns.plan().cases);
    let tolerance = cases
        .iter()
        .all(|case| case.task.schedule.tolerance.is_some());
    let mut largest = vec![Numerical::default(); session.judge.criteria.len()];
    for index in 0..POINTS.min(verification.source.len()) {
        let values = verification.job(index).values;
        let run = |by: Refined, times: i32| {
            let finer: Vec<Case> = cases
                .iter()
                .map(|case| refined_case(case, by, times))
                .collect();
            let answer = reruns.answer(&finer, values.clone()).ok()?;
            session.outcome(answer).ok()
        };
        let Some(coarse) = run(Refined::Step, 0) else {
            continue;
        };
        let runs = |by: Refined| Some([run(by, 1)?, run(by, 2)?]);
        let steps = runs(Refined::Step);
        // Without a tolerance the FMU chooses its own, which nobody knows.
        let tolerances = tolerance.then(|| runs(Refined::Tolerance)).flatten();
        let parts = [(Refined::Step, steps), (Refined::Tolerance, tolerances)];
        for (k, known) in largest.iter_mut().enumerate() {
            let part = |(by, finer): &(Refined, Option<[Vec<f64>; 2]>)| {
                let [middle, fine] = finer.as_ref()?;
                Some(refined([coarse[k], middle[k], fine[k]], *by))
            };
            let Some(here) = parts.iter().filter_map(part).reduce(Numerical::and) else {
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
