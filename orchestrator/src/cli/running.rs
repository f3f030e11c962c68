//! Options for running points: processes, limits, shards, resuming.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use clap::Args;

use crate::pipeline::Shard;
use crate::pipeline::folder::Earlier;
use fmu_points::Isolation;

/// Shards of a run, and resuming.
#[derive(Debug, Args)]
pub struct Parts {
    /// Continue a run that was interrupted
    #[arg(long)]
    pub resume: bool,
    /// Replace what the output folder holds, also where it is of another study file or FMU, or not complete
    #[arg(long, conflicts_with = "resume")]
    pub force: bool,
    /// Simulate only one of several equal parts of the points; `merge` joins them
    #[arg(long, value_name = "I/N")]
    shard: Option<Shard>,
    /// The same, counted from 0 as array jobs do
    #[arg(long, value_name = "I", requires = "shards", conflicts_with = "shard")]
    shard_index: Option<u64>,
    /// How many parts there are, with --shard-index
    #[arg(long, value_name = "N", requires = "shard_index")]
    shards: Option<u64>,
}

impl Parts {
    /// The part to simulate, if not all.
    ///
    /// # Errors
    /// When there is no such part.
    pub fn shard(&self) -> Result<Option<Shard>, String> {
        match (self.shard_index, self.shards) {
            (Some(index), Some(of)) if index < of => {
                let number = index + 1;
                Ok(Some(Shard { number, of }))
            }
            (Some(index), Some(of)) => Err(format!(
                "{index} is none of {of} parts, which are counted from 0"
            )),
            _ => Ok(self.shard),
        }
    }

    /// What becomes of an earlier run in the output folder.
    pub fn earlier(&self) -> Earlier {
        match (self.resume, self.force) {
            (true, _) => Earlier::Resumed,
            (_, true) => Earlier::Replaced,
            _ => Earlier::Complete,
        }
    }
}

/// Processes that run the points, and their limits.
#[derive(Debug, Args)]
pub struct Means {
    /// The FMU, instead of the study's
    #[arg(long, value_name = "FMU")]
    pub fmu: Option<PathBuf>,
    /// The number of parallel simulations [default: the number of cores]
    #[arg(long, value_name = "J", allow_negative_numbers = true)]
    pub jobs: Option<NonZeroUsize>,
    /// Run points in this process: a little faster, but a crash of the FMU ends the run
    #[arg(long, conflicts_with = "isolation")]
    pub in_process: bool,
    /// How points share processes
    #[arg(long, value_enum, value_name = "HOW", default_value = "audited")]
    pub isolation: Isolation,
    /// The longest time that a point may take, s
    #[arg(
        long,
        value_name = "T",
        default_value_t = 3600.0,
        allow_negative_numbers = true
    )]
    pub point_timeout: f64,
    /// The most memory that a worker process may take, such as 500MB [default: a fair share of
    /// the machine's]
    #[arg(long, value_name = "SIZE")]
    pub memory_limit: Option<String>,
}

/// What every analysis of a study takes.
#[derive(Debug, Args)]
pub struct Work {
    /// The study
    pub study: PathBuf,
    /// The folder for the results [default: results/ and the study's name, or the folder of --from]
    #[arg(long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Run settings
    #[command(flatten)]
    pub means: Means,
    /// Resuming and shards
    #[command(flatten)]
    pub parts: Parts,
}
