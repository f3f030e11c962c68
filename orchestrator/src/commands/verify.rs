//! `verify`: simulates a study's points and judges them.

use std::{collections::BTreeMap, fs, ops::ControlFlow, path::Path, process::ExitCode, time::Instant};

use indexmap::{IndexMap, IndexSet};

use super::{best, complete, cost, gate, left_out, output};
use crate::{
    cli::Verify,
    error::{Error, Result},
    methods::{
        asking, identify,
        setup::{self, ResultFolder, Runnable, Work},
    },
    options::folder_of,
    reruns::{self, Wish},
    results::{Summary, summary::Run},
    session::{Ending, Front, Request, Session, Verification},
};
use conformity::decision::Decision;
use fmu_points::names::behind;
use point_journal::{
    Journal,
    files::write_json,
    lines,
    pipeline::{Pipeline, folder::Earlier},
};
use sampling::design::Method;
use study::plan::bare;

/// With `--until`, a study has as many points as needed, but for a limit.
const MOST_POINTS: u64 = 1_000_000;

/// Refuses to write a verdict where there is none.
fn refuse_no_verdict(options: &Verify) -> Result {
    let message = match options.shards.chosen()? {
        _ if options.gate.junit.is_none() => return Ok(()),
        Some(_) => "a part of the points has no verdict; give this option to `merge`",
        None if options.dry_run => "--dry-run has no verdict; remove one of the two",
        None => return Ok(()),
    };
    Err(Error::option("junit", message))
}

pub fn run(options: &Verify) -> Result<ExitCode> {
    let begun = Instant::now();
    refuse_no_verdict(options)?;
    let mut verification = Verification::open(request(options)?)?;
    asking::warn(&verification.session.judge);
    let means = &options.work.means;
    let folder = match (&options.work.output, verification.session.request.shard) {
        (None, Some(shard)) => folder_of(&options.work.study).join(format!("shard-{}-of-{}", shard.number, shard.of)),
        _ => options.work.folder(),
    };
    let mut looked = verification.looked(&folder, &[])?;
    let ending = options.until.map(|until| verification.ending(until, &looked.history)).transpose();
    let ending = ending.map_err(|message| Error::option("until", message))?;
    // More workers than points would only take memory from each other.
    let points = usize::try_from(verification.expected()).unwrap_or(usize::MAX);
    let jobs = means.jobs_of(points)?;
    if options.dry_run {
        output::print(&plan(&verification, &folder));
        output::print(&cost::of(&mut verification, means, jobs)?);
        return Ok(ExitCode::SUCCESS);
    }
    let place = ResultFolder { output: &folder, analysis: None, earlier: options.work.resuming.earlier() };
    let header = verification.header.clone();
    let taken = place.take(verification.parts(), &header, || {
        if place.earlier == Earlier::Resumed { extend(&verification, &folder) } else { Ok(()) }
    })?;
    let work = Work {
        means,
        jobs,
        // A study that ends when enough is known has as many points as that takes.
        ends: false,
    };
    let mut hosts = BTreeMap::new();
    let ((done, computed, halt), _kept) = setup::run(&mut verification, &header, taken, work, |of, pipeline| {
        let enough = compute(of, pipeline, ending.as_ref(), jobs)?;
        let (done, computed) = (pipeline.done(), pipeline.computed());
        let halt = pipeline.interrupted();
        hosts = pipeline.answered();
        Ok((done, computed, (done < of.expected() && !enough).then_some(halt)))
    })?;
    if let Some(halt) = halt {
        return Err(halt.into());
    }
    if verification.session.request.shard.is_some() {
        output::print(&format!("{done} points in {}; `orchestrator merge` joins the shards\n", folder.display()));
        return Ok(ExitCode::SUCCESS);
    }
    let run = Run { hosts, ..Run::since(begun, computed, jobs) };
    let mut summary = verification.conclude(&folder, Some(run), ending.as_ref(), &mut looked, None)?;
    let jobs = means.jobs_here().min(jobs);
    let limits = means.limits(jobs)?;
    let wish = Wish { most: options.extra_runs, validation: options.validation, dear: false, limits, jobs };
    run_again(&mut verification, &folder, &mut summary, &wish);
    if options.extra_runs > 0 {
        explain(options, &folder, &mut summary);
    }
    complete(&folder);
    gate::verdict(&summary, Some(&folder), (&options.gate, options.verbose))
}

/// Looks for what would explain that the model is not verified, where that does not take long.
fn explain(options: &Verify, folder: &Path, summary: &mut Summary) {
    /// A search takes about so many runs of each case.
    const RUNS: f64 = 1000.0;
    /// What nobody asked for takes no longer than the points did; but it may take so long, s.
    const LEAST: f64 = 30.0;
    let Some(run) = summary.run.as_ref().filter(|run| run.computed > 0) else { return };
    let took = RUNS * run.wall_seconds / run.computed as f64;
    let is_asked = summary.decision() == Decision::NotVerified && summary.is_compared();
    if !is_asked || took > run.wall_seconds.max(LEAST) {
        return;
    }
    // A search that was cut short goes on with the study.
    let earlier = match options.work.resuming.earlier() {
        Earlier::Resumed => Earlier::Resumed,
        _ => Earlier::Replaced,
    };
    let told = identify::causes(&options.work.study, &options.work.means, earlier, folder);
    match told {
        Ok(causes) => summary.causes = causes,
        Err(error) => left_out("what would explain the verdict was not sought", &error),
    }
    write_json(&folder.join("summary.json"), summary)
        .unwrap_or_else(|error| left_out("the causes are in no summary", &error));
}

/// Lets a run with fewer points go on with more, where these are the first ones of the longer run.
fn extend(verification: &Verification, folder: &Path) -> Result {
    let header = &verification.header;
    let then = match lines::header(folder) {
        Ok(then) if header.extends(&then) => then,
        // A folder without a journal, or with that of another study, is dealt with where the run takes it.
        _ => return Ok(()),
    };
    if verification.is_extensible() {
        // The shorter run is complete no more.
        let summary = folder.join("summary.json");
        if summary.exists() {
            fs::remove_file(&summary).map_err(Error::io(&summary))?;
        }
        return Ok(Journal::rewrite(folder, header)?);
    }
    let method = verification.session.study.design.method.name();
    let with = Method::named(Method::is_extensible);
    let points = then.points.unwrap_or(0);
    Err(Error::option(
        "points",
        format!(
            "the points of a {method} depend on how many they are, so the {points} that are done are none of a longer one; \
         choose another --output, or method = {with}"
        ),
    ))
}

/// Completes the folder of a study whose verdict is known and written.
pub fn finish(verification: &mut Verification, folder: &Path, summary: &mut Summary, wish: &Wish) {
    run_again(verification, folder, summary, wish);
    complete(folder);
}

/// Runs some points once more, and writes the files of the best one.
fn run_again(verification: &mut Verification, folder: &Path, summary: &mut Summary, wish: &Wish) {
    reruns::run(verification, folder, summary, wish)
        .unwrap_or_else(|error| left_out("no point was run once more", &error));
    let Session { plan, package, .. } = &verification.session;
    best::write(folder, plan, package.description(), summary)
        .unwrap_or_else(|error| left_out("the best point is in no file", &error));
}

/// A number of things.
fn counted(number: u64, thing: &str) -> String {
    format!("{number} {thing}{}", if number == 1 { "" } else { "s" })
}

/// The plan of the run, for `--dry-run`.
pub fn plan(verification: &Verification, folder: &Path) -> String {
    let session = &verification.session;
    let cases: Vec<String> = session
        .plan
        .cases
        .iter()
        .map(|case| {
            let schedule = &case.task.schedule;
            let name = case.name.as_ref();
            format!(
                "{}{} ({} to {} s)",
                name.map_or_else(String::new, |name| format!("{name}: ")),
                counted(schedule.steps(), "step"),
                schedule.start,
                schedule.stop,
            )
        })
        .collect();
    let mut text =
        format!("{} of {} into {}\n", counted(verification.expected(), "point"), cases.join(", "), folder.display());
    for input in &session.plan.inputs {
        let unit = input.unit.as_deref().unwrap_or("");
        let [low, high] = [0.025, 0.975].map(|u| input.distribution.quantile(u));
        text += &format!("  {} {low:.5} .. {high:.5} {unit} (95 %)\n", input.name);
    }
    text += &set(session);
    text += "accepted when\n";
    for criterion in &session.judge.criteria {
        let unit = criterion.unit.as_deref().unwrap_or("");
        let [low, high] = criterion.limits.ends();
        text += &match criterion.metric {
            None if criterion.limits.is_one_sided() => {
                format!("  {} is {}\n", criterion.name, criterion.stated_tolerance)
            }
            Some(_) => format!("  {}: {}\n", criterion.name, criterion.stated_tolerance),
            None => format!("  {} is {low:.5} .. {high:.5} {unit}\n", criterion.name),
        };
    }
    text
}

/// Recorded inputs in the FMU's units, and fixed numbers that people may have meant in another one.
fn set(session: &Session) -> String {
    let fmu = session.package.description();
    let mut recorded: IndexMap<&str, [f64; 2]> = IndexMap::new();
    let cases = session.plan.cases.iter();
    for series in cases.flat_map(|case| &case.task.inputs) {
        let [low, high] = recorded.entry(&series.slot.name).or_insert([f64::INFINITY, f64::NEG_INFINITY]);
        for value in &series.values {
            (*low, *high) = (low.min(*value), high.max(*value));
        }
    }
    let recorded = recorded.iter().map(|(name, [low, high])| {
        let unit = behind(fmu.variables[*name].unit());
        format!("  {name} {low:.5} .. {high:.5}{unit} (recorded)\n")
    });
    let fixed = session.study.by_case().into_iter().flat_map(|(_, study)| {
        study
            .fixed
            .iter()
            .filter_map(|(name, setting)| {
                let variable = fmu.variables.get(name.as_ref())?;
                bare(fmu, variable, setting.as_ref()).map(|read| format!("  {read}\n"))
            })
            .collect::<Vec<_>>()
    });
    let lines: IndexSet<String> = recorded.chain(fixed).collect();
    lines.into_iter().collect()
}

pub fn request(options: &Verify) -> Result<Request> {
    Ok(Request {
        points: options.points,
        most: options.until.map(|_| MOST_POINTS),
        seed: options.seed,
        points_from: options.points_from.clone(),
        shard: options.shards.chosen()?,
        ..asking::request(&options.work.study, &options.work.means)
    })
}

/// Runs all points that are not finished; says whether no further ones are needed.
fn compute(verification: &Verification, pipeline: &mut Pipeline, ending: Option<&Ending>, jobs: usize) -> Result<bool> {
    let judge = &verification.session.judge;
    let job = |index| verification.job(index);
    let finished = pipeline.finished();
    let mut front = ending.map(|ending| (ending, Front::new(ending)));
    let mut enough = false;
    if let (Some((ending, front)), Some(finished)) = (&mut front, &finished) {
        let mut outcomes = finished.outcomes()?;
        // A run that was killed had several points under way, and left gaps.
        for index in 0..verification.source.len() {
            if let Some(outcome) = outcomes.get(index)? {
                enough = front.add(index, ending.counts(judge, &outcome));
            }
            if enough {
                return Ok(true);
            }
        }
    }
    // The workers share out what is left, so they have to know how much that is.
    let left = usize::try_from(verification.expected().saturating_sub(pipeline.done())).unwrap_or(usize::MAX);
    let open = verification.indexes().filter(|index| !finished.as_ref().is_some_and(|f| f.has(*index))).take(left);
    let (begun, mut done) = (Instant::now(), 0);
    pipeline.compute(open, &job, |index, outcome| {
        done += 1;
        if done == 2 * jobs {
            cost::remark(begun.elapsed() / 2, left, jobs);
        }
        if let Some((ending, front)) = &mut front {
            enough = enough || front.add(index, ending.counts(judge, &outcome));
        }
        if enough { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    })?;
    Ok(enough)
}
