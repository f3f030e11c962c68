//! `check`: looks at an FMU before it is used.

use std::{
    fs,
    path::Path,
    process::ExitCode,
    time::{Duration, Instant},
};

use fmu_check::{CheckError, Conditions, Findings, RULES, Severity, check};
use fmu_import::{Package, Value};
use fmu_points::names::{did_you_mean, nearest};
use serde::Deserialize;

use super::{output, simulate};
use crate::{
    cli::{Check, Format},
    error::{Error, Result},
    junit::{self, Test, TestOutcome},
};

/// The findings that are known.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct KnownFindings {
    #[serde(default)]
    ignore: Vec<Entry>,
}

/// Findings of a rule that are known, and why they are accepted.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    rule: String,
    variable: Option<String>,
    #[serde(default)]
    reason: String,
}

pub fn run(options: &Check) -> Result<ExitCode> {
    let begun = Instant::now();
    let known = options.ignore.as_deref().map(known).transpose()?;
    let patience = Duration::try_from_secs_f64(options.patience).unwrap_or(Duration::MAX);
    let conditions = Conditions { patience, step: options.step, set: start_values(options)? };
    let mut findings = check(&options.fmu, &conditions).map_err(|error| match error {
        CheckError::Fmu(error) => Error::from(error),
        CheckError::Scratch(error) => Error::from(error),
        CheckError::Io { path, source } => Error::io(&path)(source),
    })?;
    for Entry { rule, variable, reason } in known.iter().flat_map(|known| &known.ignore) {
        if findings.ignore(rule, variable.as_deref(), reason) == 0 {
            let of = variable.as_ref().map(|name| format!(" of {name}")).unwrap_or_default();
            output::line!("note: no finding of the rule {rule}{of} is left to ignore: remove the entry");
        }
    }
    output::print(&match options.format {
        Format::Text => findings.text(),
        Format::Json => findings.json(),
        Format::Sarif => findings.sarif("orchestrator check"),
    });
    let enough = if options.gate.strict { Severity::Warning } else { Severity::Error };
    if let Some(file) = &options.gate.junit {
        junit::write(file, "check", &tests(&findings, enough), begun.elapsed().as_secs_f64())?;
    }
    Ok(match findings.worst() {
        Some(severity) if severity >= enough => ExitCode::FAILURE,
        _ => ExitCode::SUCCESS,
    })
}

/// The start values that the user gives.
fn start_values(options: &Check) -> Result<Vec<(u32, Value)>> {
    if options.step.is_some_and(|step| !(step > 0.0 && step.is_finite())) {
        return Err(Error::option("step", "it must be a positive, finite number of seconds"));
    }
    if options.set.is_empty() {
        return Ok(Vec::new());
    }
    let mut package = Package::open(&options.fmu)?;
    let sizes = package.description().sizes.clone();
    let values = simulate::settings(&options.set, &mut package)?;
    if package.description().sizes == sizes {
        Ok(values)
    } else {
        Err(Error::option("set", "check leaves the sizes of arrays as they are"))
    }
}

/// Reads the findings that are known.
fn known(path: &Path) -> Result<KnownFindings> {
    let text = fs::read_to_string(path).map_err(Error::io(path))?;
    let known: KnownFindings = toml::from_str(&text).map_err(|error| {
        let line = error.span().map_or(1, |span| text[..span.start].lines().count());
        Error::content(path, format!("line {}: {}", line.max(1), error.message()))
    })?;
    for Entry { rule, reason, .. } in &known.ignore {
        if RULES.iter().all(|known| known.id != rule) {
            let suggestion = did_you_mean(nearest(rule, RULES.iter().map(|rule| rule.id)));
            return Err(Error::content(
                path,
                format!("there is no rule `{rule}`{suggestion}; --format json names them"),
            ));
        }
        if reason.trim().is_empty() {
            return Err(Error::content(path, format!("`{rule}` has no reason: say why its findings are accepted")));
        }
    }
    Ok(known)
}

/// A test for the FMU as a whole, and one a finding.
fn tests(findings: &Findings, enough: Severity) -> Vec<Test> {
    let fmu = findings.fmu.file_stem().unwrap_or_default().to_string_lossy();
    let count = findings.all.iter().filter(|finding| finding.rule.severity >= enough).count();
    let whole = TestOutcome::of(count == 0, || format!("{count} findings of severity {} or worse", enough.word()));
    let found = findings.all.iter().map(|finding| {
        let (severity, text) = (finding.rule.severity, finding.hit.full());
        let text = format!("{}: {text} [{}]", severity.word(), finding.rule.source);
        (finding, TestOutcome::doubt(severity >= enough, text))
    });
    let known = findings
        .ignored
        .iter()
        .map(|(finding, reason)| (finding, TestOutcome::Skipped(format!("known: {reason} ({})", finding.hit.full()))));
    let each = found.chain(known).map(|(finding, outcome)| {
        let name = format!("{}: {}", finding.rule.id, finding.hit.text);
        Test::new(&format!("{fmu}.check"), &name, outcome)
    });
    [Test::new(&fmu, "check", whole)].into_iter().chain(each).collect()
}
