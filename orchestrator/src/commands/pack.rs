//! `pack`, and `verify` of what it has packed.

use std::{fs, path::Path, process::ExitCode};

use super::{gate, output, verify};
use crate::{
    cli::{Pack, Verify},
    compare::{compare, write},
    error::{Error, Result},
    junit::{Test, TestOutcome},
    options::folder_of,
    packed::{altered, changed, choose, digests, pack, settle},
    results::table,
    session::Request,
};
use fmu_import::Package;
use point_journal::Lock;
use study::Study;

/// Where the carried study lies beside the new results.
const CARRIED: &str = "carried";

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
            verify::run(&own).map_err(|error| {
                match error.to_string().split_once(';') {
                    // Its options are those of `verify`.
                    Some((what, remedy)) if remedy.contains("--force") => {
                        Error::Refused(format!("{what}; verify the study into another folder, and name that by --from"))
                    }
                    _ => error,
                }
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
    let from = &summary.provenance;
    if from.study_sha256 != study.digest() {
        return refuse("study, or of its earlier text");
    }
    // Another FMU may be the same model that carries a study already.
    let mut own = study.open_fmu(None)?;
    let same = digests(&mut own)? == digests(&mut package)?;
    let verified = if same { &own } else { &package };
    let then = from.fmu_sha256.as_deref();
    if then != Some(&package.digest()?) && then != Some(&verified.digest()?) {
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

/// Whether a file is an FMU rather than a study: an archive.
pub fn is_fmu(path: &Path) -> bool {
    let is_named = path.extension().is_some_and(|end| end.eq_ignore_ascii_case("fmu"));
    is_named && !fs::metadata(path).is_ok_and(|entry| entry.is_dir())
}

/// `verify MODEL.fmu`: runs the study that the FMU carries, and compares with the result that it carries.
pub fn run_carried(mut options: Verify) -> Result<ExitCode> {
    let fmu = options.work.study.clone();
    let mut package = Package::open(&fmu)?;
    let (carried, others) = choose(&mut package, options.carried.as_deref())?;
    let name = &carried.name;
    // Two FMUs may carry studies of one name, and `pack` has the study's own results in a folder of this name.
    let folder = options
        .work
        .output
        .clone()
        .unwrap_or_else(|| Path::new("results").join(fmu.file_name().unwrap_or_default()).join(name));
    let place = folder.join(CARRIED);
    let earlier = options.work.resuming.earlier();
    let aside = settle(&mut package, &carried, &place, |study| {
        let fmu = options.work.means.fmu.as_ref().unwrap_or(&fmu).clone();
        let request = Request { study: place.join(&carried.ties.study), fmu: Some(fmu), ..Request::default() };
        request.check(&folder, None, Some(study), earlier)?;
        request.check_files(&folder, earlier)?;
        Ok(if options.dry_run { None } else { Some(Lock::take(&folder)?) })
    })?;
    let place = aside.as_ref().map_or(place, |aside| aside.path().to_owned());
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
    let is_as_packed = doubts.iter().all(|(.., found)| found.is_empty());
    let ties = carried.ties;
    options.work.study = place.join(&ties.study);
    options.work.output = Some(folder.clone());
    options.work.means.fmu.get_or_insert(fmu);
    if options.points_from.is_none() {
        options.points = options.points.or(ties.points);
        options.seed = options.seed.or(ties.seed);
        options.points_from = ties.points_from.map(|table| place.join(table));
    }
    options.validation |= ties.validation;
    let file = options.gate.junit.take();
    let code = verify::run(&options)?;
    if options.dry_run || options.shards.chosen()?.is_some() {
        return Ok(code);
    }
    let results = place.join("results");
    let mut comparison = compare(&results, &folder)?;
    comparison.as_packed = is_as_packed;
    let strict = options.gate.strict;
    let of_files = doubts.iter().map(|(name, _, found)| {
        let outcome = if found.is_empty() { TestOutcome::Passed } else { TestOutcome::doubt(strict, found.join("; ")) };
        Test::new("compare", name, outcome)
    });
    let tests: Vec<Test> = of_files.chain(comparison.tests(true)).collect();
    write(&comparison, &folder)?;
    let met = comparison.same && comparison.warnings.is_empty();
    let mut text =
        format!("\nThe study {name}, which the FMU carries, against its result: {}\n", comparison.headline());
    if met {
        text += &format!("The carried result is met again: {}.\n", comparison.verdict());
    }
    for (_, about, found) in &doubts {
        text.extend(found.iter().map(|what| format!("warning: {about}: {what}\n")));
    }
    if !others.is_empty() {
        text += &format!("It also carries {}: --study NAME runs another one.\n", others.join(", "));
    }
    output::print(&(text + &comparison.document().as_text()));
    if let Some(file) = file {
        let summary = table::summary(&folder)?;
        let tests = [gate::tests(&summary, strict), tests].concat();
        gate::write(&file, &summary, &tests)?;
    }
    Ok(if met && (is_as_packed || !strict) { code } else { ExitCode::FAILURE })
}
