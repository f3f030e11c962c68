//! `merge`: joins shards; the same result as one run.

use std::{
    path::PathBuf,
    process::ExitCode,
    thread::available_parallelism,
    time::{Duration, Instant},
};

use super::{gate, verify};
use crate::{
    cli::Merge,
    error::{Error, Result},
    methods::setup::{ResultFolder, Runnable},
    reruns::Wish,
    results::summary::Run,
    session::{Request, Verification},
};
use fmu_points::PointLimits;
use point_journal::{Header, journal, lines, pipeline::folder::Earlier};

pub fn run(options: &Merge) -> Result<ExitCode> {
    let start = Instant::now();
    let Merge { folders, output, .. } = options;
    // The command line has one at least.
    let mut request = Request::read(&folders[0])?;
    request.shard = None;
    request.fmu = options.fmu.clone().or(request.fmu);
    let mut verification = Verification::open(request)?;
    let named = shards(folders, &verification.header)?;
    let mut looked = verification.looked(output, folders)?;
    // A merge that was interrupted goes on, one that is complete is done again.
    let earlier = match (options.force, output.join("summary.json").exists()) {
        (true, _) => Earlier::Replaced,
        (_, true) => Earlier::Complete,
        _ => Earlier::Resumed,
    };
    let place = ResultFolder { output, analysis: None, earlier };
    let mut taken = place.take(verification.parts(), &verification.header, || Ok(()))?;
    for folder in folders {
        journal::copy(folder, &mut taken.journal)?;
    }
    taken.journal.sync()?;
    let run = Run::since(start, 0, 0);
    let mut summary = verification.conclude(output, Some(run), None, &mut looked, None).map_err(|error| match error {
        Error::Incomplete { missing, points, .. } => Error::Refused(format!(
            "{missing} of {points} points are in none of the shards {}; merge all of them, or compute what is missing with \
             `orchestrator verify {} --output {} --resume`",
            named.join(", "),
            verification.session.request.own_study().display(),
            output.display()
        )),
        error => error,
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
    let jobs = available_parallelism().map_or(1, Into::into);
    let wish = Wish {
        most: options.extra_runs,
        dear: false,
        validation: false,
        limits: PointLimits { time: Duration::from_secs(3600), memory: 16 << 30 },
        jobs,
    };
    verify::finish(&mut verification, output, &mut summary, &wish);
    gate::verdict(&summary, Some(output), (&options.gate, options.verbose))
}

/// Refuses folders that are not of one study, before anything is written; names their shards.
fn shards(folders: &[PathBuf], of: &Header) -> Result<Vec<String>> {
    let name = |folder: &PathBuf| {
        let then = lines::header(folder)?;
        // Only the part differs from one to the other.
        let same_part = Header { shard: then.shard.clone(), ..of.clone() };
        match same_part.difference(&then) {
            None => Ok(then.shard.unwrap_or_else(|| "1/1".to_owned())),
            // The first one gave the study file; its points are older than what stands there now.
            Some((what, then, now)) if *folder == folders[0] => Err(Error::Refused(format!(
                "{} has points of another {what} ({then}) than there is now ({now}); run it again",
                folder.display(),
            ))),
            Some((what, then, now)) => Err(Error::Refused(format!(
                "{} has another {what} ({then}) than {} ({now}); leave it out",
                folder.display(),
                folders[0].display(),
            ))),
        }
    };
    folders.iter().map(name).collect()
}
