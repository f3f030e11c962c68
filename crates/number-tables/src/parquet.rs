//! Tables of Apache Parquet, read row by row.

use std::fs::File;
use std::path::Path;

use crate::files;
use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::{Field, Row};

/// A Parquet file that is read row by row.
pub struct ParquetFile {
    reader: SerializedFileReader<File>,
}

impl ParquetFile {
    /// Opens a file.
    ///
    /// # Errors
    /// When there is none, or it is none of Parquet.
    pub fn open(path: &Path) -> Result<Self, String> {
        let file = files::open(path).map_err(|error| files::reason(path, &error))?;
        let reader = SerializedFileReader::new(file).map_err(|error| one_line(&error))?;
        Ok(Self { reader })
    }

    /// The names of the columns.
    pub fn names(&self) -> Vec<String> {
        let schema = self.reader.metadata().file_metadata().schema();
        let fields = schema.get_fields().iter();
        fields.map(|field| field.name().to_owned()).collect()
    }

    /// The rows, in order.
    ///
    /// # Errors
    /// When they cannot be read.
    pub fn rows(&self) -> Result<impl Iterator<Item = Result<Vec<Field>, String>>, String> {
        let rows = self.reader.get_row_iter(None);
        let rows = rows.map_err(|error| one_line(&error))?;
        let cells = |row: Row| {
            row.into_columns()
                .into_iter()
                .map(|(_, cell)| cell)
                .collect()
        };
        Ok(rows.map(move |row| row.map(cells).map_err(|error| one_line(&error))))
    }
}

/// The error's message on one line.
pub fn one_line(error: &ParquetError) -> String {
    let text = error.to_string();
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// A cell as a number.
#[allow(clippy::cast_precision_loss)]
pub fn number(cell: &Field) -> Option<f64> {
    Some(match cell {
        Field::Double(value) => *value,
        Field::Float(value) => f64::from(*value),
        Field::Bool(value) => f64::from(u8::from(*value)),
        Field::Long(value) => *value as f64,
        Field::ULong(value) => *value as f64,
        other => integer(other)? as f64,
    })
}

/// A cell as a count.
pub fn whole(cell: &Field) -> Option<u64> {
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
