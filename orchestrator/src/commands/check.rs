//! `check`: looks at an FMU before it is used.

use std::process::ExitCode;
use std::time::Duration;

use fmu_check::{CheckError, Severity, check};

use super::output;
use crate::cli::{Check, Format};
use crate::error::Error;

pub(super) fn run(options: &Check) -> Result<ExitCode, Error> {
    let patience = Duration::try_from_secs_f64(options.patience).unwrap_or(Duration::MAX);
    let findings = check(&options.fmu, patience).map_err(|error| match error {
        CheckError::Fmu(error) => Error::from(error),
        CheckError::Scratch(error) => Error::from(error),
        CheckError::Io { path, source } => Error::io(&path)(source),
    })?;
    output::print(&match options.format {
        Format::Text => findings.text(),
        Format::Json => findings.json(),
        Format::Sarif => findings.sarif("orchestrator check"),
    });
    let enough = match options.strict {
        true => Severity::Warning,
        false => Severity::Error,
    };
    Ok(match findings.worst() {
        Some(severity) if severity >= enough => ExitCode::FAILURE,
        _ => ExitCode::SUCCESS,
    })
}
