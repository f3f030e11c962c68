//! `verify MODEL.fmu`: runs the study that an FMU carries, and compares with the result that it carries.

use std::{fs, path::Path, process::ExitCode};

use super::{gate, output, verify};
use crate::{
    cli::Verify,
    compare::{Comparison, compare, write},
    error::{Error, Result},
    junit::{Test, TestOutcome},
    packed::{Ties, altered, changed, choose, digests, settle},
    results::table,
    session::Request,
};
use fmu_import::Package;
use point_journal::Lock;

/// Where the carried study lies beside the new results.
const CARRIED: &str = "carried";

/// Whether a file is an FMU rather than a study: an archive.
pub fn is_fmu(path: &Path) -> bool {
    let is_named = path.extension().is_some_and(|end| end.eq_ignore_ascii_case("fmu"));
    is_named && !fs::metadata(path).is_ok_and(|entry| entry.is_dir())
}

/// What should be as it was packed: the test of it, the words that warn, and which files are other ones.
type Doubt = (&'static str, &'static str, Vec<String>);

pub fn run(mut options: Verify) -> Result<ExitCode> {
    if options.budget.is_some() {
        return Err(Error::option("budget", "an FMU's own study has its own points; give a budget to a study's file"));
    }
    let fmu = options.work.study.clone();
    let mut package = Package::open(&fmu)?;
    let (carried, others) = choose(&mut package, options.carried.as_deref())?;
    check_points(&options, &carried.ties)?;
    let name = &carried.name;
    // Two FMUs may carry studies of one name, and `pack` has the study's own results in a folder of this name.
    let folder = options
        .work
        .output
        .clone()
        .unwrap_or_else(|| Path::new("results").join(fmu.file_name().unwrap_or_default()).join(name));
    let wanted = folder.join(CARRIED);
    let earlier = options.work.resuming.earlier();
    let aside = settle(&mut package, &carried, &wanted, |study| {
        let fmu = options.work.means.fmu.as_ref().unwrap_or(&fmu).clone();
        let request = Request { study: wanted.join(&carried.ties.study), fmu: Some(fmu), ..Request::default() };
        request.check(&folder, None, Some(study), earlier)?;
        request.check_files(&folder, earlier)?;
        Ok(if options.dry_run { None } else { Some(Lock::take(&folder)?) })
    })?;
    let place = aside.as_ref().map_or(wanted, |aside| aside.path().to_owned());
    let altered = altered(&mut package, &carried)?;
    let mut tested = match &options.work.means.fmu {
        Some(other) => Package::open(other)?,
        None => package,
    };
    let changed = changed(&carried.ties.files, &digests(&mut tested)?);
    let doubts = [
        ("the FMU is the one that was verified", "not the FMU that was verified", changed),
        ("what the FMU carries is as it was packed", "changed after it was packed", altered),
    ];
    options.work.output = Some(folder.clone());
    options.work.means.fmu.get_or_insert(fmu);
    set(&mut options, carried.ties, &place);
    let file = options.gate.junit.take();
    let code = verify::run(&options)?;
    if options.dry_run || options.shards.chosen()?.is_some() {
        return Ok(code);
    }
    let mut comparison = compare(&place.join("results"), &folder)?;
    comparison.as_packed = doubts.iter().all(|(.., found)| found.is_empty());
    write(&comparison, &folder)?;
    output::print(&text(&comparison, &doubts, name, &others));
    let strict = options.gate.strict;
    if let Some(file) = file {
        let summary = table::summary(&folder)?;
        let tests = [gate::tests(&summary, strict), tests(&comparison, &doubts, strict)].concat();
        gate::write(&file, &summary, &tests)?;
    }
    Ok(if is_met(&comparison) && (comparison.as_packed || !strict) { code } else { ExitCode::FAILURE })
}

/// Refuses other points than those of the table with which a study was run.
fn check_points(options: &Verify, ties: &Ties) -> Result {
    let given = [("points", options.points), ("seed", options.seed)];
    match given.into_iter().find(|(_, given)| given.is_some()) {
        Some((option, _)) if ties.points_from.is_some() => Err(Error::option(
            option,
            "the carried study has a table of points, with which this cannot be used; --points-from takes another table",
        )),
        _ => Ok(()),
    }
}

/// Sets how a study, which lies at `place`, was run, where the user does not say otherwise.
fn set(options: &mut Verify, ties: Ties, place: &Path) {
    options.work.study = place.join(&ties.study);
    if options.points_from.is_none() {
        options.points = options.points.or(ties.points);
        options.seed = options.seed.or(ties.seed);
        options.points_from = ties.points_from.map(|table| place.join(table));
    }
    options.validation |= ties.validation;
}

/// Whether the new result is the carried one.
fn is_met(comparison: &Comparison) -> bool {
    comparison.same && comparison.warnings.is_empty()
}

fn tests(comparison: &Comparison, doubts: &[Doubt], strict: bool) -> Vec<Test> {
    let of_files = doubts.iter().map(|(name, _, found)| {
        let outcome = if found.is_empty() { TestOutcome::Passed } else { TestOutcome::doubt(strict, found.join("; ")) };
        Test::new("compare", name, outcome)
    });
    of_files.chain(comparison.tests(true)).collect()
}

fn text(comparison: &Comparison, doubts: &[Doubt], name: &str, others: &[String]) -> String {
    let mut text =
        format!("\nThe study {name}, which the FMU carries, against its result: {}\n", comparison.headline());
    if is_met(comparison) {
        text += &format!("The carried result is met again: {}.\n", comparison.verdict());
    }
    for (_, about, found) in doubts {
        text.extend(found.iter().map(|what| format!("warning: {about}: {what}\n")));
    }
    if !others.is_empty() {
        text += &format!("It also carries {}: --study NAME runs another one.\n", others.join(", "));
    }
    text + &comparison.document().as_text()
}
