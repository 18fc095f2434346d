//! Turning of a tendon's path: angles between its straight pieces.

/// A pulley in MuJoCo's list of a path: the path ends before it and another branch begins behind it.
const PULLEY: i32 = -2;

/// Sum of the angles, rad, at the points of a path, `points: [objects x 3]`.
///
/// An arc around a cylinder or a sphere is two points; the angles at both ends of its chord add up to the
/// arc.
pub(crate) fn turning(points: &[f64], objects: &[i32]) -> f64 {
    let mut sum = 0.0;
    let mut before: Option<[f64; 3]> = None;
    let mut last: Option<[f64; 3]> = None;
    for (point, object) in points.chunks_exact(3).zip(objects) {
        if *object == PULLEY {
            (before, last) = (None, None);
            continue;
        }
        let point = [point[0], point[1], point[2]];
        if let Some(last) = last {
            let piece = [point[0] - last[0], point[1] - last[1], point[2] - last[2]];
            if piece.iter().all(|x| *x == 0.0) {
                continue;
            }
            sum += before.map_or(0.0, |before| angle(before, piece));
            before = Some(piece);
        }
        last = Some(point);
    }
    sum
}

fn angle(a: [f64; 3], b: [f64; 3]) -> f64 {
    let cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let dot = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    (cross[0] * cross[0] + cross[1] * cross[1] + cross[2] * cross[2]).sqrt().atan2(dot)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn an_arc_counts_as_its_angle() {
        for arc in [0.1, 1.0, 3.0] {
            // Tangents of unit length at both ends of an arc of the unit circle.
            let at = |a: f64| [a.cos(), a.sin(), 0.0];
            let along = |a: f64| [-a.sin(), a.cos(), 0.0];
            let minus = |p: [f64; 3], d: [f64; 3]| [p[0] - d[0], p[1] - d[1], p[2] - d[2]];
            let plus = |p: [f64; 3], d: [f64; 3]| [p[0] + d[0], p[1] + d[1], p[2] + d[2]];
            let path = [minus(at(0.0), along(0.0)), at(0.0), at(arc), plus(at(arc), along(arc))].concat();
            assert!((turning(&path, &[-1, 0, 0, -1]) - arc).abs() < 1e-14);
        }
    }

    #[test]
    fn a_pulley_separates_branches_and_points_in_one_place_count_once() {
        let corner = [0., 0., 0., 1., 0., 0., 1., 1., 0.];
        assert!((turning(&corner, &[-1; 3]) - 0.5 * PI).abs() < 1e-15);
        assert_eq!(turning(&corner, &[-1, -2, -1]).to_bits(), 0.0_f64.to_bits());
        let doubled = [0., 0., 0., 1., 0., 0., 1., 0., 0., 1., 1., 0.];
        assert!((turning(&doubled, &[-1; 4]) - 0.5 * PI).abs() < 1e-15);
        assert_eq!(turning(&[], &[]).to_bits(), 0.0_f64.to_bits());
    }
}
