//! The files of an identification.

use super::optimum;
use crate::{
    error::{Error, Result},
    identify::bind::Bound,
};
use calibration::{outcome::IdentificationOutcome, text};
use point_journal::files::write_text;
use std::path::Path;
use study::Study;

/// Writes all files. `fmu` is the FMU that was run.
pub fn write(folder: &Path, (study, fmu): (&Study, &Path), outcome: &IdentificationOutcome, bound: &Bound) -> Result {
    let name = number_tables::files::name(study.path());
    let optima = outcome.optima.len();
    for place in 0..optima {
        let file = folder.join(numbered(place, optima));
        let text = if study.criteria.is_empty() {
            text::fixed_section(&name, place, outcome, &bound.others())
        } else {
            optimum::study((study, fmu), outcome, (place, bound), &file)?
        };
        write_text(&file, text)?;
    }
    remove_others(folder, optima)
}

/// The name of a file of one optimum: where there are several, none has the plain name.
fn numbered(place: usize, optima: usize) -> String {
    match optima {
        1 => "optimum.toml".to_owned(),
        _ => format!("optimum-{}.toml", place + 1),
    }
}

/// Removes files of an earlier search that found another number of optima: they would be taken for this one's.
fn remove_others(folder: &Path, optima: usize) -> Result {
    if optima != 1 {
        remove(&folder.join(numbered(0, 1)))?;
    }
    let mut number = if optima == 1 { 0 } else { optima };
    while folder.join(numbered(number, 2)).exists() {
        remove(&folder.join(numbered(number, 2)))?;
        number += 1;
    }
    Ok(())
}

pub fn remove(path: &Path) -> Result {
    match std::fs::remove_file(path) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(Error::io(path)(error)),
        _ => Ok(()),
    }
}
