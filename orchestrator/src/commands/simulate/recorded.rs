//! The variables that `simulate` records, and the recordings that it feeds to inputs.

use std::path::Path;

use crate::{
    commands::isolated::Columns,
    error::{Error, Result},
};
use fmu_import::{Causality, Description, quantity::Scale};
use fmu_points::task::{Schedule, Series};
use number_tables::{Table, recorded::RecordedTable};
use study::{
    inputs::{covers, doubts, follow, is_discrete, is_integrated, many_steps, slot_while_running, takes_any_step},
    plan::find,
};

/// The variables of `--record`.
pub fn columns(lists: &[String], fmu: &Description) -> Result<Columns> {
    let names = lists.iter().flat_map(|list| names(list, |name| fmu.variables.contains_key(name)));
    let variables = names.map(|name| find(fmu, name).cloned().map_err(|message| Error::option("record", message)));
    Ok(Columns(variables.collect::<Result<_, _>>()?))
}

/// The names of a list. A comma belongs to a name where a variable is called so, or within brackets: `a[1,2]`, `der(x,2)`.
fn names(mut list: &str, is_variable: impl Fn(&str) -> bool) -> Vec<&str> {
    let mut names = Vec::new();
    while !list.trim().is_empty() {
        let ends: Vec<usize> = list.match_indices(',').map(|(place, _)| place).chain([list.len()]).collect();
        let end = ends
            .iter()
            .rev()
            .find(|end| is_variable(list[..**end].trim()))
            .copied()
            .unwrap_or_else(|| end_of_name(list));
        names.push(list[..end].trim());
        list = list.get(end + 1..).unwrap_or_default();
    }
    names.retain(|name| !name.is_empty());
    names
}

/// Where the first comma outside of brackets is, or the end.
fn end_of_name(list: &str) -> usize {
    let mut depth = 0_usize;
    list.find(|c: char| {
        match c {
            '[' | '(' => depth += 1,
            ']' | ')' => depth = depth.saturating_sub(1),
            _ => {}
        }
        c == ',' && depth == 0
    })
    .unwrap_or(list.len())
}

/// The inputs of `--input`: each column beside the time is one, as under `[inputs]` in a study.
pub fn inputs(path: &Path, ends_hold: bool, fmu: &Description, schedule: &Schedule) -> Result<Vec<Series>> {
    let recorded = RecordedTable::read_times(path)?;
    let time = recorded.time(&may_be_time(fmu), ONE_TIME)?;
    let inputs = recorded
        .columns
        .iter()
        .map(|column| &*column.name)
        .filter(|name| *name != time)
        .map(|column| {
            let wrong = |message| Error::option("input", format!("{}: column `{column}`: {message}", path.display()));
            let (name, unit) = split(column, fmu);
            let variable = find(fmu, name).map_err(wrong)?;
            let slot = slot_while_running(variable).map_err(wrong)?;
            let scale = Scale::new(unit.as_deref(), fmu, variable).map_err(wrong)?;
            let columns = vec![number_tables::column(column, format!("the input {name}"))];
            let table = Table::read_over_time(path, Some(time), columns)?;
            let mut series = follow(&table, time, slot, scale.conversion).map_err(wrong)?;
            series.hold = is_discrete(variable, &series.slot);
            series.ramp = !series.hold && is_integrated(variable, fmu);
            series.each_row = takes_any_step(fmu);
            if !ends_hold {
                let words = ["--start ", "--stop ", "--extrapolate hold"];
                covers(&series, schedule, words).map_err(wrong)?;
            }
            for concern in doubts(&series, schedule, &scale) {
                fmu_points::tell::line!("note: {concern}");
            }
            Ok(series)
        })
        .collect::<Result<Vec<Series>>>()?;
    if inputs.is_empty() {
        return Err(Error::option(
            "input",
            format!("{}: no column beside `{time}`: add one for each input", path.display()),
        ));
    }
    if let Some(concern) = many_steps(&inputs, schedule) {
        fmu_points::tell::line!("note: {concern}");
    }
    Ok(inputs)
}

/// A column's variable and unit: `NAME`, or `NAME [UNIT]` as in every table.
pub fn split<'a>(column: &'a str, fmu: &Description) -> (&'a str, Option<String>) {
    if fmu.variables.contains_key(column) { (column, None) } else { number_tables::name_and_unit(column) }
}

/// What a table of inputs or measured values needs.
pub const ONE_TIME: &str = "the file needs one column of a time that rises";

/// Whether a column may be the time: the FMU's own variable `time` may, its others are what they are.
pub fn may_be_time(fmu: &Description) -> impl Fn(&str) -> bool {
    |column| fmu.variables.get(split(column, fmu).0).is_none_or(|known| known.causality == Causality::Independent)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commas_within_brackets_belong_to_names() {
        let parts: Vec<&str> = names("a, b[1,2].c,der(x,2) ,,d", |_| false);
        assert_eq!(parts, ["a", "b[1,2].c", "der(x,2)", "d"]);
    }

    #[test]
    fn commas_of_a_variable_belong_to_its_name() {
        let parts = names("u,1, u,v", |name| ["u", "u,1", "v"].contains(&name));
        assert_eq!(parts, ["u,1", "u", "v"]);
    }
}
