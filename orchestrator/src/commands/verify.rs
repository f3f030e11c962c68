//! `verify`: simulates a study's points and judges them.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant};

use super::limits::place;
use super::progress::Progress;
use super::{CommandError, best, cost, finding, output, report, stop, table, verdict};
use crate::cli::Verify;
use crate::design::Method;
use crate::engine;
use crate::results::finished::Finished;
use crate::results::note::Note;
use crate::results::summary::Run;
use crate::results::{Journal, Tally, parquet};
use crate::session::{Front, Request, Session, scratch};

/// With `--until`, a study has as many points as needed, but for a limit.
const MOST_POINTS: u64 = 1_000_000;

pub(super) fn run(options: &Verify) -> Result<ExitCode, CommandError> {
    let begun = Instant::now();
    let mut session = Session::open(request(options))?;
    if options.until.is_some() && !session.is_extensible() {
        return Err(CommandError::Option {
            option: "until",
            message:
                "a Latin hypercube or a full factorial needs all its points; use sobol, halton or \
                monte-carlo"
                    .to_owned(),
        });
    }
    if options.points.is_some() && session.study.design.method == Method::FullFactorial {
        return Err(CommandError::Option {
            option: "points",
            message: "a full factorial has as many points as the levels make; change `levels`"
                .to_owned(),
        });
    }
    let folder = output_folder(options);
    // More workers than points would only take memory from each other.
    let points = usize::try_from(session.expected()).unwrap_or(usize::MAX);
    let jobs = options.means.jobs().min(points.max(1));
    if options.dry_run {
        output::print(&plan(&session, &folder));
        output::print(&cost::of(&mut session, &options.means, jobs)?);
        return Ok(ExitCode::SUCCESS);
    }
    let (mut journal, finished) = session.journal(&folder, options.resume)?;
    // The unpacked FMU is kept in it until the report is written.
    let scratch = scratch(&folder)?;
    let computed = compute(
        &mut session,
        options,
        scratch.path(),
        &mut journal,
        finished.as_ref(),
        jobs,
    )?;
    journal.sync()?;
    let done = finished.as_ref().map_or(0, |finished| finished.count) + computed.points;
    if done < session.expected() && !computed.enough {
        let all = session.expected();
        eprintln!("interrupted: {done} of {all} points are done; --resume goes on");
        return Ok(ExitCode::from(stop::INTERRUPTED));
    }
    if session.request.shard.is_some() {
        output::print(&format!(
            "{done} points in {}; `orchestrator merge` joins the shards\n",
            folder.display()
        ));
        return Ok(ExitCode::SUCCESS);
    }
    let run = Run {
        wall_seconds: begun.elapsed().as_secs_f64(),
        computed: computed.points,
        jobs,
    };
    let enough = |tally: &Tally<'_>| options.until.is_some_and(|until| until.is_met(tally));
    let summary = session.conclude(&folder, Some(run), enough)?;
    if options.parquet {
        parquet::convert(&folder, &summary)?;
    }
    conclude(&mut session, &folder, &summary, options.means.in_process)
}

/// Completes the folder and says what came out. `trusted`: the points ran in this process.
pub(super) fn conclude(
    session: &mut Session,
    folder: &Path,
    summary: &crate::results::Summary,
    trusted: bool,
) -> Result<ExitCode, CommandError> {
    let Session {
        study,
        plan,
        package,
        ..
    } = session;
    best::write(folder, plan, package.description(), summary)?;
    report::complete(folder, study, plan, package, summary, trusted)?;
    output::print(&format!(
        "{}{}{}\nresults in {}\n",
        table::remarks(summary),
        table::counts(summary),
        table::best(summary),
        folder.display()
    ));
    Ok(verdict(summary.verified))
}

/// A number of things.
fn counted(number: u64, thing: &str) -> String {
    format!("{number} {thing}{}", if number == 1 { "" } else { "s" })
}

/// What would be done.
fn plan(session: &Session, folder: &Path) -> String {
    let schedule = &session.plan.task.schedule;
    let steps = schedule.steps();
    let mut text = format!(
        "{} of {} ({} to {} s) into {}\n",
        counted(session.expected(), "point"),
        counted(steps, "step"),
        schedule.start,
        schedule.stop,
        folder.display()
    );
    for input in &session.plan.inputs {
        let unit = input.unit.as_deref().unwrap_or("");
        let [low, high] = [0.025, 0.975].map(|u| input.distribution.quantile(u));
        text += &format!("  {} {low:.5} .. {high:.5} {unit} (95 %)\n", input.name);
    }
    text += "accepted when\n";
    for criterion in &session.judge.criteria {
        let unit = criterion.unit.as_deref().unwrap_or("");
        let low = criterion.nominal - criterion.tolerance;
        let high = criterion.nominal + criterion.tolerance;
        text += &format!("  {} is {low:.5} .. {high:.5} {unit}\n", criterion.name);
    }
    text
}

fn request(options: &Verify) -> Request {
    let until = options.until.filter(|_| options.points_from.is_none());
    Request {
        study: options.study.clone(),
        fmu: options.means.fmu.clone(),
        points: options.points.or(until.map(|_| MOST_POINTS)),
        seed: options.seed,
        points_from: options.points_from.clone(),
        shard: options.shard,
        base: None,
        original: None,
    }
}

/// `results/` and the study's name, unless the user says otherwise.
fn output_folder(options: &Verify) -> PathBuf {
    let usual = || {
        let folder = finding::folder_of(&options.study);
        match options.shard {
            Some(shard) => folder.join(format!("shard-{}-of-{}", shard.number, shard.of)),
            None => folder,
        }
    };
    options.output.clone().unwrap_or_else(usual)
}

/// What came of a run of points.
struct Computed {
    /// How many points were run.
    points: u64,
    /// Whether no further ones are needed.
    enough: bool,
}

/// Runs all points that are not finished.
fn compute(
    session: &mut Session,
    options: &Verify,
    scratch: &Path,
    journal: &mut Journal,
    finished: Option<&Finished>,
    jobs: usize,
) -> Result<Computed, CommandError> {
    let place = place(&options.means, jobs)?;
    let crew = session.crew(place, scratch, jobs)?;
    let mut workers = crew.workers(&session.plan.task);
    let session = &*session;
    let mut front = Front::default();
    let mut enough = false;
    if let (Some(until), Some(finished)) = (options.until, finished) {
        let mut outcomes = finished.outcomes()?;
        for index in (0..session.source.len()).take_while(|&index| finished.has(index)) {
            let outcome = outcomes.get(index)?;
            let values = outcome.as_ref().and_then(|outcome| outcome.as_deref().ok());
            enough |= front.add(index, session.judge.verdict(values).verified(), until);
        }
    }
    let open = session
        .indexes()
        .filter(|&index| !finished.is_some_and(|f| f.has(index)));
    let open = open.take(if enough { 0 } else { usize::MAX });
    let before = finished.map_or(0, |finished| finished.count);
    let progress = Progress::new(session.expected(), before);
    let mut tally = Tally::new(&session.judge);
    let mut synced = Instant::now();
    let job = |index| session.job(index);
    let earlier = |separation| finished.map_or_else(Vec::new, |finished| finished.of(separation));
    let mut noted = None;
    let result = engine::run(&mut workers, open, &job, &earlier, stop::flag(), |event| {
        let (index, answer, separation) = match event {
            engine::Event::Answer(index, answer, separation) => (index, answer, separation),
            engine::Event::Void(separation) => {
                journal.note(&Note::Void(separation))?;
                return Ok(ControlFlow::Continue(()));
            }
            // Nothing else to do: what is finished is made durable.
            engine::Event::Idle => {
                const OFTEN: Duration = Duration::from_secs(5);
                if synced.elapsed() > OFTEN {
                    let conduct = crew.conduct();
                    journal.note(&Note::Conduct(conduct.since(noted.replace(conduct))))?;
                    journal.sync()?;
                    synced = Instant::now();
                } else {
                    journal.flush()?;
                }
                return Ok(ControlFlow::Continue(()));
            }
        };
        let outcome = session.outcome(answer);
        journal.append(index, &outcome, separation)?;
        let verified = tally.add(index, &[], &outcome).verified();
        progress.step(tally.verified(), tally.failed(), tally.points());
        enough |= options
            .until
            .is_some_and(|until| front.add(index, verified, until));
        Ok::<_, CommandError>(if enough {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        })
    });
    progress.finish();
    result?;
    if tally.points() > 0 {
        journal.note(&Note::Conduct(crew.conduct().since(noted)))?;
    }
    Ok(Computed {
        points: tally.points(),
        enough,
    })
}
