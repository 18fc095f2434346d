//! Eight small networks, one per SIMD lane: median and variance of their outputs.

use crate::math::quick_tanh_lanes;
use alloc::vec::Vec;
use serde::{Deserialize, Serialize};

/// Networks in an ensemble: one per SIMD lane.
pub const MEMBERS: usize = 8;

/// One number for each network. Single precision: its rounding, 1e-7 of a correction, is far below the noise
/// of a sensor, and eight numbers fill two SSE2 registers instead of four.
pub type PerNetwork = [f32; MEMBERS];

/// Eight networks with one hidden layer of tanh nodes and a linear skip, trained from different starts.
///
/// ```text
/// z = (clamp(x, clip_low, clip_high) - mean) inverse_scale
/// c_k = bias_k + skip_k . z + sum_j v_kj tanh(W_kj . z + d_kj)
/// ```
///
/// Inputs are clipped to the box of the training data: outside it the networks are constant and only the
/// physics extrapolates. Weights are trained by `sinew_identify`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ensemble {
    /// Lower edge of the clip box: `[features]`.
    pub clip_low: Vec<f64>,
    /// Upper edge of the clip box: `[features]`.
    pub clip_high: Vec<f64>,
    /// Subtracted after clipping: `[features]`.
    pub mean: Vec<f64>,
    /// One over the standard deviation, multiplied by after that: `[features]`.
    pub inverse_scale: Vec<f64>,
    /// `W`, one row of features per hidden node: `[hidden x features]`.
    pub hidden_weights: Vec<PerNetwork>,
    /// `d`: `[hidden]`.
    pub hidden_bias: Vec<PerNetwork>,
    /// `v`, far unit: `[hidden]`.
    pub output_weights: Vec<PerNetwork>,
    /// Linear part, far unit: `[features]`.
    pub skip: Vec<PerNetwork>,
    /// Offset, far unit.
    pub bias: PerNetwork,
}

/// Outputs of the networks at one sample, summarised.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EnsembleOutput {
    /// Median over the networks, far unit.
    pub median: f64,
    /// Variance over the networks, far unit squared.
    pub variance: f64,
    /// Features outside the clip box.
    pub clipped: usize,
    /// Largest distance of a feature from that box, in its standard deviations.
    pub beyond: f64,
}

impl Ensemble {
    /// Median and variance of the networks at one sample; `features` and `scratch`: `[features]`.
    #[must_use]
    pub fn evaluate(&self, features: &[f64], scratch: &mut [f32]) -> EnsembleOutput {
        let (mut clipped, mut beyond) = (0, 0.0_f64);
        let box_edges = self.clip_low.iter().zip(&self.clip_high);
        let standard = self.mean.iter().zip(&self.inverse_scale);
        for (((z, &x), (&low, &high)), (mean, scale)) in
            scratch.iter_mut().zip(features).zip(box_edges).zip(standard)
        {
            // Comparisons instead of `max` and `min`, which also order NaN; features are finite.
            let above = if x < low { low } else { x };
            let inside = if above > high { high } else { above };
            clipped += usize::from(x < low) + usize::from(x > high);
            let excess = (x - inside).abs() * scale;
            beyond = if excess > beyond { excess } else { beyond };
            *z = ((inside - mean) * scale) as f32;
        }
        let outputs = self.outputs(scratch);
        let mean = sum(outputs) / MEMBERS as f32;
        let mut squares = outputs;
        for output in &mut squares {
            let deviation = *output - mean;
            *output = deviation * deviation;
        }
        let variance = sum(squares) / (MEMBERS - 1) as f32;
        EnsembleOutput { median: f64::from(median(outputs)), variance: f64::from(variance), clipped, beyond }
    }

    #[inline]
    fn outputs(&self, z: &[f32]) -> PerNetwork {
        let mut outputs = self.bias;
        for (weight, z) in self.skip.iter().zip(z) {
            add(&mut outputs, weight, [*z; MEMBERS]);
        }
        // Two nodes at a time: their sums are independent chains of additions.
        let (row, nodes) = (z.len().max(1), self.hidden_bias.len());
        let mut rows = self.hidden_weights.chunks_exact(2 * row);
        let biases = self.hidden_bias.chunks_exact(2).zip(self.output_weights.chunks_exact(2));
        for (pair, (bias, output)) in rows.by_ref().zip(biases) {
            let (first, second) = pair.split_at(row);
            let (mut a, mut b) = (bias[0], bias[1]);
            for ((first, second), z) in first.iter().zip(second).zip(z) {
                add(&mut a, first, [*z; MEMBERS]);
                add(&mut b, second, [*z; MEMBERS]);
            }
            add(&mut outputs, &output[0], quick_tanh_lanes(a));
            add(&mut outputs, &output[1], quick_tanh_lanes(b));
        }
        if let (1, Some(bias), Some(output)) =
            (nodes % 2, self.hidden_bias.last(), self.output_weights.last())
        {
            let mut node = *bias;
            for (weight, z) in rows.remainder().iter().zip(z) {
                add(&mut node, weight, [*z; MEMBERS]);
            }
            add(&mut outputs, output, quick_tanh_lanes(node));
        }
        outputs
    }
}

/// Adds `weight input`, lane by lane. At opt-level 3 the compiler makes vector instructions of it, at 2 of
/// the hyperbolic tangents alone.
#[inline(always)]
fn add(sum: &mut PerNetwork, weight: &PerNetwork, input: PerNetwork) {
    for ((sum, weight), input) in sum.iter_mut().zip(weight).zip(input) {
        *sum += weight * input;
    }
}

/// Pairwise sum, three additions deep.
#[inline]
fn sum(v: PerNetwork) -> f32 {
    ((v[0] + v[4]) + (v[1] + v[5])) + ((v[2] + v[6]) + (v[3] + v[7]))
}

/// Median of eight, the mean of the middle two, by Batcher's sorting network without the last exchanges of
/// the other six.
#[inline]
fn median(mut v: PerNetwork) -> f32 {
    order(&mut v, [(0, 1), (2, 3), (4, 5), (6, 7)]);
    order(&mut v, [(0, 2), (1, 3), (4, 6), (5, 7)]);
    order(&mut v, [(1, 2), (5, 6)]);
    order(&mut v, [(0, 4), (1, 5), (2, 6), (3, 7)]);
    order(&mut v, [(2, 4), (3, 5)]);
    order(&mut v, [(3, 4)]);
    0.5 * (v[3] + v[4])
}

/// Orders pairs. Few at a time: a loop over all pairs of the network is not unrolled, which keeps the numbers
/// in memory.
#[inline(always)]
fn order<const N: usize>(v: &mut PerNetwork, pairs: [(usize, usize); N]) {
    for (i, j) in pairs {
        let (a, b) = (v[i], v[j]);
        v[i] = if a < b { a } else { b };
        v[j] = if a > b { a } else { b };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec;

    fn ensemble() -> Ensemble {
        let mut k = 0.0_f32;
        let mut next = || -> PerNetwork {
            core::array::from_fn(|_| {
                k += 1.0;
                k.sin()
            })
        };
        Ensemble {
            clip_low: vec![-1.0, -2.0],
            clip_high: vec![1.0, 2.0],
            mean: vec![0.2, -0.1],
            inverse_scale: vec![2.0, 0.5],
            hidden_weights: (0..6).map(|_| next()).collect(),
            hidden_bias: (0..3).map(|_| next()).collect(),
            output_weights: (0..3).map(|_| next()).collect(),
            skip: (0..2).map(|_| next()).collect(),
            bias: next(),
        }
    }

    /// The same sums in double precision with an exact tanh.
    fn reference(e: &Ensemble, x: [f64; 2], lane: usize) -> f64 {
        let at = |v: &PerNetwork| f64::from(v[lane]);
        let z: Vec<f64> = (0..2)
            .map(|i| (x[i].clamp(e.clip_low[i], e.clip_high[i]) - e.mean[i]) * e.inverse_scale[i])
            .collect();
        let dot = |rows: &[PerNetwork]| rows.iter().zip(&z).map(|(w, z)| at(w) * z).sum::<f64>();
        let node = |j: usize| (at(&e.hidden_bias[j]) + dot(&e.hidden_weights[2 * j..])).tanh();
        at(&e.bias) + dot(&e.skip) + (0..3).map(|j| at(&e.output_weights[j]) * node(j)).sum::<f64>()
    }

    #[test]
    fn the_output_is_the_median_and_variance_of_the_networks() {
        let e = ensemble();
        for step in 0..200 {
            let x = [(f64::from(step) * 0.7).sin(), 3.0 * (f64::from(step) * 0.3).cos()];
            let mut each: Vec<f64> = (0..MEMBERS).map(|lane| reference(&e, x, lane)).collect();
            each.sort_by(f64::total_cmp);
            let mean = each.iter().sum::<f64>() / 8.0;
            let variance = each.iter().map(|c| (c - mean).powi(2)).sum::<f64>() / 7.0;
            let output = e.evaluate(&x, &mut [0.0; 2]);
            assert!((output.median - 0.5 * (each[3] + each[4])).abs() < 5e-4, "{output:?}");
            assert!((output.variance - variance).abs() < 2e-3 * (1.0 + variance), "{output:?}");
        }
    }

    #[test]
    fn outside_the_box_the_networks_are_constant_and_clipping_is_counted() {
        let e = ensemble();
        let edge = e.evaluate(&[1.0, 2.0], &mut [0.0; 2]);
        let far = e.evaluate(&[50.0, 1e9], &mut [0.0; 2]);
        assert_eq!(edge.median.to_bits(), far.median.to_bits());
        assert_eq!((edge.clipped, far.clipped), (0, 2));
    }

    #[test]
    fn any_numbers_of_features_and_nodes_give_the_sum_of_the_networks() {
        for features in 1..=4 {
            for hidden in 0..=5 {
                let mut k = 0.0_f32;
                let mut rows = |count: usize| -> Vec<PerNetwork> {
                    let mut next = || {
                        k += 1.3;
                        k.sin()
                    };
                    (0..count).map(|_| core::array::from_fn(|_| next())).collect()
                };
                let e = Ensemble {
                    clip_low: vec![-2.0; features],
                    clip_high: vec![2.0; features],
                    mean: vec![0.3; features],
                    inverse_scale: vec![0.7; features],
                    hidden_weights: rows(hidden * features),
                    hidden_bias: rows(hidden),
                    output_weights: rows(hidden),
                    skip: rows(features),
                    bias: rows(1)[0],
                };
                let x: Vec<f64> = (0..features).map(|i| 0.4 + 0.3 * i as f64).collect();
                let z: Vec<f64> = x.iter().map(|x| (x - 0.3) * 0.7).collect();
                let mut sum = 0.0;
                for lane in 0..MEMBERS {
                    let dot = |rows: &[PerNetwork]| {
                        rows.iter().zip(&z).map(|(w, z)| f64::from(w[lane]) * z).sum::<f64>()
                    };
                    sum += f64::from(e.bias[lane]) + dot(&e.skip);
                    for (j, row) in e.hidden_weights.chunks_exact(features).enumerate() {
                        let node = (f64::from(e.hidden_bias[j][lane]) + dot(row)).tanh();
                        sum += f64::from(e.output_weights[j][lane]) * node;
                    }
                }
                let z: Vec<f32> = z.iter().map(|z| *z as f32).collect();
                let got = e.outputs(&z).iter().map(|output| f64::from(*output)).sum::<f64>();
                assert!((got - sum).abs() < 7e-7, "{features} features, {hidden} nodes: {got} {sum}");
            }
        }
    }

    #[test]
    fn features_below_and_above_the_box_are_counted_and_those_on_its_edges_are_not() {
        let (e, mut scratch) = (ensemble(), [0.0; 2]);
        for (x, clipped) in
            [([-1.0, 2.0], 0), ([-1.1, 0.0], 1), ([1.1, 0.0], 1), ([-9.0, 9.0], 2), ([0.0, -2.0], 0)]
        {
            assert_eq!(e.evaluate(&x, &mut scratch).clipped, clipped, "{x:?}");
        }
    }
}
