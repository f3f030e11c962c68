//! Csv tables as Apache Parquet, with columns of types as pandas, DuckDB and Spark write them.

use std::fs::File;
use std::path::Path;
use std::sync::Arc;

use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use parquet::column::writer::ColumnWriter;
use parquet::data_type::ByteArray;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

/// The type of a column whose cells are these, and whether any is empty: of numbers only then.
fn kind(name: &str, cells: &[&str]) -> (Physical, Repetition) {
    let all = |is: &dyn Fn(&str) -> bool| cells.iter().all(|cell| is(cell));
    if name == "point" {
        (Physical::INT64, Repetition::REQUIRED)
    } else if all(&|cell| ["true", "false"].contains(&cell)) {
        (Physical::BOOLEAN, Repetition::REQUIRED)
    } else if all(&|cell| cell.is_empty() || cell.parse::<f64>().is_ok()) {
        (Physical::DOUBLE, Repetition::OPTIONAL)
    } else {
        (Physical::BYTE_ARRAY, Repetition::REQUIRED)
    }
}

/// Writes the rows of a csv table as Parquet.
pub fn convert(table: &Path, into: &Path) {
    let mut table = csv::Reader::from_path(table).unwrap();
    let header = table.headers().unwrap().clone();
    let rows: Vec<csv::StringRecord> = table.records().collect::<Result<_, _>>().unwrap();
    let columns: Vec<Vec<&str>> = (0..header.len()).map(|k| rows.iter().map(|row| &row[k]).collect()).collect();
    let fields = header.iter().zip(&columns).map(|(name, cells)| {
        let (physical, repetition) = kind(name, cells);
        let field = Type::primitive_type_builder(name, physical).with_repetition(repetition);
        let logical = (physical == Physical::BYTE_ARRAY).then_some(LogicalType::String);
        Arc::new(field.with_logical_type(logical).build().unwrap())
    });
    let schema = Type::group_type_builder("points").with_fields(fields.collect()).build().unwrap();
    let settings = WriterProperties::builder().set_compression(Compression::SNAPPY).build();
    let mut writer =
        SerializedFileWriter::new(File::create(into).unwrap(), Arc::new(schema), Arc::new(settings)).unwrap();
    let mut group = writer.next_row_group().unwrap();
    for cells in &columns {
        let mut column = group.next_column().unwrap().unwrap();
        match column.untyped() {
            ColumnWriter::Int64ColumnWriter(column) => {
                let values: Vec<i64> = cells.iter().map(|cell| cell.parse().unwrap()).collect();
                column.write_batch(&values, None, None).unwrap();
            }
            ColumnWriter::DoubleColumnWriter(column) => {
                let numbers: Vec<Option<f64>> = cells.iter().map(|cell| cell.parse().ok()).collect();
                let values: Vec<f64> = numbers.iter().flatten().copied().collect();
                let present: Vec<i16> = numbers.iter().map(|number| number.is_some().into()).collect();
                column.write_batch(&values, Some(&present), None).unwrap();
            }
            ColumnWriter::BoolColumnWriter(column) => {
                let values: Vec<bool> = cells.iter().map(|cell| *cell == "true").collect();
                column.write_batch(&values, None, None).unwrap();
            }
            ColumnWriter::ByteArrayColumnWriter(column) => {
                let values: Vec<ByteArray> = cells.iter().map(|cell| ByteArray::from(*cell)).collect();
                column.write_batch(&values, None, None).unwrap();
            }
            _ => unreachable!("no other type is written"),
        }
        column.close().unwrap();
    }
    group.close().unwrap();
    writer.close().unwrap();
}
