//! Turns a csv table into Apache Parquet: columns with types, compressed, as pandas, DuckDB and Spark read them.

use std::fs::File;
use std::io;
use std::path::Path;
use std::sync::Arc;

use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use parquet::column::writer::ColumnWriter;
use parquet::data_type::ByteArray;
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use crate::csv_file;
use crate::parquet::one_line;

/// Rows that are held in memory at a time.
const GROUP: usize = 1 << 16;

/// Type of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Whole numbers.
    Count,
    /// Numbers; a cell may be empty.
    Number,
    /// `true` or `false`.
    Flag,
    /// Texts.
    Text,
}

/// Writes the rows of a csv table as Parquet; `kind` is the type of the column at a place among so many.
///
/// # Errors
/// When the table cannot be read or the file not be written.
pub fn convert(table: &Path, into: File, kind: impl Fn(usize, usize) -> Kind) -> io::Result<()> {
    let attempt = || -> Result<(), ParquetError> {
        let mut table = csv::Reader::from_path(table).map_err(other)?;
        let header = table.headers().map_err(other)?.clone();
        let width = header.len();
        let kinds: Vec<Kind> = (0..width).map(|place| kind(place, width)).collect();
        let schema = Arc::new(schema(&header, &kinds)?);
        let settings = WriterProperties::builder().set_compression(Compression::SNAPPY);
        let mut writer = SerializedFileWriter::new(into, schema, Arc::new(settings.build()))?;
        let mut rows = table.records();
        loop {
            let group = rows.by_ref().take(GROUP);
            let group: Vec<_> = group.collect::<Result<_, _>>().map_err(other)?;
            if group.is_empty() {
                break;
            }
            write_group(&mut writer, &kinds, &group)?;
        }
        writer.close().map(drop)
    };
    attempt().map_err(|error| match error {
        ParquetError::External(source) => match source.downcast::<io::Error>() {
            Ok(error) => *error,
            Err(source) => io::Error::other(source.to_string()),
        },
        error => io::Error::other(one_line(&error)),
    })
}

fn other(error: csv::Error) -> ParquetError {
    ParquetError::External(Box::new(io::Error::from(error)))
}

fn schema(header: &csv::StringRecord, kinds: &[Kind]) -> Result<Type, ParquetError> {
    let column = |(name, kind): (&str, &Kind)| {
        let physical = match kind {
            Kind::Count => Physical::INT64,
            Kind::Number => Physical::DOUBLE,
            Kind::Flag => Physical::BOOLEAN,
            Kind::Text => Physical::BYTE_ARRAY,
        };
        let repetition = if *kind == Kind::Number {
            // A point that failed has no values.
            Repetition::OPTIONAL
        } else {
            Repetition::REQUIRED
        };
        let name = csv_file::text(name);
        let builder = Type::primitive_type_builder(&name, physical).with_repetition(repetition);
        let logical = (*kind == Kind::Text).then_some(LogicalType::String);
        builder.with_logical_type(logical).build().map(Arc::new)
    };
    let columns = header.iter().zip(kinds).map(column).collect::<Result<_, _>>()?;
    Type::group_type_builder("points").with_fields(columns).build()
}

fn write_group(
    writer: &mut SerializedFileWriter<File>,
    kinds: &[Kind],
    rows: &[csv::StringRecord],
) -> Result<(), ParquetError> {
    let mut group = writer.next_row_group()?;
    for place in 0..kinds.len() {
        let cells = rows.iter().map(|row| row.get(place).unwrap_or(""));
        let Some(mut column) = group.next_column()? else {
            break;
        };
        match column.untyped() {
            ColumnWriter::Int64ColumnWriter(column) => {
                let values: Vec<i64> = cells.map(|cell| cell.parse().unwrap_or(-1)).collect();
                column.write_batch(&values, None, None)?;
            }
            ColumnWriter::DoubleColumnWriter(column) => {
                let numbers: Vec<Option<f64>> = cells.map(|cell| cell.parse().ok()).collect();
                let values: Vec<f64> = numbers.iter().flatten().copied().collect();
                let present: Vec<i16> = numbers.iter().map(|n| n.is_some().into()).collect();
                column.write_batch(&values, Some(&present), None)?;
            }
            ColumnWriter::BoolColumnWriter(column) => {
                let values: Vec<bool> = cells.map(|cell| cell == "true").collect();
                column.write_batch(&values, None, None)?;
            }
            ColumnWriter::ByteArrayColumnWriter(column) => {
                let text = |cell| ByteArray::from(&*csv_file::text(cell));
                let values: Vec<ByteArray> = cells.map(text).collect();
                column.write_batch(&values, None, None)?;
            }
            _ => {}
        }
        column.close()?;
    }
    group.close().map(drop)
}
