//! A named numeric array of a MATLAB file.

/// A numeric array with its place in the file.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Array {
    /// Its name, with the structs it is in: `log.tension_in_n`.
    pub(super) path: String,
    /// Rows.
    pub(super) rows: usize,
    /// Columns (the product of all dimensions but the first).
    pub(super) columns: usize,
    /// Column by column.
    pub(super) data: Vec<f64>,
}
