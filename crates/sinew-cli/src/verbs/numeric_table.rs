//! Small tables of numbers: named columns in any order, comments and empty lines anywhere; cells between commas, semicolons
//! or tabs, quoted or not.

use super::read_text;
use crate::error::Error;
use std::path::Path;

/// Every row's line and the numbers of the wanted columns.
pub(super) fn read<const N: usize>(path: &Path, names: [&str; N]) -> Result<Vec<(usize, [f64; N])>, Error> {
    let refuse = |problem: String| Error::File { file: path.to_owned(), problem };
    let text = read_text(path)?;
    let mut lines = (1..).zip(text.lines()).filter(|(_, line)| {
        let line = line.trim();
        !line.is_empty() && !line.starts_with('#')
    });
    let (first, head) = lines.next().ok_or_else(|| refuse("is empty: expected columns".to_owned()))?;
    let (separator, head) =
        parse_header(head).map_err(|problem| refuse(format!("line {first}: {problem}")))?;
    let mut places = [0; N];
    for (place, name) in places.iter_mut().zip(names) {
        let mut found = head.iter().enumerate().filter(|(_, column)| *column == name);
        *place = found
            .next()
            .ok_or_else(|| refuse(format!("line {first}: no column `{name}` among `{}`", head.join(", "))))?
            .0;
        if found.next().is_some() {
            return Err(refuse(format!("line {first}: column `{name}` stands twice")));
        }
    }
    let mut rows = Vec::new();
    for (line, content) in lines {
        let cells =
            split_cells(content, separator).map_err(|problem| refuse(format!("line {line}: {problem}")))?;
        let mut row = [0.0; N];
        for ((value, place), name) in row.iter_mut().zip(places).zip(names) {
            let cell = cells.get(place).map_or("", String::as_str);
            let number = cell.parse::<f64>().ok().filter(|number| number.is_finite());
            *value = number.ok_or_else(|| {
                refuse(format!("line {line}, column `{name}`: `{cell}`: expected a finite number"))
            })?;
        }
        rows.push((line, row));
    }
    Ok(rows)
}

/// What separates the cells of a table's first line, and these: what separates the names separates everything.
pub(super) fn parse_header(head: &str) -> Result<(char, Vec<String>), String> {
    let counted = |&separator: &char| split_cells(head, separator).is_ok_and(|cells| cells.len() > 1);
    let separator = [';', '\t'].into_iter().find(counted).unwrap_or(',');
    Ok((separator, split_cells(head, separator)?))
}

/// The cells of a line; in quotes a separator is text, and two quotes are one.
pub(super) fn split_cells(line: &str, separator: char) -> Result<Vec<String>, String> {
    let mut cells = vec![String::new()];
    let (mut quoted, mut characters) = (false, line.chars().peekable());
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
        return Err("opens a quote that nothing closes: expected cells of one line".to_owned());
    }
    Ok(cells.iter().map(|cell| cell.trim().to_owned()).collect())
}
