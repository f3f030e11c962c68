//! The command line: commands and options, as `clap` reads them.

mod analysis;
mod fmu;
mod running;
mod study;

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};

pub use analysis::{Pareto, Robustness, Sensitivity, Synchronise, Tolerances};
pub use fmu::{Check, Format, Init, Inspect, Simulate};
pub use running::{Means, Parts, Work};
pub use study::{Identify, Judge, Merge, RareEvent, Replay, Report, Verify};

/// Verifies FMUs of FMI 2.0 and 3.0 against measurements under uncertainty.
#[derive(Debug, Parser)]
#[command(version, about, max_term_width = 100, after_help = EXIT)]
pub struct Cli {
    /// The command.
    #[command(subcommand)]
    pub command: Command,
}

const EXIT: &str = "Exit codes: 0 done (verify, judge, merge: verified), 1 not verified, 2 a mistake in the call, \
    3 inconclusive: the points do not tell (only with [verdict] in the study), 130 interrupted: --resume goes on.";

/// How `verify`, `judge` and `merge` come to a verdict.
macro_rules! verdict_help {
    ($example:literal) => {
        concat!(
            "Verdict: with [verdict] in the study, its `share` of the sampled space must be accepted: 0 verified, 1 not \
             verified, 3 inconclusive. Without it one point that meets all criteria is enough: 0 verified, 1 not \
             verified. Other exit codes: 2 a mistake in the call, 130 interrupted (--resume goes on).\n\nExample: ",
            $example
        )
    };
}
use verdict_help;

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Shows an FMU: variables, units, capabilities, platforms
    Inspect(Inspect),
    /// Looks for faults in an FMU; exit code 1 when it finds an error
    Check(Check),
    /// Writes a commented starting study from an FMU's own variables
    Init(Init),
    /// Simulates an FMU once and writes csv: the time, then the outputs
    Simulate(Simulate),
    /// Simulates a study's points and judges them against the measurement
    Verify(Verify),
    /// Finds the parameters that make the measured values most probable
    Identify(Identify),
    /// Applies a study's criteria to outputs in a table, without an FMU
    Judge(Judge),
    /// Runs one point of a study again, with its trajectory
    Replay(Replay),
    /// Joins shards; the result is the same as that of one run
    Merge(Merge),
    /// Writes the completion script of a shell to standard output
    Completion(Completion),
    /// Writes manual pages into a folder: one of the program and one of each command
    Manual(Manual),
    /// Runs points for another process of this program
    #[command(hide = true)]
    Worker,
    /// Runs points for a worker
    #[cfg(windows)]
    #[command(hide = true)]
    Servant {
        /// Name of the number that tells how far it is
        progress: String,
    },
    /// Simulates once for `check`
    #[command(hide = true)]
    Probe {
        /// File that describes the simulation
        setup: PathBuf,
    },
    /// Writes the report of a finished study again
    Report(Report),
    /// Tells which parameter matters: Sobol indices, Shapley effects, Morris screening, ranks, PAWN
    Sensitivity(Sensitivity),
    /// Tells how far parameters may move: maps, largest box and ellipsoid, margins
    Robustness(Robustness),
    /// Finds the widest tolerances of the parameters at which the model still conforms as wanted
    Tolerances(Tolerances),
    /// Shows the trade-off between criteria: Pareto front, best compromise
    Pareto(Pareto),
    /// Turns measured signals into criteria with their uncertainty
    Synchronise(Synchronise),
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

/// Options of `manual`.
#[derive(Debug, Args)]
#[command(after_help = "Example: orchestrator manual ~/.local/share/man/man1")]
pub struct Manual {
    /// The folder; it is made if it is not there
    pub folder: PathBuf,
}
