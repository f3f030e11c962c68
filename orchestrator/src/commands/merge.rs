//! `merge`: joins shards; the same result as one run.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::thread::available_parallelism;
use std::time::{Duration, Instant};

use super::asking::{self, Analysis};
use super::{CommandError, pareto, robustness, sensitivity, verify};
use crate::cli::Merge;
use crate::pipeline::folder::{Earlier, RunFolder};
use crate::pipeline::{Halt, Part, Pipeline};
use crate::reruns::Wish;
use crate::results::finished::Finished;
use crate::results::lock::Lock;
use crate::results::summary::Run;
use crate::results::{Header, Journal, MOST_EXTRA_RUNS, ResultsError, journal, lines, parquet};
use crate::session::{Asking, Request, Session, SessionError, Verification};
use fmu_points::process::Limits;

/// The analyses by name, with what makes one of its kept options.
const KNOWN: [(&str, Kept); 3] = [
    (sensitivity::NAME, sensitivity::kept),
    (robustness::NAME, robustness::kept),
    (pareto::NAME, pareto::kept),
];

type Kept = fn(serde_json::Value) -> serde_json::Result<Box<dyn Analysis>>;

/// The analysis that a request asks for.
fn analysis_of(asking: &Asking, folder: &Path) -> Result<Box<dyn Analysis>, CommandError> {
    let known = KNOWN.iter().find(|(name, _)| *name == asking.name);
    let kept = known.and_then(|(_, kept)| kept(asking.options.clone()).ok());
    kept.ok_or_else(|| {
        CommandError::Shards(format!(
            "{}: this program knows no analysis `{}` with these options",
            folder.display(),
            asking.name
        ))
    })
}

pub(super) fn run(options: &Merge) -> Result<ExitCode, CommandError> {
    let folders = options.folders.iter().map(|folder| shard_in(folder));
    let folders: Vec<PathBuf> = folders.collect::<Result<_, _>>()?;
    let [first, ..] = &folders[..] else {
        return Err(ResultsError::Missing(options.output.clone()).into());
    };
    let mut request = Request::read(first)?;
    request.shard = None;
    request.fmu = options.fmu.clone().or(request.fmu);
    match request.analysis.clone() {
        Some(asking) => join_analysis(options, &folders, request, &asking),
        None => join_verification(options, &folders, request),
    }
}

/// The folder of the journal in a shard's folder: that of `verify`, or that of the only analysis.
fn shard_in(folder: &Path) -> Result<PathBuf, CommandError> {
    if Request::is_in(folder) {
        return Ok(folder.to_owned());
    }
    let candidates = KNOWN.iter().map(|(name, _)| folder.join(name));
    let found: Vec<PathBuf> = candidates.filter(|inner| Request::is_in(inner)).collect();
    match &found[..] {
        [] => Err(ResultsError::Missing(folder.to_owned()).into()),
        [only] => Ok(only.clone()),
        [one, ..] => Err(CommandError::Shards(format!(
            "{} holds shards of several analyses; name one of them, such as {}",
            folder.display(),
            one.display()
        ))),
    }
}

fn join_verification(
    options: &Merge,
    folders: &[PathBuf],
    request: Request,
) -> Result<ExitCode, CommandError> {
    let start = Instant::now();
    let mut verification = Verification::open(request)?;
    let named = check(folders, verification.header())?;
    let Session { request, study, .. } = &verification.session;
    request.check(&options.output, None, Some(study), earlier(options, false))?;
    let mut looked = verification.looked(&options.output, folders)?;
    let lock = Lock::take(&options.output)?;
    // Continue a merge that was interrupted.
    let complete = options.output.join("summary.json").exists();
    let mut taken = verify::open(
        &verification,
        lock,
        &options.output,
        earlier(options, complete),
    )?;
    fill(&mut taken.journal, folders)?;
    let run = Run::since(start, 0, 0);
    let summary = verification.conclude(&options.output, Some(run), None, &mut looked);
    let summary = summary.map_err(|error| match error {
        SessionError::Results(ResultsError::Incomplete {
            missing, points, ..
        }) => incomplete(missing, points, &named, "verify STUDY", &options.output),
        error => error.into(),
    })?;
    // Shards that grow and are joined again know of it, where they can be written to.
    for folder in folders {
        if looked.write(folder).is_err() {
            fmu_points::tell::line!(
                "note: {} does not take a note of this verdict; join its points in the same --output",
                folder.display()
            );
        }
    }
    if options.parquet {
        parquet::convert(&options.output, &summary)?;
    }
    let jobs = available_parallelism().map_or(1, Into::into);
    let wish = Wish {
        most: MOST_EXTRA_RUNS,
        validation: false,
        limits: Limits {
            time: Duration::from_secs(3600),
            memory: 16 << 30,
        },
        jobs,
    };
    verify::conclude(&mut verification, &options.output, summary, &wish)
}

fn join_analysis(
    options: &Merge,
    folders: &[PathBuf],
    request: Request,
    asking: &Asking,
) -> Result<ExitCode, CommandError> {
    let analysis = analysis_of(asking, &folders[0])?;
    let session = Session::open(request)?;
    analysis.check(&session)?;
    let header = asking::header(&session, &*analysis)?;
    let named = check(folders, &header)?;
    let state = options.output.join(analysis.name());
    // Continue a merge that was interrupted.
    let earlier = earlier(options, false);
    session.request.check(
        &options.output,
        Some(analysis.name()),
        Some(&session.study),
        earlier,
    )?;
    let RunFolder {
        mut journal,
        scratch: _scratch,
        lock: _lock,
        ..
    } = RunFolder::open(Lock::take(&state)?, &state, &header, earlier, false)?;
    session.request.write(&state, &session.study)?;
    fill(&mut journal, folders)?;
    let finished = Finished::read(&state)?;
    let part = Part::of(None, &header);
    let mut pipeline = Pipeline::new(&session, None, journal, Some(finished), part);
    match analysis.find(&session, &mut pipeline, &options.output) {
        Ok(finding) => {
            pipeline.end()?;
            finding.tell(&options.output)
        }
        Err(CommandError::Halted(Halt::Missing { missing, of })) => {
            let command = format!("{} STUDY ...", analysis.name());
            Err(incomplete(missing, of, &named, &command, &options.output))
        }
        Err(error) => Err(error),
    }
}

fn incomplete(
    missing: u64,
    points: u64,
    shards: &[String],
    command: &str,
    output: &Path,
) -> CommandError {
    CommandError::Shards(format!(
        "{missing} of {points} points are in none of the shards {}; merge all of them, or \
         compute what is missing with `{command} --output {} --resume`",
        shards.join(", "),
        output.display()
    ))
}

/// What becomes of what the output folder holds.
fn earlier(options: &Merge, complete: bool) -> Earlier {
    match (options.force, complete) {
        (true, _) => Earlier::Replaced,
        (_, true) => Earlier::Complete,
        _ => Earlier::Resumed,
    }
}

/// Adds all points of these folders to a journal.
fn fill(joined: &mut Journal, folders: &[PathBuf]) -> Result<(), ResultsError> {
    for folder in folders {
        journal::copy(folder, joined)?;
    }
    joined.sync()
}

/// Refuses folders that are not of one study, before anything is written; names their shards.
fn check(folders: &[PathBuf], of: &Header) -> Result<Vec<String>, CommandError> {
    let name = |folder: &PathBuf| {
        let then = lines::header(folder)?;
        // Only the part differs from one to the other.
        let same_part = Header {
            shard: then.shard.clone(),
            ..of.clone()
        };
        match same_part.difference(&then) {
            None => Ok(then.shard.unwrap_or_else(|| "1/1".to_owned())),
            Some((what, then, own)) => Err(CommandError::Shards(format!(
                "{} has another {what} ({then}) than {} ({own}); leave it out",
                folder.display(),
                folders[0].display(),
            ))),
        }
    };
    folders.iter().map(name).collect()
}
