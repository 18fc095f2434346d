//! Small tables of numbers: named columns in any order, comments and empty lines anywhere.

use super::read_text;
use crate::error::Error;
use std::path::Path;

/// Every row's line and the numbers of the wanted columns.
pub(super) fn read<const N: usize>(path: &Path, names: [&str; N]) -> Result<Vec<(usize, [f64; N])>, Error> {
    let wrong = |problem: String| Error::File { file: path.to_owned(), problem };
    let text = read_text(path)?;
    let mut lines = (1..).zip(text.lines()).filter(|(_, line)| {
        let line = line.trim();
        !line.is_empty() && !line.starts_with('#')
    });
    let (first, head) = lines.next().ok_or_else(|| wrong("is empty: expected columns".to_owned()))?;
    let head: Vec<&str> = head.split(',').map(str::trim).collect();
    let mut places = [0; N];
    for (place, name) in places.iter_mut().zip(names) {
        *place = head
            .iter()
            .position(|column| *column == name)
            .ok_or_else(|| wrong(format!("line {first}: no column `{name}` among `{}`", head.join(", "))))?;
    }
    let mut rows = Vec::new();
    for (line, content) in lines {
        let cells: Vec<&str> = content.split(',').map(str::trim).collect();
        let mut row = [0.0; N];
        for ((value, place), name) in row.iter_mut().zip(places).zip(names) {
            let cell = cells.get(place).copied().unwrap_or("");
            let number = cell.parse::<f64>().ok().filter(|number| number.is_finite());
            *value = number.ok_or_else(|| {
                wrong(format!("line {line}, column `{name}`: `{cell}`: expected a finite number"))
            })?;
        }
        rows.push((line, row));
    }
    Ok(rows)
}
