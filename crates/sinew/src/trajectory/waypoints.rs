use super::path::{EndPointPath, Waypoint};
use crate::error::Error;
use alloc::vec::Vec;
use core::ops::Range;

/// A part of a path through waypoints without an intermediate stop.
#[derive(Debug, Clone, PartialEq)]
pub struct PathSegment {
    /// Start time since the first waypoint, s.
    pub start: f64,
    /// Path from rest to rest.
    pub path: EndPointPath,
}

/// Waypoints closer than this are the same position, m.
const POSITION_TOLERANCE: f64 = 1e-9;

/// Segments of a path through waypoints in the order of their times, split where a position is given twice in
/// a row.
///
/// Where all waypoints coincide there is one segment, at rest.
///
/// # Errors
/// As [`EndPointPath::through`].
pub fn split_at_rests(points: &[Waypoint]) -> Result<Vec<PathSegment>, Error> {
    let whole = EndPointPath::through(points)?;
    let coincide = |a: usize, b: usize| close(&points[a].position, &points[b].position, POSITION_TOLERANCE);
    let mut segments = Vec::new();
    for range in between_rests(points.len(), coincide) {
        let start = points[range.start].time - points[0].time;
        segments.push(PathSegment { start, path: EndPointPath::through(&points[range])? });
    }
    if segments.is_empty() {
        segments.push(PathSegment { start: 0.0, path: whole });
    }
    Ok(segments)
}

/// Whether two points of one dimension differ by less than a tolerance in every coordinate.
pub(super) fn close(a: &[f64], b: &[f64], tolerance: f64) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < tolerance)
}

/// Ranges of two points and more, split where a point and the next one coincide.
pub(super) fn between_rests(count: usize, coincide: impl Fn(usize, usize) -> bool) -> Vec<Range<usize>> {
    let mut ranges = Vec::new();
    let mut from = 0;
    for to in 1..=count {
        if to < count && !coincide(to - 1, to) {
            continue;
        }
        if to - from > 1 {
            ranges.push(from..to);
        }
        from = to;
    }
    ranges
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(time: f64, x: f64) -> Waypoint {
        Waypoint { time, position: [x, 0.0, 1.0] }
    }

    fn starts_and_ends(points: &[Waypoint]) -> Vec<(f64, f64)> {
        let length = |leg: &PathSegment| match &leg.path {
            EndPointPath::Waypoints { law, .. } => law.duration(),
            EndPointPath::Loop { .. } => f64::NAN,
        };
        split_at_rests(points).unwrap().iter().map(|leg| (leg.start, leg.start + length(leg))).collect()
    }

    #[test]
    fn a_path_is_split_where_a_waypoint_is_repeated() {
        let points = [at(5.0, 0.0), at(6.0, 0.3), at(8.0, 0.1), at(9.0, 0.1), at(10.0, 0.1), at(12.0, 0.0)];
        assert_eq!(starts_and_ends(&points), [(0.0, 3.0), (5.0, 7.0)]);
        assert_eq!(starts_and_ends(&points[..3]), [(0.0, 3.0)]);
    }

    #[test]
    fn pauses_at_the_ends_and_paths_of_pauses_alone_are_accepted() {
        let points = [at(0.0, 0.2), at(1.0, 0.2), at(3.0, 0.1), at(9.0, 0.1)];
        assert_eq!(starts_and_ends(&points), [(1.0, 3.0)]);
        assert_eq!(starts_and_ends(&points[2..]), [(0.0, 6.0)]);
    }

    #[test]
    fn too_few_waypoints_and_times_that_do_not_increase_are_refused() {
        assert!(split_at_rests(&[]).is_err() && split_at_rests(&[at(0.0, 0.0)]).is_err());
        assert!(split_at_rests(&[at(0.0, 0.0), at(0.0, 0.0)]).is_err());
        assert!(split_at_rests(&[at(0.0, 0.0), at(1.0, 0.0), at(0.5, 1.0)]).is_err());
        assert!(split_at_rests(&[at(0.0, 0.0), at(1.0, 0.0), at(2.0, f64::NAN)]).is_err());
    }
}
