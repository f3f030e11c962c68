//! `replay`: runs one point of a study again, with its trajectory.

use std::{
    fs::File,
    path::{Path, PathBuf},
    process::ExitCode,
};

use super::{
    isolated::{Columns, Isolated},
    output,
};
use crate::{
    cli::Replay,
    error::{Error, Result},
    results::{points::number, table},
    session::Verification,
};
use fmu_points::{
    names::{did_you_mean, nearest},
    task::Case,
};
use point_journal::{
    Finished, PointOutcome,
    files::{draft, keep},
    pipeline::{Model, difference},
};
use study::judge::Judge;

pub fn run(options: &Replay) -> Result<ExitCode> {
    let mut verification = Verification::reopen(&options.folder, options.fmu.clone())?;
    let source = &verification.source;
    let index = source.index_of(options.point).ok_or_else(|| {
        let (point, all) = (options.point, source.len());
        let folder = options.folder.display();
        Error::Refused(format!("{folder}: the study has no point {point}; points.csv lists its {all}"))
    })?;
    let job = verification.job(index);
    let parameters = verification.source.parameters(index);
    let session = &mut verification.session;
    let wanted = wanted(options, &session.plan.cases)?;
    let run = Isolated::elsewhere(&mut session.package)?;
    let outcome = session.outcome(run.run(&session.plan.cases, &job)?);
    let columns = Columns::usual(session.package.description(), false);
    let mut files = String::new();
    for (case, path) in wanted {
        // The run before may have changed the unpacked FMU.
        let again = Isolated::new(&mut session.package)?;
        let case = std::slice::from_ref(&session.plan.cases[case]);
        // One in the folder is replaced when it is complete; where the user wants it may be a pipe.
        let kept = options.output.is_none().then(|| draft(&options.folder)).transpose().map_err(Error::io(&path))?;
        let file = match &kept {
            Some(file) => file.reopen(),
            None => File::create(&path),
        };
        let file = file.map_err(Error::io(&path))?;
        let written = again.trajectory(&case[0].task, &job.values, &columns, file, &path);
        // The trajectory of a point that fails ends where it fails.
        if outcome.is_ok() {
            written?;
        }
        if let Some(file) = kept {
            keep(file, &path)?;
        }
        let of = case[0].name.as_ref().map(|name| format!(" of the case {name}")).unwrap_or_default();
        files += &format!("trajectory{of} in {}\n", path.display());
    }
    let mut text = format!("point {}\n", options.point);
    for (input, value) in session.plan.inputs.iter().zip(parameters) {
        let unit = input.unit.as_deref().unwrap_or("");
        text += format!("  {} = {} {unit}", input.name, number(value)).trim_end();
        text += "\n";
    }
    let values = outcome.as_deref().ok();
    let verdict = session.judge.judged(outcome.as_deref());
    for (k, criterion) in session.judge.criteria.iter().enumerate() {
        let value = outcome.as_ref().map_or_else(|failure| failure.value(k), |values| Some(values[k]));
        let value = value.map_or("no value".to_owned(), number);
        let unit = criterion.unit.as_deref().unwrap_or("");
        let sign = if verdict.passed[k] { "ok" } else { "not met" };
        text += &format!("  {} = {value} {unit}: {sign}\n", criterion.name);
    }
    let accepted = accepted(&options.folder, &session.judge, values);
    match (&outcome, accepted) {
        (Ok(_), None) => {}
        (Ok(_), Some(true)) => text += "  accepted, with the guard band\n",
        (Ok(_), Some(false)) => text += "  not accepted, with the guard band\n",
        (Err(failure), _) => text += &format!("  failed: {failure}\n"),
    }
    if let Some(then) = recorded(&options.folder, index)
        && let Some(difference) = difference(&then, &outcome)
    {
        text += &format!(
            "warning: these are not the results that {} holds: {difference}; the FMU gives other results for the same point\n",
            options.folder.display()
        );
    }
    text += &files;
    output::print(&text);
    Ok(if accepted.unwrap_or_else(|| verdict.verified()) { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// The outcome of a point that a folder's journal holds, where it does: results of a table have none.
fn recorded(folder: &Path, index: u64) -> Option<PointOutcome> {
    Finished::read(folder).ok()?.outcomes().ok()?.get(index).ok()?
}

/// The cases whose trajectories are written, each with its file.
fn wanted(options: &Replay, cases: &[Case]) -> Result<Vec<(usize, PathBuf)>> {
    let point = options.point;
    let wrong = |option, message| Err(Error::option(option, message));
    let names: Vec<&str> = cases.iter().filter_map(|case| case.name.as_deref()).collect();
    let chosen = match &options.case {
        None => None,
        Some(_) if names.is_empty() => {
            return wrong("case", "the study has no cases; leave it out".to_owned());
        }
        Some(name) => match names.iter().position(|known| known == name) {
            Some(case) => Some(case),
            None => {
                let suggestion = did_you_mean(nearest(name, names.iter().copied()));
                return wrong("case", format!("the study has no case `{name}`{suggestion}"));
            }
        },
    };
    if options.output.is_some() && chosen.is_none() && cases.len() > 1 {
        return wrong("output", "one file holds the trajectory of one case; choose it with --case NAME".to_owned());
    }
    let usual = |case: usize| {
        if names.is_empty() { format!("point-{point}.csv") } else { format!("point-{point}-case-{}.csv", case + 1) }
    };
    Ok(chosen
        .map_or(0..cases.len(), |case| case..case + 1)
        .map(|case| {
            let given = options.output.clone();
            (case, given.unwrap_or_else(|| options.folder.join(usual(case))))
        })
        .collect())
}

/// Whether the study's guard band lets a point pass; none where no guard band acts, or the study has not found it yet.
fn accepted(folder: &Path, judge: &Judge, values: Option<&[f64]>) -> Option<bool> {
    if !judge.is_guarded() {
        return None;
    }
    let band = table::summary(folder).ok()?.conclusion?.guard_band;
    Some(values.is_some_and(|values| judge.guard.accepts(judge.measurement.assess(values).all, band)))
}
