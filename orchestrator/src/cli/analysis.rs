//! Options of the analyses.

use std::path::PathBuf;

use clap::Args;

use super::{Means, Parts};
use crate::analysis::sensitivity::sobol::FirstOrder;

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
    #[arg(long, value_name = "DIR", conflicts_with_all = ["morris", "fmu", "jobs", "resume", "shard"])]
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
    /// Run settings
    #[command(flatten)]
    pub means: Means,
    /// Which part of it
    #[command(flatten)]
    pub parts: Parts,
    /// The folder for the results [default: results/ and the study's name, or DIR of --from]
    #[arg(long, value_name = "DIR")]
    pub output: Option<PathBuf>,
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
    /// Run settings
    #[command(flatten)]
    pub means: Means,
    /// Which part of it
    #[command(flatten)]
    pub parts: Parts,
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
    /// Run settings
    #[command(flatten)]
    pub means: Means,
    /// Which part of it
    #[command(flatten)]
    pub parts: Parts,
    /// The folder for the results [default: that of the study]
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
    /// TOML file with the columns' names, units, accuracies and smoothing
    #[arg(long, value_name = "SETTINGS.toml")]
    pub settings: PathBuf,
    /// Criteria for the amplitudes of load and torque, too
    #[arg(long)]
    pub amplitudes: bool,
    /// The folder for the results
    #[arg(long, value_name = "DIR", default_value = "results/measured")]
    pub output: PathBuf,
}
