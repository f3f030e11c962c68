//! The best point's trajectory, as a file beside the results.

use super::figures::Series;
use crate::analysis::table::PointTable;
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
            // An amplitude has limits, but the signal itself does not.
            accepted: (!criterion.source.starts_with("amplitude"))
                .then_some([criterion.lower, criterion.upper]),
        })
    };
    columns.filter_map(series).collect()
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
