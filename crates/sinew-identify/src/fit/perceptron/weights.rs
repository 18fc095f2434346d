//! The numbers of one network.

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
}
