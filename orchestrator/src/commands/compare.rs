//! `compare`: two results of a study, point by point.

use std::process::ExitCode;

use super::output;
use crate::{
    cli,
    compare::{compare, write},
    error::Result,
    junit,
};

pub fn run(options: &cli::Compare) -> Result<ExitCode> {
    let comparison = compare(&options.old, &options.new)?;
    if let Some(folder) = &options.output {
        write(&comparison, folder)?;
    }
    if let Some(file) = &options.gate.junit {
        junit::write(file, "compare", &comparison.tests(options.gate.strict), 0.0)?;
    }
    output::print(&format!("{}\n{}", comparison.headline(), comparison.document().as_text()));
    let fails = !comparison.same || (options.gate.strict && !comparison.warnings.is_empty());
    Ok(if fails { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}
