//! `merge`: joins shards; the same result as one run.

use std::process::ExitCode;

use super::{CommandError, verify};
use crate::cli::Merge;
use crate::results::journal::{self, Header};
use crate::results::{ResultsError, parquet};
use crate::session::{Request, Session};

pub(super) fn run(options: &Merge) -> Result<ExitCode, CommandError> {
    let [first, ..] = &options.folders[..] else {
        return Err(ResultsError::Missing(options.output.clone()).into());
    };
    let mut request = Request::read(first)?;
    request.shard = None;
    request.fmu = options.fmu.clone().or(request.fmu);
    let mut session = Session::open(request)?;
    for folder in &options.folders {
        let then = Header::read(folder)?;
        // Only the part differs from one to the other.
        let same_part = Header {
            shard: then.shard.clone(),
            ..session.header().clone()
        };
        same_part.check(&then, folder)?;
    }
    let (mut joined, _) = session.journal(&options.output, false)?;
    for folder in &options.folders {
        journal::copy(folder, &mut joined)?;
    }
    joined.sync()?;
    drop(joined);
    let summary = session.conclude(&options.output, None, |_| false)?;
    if options.parquet {
        parquet::convert(&options.output, &summary)?;
    }
    verify::conclude(&mut session, &options.output, &summary, false)
}
