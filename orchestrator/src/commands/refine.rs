//! `verify --validation`: the numerical uncertainty of the criteria's values, by some points with finer communication
//! steps, and with finer tolerances of the FMU's solver.

use std::path::Path;
use std::time::Duration;

use super::CommandError;
use crate::cli::Means;
use crate::engine::process::Limits;
use crate::engine::single::Recorder;
use crate::engine::working_directory;
use crate::pipeline::Model;
use crate::pipeline::stop;
use crate::results::validation::{Comparison, Numerical, Refined, refined};
use crate::results::{Outcome, Summary, write_atomically};
use crate::session::Verification;
use crate::task::Case;

/// So many points are refined.
const POINTS: u64 = 3;

/// The summary with what the refinement shows, which is written again.
pub(super) fn observed(
    verification: &mut Verification,
    means: &Means,
    folder: &Path,
    summary: &Summary,
) -> Result<Summary, CommandError> {
    let found = numerical(verification, means)?;
    let mut summary = summary.clone();
    // Curves are found among the criteria, but have no comparison.
    for (name, comparison) in &mut summary.validation {
        let place = summary.criteria.get_full(name);
        let numerical = place.and_then(|(number, ..)| found.get(number));
        if let (Some((_, _, count)), Some(numerical)) = (place, numerical) {
            let spread = [comparison.model, comparison.u_input];
            *comparison = Comparison::new(&count.criterion, spread, numerical.clone());
        }
    }
    write_atomically(&folder.join("summary.json"), |out| {
        serde_json::to_writer_pretty(&mut *out, &summary)?;
        writeln!(out)
    })?;
    Ok(summary)
}

/// The numerical uncertainty of each criterion: the largest of some points.
fn numerical(
    verification: &mut Verification,
    means: &Means,
) -> Result<Vec<Numerical>, CommandError> {
    let scratch = stop::scratch()?;
    let limits = Limits {
        time: Duration::from_secs_f64(means.point_timeout.clamp(1.0, 1e9)),
        memory: 16 << 30,
    };
    let cases = &verification.session.plan.cases;
    let tolerance = cases
        .iter()
        .all(|case| case.task.schedule.tolerance.is_some());
    let mut found = vec![Numerical::default(); verification.session.judge.criteria.len()];
    for index in 0..POINTS.min(verification.source.len()) {
        let job = verification.job(index);
        let mut run = |by: Refined, times: i32| -> Result<Outcome, CommandError> {
            // Unpacked again where the last run has changed it.
            let fmu = verification.session.package.unpack(scratch.path())?;
            let session = &verification.session;
            let (package, cases) = (&session.package, &session.plan.cases);
            let recorder = Recorder {
                fmu: &fmu,
                name: package.path(),
                home: working_directory::home(
                    scratch.path(),
                    package.description(),
                    cases.iter().map(|case| &case.task),
                ),
                limits,
                echo: false,
            };
            let finer: Vec<Case> = cases.iter().map(|case| finer(case, by, times)).collect();
            Ok(session.outcome(recorder.run(&finer, &job)?))
        };
        let Ok(coarse) = run(Refined::Step, 0)? else {
            continue;
        };
        let mut runs = |by: Refined| {
            let finer = [run(by, 1)?, run(by, 2)?];
            Ok::<_, CommandError>(finer.into_iter().collect::<Result<Vec<_>, _>>().ok())
        };
        let steps = runs(Refined::Step)?;
        // Without a tolerance the FMU chooses its own, which nobody knows.
        let tolerances = match tolerance {
            true => runs(Refined::Tolerance)?,
            false => None,
        };
        let parts = [(Refined::Step, steps), (Refined::Tolerance, tolerances)];
        for (k, known) in found.iter_mut().enumerate() {
            let part = |(by, finer): &(Refined, Option<Vec<Vec<f64>>>)| {
                let finer = finer.as_ref()?;
                Some(refined([coarse[k], finer[0][k], finer[1][k]], *by))
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
    Ok(found)
}

/// The case with a finer setting, so many times.
fn finer(case: &Case, by: Refined, times: i32) -> Case {
    let factor = by.ratio().powi(-times);
    let mut case = case.clone();
    let schedule = &mut case.task.schedule;
    match by {
        Refined::Step => schedule.step *= factor,
        Refined::Tolerance => schedule.tolerance = schedule.tolerance.map(|own| factor * own),
    }
    case
}
