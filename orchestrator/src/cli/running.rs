//! With what and where a study is run.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use clap::Args;

use crate::engine::Isolation;
use crate::pipeline::Shard;

/// How a run of points is cut up and taken up again.
#[derive(Debug, Args)]
pub struct Parts {
    /// Continue a run that was interrupted
    #[arg(long)]
    pub resume: bool,
    /// Simulate only one of several equal parts of the points; `merge` joins them
    #[arg(long, value_name = "I/N")]
    pub shard: Option<Shard>,
}

/// With what and where a study is run, and what a point may use.
#[derive(Debug, Args)]
pub struct Means {
    /// Another FMU than the study's
    #[arg(long, value_name = "FMU")]
    pub fmu: Option<PathBuf>,
    /// How many simulations at a time [default: the number of cores]
    #[arg(long, value_name = "J", allow_negative_numbers = true)]
    pub jobs: Option<NonZeroUsize>,
    /// Run points in this process: a little faster, but a crash of the FMU ends the run
    #[arg(long, conflicts_with = "isolation")]
    pub in_process: bool,
    /// How points share processes
    #[arg(long, value_enum, value_name = "HOW", default_value = "audited")]
    pub isolation: Isolation,
    /// The longest time that a point may take, s
    #[arg(long, value_name = "T", default_value_t = 3600.0)]
    pub point_timeout: f64,
    /// The most memory that a worker process may take, such as 500MB [default: a fair share of
    /// the machine's]
    #[arg(long, value_name = "SIZE")]
    pub memory_limit: Option<String>,
}
