//! A row for every time and three columns for every marker, as TRC and Motive have them.

use super::observed::Track;
use crate::table_error::TableError;
use crate::verbs::numeric_table::{parse_number, split_cells};

/// The columns of a table.
pub(super) struct MarkerTable {
    pub(super) separator: char,
    /// Number of cells in a row; more may follow that are empty.
    pub(super) width: usize,
    /// Names of the markers, and the columns of their x; y and z are the next.
    pub(super) markers: Vec<(String, usize)>,
    /// Rows by the header.
    pub(super) count: Option<usize>,
}

/// Column of the time.
const TIME: usize = 1;

impl MarkerTable {
    /// The rows of the numbered lines; where all three cells of a marker are empty or NaN it was not seen.
    pub(super) fn read<'a>(
        &self,
        lines: impl Iterator<Item = (usize, &'a str)>,
        last: usize,
    ) -> Result<Vec<Track>, TableError> {
        let empty = |(name, _): &(String, usize)| Track {
            name: name.clone(),
            frame: String::new(),
            points: Vec::new(),
        };
        let mut tracks: Vec<Track> = self.markers.iter().map(empty).collect();
        let (mut before, mut count, mut last) = (f64::NEG_INFINITY, 0, last);
        for (line, content) in lines.filter(|(_, content)| !content.trim().is_empty()) {
            let cells = split_cells(line, content, self.separator)?;
            if cells.len() < self.width || cells[self.width..].iter().any(|cell| !cell.is_empty()) {
                let got = format!("{} of them", cells.len());
                return Err(TableError::in_line(line, format!("{} cells", self.width), got));
            }
            let time = parse_number(line, "Time", &cells[TIME])?;
            if time <= before {
                return Err(TableError::in_column(line, "Time", "increasing times", &time.to_string()));
            }
            for (track, (name, column)) in tracks.iter_mut().zip(&self.markers) {
                let cells = &cells[*column..column + 3];
                if cells.iter().all(|cell| cell.is_empty() || cell.eq_ignore_ascii_case("nan")) {
                    continue;
                }
                let mut position = [0.0; 3];
                for (x, cell) in position.iter_mut().zip(cells) {
                    *x = parse_number(line, name, cell)?;
                }
                track.points.push((time, position));
            }
            (before, count, last) = (time, count + 1, line);
        }
        match self.count {
            Some(expected) if expected != count => {
                Err(TableError::in_line(last, format!("{expected} rows by the header"), count.to_string()))
            }
            _ => Ok(tracks),
        }
    }
}
