//! `points.csv`: a row per point.

use std::{
    borrow::Cow,
    fs::File,
    io::{self, BufWriter, Read, Write},
    path::Path,
};

use super::{
    choice::{Best, Even},
    summary::Summary,
};
use crate::error::{Error, Result};
use conformity::{measured::Assessed, risk::Guard};
use number_tables::csv_file;
use parameter_regions::table::{CriterionColumn, ParameterColumn, PointTable};
use point_journal::PointOutcome;
use sampling::statistics::moments::length;
use study::{
    judge::{Criterion, Judge, PointVerdict},
    plan::Input,
};

/// Writes `points.csv` row by row.
pub struct Writer {
    csv: csv::Writer<BufWriter<File>>,
    record: csv::StringRecord,
    /// How points are accepted, where others are than those within all tolerances.
    guard: Option<Guard>,
    /// Whether each point has a conformance probability.
    conformance: bool,
}

/// The column of the decision under a guard band. That may be known only when all points are; until then the column holds
/// margins.
const ACCEPTED: &str = "accepted";

/// The column of the probability that a point conforms.
const CONFORMANCE: &str = "conformance";

impl Writer {
    /// Begins the table: `point`, the parameters, the criteria's values, `NAME.ok` a criterion,
    /// `verified`, where a guard band acts `accepted`, where uncertainties are known `conformance`, `status`. [`settle`] completes the table with a guard band.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn new(into: BufWriter<File>, inputs: &[Input], judge: &Judge) -> io::Result<Self> {
        let mut csv = csv::Writer::from_writer(into);
        let header = std::iter::once("point".to_owned())
            .chain(inputs.iter().map(|input| input.name.clone()))
            .chain(judge.names().cloned())
            .chain(judge.names().map(|name| format!("{name}.ok")))
            .chain(["verified".to_owned()])
            .chain(judge.is_guarded().then(|| ACCEPTED.to_owned()))
            .chain(judge.knows_conformance().then(|| CONFORMANCE.to_owned()))
            .chain(["status".to_owned()]);
        csv.write_record(header.map(|name| csv_file::cell(&name).into_owned()))?;
        Ok(Self {
            csv,
            record: csv::StringRecord::new(),
            guard: judge.is_guarded().then_some(judge.guard),
            conformance: judge.knows_conformance(),
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
        outcome: &PointOutcome,
        verdict: &PointVerdict,
    ) -> io::Result<()> {
        let record = &mut self.record;
        record.clear();
        record.push_field(&label.to_string());
        for value in parameters {
            record.push_field(&number(*value));
        }
        match outcome {
            Ok(values) => values.iter().for_each(|&value| record.push_field(&number(value))),
            Err(failure) => (0..verdict.passed.len()).for_each(|k| {
                let value = failure.value(k).map(number);
                record.push_field(&value.unwrap_or_default());
            }),
        }
        for passed in verdict.passed.iter().chain([&verdict.verified()]) {
            record.push_field(word(*passed));
        }
        let together = verdict.together;
        match self.guard {
            None => (),
            Some(guard @ Guard::EachPoint { .. }) => {
                record.push_field(word(together.is_some_and(|point| guard.accepts(point, None))));
            }
            Some(_) => record.push_field(&number(together.map_or(f64::NEG_INFINITY, |point| point.margin))),
        }
        if self.conformance {
            let probability = together.and_then(|point| point.probability);
            record.push_field(&probability.map(number).unwrap_or_default());
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
pub fn settle(from: impl Read, into: impl Write, guard: Guard, band: Option<f64>) -> io::Result<()> {
    let mut table = csv::Reader::from_reader(from);
    let mut settled = csv::Writer::from_writer(into);
    let header = table.headers()?.clone();
    settled.write_record(&header)?;
    // A parameter of the same name comes earlier.
    let column = (0..header.len()).rev().find(|&k| &header[k] == ACCEPTED);
    let mut record = csv::StringRecord::new();
    while table.read_record(&mut record)? {
        let cells = record.iter().enumerate().map(|(k, cell)| match cell.parse() {
            Ok(margin) if Some(k) == column => word(guard.accepts(Assessed { margin, probability: None }, band)),
            _ => cell,
        });
        settled.write_record(cells)?;
    }
    settled.flush()
}

fn word(flag: bool) -> &'static str {
    if flag { "true" } else { "false" }
}

/// What a flag says, also as other programs write it: `True`.
fn flag(cell: &str) -> Option<bool> {
    [false, true].into_iter().find(|flag| cell.eq_ignore_ascii_case(word(*flag)))
}

/// A number as text that reads back as the same number.
pub fn number(value: f64) -> String {
    let magnitude = value.abs();
    if magnitude == 0.0 || (1e-4..1e15).contains(&magnitude) { value.to_string() } else { format!("{value:e}") }
}

/// Reads the table that belongs to a summary: an even choice of at most about `most` points, and the best ones, in their order.
/// A point that failed has no values, or those of some criteria.
///
/// # Errors
/// When it cannot be read, or does not belong to the summary.
pub fn read(path: &Path, summary: &Summary, most: u64) -> Result<PointTable> {
    let failed = |error| Error::content(path, error);
    let mut reader = csv::Reader::from_path(path).map_err(failed)?;
    let verified = 1 + summary.parameters.len() + 2 * summary.criteria.len();
    let header = reader.headers().map_err(failed)?;
    let beside = header.iter().skip(verified + 1).take_while(|name| [ACCEPTED, CONFORMANCE].contains(name)).count();
    let width = verified + 2 + beside;
    if header.len() != width {
        return Err(Error::content(path, format!("{} columns, but the summary asks for {width}", header.len())));
    }
    let mut table = no_points(summary);
    let columns = header.clone();
    let flags = verified - summary.criteria.len()..=verified;
    let mut take = |record: &csv::StringRecord| {
        let line = record.position().map_or(0, csv::Position::line);
        if let Some(k) = flags.clone().find(|k| record.get(*k).is_some_and(|cell| flag(cell).is_none())) {
            let (column, cell) = (csv_file::text(&columns[k]), &record[k]);
            return Err(Error::content(
                path,
                format!("line {line}, column `{column}`: `{cell}` is neither true nor false"),
            ));
        }
        add(&mut table, record).ok_or_else(|| Error::content(path, format_args!("line {line} is damaged")))
    };
    let (even, mut best) = (Even::new(summary.points, most), Best::default());
    let (mut record, mut row, mut taken) = (csv::StringRecord::new(), 0, Vec::new());
    while reader.read_record(&mut record).map_err(failed)? {
        if even.has(row) {
            take(&record)?;
            taken.push(row);
        } else if let Some(distance) = distance(&record, summary) {
            let verified = record.get(verified).and_then(flag) == Some(true);
            best.offer(row, verified, distance, &record);
        }
        row += 1;
    }
    if even.is_whole() {
        return Ok(table);
    }
    for (row, record) in best.into_rows() {
        take(&record)?;
        taken.push(row);
    }
    let mut order: Vec<usize> = (0..taken.len()).collect();
    order.sort_unstable_by_key(|&place| taken[place]);
    Ok(table.subset(&order))
}

/// A criterion with its values at points.
pub(super) fn column(criterion: &Criterion, values: Vec<f64>, ok: Vec<bool>) -> CriterionColumn {
    let [lower, upper] = criterion.accepted();
    CriterionColumn {
        name: criterion.name.clone(),
        unit: criterion.unit.clone().unwrap_or_default(),
        nominal: criterion.target(),
        lower,
        upper,
        group: criterion.group.clone(),
        values,
        ok,
    }
}

/// The columns of a summary's points.
fn no_points(summary: &Summary) -> PointTable {
    let parameters = summary.parameters.iter().map(|p| ParameterColumn {
        name: p.name.clone(),
        unit: p.unit.clone().unwrap_or_default(),
        values: Vec::new(),
    });
    let criteria = summary.criteria.values().map(|count| column(&count.criterion, Vec::new(), Vec::new()));
    PointTable { parameters: parameters.collect(), criteria: criteria.collect(), ..PointTable::default() }
}

fn add(table: &mut PointTable, record: &csv::StringRecord) -> Option<()> {
    let mut cells = record.iter();
    table.ids.push(cells.next()?.parse().ok()?);
    for column in &mut table.parameters {
        column.values.push(cells.next()?.parse().ok()?);
    }
    for column in &mut table.criteria {
        column.values.push(match cells.next()? {
            "" => f64::NAN,
            number => number.parse().ok()?,
        });
    }
    for column in &mut table.criteria {
        column.ok.push(flag(cells.next()?)?);
    }
    table.verified.push(flag(cells.next()?)?);
    // A million points are hardly ever not ok: their texts would be a good part of the memory.
    table.status.push(match cells.next_back()? {
        "ok" => Cow::Borrowed("ok"),
        failure => Cow::Owned(csv_file::text(failure).into_owned()),
    });
    Some(())
}

/// How far a row is from the measurement: the root of the sum of its squared deviations, each in units of the
/// tolerance; nothing where the point failed.
fn distance(record: &csv::StringRecord, summary: &Summary) -> Option<f64> {
    let deviations: Vec<f64> = record
        .iter()
        .skip(1 + summary.parameters.len())
        .zip(summary.criteria.values())
        .map(|(cell, count)| Some(count.criterion.deviation(cell.parse().ok()?)))
        .collect::<Option<_>>()?;
    Some(length(deviations.into_iter())).filter(|distance| !distance.is_nan())
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
