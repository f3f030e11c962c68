//! `replay`: runs one point of a study again, with its trajectory.

use std::fs::File;
use std::path::Path;
use std::process::ExitCode;

use super::simulate::{Columns, Isolated};
use super::{CommandError, output};
use crate::analysis::from_results;
use crate::cli::Replay;
use crate::judge::Judge;
use crate::pipeline::Model;
use crate::results::ResultsError;
use crate::results::points::number;
use crate::session::Verification;

pub(super) fn run(options: &Replay) -> Result<ExitCode, CommandError> {
    let mut verification = Verification::reopen(&options.folder, options.fmu.clone())?;
    let index =
        verification
            .source
            .index_of(options.point)
            .ok_or_else(|| CommandError::Option {
                option: "point",
                message: format!(
                    "the study has no point {}; points.csv lists its {}",
                    options.point,
                    verification.source.len()
                ),
            })?;
    let job = verification.job(index);
    let parameters = verification.source.parameters(index);
    let session = &mut verification.session;
    let run = Isolated::new(&mut session.package)?;
    let run = run.in_a_study(&session.package, &session.plan.task);
    let outcome = session.outcome(run.run(&session.plan.task, &job)?);
    // The first run may have changed the unpacked FMU.
    let again = Isolated::new(&mut session.package)?;
    let again = again.in_a_study(&session.package, &session.plan.task);
    let columns = Columns::usual(session.package.description(), false);
    let usual = options.folder.join(format!("point-{}.csv", options.point));
    let path = options.output.clone().unwrap_or(usual);
    let file = File::create(&path).map_err(ResultsError::io(&path))?;
    let written = again.trajectory(&session.plan.task, &job.values, &columns, file);
    // The trajectory of a point that fails ends where it fails.
    if outcome.is_ok() {
        written.map_err(|error| error.into_command(&path))?;
    }
    let mut text = format!("point {}\n", options.point);
    for (input, value) in session.plan.inputs.iter().zip(parameters) {
        let unit = input.unit.as_deref().unwrap_or("");
        text += format!("  {} = {} {unit}", input.name, number(value)).trim_end();
        text += "\n";
    }
    let values = outcome.as_deref().ok();
    let verdict = session.judge.verdict(values);
    for (number_of, criterion) in session.judge.criteria.iter().enumerate() {
        let value = values.map_or("no value".to_owned(), |values| number(values[number_of]));
        let unit = criterion.unit.as_deref().unwrap_or("");
        let sign = if verdict.passed[number_of] {
            "ok"
        } else {
            "not met"
        };
        text += &format!("  {} = {value} {unit}: {sign}\n", criterion.name);
    }
    let accepted = accepted(&options.folder, &session.judge, values);
    match (&outcome, accepted) {
        (Ok(_), None) => {}
        (Ok(_), Some(true)) => text += "  accepted, with the guard band\n",
        (Ok(_), Some(false)) => text += "  not accepted, with the guard band\n",
        (Err(failure), _) => text += &format!("  failed: {failure}\n"),
    }
    text += &format!("trajectory in {}\n", path.display());
    output::print(&text);
    Ok(if accepted.unwrap_or_else(|| verdict.verified()) {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}

/// Whether the study's guard band lets a point pass; none where no guard band acts, or the study has not found it yet.
fn accepted(folder: &Path, judge: &Judge, values: Option<&[f64]>) -> Option<bool> {
    if !judge.is_guarded() {
        return None;
    }
    let found = from_results::summary(folder).ok()?.conclusion?.guard_band;
    let margin = values.map_or(f64::NEG_INFINITY, |values| judge.measurement.margin(values));
    Some(judge.guard.accepts(margin, found))
}
