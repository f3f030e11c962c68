//! The commands, one file each.

mod asking;
mod best;
mod check;
mod completion;
mod cost;
mod dossier;
mod finding;
mod identify;
mod improvements;
mod init;
mod inspect;
mod judge;
mod limits;
mod manual;
mod means;
mod merge;
mod pareto;
mod rare;
mod replay;
mod report;
mod robustness;
mod sensitivity;
mod simulate;
pub mod synchronise;
mod table;
mod tolerances;
mod verify;

use std::process::ExitCode;

use thiserror::Error;

use crate::analysis::from_results::FolderError;
use crate::cli::{Cli, Command, Work};
use crate::files::unusable;
use crate::judge::Judge;
use crate::pipeline::Halt;
use crate::report::ReportError;
use crate::results::{ResultsError, Summary};
use crate::session::SessionError;
use crate::study::StudyError;
use crate::study::ssv::SsvError;
use crate::table::TableError;
use conformity::decision::Decision;
use fmu_import::FmuError;
use fmu_points::failure::Failure;
use fmu_points::stop::INTERRUPTED;
use fmu_points::tell as output;
use fmu_points::{Isolation, RunError, worker};

/// The exit code for a mistake in what was asked for.
pub const MISTAKE: u8 = 2;

/// Why a command cannot do what was asked for.
#[derive(Debug, Error)]
pub enum CommandError {
    /// The FMU cannot be used.
    #[error("{}", unusable(.0))]
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
    Engine(#[from] RunError),
    /// The study cannot be run.
    #[error(transparent)]
    Session(#[from] SessionError),
    /// A single simulation failed.
    #[error("the simulation failed: {0}")]
    Simulation(#[from] Failure),
    /// The FMU refused a step of a size that it has not suggested.
    #[error(
        "the simulation failed: {failure}: the step is {step} s, as the FMU suggests none; set another by --step"
    )]
    Step {
        /// The FMU's remarks.
        failure: Failure,
        /// The step, s.
        step: f64,
    },
    /// A search found nothing.
    #[error("the search failed: {0}")]
    Search(String),
    /// Not every point has an outcome.
    #[error(transparent)]
    Halted(#[from] Halt),
    /// Shards cannot be joined.
    #[error("{0}")]
    Shards(String),
    /// An option's value cannot be used.
    #[error("--{option}: {message}")]
    Option {
        /// The option.
        option: &'static str,
        /// The problem.
        message: String,
    },
}

/// Does what the command line says.
///
/// # Errors
/// With one clear line, for a mistake in what was asked for.
pub fn run(cli: Cli) -> Result<ExitCode, CommandError> {
    match dispatch(cli) {
        Err(CommandError::Halted(halt @ Halt::Interrupted { .. })) => {
            fmu_points::tell::line!("{halt}");
            Ok(ExitCode::from(INTERRUPTED))
        }
        Err(CommandError::Halted(halt @ Halt::Shard(_))) => {
            output::print(&format!("{halt}; `orchestrator merge` joins the shards\n"));
            Ok(ExitCode::SUCCESS)
        }
        other => other,
    }
}

fn dispatch(cli: Cli) -> Result<ExitCode, CommandError> {
    match cli.command {
        Command::Inspect(options) => inspect::run(&options),
        Command::Check(options) => check::run(&options),
        Command::Init(options) => init::run(&options),
        Command::Completion(options) => Ok(completion::run(&options)),
        Command::Manual(options) => manual::run(&options),
        Command::Simulate(options) => simulate::run(&options),
        Command::Verify(options) => match options.rare {
            Some(event) => proven(rare::Options::new(options, event), rare::run, |o| {
                &mut o.work
            }),
            None => verify::run(&options),
        },
        Command::Identify(options) => proven(options, identify::run, |o| &mut o.work),
        Command::Judge(options) => judge::run(&options),
        Command::Replay(options) => replay::run(&options),
        Command::Merge(options) => merge::run(&options),
        Command::Probe { setup } => worker::end(check::serve(&setup)),
        Command::Report(options) => report::run(&options),
        Command::Sensitivity(options) => proven(options, sensitivity::run, |o| &mut o.work),
        Command::Robustness(options) => proven(options, robustness::run, |o| &mut o.work),
        Command::Tolerances(options) => proven(options, tolerances::run, |o| &mut o.work),
        Command::Pareto(options) => proven(options, pareto::run, |o| &mut o.work),
        Command::Synchronise(options) => synchronise::run(&options),
    }
}

/// Runs an analysis of which later points depend on earlier ones. Where the processes of these turn out not to be
/// used again, it begins again with each point alone.
fn proven<T>(
    mut options: T,
    run: impl Fn(&T) -> Result<ExitCode, CommandError>,
    work: impl Fn(&mut T) -> &mut Work,
) -> Result<ExitCode, CommandError> {
    match run(&options) {
        Err(CommandError::Halted(Halt::Engine(RunError::Refuted))) => {
            fmu_points::tell::line!(
                "note: the FMU gives other results in a process that has computed points before: all points are \
                 computed again, each alone"
            );
            let work = work(&mut options);
            work.means.isolation = Isolation::Fresh;
            // The journal says which points count no more; the others are kept.
            work.parts.resume = true;
            run(&options)
        }
        other => other,
    }
}

/// 0 when the model is verified, 1 when it is not, 3 when the points do not tell.
fn verdict(summary: &Summary) -> ExitCode {
    exit_code(summary.conclusion.as_ref().map(|found| found.verdict))
}

fn exit_code(verdict: Option<Decision>) -> ExitCode {
    const INCONCLUSIVE: u8 = 3;
    match verdict {
        Some(Decision::Inconclusive) => ExitCode::from(INCONCLUSIVE),
        Some(Decision::Verified) => ExitCode::SUCCESS,
        Some(Decision::NotVerified) | None => ExitCode::FAILURE,
    }
}

/// Says what the user should know of a study that can be used all the same.
fn warn(judge: &Judge) {
    for warning in &judge.warnings {
        fmu_points::tell::line!("warning: {warning}");
    }
}
