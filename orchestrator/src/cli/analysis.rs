//! Options of the analyses.

use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};

use super::Work;
use sensitivity::method::FirstOrder;

fn estimator() -> impl TypedValueParser<Value = FirstOrder> {
    let names = PossibleValuesParser::new(FirstOrder::ALL.map(FirstOrder::name));
    // The parser lets no other name pass.
    names.map(|name| FirstOrder::named(&name).unwrap_or_default())
}

/// Options of `sensitivity`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples: orchestrator sensitivity studies/paper-table3.toml --base 256\n\
    \u{20}         orchestrator sensitivity studies/paper-table3.toml --from results/paper-table3"
)]
pub struct Sensitivity {
    /// The study, how its points are run, and where the results go
    #[command(flatten)]
    pub work: Work,
    /// Use the points of a finished study instead of new runs
    #[arg(long, value_name = "DIR", conflicts_with_all = ["method", "size", "base", "morris", "shapley", "fmu", "jobs", "resume", "shard"])]
    pub from: Option<PathBuf>,
    /// The method, such as sobol, morris or shapley [default: the study's, or sobol]
    #[arg(long, value_name = "NAME", conflicts_with_all = ["base", "morris", "shapley"])]
    pub method: Option<String>,
    /// The size of its design [default: the study's, or the method's usual one]
    #[arg(long, value_name = "N", conflicts_with_all = ["base", "morris", "shapley"])]
    pub size: Option<u64>,
    /// Sobol indices from N base points, which needs N (p + 2) runs for p parameters
    #[arg(long, value_name = "N", conflicts_with_all = ["morris", "shapley"])]
    pub base: Option<u64>,
    /// Morris screening with R trajectories, which needs R (p + 1) runs
    #[arg(long, value_name = "R", conflicts_with = "shapley")]
    pub morris: Option<u64>,
    /// Shapley effects, for correlated parameters, too, from N base points: N (p + 1) runs, N 2 p where correlated
    #[arg(long, value_name = "N")]
    pub shapley: Option<u64>,
    /// How first-order Sobol indices are estimated [default: the study's, or combined]
    #[arg(long, value_parser = estimator())]
    pub estimator: Option<FirstOrder>,
    /// The seed [default: the study's, or 1]
    #[arg(long, value_name = "S")]
    pub seed: Option<u64>,
}

/// Options of `robustness`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: orchestrator robustness studies/paper-table3.toml \
    --from results/paper-table3 --level 0.9"
)]
pub struct Robustness {
    /// The study, how its points are run, and where the results go
    #[command(flatten)]
    pub work: Work,
    /// The folder of the finished study [default: results/ and the study's name]
    #[arg(long, value_name = "DIR")]
    pub from: Option<PathBuf>,
    /// The verification probability that box and ellipsoid must hold [default: the study's, or 0.9]
    #[arg(long, value_name = "P")]
    pub level: Option<f64>,
    /// Confirm box and ellipsoid by N new runs in each [default: the study's, or 0]
    #[arg(long, value_name = "N")]
    pub confirm: Option<usize>,
    /// The seed [default: the study's, or 1]
    #[arg(long, value_name = "S")]
    pub seed: Option<u64>,
}

/// Options of `tolerances`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: orchestrator tolerances studies/paper-table3.toml --from results/paper-table3"
)]
pub struct Tolerances {
    /// The study, how its points are run, and where the results go
    #[command(flatten)]
    pub work: Work,
    /// The folder of the finished study, whose points are used first [default: results/ and the study's name]
    #[arg(long, value_name = "DIR")]
    pub from: Option<PathBuf>,
    /// Points of each round of the search [default: `points` under `[tolerances]`, or 1024]
    #[arg(long, value_name = "N")]
    pub points: Option<u64>,
    /// Fresh runs that confirm the result [default: `confirm` under `[tolerances]`, or 1000]
    #[arg(long, value_name = "N")]
    pub confirm: Option<u64>,
    /// The seed [default: the study's, or 1]
    #[arg(long, value_name = "S")]
    pub seed: Option<u64>,
}

/// Options of `pareto`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples: orchestrator pareto studies/paper-table3.toml --from results/paper-table3\n\
    \u{20}         orchestrator pareto studies/paper-table3.toml --generations 50"
)]
pub struct Pareto {
    /// The study, how its points are run, and where the results go
    #[command(flatten)]
    pub work: Work,
    /// The folder of the finished study [default: results/ and the study's name]
    #[arg(long, value_name = "DIR", conflicts_with = "generations")]
    pub from: Option<PathBuf>,
    /// Search by new runs (NSGA-II) over G generations, instead of using existing points
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
}

/// Options of `synchronise`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: orchestrator synchronise measured.csv --settings measured.toml \
    --output results/measured"
)]
pub struct Synchronise {
    /// The recording: a table with a column for each signal
    #[arg(value_name = "MEASURED.csv")]
    pub measured: PathBuf,
    /// TOML file with the columns' names, units, accuracies and smoothing
    #[arg(long, value_name = "SETTINGS.toml")]
    pub settings: PathBuf,
    /// Also make criteria for the amplitudes of load and torque
    #[arg(long)]
    pub amplitudes: bool,
    /// Also write a case of this name for a study, case.toml: the inputs, and the signals as curves in case.csv
    #[arg(long, value_name = "NAME")]
    pub case: Option<String>,
    /// The case is judged, and never fitted
    #[arg(long, requires = "case")]
    pub held_out: bool,
    /// The folder for the results
    #[arg(long, value_name = "DIR", default_value = "results/measured")]
    pub output: PathBuf,
}
