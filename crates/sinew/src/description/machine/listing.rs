//! Every value of a machine with the place it comes from, in the order of reading.

use crate::description::document::Table;
use crate::description::error::DescriptionError;
use alloc::string::{String, ToString};
use alloc::vec::Vec;

/// Where a value of a machine comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ValueSource {
    /// A line of the machine file.
    File {
        /// From 1.
        line: usize,
    },
    /// The description of the body.
    Body,
    /// The identified model of the cable.
    Model,
    /// The catalogue of drives.
    Catalogue,
    /// None of them says it.
    Default,
}

/// A value as it holds.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// A number in the unit that the key names.
    Number(f64),
    /// Several numbers.
    Numbers(Vec<f64>),
    /// A name or a word.
    Text(String),
    /// Several names.
    Texts(Vec<String>),
    /// None; what follows from that is documented with the field.
    None,
}

/// A value of a machine.
#[derive(Debug, Clone, PartialEq)]
pub struct Setting {
    /// Table of the machine file and what it is about: `[[transmission]] `biceps``.
    pub table: String,
    /// Key in that table; dots separate inner tables.
    pub key: String,
    /// The value.
    pub value: Value,
    /// Where it comes from.
    pub source: ValueSource,
}

/// Settings while they are read.
#[derive(Debug, Default)]
pub struct Listing {
    pub(super) settings: Vec<Setting>,
    table: String,
}

impl Listing {
    /// Settings from here on belong to this table.
    pub(super) fn begin(&mut self, table: &str) {
        self.table = table.to_string();
    }

    /// Adds a value of the present table.
    pub fn add(&mut self, key: &str, value: Value, source: ValueSource) {
        self.settings.push(Setting { table: self.table.clone(), key: key.to_string(), value, source });
    }

    /// Adds a number.
    pub fn number(&mut self, key: &str, value: f64, source: ValueSource) {
        self.add(key, Value::Number(value), source);
    }

    pub(super) fn optional(&mut self, key: &str, value: Option<f64>, source: ValueSource) {
        self.add(key, value.map_or(Value::None, Value::Number), source);
    }

    /// Adds a text.
    pub fn text(&mut self, key: &str, value: &str, source: ValueSource) {
        self.add(key, Value::Text(value.to_string()), source);
    }

    /// Reads one of some words, the one of this index where the key is missing, and adds it: its index.
    ///
    /// # Errors
    /// Another word.
    pub fn word(
        &mut self,
        table: &Table<'_>,
        key: &str,
        (words, default): (&[&str], usize),
    ) -> Result<usize, DescriptionError> {
        let entry = table.entry(key);
        let chosen = entry.as_ref().map_or(Ok(default), |entry| entry.name(key, words))?;
        self.text(key, words[chosen], source_of(entry.map(|entry| entry.line())));
        Ok(chosen)
    }
}

/// File and line of an entry, else a default.
#[must_use]
pub fn source_of(line: Option<usize>) -> ValueSource {
    line.map_or(ValueSource::Default, |line| ValueSource::File { line })
}
