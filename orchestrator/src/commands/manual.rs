//! `manual`: manual pages of the program and of its commands.

use std::process::ExitCode;

use crate::{
    cli::{Cli, Manual},
    error::{Error, Result},
};
use clap::CommandFactory;
use point_journal::files::make_folder;

pub fn run(options: &Manual) -> Result<ExitCode> {
    let folder = &options.folder;
    make_folder(folder)?;
    clap_mangen::generate_to(Cli::command(), folder).map_err(Error::io(folder))?;
    Ok(ExitCode::SUCCESS)
}
