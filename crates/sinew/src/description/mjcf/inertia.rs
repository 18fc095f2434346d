//! Mass and inertia of a body from its solids.

use super::solid::Solid;
use crate::description::orientation::turn_tensor;
use alloc::format;
use alloc::string::String;

/// Mass, centre of mass and inertia about it `[xx, yy, zz, xy, xz, yz]`, in the body's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Inertia {
    pub(super) mass: f64,
    pub(super) center: [f64; 3],
    pub(super) tensor: [f64; 6],
}

pub(super) const NOTHING: Inertia = Inertia { mass: 0.0, center: [0.0; 3], tensor: [0.0; 6] };

impl From<&Solid> for Inertia {
    fn from(solid: &Solid) -> Self {
        let tensor = turn_tensor(solid.orientation, diagonal(solid.inertia));
        Self { mass: solid.mass, center: solid.position, tensor }
    }
}

/// Sum over all parts.
pub(super) fn total(parts: &[Inertia]) -> Inertia {
    if let [one] = parts {
        return *one;
    }
    let mass: f64 = parts.iter().map(|part| part.mass).sum();
    if mass < 1e-14 {
        return NOTHING;
    }
    let mut center = [0.0; 3];
    for part in parts {
        (0..3).for_each(|i| center[i] += part.mass * part.center[i]);
    }
    center = center.map(|x| x / mass);
    let mut tensor = [0.0; 6];
    for part in parts {
        let shift = steiner(part.mass, core::array::from_fn(|i| part.center[i] - center[i]));
        (0..6).for_each(|i| tensor[i] += part.tensor[i] + shift[i]);
    }
    Inertia { mass, center, tensor }
}

pub(super) fn diagonal(d: [f64; 3]) -> [f64; 6] {
    [d[0], d[1], d[2], 0.0, 0.0, 0.0]
}

/// Inertia of a point mass at `d`.
fn steiner(m: f64, d: [f64; 3]) -> [f64; 6] {
    let [x, y, z] = d;
    [m * (y * y + z * z), m * (x * x + z * z), m * (x * x + y * y), -m * x * y, -m * x * z, -m * y * z]
}

/// Principal moments of a tensor and its principal axes, as columns.
pub(super) fn principal(t: [f64; 6]) -> ([f64; 3], [[f64; 3]; 3]) {
    let mut a = [[t[0], t[3], t[4]], [t[3], t[1], t[5]], [t[4], t[5], t[2]]];
    let mut v = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    // Cyclic Jacobi rotations; twelve sweeps exceed what a 3 x 3 matrix needs.
    for _ in 0..12 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            if a[p][q] == 0.0 {
                continue;
            }
            let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
            let t = libm::copysign(1.0, theta) / (theta.abs() + libm::sqrt(theta * theta + 1.0));
            let c = 1.0 / libm::sqrt(t * t + 1.0);
            let s = t * c;
            for row in &mut a {
                (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
            }
            let (from, to) = (a[p], a[q]);
            a[p] = core::array::from_fn(|k| c * from[k] - s * to[k]);
            a[q] = core::array::from_fn(|k| s * from[k] + c * to[k]);
            for row in &mut v {
                (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
            }
        }
    }
    ([a[0][0], a[1][1], a[2][2]], v)
}

/// The tensor from principal moments and axes.
pub(super) fn compose(moments: [f64; 3], v: [[f64; 3]; 3]) -> [f64; 6] {
    let entry = |i: usize, j: usize| (0..3).map(|k| v[i][k] * moments[k] * v[j][k]).sum();
    [entry(0, 0), entry(1, 1), entry(2, 2), entry(0, 1), entry(0, 2), entry(1, 2)]
}

/// Checks that the inertia about the centre of mass is physically possible.
pub(in crate::description) fn possible(tensor: [f64; 6]) -> Result<(), String> {
    let (moments, _) = principal(tensor);
    let largest = moments.iter().fold(0.0, |most: f64, m| most.max(m.abs()));
    if !largest.is_finite() || moments.iter().any(|m| *m < -1e-12 * largest) {
        return Err(format!("has principal moments of inertia {moments:?}: expected none below zero"));
    }
    let [a, b, c] = moments;
    if 2.0 * a.max(b).max(c) > (a + b + c) + 1e-14 + 1e-9 * largest {
        return Err(format!(
            "has principal moments of inertia {moments:?}: expected none above the sum of the others, which \
                no body of matter has (in MJCF `balanceinertia` evens them out)"
        ));
    }
    Ok(())
}
