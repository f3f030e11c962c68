//! Options of the commands that work on a study.

use std::path::PathBuf;

use clap::builder::{RangedU64ValueParser, TypedValueParser};
use clap::{Args, ValueEnum};

use super::{Means, Parts, Work, verdict_help};
use crate::results::MOST_EXTRA_RUNS;
use crate::session::Until;
use serde::Serialize;

/// Options of `verify`.
#[derive(Debug, Args)]
#[command(
    after_help = verdict_help!(
        "orchestrator verify studies/paper-table3.toml --points 10000 --output results/table3"
    )
)]
pub struct Verify {
    /// The study
    pub study: PathBuf,
    /// The folder for the results [default: results/ and the study's name]
    #[arg(long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Run settings
    #[command(flatten)]
    pub means: Means,
    /// How many points, instead of the study's number
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub points: Option<u64>,
    /// The seed, instead of the study's
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub seed: Option<u64>,
    /// Simulate the points of a table (csv or Parquet) instead of sampling
    #[arg(long, value_name = "TABLE.csv", conflicts_with_all = ["points", "seed"])]
    pub points_from: Option<PathBuf>,
    /// Show points, design and criteria and estimate the time from a few points; run nothing else
    #[arg(long)]
    pub dry_run: bool,
    /// Resuming and shards
    #[command(flatten)]
    pub parts: Parts,
    /// Write points.parquet, too
    #[arg(long)]
    pub parquet: bool,
    /// End when the 95 % interval of the verified share is narrow enough, such as "ci 0.01", or with "verdict" when
    /// the rule of the study's section verdict decides; up to --points, or a million
    #[arg(long, value_name = "CONDITION", conflicts_with_all = ["shard", "shard_index"])]
    pub until: Option<Until>,
    /// Run some points with finer communication steps, too, to tell the numerical uncertainty (ASME V&V 20)
    #[arg(long, conflicts_with_all = ["shard", "shard_index"])]
    pub validation: bool,
    /// Find a share that is too small to be counted among sampled points, with at most --points runs [default: 100000]:
    /// that of verified points, of points that miss a criterion, or of runs that fail
    #[arg(
        long,
        value_enum,
        value_name = "OF",
        num_args = 0..=1,
        default_missing_value = "verified",
        conflicts_with_all = ["until", "validation", "points_from", "shard", "shard_index", "parquet", "dry_run"]
    )]
    pub rare: Option<RareEvent>,
    /// Run at most so many points once more, with finer steps and to a later end, to see whether their values rest
    #[arg(long, value_name = "N", default_value_t = MOST_EXTRA_RUNS, value_parser = extra_runs())]
    pub extra_runs: usize,
}

/// A share that `verify --rare` finds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum RareEvent {
    /// Points that meet all criteria
    Verified,
    /// Points whose run ends and that miss a criterion
    NotConforming,
    /// Points whose run fails
    Failed,
}

impl RareEvent {
    /// As the user writes it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Verified => "verified",
            Self::NotConforming => "not-conforming",
            Self::Failed => "failed",
        }
    }
}

fn extra_runs() -> impl TypedValueParser<Value = usize> {
    RangedU64ValueParser::<usize>::new().range(0..=MOST_EXTRA_RUNS as u64)
}

/// Options of `replay`.
#[derive(Debug, Args)]
#[command(after_help = "Example: orchestrator replay results/table3 17")]
pub struct Replay {
    /// The folder that `verify` has written
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// The point's number in `points.csv`
    pub point: u64,
    /// The FMU's new path, if it has moved
    #[arg(long, value_name = "FMU")]
    pub fmu: Option<PathBuf>,
    /// The case whose trajectory is written, where the study has cases [default: all, point-N-case-K.csv each]
    #[arg(long, value_name = "NAME")]
    pub case: Option<String>,
    /// Where to write the trajectory [default: point-N.csv in the folder]
    #[arg(long, value_name = "FILE.csv")]
    pub output: Option<PathBuf>,
}

/// Options of `merge`.
#[derive(Debug, Args)]
#[command(
    after_help = verdict_help!("orchestrator merge results/table3/shard-* --output results/table3")
)]
pub struct Merge {
    /// The folders of the shards
    #[arg(value_name = "DIR", required = true)]
    pub folders: Vec<PathBuf>,
    /// The folder for the results
    #[arg(long, value_name = "DIR")]
    pub output: PathBuf,
    /// Write points.parquet, too
    #[arg(long)]
    pub parquet: bool,
    /// The FMU's new path, if it has moved
    #[arg(long, value_name = "FMU")]
    pub fmu: Option<PathBuf>,
    /// Replace what the output folder holds, also where it is of another study file or FMU
    #[arg(long)]
    pub force: bool,
}

/// Options of `judge`.
#[derive(Debug, Args)]
#[command(after_help = verdict_help!(
    "orchestrator judge studies/paper-table3.toml studies/paper/table3_solutions.csv"
))]
pub struct Judge {
    /// The study
    pub study: PathBuf,
    /// The table
    pub table: PathBuf,
    /// The folder for points.csv and summary.json
    #[arg(long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Replace what the output folder holds, also where it is of another study file
    #[arg(long, requires = "output")]
    pub force: bool,
}

/// Options of `identify`.
#[derive(Debug, Args)]
#[command(after_help = include_str!("identify.txt"))]
pub struct Identify {
    /// The study, how its points are run, and where the results go
    #[command(flatten)]
    pub work: Work,
    /// How many starts are screened, instead of the study's number
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub starts: Option<u64>,
    /// Also predict each case from the others (leave one out), beside the fit and a plain regression
    #[arg(long)]
    pub cross_validate: bool,
    /// Draw this many sets of parameters from the posterior, too: several modes and curved valleys as they are
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub posterior: Option<u64>,
    /// Search and sample on polynomials from at most this many runs of each case, where runs are dear; their error counts
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub surrogate: Option<u64>,
    /// The seed of the starts, instead of the study's
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub seed: Option<u64>,
    /// End the search after this long and report the best so far
    #[arg(long, value_name = "SECONDS")]
    pub time_limit: Option<f64>,
}

/// Options of `report`.
#[derive(Debug, Args)]
#[command(after_help = "Example: orchestrator report results/table3")]
pub struct Report {
    /// The folder that `verify` has written
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// Write the plots as PNG, too (plots/ holds them as SVG in any case)
    #[arg(long)]
    pub png: bool,
    /// Put the FMU's WebAssembly module into the page, so that "What if" simulates fresh points
    #[arg(long)]
    pub live: bool,
    /// The FMU, instead of the study's (with --live)
    #[arg(long, value_name = "FMU", requires = "live")]
    pub fmu: Option<PathBuf>,
}
