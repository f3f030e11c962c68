//! The command line's words.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};

use crate::analysis::sensitivity::sobol::FirstOrder;
use crate::commands::Until;
use crate::session::Shard;

/// Verifies FMI 2.0 Co-Simulation FMUs against measurements under uncertainty.
#[derive(Debug, Parser)]
#[command(version, about, max_term_width = 100, after_help = EXIT)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

const EXIT: &str = "Exit codes: 0 done (verify, judge: at least one point meets all criteria), \
    1 not verified, 2 a mistake in what was asked for.";

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Says what an FMU is: variables, units, capabilities, platforms
    Inspect(Inspect),
    /// Looks at an FMU before it is used: exit code 0 when nothing was found, 1 with findings
    Check(Check),
    /// Writes a commented starting study from an FMU's own variables
    Init(Init),
    /// Simulates an FMU once; the first column is the time, then come the outputs
    Simulate(Simulate),
    /// Simulates a study's points and judges them against the measurement
    Verify(Verify),
    /// Finds the parameters that make the FMU's outputs most probable, given measured values
    Identify(Identify),
    /// Judges outputs that already stand in a table; needs no FMU
    Judge(Judge),
    /// Runs one point of a study again, with its trajectory
    Replay(Replay),
    /// Joins shards: the same result as one run
    Merge(Merge),
    /// Writes the completion script of a shell to standard output
    Completion(Completion),
    /// Runs points for another process of this program
    #[command(hide = true)]
    Worker,
    /// Writes the page of a finished study again
    Report(Report),
    /// Tells which parameter matters: Sobol indices, screening, or from existing points
    Sensitivity(Sensitivity),
    /// Tells how far the parameters may go: maps, the largest box and ellipsoid, margins
    Robustness(Robustness),
    /// Tells what the criteria cost each other: the front of unbeaten points, the best compromise
    Pareto(Pareto),
    /// Aligns measured signals and derives criteria with their uncertainty
    Synchronise(Synchronise),
}

/// Options of `inspect`.
#[derive(Debug, Args)]
#[command(after_help = "Example: orchestrator inspect dist/PlainBearingStand.fmu")]
pub struct Inspect {
    /// The FMU
    pub fmu: PathBuf,
    /// Everything, as JSON
    #[arg(long)]
    pub json: bool,
}

/// Options of `check`.
#[derive(Debug, Args)]
#[command(after_help = "Example: orchestrator check dist/PlainBearingStand.fmu")]
pub struct Check {
    /// The FMU
    pub fmu: PathBuf,
}

/// Options of `init`.
#[derive(Debug, Args)]
#[command(after_help = "Example: orchestrator init dist/PlainBearingStand.fmu --output study.toml")]
pub struct Init {
    /// The FMU
    pub fmu: PathBuf,
    /// Where to write the study [default: standard output]
    #[arg(long, value_name = "STUDY.toml")]
    pub output: Option<PathBuf>,
}

/// Options of `completion`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: orchestrator completion bash > ~/.local/share/bash-completion/completions/orchestrator"
)]
pub struct Completion {
    /// The shell
    pub shell: clap_complete::Shell,
}

/// Options of `simulate`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: orchestrator simulate dist/PlainBearingStand.fmu --stop 10 \
    --set bearing.radialClearance=\"0.02 mm\" --output run.csv"
)]
pub struct Simulate {
    /// The FMU
    pub fmu: PathBuf,
    /// A start value, with or without a unit; may be repeated
    #[arg(long, value_name = "NAME=VALUE")]
    pub set: Vec<String>,
    /// Start values from an SSP parameter set, such as the best.ssv that `verify` writes
    #[arg(long, value_name = "FILE.ssv")]
    pub set_from: Option<PathBuf>,
    /// When to start, s [default: as the FMU suggests]
    #[arg(long, value_name = "T")]
    pub start: Option<f64>,
    /// When to stop, s [default: as the FMU suggests]
    #[arg(long, value_name = "T")]
    pub stop: Option<f64>,
    /// The communication step, s [default: as the FMU suggests]
    #[arg(long, value_name = "H")]
    pub step: Option<f64>,
    /// Where to write the trajectory [default: standard output]
    #[arg(long, value_name = "FILE.csv")]
    pub output: Option<PathBuf>,
}

/// With what a study is run.
#[derive(Debug, Args)]
pub struct Means {
    /// Another FMU than the study's
    #[arg(long, value_name = "FMU")]
    pub fmu: Option<PathBuf>,
    /// How many simulations at a time [default: the number of cores]
    #[arg(long, value_name = "J")]
    pub jobs: Option<usize>,
}

/// Options of `verify`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: orchestrator verify studies/paper-table3.toml --points 10000 \
    --output results/table3"
)]
pub struct Verify {
    /// The study
    pub study: PathBuf,
    /// The folder for the results [default: results/ and the study's name]
    #[arg(long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// What runs it
    #[command(flatten)]
    pub means: Means,
    /// How many points, instead of the study's number
    #[arg(long, value_name = "N")]
    pub points: Option<u64>,
    /// The seed, instead of the study's
    #[arg(long, value_name = "S")]
    pub seed: Option<u64>,
    /// Simulate the points of a table (csv or Parquet) instead of sampling
    #[arg(long, value_name = "TABLE.csv", conflicts_with_all = ["points", "seed"])]
    pub points_from: Option<PathBuf>,
    /// Only say what would be done: points, design, criteria
    #[arg(long)]
    pub dry_run: bool,
    /// Continue a study that was interrupted
    #[arg(long)]
    pub resume: bool,
    /// Write points.parquet, too
    #[arg(long)]
    pub parquet: bool,
    /// Simulate only one of several equal parts of the points; `merge` joins them
    #[arg(long, value_name = "I/N")]
    pub shard: Option<Shard>,
    /// End when the 95 % interval of the verified share is narrow enough, such as "ci 0.01"
    #[arg(long, value_name = "CONDITION", conflicts_with = "shard")]
    pub until: Option<Until>,
    /// Run points in this process: a little faster, but a crash of the FMU ends the study
    #[arg(long)]
    pub in_process: bool,
    /// The longest time that a point may take, s
    #[arg(long, value_name = "T", default_value_t = 3600.0)]
    pub point_timeout: f64,
    /// The most memory that a worker process may take, such as 500MB [default: a fair share of
    /// the machine's]
    #[arg(long, value_name = "SIZE")]
    pub memory_limit: Option<String>,
}

/// Options of `replay`.
#[derive(Debug, Args)]
#[command(after_help = "Example: orchestrator replay results/table3 17")]
pub struct Replay {
    /// The folder that `verify` has written
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// The point, as `points.csv` calls it
    pub point: u64,
    /// Where the FMU is, if it has moved
    #[arg(long, value_name = "FMU")]
    pub fmu: Option<PathBuf>,
    /// Where to write the trajectory [default: point-N.csv in the folder]
    #[arg(long, value_name = "FILE.csv")]
    pub output: Option<PathBuf>,
}

/// Options of `merge`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: orchestrator merge results/table3/shard-* --output results/table3"
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
    /// Where the FMU is, if it has moved
    #[arg(long, value_name = "FMU")]
    pub fmu: Option<PathBuf>,
}

/// Options of `judge`.
#[derive(Debug, Args)]
#[command(after_help = "Example: orchestrator judge studies/paper-table3.toml \
    studies/paper/table3_solutions.csv")]
pub struct Judge {
    /// The study
    pub study: PathBuf,
    /// The table
    pub table: PathBuf,
    /// Where to write points.csv and summary.json
    #[arg(long, value_name = "DIR")]
    pub output: Option<PathBuf>,
}

/// Options of `identify`.
#[derive(Debug, Args)]
#[command(after_help = include_str!("cli/identify.txt"))]
pub struct Identify {
    /// The study
    pub study: PathBuf,
    /// The folder for the results [default: results/ and the study's name]
    #[arg(long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// What runs it
    #[command(flatten)]
    pub means: Means,
    /// How many starts are screened, instead of the study's number
    #[arg(long, value_name = "N")]
    pub starts: Option<u64>,
    /// The seed of the starts, instead of the study's
    #[arg(long, value_name = "S")]
    pub seed: Option<u64>,
    /// End the search after this long and report the best so far
    #[arg(long, value_name = "SECONDS")]
    pub time_limit: Option<f64>,
    /// Continue a search that was interrupted
    #[arg(long)]
    pub resume: bool,
}

/// Options of `report`.
#[derive(Debug, Args)]
#[command(after_help = "Example: orchestrator report results/table3")]
pub struct Report {
    /// The folder that `verify` has written
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// The plots as PNG files, too; they are beside the page in plots/, as SVG in any case
    #[arg(long)]
    pub png: bool,
}

/// Options of `sensitivity`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples: orchestrator sensitivity studies/paper-table3.toml --base 256\n\
    \u{20}         orchestrator sensitivity studies/paper-table3.toml --from results/paper-table3"
)]
pub struct Sensitivity {
    /// The study
    pub study: PathBuf,
    /// Use the points of a finished study instead of new runs
    #[arg(long, value_name = "DIR", conflicts_with_all = ["morris", "fmu", "jobs"])]
    pub from: Option<PathBuf>,
    /// Base points of the Sobol indices; the runs are this many times the parameters and two more
    #[arg(long, value_name = "N", default_value_t = 256)]
    pub base: u64,
    /// How first-order indices are estimated
    #[arg(long, value_enum, default_value_t)]
    pub estimator: FirstOrder,
    /// Morris screening with so many trajectories instead of Sobol indices
    #[arg(long, value_name = "R", conflicts_with = "base")]
    pub morris: Option<usize>,
    /// The seed
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub seed: u64,
    /// What runs it
    #[command(flatten)]
    pub means: Means,
    /// The folder for the results [default: results/ and the study's name, or DIR of --from]
    #[arg(long, value_name = "DIR")]
    pub output: Option<PathBuf>,
}

/// Options of `synchronise`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: orchestrator synchronise measured.csv --settings measured.toml \
    --output results/measured"
)]
pub struct Synchronise {
    /// The recording: a column a signal
    #[arg(value_name = "MEASURED.csv")]
    pub measured: PathBuf,
    /// What the columns are: names, units, accuracies, smoothing
    #[arg(long, value_name = "SETTINGS.toml")]
    pub settings: PathBuf,
    /// Criteria for the amplitudes of load and torque, too
    #[arg(long)]
    pub amplitudes: bool,
    /// The folder for the results
    #[arg(long, value_name = "DIR", default_value = "results/measured")]
    pub output: PathBuf,
}

/// Options of `robustness`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: orchestrator robustness studies/paper-table3.toml \
    --from results/paper-table3 --level 0.9"
)]
pub struct Robustness {
    /// The study
    pub study: PathBuf,
    /// The folder of the finished study [default: results/ and the study's name]
    #[arg(long, value_name = "DIR")]
    pub from: Option<PathBuf>,
    /// The verification probability that box and ellipsoid must hold
    #[arg(long, value_name = "P", default_value_t = 0.9)]
    pub level: f64,
    /// Confirm box and ellipsoid by so many new runs in each
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub confirm: usize,
    /// The seed
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub seed: u64,
    /// What runs it
    #[command(flatten)]
    pub means: Means,
    /// The folder for the results [default: that of the study]
    #[arg(long, value_name = "DIR")]
    pub output: Option<PathBuf>,
}

/// Options of `pareto`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples: orchestrator pareto studies/paper-table3.toml --from results/paper-table3\n\
    \u{20}         orchestrator pareto studies/paper-table3.toml --generations 50"
)]
pub struct Pareto {
    /// The study
    pub study: PathBuf,
    /// The folder of the finished study [default: results/ and the study's name]
    #[arg(long, value_name = "DIR", conflicts_with = "generations")]
    pub from: Option<PathBuf>,
    /// Search by new runs (NSGA-II) over so many generations, instead of using existing points
    #[arg(long, value_name = "G")]
    pub generations: Option<usize>,
    /// Runs in a generation
    #[arg(
        long,
        value_name = "N",
        default_value_t = 100,
        requires = "generations"
    )]
    pub population: usize,
    /// The seed of the search
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub seed: u64,
    /// What runs it
    #[command(flatten)]
    pub means: Means,
    /// The folder for the results [default: that of the study]
    #[arg(long, value_name = "DIR")]
    pub output: Option<PathBuf>,
}
