//! The commands, one file each; those of the methods are in [`methods`](crate::methods).

mod best;
mod carried;
mod check;
mod compare;
mod completion;
mod cost;
mod dear;
mod gate;
mod init;
mod inspect;
mod isolated;
mod judge;
mod manual;
mod merge;
mod pack;
mod replay;
mod report;
mod simulate;
mod synchronise;
mod table;
mod verify;

use std::{ffi::OsString, path::Path, process::ExitCode};

use crate::{
    cli::{Cli, Command},
    error::{Error, Result},
    junit::{self, Test, TestOutcome},
    methods::{Method, asking::Delivery, rare},
    report::Report,
};
use conformity::decision::Decision;
use fmu_points::{stop::INTERRUPTED, tell as output};
use point_journal::{Error as Halt, files::write_json};

/// The exit code for a mistake in what was asked for.
pub const MISTAKE: u8 = 2;

/// Does what the command line says.
///
/// # Errors
/// With one clear line, for a mistake in what was asked for.
pub fn run(cli: Cli) -> Result<ExitCode> {
    let junit = cli.command.junit().map(Path::to_owned);
    // A run that is killed writes nothing more.
    if let Some(file) = &junit {
        note_mistake(file, "the run did not end".to_owned());
    }
    let done = dispatch(cli);
    if let (Err(error), Some(file)) = (&done, junit) {
        note_mistake(&file, error.to_string());
    }
    match done {
        Err(Error::Journal(halt @ Halt::Interrupted { .. })) => {
            output::line!("{halt}");
            Ok(ExitCode::from(INTERRUPTED))
        }
        other => other,
    }
}

/// Writes a mistake into the file of the tests, as that of an earlier run must not stand for this one.
fn note_mistake(file: &Path, mistake: String) {
    let test = Test::new("orchestrator", "run", TestOutcome::Broken(mistake));
    junit::write(file, "orchestrator", &[test], 0.0)
        .unwrap_or_else(|error| left_out("the tests are in no file", &error));
}

/// The same for a command line that cannot be read: the word after `--junit` is the file.
pub fn note_misread(mistake: &str) {
    let words: Vec<OsString> = std::env::args_os().collect();
    let place = words.iter().position(|word| word == "--junit");
    if let Some(file) = place.and_then(|place| words.get(place + 1)) {
        note_mistake(file.as_ref(), mistake.to_owned());
    }
}

fn dispatch(cli: Cli) -> Result<ExitCode> {
    match cli.command {
        Command::Inspect(options) => inspect::run(&options),
        Command::Check(options) => check::run(&options),
        Command::Init(options) => init::run(&options),
        Command::Completion(options) => Ok(completion::run(&options)),
        Command::Manual(options) => manual::run(&options),
        Command::Simulate(options) => simulate::run(&options),
        Command::Verify(options) => match options.rare {
            Some(event) => deliver(rare::run(&options.rare(event))?),
            None if carried::is_fmu(&options.work.study) => carried::run(*options),
            None => match options.budget {
                Some(runs) => dear::run(&options, runs),
                None => verify::run(&options),
            },
        },
        Command::Pack(options) => pack::run(&options),
        Command::Judge(options) => judge::run(&options),
        Command::Replay(options) => replay::run(&options),
        Command::Merge(options) => merge::run(&options),
        Command::Compare(options) => compare::run(&options),
        Command::Report(options) => report::run(&options),
        Command::Method(Method::Sensitivity(options)) if options.budget.is_some() => {
            let runs = options.budget.unwrap_or_default();
            deliver(dear::sensitivity(options, runs)?)
        }
        Command::Method(method) => deliver(method.run()?),
        Command::Synchronise(options) => synchronise::run(&options),
    }
}

/// Delivers the result of a method: to its file, to the terminal, and to the page of a finished study in the same folder,
/// where it belongs to that study.
fn deliver(delivery: Delivery) -> Result<ExitCode> {
    let Delivery { result, folder, .. } = &delivery;
    result.write(folder)?;
    if folder.join("summary.json").exists() {
        let mut summary = crate::results::table::summary(folder)?;
        let fits = result.origin.fits(&summary);
        if fits && !result.causes.is_empty() && summary.decision() == Decision::NotVerified {
            summary.causes.clone_from(&result.causes);
            write_json(&folder.join("summary.json"), &summary)?;
        }
        Report::from_folder(folder)?.write(folder)?;
        if !fits {
            let page = folder.join("report.html");
            output::line!(
                "note: {} tells of another study or its earlier text, so it does not show this",
                page.display()
            );
        }
    }
    let text = &result.text;
    output::print(&format!("{text}\nresults in {}\n", folder.display()));
    Ok(result.code)
}

/// Writes the page of a verdict, which is known and written: what fails here costs itself alone.
fn complete(folder: &Path) {
    Report::from_folder(folder)
        .and_then(|report| report.write(folder))
        .map_or_else(|error| left_out("there is no page", &error), drop);
}

fn left_out(what: &str, error: &dyn std::error::Error) {
    output::line!("note: {what}: {error}");
}
