//! The commands, one file each.

mod batch;
mod best;
mod check;
mod completion;
mod cost;
mod finding;
mod identify;
mod init;
mod inspect;
mod judge;
mod limits;
mod means;
mod merge;
mod output;
mod pareto;
mod progress;
mod replay;
mod report;
mod robustness;
mod sensitivity;
mod simulate;
mod stop;
pub mod synchronise;
mod table;
mod verify;

use std::process::ExitCode;

use thiserror::Error;

use crate::analysis::from_results::FolderError;
use crate::cli::{Cli, Command};
use crate::engine::{EngineError, guard};
use crate::failure::Failure;
use crate::report::ReportError;
use crate::results::ResultsError;
use crate::session::SessionError;
use crate::study::StudyError;
use crate::study::ssv::SsvError;
use crate::table::TableError;
use fmu_import::FmuError;

/// The exit code for a mistake in what was asked for.
pub const MISTAKE: u8 = 2;

/// Why a command cannot do what was asked for.
#[derive(Debug, Error)]
pub enum CommandError {
    /// The FMU cannot be used.
    #[error(transparent)]
    Fmu(#[from] FmuError),
    /// The study cannot be used.
    #[error(transparent)]
    Study(#[from] StudyError),
    /// A parameter set cannot be used.
    #[error(transparent)]
    Set(#[from] SsvError),
    /// A table cannot be used.
    #[error(transparent)]
    Table(#[from] TableError),
    /// The results cannot be written or read.
    #[error(transparent)]
    Results(#[from] ResultsError),
    /// A recording cannot be used.
    #[error(transparent)]
    Recording(#[from] synchronise::SettingsError),
    /// A folder of results cannot be read.
    #[error(transparent)]
    Folder(#[from] FolderError),
    /// The report cannot be written.
    #[error(transparent)]
    Report(#[from] ReportError),
    /// The points cannot be run.
    #[error(transparent)]
    Engine(#[from] EngineError),
    /// The study cannot be run.
    #[error(transparent)]
    Session(#[from] SessionError),
    /// A single simulation failed.
    #[error("the simulation failed: {0}")]
    Simulation(#[from] Failure),
    /// A search found nothing.
    #[error("the search failed: {0}")]
    Search(String),
    /// Shards cannot be joined.
    #[error("{0}")]
    Shards(String),
    /// An option's value cannot be used.
    #[error("--{option}: {message}")]
    Option {
        /// The option.
        option: &'static str,
        /// What is wrong.
        message: String,
    },
}

/// Does what the command line says.
///
/// # Errors
/// With one clear line, for a mistake in what was asked for.
pub fn run(cli: Cli) -> Result<ExitCode, CommandError> {
    match cli.command {
        Command::Inspect(options) => inspect::run(&options),
        Command::Check(options) => check::run(&options),
        Command::Init(options) => init::run(&options),
        Command::Completion(options) => Ok(completion::run(&options)),
        Command::Simulate(options) => simulate::run(&options),
        Command::Verify(options) => verify::run(&options),
        Command::Identify(options) => identify::run(&options),
        Command::Judge(options) => judge::run(&options),
        Command::Replay(options) => replay::run(&options),
        Command::Merge(options) => merge::run(&options),
        Command::Worker => guard::end(guard::serve()),
        Command::Probe { setup } => guard::end(check::serve(&setup)),
        Command::Report(options) => report::run(&options),
        Command::Sensitivity(options) => sensitivity::run(&options),
        Command::Robustness(options) => robustness::run(&options),
        Command::Pareto(options) => pareto::run(&options),
        Command::Synchronise(options) => synchronise::run(&options),
    }
}

/// 0 when at least one point meets all criteria, 1 when none does.
fn verdict(verified: u64) -> ExitCode {
    if verified > 0 {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}
