//! The files of an identification.

use super::optimum;
use crate::error::{Error, Result};
use calibration::{outcome::IdentificationOutcome, text};
use number_tables::csv_file::{self, CsvFile};
use point_journal::files::{write_table, write_text, write_texts};
use std::path::{Path, PathBuf};
use study::{Identification, Study};

/// Writes all files. `fmu` is the FMU that was run.
pub(super) fn write(
    folder: &Path,
    (study, fmu): (&Study, &Path),
    settings: &Identification,
    outcome: &IdentificationOutcome,
    others: &[String],
) -> Result {
    let name = number_tables::files::name(study.path());
    let optima = outcome.optima.len();
    for place in 0..optima {
        let file = folder.join(numbered("optimum", "toml", place, optima));
        let text = if study.criteria.is_empty() {
            text::fixed_section(&name, place, outcome, others)
        } else {
            optimum::study((study, fmu), outcome, (place, others), &file)?
        };
        write_text(&file, text)?;
    }
    for (stem, ending) in [("optimum", "toml"), ("cases", "csv")] {
        remove_others(folder, stem, ending, optima)?;
    }
    for place in 0..optima {
        write_cases(folder, study, settings, outcome, place)?;
    }
    Ok(())
}

/// The name of a file of one optimum: where there are several, none has the plain name.
fn numbered(stem: &str, ending: &str, place: usize, optima: usize) -> String {
    match optima {
        1 => format!("{stem}.{ending}"),
        _ => format!("{stem}-{}.{ending}", place + 1),
    }
}

/// Removes files of an earlier search that found another number of optima: they would be taken for this one's.
fn remove_others(folder: &Path, stem: &str, ending: &str, optima: usize) -> Result {
    if optima != 1 {
        remove(&folder.join(format!("{stem}.{ending}")))?;
    }
    let mut number = if optima == 1 { 1 } else { optima + 1 };
    while folder.join(format!("{stem}-{number}.{ending}")).exists() {
        remove(&folder.join(format!("{stem}-{number}.{ending}")))?;
        number += 1;
    }
    Ok(())
}

pub(super) fn remove(path: &Path) -> Result {
    match std::fs::remove_file(path) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(Error::io(path)(error)),
        _ => Ok(()),
    }
}

/// The table of cases with the latent parameters' most probable values in place of what it had.
fn write_cases(
    folder: &Path,
    study: &Study,
    settings: &Identification,
    outcome: &IdentificationOutcome,
    optimum: usize,
) -> Result {
    let Some(path) = &settings.cases else { return Ok(()) };
    let path = resolve(study, path.as_ref());
    let mut table = CsvFile::open(&path, Some(b'#'))?;
    let header = table.header()?;
    let places: Vec<Option<usize>> = settings
        .latent
        .values()
        .map(|latent| header.iter().position(|name| Some(name) == latent.column.as_ref()))
        .collect();
    let (mut rows, mut row) = (Vec::new(), csv::StringRecord::new());
    for case in &outcome.optima[optimum].latents {
        if !table.row(&mut row)? {
            break;
        }
        let mut cells: Vec<String> = row.iter().map(|cell| csv_file::text(cell).into_owned()).collect();
        for (place, latent) in places.iter().zip(case) {
            if let Some(cell) = place.and_then(|place| cells.get_mut(place)) {
                *cell = text::digits(latent.value).to_string();
            }
        }
        rows.push(cells);
    }
    let file = numbered("cases", "csv", optimum, outcome.optima.len());
    Ok(write_table(&folder.join(file), &header, |table| rows.iter().try_for_each(|row| write_texts(table, row)))?)
}

/// A path that the study gives relative to itself.
pub(super) fn resolve(study: &Study, path: &Path) -> PathBuf {
    study.path().parent().unwrap_or("".as_ref()).join(path)
}
