//! The best point's trajectory, as a file beside the results.

use super::figures::Series;
use crate::analysis::table::PointTable;
use crate::statistics::Statistic;
use std::path::Path;

/// The file: `time` in seconds, and the criteria's signals in the criteria's units.
pub const FILE: &str = "best-point.csv";

/// Reads the trajectory of a folder: a signal a variable, with the accepted range of the criterion.
/// Nothing where there is no such file or it does not fit.
pub fn read(folder: &Path, table: &PointTable) -> Vec<Series> {
    let Ok(text) = std::fs::read_to_string(folder.join(FILE)) else {
        return vec![];
    };
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap_or("").split(',').collect();
    let mut columns = vec![Vec::new(); header.len()];
    for line in lines {
        let mut cells = line.split(',');
        for (column, cell) in columns.iter_mut().zip(cells.by_ref()) {
            column.push(cell.parse().unwrap_or(f64::NAN));
        }
        let last = columns.last().map_or(0, Vec::len);
        if last != columns[0].len() || cells.next().is_some() {
            return vec![];
        }
    }
    let mut columns = header.into_iter().zip(columns);
    let Some((_, time)) = columns.next() else {
        return vec![];
    };
    let series = |(name, values): (&str, Vec<f64>)| {
        let criterion = table.criteria.iter().find(|c| c.name == name)?;
        Some(Series {
            name: name.to_owned(),
            unit: criterion.unit.clone(),
            time: time.clone(),
            values,
            accepted: limits_the_signal(&criterion.source)
                .then_some([criterion.lower, criterion.upper]),
        })
    };
    columns.filter_map(series).collect()
}

/// Whether the limits of a criterion with this source are limits of the signal itself, as those of an amplitude are not.
fn limits_the_signal(source: &str) -> bool {
    let of = |statistic: &&Statistic| {
        let rest = source.strip_prefix(statistic.label());
        rest.is_some_and(|rest| rest.starts_with(" of "))
    };
    !Statistic::ALL
        .iter()
        .find(of)
        .is_some_and(|statistic| statistic.is_difference())
}
