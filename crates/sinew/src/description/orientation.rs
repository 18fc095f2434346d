//! Quaternions `[w, x, y, z]` as files give them: from axes, angles and pairs of directions.

use libm::{cos, sin, sqrt};

pub(super) type Quaternion = [f64; 4];
pub(super) const IDENTITY: Quaternion = [1.0, 0.0, 0.0, 0.0];

/// Norm below which a vector has no direction, as in MuJoCo.
pub(super) const SHORTEST: f64 = 1e-14;

pub(super) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn is_identity(q: Quaternion) -> bool {
    q.map(f64::to_bits) == IDENTITY.map(f64::to_bits)
}

/// The normalised vector, if it has a direction; one of unit length within rounding keeps its bits.
pub(super) fn unit<const N: usize>(vector: [f64; N]) -> Option<[f64; N]> {
    let length = sqrt(vector.iter().map(|x| x * x).sum());
    if (length - 1.0).abs() <= 2.0 * f64::EPSILON {
        return Some(vector);
    }
    (length.is_finite() && length >= SHORTEST).then(|| vector.map(|x| x / length))
}

/// `a b`: first `b`, then `a`.
pub(super) fn product(a: Quaternion, b: Quaternion) -> Quaternion {
    [
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    ]
}

/// The rotation matrix; its columns are the rotated axes.
pub(super) fn matrix(q: Quaternion) -> [[f64; 3]; 3] {
    let [w, x, y, z] = q;
    [
        [w * w + x * x - y * y - z * z, 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), w * w - x * x + y * y - z * z, 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), w * w - x * x - y * y + z * z],
    ]
}

pub(super) fn rotate(q: Quaternion, v: [f64; 3]) -> [f64; 3] {
    if is_identity(q) {
        return v;
    }
    matrix(q).map(|row| dot(row, v))
}

pub(super) fn about(axis: [f64; 3], angle: f64) -> Quaternion {
    let (s, c) = (sin(angle / 2.0), cos(angle / 2.0));
    [c, s * axis[0], s * axis[1], s * axis[2]]
}

/// The smallest rotation from z to a unit vector.
pub(super) fn z_to(direction: [f64; 3]) -> Quaternion {
    let axis = cross([0.0, 0.0, 1.0], direction);
    let s = sqrt(dot(axis, axis));
    // Parallel to z: a rotation about x, as in MuJoCo.
    let axis = if s < 1e-10 { [1.0, 0.0, 0.0] } else { axis.map(|x| x / s) };
    about(axis, libm::atan2(s, direction[2]))
}

/// From orthonormal axes (columns of the rotation matrix).
pub(super) fn from_axes(x: [f64; 3], y: [f64; 3], z: [f64; 3]) -> Quaternion {
    let (m00, m11, m22) = (x[0], y[1], z[2]);
    let q = if m00 + m11 + m22 > 0.0 {
        let w = 0.5 * sqrt(1.0 + m00 + m11 + m22);
        [w, 0.25 * (y[2] - z[1]) / w, 0.25 * (z[0] - x[2]) / w, 0.25 * (x[1] - y[0]) / w]
    } else if m00 > m11 && m00 > m22 {
        let a = 0.5 * sqrt(1.0 + m00 - m11 - m22);
        [0.25 * (y[2] - z[1]) / a, a, 0.25 * (y[0] + x[1]) / a, 0.25 * (z[0] + x[2]) / a]
    } else if m11 > m22 {
        let b = 0.5 * sqrt(1.0 - m00 + m11 - m22);
        [0.25 * (z[0] - x[2]) / b, 0.25 * (y[0] + x[1]) / b, b, 0.25 * (z[1] + y[2]) / b]
    } else {
        let c = 0.5 * sqrt(1.0 - m00 - m11 + m22);
        [0.25 * (x[1] - y[0]) / c, 0.25 * (z[0] + x[2]) / c, 0.25 * (z[1] + y[2]) / c, c]
    };
    unit(q).unwrap_or(IDENTITY)
}

/// Euler angles in a sequence such as `xyz`: lower case for moving axes, upper case for fixed ones.
pub(super) fn euler(angles: [f64; 3], sequence: [u8; 3]) -> Quaternion {
    let mut total = IDENTITY;
    for (angle, letter) in angles.into_iter().zip(sequence) {
        let axis = match letter.to_ascii_lowercase() {
            b'x' => [1.0, 0.0, 0.0],
            b'y' => [0.0, 1.0, 0.0],
            _ => [0.0, 0.0, 1.0],
        };
        let turn = about(axis, angle);
        total = if letter.is_ascii_lowercase() { product(total, turn) } else { product(turn, total) };
    }
    unit(total).unwrap_or(IDENTITY)
}

/// `R diag R^T` for a symmetric tensor `[xx, yy, zz, xy, xz, yz]`.
pub(super) fn turn_tensor(q: Quaternion, t: [f64; 6]) -> [f64; 6] {
    if is_identity(q) {
        return t;
    }
    let r = matrix(q);
    let m = [[t[0], t[3], t[4]], [t[3], t[1], t[5]], [t[4], t[5], t[2]]];
    let entry = |i: usize, j: usize| dot(r[i], m.map(|row| dot(row, r[j])));
    [entry(0, 0), entry(1, 1), entry(2, 2), entry(0, 1), entry(0, 2), entry(1, 2)]
}
