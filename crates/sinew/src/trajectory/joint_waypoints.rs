use super::joint_path::JointPath;
use super::motion::{Sequence, Trajectory};
use super::path::timed_spline;
use super::waypoints::{between_rests, close};
use crate::error::{Error, check_length};
use alloc::vec;
use alloc::vec::Vec;

/// A pose that has to be reached at a time.
#[derive(Debug, Clone, PartialEq)]
pub struct JointWaypoint {
    /// s; only differences to the first waypoint matter.
    pub time: f64,
    /// Coordinates of the independent joints, rad or m: `[n]`.
    pub q: Vec<f64>,
}

/// Poses closer than this are the same, rad or m.
const POSE_TOLERANCE: f64 = 1e-9;

/// A trajectory through poses at their times, from rest to rest: a cubic spline of the joints, with a stop
/// where a pose is given twice in a row.
///
/// The timing is that of [`EndPointPath::through`](super::EndPointPath::through): two poses are joined by
/// minimum jerk.
///
/// # Errors
/// [`Error::WrongLength`] below two points or for poses of different robots, [`Error::OutOfDomain`] for one
/// that is not finite or times that do not increase.
pub fn through_joint_waypoints(points: &[JointWaypoint]) -> Result<Trajectory, Error> {
    let joints = points.first().map_or(0, |first| first.q.len());
    points.iter().try_for_each(|point| check_length("pose of a waypoint", point.q.len(), joints))?;
    let leg = |points: &[JointWaypoint]| {
        let times: Vec<f64> = points.iter().map(|point| point.time).collect();
        let values: Vec<f64> = points.iter().flat_map(|point| point.q.iter().copied()).collect();
        let (spline, law) = timed_spline(&times, &values)?;
        Ok::<_, Error>(Trajectory::AlongPath { joints: JointPath::along(spline), law })
    };
    let whole = leg(points)?;
    let coincide = |a: usize, b: usize| close(&points[a].q, &points[b].q, POSE_TOLERANCE);
    let ranges = between_rests(points.len(), coincide);
    let mut motions = match ranges.is_empty() {
        true => vec![(0.0, whole.clone())],
        false => Vec::new(),
    };
    for range in ranges {
        motions.push((points[range.start].time - points[0].time, leg(&points[range])?));
    }
    Ok(Trajectory::Sequence(Sequence::new(motions, whole.duration())?))
}
