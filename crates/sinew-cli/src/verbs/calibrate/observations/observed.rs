//! What a file says of markers, whatever its format.

use crate::table_error::TableError;

/// Where one marker was, in the unit of its file.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Track {
    pub(super) name: String,
    /// In which it was seen; empty in formats with one frame.
    pub(super) frame: String,
    pub(super) points: Vec<(f64, [f64; 3])>,
}

/// A file as read.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Observed {
    /// What the file calls its unit of length, m; none where it does not tell.
    pub(super) unit: Option<(f64, String)>,
    pub(super) tracks: Vec<Track>,
}

/// The unit of a header, m.
pub(super) fn unit(line: usize, column: &str, name: &str) -> Result<(f64, String), TableError> {
    let metres = match name.to_lowercase().as_str() {
        "m" | "meters" | "metres" => 1.0,
        "cm" | "centimeters" | "centimetres" => 0.01,
        "mm" | "millimeters" | "millimetres" => 0.001,
        _ => return Err(TableError::in_column(line, column, "m, cm or mm", &format!("`{name}`"))),
    };
    Ok((metres, name.to_owned()))
}
