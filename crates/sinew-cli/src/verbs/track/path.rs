//! Which route the end point is to take: a name, a place, or waypoints from a table.

use crate::error::Error;
use crate::verbs::numeric_table;
use sinew::trajectory::{EndPointPath, Loop, Waypoint, split_at_rests};
use sinew_lab::arm::EndPointMotion;
use std::path::{Path, PathBuf};

const COLUMNS: [&str; 4] = ["time_s", "x_m", "y_m", "z_m"];

/// Of a route, s.
pub(super) const LONGEST_S: f64 = 3600.0;

/// Times closer than this are one, s.
const CLOSEST_S: f64 = 1e-6;

/// Before the coordinates of a place.
const TO: &str = "to:";

/// The file behind a path, where it is none of the named ones.
pub(super) fn file(path: &str) -> Option<PathBuf> {
    (!matches!(path, "sine" | "saddle") && !path.starts_with(TO)).then(|| PathBuf::from(path))
}

/// The route that is meant.
pub(super) fn wanted(path: &str) -> Result<EndPointMotion, Error> {
    match path {
        "sine" => Ok(EndPointMotion::ClosedPath(EndPointPath::lm_arm(Loop::Sine))),
        "saddle" => Ok(EndPointMotion::ClosedPath(EndPointPath::lm_arm(Loop::Saddle))),
        _ => match path.strip_prefix(TO) {
            Some(place) => to(path, place),
            None => waypoints(Path::new(path)),
        },
    }
}

/// A place as `X,Y,Z`.
fn to(path: &str, place: &str) -> Result<EndPointMotion, Error> {
    let coordinates: Vec<f64> =
        place.split(',').filter_map(|x| x.trim().parse().ok()).filter(|x: &f64| x.is_finite()).collect();
    let whole = place.split(',').count() == 3;
    match coordinates.as_slice() {
        [x, y, z] if whole => Ok(EndPointMotion::PointToPoint([*x, *y, *z])),
        _ => Err(Error::Argument {
            flag: "--path",
            value: path.to_owned(),
            expected: "to:X,Y,Z, three finite numbers, m",
        }),
    }
}

fn waypoints(path: &Path) -> Result<EndPointMotion, Error> {
    let wrong = |problem: String| Error::File { file: path.to_owned(), problem };
    let mut points = Vec::new();
    let (mut first, mut last) = (None, f64::NEG_INFINITY);
    for (line, [time, x, y, z]) in numeric_table::read(path, COLUMNS)? {
        if time - last <= CLOSEST_S {
            return Err(wrong(format!("line {line}, column `time_s`: {time}: expected more than {last}")));
        }
        if time - *first.get_or_insert(time) > LONGEST_S {
            let most = "at most 3600 s after the first";
            return Err(wrong(format!("line {line}, column `time_s`: {time}: expected {most}")));
        }
        last = time;
        points.push(Waypoint { time, position: [x, y, z] });
    }
    if points.len() < 2 {
        return Err(wrong(format!("has {} waypoints: expected at least two", points.len())));
    }
    split_at_rests(&points).map_err(|e| wrong(e.to_string()))?;
    Ok(EndPointMotion::Waypoints(points))
}
