//! The network laid out for vectors over nodes, and what it makes of a block of samples.

use super::product::BLOCK;
use super::simd::{Real, load, padded, store, tanh};
use pulp::{Simd, WithSimd};

/// A network; also the meaning of the parameter vector.
///
/// Parameters are `[W_00 .. W_0h, W_10 .. , b_0 .. b_h, v_0 .. v_h, c]`, input by input.
#[derive(Debug, Clone)]
pub(super) struct Net {
    pub(super) inputs: usize,
    pub(super) hidden: usize,
    /// Nodes with those that fill up the last vector; the latter are always zero.
    pub(super) wide: usize,
    /// `[inputs + 1][wide]`
    first: Vec<f64>,
    /// `[wide]`
    pub(super) second: Vec<f64>,
    bias: f64,
}

impl Net {
    pub(super) fn parameters(inputs: usize, hidden: usize) -> usize {
        (inputs + 2) * hidden + 1
    }

    pub(super) fn new(inputs: usize, hidden: usize, theta: &[f64]) -> Self {
        let wide = padded(hidden, f64::WIDEST);
        let mut rows = theta.chunks_exact(hidden.max(1)).map(|row| {
            let mut row = row.to_vec();
            row.resize(wide, 0.0);
            row
        });
        let first = rows.by_ref().take(inputs + 1).flatten().collect();
        let second = rows.next().unwrap_or_default();
        let bias = theta.last().copied().unwrap_or_default();
        Self { inputs, hidden, wide, first, second, bias }
    }

    /// Hidden nodes into the rows of `nodes: [BLOCK x wide]`, outputs less targets into `residuals`.
    #[inline(always)]
    pub(super) fn forward<S: Simd>(
        &self,
        simd: S,
        block: &[f64],
        nodes: &mut [f64],
        residuals: &mut [f64; BLOCK],
    ) {
        let fours = self.wide / (4 * S::F64_LANES) * (4 * S::F64_LANES);
        let rows = block.chunks_exact(self.inputs + 1).zip(nodes.chunks_exact_mut(self.wide)).zip(residuals);
        for ((sample, nodes), residual) in rows {
            let (inputs, target) = sample.split_at(self.inputs);
            let mut output = simd.splat_f64s(0.0);
            for at in (0..fours).step_by(4 * S::F64_LANES) {
                output = self.activate::<S, 4>(simd, inputs, nodes, at, output);
            }
            for at in (fours..self.wide).step_by(S::F64_LANES) {
                output = self.activate::<S, 1>(simd, inputs, nodes, at, output);
            }
            *residual = simd.reduce_sum_f64s(output) + self.bias - target[0];
        }
    }

    /// `N` vectors of nodes; their part of the output is added to `output`.
    #[inline(always)]
    fn activate<S: Simd, const N: usize>(
        &self,
        simd: S,
        inputs: &[f64],
        nodes: &mut [f64],
        at: usize,
        mut output: S::f64s,
    ) -> S::f64s {
        let mut sum = load::<S, f64, N>(simd, &self.first, self.inputs * self.wide + at);
        for (x, weights) in inputs.iter().zip(self.first.chunks_exact(self.wide)) {
            let x = simd.splat_f64s(*x);
            let weights = load::<S, f64, N>(simd, weights, at);
            for i in 0..N {
                sum[i] = simd.mul_add_e_f64s(x, weights[i], sum[i]);
            }
        }
        let h = tanh(simd, sum);
        store::<S, f64, N>(nodes, at, h);
        let v = load::<S, f64, N>(simd, &self.second, at);
        for i in 0..N {
            output = simd.mul_add_e_f64s(h[i], v[i], output);
        }
        output
    }
}

/// Squared error of `net` over `samples`, rows of `[inputs, target]`.
pub(super) struct SquaredError<'a> {
    pub(super) net: &'a Net,
    pub(super) samples: &'a [f64],
}

impl WithSimd for SquaredError<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let Self { net, samples } = self;
        let mut nodes = vec![0.0; BLOCK * net.wide];
        let mut residuals = [0.0; BLOCK];
        let mut sum = 0.0;
        for block in samples.chunks(BLOCK * (net.inputs + 1)) {
            let count = block.len() / (net.inputs + 1);
            net.forward(simd, block, &mut nodes, &mut residuals);
            sum += residuals[..count].iter().map(|e| e * e).sum::<f64>();
        }
        sum
    }
}
