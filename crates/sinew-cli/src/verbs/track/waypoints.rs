//! Waypoints from a table.

use crate::error::Error;
use crate::table_error::TableError;
use crate::verbs::numeric_table;
use sinew::trajectory::{Waypoint, split_at_rests};
use std::path::Path;

const COLUMNS: [&str; 4] = ["time_s", "x_m", "y_m", "z_m"];

/// Longest path, s.
const MAX_DURATION_S: f64 = 3600.0;

/// Smallest difference between two times, s.
const MIN_INTERVAL_S: f64 = 1e-6;

/// At least two waypoints in ascending time.
pub(super) fn read(file: &Path) -> Result<Vec<Waypoint>, Error> {
    let mut points: Vec<Waypoint> = Vec::new();
    for (line, [time, x, y, z]) in numeric_table::read(file, COLUMNS)? {
        let ends = points.first().zip(points.last()).map(|(first, last)| [first.time, last.time]);
        check_time(time, ends).map_err(|expected| {
            Error::table(file)(TableError::in_column(line, COLUMNS[0], expected, &time.to_string()))
        })?;
        points.push(Waypoint { time, position: [x, y, z] });
    }
    if points.len() < 2 {
        return Err(Error::TooFewRows { file: file.to_owned(), what: "waypoints", got: points.len() });
    }
    split_at_rests(&points)
        .map_err(|source| Error::Waypoints { file: file.to_owned(), source: source.into() })?;
    Ok(points)
}

/// What was expected of a time after waypoints from a first to a last time, s, where it is not met.
pub(super) fn check_time(time: f64, earlier: Option<[f64; 2]>) -> Result<(), String> {
    let Some([first, last]) = earlier else { return Ok(()) };
    if time - last <= MIN_INTERVAL_S {
        return Err(format!("more than {last}"));
    }
    if time - first > MAX_DURATION_S {
        return Err(format!("at most {MAX_DURATION_S} s after the first"));
    }
    Ok(())
}
