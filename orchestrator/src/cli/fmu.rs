//! Options of the commands that work without a study: on a single FMU, or on a recording.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::Gate;

/// Options of `inspect`.
#[derive(Debug, Args)]
#[command(after_help = "Example: orchestrator inspect dist/PlainBearingStand.fmu")]
pub struct Inspect {
    /// The FMU
    pub fmu: PathBuf,
    /// Print everything, as JSON
    #[arg(long)]
    pub json: bool,
}

/// Options of `check`.
#[derive(Debug, Args)]
#[command(after_help = "Example: orchestrator check dist/PlainBearingStand.fmu")]
pub struct Check {
    /// The FMU
    pub fmu: PathBuf,
    /// A start value, with or without a unit, such as that of an input that starts at 0; may be repeated
    #[arg(long, value_name = "NAME=VALUE")]
    pub set: Vec<String>,
    /// The communication step, s [default: as the FMU suggests]
    #[arg(long, value_name = "H", allow_negative_numbers = true)]
    pub step: Option<f64>,
    /// The format of the findings: text, JSON, or SARIF for editors and build servers
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
    /// What a build server wants
    #[command(flatten)]
    pub gate: Gate,
    /// Known findings, which do not count: a TOML file with `[[ignore]]` entries of `rule`, `reason` and, for one variable
    /// only, `variable`
    #[arg(long, value_name = "FILE.toml")]
    pub ignore: Option<PathBuf>,
    /// Time limit for each of the short simulations, s
    #[arg(long, value_name = "SECONDS", default_value_t = 60.0)]
    pub patience: f64,
}

/// How `check` writes its findings.
#[derive(Clone, Debug, Default, ValueEnum)]
pub enum Format {
    /// A line each
    #[default]
    Text,
    /// One object
    Json,
    /// SARIF 2.1.0
    Sarif,
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
    /// Measured values: a table with columns `NAME [UNIT]` of the FMU's outputs and inputs; with a column `time` they are
    /// curves
    #[arg(long, value_name = "DATA.csv")]
    pub measured: Option<PathBuf>,
    /// A start value, with or without a unit, such as that of an input that starts at 0; may be repeated
    #[arg(long, value_name = "NAME=VALUE")]
    pub set: Vec<String>,
    /// When to stop, s [default: with the measured curves, or as the FMU suggests]
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    pub stop: Option<f64>,
    /// The communication step, s [default: as the FMU suggests]
    #[arg(long, value_name = "H", allow_negative_numbers = true)]
    pub step: Option<f64>,
}

/// Options of `simulate`.
#[derive(Debug, Args)]
#[command(after_help = "Example: orchestrator simulate dist/PlainBearingStand.fmu --stop 10 \
    --set bearing.radialClearance=\"0.02 mm\" --output run.csv")]
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
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    pub start: Option<f64>,
    /// When to stop, s [default: as the FMU suggests]
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    pub stop: Option<f64>,
    /// The communication step, s [default: as the FMU suggests]
    #[arg(long, value_name = "H", allow_negative_numbers = true)]
    pub step: Option<f64>,
    /// The variables to record, separated by commas; may be repeated [default: the outputs]
    #[arg(long, value_name = "NAME,NAME")]
    pub record: Vec<String>,
    /// Inputs over time: a table with a column `time` and a column for each input, `NAME` or `NAME [UNIT]`
    #[arg(long, value_name = "FILE.csv")]
    pub input: Option<PathBuf>,
    /// Let the first and the last value of inputs hold where the run is longer than their table
    #[arg(long, value_name = "hold", value_parser = ["hold"], requires = "input")]
    pub extrapolate: Option<String>,
    /// The file for the trajectory; - or no option: standard output
    #[arg(long, value_name = "FILE.csv")]
    pub output: Option<PathBuf>,
}

/// Options of `synchronise`.
#[derive(Debug, Args)]
#[command(after_help = "Example: orchestrator synchronise measured.csv --settings measured.toml \
    --output results/measured")]
pub struct Synchronise {
    /// The recording: tables with a column for each signal, one or more files
    #[arg(value_name = "MEASURED.csv", required = true)]
    pub measured: Vec<PathBuf>,
    /// TOML file with the columns' names, units and accuracies
    #[arg(long, value_name = "SETTINGS.toml")]
    pub settings: PathBuf,
    /// Also write a case of this name for a study: case.toml, with csv files of the inputs and of the signals as curves
    #[arg(long, value_name = "NAME")]
    pub case: Option<String>,
    /// Mark the case as held out: judged, never fitted
    #[arg(long, requires = "case")]
    pub held_out: bool,
    /// The folder for the results
    #[arg(long, value_name = "DIR", default_value = "results/measured")]
    pub output: PathBuf,
}
