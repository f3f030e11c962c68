//! `manual`: manual pages of the program and of its commands.

use std::process::ExitCode;

use clap::CommandFactory;

use super::CommandError;
use crate::cli::{Cli, Manual};
use crate::results::{ResultsError, make_folder};

pub(super) fn run(options: &Manual) -> Result<ExitCode, CommandError> {
    let folder = &options.folder;
    make_folder(folder)?;
    clap_mangen::generate_to(Cli::command(), folder).map_err(ResultsError::io(folder))?;
    Ok(ExitCode::SUCCESS)
}
