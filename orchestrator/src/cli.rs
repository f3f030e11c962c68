//! The command line's words.

mod analysis;
mod fmu;
mod running;
mod study;

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};

pub use analysis::{Pareto, Robustness, Sensitivity, Synchronise};
pub use fmu::{Check, Format, Init, Inspect, Simulate};
pub use running::{Means, Parts};
pub use study::{Identify, Judge, Merge, Replay, Report, Verify};

/// Verifies FMI 2.0 Co-Simulation FMUs against measurements under uncertainty.
#[derive(Debug, Parser)]
#[command(version, about, max_term_width = 100, after_help = EXIT)]
pub struct Cli {
    /// The command.
    #[command(subcommand)]
    pub command: Command,
}

const EXIT: &str = "Exit codes: 0 done (verify, judge: at least one point meets all criteria), \
    1 not verified, 2 a mistake in what was asked for.";

/// The commands.
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
    /// Simulates once for `check`
    #[command(hide = true)]
    Probe {
        /// File that describes the simulation
        setup: PathBuf,
    },
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

/// Options of `completion`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: orchestrator completion bash > ~/.local/share/bash-completion/completions/orchestrator"
)]
pub struct Completion {
    /// The shell
    pub shell: clap_complete::Shell,
}
