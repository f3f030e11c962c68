//! Checks an FMU and prints the findings: `cargo run -p fmu-check --example check -- model.fmu`.

use std::error::Error;
use std::path::Path;
use std::process::ExitCode;

use fmu_check::{Conditions, Severity, check};

fn main() -> Result<ExitCode, Box<dyn Error>> {
    fmu_check::serve_if_probe();
    let fmu = std::env::args_os().nth(1).ok_or("which FMU?")?;
    let findings = check(Path::new(&fmu), &Conditions::default())?;
    for finding in &findings.all {
        println!("{:?}: {}", finding.rule.severity, finding.hit.full());
    }
    println!("{} errors", findings.count(Severity::Error));
    Ok(match findings.worst() {
        Some(Severity::Error) => ExitCode::FAILURE,
        _ => ExitCode::SUCCESS,
    })
}
