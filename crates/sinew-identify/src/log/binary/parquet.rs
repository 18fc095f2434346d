//! Parquet: streamed row by row, only the columns that are needed.

use super::guarded;
use crate::Error;
use crate::log::table::{Table, TableBuilder, Wanted};
use bytes::Bytes;
use parquet::column::page::Page;
use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader, SerializedFileReader};
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
        guarded(file, EXPECTED, || {
            let reader = SerializedFileReader::new(handle).map_err(|e| damaged(file, &e))?;
            Self::new(file, Box::new(reader))
        })
    }

    /// Reads the footer of a file in memory.
    pub(in crate::log) fn from_bytes(file: &str, bytes: Vec<u8>) -> Result<Self, Error> {
        guarded(file, EXPECTED, || {
            let reader = SerializedFileReader::new(Bytes::from(bytes)).map_err(|e| damaged(file, &e))?;
            Self::new(file, Box::new(reader))
        })
    }

    fn new(file: &str, reader: Box<dyn FileReader>) -> Result<Self, Error> {
        plausible(file, reader.as_ref())?;
        let metadata = reader.metadata().file_metadata();
        let fields = metadata.schema_descr().root_schema().get_fields();
        let columns = fields.iter().map(|f| f.name().to_owned()).collect();
        let rows = u64::try_from(metadata.num_rows()).unwrap_or(0);
        Ok(Self { file: file.to_owned(), reader, columns, rows })
    }

    /// Column names.
    pub(in crate::log) fn columns(&self) -> &[String] {
        &self.columns
    }

    /// Number of rows.
    pub(in crate::log) fn rows(&self) -> u64 {
        self.rows
    }

    /// Reads what is `wanted`.
    pub(in crate::log) fn read(self, wanted: &Wanted) -> Result<Table, Error> {
        guarded(&self.file, EXPECTED, || self.rows_of(wanted))
    }

    fn rows_of(&self, wanted: &Wanted) -> Result<Table, Error> {
        // Columns that are read, in the order of the file, and where each stands in a row.
        let mut needed: Vec<usize> = wanted.numbers.clone();
        needed.extend(wanted.trial.iter().chain(&wanted.group).chain(&wanted.candidates));
        needed.sort_unstable();
        needed.dedup();
        let place = |column: usize| needed.binary_search(&column).unwrap_or(0);
        self.check_dictionaries(&needed)?;
        let projection = self.projection(&needed)?;
        let rows = self.reader.get_row_iter(Some(projection)).map_err(|e| damaged(&self.file, &e))?;
        let mut builder = TableBuilder::new(wanted);
        for (index, row) in rows.enumerate() {
            let row = row.map_err(|e| damaged(&self.file, &e))?;
            let fields: Vec<&Field> = row.get_column_iter().map(|(_, field)| field).collect();
            if fields.len() != needed.len() {
                return Err(self.malformed(needed.len(), &row));
            }
            builder.begin(index + 1);
            if let Some(column) = wanted.trial {
                builder.trial(label(fields[place(column)]).as_bytes());
            }
            if let Some(column) = wanted.group {
                builder.group(label(fields[place(column)]).as_bytes());
            }
            for (k, &column) in wanted.numbers.iter().enumerate() {
                builder.number(k, self.number(fields[place(column)], column, index + 1)?);
            }
            builder.candidates(|column| Cow::Owned(label(fields[place(column)]).into_bytes()));
        }
        Ok(builder.finish(Vec::new()))
    }

    /// Refuses a dictionary that says it holds more values than it has bytes: its reader would make room for them.
    fn check_dictionaries(&self, needed: &[usize]) -> Result<(), Error> {
        let schema = self.reader.metadata().file_metadata().schema_descr();
        let broken = |e: ParquetError| damaged(&self.file, &e);
        for group in 0..self.reader.num_row_groups() {
            let group = self.reader.get_row_group(group).map_err(broken)?;
            for leaf in 0..group.num_columns().min(schema.num_columns()) {
                if needed.binary_search(&schema.get_column_root_idx(leaf)).is_err() {
                    continue;
                }
                let mut pages = group.get_column_page_reader(leaf).map_err(broken)?;
                while let Some(next) = pages.peek_next_page().map_err(broken)? {
                    if !next.is_dict {
                        pages.skip_next_page().map_err(broken)?;
                        continue;
                    }
                    let page = pages.get_next_page().map_err(broken)?;
                    if let Some(Page::DictionaryPage { buf, num_values, .. }) = page
                        && num_values as usize > buf.len()
                    {
                        return Err(Error::Malformed {
                            file: self.file.clone(),
                            line: None,
                            expected: EXPECTED.into(),
                            got: format!("a dictionary of {num_values} values in {} bytes", buf.len()),
                        });
                    }
                }
            }
        }
        Ok(())
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
        let (file, column) = (self.file.clone(), self.columns[column].clone());
        match numeric(field) {
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

/// Refuses a footer whose columns lie before the file: its reader would not return from them.
fn plausible(file: &str, reader: &dyn FileReader) -> Result<(), Error> {
    let groups = reader.metadata().row_groups().iter();
    let lies = |start: i64, length: i64| start < 0 || length < 0;
    for column in groups.flat_map(|group| group.columns()) {
        let start = column.dictionary_page_offset().unwrap_or(0).min(column.data_page_offset());
        if lies(start, column.compressed_size()) {
            return Err(Error::Malformed {
                file: file.into(),
                line: None,
                expected: EXPECTED.into(),
                got: format!("one whose footer places column `{}` before its start", column.column_path()),
            });
        }
    }
    Ok(())
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
/// Times become seconds: a Parquet file says what its numbers mean.
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
