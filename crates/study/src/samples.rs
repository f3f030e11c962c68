//! Parameters that come together from a sample, such as the `posterior.csv` of `identify`.

use std::{
    collections::HashMap,
    io::{BufRead, BufReader, Read},
    path::PathBuf,
};

use indexmap::IndexMap;
use toml::Spanned;

use super::{Name, ParameterText, Shape, Study, input::Input};
use number_tables::{
    Column, Table,
    files::{self, Result},
};
use sampling::{design::Joint, distribution::Distribution};

/// A parameter that comes from a sample.
struct Member<'a> {
    index: usize,
    name: &'a Name,
    text: &'a ParameterText,
}

/// Parameters that are drawn together.
pub struct Together {
    /// The sample.
    pub joint: Joint,
    /// The distribution of each by itself, with its place among the parameters.
    pub alone: Vec<(usize, Distribution)>,
}

/// Reads the samples of a study for its parameters: those from one file are drawn together.
///
/// # Errors
/// With the place in the study, when a file cannot be read, has no such column, or has it in another unit.
pub fn read(study: &Study, inputs: &[Input]) -> Result<Vec<Together>> {
    let mut files: IndexMap<PathBuf, (&Spanned<PathBuf>, Vec<Member>)> = IndexMap::new();
    for (index, (name, text)) in study.parameters.iter().enumerate() {
        if text.distribution != Shape::Sample {
            continue;
        }
        let file = text.file.as_ref().expect("a sample without a file has no distribution");
        let (_, members) = files.entry(study.one_path(file.as_ref())).or_insert_with(|| (file, Vec::new()));
        members.push(Member { index, name, text });
    }
    files.into_values().map(|(file, members)| together(study, file, &members, inputs)).collect()
}

fn together(study: &Study, file: &Spanned<PathBuf>, members: &[Member], inputs: &[Input]) -> Result<Together> {
    let path = study.path_of(file.as_ref());
    let column = |member: &Member| {
        let name = member.name.as_ref();
        let column = member.text.column.as_ref().unwrap_or(name);
        number_tables::column(column, format!("the parameter {name}"))
    };
    let columns: Vec<Column> = members.iter().map(column).collect();
    let mut table = Table::read_points(&path, &columns).map_err(|error| study.error_at(file, error))?;
    for (column, member) in members.iter().enumerate() {
        inputs[member.index].round(&mut table, column, &path);
    }
    let stated = stated_units(&path);
    for (member, (names, _)) in members.iter().zip(&columns) {
        let unit = inputs[member.index].unit.as_deref().unwrap_or("1");
        if let Some(stated) = stated.get(&names[0]).filter(|stated| *stated != unit) {
            let path = path.display();
            return Err(study.error_of(
                member.name,
                format!("{path} has it in {stated}, the study in {unit}; write unit = \"{stated}\""),
            ));
        }
    }
    let alone = members
        .iter()
        .enumerate()
        .map(|(column, member)| {
            let values = table.rows.iter().map(|row| row[column]).collect();
            (member.index, Distribution::sample(values))
        })
        .collect();
    let places = members.iter().map(|member| member.index).collect();
    let joint = Joint::new(places, table.rows).map_err(|message| study.error_at(file, message))?;
    Ok(Together { joint, alone })
}

/// The units that the comment in a file's first line states: `# NAME in UNIT, NAME in UNIT`, as `identify` writes it.
fn stated_units(path: &std::path::Path) -> HashMap<String, String> {
    let mut first = String::new();
    const MOST: u64 = 1 << 20;
    let file = files::open(path).map(|file| BufReader::new(file.take(MOST)));
    let Some(comment) = file
        .and_then(|mut file| file.read_line(&mut first))
        .ok()
        .and(first.trim_start_matches('\u{feff}').strip_prefix("# "))
    else {
        return HashMap::new();
    };
    comment
        .trim_end()
        .split(", ")
        .filter_map(|pair| pair.rsplit_once(" in "))
        .map(|(name, unit)| (name.to_owned(), unit.to_owned()))
        .collect()
}
