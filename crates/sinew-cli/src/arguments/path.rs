//! The value of `--path`: a name, a point, a pose, or a table of waypoints.

use super::values::invalid_value;
use clap::builder::TypedValueParser;
use clap::{Arg, Command};
use std::ffi::OsStr;
use std::fmt;
use std::path::{Path, PathBuf};

/// A desired motion as named on the command line.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum PathArgument {
    /// A path of the machine by its name.
    Named(String),
    /// A tour of all joints.
    Tour,
    /// A position of the end point, m.
    Point([f64; 3]),
    /// Positions of independent joints by their names, rad or m.
    Pose(Vec<(String, f64)>),
    /// A file of waypoints of the end point.
    Waypoints(PathBuf),
    /// A file of poses of the joints.
    JointWaypoints(PathBuf),
}

/// Name of the tour, and prefixes of a point, a pose and a table of poses.
const TOUR: &str = "tour";
const POINT_PREFIX: &str = "to:";
const POSE_PREFIX: &str = "to-joints:";
const JOINTS_PREFIX: &str = "joints:";

/// What may stand for a motion that is not named by the machine.
pub(crate) const PATH_FORMS: &str = "tour, to:X,Y,Z, to-joints:JOINT=VALUE,.., joints:FILE.csv or FILE.csv";

impl PathArgument {
    /// Whether poses of the joints are given, not places of the end point.
    pub(crate) fn is_of_joints(&self) -> bool {
        matches!(self, Self::Pose(_) | Self::JointWaypoints(_))
    }
}

impl fmt::Display for PathArgument {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Named(name) => f.write_str(name),
            Self::Tour => f.write_str(TOUR),
            Self::Point([x, y, z]) => write!(f, "{POINT_PREFIX}{x},{y},{z}"),
            Self::Pose(joints) => {
                f.write_str(POSE_PREFIX)?;
                for (k, (name, value)) in joints.iter().enumerate() {
                    write!(f, "{}{name}={value}", if k > 0 { "," } else { "" })?;
                }
                Ok(())
            }
            Self::Waypoints(file) => write!(f, "{}", file.display()),
            Self::JointWaypoints(file) => write!(f, "{JOINTS_PREFIX}{}", file.display()),
        }
    }
}

impl PathArgument {
    /// Of the text that [`Display`](fmt::Display) gives; a motion without a file.
    pub(crate) fn without_file(text: &str) -> Option<Self> {
        if text == TOUR {
            return Some(Self::Tour);
        }
        if let Some(coordinates) = text.strip_prefix(POINT_PREFIX) {
            return point(coordinates).map(Self::Point);
        }
        if let Some(joints) = text.strip_prefix(POSE_PREFIX) {
            return pose(joints).map(Self::Pose);
        }
        Some(Self::Named(text.to_owned()))
    }

    /// The file that is read for it.
    pub(crate) fn file(&self) -> Option<&PathBuf> {
        match self {
            Self::Waypoints(file) | Self::JointWaypoints(file) => Some(file),
            Self::Named(_) | Self::Tour | Self::Point(_) | Self::Pose(_) => None,
        }
    }
}

/// Parses a [`PathArgument`]. What has no form of its own is a file where it ends in an extension or exists,
/// and a name of the machine's paths otherwise.
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
        let refuse = |valid: &[&str]| invalid_value(command, arg, value, valid);
        let Some(text) = value.to_str() else { return Ok(PathArgument::Waypoints(value.into())) };
        if text == TOUR {
            return Ok(PathArgument::Tour);
        }
        if let Some(coordinates) = text.strip_prefix(POINT_PREFIX) {
            let point = point(coordinates).map(PathArgument::Point);
            return point.ok_or_else(|| refuse(&["to:X,Y,Z with three numbers within -1000 to 1000 m"]));
        }
        if let Some(joints) = text.strip_prefix(POSE_PREFIX) {
            let pose = pose(joints).map(PathArgument::Pose);
            let valid = "to-joints:JOINT=VALUE,JOINT=VALUE with each joint once and numbers within -1000 \
                to 1000 rad or m";
            return pose.ok_or_else(|| refuse(&[valid]));
        }
        if let Some(file) = text.strip_prefix(JOINTS_PREFIX) {
            return match file {
                "" => Err(refuse(&["joints:FILE.csv"])),
                file => Ok(PathArgument::JointWaypoints(file.into())),
            };
        }
        if text.is_empty() {
            return Err(refuse(&["the name of a path", PATH_FORMS]));
        }
        if Path::new(text).exists() || Path::new(text).extension().is_some() {
            return Ok(PathArgument::Waypoints(text.into()));
        }
        Ok(PathArgument::Named(text.to_owned()))
    }
}

/// A coordinate, m or rad, within those of any machine.
fn number(text: &str) -> Option<f64> {
    text.trim().parse().ok().filter(|x: &f64| x.abs() <= 1e3)
}

/// Three coordinates between commas.
fn point(text: &str) -> Option<[f64; 3]> {
    let coordinates: Option<Vec<f64>> = text.split(',').map(number).collect();
    coordinates?.try_into().ok()
}

/// Names and coordinates, each name once.
fn pose(text: &str) -> Option<Vec<(String, f64)>> {
    let mut joints: Vec<(String, f64)> = Vec::new();
    for entry in text.split(',') {
        let (name, value) = entry.rsplit_once('=')?;
        let name = name.trim();
        if name.is_empty() || joints.iter().any(|(other, _)| other == name) {
            return None;
        }
        joints.push((name.to_owned(), number(value)?));
    }
    Some(joints)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pose_names_every_joint_once_with_a_finite_number() {
        let named = |text| pose(text).map(|joints| joints.len());
        assert_eq!(pose("elbow=0.5, wrist = -1"), Some(vec![("elbow".into(), 0.5), ("wrist".into(), -1.0)]));
        assert_eq!(
            [
                named("elbow"),
                named("elbow="),
                named("=1"),
                named("a=1,a=2"),
                named("a=nan"),
                named("a=1e300")
            ],
            [None; 6]
        );
    }
}
