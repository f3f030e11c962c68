//! The command line: commands and options, as `clap` reads them.

mod fmu;
mod study;

use std::path::{Path, PathBuf};

use clap::{Args, Parser, Subcommand, error::ErrorKind};

use crate::methods::Method;
pub use fmu::{Check, Format, Init, Inspect, Simulate, Synchronise};
use number_tables::files::in_a_line;
pub use study::{Compare, Gate, Judge, Merge, Pack, Replay, Report, Verify};

/// Verifies FMUs of FMI 2.0 and 3.0 against measurements under uncertainty.
#[derive(Debug, Parser)]
#[command(version, about, max_term_width = 100, after_help = EXIT)]
pub struct Cli {
    /// The command.
    #[command(subcommand)]
    pub command: Command,
}

/// Reads the command line. Help and version are printed at once, and end the program.
///
/// # Errors
/// With one line for a mistake in it.
pub fn parse() -> Result<Cli, String> {
    Cli::try_parse().map_err(|error| {
        let is_help = error.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand;
        if is_help || !error.use_stderr() {
            error.exit();
        }
        told(&error.to_string())
    })
}

/// The fault of the command line, on one line and in plain words.
fn told(message: &str) -> String {
    const WORDS: [(&str, &str); 7] = [
        ("number would be zero for non-zero type", "at least 1 is needed"),
        ("invalid digit found in string", "a whole number is needed, not negative"),
        ("number too large to fit in target type", "too large a number"),
        ("invalid float literal", "a number is needed, with a decimal point and without a unit"),
        ("were not provided:", "are missing:"),
        ("tip: a similar", "a similar"),
        ("tip: some similar", "some similar"),
    ];
    let message = message.strip_prefix("error: ").unwrap_or(message);
    // Behind it stand the usage and where to find more.
    let end = ["\n\nUsage:", "\n\nFor more"]
        .map(|end| message.find(end))
        .into_iter()
        .flatten()
        .min()
        .unwrap_or(message.len());
    let parts: Vec<String> =
        message[..end].split("\n\n").map(in_a_line).filter(|part| !part.starts_with("tip: to pass")).collect();
    let line = elsewhere(&parts[0]).unwrap_or_else(|| parts.join("; "));
    let line = line + "; --help shows what there is";
    WORDS.iter().fold(line, |text, (from, to)| text.replace(from, to))
}

/// What clap cannot know of an argument that it does not expect.
fn elsewhere(fault: &str) -> Option<String> {
    /// Options of earlier versions, with what takes their place.
    const GONE: [(&str, &str); 5] = [
        ("-in-process", "it is called `--isolation none` now"),
        ("-shapley", "`sensitivity` with `--budget N` or `--from DIR` tells Shapley effects"),
        ("-surrogate", "`--budget N` takes its place"),
        ("-time-limit", "`--budget N` takes its place"),
        ("-cross-validate", "cases with `held-out = true` take its place"),
    ];
    let option = fault.strip_prefix("unexpected argument '-")?;
    if let Some((name, instead)) = GONE.iter().find(|(name, _)| option.starts_with(&format!("{name}'"))) {
        return Some(format!("unexpected argument '-{name}' found; {instead}"));
    }
    // Clap tells the first letter of a name behind one hyphen.
    let letter = option.split('\'').next().filter(|letter| letter.chars().all(char::is_alphabetic))?;
    let word = std::env::args().find(|word| word.len() > 2 && word.starts_with(&format!("-{letter}")))?;
    Some(format!("unexpected argument '{word}' found; a name of several letters has two hyphens: '-{word}'"))
}

const EXIT: &str = "Exit codes: 0 done (verify, judge, merge: verified), 1 not verified, 2 a mistake in the call or a file, \
    3 inconclusive (by [verdict] in the study, or all points failed), 130 interrupted: --resume goes on.";

/// How `verify`, `judge` and `merge` come to a verdict.
macro_rules! verdict_help {
    ($example:literal) => {
        concat!(
            "Verdict: with [verdict] in the study, its `share` of the sampled space must be accepted; without it, one point \
             that meets all criteria is enough.\n\nExit codes: 0 verified, 1 not verified, 3 inconclusive (by [verdict], \
             or all points failed), 2 a mistake in the call or a file, 130 interrupted.\n\nExample: ",
            $example
        )
    };
}
use verdict_help;

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Shows an FMU: variables, units, capabilities, platforms
    Inspect(Inspect),
    /// Looks for faults in an FMU; exit code 1 when it finds an error
    Check(Check),
    /// Writes a first study of an FMU from its own variables, with comments
    Init(Init),
    /// Simulates an FMU once and writes csv: the time, then the outputs
    Simulate(Simulate),
    /// Simulates a study's points and judges them against the measurement
    Verify(Box<Verify>),
    /// Puts a study with its results into a copy of its FMU; `verify MODEL.fmu` runs it again
    Pack(Pack),
    /// Applies a study's criteria to outputs in a table; its FMU need not exist
    Judge(Judge),
    /// Runs one point of a study again, with its trajectory
    Replay(Replay),
    /// Joins shards; the result is the same as that of one run
    Merge(Merge),
    /// Compares two results of a study, point by point
    Compare(Compare),
    /// Writes the completion script of a shell to standard output
    Completion(Completion),
    /// Writes manual pages into a folder: one of the program and one of each command
    Manual(Manual),
    /// Writes the report of a finished study again
    Report(Report),
    /// A method that asks for points of a study
    #[command(flatten)]
    Method(Method),
    /// Turns measured signals into criteria with their uncertainty
    Synchronise(Synchronise),
}

impl Command {
    /// The file for the outcome as JUnit XML, where one is wanted.
    pub fn junit(&self) -> Option<&Path> {
        let gate = match self {
            Self::Check(options) => &options.gate,
            Self::Verify(options) => &options.gate,
            Self::Judge(options) => &options.gate,
            Self::Merge(options) => &options.gate,
            Self::Compare(options) => &options.gate,
            _ => return None,
        };
        gate.junit.as_deref()
    }
}

/// Options of `completion`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: orchestrator completion bash > ~/.local/share/bash-completion/completions/orchestrator"
)]
pub struct Completion {
    /// The shell
    pub shell: clap_complete::Shell,
}

/// Options of `manual`.
#[derive(Debug, Args)]
#[command(after_help = "Example: orchestrator manual ~/.local/share/man/man1")]
pub struct Manual {
    /// The folder; it is made if it is not there
    pub folder: PathBuf,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mistakes_take_one_line() {
        let said = |line: &str| {
            let error = Cli::try_parse_from(line.split(' ')).unwrap_err();
            told(&error.to_string())
        };
        for (line, message) in [
            ("o verify s --jobs 0", "invalid value '0' for '--jobs <J>': at least 1 is needed"),
            (
                "o verify s --points 1e4",
                "invalid value '1e4' for '--points <N>': a whole number is needed, not negative",
            ),
            (
                "o simulate m --stop 10s",
                "invalid value '10s' for '--stop <T>': a number is needed, with a decimal point and without a unit",
            ),
            ("o verify s --ponits 3", "unexpected argument '--ponits' found; a similar argument exists: '--points'"),
            ("o verify", "the following required arguments are missing: <STUDY>"),
            ("o verfy s", "unrecognized subcommand 'verfy'; a similar subcommand exists: 'verify'"),
            (
                "o verify s --isolation reuse",
                "invalid value 'reuse' for '--isolation <HOW>': it is called `shared` now",
            ),
            (
                "o verify s --in-process",
                "unexpected argument '--in-process' found; it is called `--isolation none` now",
            ),
            (
                "o sensitivity s --shapley 100",
                "unexpected argument '--shapley' found; `sensitivity` with `--budget N` or `--from DIR` tells Shapley effects",
            ),
            ("o verify s --output", "a value is required for '--output <DIR>' but none was supplied"),
        ] {
            assert_eq!(said(line), format!("{message}; --help shows what there is"));
        }
        let negative = Cli::try_parse_from(["o", "verify", "s", "--point-timeout", "-1"]);
        assert!(negative.is_ok(), "the command says what a time must be");
    }
}
