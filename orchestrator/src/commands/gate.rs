//! A verdict for a build server: its exit code, and its tests as JUnit XML.

use std::{path::Path, process::ExitCode};

use super::{output, table};
use crate::{
    cli::Gate,
    error::Result,
    junit::{self, Test, TestOutcome},
    methods::asking::exit_code,
    results::{FEWEST, Summary, summary::Count},
};
use conformity::{
    conclusion::{Conclusion, grouped},
    decision::Decision,
};
use indexmap::IndexMap;

/// Prints what came out, and gives the verdict's exit code. Writes its tests where they are wanted.
pub fn verdict(summary: &Summary, folder: Option<&Path>, (gate, verbose): (&Gate, bool)) -> Result<ExitCode> {
    output::print(&table::told(summary, folder, verbose));
    if let Some(file) = &gate.junit {
        write(file, summary, &tests(summary, gate.strict))?;
    }
    let conclusion = summary.conclusion.as_ref();
    let verdict = conclusion.map(|conclusion| conclusion.verdict);
    let doubts = summary.warnings().count();
    if gate.strict && verdict == Some(Decision::Verified) && doubts > 0 {
        output::line!("note: exit code 1, since --strict allows for no warning (found: {doubts})");
        return Ok(ExitCode::FAILURE);
    }
    if let Some(few) = few(summary).filter(|_| gate.strict) {
        output::line!("note: exit code 1, since --strict is given, and {few}");
        return Ok(ExitCode::FAILURE);
    }
    Ok(exit_code(verdict))
}

/// That the points of a design that verify a model are so few that hardly any doubt could show.
fn few(summary: &Summary) -> Option<String> {
    let is_drawn =
        !summary.parameters.is_empty() && summary.provenance.method != "table" && summary.surrogate.is_none();
    let is_few = is_drawn && summary.points < FEWEST && summary.decision() == Decision::Verified;
    is_few.then(|| format!("fewer than {FEWEST} points show no doubt: run more"))
}

/// Writes tests of a study into a file, as a suite of its name.
///
/// # Errors
/// When the file cannot be written.
pub fn write(file: &Path, summary: &Summary, tests: &[Test]) -> Result {
    let seconds = summary.run.as_ref().map_or(0.0, |run| run.wall_seconds);
    junit::write(file, &name(summary), tests, seconds)
}

/// The study's name.
fn name(summary: &Summary) -> String {
    let stem = Path::new(&summary.provenance.study).file_stem();
    stem.map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default()
}

/// The verdict, each criterion, each case, and each warning as a test. A criterion that no point meets, or fewer than the
/// required share, fails: with it the model cannot be verified.
pub fn tests(summary: &Summary, strict: bool) -> Vec<Test> {
    let study = name(summary);
    let whole = summary.conclusion.as_ref().map_or_else(
        || TestOutcome::Failed("there is no verdict".to_owned()),
        |Conclusion { verdict, verdict_words, .. }| match verdict {
            Decision::Verified => TestOutcome::Passed,
            Decision::NotVerified => TestOutcome::Failed(verdict_words.clone()),
            Decision::Inconclusive => TestOutcome::Undecided(verdict_words.clone()),
        },
    );
    let required = summary.required();
    let counted = |what: &str, count: &Count| {
        let least = required.map_or(0.0, |required| required.rule.share);
        TestOutcome::of(count.passed > 0 && count.fraction >= least, || {
            let (passed, points) = (grouped(count.passed), grouped(summary.points));
            let wanted = match required {
                Some(_) => format!(", {} % of them are required", 100.0 * least),
                None => String::new(),
            };
            format!("{what}: {passed} of {points} points meet it{wanted}")
        })
    };
    let criteria = summary.criteria.iter().map(|(name, entry)| {
        let case = name.split_once('/');
        let case = case.filter(|(case, _)| summary.cases.contains_key(*case));
        let outcome = counted(&entry.criterion.wanted(), &entry.count);
        match case {
            Some((case, inner)) => Test::new(&format!("{study}.{case}"), inner, outcome),
            None => Test::new(&study, name, outcome),
        }
    });
    let cases = summary.cases.iter().map(|(name, case)| {
        Test::new(&format!("{study}.{name}"), "all criteria", counted("all criteria of the case", &case.count))
    });
    let mut named: IndexMap<String, usize> = IndexMap::new();
    let doubts = summary.warnings().map(|concern| {
        let text = concern.to_string();
        let count = named.entry(concern.code.name()).or_insert(0);
        *count += 1;
        let name = match count {
            1 => concern.code.name(),
            number => format!("{} {number}", concern.code.name()),
        };
        let outcome = if strict { TestOutcome::Failed(text) } else { TestOutcome::Skipped(format!("warning: {text}")) };
        Test::new(&format!("{study}.warnings"), &name, outcome)
    });
    let few = few(summary).filter(|_| strict);
    let few = few.map(|few| Test::new(&format!("{study}.warnings"), "few-points", TestOutcome::Failed(few)));
    let verdict = Test::new(&study, "verdict", whole);
    [verdict].into_iter().chain(criteria).chain(cases).chain(doubts).chain(few).collect()
}
