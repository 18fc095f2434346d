//! The value of `--path`: a named path, a point, or a table of waypoints.

use super::values::invalid_value;
use clap::builder::{PossibleValue, TypedValueParser};
use clap::{Arg, Command};
use sinew::trajectory::Loop;
use std::ffi::OsStr;
use std::fmt;
use std::path::PathBuf;

/// A desired motion of the end point, as named on the command line.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum PathArgument {
    /// A closed path by its name.
    Closed(Loop),
    /// A point, m.
    Point([f64; 3]),
    /// A file of waypoints.
    Waypoints(PathBuf),
}

/// Prefix of a point's coordinates.
const POINT_PREFIX: &str = "to:";

impl fmt::Display for PathArgument {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Closed(Loop::Sine) => f.write_str("sine"),
            Self::Closed(Loop::Saddle) => f.write_str("saddle"),
            Self::Point([x, y, z]) => write!(f, "{POINT_PREFIX}{x},{y},{z}"),
            Self::Waypoints(file) => write!(f, "{}", file.display()),
        }
    }
}

/// Parses a [`PathArgument`]; a file must exist, so that a misspelt name is answered with the valid ones.
#[derive(Debug, Clone)]
pub(super) struct PathParser;

impl TypedValueParser for PathParser {
    type Value = PathArgument;

    fn parse_ref(
        &self,
        command: &Command,
        arg: Option<&Arg>,
        value: &OsStr,
    ) -> Result<PathArgument, clap::Error> {
        match value.to_str() {
            Some("sine") => return Ok(PathArgument::Closed(Loop::Sine)),
            Some("saddle") => return Ok(PathArgument::Closed(Loop::Saddle)),
            _ => {}
        }
        if let Some(coordinates) = value.to_str().and_then(|text| text.strip_prefix(POINT_PREFIX)) {
            let point = point(coordinates).map(PathArgument::Point);
            let valid = ["to:X,Y,Z with three finite numbers, m"];
            return point.ok_or_else(|| invalid_value(command, arg, value, &valid));
        }
        let file = PathBuf::from(value);
        if file.exists() {
            return Ok(PathArgument::Waypoints(file));
        }
        Err(invalid_value(command, arg, value, &["sine", "saddle", "to:X,Y,Z", "EXISTING_FILE.csv"]))
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        Some(Box::new(
            [
                PossibleValue::new("sine").help("two turns of the paper's sine-shaped closed path"),
                PossibleValue::new("saddle").help("two turns of a saddle-shaped closed path"),
            ]
            .into_iter(),
        ))
    }
}

/// Three finite numbers between commas.
fn point(text: &str) -> Option<[f64; 3]> {
    let number = |text: &str| text.trim().parse().ok().filter(|x: &f64| x.is_finite());
    let coordinates: Option<Vec<f64>> = text.split(',').map(number).collect();
    coordinates?.try_into().ok()
}
