//! Where the camera stands, from the design alone: a rigid fit that points far off do not disturb.

use super::GeometryError;
use super::places::{distance, median};
use crate::fit::linear_algebra::{Matrix, symmetric_eigen};
use sinew::body::Pose;
use sinew::random::Random;

/// Draws of four points.
const DRAWS: usize = 300;
/// Ratio of lengths that is still a camera's scale.
const SCALES: std::ops::Range<f64> = 0.8..1.25;
/// Fraction of the residual that a mirrored camera leaves.
const MIRRORED: f64 = 0.4;

/// A marker, where it is in the world and where it is seen, m.
pub(super) type Pair = (usize, [f64; 3], [f64; 3]);

/// The world in the camera's frame.
///
/// # Errors
/// [`GeometryError::Observations`] where lengths do not agree, or one axis has the wrong sign.
pub(super) fn start(pairs: &[Pair]) -> Result<Pose, GeometryError> {
    let refuse = |text: String| Err(GeometryError::Observations(text));
    let far = |at: usize| (1..8).map(move |k| (at, (at + k * pairs.len() / 8) % pairs.len()));
    let ratios = (0..pairs.len()).flat_map(far).filter_map(|(a, b)| {
        let known = distance(pairs[a].1, pairs[b].1);
        (known > 0.02).then(|| distance(pairs[a].2, pairs[b].2) / known)
    });
    let ratio = median(ratios);
    if !SCALES.contains(&ratio) {
        return refuse(format!(
            "lengths that the camera sees are {ratio:.3} times those of the machine: expected metres, and markers \
             with the names of the machine"
        ));
    }
    let best = consensus(pairs);
    let mirrored: Vec<_> = pairs.iter().map(|(m, x, y)| (*m, *x, [y[0], -y[1], y[2]])).collect();
    let other = consensus(&mirrored);
    if other.1 < MIRRORED * best.1 {
        return refuse("one axis of the camera has the wrong sign: expected a right-handed frame".to_owned());
    }
    Ok(best.0)
}

/// The rigid fit with the least sum of the markers' median residuals, m, improved by the points near it.
fn consensus(pairs: &[Pair]) -> (Pose, f64) {
    let residual = |pose: &Pose, (_, x, y): &Pair| distance(pose.point(*x), *y);
    let markers = 1 + pairs.iter().map(|pair| pair.0).max().unwrap_or(0);
    let of = |pose: &Pose, marker: usize| {
        median(pairs.iter().filter(|pair| pair.0 == marker).map(|pair| residual(pose, pair)))
    };
    let middle = |pose: &Pose| -> f64 { (0..markers).map(|m| of(pose, m)).filter(|x| x.is_finite()).sum() };
    let mut random = Random::new(1);
    let mut best = rigid(pairs);
    let mut least = middle(&best);
    for _ in 0..DRAWS {
        let four: [Pair; 4] = std::array::from_fn(|_| pairs[(random.unit() * pairs.len() as f64) as usize]);
        let trial = rigid(&four);
        let miss = middle(&trial);
        if miss < least {
            (best, least) = (trial, miss);
        }
    }
    let near: Vec<Pair> = pairs.iter().filter(|pair| residual(&best, pair) <= 3.0 * least).copied().collect();
    let improved = rigid(&near);
    let miss = middle(&improved);
    if miss < least { (improved, miss) } else { (best, least) }
}

/// The least-squares rigid fit of pairs `x -> y`.
///
/// # Source
/// Horn 1987: the quaternion is the eigenvector of the largest eigenvalue.
fn rigid(pairs: &[Pair]) -> Pose {
    let n = pairs.len().max(1) as f64;
    let mean = |of: fn(&Pair) -> [f64; 3]| -> [f64; 3] {
        std::array::from_fn(|k| pairs.iter().map(|pair| of(pair)[k]).sum::<f64>() / n)
    };
    let (x0, y0) = (mean(|pair| pair.1), mean(|pair| pair.2));
    let mut s = [[0.0; 3]; 3];
    for (_, x, y) in pairs {
        for (i, row) in s.iter_mut().enumerate() {
            for (j, entry) in row.iter_mut().enumerate() {
                *entry += (x[i] - x0[i]) * (y[j] - y0[j]);
            }
        }
    }
    let [[xx, xy, xz], [yx, yy, yz], [zx, zy, zz]] = s;
    let rows = [
        [xx + yy + zz, yz - zy, zx - xz, xy - yx],
        [yz - zy, xx - yy - zz, xy + yx, zx + xz],
        [zx - xz, xy + yx, yy - xx - zz, yz + zy],
        [xy - yx, zx + xz, yz + zy, zz - xx - yy],
    ];
    let quaternion =
        symmetric_eigen(&Matrix::from_fn(4, |i, j| rows[i][j])).map_or([1.0, 0.0, 0.0, 0.0], |e| {
            let largest = (0..4).max_by(|a, b| e.0[*a].total_cmp(&e.0[*b])).unwrap_or(0);
            std::array::from_fn(|k| e.1[(k, largest)])
        });
    let turn = Pose::new(quaternion, [0.0; 3]);
    let moved = turn.point(x0);
    Pose { origin: std::array::from_fn(|k| y0[k] - moved[k]), ..turn }
}
