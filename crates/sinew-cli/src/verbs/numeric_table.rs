//! Small tables of numbers: named columns in any order, comments and empty lines anywhere; cells between
//! commas, semicolons or tabs, quoted or not.
//!
//! Own reader, because the `csv` crate takes a quote after a blank as text.

use super::read_text;
use crate::error::Error;
use crate::output::one_line;
use crate::table_error::TableError;
use std::path::Path;

/// Line number and numbers of the named columns, for every row.
pub(super) fn read<const N: usize>(path: &Path, names: [&str; N]) -> Result<Vec<(usize, [f64; N])>, Error> {
    parse(&read_text(path)?, names).map_err(Error::table(path))
}

fn parse<const N: usize>(text: &str, names: [&str; N]) -> Result<Vec<(usize, [f64; N])>, TableError> {
    let mut lines = data_lines(text);
    let Some((line, header)) = lines.next() else {
        return Err(TableError::in_line(1, format!("the columns {}", names.join(", ")), "an empty table"));
    };
    let (separator, header) = parse_header(line, header)?;
    let mut places = [0; N];
    for (place, name) in places.iter_mut().zip(names) {
        let mut found = header.iter().enumerate().filter(|(_, column)| *column == name);
        let missing = || TableError::in_line(line, format!("a column `{name}`"), header.join(", "));
        *place = found.next().ok_or_else(missing)?.0;
        if found.next().is_some() {
            return Err(TableError::in_column(line, name, "it once", "it twice"));
        }
    }
    let row = |(line, content)| {
        let cells = split_cells(line, content, separator)?;
        let mut row = [0.0; N];
        for ((value, place), name) in row.iter_mut().zip(places).zip(names) {
            *value = parse_number(line, name, cells.get(place).map_or("", String::as_str))?;
        }
        Ok((line, row))
    };
    lines.map(row).collect()
}

/// The lines that are neither empty nor a comment, numbered from 1.
pub(super) fn data_lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let is_data = |line: &str| !line.trim().is_empty() && !line.trim_start().starts_with('#');
    (1..).zip(text.lines()).filter(move |(_, line)| is_data(line))
}

/// A finite number.
pub(super) fn parse_number(line: usize, column: &str, cell: &str) -> Result<f64, TableError> {
    let number = cell.parse::<f64>().ok().filter(|number| number.is_finite());
    let got = if cell.is_empty() { "an empty cell".to_owned() } else { format!("`{}`", one_line(cell)) };
    number.ok_or_else(|| TableError::in_column(line, column, "a finite number", &got))
}

/// Separator and column names of a header; the separator of the header is that of the table.
pub(super) fn parse_header(line: usize, header: &str) -> Result<(char, Vec<String>), TableError> {
    let separates =
        |&separator: &char| split_cells(line, header, separator).is_ok_and(|cells| cells.len() > 1);
    let separator = [';', '\t'].into_iter().find(separates).unwrap_or(',');
    Ok((separator, split_cells(line, header, separator)?))
}

/// The cells of a line; within quotes a separator is text, and two quotes are one.
pub(super) fn split_cells(line: usize, content: &str, separator: char) -> Result<Vec<String>, TableError> {
    let mut cells = vec![String::new()];
    let (mut quoted, mut characters) = (false, content.chars().peekable());
    while let Some(character) = characters.next() {
        let cell = match cells.last_mut() {
            Some(cell) if character != separator || quoted => cell,
            _ => {
                cells.push(String::new());
                continue;
            }
        };
        match character {
            '"' if quoted && characters.next_if_eq(&'"').is_some() => cell.push('"'),
            '"' if quoted || cell.trim().is_empty() => quoted = !quoted,
            character => cell.push(character),
        }
    }
    if quoted {
        return Err(TableError::in_line(line, "a closing quote in the same line", "none"));
    }
    Ok(cells.iter().map(|cell| cell.trim().to_owned()).collect())
}
