//! `merge`: joins shards; the same result as one run.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::thread::available_parallelism;
use std::time::{Duration, Instant};

use super::{deliver, verify};
use crate::cli::Merge;
use crate::error::Error;
use crate::methods;
use crate::methods::join::Shards;
use crate::methods::setup::{Place, Source};
use crate::reruns::Wish;
use crate::results::summary::Run;
use crate::results::MOST_EXTRA_RUNS;
use crate::session::{Request, Verification};
use fmu_points::Limits;

pub(super) fn run(options: &Merge) -> Result<ExitCode, Error> {
    let folders = options.folders.iter().map(|folder| shard_in(folder));
    let folders: Vec<PathBuf> = folders.collect::<Result<_, _>>()?;
    let shards = Shards { folders: &folders, output: &options.output, force: options.force };
    let [first, ..] = &folders[..] else {
        return Err(Error::Missing(options.output.clone()));
    };
    let mut request = Request::read(first)?;
    request.shard = None;
    request.fmu = options.fmu.clone().or(request.fmu);
    match request.analysis {
        Some(_) => deliver(methods::join(&shards, request)?),
        None => join_verification(options, &shards, request),
    }
}

/// The folder of the journal in a shard's folder: that of `verify`, or that of the only analysis.
fn shard_in(folder: &Path) -> Result<PathBuf, Error> {
    if Request::is_in(folder) {
        return Ok(folder.to_owned());
    }
    let candidates = methods::NAMES.iter().map(|name| folder.join(name));
    let shards: Vec<PathBuf> = candidates.filter(|inner| Request::is_in(inner)).collect();
    match &shards[..] {
        [] => Err(Error::Missing(folder.to_owned())),
        [only] => Ok(only.clone()),
        [one, ..] => Err(Error::Refused(format!(
            "{} holds shards of several analyses; name one of them, such as {}",
            folder.display(),
            one.display()
        ))),
    }
}

fn join_verification(options: &Merge, shards: &Shards<'_>, request: Request) -> Result<ExitCode, Error> {
    let start = Instant::now();
    let output = &options.output;
    let mut verification = Verification::open(request)?;
    let named = shards.check(&verification.header)?;
    let mut looked = verification.looked(output, shards.folders)?;
    let place = Place { output, analysis: None, earlier: shards.earlier(output.join("summary.json").exists()) };
    let mut taken = place.take(verification.parts(), &verification.header, || Ok(()))?;
    shards.fill(&mut taken.journal)?;
    let run = Run::since(start, 0, 0);
    let summary = verification.conclude(output, Some(run), None, &mut looked, None);
    let summary = summary.map_err(|error| match error {
        Error::Incomplete { missing, points, .. } => shards.incomplete([missing, points], &named, "verify STUDY"),
        error => error,
    })?;
    // Shards that grow and are joined again know of it, where they can be written to.
    for folder in shards.folders {
        if looked.write(folder).is_err() {
            fmu_points::tell::line!(
                "note: {} does not take a note of this verdict; join its points in the same --output",
                folder.display()
            );
        }
    }
    let jobs = available_parallelism().map_or(1, Into::into);
    let wish = Wish {
        most: MOST_EXTRA_RUNS,
        dear: false,
        validation: false,
        limits: Limits { time: Duration::from_secs(3600), memory: 16 << 30 },
        jobs,
    };
    verify::conclude(&mut verification, output, summary, &wish, (&options.gate, options.verbose))
}
