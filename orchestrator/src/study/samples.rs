//! Parameters that come together from a sample, such as the `posterior.csv` of `identify`.

use std::collections::HashMap;
use std::io::{BufRead, BufReader, Read};
use std::path::PathBuf;

use toml::Spanned;

use super::{Name, ParameterText, Shape, Study, StudyError};
use crate::files;
use crate::table::Table;
use sampling::design::Joint;
use sampling::distribution::Distribution;

/// A parameter as the FMU's description knows it.
pub(super) struct Known<'a> {
    /// The FMU's variable.
    pub(super) name: &'a str,
    /// The unit of the study's numbers.
    pub(super) unit: Option<&'a str>,
}

/// Parameters that are drawn together.
pub(super) struct Together {
    /// The sample.
    pub(super) joint: Joint,
    /// The distribution of each by itself, with its place among the parameters.
    pub(super) alone: Vec<(usize, Distribution)>,
}

/// Reads the samples of a study: parameters from one file are drawn together.
///
/// # Errors
/// With the place in the study, when a file cannot be read, has no such column, or has it in another unit.
pub(super) fn read(study: &Study, known: &[Known<'_>]) -> Result<Vec<Together>, StudyError> {
    let mut files: Vec<(PathBuf, &Spanned<PathBuf>)> = Vec::new();
    for (_, parameter) in sampled(study) {
        let file = file(study, parameter)?;
        let path = study.one_path(file.as_ref());
        if !files.iter().any(|(known, _)| *known == path) {
            files.push((path, file));
        }
    }
    files
        .into_iter()
        .map(|(_, file)| together(study, file, known))
        .collect()
}

/// The parameters that come from a sample, with their names.
fn sampled(study: &Study) -> impl Iterator<Item = (usize, &ParameterText)> {
    let all = study.parameters.values().enumerate();
    all.filter(|(_, parameter)| parameter.distribution == Shape::Sample)
}

fn name(study: &Study, index: usize) -> Option<&Name> {
    study.parameters.get_index(index).map(|(name, _)| name)
}

fn file<'a>(
    study: &Study,
    parameter: &'a ParameterText,
) -> Result<&'a Spanned<PathBuf>, StudyError> {
    // `shape` has refused a parameter without one.
    parameter
        .file
        .as_ref()
        .ok_or_else(|| study.error("a sample needs `file`"))
}

fn together(
    study: &Study,
    file: &Spanned<PathBuf>,
    known: &[Known<'_>],
) -> Result<Together, StudyError> {
    let one = study.one_path(file.as_ref());
    let from_it = |(_, parameter): &(usize, &ParameterText)| {
        let own = parameter.file.as_ref();
        own.is_some_and(|own| study.one_path(own.as_ref()) == one)
    };
    let members: Vec<(usize, &ParameterText)> = sampled(study).filter(from_it).collect();
    let path = study.beside(file.as_ref());
    let columns = members.iter().map(|(index, parameter)| {
        let own = known[*index].name;
        let column = parameter.column.as_deref().unwrap_or(own);
        (vec![column.to_owned()], format!("the parameter {own}"))
    });
    let columns: Vec<(Vec<String>, String)> = columns.collect();
    let table = Table::read_points(&path, &columns);
    let table = table.map_err(|error| study.error_at(file, error.to_string()))?;
    let units = stated_units(&path);
    for ((index, _), (names, _)) in members.iter().zip(&columns) {
        let input = &known[*index];
        let own = input.unit.unwrap_or("1");
        let stated = names.first().and_then(|name| units.get(name));
        if let (Some(stated), Some(name)) =
            (stated.filter(|stated| *stated != own), name(study, *index))
        {
            let message = format!(
                "{}: {} has it in {stated}, the study in {own}; write unit = \"{stated}\"",
                input.name,
                path.display()
            );
            return Err(study.error_at(name, message));
        }
    }
    let alone = members.iter().enumerate().map(|(column, (index, _))| {
        let values = table.rows.iter().map(|row| row[column]).collect();
        (*index, Distribution::sample(values))
    });
    let alone = alone.collect();
    let places = members.iter().map(|(index, _)| *index).collect();
    let joint = Joint::new(places, table.rows);
    let joint = joint.map_err(|message| study.error_at(file, message))?;
    Ok(Together { joint, alone })
}

/// The units that the comment in a file's first line states: `# NAME in UNIT, NAME in UNIT`, as `identify` writes it.
fn stated_units(path: &std::path::Path) -> HashMap<String, String> {
    let mut first = String::new();
    const MOST: u64 = 1 << 20;
    let file = files::open(path).map(|file| BufReader::new(file.take(MOST)));
    let read = file.and_then(|mut file| file.read_line(&mut first));
    let Some(comment) = read
        .ok()
        .and(first.trim_start_matches('\u{feff}').strip_prefix("# "))
    else {
        return HashMap::new();
    };
    let pairs = comment.trim_end().split(", ");
    let pairs = pairs.filter_map(|pair| pair.rsplit_once(" in "));
    pairs
        .map(|(name, unit)| (name.to_owned(), unit.to_owned()))
        .collect()
}
