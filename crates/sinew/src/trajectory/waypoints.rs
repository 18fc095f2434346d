use super::path::EndPointPath;
use crate::error::Error;
use alloc::vec::Vec;

/// A point that has to be passed, and when.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Waypoint {
    /// s, from the first waypoint's.
    pub time: f64,
    /// In the world, m.
    pub position: [f64; 3],
}

/// A part of the way through waypoints that is gone without a rest.
#[derive(Debug, Clone, PartialEq)]
pub struct PathSegment {
    /// Since the first waypoint, s.
    pub start: f64,
    /// From rest to rest.
    pub path: EndPointPath,
}

/// Waypoints this close together are one place, m.
const SAME_PLACE: f64 = 1e-9;

/// The split_at_rests of a way through points in the order of their times: a place given twice in a row is waited at.
///
/// Where every point is the same place there is one leg, which stands there.
///
/// # Errors
/// As [`EndPointPath::through`].
pub fn split_at_rests(points: &[Waypoint]) -> Result<Vec<PathSegment>, Error> {
    let whole = EndPointPath::through(points)?;
    let wait = |pair: &[Waypoint]| {
        pair[0].position.iter().zip(pair[1].position).all(|(a, b)| (a - b).abs() < SAME_PLACE)
    };
    let begin = points[0].time;
    let mut split_at_rests = Vec::new();
    let mut from = 0;
    for to in 1..=points.len() {
        if to < points.len() && !wait(&points[to - 1..=to]) {
            continue;
        }
        if to - from > 1 {
            let path = EndPointPath::through(&points[from..to])?;
            split_at_rests.push(PathSegment { start: points[from].time - begin, path });
        }
        from = to;
    }
    if split_at_rests.is_empty() {
        split_at_rests.push(PathSegment { start: 0.0, path: whole });
    }
    Ok(split_at_rests)
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
    fn a_way_is_parted_where_it_waits() {
        let points = [at(5.0, 0.0), at(6.0, 0.3), at(8.0, 0.1), at(9.0, 0.1), at(10.0, 0.1), at(12.0, 0.0)];
        assert_eq!(starts_and_ends(&points), [(0.0, 3.0), (5.0, 7.0)]);
        assert_eq!(starts_and_ends(&points[..3]), [(0.0, 3.0)]);
    }

    #[test]
    fn waits_at_the_ends_and_nothing_but_waits_are_ways() {
        let points = [at(0.0, 0.2), at(1.0, 0.2), at(3.0, 0.1), at(9.0, 0.1)];
        assert_eq!(starts_and_ends(&points), [(1.0, 3.0)]);
        assert_eq!(starts_and_ends(&points[2..]), [(0.0, 6.0)]);
    }

    #[test]
    fn what_no_way_goes_through_is_refused() {
        assert!(split_at_rests(&[]).is_err() && split_at_rests(&[at(0.0, 0.0)]).is_err());
        assert!(split_at_rests(&[at(0.0, 0.0), at(0.0, 0.0)]).is_err());
        assert!(split_at_rests(&[at(0.0, 0.0), at(1.0, 0.0), at(0.5, 1.0)]).is_err());
        assert!(split_at_rests(&[at(0.0, 0.0), at(1.0, 0.0), at(2.0, f64::NAN)]).is_err());
    }
}
