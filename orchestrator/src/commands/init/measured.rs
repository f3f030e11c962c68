//! A table of measured values: which of its columns are outputs of the FMU.

use std::path::{Path, PathBuf};

use super::{is_number, is_real, run::Signal};
use crate::{
    commands::simulate::recorded::{ONE_TIME, may_be_time, split},
    error::Error,
};
use fmu_import::{Causality, Description, Variable, quantity::Scale};
use fmu_points::names::{did_you_mean, nearest};
use number_tables::{Table, recorded::RecordedTable};

/// The columns of a table of measured values that are outputs of the FMU.
#[derive(Debug)]
pub struct MeasuredTable<'a> {
    pub file: PathBuf,
    /// The column of the time; where there is none, the rows are single readings.
    pub time: Option<String>,
    /// The first and the last time, s.
    pub span: Option<[f64; 2]>,
    pub columns: Vec<Column<'a>>,
    /// The columns that are inputs of the FMU: over time, or one value for each row, which is an operating point then.
    pub inputs: Vec<Column<'a>>,
    /// Names of the others, each with the reason.
    left: Vec<(String, String)>,
}

/// A column of measured values.
#[derive(Debug)]
pub struct Column<'a> {
    pub header: String,
    pub unit: Option<String>,
    pub variable: &'a Variable,
    pub values: Vec<f64>,
}

impl<'a> MeasuredTable<'a> {
    /// Reads the table.
    ///
    /// # Errors
    /// When it cannot be read, or its times do not grow.
    pub fn read(path: &Path, fmu: &'a Description) -> Result<Self, Error> {
        let recorded = RecordedTable::read(path)?;
        let may_be = may_be_time(fmu);
        // Of operating points a duration does not rise from row to row.
        let time = recorded.is_over_time(&may_be).then(|| recorded.time(&may_be, ONE_TIME)).transpose()?;
        let mut table = Self {
            file: path.to_owned(),
            time: time.map(str::to_owned),
            span: time.map(|time| span(path, time)).transpose()?,
            columns: Vec::new(),
            inputs: Vec::new(),
            left: Vec::new(),
        };
        let is_input = |name| fmu.variables.get(split(name, fmu).0).is_some_and(|v| v.causality == Causality::Input);
        for name in recorded.columns.iter().map(|column| &column.name).filter(|name| Some(name.as_str()) != time) {
            match table.column(name, fmu) {
                Ok(column) if column.variable.causality == Causality::Input => table.inputs.push(column),
                Ok(column) => table.columns.push(column),
                // Without it the FMU would run with the input at its start value.
                Err(reason) if is_input(name) => {
                    return Err(Error::content(path, format!("column `{name}`: {reason}")));
                }
                Err(reason) => table.left.push((name.clone(), reason)),
            }
        }
        let bare = |column: &&Column| column.unit.is_none() && column.variable.unit().is_some_and(|unit| unit != "1");
        if let Some(Column { header, variable, .. }) = table.columns.iter().chain(&table.inputs).find(bare) {
            let message = format!(
                "column `{header}` has no unit, and the FMU has it in {}; write `{header} [unit]` in the first line of the file",
                variable.unit().unwrap_or_default()
            );
            return Err(Error::content(path, message));
        }
        Ok(table)
    }

    /// A column with its variable, or why it has none.
    fn column(&self, header: &str, fmu: &'a Description) -> Result<Column<'a>, String> {
        let (name, unit) = split(header, fmu);
        let variable = variable(name, fmu)?;
        let is_input = variable.causality == Causality::Input;
        if self.columns.iter().chain(&self.inputs).any(|column| column.variable.name == variable.name) {
            return Err(format!("`{name}` is there twice"));
        }
        if self.time.is_some() && !is_input && !is_real(variable) {
            return Err("it is a whole number, and a curve needs real ones".to_owned());
        }
        Scale::new(unit.as_deref(), fmu, variable)?;
        let asked = number_tables::column(header, "measured values");
        let table = Table::read(&self.file, &[asked]).map_err(|error| error.to_string())?;
        let values: Vec<f64> = table.rows.iter().map(|row| row[0]).collect();
        if let Some(row) = values.iter().position(|value| !value.is_finite()) {
            return Err(format!("its value in row {} is not a finite number", row + 1));
        }
        let first = values.first();
        if self.time.is_some() && !is_input && values.iter().all(|value| Some(value) == first) {
            return Err("it is the same in all rows: write it as `nominal` of a criterion".to_owned());
        }
        Ok(Column { header: header.to_owned(), unit, variable, values })
    }

    /// Leaves out columns of which the FMU computes no finite values, in their order.
    pub fn leave_out_infinite(&mut self, signals: &[Signal]) {
        let left = &mut self.left;
        let mut signals = signals.iter();
        self.columns.retain(|column| {
            let is_finite = signals.next().is_some_and(|signal| signal.is_finite);
            if !is_finite {
                let reason = "the FMU's own values are not finite in a run";
                left.push((column.header.clone(), reason.to_owned()));
            }
            is_finite
        });
    }

    /// Tells which columns are left out, and why.
    ///
    /// # Errors
    /// When nothing is left.
    pub fn tell(&self) -> Result<(), Error> {
        let file = self.file.display();
        if self.columns.is_empty() {
            let reasons: Vec<String> = self.left.iter().map(|(name, reason)| format!("{name}: {reason}")).collect();
            let message = format!(
                "{file}: no column is an output of the FMU ({}); `synchronise` takes other names",
                reasons.join("; ")
            );
            return Err(Error::option("measured", message));
        }
        for (name, reason) in &self.left {
            fmu_points::tell::line!("left out of {file}: `{name}`: {reason}");
        }
        let named = |columns: &[Column]| {
            columns.iter().map(|column| format!("`{}`", column.header)).collect::<Vec<_>>().join(", ")
        };
        let (measured, inputs, rows) = (named(&self.columns), named(&self.inputs), self.columns[0].values.len());
        let told = match (&self.time, &*inputs) {
            (Some(time), "") => format!("`{time}` is the time; curves: {measured}"),
            (Some(time), _) => format!("`{time}` is the time; inputs over time: {inputs}; curves: {measured}"),
            (None, "") => format!(
                "no column of the time and none of an input, so {rows} rows count as repeats of one measurement: {measured}"
            ),
            (None, _) => format!(
                "no column of the time, so each of {rows} rows became a case, an operating point: inputs {inputs}, final values \
                 {measured}; a recording over time needs a column `time [s]`"
            ),
        };
        fmu_points::tell::line!("{file}: {told}");
        Ok(())
    }
}

/// The variable that a column measures.
fn variable<'a>(name: &str, fmu: &'a Description) -> Result<&'a Variable, String> {
    let is_shown = |variable: &&Variable| {
        matches!(variable.causality, Causality::Output | Causality::Local) && is_number(variable)
    };
    let known = fmu.variables.get(name);
    match known.map(|variable| (variable, variable.causality)) {
        Some((variable, _)) if is_shown(&variable) => Ok(variable),
        Some((variable, Causality::Input)) if is_number(variable) => Ok(variable),
        Some((_, Causality::Input | Causality::Output | Causality::Local)) => Err("it is no number".to_owned()),
        Some(_) => Err("it is no output of the FMU".to_owned()),
        None => {
            let names = fmu.variables.values().filter(is_shown);
            let suggestion = nearest(name, names.map(|variable| &*variable.name));
            Err(format!("the FMU has no such variable{}", did_you_mean(suggestion)))
        }
    }
}

/// The first and the last time of a table.
fn span(path: &Path, time: &str) -> Result<[f64; 2], Error> {
    let wrong = |message: &str| Err(Error::content(path, format!("column `{time}`: {message}")));
    let table = Table::read_over_time(path, Some(time), Vec::new())?;
    let times: Vec<f64> = table.rows.iter().map(|row| row[0]).collect();
    match times[..] {
        [first, .., last] if times.is_sorted_by(|a, b| a < b) => Ok([first, last]),
        _ => wrong("a curve needs two rows or more, and times that grow from row to row"),
    }
}
