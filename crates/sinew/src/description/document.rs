//! A TOML document whose values know their line, and typed access to them with one wording of errors.

use super::domain::{AT_MOST_LARGEST, Domain, LARGEST};
use crate::Error;
use crate::description::attributes::shortened;
use crate::description::error::DescriptionError;
use crate::description::spelling;
use alloc::collections::BTreeMap;
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Keys that had another name in the version before, which is still read.
const FORMER: [(&str, &str); 5] = [
    ("max_tension_n", "most_tension_n"),
    ("min_tension_n", "least_tension_n"),
    ("wind_in_speed_rad_per_s", "take_up_speed_rad_per_s"),
    ("backlash_gain", "pre_travel_gain"),
    ("backlash_integral_per_s", "pre_travel_integral_per_s"),
];

/// The present name of a key that a file has.
fn present(written: &str) -> &str {
    FORMER.iter().find(|(_, former)| *former == written).map_or(written, |(present, _)| present)
}

/// Name and text of a file.
#[derive(Debug)]
pub(in crate::description) struct Document<'a> {
    file: &'a str,
    text: &'a str,
    /// Offsets of the ends of lines.
    ends: Vec<usize>,
}

impl<'a> Document<'a> {
    pub(in crate::description) fn new(file: &'a str, text: &'a str) -> Self {
        let ends = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n').map(|(at, _)| at).collect();
        Self { file, text, ends }
    }

    pub(in crate::description) fn parse(&self) -> Result<Spanned<DeTable<'a>>, DescriptionError> {
        DeTable::parse(self.text).map_err(|error| {
            let at = error.span().map_or(0, |span| span.start);
            let start = self.text.get(..at).and_then(|before| before.rfind('\n')).map_or(0, |i| i + 1);
            let column = self.text.get(start..at).map_or(0, |before| before.chars().count()) + 1;
            self.error(at, &format!("column {column}"), error.message())
        })
    }

    /// The table of the whole document; errors name it as what it describes.
    pub(in crate::description) fn root<'d>(
        &'d self,
        table: &'d Spanned<DeTable<'a>>,
        described: &str,
    ) -> Table<'d> {
        Table {
            document: self,
            entries: table.get_ref(),
            at: 0,
            outermost: true,
            place: described.to_string(),
        }
    }

    fn line(&self, at: usize) -> usize {
        self.ends.partition_point(|&end| end < at) + 1
    }

    pub(in crate::description) fn error(&self, at: usize, place: &str, problem: &str) -> DescriptionError {
        let (file, line) = (self.file.to_string(), self.line(at));
        DescriptionError { file, line, place: place.to_string(), problem: problem.to_string() }
    }
}

/// A table of a document.
#[derive(Debug, Clone)]
pub struct Table<'d> {
    document: &'d Document<'d>,
    entries: &'d DeTable<'d>,
    at: usize,
    outermost: bool,
    /// As errors name it.
    pub(in crate::description) place: String,
}

impl<'d> Table<'d> {
    /// Refuses keys that are none of the known ones.
    ///
    /// # Errors
    /// The first such key, with the one that was probably meant.
    pub fn check_keys(&self, known: &[&str]) -> Result<(), DescriptionError> {
        let unknown = |key: &&Spanned<_>| {
            let key: &alloc::borrow::Cow<'_, str> = Spanned::get_ref(key);
            !known.contains(&present(key))
        };
        // The first in the file, not in the alphabet.
        let Some(key) = self.entries.keys().filter(unknown).min_by_key(|key| key.span().start) else {
            return self.check_former_keys();
        };
        let expected = spelling::expected(key.get_ref(), known);
        let problem = format!("`{}` is no key of it{expected}", shortened(key.get_ref()));
        Err(self.document.error(key.span().start, &self.place, &problem))
    }

    /// Refuses a key that stands there under its present and under its former name.
    fn check_former_keys(&self) -> Result<(), DescriptionError> {
        for (now, former) in FORMER {
            if let (true, Some((key, _))) =
                (self.entries.contains_key(now), self.entries.get_key_value(former))
            {
                let problem = format!("`{former}` is the former name of `{now}`, which is there, too");
                return Err(self.document.error(key.span().start, &self.place, &problem));
            }
        }
        Ok(())
    }

    /// The value of a key, under its present or its former name.
    #[must_use]
    pub fn entry(&self, key: &str) -> Option<Entry<'d>> {
        let (key, value) = self.entries.iter().find(|(known, _)| present(known.get_ref()) == key)?;
        Some(Entry { document: self.document, place: self.place.clone(), key: key.get_ref(), value })
    }

    /// The value of a key that has to be there.
    ///
    /// # Errors
    /// It is missing.
    pub fn required(&self, key: &str) -> Result<Entry<'d>, DescriptionError> {
        self.entry(key).ok_or_else(|| self.error(&format!("{key} is missing")))
    }

    /// All entries in the order of the file.
    pub(in crate::description) fn entries(&self) -> Vec<Entry<'d>> {
        let mut entries: Vec<_> = self.entries.iter().collect();
        entries.sort_by_key(|(key, _)| key.span().start);
        let entry = |(key, value): (&'d Spanned<_>, _)| {
            let key: &'d alloc::borrow::Cow<'_, str> = Spanned::get_ref(key);
            Entry { document: self.document, place: self.place.clone(), key, value }
        };
        entries.into_iter().map(entry).collect()
    }

    /// The table at a key, with the same name as the key in errors.
    ///
    /// # Errors
    /// Something else stands there.
    pub fn table(&self, key: &str) -> Result<Option<Table<'d>>, DescriptionError> {
        let Some(entry) = self.entry(key) else { return Ok(None) };
        let place = if self.outermost { format!("[{key}]") } else { format!("{}: {key}", self.place) };
        entry.table(place).map(Some)
    }

    /// The tables `[[key]]` with these keys, each named by the text at `name`, of which no two are
    /// the same.
    pub(in crate::description) fn tables(
        &self,
        key: &str,
        name: &str,
        known: &[&str],
    ) -> Result<Vec<(Table<'d>, Named)>, DescriptionError> {
        self.tables_with(key, name, Some(known))
    }

    /// As [`Table::tables`]; without known keys, with any.
    pub(in crate::description) fn tables_with(
        &self,
        key: &str,
        name: &str,
        known: Option<&[&str]>,
    ) -> Result<Vec<(Table<'d>, Named)>, DescriptionError> {
        let tables = self.read_tables(key, name, known)?;
        let mut lines: BTreeMap<&str, usize> = BTreeMap::new();
        for (table, Named { text, line }) in &tables {
            if let Some(other) = lines.insert(text, *line) {
                let expected = format!("a {name} of its own, not that of line {other}");
                return Err(table.required(name)?.refuse(&expected));
            }
        }
        Ok(tables)
    }

    /// As [`Table::tables`], where several may have the same text at `about`.
    pub(in crate::description) fn tables_about(
        &self,
        key: &str,
        about: &str,
        known: &[&str],
    ) -> Result<Vec<(Table<'d>, Named)>, DescriptionError> {
        self.read_tables(key, about, Some(known))
    }

    fn read_tables(
        &self,
        key: &str,
        about: &str,
        known: Option<&[&str]>,
    ) -> Result<Vec<(Table<'d>, Named)>, DescriptionError> {
        let Some(entry) = self.entry(key) else { return Ok(Vec::new()) };
        let read = |mut table: Table<'d>| {
            let named = table.entry(about);
            let text = named.as_ref().and_then(|named| named.value.get_ref().as_str());
            if let Some(text) = text {
                table.place = format!("[[{key}]] `{}`", shortened(text));
            }
            known.map_or(Ok(()), |known| table.check_keys(known))?;
            let named = table.required(about)?;
            let text = named.text("a name")?.to_string();
            Ok((table, Named { text, line: named.line() }))
        };
        let place = format!("[[{key}]]");
        entry.array_of_tables(&place, &format!("tables {place}"))?.into_iter().map(read).collect()
    }

    /// The line of its head.
    pub(in crate::description) fn line(&self) -> usize {
        self.document.line(self.at)
    }

    pub(in crate::description) fn file(&self) -> &'d str {
        self.document.file
    }

    pub(in crate::description) fn text(&self) -> &'d str {
        self.document.text
    }

    pub(in crate::description) fn error(&self, problem: &str) -> DescriptionError {
        self.document.error(self.at, &self.place, problem)
    }

    /// An error of the physics at the key of the quantity that it names, or of the table.
    pub(in crate::description) fn out_of_domain(&self, error: Error) -> DescriptionError {
        let name = match error {
            Error::OutOfDomain { name, .. } | Error::EntryOutOfDomain { name, .. } => name,
            _ => "",
        };
        let word = name.rsplit('.').next().unwrap_or(name).replace(' ', "_");
        let is =
            |key: &str| key.strip_prefix(&*word).is_some_and(|rest| rest.is_empty() || rest.starts_with('_'));
        match self.entries().into_iter().find(|entry| !word.is_empty() && is(present(entry.key))) {
            Some(Entry { key, value, .. }) => {
                let problem = format!("{key} is {}: {error}", self.document.written(value));
                self.document.error(value.span().start, &self.place, &problem)
            }
            None => self.error(&error.to_string()),
        }
    }
}

/// A name and its line.
#[derive(Debug, Clone)]
pub(in crate::description) struct Named {
    pub(in crate::description) text: String,
    pub(in crate::description) line: usize,
}

impl Document<'_> {
    /// A value as it stands in the file, on one line.
    fn written(&self, value: &Spanned<DeValue<'_>>) -> String {
        let text = self.text.get(value.span()).unwrap_or("");
        shortened(&text.split_whitespace().collect::<Vec<_>>().join(" "))
    }
}

/// A key of a table with its value.
#[derive(Debug, Clone)]
pub struct Entry<'d> {
    document: &'d Document<'d>,
    place: String,
    pub(in crate::description) key: &'d str,
    value: &'d Spanned<DeValue<'d>>,
}

impl<'d> Entry<'d> {
    /// Of its value, from 1.
    #[must_use]
    pub fn line(&self) -> usize {
        self.document.line(self.value.span().start)
    }

    /// The error that the value is not what was expected.
    #[must_use]
    pub fn refuse(&self, expected: &str) -> DescriptionError {
        self.refuse_part(self.value, expected)
    }

    fn refuse_part(&self, part: &Spanned<DeValue<'_>>, expected: &str) -> DescriptionError {
        let problem = format!("{} is {}: expected {expected}", self.key, self.document.written(part));
        self.document.error(part.span().start, &self.place, &problem)
    }

    /// The error that the key has this problem, whatever its value.
    pub(in crate::description) fn bare(&self, problem: &str) -> DescriptionError {
        self.document.error(self.value.span().start, &self.place, problem)
    }

    /// The error that the value has this problem.
    pub(in crate::description) fn problem(&self, problem: &str) -> DescriptionError {
        let problem = format!("{} is {}{problem}", self.key, self.document.written(self.value));
        self.document.error(self.value.span().start, &self.place, &problem)
    }

    pub(in crate::description) fn is_text(&self) -> bool {
        self.value.get_ref().is_str()
    }

    /// Whether its value is a table.
    #[must_use]
    pub fn is_table(&self) -> bool {
        self.value.get_ref().is_table()
    }

    /// A text, which may be empty.
    pub(in crate::description) fn string(&self) -> Result<&'d str, DescriptionError> {
        self.value.get_ref().as_str().ok_or_else(|| self.refuse("a text in quotes"))
    }

    /// A text that is not empty.
    ///
    /// # Errors
    /// Something else.
    pub fn text(&self, expected: &str) -> Result<&'d str, DescriptionError> {
        let text = self.value.get_ref().as_str().filter(|text| !text.is_empty());
        text.ok_or_else(|| self.refuse(&format!("{expected} in quotes")))
    }

    /// `true` or `false`.
    ///
    /// # Errors
    /// Something else.
    pub fn flag(&self) -> Result<bool, DescriptionError> {
        self.value.get_ref().as_bool().ok_or_else(|| self.refuse("true or false"))
    }

    /// A number.
    ///
    /// # Errors
    /// Something else, or a number outside of its domain.
    pub fn number(&self, domain: Domain) -> Result<f64, DescriptionError> {
        self.checked(self.value, domain)
    }

    /// A number of this value or of a part of it.
    fn checked(&self, part: &Spanned<DeValue<'_>>, domain: Domain) -> Result<f64, DescriptionError> {
        match number(part).filter(|number| number.is_finite()) {
            Some(number) if number.abs() > LARGEST => Err(self.refuse_part(part, AT_MOST_LARGEST)),
            Some(number) if domain.contains(number) => Ok(number),
            _ => Err(self.refuse_part(part, domain.expected)),
        }
    }

    /// Several numbers, each of the same domain.
    ///
    /// # Errors
    /// As [`number`](Self::number), or another count of numbers.
    pub fn numbers<const N: usize>(&self, domain: Domain) -> Result<[f64; N], DescriptionError> {
        let all = || format!("{N} numbers, each {}", domain.expected);
        let array = self.value.get_ref().as_array().filter(|array| array.len() == N);
        let Some(array) = array else { return Err(self.refuse(&all())) };
        let mut numbers = [0.0; N];
        for (place, value) in numbers.iter_mut().zip(array.iter()) {
            *place = self.checked(value, domain)?;
        }
        Ok(numbers)
    }

    /// A list of lists of as many numbers.
    pub(in crate::description) fn rows<const N: usize>(
        &self,
        domain: Domain,
    ) -> Result<Vec<[f64; N]>, DescriptionError> {
        let rows = || format!("a list of lists of {N} numbers, each {}", domain.expected);
        let Some(array) = self.value.get_ref().as_array() else { return Err(self.refuse(&rows())) };
        let row = |value| Entry { document: self.document, place: self.place.clone(), key: self.key, value };
        array.iter().map(|value| row(value).numbers(domain)).collect()
    }

    /// A list of any number of numbers.
    pub(in crate::description) fn list(&self, domain: Domain) -> Result<Vec<f64>, DescriptionError> {
        let list = || format!("a list of numbers, each {}", domain.expected);
        let Some(array) = self.value.get_ref().as_array() else { return Err(self.refuse(&list())) };
        array.iter().map(|value| self.checked(value, domain)).collect()
    }

    /// One of the known words: its index.
    pub(in crate::description) fn word(&self, known: &[&str]) -> Result<usize, DescriptionError> {
        let Some(text) = self.value.get_ref().as_str() else {
            return Err(self.refuse(&format!("one of `{}`", known.join("`, `"))));
        };
        let place = known.iter().position(|word| *word == text);
        place.ok_or_else(|| self.problem(&spelling::expected(text, known)))
    }

    /// Words, each one of the known ones.
    pub(in crate::description) fn words(&self, known: &[&str]) -> Result<Vec<&'d str>, DescriptionError> {
        let expected = || format!("a list of some of `{}`", known.join("`, `"));
        let Some(array) = self.value.get_ref().as_array() else { return Err(self.refuse(&expected())) };
        let word = |value: &'d Spanned<DeValue<'d>>| {
            let word = value.get_ref().as_str().filter(|word| known.contains(word));
            word.ok_or_else(|| self.refuse_part(value, &expected()))
        };
        array.iter().map(word).collect()
    }

    /// One of the known names: its index.
    ///
    /// # Errors
    /// Another name, with the one that was probably meant.
    pub fn name(&self, kind: &str, known: &[&str]) -> Result<usize, DescriptionError> {
        let text = self.text(&format!("the name of a {kind}"))?;
        known.iter().position(|name| *name == text).ok_or_else(|| self.unknown_name(kind, known))
    }

    /// The error that nothing has this name.
    pub(in crate::description) fn unknown_name(&self, kind: &str, known: &[&str]) -> DescriptionError {
        let expected = spelling::expected(self.value.get_ref().as_str().unwrap_or(""), known);
        self.problem(&format!(", but there is no {kind} of that name{expected}"))
    }

    pub(in crate::description) fn table(&self, place: String) -> Result<Table<'d>, DescriptionError> {
        self.table_of(self.value, place, "a table")
    }

    /// A table with these keys, named in errors by the key.
    pub(in crate::description) fn inner_table(&self, known: &[&str]) -> Result<Table<'d>, DescriptionError> {
        let table = self.table(format!("{}: {}", self.place, self.key))?;
        table.check_keys(known)?;
        Ok(table)
    }

    /// A list of tables with these keys, named in errors by the key.
    pub(in crate::description) fn inner_tables(
        &self,
        known: &[&str],
    ) -> Result<Vec<Table<'d>>, DescriptionError> {
        let place = format!("{}: {}", self.place, self.key);
        let tables = self.array_of_tables(&place, "a list of tables { .. }")?;
        tables.iter().try_for_each(|table| table.check_keys(known))?;
        Ok(tables)
    }

    fn array_of_tables(&self, place: &str, expected: &str) -> Result<Vec<Table<'d>>, DescriptionError> {
        let Some(array) = self.value.get_ref().as_array() else { return Err(self.refuse(expected)) };
        array.iter().map(|value| self.table_of(value, place.to_string(), expected)).collect()
    }

    fn table_of(
        &self,
        value: &'d Spanned<DeValue<'d>>,
        place: String,
        expected: &str,
    ) -> Result<Table<'d>, DescriptionError> {
        let Some(entries) = value.get_ref().as_table() else { return Err(self.refuse_part(value, expected)) };
        Ok(Table { document: self.document, entries, at: value.span().start, outermost: false, place })
    }
}

/// A number, whether written as a whole one or not.
fn number(value: &Spanned<DeValue<'_>>) -> Option<f64> {
    match value.get_ref() {
        DeValue::Float(float) => float.as_str().parse().ok(),
        #[expect(
            clippy::cast_precision_loss,
            reason = "counts are small; others are rounded as any decimal is"
        )]
        DeValue::Integer(integer) => {
            i64::from_str_radix(integer.as_str(), integer.radix()).ok().map(|i| i as f64)
        }
        _ => None,
    }
}
