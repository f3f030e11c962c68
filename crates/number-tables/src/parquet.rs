//! Tables of Apache Parquet, read row by row.

use std::{
    borrow::Cow,
    path::{Path, PathBuf},
};

use parquet::{
    basic::LogicalType,
    errors::ParquetError,
    file::reader::{FileReader, SerializedFileReader},
    record::{Field, reader::RowIter},
};

use crate::{
    files::{self, FileError, Result, in_a_line},
    rows::Rows,
};

/// A Parquet file as [`Rows`].
struct ParquetRows {
    path: PathBuf,
    names: Vec<String>,
    rows: RowIter<'static>,
    cells: Vec<Field>,
    count: u64,
}

/// Opens a Parquet file.
///
/// # Errors
/// When there is none, or it is none of Parquet.
pub fn rows(path: &Path, _: bool) -> Result<Box<dyn Rows>> {
    let file = files::open(path).map_err(|error| FileError::system(path, error))?;
    let reader = SerializedFileReader::new(file).map_err(|error| wrong(path, &error))?;
    let schema = reader.metadata().file_metadata().schema();
    // A duration of pandas is a plain number but for the notes beside it.
    let notes = reader.metadata().file_metadata().key_value_metadata();
    let has_durations = |note: &parquet::file::metadata::KeyValue| {
        note.key == "pandas" && note.value.as_ref().is_some_and(|value| value.contains("timedelta64"))
    };
    let durations = notes.is_some_and(|notes| notes.iter().any(has_durations));
    let is_moment = |kind: Option<&LogicalType>| {
        matches!(
            kind,
            Some(
                LogicalType::Timestamp { .. }
                    | LogicalType::Time { .. }
                    | LogicalType::Date
                    | LogicalType::Decimal { .. }
            )
        )
    };
    let moments: Vec<&str> = schema
        .get_fields()
        .iter()
        .filter(|field| is_moment(field.get_basic_info().logical_type_ref()))
        .map(|field| field.name())
        .collect();
    if durations || !moments.is_empty() {
        let what = if durations {
            "durations".to_owned()
        } else {
            format!("moments or decimals (`{}`)", moments.join("`, `"))
        };
        return Err(FileError::new(path, format!("it has {what}, which are no plain numbers")));
    }
    let fields = schema.get_fields().iter();
    Ok(Box::new(ParquetRows {
        path: path.to_owned(),
        names: fields.map(|field| field.name().to_owned()).collect(),
        rows: reader.into_iter(),
        cells: Vec::new(),
        count: 0,
    }))
}

fn wrong(path: &Path, error: &ParquetError) -> FileError {
    FileError::new(path, in_a_line(&error.to_string()))
}

impl Rows for ParquetRows {
    fn names(&self) -> &[String] {
        &self.names
    }

    fn advance(&mut self) -> Result<bool> {
        let Some(row) = self.rows.next() else { return Ok(false) };
        let columns = row.map_err(|error| wrong(&self.path, &error))?.into_columns();
        self.cells = columns.into_iter().map(|(_, cell)| cell).collect();
        self.count += 1;
        Ok(true)
    }

    fn number(&self, place: usize) -> Option<f64> {
        number(self.cells.get(place)?)
    }

    fn whole(&self, place: usize) -> Option<u64> {
        whole(self.cells.get(place)?)
    }

    fn text(&self, place: usize) -> Cow<'_, str> {
        match self.cells.get(place) {
            None | Some(Field::Null) => Cow::Borrowed(""),
            Some(Field::Str(text)) => Cow::Borrowed(text),
            Some(other) => Cow::Owned(other.to_string()),
        }
    }

    fn line(&self) -> u64 {
        self.count
    }
}

/// A cell as a number.
fn number(cell: &Field) -> Option<f64> {
    Some(match cell {
        Field::Double(value) => *value,
        Field::Float(value) => f64::from(*value),
        Field::Bool(value) => f64::from(*value),
        Field::ULong(value) => *value as f64,
        other => integer(other)? as f64,
    })
}

/// A cell as a count.
fn whole(cell: &Field) -> Option<u64> {
    match cell {
        Field::ULong(value) => Some(*value),
        other => u64::try_from(integer(other)?).ok(),
    }
}

fn integer(cell: &Field) -> Option<i64> {
    Some(match cell {
        Field::Byte(value) => (*value).into(),
        Field::Short(value) => (*value).into(),
        Field::Int(value) => (*value).into(),
        Field::Long(value) => *value,
        Field::UByte(value) => (*value).into(),
        Field::UShort(value) => (*value).into(),
        Field::UInt(value) => (*value).into(),
        _ => return None,
    })
}
