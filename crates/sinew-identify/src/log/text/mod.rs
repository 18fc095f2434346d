//! Text tables: CSV, TSV and what bench programs write in their place.
//!
//! The reader is written here because it finds the dialect (delimiter, decimal comma, units row, commented
//! header) from the first lines, streams only the columns that have a role, and names line, column and cell
//! in every error; the `csv` crate, with which the program writes, takes the dialect as given.

mod cell;
mod detect;
mod dialect;
mod header;
mod lines;
mod read;
mod stamp;

pub(super) use read::TextLog;
