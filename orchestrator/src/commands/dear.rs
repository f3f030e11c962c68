//! `verify --budget N`: few runs of an FMU whose runs are dear.

use std::{fs, path::Path, process::ExitCode, time::Instant};

use super::{cost, gate, output, verify};
use crate::{
    cli::Verify,
    error::{Error, Result},
    methods::{
        asking::{self, Delivery},
        sensitivity,
        setup::{self, ResultFolder, Runnable as _, Work},
    },
    reruns::Wish,
    results::{self, Summary, summary::Run},
    session::{
        Request, Until, Verification,
        account::Account,
        budget::{self, Budget},
    },
    source::PointSource,
};
use sampling::design::Design;

/// Runs the command.
pub fn run(options: &Verify, runs: u64) -> Result<ExitCode> {
    let folder = options.work.folder();
    let verification = open(options, runs, &folder)?;
    if options.dry_run {
        return tried(options, verification, &folder);
    }
    let summary = answered(options, verification, &folder)?;
    gate::verdict(&summary, Some(&folder), (&options.gate, options.verbose))
}

/// Runs `sensitivity --budget N`: the points are those of `verify --budget N`, and what is there of them is not run again.
pub fn sensitivity(mut options: sensitivity::Options, runs: u64) -> Result<Delivery> {
    let folder = options.work.folder();
    let mut verify = Verify::of(&options.work.study);
    let then = Request::read(&folder).ok().and_then(|request| request.account);
    verify.work = options.work;
    verify.work.resuming.resume |= !verify.work.resuming.force && then.is_some();
    verify.seed = options.seed;
    // An earlier run may have had a larger budget; it is kept, else its surplus points would be lost.
    let runs = then.map_or(runs, |then| then.runs.max(runs));
    let verification = open(&verify, runs, &folder)?;
    answered(&verify, verification, &folder)?;
    options.work = verify.work;
    options.from = Some(folder);
    sensitivity::run(&options)
}

/// Says what a budget costs and what it can be expected to answer.
fn tried(options: &Verify, mut verification: Verification, folder: &Path) -> Result<ExitCode> {
    let spent = verification.session.request.budget.clone().unwrap_or_default();
    // Which later points are run depends on the earlier answers. All take equally long, so the first points of the net stand
    // for them.
    let places = (0..spent.points() as u64).collect();
    verification.source = PointSource::Chosen { design: net(&verification), places };
    output::print(&verify::plan(&verification, folder));
    output::print(&budget::expected(&verification.session.plan, &spent));
    let jobs = options.work.means.jobs_of(spent.points())?;
    output::print(&cost::of(&mut verification, &options.work.means, jobs)?);
    Ok(ExitCode::SUCCESS)
}

fn net(verification: &Verification) -> Design {
    match &verification.source {
        PointSource::Chosen { design, .. } => design.clone(),
        _ => unreachable!("a request with a budget has chosen points"),
    }
}

/// Runs the points, and completes the folder.
fn answered(options: &Verify, mut verification: Verification, folder: &Path) -> Result<Summary> {
    let begun = Instant::now();
    let means = &options.work.means;
    let net = net(&verification);
    let session = &verification.session;
    asking::warn(&session.judge);
    if !session.judge.guard.leaves_something(&session.judge.measurement) {
        return Err(session
            .study
            .error_near(
                "verdict",
                "the guard band is as wide as a tolerance, so that no point can be accepted; change [verdict]",
            )
            .into());
    }
    budget::guard(&session.judge).map_err(|message| session.study.error_near("verdict", message))?;
    if let (Some(Until::Verdict), None) = (options.until, session.judge.rule) {
        return Err(Error::option("until", "there is no verdict to wait for: add [verdict] with the required share"));
    }
    let spent = session.request.budget.clone().unwrap_or_default();
    let jobs = means.jobs_of(spent.points())?;
    let mut looked = verification.looked(folder, &[])?;
    let place = ResultFolder { output: folder, analysis: None, earlier: options.work.resuming.earlier() };
    let (header, summary) = (verification.header.clone(), folder.join("summary.json"));
    let taken = place.take(verification.parts(), &header, || {
        // What was complete is so no more.
        if options.work.resuming.resume && spent.places.is_empty() && summary.exists() {
            fs::remove_file(&summary).map_err(Error::io(&summary))
        } else {
            Ok(())
        }
    })?;
    let work = Work { means, jobs, ends: false };
    let history = looked.history.clone();
    let until = options.until.map(|until| (until, &history));
    let ((told, computed, hosts), _kept) = setup::run(&mut verification, &header, taken, work, |of, pipeline| {
        let told = budget::run(&of.session, &net, pipeline, until)?;
        Ok((told, pipeline.computed(), pipeline.answered()))
    })?;
    if summary.exists() && computed == 0 {
        return results::table::summary(folder);
    }
    verification.source = PointSource::Chosen { design: net, places: told.places.clone() };
    let run = Run { hosts, ..Run::since(begun, computed, jobs) };
    let mut summary = verification.conclude(folder, Some(run), None, &mut looked, Some(&told))?;
    let here = means.jobs_here().min(jobs);
    let wish = Wish { most: 0, validation: false, dear: true, limits: means.limits(here)?, jobs: here };
    verify::finish(&mut verification, folder, &mut summary, &wish);
    // Last, as what is written here is complete.
    let request = &mut verification.session.request;
    if let (Some(budget), Some(account)) = (&mut request.budget, &mut request.account) {
        budget.places = told.places;
        *account = account.after(summary.surrogate.as_ref().map_or(account.left(), |surrogate| surrogate.runs));
    }
    let session = &verification.session;
    session.request.write(folder, &session.study)?;
    Ok(summary)
}

/// The study with its budget, which goes on from what the folder holds where that is resumed.
fn open(options: &Verify, runs: u64, folder: &Path) -> Result<Verification> {
    let resumed = options.work.resuming.resume && Request::is_in(folder);
    let then = if resumed { Request::read(folder)?.budget } else { None };
    let mut request = verify::request(options)?;
    request.budget = Some(Budget::default());
    let mut verification = Verification::open(request)?;
    let jobs = options.work.means.jobs_of(usize::MAX)?;
    let cases = verification.session.plan.cases.len().max(1);
    let account = Account::open(folder, ("", resumed), runs, [1, 0])?;
    let budget = Budget::new(&account, jobs, cases, then)?;
    let request = &mut verification.session.request;
    (request.budget, request.account) = (Some(budget), Some(account));
    Ok(verification)
}
