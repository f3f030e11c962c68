//! The command line.

use std::process::ExitCode;

use clap::Parser;
use orchestrator::cli::Cli;
use orchestrator::commands;

fn main() -> ExitCode {
    match commands::run(Cli::parse()) {
        Ok(code) => code,
        Err(error) => {
            orchestrator::tell::line!("error: {error}");
            ExitCode::from(commands::MISTAKE)
        }
    }
}
