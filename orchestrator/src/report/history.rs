//! The best point's trajectory, as a file beside the results.

use super::figures::Series;
use crate::analysis::table::PointTable;
use crate::statistics::Statistic;
use crate::table::csv_file;
use std::path::Path;

/// The file: `time` in seconds, and the criteria's signals in the criteria's units.
pub const FILE: &str = "best-point.csv";

/// Reads the trajectory of a folder: a signal a variable, with the accepted range of the criterion.
/// Nothing where there is no such file or it does not fit.
pub fn read(folder: &Path, table: &PointTable) -> Vec<Series> {
    let (header, columns) = columns(&folder.join(FILE)).unwrap_or_default();
    let names = header.iter().map(csv_file::text);
    let mut columns = names.zip(columns);
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

/// The names of a table, and its columns.
fn columns(path: &Path) -> csv::Result<(csv::StringRecord, Vec<Vec<f64>>)> {
    let mut table = csv::Reader::from_path(path)?;
    let header = table.headers()?.clone();
    let mut columns = vec![Vec::new(); header.len()];
    for record in table.records() {
        for (column, cell) in columns.iter_mut().zip(&record?) {
            column.push(cell.parse().unwrap_or(f64::NAN));
        }
    }
    Ok((header, columns))
}
