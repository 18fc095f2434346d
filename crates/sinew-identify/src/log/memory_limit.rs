//! The memory that reading logs may take.

/// Memory the columns of all logs together may take; more is refused with its size.
///
/// Estimated as rows x 2 x (inputs + 4) x 8 bytes before a row is kept: 22 million rows with two inputs. A
/// MATLAB file, which cannot be streamed, must also be smaller than this itself.
pub const MEMORY_LIMIT_BYTES: u64 = 2 << 30;
