//! Tables that Motive of OptiTrack exports, version 1.2x: markers and places of rigid bodies.
//!
//! ```text
//! Format Version,1.23,Take Name,..,Total Exported Frames,300,Rotation Type,Quaternion,Length Units,Millimeters,Coordinate Space,Global
//!
//! ,Type,Rigid Body,..,Marker,..
//! ,Name,plate,..,tip,..
//! ,ID,..
//! ,,Rotation,..,Position,..
//! Frame,Time (Seconds),X,Y,Z,W,X,Y,Z,..
//! ```
//!
//! Columns of type `Rigid Body Marker` are where a marker should be, not where it was seen.

use super::marker_table::MarkerTable;
use super::observed::{Observed, unit};
use crate::table_error::TableError;
use crate::verbs::numeric_table::split_cells;

pub(super) fn read(text: &str) -> Result<Observed, TableError> {
    let mut lines = (1..).zip(text.lines()).filter(|(_, line)| !line.trim().is_empty());
    let mut last = 0;
    let mut next = |expected: &str| {
        let (line, content) =
            lines.next().ok_or_else(|| TableError::in_line(last + 1, expected, "the end"))?;
        last = line;
        Ok((line, split_cells(line, content, ',')?))
    };
    let (line, about) = next("Format Version")?;
    let value = |key: &str| {
        let found = about.chunks_exact(2).find(|pair| pair[0] == key);
        found.map(|pair| pair[1].as_str())
    };
    for (key, expected) in [("Format Version", "1.2"), ("Coordinate Space", "Global")] {
        let got = value(key).unwrap_or(expected);
        if !got.starts_with(expected) {
            return Err(TableError::in_column(line, key, expected, &format!("`{got}`")));
        }
    }
    let unit = value("Length Units").map(|name| unit(line, "Length Units", name)).transpose()?;
    let count = value("Total Exported Frames").map(|text| {
        let refuse =
            |_| TableError::in_column(line, "Total Exported Frames", "a number", &format!("`{text}`"));
        text.parse().map_err(refuse)
    });
    let count = count.transpose()?;
    let (mut types, mut names, mut kinds) = (Vec::new(), Vec::new(), Vec::new());
    let (line, axes) = loop {
        let (line, cells) = next("a line that begins with Frame, Time")?;
        match cells.as_slice() {
            [frame, time, ..] if frame == "Frame" && time.starts_with("Time") => break (line, cells),
            [empty, label, ..] if empty.is_empty() && label == "Type" => types = cells,
            [empty, label, ..] if empty.is_empty() && label == "Name" => names = cells,
            [empty, label, ..] if empty.is_empty() && label.is_empty() => kinds = cells,
            [empty, _, ..] if empty.is_empty() => (),
            _ => return Err(TableError::in_line(line, "Frame, Time", cells.join(","))),
        }
    };
    let cell = |row: &[String], column: usize| row.get(column).cloned().unwrap_or_default();
    let mut markers = Vec::new();
    for column in 2..axes.len() {
        let (name, kind) = (cell(&names, column), cell(&types, column));
        let is_place =
            cell(&kinds, column) == "Position" && ["Marker", "Rigid Body"].contains(&kind.as_str());
        if !is_place || cell(&axes, column) != "X" {
            continue;
        }
        let rest = [(column + 1, "Y"), (column + 2, "Z")];
        if rest.iter().any(|(place, axis)| cell(&axes, *place) != *axis || cell(&names, *place) != name) {
            return Err(TableError::in_column(line, &name, "X, Y and Z", "other columns behind X"));
        }
        markers.push((name, column));
    }
    if markers.is_empty() {
        let got = if types.is_empty() { "none".to_owned() } else { types.join(",") };
        return Err(TableError::in_line(line, "positions of type Marker or Rigid Body", got));
    }
    let table = MarkerTable { separator: ',', width: axes.len(), markers, count };
    Ok(Observed { unit, tracks: table.read(lines, line)? })
}
