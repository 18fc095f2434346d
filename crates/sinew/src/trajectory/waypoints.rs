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
pub struct Leg {
    /// Since the first waypoint, s.
    pub start: f64,
    /// From rest to rest.
    pub path: EndPointPath,
}

/// Waypoints this close together are one place, m.
const SAME_PLACE: f64 = 1e-9;

/// The legs of a way through points in the order of their times: a place given twice in a row is waited at.
///
/// Where every point is the same place there is one leg, which stands there.
///
/// # Errors
/// As [`EndPointPath::through`].
pub fn legs(points: &[Waypoint]) -> Result<Vec<Leg>, Error> {
    let whole = EndPointPath::through(points)?;
    let wait = |pair: &[Waypoint]| {
        pair[0].position.iter().zip(pair[1].position).all(|(a, b)| (a - b).abs() < SAME_PLACE)
    };
    let begin = points[0].time;
    let mut legs = Vec::new();
    let mut from = 0;
    for to in 1..=points.len() {
        if to < points.len() && !wait(&points[to - 1..=to]) {
            continue;
        }
        if to - from > 1 {
            let path = EndPointPath::through(&points[from..to])?;
            legs.push(Leg { start: points[from].time - begin, path });
        }
        from = to;
    }
    if legs.is_empty() {
        legs.push(Leg { start: 0.0, path: whole });
    }
    Ok(legs)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(time: f64, x: f64) -> Waypoint {
        Waypoint { time, position: [x, 0.0, 1.0] }
    }

    fn starts_and_ends(points: &[Waypoint]) -> Vec<(f64, f64)> {
        let length = |leg: &Leg| match &leg.path {
            EndPointPath::Waypoints { law, .. } => law.duration(),
            EndPointPath::Loop { .. } => f64::NAN,
        };
        legs(points).unwrap().iter().map(|leg| (leg.start, leg.start + length(leg))).collect()
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
        assert!(legs(&[]).is_err() && legs(&[at(0.0, 0.0)]).is_err());
        assert!(legs(&[at(0.0, 0.0), at(0.0, 0.0)]).is_err());
        assert!(legs(&[at(0.0, 0.0), at(1.0, 0.0), at(0.5, 1.0)]).is_err());
        assert!(legs(&[at(0.0, 0.0), at(1.0, 0.0), at(2.0, f64::NAN)]).is_err());
    }
}
