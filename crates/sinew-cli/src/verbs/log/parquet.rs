//! A table as Parquet: one column of doubles per signal, NaN where there is no number.

use super::rows::{Given, Rows};
use crate::error::Error;
use parquet::basic::{Compression, Repetition, Type as PhysicalType};
use parquet::data_type::DoubleType;
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use std::path::Path;
use std::sync::Arc;

/// Rows of a group, which are in memory at once.
const GROUP: usize = 100_000;

pub(super) fn write(to: &mut std::fs::File, out: &Path, file: &Path, rows: Rows<'_>) -> Result<Given, Error> {
    let refuse = |error: ParquetError| Error::Unwritable {
        file: out.to_owned(),
        source: std::io::Error::other(error.to_string()),
    };
    let field = |name: &str| {
        let kind = Type::primitive_type_builder(name, PhysicalType::DOUBLE);
        Ok(Arc::new(kind.with_repetition(Repetition::REQUIRED).build()?))
    };
    let fields: Result<Vec<_>, ParquetError> =
        rows.columns.iter().map(|column| field(&column.name)).collect();
    let schema = Type::group_type_builder("cycles").with_fields(fields.map_err(refuse)?).build();
    let properties = WriterProperties::builder().set_compression(Compression::SNAPPY).build();
    let mut writer = SerializedFileWriter::new(to, Arc::new(schema.map_err(refuse)?), Arc::new(properties))
        .map_err(refuse)?;
    let mut group: Vec<Vec<f64>> = vec![Vec::new(); rows.columns.len()];
    let given = rows.each(file, |_, row| {
        group.iter_mut().zip(row).for_each(|(column, value)| column.push(*value));
        if group.first().is_some_and(|column| column.len() == GROUP) {
            put(&mut writer, &mut group).map_err(refuse)?;
        }
        Ok(())
    })?;
    if group.first().is_some_and(|column| !column.is_empty()) {
        put(&mut writer, &mut group).map_err(refuse)?;
    }
    writer.close().map_err(refuse)?;
    Ok(given)
}

fn put(
    writer: &mut SerializedFileWriter<&mut std::fs::File>,
    group: &mut [Vec<f64>],
) -> Result<(), ParquetError> {
    let mut to = writer.next_row_group()?;
    for values in group.iter_mut() {
        let Some(mut column) = to.next_column()? else { break };
        column.typed::<DoubleType>().write_batch(values, None, None)?;
        column.close()?;
        values.clear();
    }
    to.close().map(drop)
}
