//! The numbers of one network.

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
    /// Output for one sample, plainly: for tests and for a few samples. NaN if `input` is not `[inputs]`.
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

    /// The network with the scaling moved into its weights, so that it reads and answers in the units of the log;
    /// none where a weight is not finite.
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
