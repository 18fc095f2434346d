//! 3-vectors, rotation matrices (as three columns: the axes of a frame), quaternions `[w, x, y, z]`.

/// A vector in space.
pub(crate) type Vector = [f64; 3];

/// Axes of a frame, as columns in the frame they are written in.
pub(crate) type Frame = [Vector; 3];

/// The identity.
pub(crate) const IDENTITY: Frame = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

#[inline]
pub(crate) fn add(a: Vector, b: Vector) -> Vector {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[inline]
pub(crate) fn sub(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline]
pub(crate) fn scale(s: f64, a: Vector) -> Vector {
    [s * a[0], s * a[1], s * a[2]]
}

/// `a + s b`.
#[inline]
pub(crate) fn add_scaled(a: Vector, s: f64, b: Vector) -> Vector {
    [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]]
}

#[inline]
pub(crate) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline]
pub(crate) fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[inline]
pub(crate) fn norm(a: Vector) -> f64 {
    libm::sqrt(dot(a, a))
}

/// `F v`: from the frame to the frame in which its axes are given.
#[inline]
pub(crate) fn rotate(frame: &Frame, v: Vector) -> Vector {
    let [x, y, z] = frame;
    [
        x[0] * v[0] + y[0] * v[1] + z[0] * v[2],
        x[1] * v[0] + y[1] * v[1] + z[1] * v[2],
        x[2] * v[0] + y[2] * v[1] + z[2] * v[2],
    ]
}

/// `F^T v`, the inverse of [`rotate`].
#[inline]
pub(crate) fn unrotate(frame: &Frame, v: Vector) -> Vector {
    [dot(frame[0], v), dot(frame[1], v), dot(frame[2], v)]
}

/// Product of two rotations: the axes of `inner` are given in the frame `outer`.
#[inline]
pub(crate) fn compose(outer: &Frame, inner: &Frame) -> Frame {
    [rotate(outer, inner[0]), rotate(outer, inner[1]), rotate(outer, inner[2])]
}

pub(crate) fn transpose(frame: &Frame) -> Frame {
    let [x, y, z] = frame;
    [[x[0], y[0], z[0]], [x[1], y[1], z[1]], [x[2], y[2], z[2]]]
}

/// A right-handed frame whose z is the unit vector `axis`; exact when the axis is one of the three.
pub(crate) fn frame_about(axis: Vector) -> Frame {
    let (mut least, mut min_size) = (0, f64::INFINITY);
    for (k, component) in axis.iter().enumerate() {
        if component.abs() < min_size {
            (least, min_size) = (k, component.abs());
        }
    }
    let mut x = add_scaled([0.0; 3], -axis[least], axis);
    x[least] += 1.0;
    let x = scale(1.0 / norm(x), x);
    [x, cross(axis, x), axis]
}

/// A symmetric matrix `[xx, yy, zz, xy, xz, yz]` times a vector.
#[inline]
pub(crate) fn symmetric(m: &[f64; 6], v: Vector) -> Vector {
    [
        m[0] * v[0] + m[3] * v[1] + m[4] * v[2],
        m[3] * v[0] + m[1] * v[1] + m[5] * v[2],
        m[4] * v[0] + m[5] * v[1] + m[2] * v[2],
    ]
}

/// `F S F^T` for a symmetric matrix `S`.
pub(crate) fn rotate_symmetric(frame: &Frame, m: &[f64; 6]) -> [f64; 6] {
    let rows = transpose(frame);
    let through = rows.map(|row| symmetric(m, row));
    [
        dot(rows[0], through[0]),
        dot(rows[1], through[1]),
        dot(rows[2], through[2]),
        dot(rows[0], through[1]),
        dot(rows[0], through[2]),
        dot(rows[1], through[2]),
    ]
}

/// Inertia of a point mass at `r` about the origin, kg m^2: `[xx, yy, zz, xy, xz, yz]`, off-diagonal entries
/// negative products.
pub(crate) fn point_inertia(mass: f64, r: Vector) -> [f64; 6] {
    let [x, y, z] = r;
    [y * y + z * z, x * x + z * z, x * x + y * y, -x * y, -x * z, -y * z].map(|entry| mass * entry)
}

/// The normalised quaternion; the identity for one no longer than 1e-15.
#[inline]
pub(crate) fn unit_quaternion(q: [f64; 4]) -> [f64; 4] {
    let length = libm::sqrt(q.iter().map(|x| x * x).sum());
    if length > 1e-15 { q.map(|x| x / length) } else { [1.0, 0.0, 0.0, 0.0] }
}

pub(crate) fn quaternion_product(a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
    [
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    ]
}

/// The axes of a unit quaternion.
pub(crate) fn frame_of(q: [f64; 4]) -> Frame {
    let [w, x, y, z] = q;
    [
        [w * w + x * x - y * y - z * z, 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)],
        [2.0 * (x * y - w * z), w * w - x * x + y * y - z * z, 2.0 * (y * z + w * x)],
        [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), w * w - x * x - y * y + z * z],
    ]
}

/// The quaternion of a rotation vector.
pub(crate) fn quaternion_of(rotation: Vector) -> [f64; 4] {
    let angle = norm(rotation);
    if angle < 1e-150 {
        return [1.0, 0.0, 0.0, 0.0];
    }
    let (sine, cosine) = libm::sincos(0.5 * angle);
    let [x, y, z] = scale(sine / angle, rotation);
    [cosine, x, y, z]
}

/// The rotation vector of a unit quaternion, its angle in (-pi, pi].
pub(crate) fn rotation_of(q: [f64; 4]) -> Vector {
    let axis = [q[1], q[2], q[3]];
    let sine = norm(axis);
    if sine < 1e-150 {
        return [0.0; 3];
    }
    let angle = 2.0 * libm::atan2(sine, q[0]);
    let angle = if angle > core::f64::consts::PI { angle - 2.0 * core::f64::consts::PI } else { angle };
    scale(angle / sine, axis)
}

/// `a . b` of two slices of one length.
pub(crate) fn product(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Solves a symmetric positive definite 3 x 3 system by Cholesky factorisation.
pub(crate) fn solve_symmetric(mut a: [[f64; 3]; 3], mut b: Vector) -> Vector {
    let floor = 1e-18 * (a[0][0] + a[1][1] + a[2][2]) + f64::MIN_POSITIVE;
    for i in 0..3 {
        for j in 0..=i {
            let rest = a[i][j] - (0..j).map(|k| a[i][k] * a[j][k]).sum::<f64>();
            a[i][j] = if i == j { libm::sqrt(rest.max(floor)) } else { rest / a[j][j] };
        }
        b[i] = (b[i] - (0..i).map(|k| a[i][k] * b[k]).sum::<f64>()) / a[i][i];
    }
    for i in (0..3).rev() {
        b[i] = (b[i] - (i + 1..3).map(|k| a[k][i] * b[k]).sum::<f64>()) / a[i][i];
    }
    b
}

/// The quaternion of a frame, by the largest of its four components.
pub(crate) fn quaternion_of_axes(axes: &Frame) -> [f64; 4] {
    let [x, y, z] = *axes;
    let squares = [
        1.0 + x[0] + y[1] + z[2],
        1.0 + x[0] - y[1] - z[2],
        1.0 - x[0] + y[1] - z[2],
        1.0 - x[0] - y[1] + z[2],
    ];
    let mut largest = 0;
    for k in 1..4 {
        if squares[k] > squares[largest] {
            largest = k;
        }
    }
    let raw = match largest {
        0 => [squares[0], y[2] - z[1], z[0] - x[2], x[1] - y[0]],
        1 => [y[2] - z[1], squares[1], x[1] + y[0], z[0] + x[2]],
        2 => [z[0] - x[2], x[1] + y[0], squares[2], y[2] + z[1]],
        _ => [x[1] - y[0], z[0] + x[2], y[2] + z[1], squares[3]],
    };
    unit_quaternion(raw)
}
