//! Wrapping around a sphere or a cylinder: reduction to a circle in a plane, and back to space.

use super::circle::{Point, TINY, Touch, around, inside};
use crate::body::vector::{add_scaled, cross, dot, norm, scale};
use crate::lanes::{Frame, Mask, Row, Vector};

/// Contact of a cable with a surface, in the frame of its ends, in the worlds where it touches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Contact<const N: usize> {
    /// Where it touches.
    pub(super) at: Mask<N>,
    /// Direction in which it arrives, unit.
    pub(super) into: Vector<N>,
    /// Direction in which it leaves, unit.
    pub(super) out: Vector<N>,
    /// Length from end to end.
    pub(super) length: Row<N>,
    /// Lengths before and after the surface.
    pub(super) free: [Row<N>; 2],
    /// Angle by which it turns on the surface, rad: the wrap angle of friction.
    pub(super) angle: Row<N>,
    /// Sense and grazing angle in the plane it wraps in.
    pub(super) touch: (Row<N>, Row<N>),
}

/// A cable around a sphere at the origin. `axes` matters only where ends and centre are collinear.
#[inline(always)]
pub(super) fn sphere<const N: usize>(
    ends: [Vector<N>; 2],
    side: Option<Vector<N>>,
    radius: Row<N>,
    axes: &Frame<N>,
) -> Option<Contact<N>> {
    let [p0, p1] = ends;
    let (square0, square1, c) = (p0.dot(p0), p1.dot(p1), p0.dot(p1));
    let missed = if side.is_none() { misses(square0, square1, c, radius) } else { Mask::NONE };
    if missed.all() {
        return None;
    }
    let length0 = square0.sqrt();
    let x = (1.0 / length0) * p0;
    let normal = p0.cross(p1);
    let size = normal.norm();
    let mut y = (1.0 / (size * length0)) * normal.cross(p0);
    let collinear = size.less(Row::all(TINY));
    if collinear.any() {
        for k in (0..N).filter(|&k| collinear.0[k] != 0) {
            y.set(k, any_normal(x.at(k), &axes.at(k)));
        }
    }
    // An end at the centre is within the circle, whatever the plane.
    let planar = [[length0, Row::default()], [c / length0, p1.dot(y)]];
    // No closures here and below: in a kernel they would be compiled for the baseline.
    let mut seen = None;
    if let Some(s) = side {
        seen = Some(([s.dot(x), s.dot(y)], s.norm()));
    }
    let touch = wrap_in_plane(planar, seen, radius)?;
    Some(Contact {
        at: touch.at & !missed,
        into: touch.into[0] * x + touch.into[1] * y,
        out: touch.out[0] * x + touch.out[1] * y,
        length: touch.free[0] + touch.on + touch.free[1],
        free: touch.free,
        angle: touch.angle,
        touch: (touch.sense, touch.graze),
    })
}

/// A cable around a cylinder about z: a helix whose slope is that of the free segments.
#[inline(always)]
pub(super) fn cylinder<const N: usize>(
    ends: [Vector<N>; 2],
    side: Option<Vector<N>>,
    radius: Row<N>,
) -> Option<Contact<N>> {
    let [p0, p1] = ends;
    let planar = [[p0[0], p0[1]], [p1[0], p1[1]]];
    let mut seen = None;
    if let Some(s) = side {
        seen = Some(([s[0], s[1]], s.norm()));
    }
    let touch = wrap_in_plane(planar, seen, radius)?;
    let around = touch.free[0] + touch.on + touch.free[1];
    let rise = p1[2] - p0[2];
    let length = (around * around + rise * rise).sqrt();
    let (along, up) = (around / length, rise / length);
    let longer = 1.0 / along;
    // On a helix the direction turns by less than the angle around; at a ring it has a corner.
    let mut angle = along * touch.angle;
    let corner = !Row::default().less(touch.on) & touch.at;
    if corner.any() {
        for k in (0..N).filter(|&k| corner.0[k] != 0) {
            let half = libm::sin(0.5 * touch.angle.0[k]);
            angle.0[k] = 2.0 * libm::asin((along.0[k] * half).min(1.0));
        }
    }
    Some(Contact {
        at: touch.at,
        into: Vector([along * touch.into[0], along * touch.into[1], up]),
        out: Vector([along * touch.out[0], along * touch.out[1], up]),
        length,
        free: [longer * touch.free[0], longer * touch.free[1]],
        angle,
        touch: (touch.sense, touch.graze),
    })
}

/// Whether the straight cable stays clear of the sphere.
#[inline(always)]
fn misses<const N: usize>(square0: Row<N>, square1: Row<N>, c: Row<N>, radius: Row<N>) -> Mask<N> {
    let squared = square0 + square1 - 2.0 * c;
    let fraction = ((square0 - c) / squared).clamp(0.0, 1.0);
    let near = square0 + fraction * (2.0 * (c - square0) + fraction * squared);
    // With a margin for rounding; the decision is made in the plane.
    (radius * radius * Row::all(1.0 + 1e-9)).less(near)
}

/// Inside the circle if the side site lies within the surface, around it otherwise. `side` is given with its
/// distance from the centre.
#[inline(always)]
fn wrap_in_plane<const N: usize>(
    ends: [Point<N>; 2],
    side: Option<(Point<N>, Row<N>)>,
    radius: Row<N>,
) -> Option<Touch<N>> {
    let Some((mut side, distance)) = side else { return around(ends, None, radius) };
    let central = (side[0] * side[0] + side[1] * side[1]).less(Row::all(TINY * TINY));
    side = [central.select(Row::all(1.0), side[0]), central.select(Row::default(), side[1])];
    let ring = distance.less(radius);
    if !ring.any() {
        return around(ends, Some(side), radius);
    }
    // A ring has a root to find: world by world.
    let mut touch: Option<Touch<N>> = if ring.all() { None } else { around(ends, Some(side), radius) };
    for k in (0..N).filter(|&k| ring.0[k] != 0) {
        let one = inside(ends.map(|end| end.map(|x| Row([x.0[k]]))), Row([radius.0[k]]));
        if let Some(one) = one {
            touch.get_or_insert_with(Touch::none).set(k, &one);
        } else if let Some(touch) = &mut touch {
            touch.at.0[k] = 0;
        }
    }
    touch
}

/// MuJoCo's choice of a plane through a line: the second axis of a frame with first axis `x`.
#[cold]
fn any_normal(x: [f64; 3], axes: &[[f64; 3]; 3]) -> [f64; 3] {
    let local = axes.map(|axis| dot(axis, x));
    let mut largest = 0;
    for k in 1..3 {
        if local[k].abs() > local[largest].abs() {
            largest = k;
        }
    }
    let other = (0..3).filter(|&k| k != largest).fold([0.0; 3], |sum, k| add_scaled(sum, 1.0, axes[k]));
    let normal = cross(x, other);
    let y = cross(normal, x);
    scale(1.0 / norm(y), y)
}

#[cfg(test)]
mod tests {
    use super::{add_scaled, any_normal, cross, dot, norm, scale};
    use crate::body::vector::{frame_of, rotate, sub, unit_quaternion};
    use crate::lanes::{Frame, Row};
    use core::f64::consts::{FRAC_1_SQRT_2, PI};

    type Vector = [f64; 3];

    /// Contact in one world.
    #[derive(Debug, Clone, Copy, PartialEq)]
    struct Contact {
        into: Vector,
        out: Vector,
        length: f64,
        free: [f64; 2],
        angle: f64,
        touch: (f64, f64),
    }

    fn row(vector: Vector) -> crate::lanes::Vector<1> {
        crate::lanes::Vector::all(vector)
    }

    fn of(contact: super::Contact<1>) -> Option<Contact> {
        let free = contact.free.map(|x| x.0[0]);
        let (length, angle) = (contact.length.0[0], contact.angle.0[0]);
        let touch = (contact.touch.0.0[0], contact.touch.1.0[0]);
        let (into, out) = (contact.into.at(0), contact.out.at(0));
        contact.at.any().then_some(Contact { into, out, length, free, angle, touch })
    }

    fn sphere(ends: [Vector; 2], side: Option<Vector>, radius: f64, axes: &[Vector; 3]) -> Option<Contact> {
        super::sphere(ends.map(row), side.map(row), Row([radius]), &Frame(axes.map(row))).and_then(of)
    }

    fn cylinder(ends: [Vector; 2], side: Option<Vector>, radius: f64) -> Option<Contact> {
        super::cylinder(ends.map(row), side.map(row), Row([radius])).and_then(of)
    }

    fn misses(square0: f64, square1: f64, c: f64, radius: f64) -> bool {
        super::misses(Row([square0]), Row([square1]), Row([c]), Row([radius])).any()
    }

    /// Numbers between -1 and 1.
    fn numbers() -> impl FnMut() -> f64 {
        let mut seed = 1_u32;
        move || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            2.0 * f64::from(seed >> 8) / f64::from(1 << 24) - 1.0
        }
    }

    /// A point around the origin, out to about a distance.
    fn point(next: &mut impl FnMut() -> f64, distance: f64) -> Vector {
        [0; 3].map(|_| distance * next())
    }

    /// Where a contact begins and ends.
    fn contact_points(ends: [Vector; 2], contact: &Contact) -> [Vector; 2] {
        [
            add_scaled(ends[0], contact.free[0], contact.into),
            add_scaled(ends[1], -contact.free[1], contact.out),
        ]
    }

    fn distance(a: Vector, b: Vector) -> f64 {
        norm(sub(a, b))
    }

    fn assert_unit(vectors: [Vector; 2]) {
        assert!(vectors.iter().all(|vector| (norm(*vector) - 1.0).abs() < 7e-16), "{vectors:?}");
    }

    #[test]
    fn no_other_points_of_contact_make_the_way_over_a_sphere_shorter() {
        let (mut next, radius, mut wrapped) = (numbers(), 0.6, 0);
        let axes = frame_of(unit_quaternion([0.8, 0.3, -0.4, 0.2]));
        for _ in 0..400 {
            let ends = [point(&mut next, 1.5), point(&mut next, 1.5)];
            let Some(contact) = sphere(ends, None, radius, &axes) else { continue };
            wrapped += 1;
            assert_unit([contact.into, contact.out]);
            let points = contact_points(ends, &contact);
            let way = |points: [Vector; 2]| {
                let arc = radius * 2.0 * libm::asin(0.5 * distance(points[0], points[1]) / radius);
                distance(ends[0], points[0]) + arc + distance(points[1], ends[1])
            };
            assert!(points.iter().all(|p| (norm(*p) - radius).abs() < 1e-15));
            assert!((way(points) - contact.length).abs() < 2e-15);
            // On a sphere the cable turns by its arc over the radius.
            let turn = libm::acos(dot(contact.into, contact.out).clamp(-1.0, 1.0));
            assert!((turn - contact.angle).abs() < 1.5e-14, "{turn} {}", contact.angle);
            for _ in 0..4 {
                let other = points.map(|p| {
                    let moved = add_scaled(p, 1e-3, point(&mut next, 1.0));
                    scale(radius / norm(moved), moved)
                });
                assert!(way(other) > contact.length, "{ends:?}");
            }
        }
        assert!(wrapped > 60, "{wrapped}");
    }

    #[test]
    fn no_other_points_of_contact_make_the_way_over_a_cylinder_shorter() {
        let (mut next, radius, mut wrapped) = (numbers(), 0.6, 0);
        for _ in 0..300 {
            let ends = [point(&mut next, 1.5), point(&mut next, 1.5)];
            let Some(contact) = cylinder(ends, None, radius) else { continue };
            wrapped += 1;
            assert_unit([contact.into, contact.out]);
            let points = contact_points(ends, &contact);
            let sense = contact.touch.0;
            // The helix from one point to the other, by how far it turns and how far it climbs.
            let turn = |[from, to]: [Vector; 2]| {
                let angle = libm::atan2(to[1], to[0]) - libm::atan2(from[1], from[0]);
                libm::remainder(angle, 2.0 * PI)
            };
            let way = |points: [Vector; 2]| {
                let [from, to] = points;
                let arc = libm::hypot(radius * turn(points), to[2] - from[2]);
                distance(ends[0], from) + arc + distance(to, ends[1])
            };
            assert!(points.iter().all(|p| (libm::hypot(p[0], p[1]) - radius).abs() < 5e-16));
            assert!((way(points) - contact.length).abs() < 3e-15, "{ends:?}");
            // The angles between the tangents of many pieces add up to its angle.
            let (pieces, whole) = (60, turn(points));
            let along = libm::hypot(contact.into[0], contact.into[1]);
            let tangent = |angle: f64| {
                let (sine, cosine) = libm::sincos(angle);
                [-sense * along * sine, sense * along * cosine, contact.into[2]]
            };
            let step = whole / f64::from(pieces);
            let one = 2.0 * libm::asin(0.5 * distance(tangent(0.0), tangent(step)));
            assert!((f64::from(pieces) * one - contact.angle).abs() < 2e-5, "{ends:?}");
            for _ in 0..4 {
                let other = points.map(|p| {
                    let [x, y, z] = add_scaled(p, 1e-3, point(&mut next, 1.0));
                    let out = radius / libm::hypot(x, y);
                    [out * x, out * y, z]
                });
                assert!(way(other) > contact.length, "{ends:?}");
            }
        }
        assert!(wrapped > 60, "{wrapped}");
    }

    #[test]
    fn a_ring_on_either_surface_bends_the_cable_at_one_point_by_the_angle_between_its_parts() {
        let (mut next, radius, mut touched) = (numbers(), 0.4, [0; 2]);
        let axes = frame_of([1.0, 0.0, 0.0, 0.0]);
        for _ in 0..200 {
            let ends = [point(&mut next, 1.5), point(&mut next, 1.5)];
            let within = Some(point(&mut next, 0.2));
            for (kind, contact) in
                [sphere(ends, within, radius, &axes), cylinder(ends, within, radius)].into_iter().enumerate()
            {
                let Some(contact) = contact else { continue };
                touched[kind] += 1;
                assert_unit([contact.into, contact.out]);
                let [p, same] = contact_points(ends, &contact);
                assert!(distance(p, same) < 1e-12, "{p:?} {same:?}");
                let from_axis = if kind == 0 { norm(p) } else { libm::hypot(p[0], p[1]) };
                assert!((from_axis - radius).abs() < 8e-16);
                assert!((contact.free[0] + contact.free[1] - contact.length).abs() < 2e-15);
                let corner =
                    libm::atan2(norm(cross(contact.into, contact.out)), dot(contact.into, contact.out));
                assert!((corner - contact.angle).abs() < 2e-15, "{corner} {}", contact.angle);
            }
        }
        assert!(touched.iter().all(|count| *count > 50), "{touched:?}");
    }

    #[test]
    fn a_cable_through_the_middle_of_a_sphere_goes_around_it_in_a_plane_of_its_frame() {
        let radius = 0.5;
        let axes = frame_of(unit_quaternion([0.8, 0.3, -0.4, 0.2]));
        // A direction of the sphere's frame, and the second direction that MuJoCo chooses for it: that of the
        // two other axes, without their part along the first.
        let half = FRAC_1_SQRT_2;
        let third = libm::sqrt(1.0 / 1.5);
        for (x, y) in [
            ([1.0, 0.0, 0.0], [0.0, half, half]),
            ([0.0, -1.0, 0.0], [half, 0.0, half]),
            ([0.0, 0.0, 1.0], [half, half, 0.0]),
            // Of equal parts the first counts as the largest.
            ([half, half, 0.0], [-0.5 * third, 0.5 * third, third]),
        ] {
            let (x, y) = (rotate(&axes, x), rotate(&axes, y));
            assert!(distance(any_normal(x, &axes), y) < 1e-15, "{x:?}");
            let contact = sphere([scale(2.0, x), scale(-3.0, x)], None, radius, &axes).unwrap();
            let lean = libm::acos(radius / 2.0) + libm::acos(radius / 3.0);
            let desired = libm::sqrt(4.0 - 0.25) + libm::sqrt(9.0 - 0.25) + radius * (PI - lean);
            assert!((contact.length - desired).abs() < 2e-15, "{} {desired}", contact.length);
            assert_unit([contact.into, contact.out]);
            for direction in [contact.into, contact.out] {
                assert!(dot(direction, cross(x, y)).abs() < 3e-16, "{direction:?}");
            }
            let [first, last] = contact_points([scale(2.0, x), scale(-3.0, x)], &contact);
            // Which of its two sides is left to rounding.
            assert!(dot(first, y) * dot(last, y) > 0.0, "{first:?} {last:?}");
        }
    }

    #[test]
    fn a_cable_that_ends_in_the_middle_of_a_surface_is_straight() {
        let axes = frame_of([1.0, 0.0, 0.0, 0.0]);
        for ends in [[[0.0; 3], [1.0, 0.2, 0.3]], [[1.0, 0.2, 0.3], [0.0; 3]], [[0.0; 3]; 2]] {
            for side in [None, Some([0.0, 0.1, 0.0]), Some([0.0, 2.0, 0.0])] {
                assert_eq!(sphere(ends, side, 0.5, &axes), None);
                assert_eq!(cylinder(ends, side, 0.5), None);
            }
        }
    }

    #[test]
    fn a_straight_cable_misses_a_sphere_where_all_its_points_are_farther_than_the_radius() {
        let (mut next, mut counts) = (numbers(), [0; 2]);
        for radius in [0.3, 0.7, 1.8] {
            for _ in 0..300 {
                let [p, q] = [point(&mut next, 2.0 * radius), point(&mut next, 2.0 * radius)];
                let at = |fraction: f64| add_scaled(p, fraction, sub(q, p));
                let near = (0..=200).map(|k| norm(at(f64::from(k) / 200.0))).fold(9.0, f64::min);
                if (near - radius).abs() < 1e-2 * radius {
                    continue;
                }
                let missed = misses(dot(p, p), dot(q, q), dot(p, q), radius);
                assert_eq!(missed, near > radius, "{p:?} {q:?} {radius}");
                counts[usize::from(missed)] += 1;
            }
        }
        assert!(counts.iter().all(|count| *count > 200), "{counts:?}");
        // Half a nanometre within a sphere of a metre is not a miss, whatever rounding does.
        let height = 1.0 - 2e-10;
        assert!(!misses(1.0 + height * height, 1.0 + height * height, height * height - 1.0, 1.0));
    }

    #[test]
    fn a_side_on_the_axis_of_a_cylinder_counts_as_one_along_its_first_axis() {
        // The longer arc leads over the first axis.
        let end = |angle: f64, z| [2.0 * libm::cos(angle), 2.0 * libm::sin(angle), z];
        let ends = [end(2.6, 0.1), end(-2.6, 0.4)];
        let over = cylinder(ends, Some([3.0, 0.0, 0.0]), 0.5).unwrap();
        assert!(over.touch.0 < 0.0 && over.angle > 2.0, "{over:?}");
        for height in [0.5, -5.0] {
            assert_eq!(cylinder(ends, Some([0.0, 0.0, height]), 0.5), Some(over));
        }
    }

    #[test]
    fn a_side_on_the_surface_itself_is_outside() {
        let ends = [[2.0, 0.1, 0.0], [-2.0, 0.1, 0.3]];
        let axes = frame_of([1.0, 0.0, 0.0, 0.0]);
        let (on, beyond) = (Some([0.0, 0.5, 0.0]), Some([0.0, 0.7, 0.0]));
        assert!(cylinder(ends, on, 0.5).is_some() && sphere(ends, on, 0.5, &axes).is_some());
        assert_eq!(cylinder(ends, on, 0.5), cylinder(ends, beyond, 0.5));
        assert_eq!(sphere(ends, on, 0.5, &axes), sphere(ends, beyond, 0.5, &axes));
    }
}
