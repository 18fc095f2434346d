use crate::error::{Error, finite};
use crate::math::tanh;
use alloc::vec::Vec;
use serde::{Deserialize, Serialize};

/// Hidden nodes evaluated together: four SSE2 or two AVX2 registers.
const BLOCK: usize = 8;

/// Feed-forward network: one hidden layer of tanh nodes, linear output, optionally a linear path past them.
///
/// ```text
/// y = b_0 + a . x + sum_k v_k tanh(sum_i W_ki x_i + d_k)
/// ```
///
/// | symbol | field            | shape               | domain | meaning                      |
/// |--------|------------------|---------------------|--------|------------------------------|
/// | x      |                  | `[inputs]`          | finite | inputs, scaled by the caller |
/// | W      | `input_weights`  | `[hidden x inputs]` | finite | row-major, one row per node  |
/// | d      | `hidden_bias`    | `[hidden]`          | finite |                              |
/// | v      | `output_weights` | `[hidden]`          | finite |                              |
/// | b_0    | `output_bias`    |                     | finite |                              |
/// | a      | `skip`           | `[inputs]` or empty | finite | empty in `yuan2023`          |
///
/// The two networks of `yuan2023` have 30 nodes and no `skip`:
///
/// | network         | output   | inputs                                                                         |
/// |-----------------|----------|--------------------------------------------------------------------------------|
/// | friction (17)   | `T_r`, N | `T_s` N, length `l_s` m, cable velocity `v_c` m/s, `q` rad, pulleys `n`        |
/// | elongation (18) | `l_r`, m | `T_s` N, `v_c` m/s, `q` rad, cable length `l_c` m, transmission length `L_1` m |
///
/// `T_s` is the tension at the drive, `q` the joint angle.
///
/// # Assumes
/// No memory: the output depends on the present inputs alone.
///
/// # Departs
/// Printed (12) mixes the sums of its layers; this is the perceptron that its text and figure describe.
///
/// # Errors
/// [`Error::WrongLength`] names the slice, [`Error::OutOfDomain`] what is not finite.
///
/// # Example
/// ```
/// use sinew::transmission::{Perceptron, PerceptronWeights};
/// let network = Perceptron::new(PerceptronWeights {
///     inputs: 2,
///     hidden: 1,
///     input_weights: vec![1e-6, 0.0],
///     hidden_bias: vec![0.0],
///     output_weights: vec![1e6],
///     output_bias: 0.5,
///     skip: vec![],
/// })?;
/// // For small inputs a node is linear.
/// assert!((network.evaluate(&[3.0, 7.0])? - 3.5).abs() < 1e-9);
/// # Ok::<(), sinew::Error>(())
/// ```
///
/// # Source
/// `yuan2023`, eq. 12 corrected, inputs of eqs. 17 and 18.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "PerceptronWeights", into = "PerceptronWeights")]
#[doc(alias = "mlp")]
pub struct Perceptron {
    weights: PerceptronWeights,
    /// Per block of [`BLOCK`] nodes: biases, then one row per input, then output weights; padded with zeros.
    blocks: Vec<[f64; BLOCK]>,
}

/// The numbers of a [`Perceptron`], as written in a model file; shapes in its table.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PerceptronWeights {
    /// Number of inputs, at least 1.
    pub inputs: usize,
    /// Number of hidden nodes, at least 1.
    pub hidden: usize,
    /// `W`, row-major `[hidden x inputs]`.
    pub input_weights: Vec<f64>,
    /// `d`, `[hidden]`.
    pub hidden_bias: Vec<f64>,
    /// `v`, `[hidden]`.
    pub output_weights: Vec<f64>,
    /// `b_0`.
    pub output_bias: f64,
    /// `a`, `[inputs]`, or empty for none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub skip: Vec<f64>,
}

impl TryFrom<PerceptronWeights> for Perceptron {
    type Error = Error;

    fn try_from(written: PerceptronWeights) -> Result<Self, Error> {
        Self::new(written)
    }
}

impl From<Perceptron> for PerceptronWeights {
    fn from(network: Perceptron) -> Self {
        network.weights
    }
}

impl Perceptron {
    /// A network with validated weights.
    ///
    /// # Errors
    /// [`Error::WrongLength`] for a shape that does not fit `inputs` and `hidden`, [`Error::OutOfDomain`]
    /// for a weight that is not finite.
    pub fn new(weights: PerceptronWeights) -> Result<Self, Error> {
        let (inputs, hidden) = (weights.inputs, weights.hidden);
        of_length("inputs", inputs.min(1), 1)?;
        of_length("hidden", hidden.min(1), 1)?;
        // A product that overflows cannot be the length of a slice.
        of_length("input_weights", weights.input_weights.len(), hidden.saturating_mul(inputs))?;
        of_length("hidden_bias", weights.hidden_bias.len(), hidden)?;
        of_length("output_weights", weights.output_weights.len(), hidden)?;
        if !weights.skip.is_empty() {
            of_length("skip", weights.skip.len(), inputs)?;
        }
        for (name, slice) in [
            ("input_weights", &weights.input_weights),
            ("hidden_bias", &weights.hidden_bias),
            ("output_weights", &weights.output_weights),
            ("skip", &weights.skip),
        ] {
            for &weight in slice {
                finite(name, weight)?;
            }
        }
        finite("output_bias", weights.output_bias)?;
        let blocks = pack(&weights);
        Ok(Self { weights, blocks })
    }

    /// Its weights.
    #[must_use]
    pub fn weights(&self) -> &PerceptronWeights {
        &self.weights
    }

    /// Number of inputs.
    #[must_use]
    pub fn inputs(&self) -> usize {
        self.weights.inputs
    }

    /// Number of hidden nodes.
    #[must_use]
    pub fn hidden(&self) -> usize {
        self.weights.hidden
    }

    /// Output for `inputs: [inputs]`; nothing is allocated.
    ///
    /// # Errors
    /// [`Error::WrongLength`] for another number of inputs, [`Error::OutOfDomain`] where an input or the
    /// output is not finite.
    #[inline]
    pub fn evaluate(&self, inputs: &[f64]) -> Result<f64, Error> {
        of_length("inputs", inputs.len(), self.weights.inputs)?;
        for &x in inputs {
            finite("inputs", x)?;
        }
        let mut sums = [0.0; BLOCK];
        for block in self.blocks.chunks_exact(self.weights.inputs + 2) {
            let [mut nodes, ref rows @ .., output] = *block else { continue };
            for (row, &x) in rows.iter().zip(inputs) {
                for (node, weight) in nodes.iter_mut().zip(row) {
                    *node += weight * x;
                }
            }
            for ((sum, node), weight) in sums.iter_mut().zip(nodes).zip(output) {
                *sum += weight * tanh(node);
            }
        }
        let linear: f64 = self.weights.skip.iter().zip(inputs).map(|(a, x)| a * x).sum();
        finite("output", self.weights.output_bias + linear + sums.iter().sum::<f64>())
    }
}

fn pack(weights: &PerceptronWeights) -> Vec<[f64; BLOCK]> {
    let (inputs, hidden) = (weights.inputs, weights.hidden);
    let mut blocks = Vec::with_capacity(hidden.div_ceil(BLOCK) * (inputs + 2));
    let gather = |first: usize, of: &dyn Fn(usize) -> f64| {
        core::array::from_fn(|lane| if first + lane < hidden { of(first + lane) } else { 0.0 })
    };
    for first in (0..hidden).step_by(BLOCK) {
        blocks.push(gather(first, &|node| weights.hidden_bias[node]));
        for input in 0..inputs {
            blocks.push(gather(first, &|node| weights.input_weights[node * inputs + input]));
        }
        blocks.push(gather(first, &|node| weights.output_weights[node]));
    }
    blocks
}

fn of_length(name: &'static str, got: usize, expected: usize) -> Result<(), Error> {
    if got == expected { Ok(()) } else { Err(Error::WrongLength { name, expected, got }) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::vec;

    fn weights(inputs: usize, hidden: usize, skip: bool, seed: f64) -> PerceptronWeights {
        let mut next = seed;
        let mut draw = |n: usize| -> Vec<f64> {
            (0..n)
                .map(|_| {
                    next = libm::fmod(next * 997.0 + 0.123, 1.0);
                    2.0 * next - 1.0
                })
                .collect()
        };
        PerceptronWeights {
            inputs,
            hidden,
            input_weights: draw(inputs * hidden),
            hidden_bias: draw(hidden),
            output_weights: draw(hidden),
            output_bias: 0.25,
            skip: if skip { draw(inputs) } else { vec![] },
        }
    }

    proptest! {
        #[test]
        fn packed_evaluation_equals_the_equation(
            inputs in 1..9_usize, hidden in 1..35_usize, skip: bool, seed in 0.0..1.0_f64,
            x in proptest::collection::vec(-3.0..3.0_f64, 9),
        ) {
            let w = weights(inputs, hidden, skip, seed);
            let network = Perceptron::new(w.clone()).unwrap();
            let mut exact = w.output_bias;
            for k in 0..hidden {
                let sum: f64 = (0..inputs).map(|i| w.input_weights[k * inputs + i] * x[i]).sum();
                exact += w.output_weights[k] * libm::tanh(sum + w.hidden_bias[k]);
            }
            exact += w.skip.iter().zip(&x).map(|(a, x)| a * x).sum::<f64>();
            prop_assert!((network.evaluate(&x[..inputs]).unwrap() - exact).abs() < 1e-12);
        }
    }

    #[test]
    fn a_serialised_network_round_trips_and_an_invalid_one_is_refused() {
        let network = Perceptron::new(weights(3, 30, false, 0.4)).unwrap();
        let text = serde_json::to_string(&network).unwrap();
        assert_eq!(serde_json::from_str::<Perceptron>(&text).unwrap(), network);
        for (from, to) in
            [("\"hidden\":30", "\"hidden\":29"), ("\"inputs\":3", "\"outputs\":3"), ("0.25", "null")]
        {
            assert!(text.contains(from));
            assert!(serde_json::from_str::<Perceptron>(&text.replace(from, to)).is_err(), "{to}");
        }
    }

    #[test]
    fn shapes_and_numbers_out_of_domain_are_refused_by_name() {
        let network = Perceptron::new(weights(3, 4, true, 0.4)).unwrap();
        assert!(network.evaluate(&[1.0, 2.0]).is_err());
        assert!(network.evaluate(&[1.0, 2.0, f64::NAN]).is_err());
        let mut bad = weights(3, 4, true, 0.4);
        bad.skip.pop();
        assert!(matches!(Perceptron::new(bad), Err(Error::WrongLength { name: "skip", .. })));
        let mut bad = weights(3, 4, true, 0.4);
        bad.hidden_bias[0] = f64::INFINITY;
        assert!(Perceptron::new(bad).is_err());
        assert!(Perceptron::new(weights(0, 0, false, 0.4)).is_err());
        let mut bad = weights(3, 4, false, 0.4);
        (bad.inputs, bad.hidden) = (usize::MAX, 4);
        assert!(Perceptron::new(bad).is_err());
    }

    #[test]
    fn a_network_knows_its_size() {
        let network = Perceptron::new(weights(3, 11, true, 0.4)).unwrap();
        assert_eq!((network.inputs(), network.hidden()), (3, 11));
    }
}
