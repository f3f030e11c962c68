//! The command line.

use std::process::ExitCode;

use orchestrator::{cli, commands};

fn main() -> ExitCode {
    let said = cli::parse().map(commands::run);
    let error = match said {
        Ok(Ok(code)) => return code,
        Ok(Err(error)) => error.to_string(),
        Err(error) => error,
    };
    orchestrator::tell::line!("error: {error}");
    ExitCode::from(commands::MISTAKE)
}
