//! Text tables: CSV, TSV and what bench programs write in their place.

mod cell;
mod dialect;
mod header;
mod lines;
mod read;

pub(super) use read::TextLog;
