//! Wrapping around a sphere or a cylinder: reduction to a circle in a plane, and back to space.

use super::circle::{Point, TINY, Touch, around, inside};
use crate::body::vector::{Vector, add_scaled, cross, dot, norm, scale};

/// Contact of a cable with a surface, in the frame of its ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Contact {
    /// Direction in which it arrives, unit.
    pub(super) into: Vector,
    /// Direction in which it leaves, unit.
    pub(super) out: Vector,
    /// Length from end to end.
    pub(super) length: f64,
    /// Lengths before and after the surface.
    pub(super) free: [f64; 2],
    /// Angle by which it turns on the surface, rad: the wrap angle of friction.
    pub(super) angle: f64,
    /// Sense and grazing angle in the plane it wraps in.
    pub(super) touch: (f64, f64),
}

/// A cable around a sphere at the origin. `axes` matters only where ends and centre are collinear.
#[inline]
pub(super) fn sphere(
    ends: [Vector; 2],
    side: Option<Vector>,
    radius: f64,
    axes: &[Vector; 3],
) -> Option<Contact> {
    let [p0, p1] = ends;
    let (square0, square1, c) = (dot(p0, p0), dot(p1, p1), dot(p0, p1));
    if square0 < TINY * TINY || square1 < TINY * TINY {
        return None;
    }
    if side.is_none() && misses(square0, square1, c, radius) {
        return None;
    }
    let length0 = libm::sqrt(square0);
    let x = scale(1.0 / length0, p0);
    let normal = cross(p0, p1);
    let size = norm(normal);
    let y = if size < TINY { any_normal(x, axes) } else { scale(1.0 / (size * length0), cross(normal, p0)) };
    let planar = [[length0, 0.0], [c / length0, dot(p1, y)]];
    let touch = wrap_in_plane(planar, side.map(|s| ([dot(s, x), dot(s, y)], norm(s))), radius)?;
    let lift = |[a, b]: Point| add_scaled(scale(a, x), b, y);
    Some(Contact {
        into: lift(touch.into),
        out: lift(touch.out),
        length: touch.free[0] + touch.on + touch.free[1],
        free: touch.free,
        angle: touch.angle,
        touch: (touch.sense, touch.graze),
    })
}

/// A cable around a cylinder about z: a helix whose slope is that of the free segments.
#[inline]
pub(super) fn cylinder(ends: [Vector; 2], side: Option<Vector>, radius: f64) -> Option<Contact> {
    let [p0, p1] = ends;
    if dot(p0, p0) < TINY * TINY || dot(p1, p1) < TINY * TINY {
        return None;
    }
    let planar = [[p0[0], p0[1]], [p1[0], p1[1]]];
    let touch = wrap_in_plane(planar, side.map(|s| ([s[0], s[1]], norm(s))), radius)?;
    let around = touch.free[0] + touch.on + touch.free[1];
    let rise = p1[2] - p0[2];
    let length = libm::sqrt(around * around + rise * rise);
    if length < TINY {
        return None;
    }
    let (along, up) = (around / length, rise / length);
    let lift = |[a, b]: Point| [along * a, along * b, up];
    let longer = 1.0 / along;
    // On a helix the direction turns by less than the angle around; at a ring it has a corner.
    let angle = if touch.on > 0.0 {
        along * touch.angle
    } else {
        2.0 * libm::asin((along * libm::sin(0.5 * touch.angle)).min(1.0))
    };
    Some(Contact {
        into: lift(touch.into),
        out: lift(touch.out),
        length,
        free: touch.free.map(|free| longer * free),
        angle,
        touch: (touch.sense, touch.graze),
    })
}

/// Whether the straight cable stays clear of the sphere.
#[inline]
fn misses(square0: f64, square1: f64, c: f64, radius: f64) -> bool {
    let squared = square0 + square1 - 2.0 * c;
    let share = ((square0 - c) / squared).clamp(0.0, 1.0);
    let near = square0 + share * (2.0 * (c - square0) + share * squared);
    // With a margin for rounding; the decision is made in the plane.
    near > radius * radius * (1.0 + 1e-9)
}

/// Inside the circle if the side site lies within the surface, around it otherwise. `side` is given with its
/// distance from the centre.
#[inline]
fn wrap_in_plane(ends: [Point; 2], side: Option<(Point, f64)>, radius: f64) -> Option<Touch> {
    match side {
        Some((_, distance)) if distance < radius => inside(ends, radius),
        Some((side, _)) if side[0] * side[0] + side[1] * side[1] < TINY * TINY => {
            around(ends, Some([1.0, 0.0]), radius)
        }
        side => around(ends, side.map(|(point, _)| point), radius),
    }
}

/// MuJoCo's choice of a plane through a line: the second axis of a frame with first axis `x`.
#[cold]
fn any_normal(x: Vector, axes: &[Vector; 3]) -> Vector {
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
