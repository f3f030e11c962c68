//! The files of an identification.

use crate::error::{Error, Result};
use calibration::{outcome::IdentificationOutcome, text};
use fmu_import::{quantity::Quantity, units::known};
use fmu_points::names::behind;
use point_journal::files::write_text;
use std::path::{Path, PathBuf};
use study::{
    Study,
    cases::SEPARATOR,
    inputs::{GAIN, OFFSET},
    limit::part,
};

/// Writes all files.
pub(super) fn write(folder: &Path, study: &Study, outcome: &IdentificationOutcome, others: &[String]) -> Result {
    let name = number_tables::files::name(study.path());
    let optima = outcome.optima.len();
    for place in 0..optima {
        let section = text::fixed_section(&name, place, outcome, others) + &offsets(study, outcome, place);
        write_text(&folder.join(numbered(place, optima)), section)?;
    }
    remove_others(folder, optima)
}

/// The offsets and gains of recorded inputs that the search found, with what is left of their uncertainty, as keys of these inputs.
fn offsets(study: &Study, outcome: &IdentificationOutcome, place: usize) -> String {
    let cases = study.by_case();
    let (mut section, mut begun) = (String::new(), "");
    for free in outcome.optima.get(place).iter().flat_map(|optimum| &optimum.free) {
        let Some((path, what)) = free.name.rsplit_once('/') else { continue };
        if ![OFFSET, GAIN].contains(&what) {
            continue;
        }
        // The first case that has the input says what was taken off before the search.
        let stated = cases.iter().find_map(|(case, of_case)| {
            let own = case.and_then(|case| path.strip_prefix(case.name.as_ref().as_str())?.strip_prefix(SEPARATOR));
            let key = own.unwrap_or(path);
            of_case
                .inputs
                .iter()
                .find(|(name, _)| name.as_ref().as_str() == key)
                .map(|(_, text)| (key, own.is_some(), text))
        });
        let Some((key, of_case, text)) = stated else { continue };
        let unit = free.unit.as_deref().unwrap_or("1");
        let in_unit = |stated: &Quantity| match &stated.unit {
            Some(own) if own != unit => known::between(own, unit).map(|way| way.difference(stated.number)),
            _ => Some(stated.number),
        };
        let gain = text.gain.as_ref().and_then(part).unwrap_or(0.0);
        let before = text.offset.as_ref().map_or(Some(0.0), in_unit);
        if let (OFFSET, None, Some(stated)) = (what, before, &text.offset) {
            section += &format!("# to be added to the stated offset of {stated}:\n");
        }
        // One after the other they are taken off the recording.
        let (found, uncertainty) = match what {
            GAIN => (100.0 * gain + (1.0 + gain) * free.value, "gain-uncertainty"),
            _ => (before.unwrap_or(0.0) + (1.0 + gain) * free.value, "uncertainty"),
        };
        let unit = behind(Some(unit).filter(|unit| *unit != "1"));
        let half = (free.interval[1] - free.interval[0]) / 2.0;
        if of_case && begun != path {
            section += &format!(
                "# of the case {} alone:\n",
                path.strip_suffix(key).unwrap_or(path).trim_end_matches(SEPARATOR)
            );
        }
        if begun != path {
            section += &format!("[inputs.\"{key}\"]  # beside its `file`\n");
        }
        begun = path;
        section += &format!("{what} = \"{}{unit}\"\n", text::digits(found));
        section += &format!("{uncertainty} = \"{}{unit}\"\n", text::digits(half));
    }
    match section.as_str() {
        "" => section,
        _ => format!(
            "\n# The recorded inputs read too high by `offset` and `gain`; the values above hold with these alone.\n{section}"
        ),
    }
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

pub(super) fn remove(path: &Path) -> Result {
    match std::fs::remove_file(path) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(Error::io(path)(error)),
        _ => Ok(()),
    }
}

/// A path that the study gives relative to itself.
pub(super) fn resolve(study: &Study, path: &Path) -> PathBuf {
    study.path().parent().unwrap_or("".as_ref()).join(path)
}
