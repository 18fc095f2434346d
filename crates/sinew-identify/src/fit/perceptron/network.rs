//! The network: as plain weights, and laid out for SIMD vectors over its nodes.

use crate::fit::simd::{Real, load, padded, store, tanh};
use crate::fit::tiles::BLOCK;
use pulp::{Simd, WithSimd};
use sinew::transmission::{Perceptron, PerceptronWeights};

/// A network of one hidden layer and the scaling around it.
///
/// ```text
/// x_i = (input_i - input_mean_i) / input_scale_i
/// output = output_mean + output_scale (c + sum_j v_j tanh(b_j + sum_i W_ji x_i))
/// ```
///
/// # Shapes
///
/// `W`: `hidden_weights: [hidden x inputs]` row-major; `b`: `hidden_bias: [hidden]`; `v`:
/// `output_weights: [hidden]`; `c`: `output_bias`; `input_mean`, `input_scale`: `[inputs]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Weights {
    /// Number of inputs.
    pub inputs: usize,
    /// Number of hidden nodes.
    pub hidden: usize,
    /// `W`, one row a node.
    pub hidden_weights: Vec<f64>,
    /// `b`.
    pub hidden_bias: Vec<f64>,
    /// `v`.
    pub output_weights: Vec<f64>,
    /// `c`.
    pub output_bias: f64,
    /// Mean of every input over the training samples, unit of the input.
    pub input_mean: Vec<f64>,
    /// Standard deviation of every input, or one where it does not vary.
    pub input_scale: Vec<f64>,
    /// Mean of the target, unit of the target.
    pub output_mean: f64,
    /// Standard deviation of the target.
    pub output_scale: f64,
}

impl Weights {
    /// Output for one sample. NaN if `input` is not `[inputs]`.
    #[must_use]
    pub fn output(&self, input: &[f64]) -> f64 {
        if input.len() != self.inputs {
            return f64::NAN;
        }
        let scaled: Vec<f64> =
            (0..self.inputs).map(|i| (input[i] - self.input_mean[i]) / self.input_scale[i]).collect();
        let mut sum = self.output_bias;
        for (j, row) in self.hidden_weights.chunks_exact(self.inputs).enumerate() {
            let net: f64 = row.iter().zip(&scaled).map(|(w, x)| w * x).sum();
            sum += self.output_weights[j] * (net + self.hidden_bias[j]).tanh();
        }
        self.output_mean + self.output_scale * sum
    }

    /// The network with the scaling moved into its weights, so that inputs and output have the units of the
    /// log; `None` where a weight is not finite.
    #[must_use]
    pub fn to_perceptron(&self) -> Option<Perceptron> {
        let slope = |k: usize| self.hidden_weights[k] / self.input_scale[k % self.inputs];
        let bias = |j: usize| {
            let shift =
                (0..self.inputs).map(|i| slope(j * self.inputs + i) * self.input_mean[i]).sum::<f64>();
            self.hidden_bias[j] - shift
        };
        Perceptron::new(PerceptronWeights {
            inputs: self.inputs,
            hidden: self.hidden,
            input_weights: (0..self.hidden_weights.len()).map(slope).collect(),
            hidden_bias: (0..self.hidden).map(bias).collect(),
            output_weights: self.output_weights.iter().map(|v| v * self.output_scale).collect(),
            output_bias: self.output_bias * self.output_scale + self.output_mean,
            skip: Vec::new(),
        })
        .ok()
    }
}

/// A network between standardised inputs and a standardised target, padded to whole vectors.
///
/// The parameter vector is `[W_00 .. W_0h, W_10 .. , b_0 .. b_h, v_0 .. v_h, c]`, input by input.
#[derive(Debug, Clone)]
pub(super) struct Net {
    pub(super) inputs: usize,
    pub(super) hidden: usize,
    /// Nodes rounded up to whole vectors; the additional ones are zero.
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
