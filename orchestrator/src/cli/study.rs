//! Options of the commands that work on a study.

use std::path::{Path, PathBuf};

use clap::{
    Args, Parser,
    builder::{RangedU64ValueParser, TypedValueParser},
};

use super::{Cli, Command, verdict_help};
use crate::{
    methods::rare::{self, RareEvent},
    options::{Shards, Work},
    results::MOST_EXTRA_RUNS,
    session::Until,
};

/// What a build server wants.
#[derive(Debug, Args)]
pub struct Gate {
    /// Write the outcome as JUnit XML, too: a test each for the verdict, every criterion, case, warning or finding
    #[arg(long, value_name = "FILE.xml")]
    pub junit: Option<PathBuf>,
    /// Exit with 1 on warnings, too
    #[arg(long)]
    pub strict: bool,
}

/// Options of `verify`.
#[derive(Debug, Args)]
#[command(
    after_help = verdict_help!(
        "orchestrator verify studies/paper-table3.toml --points 10000 --output results/table3"
    )
)]
pub struct Verify {
    /// The study, how its points are run, and where the results go
    #[command(flatten)]
    pub work: Work,
    /// A part of the points
    #[command(flatten)]
    pub shards: Shards,
    /// How many points, instead of the study's number
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub points: Option<u64>,
    /// The seed, instead of the study's
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub seed: Option<u64>,
    /// For an FMU whose runs are dear: at most N runs in the folder, at points that are chosen while they come in; a surrogate tells the
    /// share with its interval, or counts where it does not hold
    #[arg(
        long,
        value_name = "N",
        conflicts_with_all = ["points", "points_from", "shard", "shard_index", "validation", "carried"]
    )]
    pub budget: Option<u64>,
    /// Simulate the points of a table (csv or Parquet) instead of sampling
    #[arg(long, value_name = "TABLE.csv", conflicts_with_all = ["points", "seed"])]
    pub points_from: Option<PathBuf>,
    /// Show points, design and criteria and estimate the time from a few points; run nothing else
    #[arg(long)]
    pub dry_run: bool,
    /// End early: "ci 0.01" when the 95 % interval of the share is 0.01 wide, "verdict" when the study's `[verdict]` is decided;
    /// at the latest at --points, --budget, or a million
    #[arg(long, value_name = "CONDITION", conflicts_with_all = ["shard", "shard_index"])]
    pub until: Option<Until>,
    /// Run some points with finer communication steps, too, to find the numerical uncertainty (ASME V&V 20)
    #[arg(long, conflicts_with_all = ["shard", "shard_index"])]
    pub validation: bool,
    /// Print the long answer
    #[arg(long)]
    pub verbose: bool,
    /// Find a share that is too small to be counted among sampled points, with at most --budget runs [default: 150]:
    /// that of verified points, of points that miss a criterion, or of runs that fail
    #[arg(
        long,
        value_enum,
        value_name = "OF",
        num_args = 0..=1,
        default_missing_value = "verified",
        conflicts_with_all = ["points", "until", "validation", "points_from", "shard", "shard_index", "dry_run", "junit", "strict"]
    )]
    pub rare: Option<RareEvent>,
    /// Run at most N points again: the best one longer and finer, to see whether its values have settled; of many points some with half
    /// the communication step, too
    #[arg(long, value_name = "N", default_value_t = MOST_EXTRA_RUNS, value_parser = extra_runs())]
    pub extra_runs: usize,
    /// The study to run, where STUDY is an FMU that carries several [default: the one packed last]
    #[arg(long = "study", id = "carried", value_name = "NAME")]
    pub carried: Option<String>,
    /// For a build server
    #[command(flatten)]
    pub gate: Gate,
}

impl Verify {
    /// Those of `verify STUDY`.
    pub fn of(study: &Path) -> Self {
        let line = ["orchestrator".as_ref(), "verify".as_ref(), study.as_os_str()];
        match Cli::try_parse_from(line).map(|cli| cli.command) {
            Ok(Command::Verify(options)) => *options,
            _ => unreachable!("`verify STUDY` is a command"),
        }
    }

    /// The search for the share of a rare event.
    pub fn rare(self, event: RareEvent) -> rare::Options {
        rare::Options { event, budget: self.budget, seed: self.seed, work: self.work }
    }
}

fn extra_runs() -> impl TypedValueParser<Value = usize> {
    RangedU64ValueParser::<usize>::new().range(0..=MOST_EXTRA_RUNS as u64)
}

/// Options of `pack`.
#[derive(Debug, Args)]
#[command(
    after_help = "`orchestrator verify MODEL.fmu` runs the study that the FMU carries, on any machine, and compares the results \
    with the carried ones: exit code 1 if they differ.\n\nExample: orchestrator pack studies/rig.toml --output Stand.fmu"
)]
pub struct Pack {
    /// The study, a TOML file
    pub study: PathBuf,
    /// The copy of the FMU
    #[arg(long, value_name = "MODEL.fmu")]
    pub output: PathBuf,
    /// Replace the file of that name
    #[arg(long)]
    pub force: bool,
    /// The folder with the study's results [default: the study is run first, by `verify --validation`]
    #[arg(long, value_name = "DIR")]
    pub from: Option<PathBuf>,
    /// The FMU, instead of the study's, such as one that carries another study already
    #[arg(long, value_name = "FMU")]
    pub fmu: Option<PathBuf>,
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
    /// The case whose trajectory is written, where the study has cases [default: every case, in point-N-case-K.csv]
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
    /// The FMU's new path, if it has moved
    #[arg(long, value_name = "FMU")]
    pub fmu: Option<PathBuf>,
    /// Run at most N points again, as `verify` does
    #[arg(long, value_name = "N", default_value_t = MOST_EXTRA_RUNS, value_parser = extra_runs())]
    pub extra_runs: usize,
    /// Print the long answer
    #[arg(long)]
    pub verbose: bool,
    /// Replace the folder's results, also those of another study or FMU
    #[arg(long)]
    pub force: bool,
    /// For a build server
    #[command(flatten)]
    pub gate: Gate,
}

/// Options of `compare`.
#[derive(Debug, Args)]
#[command(after_help = "Exit codes: 0 the same verdict, and no point changed sides (beyond the stated numerical \
    uncertainty), 1 a difference (with --strict also a changed value), 2 a mistake in the call or a \
    file.\n\nExample: orchestrator compare \
    results/release-1 results/rig --output results/changes")]
pub struct Compare {
    /// The folder of the earlier results of `verify` or `judge`
    #[arg(value_name = "OLD")]
    pub old: PathBuf,
    /// The folder of the later results
    #[arg(value_name = "NEW")]
    pub new: PathBuf,
    /// The folder for compare.html and compare.json [default: they are not written]
    #[arg(long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// For a build server
    #[command(flatten)]
    pub gate: Gate,
}

/// Options of `judge`.
#[derive(Debug, Args)]
#[command(after_help = verdict_help!(
    "orchestrator judge studies/paper-table3.toml studies/paper/table3_solutions.csv"
))]
pub struct Judge {
    /// The study, a TOML file
    pub study: PathBuf,
    /// The table, a row a point (csv or Parquet)
    pub table: PathBuf,
    /// The folder for points.csv and summary.json [default: they are not written]
    #[arg(long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Print the long answer
    #[arg(long)]
    pub verbose: bool,
    /// Replace the folder's results, also those of another study
    #[arg(long, requires = "output")]
    pub force: bool,
    /// For a build server
    #[command(flatten)]
    pub gate: Gate,
}

/// Options of `report`.
#[derive(Debug, Args)]
#[command(after_help = "Example: orchestrator report results/table3")]
pub struct Report {
    /// The folder that `verify` has written
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
}
