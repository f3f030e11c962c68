//! `judge`: applies a study's criteria to outputs that already stand in a table.

use std::{collections::HashSet, path::Path, process::ExitCode, time::Instant};

use super::{complete, gate};
use crate::{
    cli,
    error::Result,
    methods::asking::warn,
    results::{
        concerns,
        summary::{Provenance, Run},
        survey::Survey,
        tally::{Sample, Tally},
    },
    session::{FileSet, Request, provenance},
};
use fmu_import::{Description, Package, quantity::Scale, units::Conversion};
use fmu_points::failure::{Failure, Partial};
use number_tables::Table;
use point_journal::{Lock, files::write_text, lines, pipeline::folder::Earlier};
use study::{Study, judge::Judge};

pub fn run(options: &cli::Judge) -> Result<ExitCode> {
    let begun = Instant::now();
    let study = Study::read(&options.study)?;
    // The FMU only helps to convert units; without it the table must be in the study's.
    let package = study.open_fmu(None).ok();
    let fmu = package.as_ref().map(Package::description);
    let judge = Judge::new(&study, fmu)?;
    warn(&judge);
    let conversions = conversions(&study, &judge, fmu)?;
    let mut rows = Table::read_results(&options.table, &columns(&study))?;
    // The rows of a table need not be in the order of the points, so that nobody knows which belong to one net.
    let mut tally = Tally::new(&judge, Sample::of(&study, rows.rows.len() as u64, 1));
    let mut survey = Survey::new(&judge, None);
    let (mut seen, mut repeated) = (HashSet::new(), 0);
    let folder = options.output.as_deref();
    let _lock = folder.map(|folder| take(options, &study, folder)).transpose()?;
    let mut files = folder.map(|folder| FileSet::new(folder, &[], &judge)).transpose()?;
    for (row, &label) in rows.rows.iter_mut().zip(&rows.labels) {
        for (value, conversion) in row.iter_mut().zip(&conversions) {
            *value = conversion.value(*value);
        }
        let missing = row.iter().position(|value| !value.is_finite());
        if missing.is_none() && concerns::is_telling(row) {
            let digits = row.iter().map(|value| value.to_bits());
            repeated += u64::from(!seen.insert(digits.collect::<Vec<u64>>()));
        }
        let outcome = match missing {
            None => Ok(std::mem::take(row)),
            Some(k) => Err(Failure::NotFinite(Partial::new(
                if judge.cases.is_empty() { &judge.criteria[k].variable } else { &judge.criteria[k].name },
                row,
            ))),
        };
        let verdict = tally.add(label, &[], &outcome, None);
        survey.add(&[], &outcome, false);
        if let Some(files) = &mut files {
            files.write(label, &[], &outcome, &verdict)?;
        }
    }
    let provenance = Provenance { method: "table".to_owned(), ..provenance(&study) };
    let mut summary = tally.summary(study.title.clone(), provenance, Vec::new());
    survey.complete(&mut summary);
    summary.concerns.extend(concerns::repeated(repeated, tally.points));
    summary.dossier = study.dossier.clone();
    summary.run = Some(Run::since(begun, 0, 0));
    if let Some(files) = files {
        files.finish(&summary)?;
    }
    if let Some(folder) = folder {
        write_text(&folder.join("study.toml"), study.text())?;
        complete(folder);
    }
    gate::verdict(&summary, folder, (&options.gate, options.verbose))
}

/// Takes the folder for the results. It keeps the request, unless it holds that of a run of the same study.
fn take(options: &cli::Judge, study: &Study, folder: &Path) -> Result<Lock> {
    let request =
        Request { study: options.study.clone(), points_from: Some(options.table.clone()), ..Request::default() };
    let earlier = if options.force { Earlier::Replaced } else { Earlier::Complete };
    request.check(folder, None, None, earlier)?;
    request.check_files(folder, earlier)?;
    let lock = Lock::take(folder)?;
    if options.force || !lines::path_in(folder).exists() {
        request.write(folder, study)?;
    }
    Ok(lock)
}

/// The columns of the criteria: the study's mapping, the criterion's name, or the variable's. Those of cases are told
/// apart by their names, `CASE/NAME`, or by a mapping that no other criterion has.
fn columns(study: &Study) -> Vec<(Vec<String>, String)> {
    let is_shared = |column: &String| {
        let all = study.criteria.values();
        all.filter(|other| other.column.as_ref() == Some(column)).count() > 1
    };
    let names = study.criteria.iter().map(|(name, criterion)| {
        let in_case = criterion.case.is_some();
        let mapped = criterion.column.clone().filter(|column| !(in_case && is_shared(column)));
        let usual = [name.as_ref().clone(), criterion.variable.as_ref().clone()];
        // A table has no room for curves: its column holds the metric's value, not the variable's.
        let only_named = criterion.reference.is_some() || in_case;
        let usual = usual.into_iter().take(if only_named { 1 } else { 2 });
        let names = mapped.into_iter().chain(usual).collect();
        (names, format!("the criterion {}", name.as_ref()))
    });
    names.collect()
}

/// From each column's unit to the criterion's.
fn conversions(study: &Study, judge: &Judge, fmu: Option<&Description>) -> Result<Vec<Conversion>> {
    let pairs = study.criteria.iter().zip(&judge.criteria);
    let conversion = |(name, text): (&study::Name, &study::CriterionText), unit| {
        let Some(column_unit) = text.column_unit.as_deref() else { return Ok(Conversion::IDENTITY) };
        let variable = fmu.and_then(|fmu| fmu.variables.get(text.variable.as_ref().as_str()));
        let scale = match (fmu, variable) {
            (Some(fmu), Some(variable)) => Scale::new(unit, fmu, variable),
            _ => Ok(Scale::alone(unit)),
        };
        let conversion = scale.and_then(|scale| scale.from(column_unit));
        conversion
            .map(|conversion| match text.reference {
                Some(_) => conversion.of_differences(),
                None => conversion,
            })
            .map_err(|message| study.error_at(name, message).into())
    };
    pairs.map(|(entry, criterion)| conversion(entry, criterion.unit.as_deref())).collect()
}
