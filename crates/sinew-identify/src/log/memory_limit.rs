//! The memory that reading logs may take.

/// Memory the columns of all logs together may take; more is refused with its size.
///
/// Estimated as rows x 2 x (inputs + 4) x 8 bytes before a row is kept: 22 million rows with two inputs. A
/// MATLAB file, which cannot be streamed, must also be smaller than this itself.
pub const MEMORY_LIMIT_BYTES: u64 = 2 << 30;

/// Memory for one row with this number of requested columns, time and far side among them: as a table and,
/// for a moment, as sequences too, with the far side to fit and the line.
pub(super) fn bytes_per_row(columns: usize) -> usize {
    2 * (columns + 2) * 8
}
