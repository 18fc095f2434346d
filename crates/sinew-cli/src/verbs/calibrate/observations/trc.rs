//! Tracks of markers as Motion Analysis and OpenSim write them: TRC.
//!
//! ```text
//! PathFileType  4  (X/Y/Z)  seen.trc
//! DataRate  CameraRate  NumFrames  NumMarkers  Units  OrigDataRate  OrigDataStartFrame  OrigNumFrames
//! 100  100  300  2  mm  100  1  300
//! Frame#  Time  tip          base_1
//!               X1  Y1  Z1   X2  Y2  Z2
//! 1  0.000  ..
//! ```

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
        Ok((line, split_cells(line, content, '\t')?))
    };
    next("PathFileType")?;
    let (_, keys) = next("a line with NumFrames, NumMarkers and Units")?;
    let (line, values) = next("a line with their values")?;
    // Writers differ in the number of tabs between cells that are never empty.
    let full = |cell: &&String| !cell.is_empty();
    let value = |key: &str| {
        let found = keys
            .iter()
            .filter(full)
            .zip(values.iter().filter(full))
            .find(|(name, _)| name.as_str() == key)
            .map(|(_, value)| value.as_str());
        found.ok_or_else(|| TableError::in_column(line, key, "a value", "none"))
    };
    let count = |key: &str| {
        let text = value(key)?;
        let number = text.parse::<f64>().ok().filter(|x| x.fract() == 0.0 && (0.0..=1e9).contains(x));
        let refuse = || TableError::in_column(line, key, "a whole number", &format!("`{text}`"));
        number.map(|x| x as usize).ok_or_else(refuse)
    };
    let (frames, markers, unit) =
        (count("NumFrames")?, count("NumMarkers")?, unit(line, "Units", value("Units")?)?);
    let (line, names) = next("a line with Frame#, Time and the markers")?;
    let [frame, time, names @ ..] = names.as_slice() else {
        return Err(TableError::in_line(line, "Frame#, Time and the markers", names.join(" ")));
    };
    if frame != "Frame#" || time != "Time" {
        return Err(TableError::in_line(line, "Frame# and Time", format!("{frame} and {time}")));
    }
    let names: Vec<&String> = names.iter().filter(full).collect();
    if names.len() != markers {
        let expected = format!("{markers} markers by NumMarkers");
        return Err(TableError::in_line(line, expected, names.len().to_string()));
    }
    let (line, axes) = next("a line with X1, Y1, Z1 and so on")?;
    let expected = (1..=markers).flat_map(|k| ['X', 'Y', 'Z'].map(|axis| format!("{axis}{k}")));
    let mut got = axes.iter().filter(full);
    for expected in expected.chain(std::iter::once("the end".to_owned())) {
        let got = got.next().map_or("the end", String::as_str);
        if expected != got {
            return Err(TableError::in_line(line, expected, got));
        }
    }
    let width = 2 + 3 * markers;
    let markers = names.into_iter().zip((2..).step_by(3)).map(|(name, x)| (name.clone(), x)).collect();
    let table = MarkerTable { separator: '\t', width, markers, count: Some(frames) };
    Ok(Observed { unit: Some(unit), tracks: table.read(lines, line)? })
}
