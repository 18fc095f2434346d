//! Which way the end point is to go: a name, or waypoints from a table.

use crate::error::Error;
use crate::verbs::read_text;
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
    let text = read_text(path)?;
    let mut lines = (1..).zip(text.lines()).filter(|(_, line)| {
        let line = line.trim();
        !line.is_empty() && !line.starts_with('#')
    });
    let (first, head) = lines.next().ok_or_else(|| wrong("is empty: expected columns".to_owned()))?;
    let head: Vec<&str> = head.split(',').map(str::trim).collect();
    let mut places = [0; 4];
    for (place, name) in places.iter_mut().zip(COLUMNS) {
        let found = head.iter().position(|column| *column == name);
        *place = found
            .ok_or_else(|| wrong(format!("line {first}: no column `{name}` among `{}`", head.join(", "))))?;
    }
    let mut points = Vec::new();
    let mut last = f64::NEG_INFINITY;
    for (line, content) in lines {
        let cells: Vec<&str> = content.split(',').map(str::trim).collect();
        let mut row = [0.0; 4];
        for ((value, place), name) in row.iter_mut().zip(places).zip(COLUMNS) {
            let cell = cells.get(place).copied().unwrap_or("");
            *value = cell.parse::<f64>().ok().filter(|number| number.is_finite()).ok_or_else(|| {
                wrong(format!("line {line}, column `{name}`: `{cell}`: expected a finite number"))
            })?;
        }
        let [time, x, y, z] = row;
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
