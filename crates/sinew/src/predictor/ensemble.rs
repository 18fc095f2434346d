//! Eight small networks side by side, and how far they agree.

use crate::math::quick_tanh_f32;
use alloc::vec::Vec;
use serde::{Deserialize, Serialize};

/// Networks in an ensemble: one per SIMD lane.
pub const MEMBERS: usize = 8;

/// One number for each network. Single precision: its rounding, 1e-7 of a correction, is far below any
/// sensor's, and eight lanes fill two plain SSE2 registers instead of four.
pub type Lanes = [f32; MEMBERS];

/// Eight networks with one hidden layer of tanh nodes and a linear skip, trained from different starts.
///
/// ```text
/// z = (clamp(x, clip_low, clip_high) - mean) / scale
/// c_k = bias_k + skip_k . z + sum_j v_kj tanh(W_kj . z + d_kj)
/// ```
///
/// Inputs are clipped to the box of the training data: outside it physics extrapolates and the network
/// keeps its value at the edge.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ensemble {
    /// Lower edge of the clip box: `[features]`.
    pub clip_low: Vec<f64>,
    /// Upper edge of the clip box: `[features]`.
    pub clip_high: Vec<f64>,
    /// Subtracted after clipping: `[features]`.
    pub mean: Vec<f64>,
    /// Divided by after that: `[features]`.
    pub scale: Vec<f64>,
    /// `W`, one row of features per hidden node: `[hidden x features]`.
    pub hidden_weights: Vec<Lanes>,
    /// `d`: `[hidden]`.
    pub hidden_bias: Vec<Lanes>,
    /// `v`, far unit: `[hidden]`.
    pub output_weights: Vec<Lanes>,
    /// Linear part, far unit: `[features]`.
    pub skip: Vec<Lanes>,
    /// Offset, far unit.
    pub bias: Lanes,
}

/// What the networks say of one sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Opinion {
    /// Median over the networks, far unit.
    pub median: f64,
    /// Variance over the networks, far unit squared.
    pub variance: f64,
    /// Features outside the clip box.
    pub clipped: usize,
}

impl Ensemble {
    /// The opinion on one sample; `features` and `scratch`: `[features]`.
    #[must_use]
    pub fn opinion(&self, features: &[f64], scratch: &mut [f32]) -> Opinion {
        let mut clipped = 0;
        let box_edges = self.clip_low.iter().zip(&self.clip_high);
        let standard = self.mean.iter().zip(&self.scale);
        for (((z, &x), (&low, &high)), (mean, scale)) in
            scratch.iter_mut().zip(features).zip(box_edges).zip(standard)
        {
            let inside = x.max(low).min(high);
            clipped += usize::from(x < low || x > high);
            *z = ((inside - mean) / scale) as f32;
        }
        let outputs = self.outputs(scratch);
        let mean = outputs.iter().sum::<f64>() / MEMBERS as f64;
        let variance = outputs.iter().map(|c| (c - mean) * (c - mean)).sum::<f64>() / (MEMBERS - 1) as f64;
        Opinion { median: median(outputs), variance, clipped }
    }

    #[inline]
    fn outputs(&self, z: &[f32]) -> [f64; MEMBERS] {
        let mut outputs = self.bias;
        for (weight, z) in self.skip.iter().zip(z) {
            add_scaled(&mut outputs, weight, *z);
        }
        let rows = self.hidden_weights.chunks_exact(z.len());
        for ((row, bias), output) in rows.zip(&self.hidden_bias).zip(&self.output_weights) {
            let mut node = *bias;
            for (weight, z) in row.iter().zip(z) {
                add_scaled(&mut node, weight, *z);
            }
            for ((sum, node), weight) in outputs.iter_mut().zip(node).zip(output) {
                *sum += weight * quick_tanh_f32(node);
            }
        }
        outputs.map(f64::from)
    }
}

#[inline]
fn add_scaled(sum: &mut Lanes, weight: &Lanes, z: f32) {
    for (sum, weight) in sum.iter_mut().zip(weight) {
        *sum += weight * z;
    }
}

/// Median of eight: the mean of the middle two, after Batcher's sorting network.
#[inline]
fn median(mut v: [f64; MEMBERS]) -> f64 {
    const PAIRS: [(usize, usize); 19] = [
        (0, 1),
        (2, 3),
        (4, 5),
        (6, 7),
        (0, 2),
        (1, 3),
        (4, 6),
        (5, 7),
        (1, 2),
        (5, 6),
        (0, 4),
        (1, 5),
        (2, 6),
        (3, 7),
        (2, 4),
        (3, 5),
        (1, 2),
        (3, 4),
        (5, 6),
    ];
    for (i, j) in PAIRS {
        let (a, b) = (v[i], v[j]);
        v[i] = a.min(b);
        v[j] = a.max(b);
    }
    0.5 * (v[3] + v[4])
}
