//! `points.csv`: a row a point.

use std::borrow::Cow;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use thiserror::Error;

use super::Outcome;
use super::summary::Summary;
use crate::judge::{Judge, PointVerdict};
use crate::study::plan::Input;
use crate::table::csv_file;

/// Writes `points.csv` row by row.
pub struct Writer<W: Write> {
    csv: csv::Writer<W>,
    record: csv::StringRecord,
}

impl<W: Write> Writer<W> {
    /// Begins the table: `point`, the parameters, the criteria's values, `NAME.ok` a criterion,
    /// `verified`, `status`.
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
            .chain(["verified".to_owned(), "status".to_owned()]);
        csv.write_record(header.map(|name| csv_file::cell(&name).into_owned()))?;
        let record = csv::StringRecord::new();
        Ok(Self { csv, record })
    }

    /// Writes a point. One that failed has empty cells for its values.
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
            Err(_) => verdict.passed.iter().for_each(|_| record.push_field("")),
        }
        for passed in &verdict.passed {
            record.push_field(if *passed { "true" } else { "false" });
        }
        record.push_field(if verdict.verified() { "true" } else { "false" });
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
    /// A column a parameter, in the order of [`Summary::parameters`].
    pub parameters: Vec<Vec<f64>>,
    /// A column a criterion, in the order of [`Summary::criteria`]; not a number where the point
    /// failed.
    pub values: Vec<Vec<f64>>,
    /// Whether the criterion is met, in the same order.
    pub passed: Vec<Vec<bool>>,
    /// Whether all criteria are met.
    pub verified: Vec<bool>,
    /// `ok`, or why the point failed.
    pub status: Vec<Cow<'static, str>>,
}

impl Points {
    /// Reads the table that belongs to a summary.
    ///
    /// # Errors
    /// When it cannot be read, or does not belong to the summary.
    pub fn read(path: &Path, summary: &Summary) -> Result<Self, PointsError> {
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
        let width = inputs + 2 * criteria + 3;
        let header = reader.headers().map_err(failed)?;
        if header.len() != width {
            let message = format!("{} columns, but the summary asks for {width}", header.len());
            return Err(content(message));
        }
        let mut points = Self {
            parameters: vec![Vec::new(); inputs],
            values: vec![Vec::new(); criteria],
            passed: vec![Vec::new(); criteria],
            ..Self::default()
        };
        let mut record = csv::StringRecord::new();
        while reader.read_record(&mut record).map_err(failed)? {
            points.add(&record).ok_or_else(|| {
                let line = record.position().map_or(0, csv::Position::line);
                content(format!("line {line} is damaged"))
            })?;
        }
        Ok(points)
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
        // A million points are hardly ever not ok: their texts would be a good part of the memory.
        self.status.push(match cells.next()? {
            "ok" => Cow::Borrowed("ok"),
            failure => Cow::Owned(failure.to_owned()),
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
}
