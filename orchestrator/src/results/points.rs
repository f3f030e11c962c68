//! `points.csv`: a row per point.

use std::borrow::Cow;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

use thiserror::Error;

use super::Outcome;
use super::choice::{Best, Even};
use super::summary::Summary;
use crate::judge::{Judge, PointVerdict};
use crate::study::plan::Input;
use crate::table::csv_file;
use conformity::measured::Measurement;
use conformity::risk::Guard;

/// Writes `points.csv` row by row.
pub struct Writer<W: Write> {
    csv: csv::Writer<W>,
    record: csv::StringRecord,
    /// Where a guard band acts. It may be known only when all points are; until then the column `accepted` holds margins.
    margins: Option<Measurement>,
}

/// The column of the decision under a guard band.
const ACCEPTED: &str = "accepted";

impl<W: Write> Writer<W> {
    /// Begins the table: `point`, the parameters, the criteria's values, `NAME.ok` a criterion,
    /// `verified`, where a guard band acts `accepted`, `status`. [`settle`] completes the table with a guard band.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn new(into: W, inputs: &[Input], judge: &Judge) -> io::Result<Self> {
        let mut csv = csv::Writer::from_writer(into);
        let criteria = || {
            judge
                .criteria
                .iter()
                .map(|criterion| criterion.name.clone())
        };
        let header = std::iter::once("point".to_owned())
            .chain(inputs.iter().map(|input| input.name.clone()))
            .chain(criteria())
            .chain(criteria().map(|name| format!("{name}.ok")))
            .chain(["verified".to_owned()])
            .chain(judge.is_guarded().then(|| ACCEPTED.to_owned()))
            .chain(["status".to_owned()]);
        csv.write_record(header.map(|name| csv_file::cell(&name).into_owned()))?;
        Ok(Self {
            csv,
            record: csv::StringRecord::new(),
            margins: judge.is_guarded().then(|| judge.measurement.clone()),
        })
    }

    /// Writes a point. Cells are empty for values that are no finite numbers, or that a failed point does not have.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn write(
        &mut self,
        label: u64,
        parameters: &[f64],
        outcome: &Outcome,
        verdict: &PointVerdict,
    ) -> io::Result<()> {
        let record = &mut self.record;
        record.clear();
        record.push_field(&label.to_string());
        for value in parameters {
            record.push_field(&number(*value));
        }
        match outcome {
            Ok(values) => values
                .iter()
                .for_each(|&value| record.push_field(&number(value))),
            Err(failure) => (0..verdict.passed.len()).for_each(|k| {
                let value = failure.value(k).map(number);
                record.push_field(&value.unwrap_or_default());
            }),
        }
        for passed in &verdict.passed {
            record.push_field(if *passed { "true" } else { "false" });
        }
        record.push_field(if verdict.verified() { "true" } else { "false" });
        if let Some(measurement) = &self.margins {
            let values = outcome.as_deref().ok();
            let margin = values.map_or(f64::NEG_INFINITY, |values| measurement.margin(values));
            record.push_field(&number(margin));
        }
        match outcome {
            Ok(_) => record.push_field("ok"),
            Err(failure) => record.push_field(&csv_file::cell(&failure.to_string())),
        }
        self.csv.write_record(&*record)?;
        Ok(())
    }

    /// Writes what is still held back.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn finish(mut self) -> io::Result<()> {
        self.csv.flush()
    }
}

/// Copies a table with margins in its column `accepted`, and puts the decision there: whether a guard band accepts the
/// margin, given the one that was found from all points.
///
/// # Errors
/// When a table cannot be read or written.
pub fn settle(
    from: impl Read,
    into: impl Write,
    guard: Guard,
    found: Option<f64>,
) -> io::Result<()> {
    let mut table = csv::Reader::from_reader(from);
    let mut settled = csv::Writer::from_writer(into);
    let header = table.headers()?.clone();
    settled.write_record(&header)?;
    // A parameter of the same name comes earlier.
    let column = (0..header.len()).rev().find(|&k| &header[k] == ACCEPTED);
    let mut record = csv::StringRecord::new();
    while table.read_record(&mut record)? {
        let cells = record
            .iter()
            .enumerate()
            .map(|(k, cell)| match cell.parse() {
                Ok(margin) if Some(k) == column => match guard.accepts(margin, found) {
                    true => "true",
                    false => "false",
                },
                _ => cell,
            });
        settled.write_record(cells)?;
    }
    settled.flush()
}

/// A number as text that reads back as the same number.
pub fn number(value: f64) -> String {
    let magnitude = value.abs();
    if magnitude == 0.0 || (1e-4..1e15).contains(&magnitude) {
        value.to_string()
    } else {
        format!("{value:e}")
    }
}

/// Why `points.csv` cannot be read.
#[derive(Debug, Error)]
pub enum PointsError {
    /// The file is not a table.
    #[error("{path}: {source}")]
    Csv {
        /// The table.
        path: PathBuf,
        /// The problem.
        source: csv::Error,
    },
    /// A column is missing, or a cell is not what it should be.
    #[error("{path}: {message}")]
    Content {
        /// The table.
        path: PathBuf,
        /// The problem.
        message: String,
    },
}

/// The content of `points.csv`, column by column.
#[derive(Clone, Debug, Default)]
pub struct Points {
    /// The points' numbers.
    pub labels: Vec<u64>,
    /// A column per parameter, in the order of [`Summary::parameters`].
    pub parameters: Vec<Vec<f64>>,
    /// A column per criterion, in the order of [`Summary::criteria`]; not a number where the point has no value. One that
    /// failed may have values of some criteria.
    pub values: Vec<Vec<f64>>,
    /// Whether the criterion is met, in the same order.
    pub passed: Vec<Vec<bool>>,
    /// Whether all criteria are met.
    pub verified: Vec<bool>,
    /// Whether the guard band lets them pass, where one acts.
    pub accepted: Option<Vec<bool>>,
    /// `ok`, or why the point failed.
    pub status: Vec<Cow<'static, str>>,
}

impl Points {
    /// Reads the table that belongs to a summary.
    ///
    /// # Errors
    /// When it cannot be read, or does not belong to the summary.
    pub fn read(path: &Path, summary: &Summary) -> Result<Self, PointsError> {
        Self::read_some(path, summary, u64::MAX)
    }

    /// Reads an even choice of at most about `most` points, and the best ones.
    ///
    /// # Errors
    /// As [`Points::read`].
    pub fn read_some(path: &Path, summary: &Summary, most: u64) -> Result<Self, PointsError> {
        let failed = |source| PointsError::Csv {
            path: path.to_owned(),
            source,
        };
        let content = |message: String| PointsError::Content {
            path: path.to_owned(),
            message,
        };
        let mut reader = csv::Reader::from_path(path).map_err(failed)?;
        let (inputs, criteria) = (summary.parameters.len(), summary.criteria.len());
        let verified = 1 + inputs + 2 * criteria;
        let header = reader.headers().map_err(failed)?;
        let guarded = header.get(verified + 1) == Some(ACCEPTED);
        let width = verified + 2 + usize::from(guarded);
        if header.len() != width {
            let message = format!("{} columns, but the summary asks for {width}", header.len());
            return Err(content(message));
        }
        let empty = Self {
            parameters: vec![Vec::new(); inputs],
            values: vec![Vec::new(); criteria],
            passed: vec![Vec::new(); criteria],
            accepted: guarded.then(Vec::new),
            ..Self::default()
        };
        let damaged = |record: &csv::StringRecord| {
            let line = record.position().map_or(0, csv::Position::line);
            content(format!("line {line} is damaged"))
        };
        let (even, mut best) = (Even::new(summary.points, most), Best::default());
        let (mut points, mut others) = (empty.clone(), empty);
        let (mut record, mut rows) = (csv::StringRecord::new(), 0..);
        while reader.read_record(&mut record).map_err(failed)? {
            let row = rows.next().unwrap_or(0);
            if even.has(row) {
                points.add(&record).ok_or_else(|| damaged(&record))?;
            } else if let Some(distance) = distance(&record, summary) {
                let verified = record.get(verified) == Some("true");
                best.offer(row, verified, distance, &record);
            }
        }
        let mut places = Vec::new();
        for (row, record) in best.into_rows() {
            others.add(&record).ok_or_else(|| damaged(&record))?;
            places.push(usize::try_from(even.before(row)).unwrap_or(usize::MAX));
        }
        points.insert(&places, others);
        Ok(points)
    }

    /// Inserts other points before those at `places`, which ascend.
    fn insert(&mut self, places: &[usize], others: Self) {
        if places.is_empty() {
            return;
        }
        merge(&mut self.labels, places, others.labels);
        let parameters = self.parameters.iter_mut().zip(others.parameters);
        let values = self.values.iter_mut().zip(others.values);
        for (own, others) in parameters.chain(values) {
            merge(own, places, others);
        }
        for (own, others) in self.passed.iter_mut().zip(others.passed) {
            merge(own, places, others);
        }
        merge(&mut self.verified, places, others.verified);
        if let (Some(own), Some(others)) = (&mut self.accepted, others.accepted) {
            merge(own, places, others);
        }
        merge(&mut self.status, places, others.status);
    }

    fn add(&mut self, record: &csv::StringRecord) -> Option<()> {
        let mut cells = record.iter();
        self.labels.push(cells.next()?.parse().ok()?);
        for column in &mut self.parameters {
            column.push(cells.next()?.parse().ok()?);
        }
        for column in &mut self.values {
            let cell = cells.next()?;
            column.push(if cell.is_empty() {
                f64::NAN
            } else {
                cell.parse().ok()?
            });
        }
        for column in &mut self.passed {
            column.push(cells.next()? == "true");
        }
        self.verified.push(cells.next()? == "true");
        if let Some(accepted) = &mut self.accepted {
            accepted.push(cells.next()? == "true");
        }
        // A million points are hardly ever not ok: their texts would be a good part of the memory.
        self.status.push(match cells.next()? {
            "ok" => Cow::Borrowed("ok"),
            failure => Cow::Owned(csv_file::text(failure).into_owned()),
        });
        Some(())
    }

    /// How many points there are.
    pub fn len(&self) -> usize {
        self.labels.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.labels.is_empty()
    }
}

/// Inserts elements before those at `places`, which ascend.
fn merge<T>(own: &mut Vec<T>, places: &[usize], others: Vec<T>) {
    let mut merged = Vec::with_capacity(own.len() + others.len());
    let mut rest = own.drain(..).enumerate().peekable();
    for (&place, other) in places.iter().zip(others) {
        while let Some((_, element)) = rest.next_if(|(number, _)| *number < place) {
            merged.push(element);
        }
        merged.push(other);
    }
    merged.extend(rest.map(|(_, element)| element));
    *own = merged;
}

/// How far a row is from the measurement: the root of the sum of its squared deviations, each in units of the
/// tolerance; nothing where the point failed.
fn distance(record: &csv::StringRecord, summary: &Summary) -> Option<f64> {
    let cells = record.iter().skip(1 + summary.parameters.len());
    let mut sum = 0.0;
    for (cell, count) in cells.zip(summary.criteria.values()) {
        let criterion = &count.criterion;
        let value: f64 = cell.parse().ok()?;
        sum += ((value - criterion.nominal) / criterion.tolerance).powi(2);
    }
    (!sum.is_nan()).then(|| sum.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn numbers_read_back_as_they_were(bits: u64) {
            let value = f64::from_bits(bits);
            prop_assume!(value.is_finite());
            prop_assert_eq!(number(value).parse::<f64>(), Ok(value));
        }
    }

    #[test]
    fn elements_are_inserted_where_they_belong() {
        let mut own = vec![1, 2, 4];
        merge(&mut own, &[0, 2, 2, 3], vec![0, 30, 31, 5]);
        assert_eq!(own, [0, 1, 2, 30, 31, 4, 5]);
    }
}
