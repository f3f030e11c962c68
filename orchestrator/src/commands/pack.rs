//! `pack`: an FMU that carries a study with its results.

use std::{fs, process::ExitCode};

use super::{output, verify};
use crate::{
    cli::{Pack, Verify},
    error::{Error, Result},
    options::folder_of,
    packed::{digests, pack},
    results::table,
};
use point_journal::Error as Halt;
use study::Study;

/// `pack`: puts a study with its results into a copy of its FMU.
pub fn run(options: &Pack) -> Result<ExitCode> {
    let study = Study::read(&options.study)?;
    check_output(options, &study)?;
    let results = match &options.from {
        Some(folder) => folder.clone(),
        None => {
            let folder = folder_of(&options.study);
            let mut own = Verify::of(&options.study);
            own.validation = true;
            own.work.output = Some(folder.clone());
            own.work.means.fmu.clone_from(&options.fmu);
            // A study that is not verified may be packed, too.
            verify::run(&own).map_err(|error| {
                let what = match error {
                    Error::Taken { what, .. } => what,
                    Error::Journal(Halt::Begun(folder)) => {
                        format!("{} holds a study that has begun already", folder.display())
                    }
                    error => return error,
                };
                // The remedies are options of `verify`.
                Error::Refused(format!("{what}; verify the study into another folder, and name that by --from"))
            })?;
            folder
        }
    };
    let summary = table::summary(&results)?;
    let mut package = study.open_fmu(options.fmu.as_deref())?;
    let refuse = |what: &str| {
        Err(Error::Refused(format!(
            "{} holds results of another {what}; verify {} again, or leave out --from",
            results.display(),
            options.study.display()
        )))
    };
    let provenance = &summary.provenance;
    if provenance.study_sha256 != study.digest() {
        return refuse("study, or of its earlier text");
    }
    // Another FMU may be the same model that carries a study already.
    let mut own = study.open_fmu(None)?;
    let is_same_model = digests(&mut own)? == digests(&mut package)?;
    let verified = if is_same_model { &own } else { &package };
    let fmu_then = provenance.fmu_sha256.as_deref();
    if fmu_then != Some(&package.digest()?) && fmu_then != Some(&verified.digest()?) {
        return refuse("FMU");
    }
    let name = pack(&mut package, &study, &results, &summary, &options.output)?;
    output::print(&format!(
        "{} carries the study {name}: orchestrator verify {} runs it and compares\n",
        options.output.display(),
        options.output.display()
    ));
    Ok(ExitCode::SUCCESS)
}

/// Refuses to replace a file without the user's word, and the study's own FMU with it.
fn check_output(options: &Pack, study: &Study) -> Result {
    let there = fs::canonicalize(&options.output).ok();
    let refuse = |message: &str| Err(Error::option("output", format!("{} {message}", options.output.display())));
    match there {
        Some(there) if fs::canonicalize(study.fmu_path()).is_ok_and(|own| own == there) => {
            refuse("is the study's own FMU; choose another name")
        }
        Some(_) if !options.force => refuse("exists already; choose another name, or replace it with --force"),
        _ => Ok(()),
    }
}
