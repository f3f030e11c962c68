//! `report`: the page that tells the result of a study.

use std::process::ExitCode;

use super::output;
use crate::{cli, error::Result, report::Report};

pub fn run(options: &cli::Report) -> Result<ExitCode> {
    let page = Report::from_folder(&options.folder)?.write(&options.folder)?;
    output::print(&format!("{}\n", page.display()));
    Ok(ExitCode::SUCCESS)
}
