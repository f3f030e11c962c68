//! `merge`: joins shards; the same result as one run.

use std::path::PathBuf;
use std::process::ExitCode;

use super::{CommandError, verify};
use crate::cli::Merge;
use crate::results::{Header, ResultsError, journal, lines, parquet};
use crate::session::{Request, Session, SessionError};

pub(super) fn run(options: &Merge) -> Result<ExitCode, CommandError> {
    let [first, ..] = &options.folders[..] else {
        return Err(ResultsError::Missing(options.output.clone()).into());
    };
    let mut request = Request::read(first)?;
    request.shard = None;
    request.fmu = options.fmu.clone().or(request.fmu);
    let mut session = Session::open(request)?;
    let named = check(&options.folders, session.header())?;
    // What an incomplete merge has begun, this one goes on with.
    let begun = !options.output.join("summary.json").exists();
    let (mut joined, _) = session.journal(&options.output, begun)?;
    for folder in &options.folders {
        journal::copy(folder, &mut joined)?;
    }
    joined.sync()?;
    drop(joined);
    let summary = session.conclude(&options.output, None, |_| false);
    let summary = summary.map_err(|error| match error {
        SessionError::Results(ResultsError::Incomplete {
            missing, points, ..
        }) => CommandError::Shards(format!(
            "{missing} of {points} points are in none of the shards {}; merge all of them, or \
                 compute what is missing with `verify STUDY --output {} --resume`",
            named.join(", "),
            options.output.display()
        )),
        error => error.into(),
    })?;
    if options.parquet {
        parquet::convert(&options.output, &summary)?;
    }
    verify::conclude(&mut session, &options.output, &summary, false)
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
