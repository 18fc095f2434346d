//! Which way the end point is to go: a name, or waypoints from a table.

use crate::error::Error;
use crate::verbs::columns;
use sinew::trajectory::{EndPointPath, Loop, Waypoint};
use std::path::{Path, PathBuf};

const COLUMNS: [&str; 4] = ["time_s", "x_m", "y_m", "z_m"];

/// The file behind a path, where it is none of the named ones.
pub(super) fn file(path: &str) -> Option<PathBuf> {
    (!matches!(path, "sine" | "saddle")).then(|| PathBuf::from(path))
}

/// The path that is meant.
pub(super) fn wanted(path: &str) -> Result<EndPointPath, Error> {
    match path {
        "sine" => Ok(EndPointPath::lm_arm(Loop::Sine)),
        "saddle" => Ok(EndPointPath::lm_arm(Loop::Saddle)),
        file => waypoints(Path::new(file)),
    }
}

fn waypoints(path: &Path) -> Result<EndPointPath, Error> {
    let wrong = |problem: String| Error::File { file: path.to_owned(), problem };
    let mut points = Vec::new();
    let mut last = f64::NEG_INFINITY;
    for (line, [time, x, y, z]) in columns::read(path, COLUMNS)? {
        if time <= last {
            return Err(wrong(format!("line {line}, column `time_s`: {time}: expected more than {last}")));
        }
        last = time;
        points.push(Waypoint { time, position: [x, y, z] });
    }
    if points.len() < 2 {
        return Err(wrong(format!("has {} waypoints: expected at least two", points.len())));
    }
    EndPointPath::through(&points).map_err(|e| wrong(e.to_string()))
}
