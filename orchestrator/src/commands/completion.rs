//! `completion`: the completion script of a shell.

use std::process::ExitCode;

use clap::CommandFactory;

use super::output;
use crate::cli::{Cli, Completion};

pub fn run(options: &Completion) -> ExitCode {
    let mut script = Vec::new();
    clap_complete::generate(options.shell, &mut Cli::command(), "orchestrator", &mut script);
    output::print(&String::from_utf8_lossy(&script));
    ExitCode::SUCCESS
}
