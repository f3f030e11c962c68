//! The command line.

use std::process::ExitCode;

use orchestrator::{cli, commands};

fn main() -> ExitCode {
    fmu_check::serve_if_probe();
    fmu_points::system::give_back_memory();
    fmu_points::system::survive_large_files();
    let _ = fmu_points::stop::WAY_ON.set("; --resume goes on");
    let said = cli::parse().map(commands::run);
    let error = match said {
        Ok(Ok(code)) => return code,
        Ok(Err(error)) => error.to_string(),
        Err(error) => {
            commands::note_misread(&error);
            error
        }
    };
    fmu_points::tell::line!("error: {error}");
    ExitCode::from(commands::MISTAKE)
}
