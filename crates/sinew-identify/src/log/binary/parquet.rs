//! Parquet: streamed row by row, only the columns that are needed.

use super::panics::catch_panic;
use super::parquet_bounds;
use crate::Error;
use crate::log::table::{Requested, Table, TableBuilder};
use bytes::Bytes;
use parquet::basic::{LogicalType, TimeUnit};
use parquet::errors::ParquetError;
use parquet::file::reader::{ChunkReader, FileReader, SerializedFileReader};
use parquet::record::{Field, Row};
use parquet::schema::types::Type;
use std::borrow::Cow;
use std::sync::Arc;

const EXPECTED: &str = "a Parquet file";

/// A Parquet file of which the columns are known.
pub(in crate::log) struct ParquetLog {
    file: String,
    reader: Box<dyn FileReader>,
    columns: Vec<String>,
    rows: u64,
}

impl ParquetLog {
    /// Reads the footer of a file.
    pub(in crate::log) fn open(file: &str, path: &std::path::Path) -> Result<Self, Error> {
        let unreadable = |source| Error::Unreadable { file: file.to_owned(), source };
        let handle = std::fs::File::open(path).map_err(unreadable)?;
        let again = handle.try_clone().map_err(unreadable)?;
        catch_panic(file, EXPECTED, || Self::checked(file, &handle, again))
    }

    /// Reads the footer of a file in memory.
    pub(in crate::log) fn from_bytes(file: &str, bytes: Vec<u8>) -> Result<Self, Error> {
        let bytes = Bytes::from(bytes);
        catch_panic(file, EXPECTED, || Self::checked(file, &bytes.clone(), bytes))
    }

    /// `source` and `again` are the same file: one to check its promises, one for the reader to keep.
    fn checked<R: ChunkReader + 'static>(file: &str, source: &R, again: R) -> Result<Self, Error> {
        let refused =
            |got| Error::Malformed { file: file.into(), line: None, expected: EXPECTED.into(), got };
        parquet_bounds::footer(source).map_err(refused)?;
        let reader = SerializedFileReader::new(again).map_err(|e| damaged(file, &e))?;
        parquet_bounds::pages(source, reader.metadata()).map_err(refused)?;
        let metadata = reader.metadata().file_metadata();
        let fields = metadata.schema_descr().root_schema().get_fields();
        let columns = fields.iter().map(|f| f.name().to_owned()).collect();
        let rows = u64::try_from(metadata.num_rows()).unwrap_or(0);
        Ok(Self { file: file.to_owned(), reader: Box::new(reader), columns, rows })
    }

    /// Column names.
    pub(in crate::log) fn columns(&self) -> &[String] {
        &self.columns
    }

    /// Whether a column is declared as stamps of time, which are read in seconds.
    pub(in crate::log) fn is_stamped(&self, column: usize) -> bool {
        self.timestamp_unit(column).is_some()
    }

    fn timestamp_unit(&self, column: usize) -> Option<TimeUnit> {
        let schema = self.reader.metadata().file_metadata().schema_descr().root_schema();
        match schema.get_fields().get(column)?.get_basic_info().logical_type_ref()? {
            LogicalType::Timestamp(stamp) => Some(stamp.unit),
            _ => None,
        }
    }

    /// Number of rows.
    pub(in crate::log) fn rows(&self) -> u64 {
        self.rows
    }

    /// Reads what is `requested`.
    pub(in crate::log) fn read(self, requested: &Requested) -> Result<Table, Error> {
        catch_panic(&self.file, EXPECTED, || self.rows_of(requested))
    }

    fn rows_of(&self, requested: &Requested) -> Result<Table, Error> {
        // Columns that are read, in the order of the file, and where each stands in a row.
        let mut needed: Vec<usize> = requested.numbers.clone();
        needed.extend(requested.trial.iter().chain(&requested.group).chain(&requested.candidates));
        needed.sort_unstable();
        needed.dedup();
        let place = |column: usize| needed.binary_search(&column).unwrap_or(0);
        let projection = self.projection(&needed)?;
        let rows = self.reader.get_row_iter(Some(projection)).map_err(|e| damaged(&self.file, &e))?;
        let mut builder = TableBuilder::new(requested);
        for (index, row) in rows.enumerate() {
            let row = row.map_err(|e| damaged(&self.file, &e))?;
            let fields: Vec<&Field> = row.get_column_iter().map(|(_, field)| field).collect();
            if fields.len() != needed.len() {
                return Err(self.malformed(needed.len(), &row));
            }
            builder.begin(index + 1);
            if let Some(column) = requested.trial {
                builder.trial(label(fields[place(column)]).as_bytes());
            }
            if let Some(column) = requested.group {
                builder.group(label(fields[place(column)]).as_bytes());
            }
            for (k, &column) in requested.numbers.iter().enumerate() {
                builder.number(k, self.number(fields[place(column)], column, index + 1)?);
            }
            builder.candidates(|column| Cow::Owned(label(fields[place(column)]).into_bytes()));
        }
        Ok(builder.finish(Vec::new()))
    }

    fn projection(&self, needed: &[usize]) -> Result<Type, Error> {
        let schema = self.reader.metadata().file_metadata().schema_descr().root_schema();
        let fields = schema.get_fields();
        let kept: Vec<Arc<Type>> = needed.iter().filter_map(|&c| fields.get(c).cloned()).collect();
        Type::group_type_builder(schema.name()).with_fields(kept).build().map_err(|e| damaged(&self.file, &e))
    }

    fn malformed(&self, expected: usize, row: &Row) -> Error {
        Error::Malformed {
            file: self.file.clone(),
            line: None,
            expected: format!("{expected} columns in every row"),
            got: row.len().to_string(),
        }
    }

    fn number(&self, field: &Field, column: usize, line: usize) -> Result<f64, Error> {
        // The reader has no type of its own for stamps in nanoseconds.
        let nanoseconds =
            matches!(field, Field::Long(_)) && self.timestamp_unit(column) == Some(TimeUnit::NANOS);
        let (file, column) = (self.file.clone(), self.columns[column].clone());
        match numeric(field).map(|value| if nanoseconds { value * 1e-9 } else { value }) {
            Some(value) if value.is_infinite() => {
                Err(Error::NotFinite { file, line, column, value: value.to_string() })
            }
            Some(value) => Ok(value),
            None => {
                let value = field.to_string().chars().take(60).collect();
                Err(Error::NotANumber { file, line, column, value })
            }
        }
    }
}

fn damaged(file: &str, error: &ParquetError) -> Error {
    Error::Malformed {
        file: file.into(),
        line: None,
        expected: EXPECTED.into(),
        got: format!("a damaged one, or one packed in a way that is not built in ({error})"),
    }
}

/// The number in a field; NaN where there is none; nothing where it is no number.
///
/// Times become seconds: a Parquet file declares the unit.
fn numeric(field: &Field) -> Option<f64> {
    Some(match *field {
        Field::Null => f64::NAN,
        Field::Bool(x) => f64::from(u8::from(x)),
        Field::Byte(x) => f64::from(x),
        Field::Short(x) => f64::from(x),
        Field::Int(x) => f64::from(x),
        Field::Long(x) => x as f64,
        Field::UByte(x) => f64::from(x),
        Field::UShort(x) => f64::from(x),
        Field::UInt(x) => f64::from(x),
        Field::ULong(x) => x as f64,
        Field::Float(x) => f64::from(x),
        Field::Double(x) => x,
        Field::Float16(x) => f64::from(x),
        Field::TimestampMillis(x) => x as f64 * 1e-3,
        Field::TimestampMicros(x) => x as f64 * 1e-6,
        _ => return None,
    })
}

/// A field as a label.
fn label(field: &Field) -> String {
    match field {
        Field::Null => String::new(),
        Field::Str(text) => text.clone(),
        other => match numeric(other) {
            Some(value) => value.to_string(),
            None => other.to_string(),
        },
    }
}
