use crate::Error;
use crate::math::tanh;
use crate::predictor::{CableEstimate, CableSample};
use crate::transmission::Perceptron;

/// Correction of an observer's far tension by a network that was trained on its residual.
///
/// ```text
/// T_out <- T_out + clip(y(T_in, T_out, s(v_motor), s(v_anchor)), +-4 N),   s(v) = tanh(v/v_s)
/// ```
///
/// | symbol                | unit | domain | meaning                                                |
/// |-----------------------|------|--------|--------------------------------------------------------|
/// | `T_in`, `T_out`       | N    | finite | estimated tensions at drive's outlet and anchor          |
/// | `v_motor`, `v_anchor` | m/s  | finite | filtered speed of the cable's ends, + toward the motor |
/// | `v_s`                 | m/s  | 0.005  | speed beyond which the input saturates                 |
/// | y                     | N    | finite | the network                                            |
///
/// # Assumes
/// The observer's error is a function of the present state.
///
/// # Errors
/// [`Error::WrongLength`] for a network of other inputs; [`Error::OutOfDomain`] for inputs that are not
/// finite.
///
/// # Example
/// ```
/// use sinew::control::arm::ResidualNetwork;
/// use sinew::predictor::{CableEstimate, CableSample};
/// use sinew::transmission::{Perceptron, PerceptronWeights};
/// let network = Perceptron::new(PerceptronWeights {
///     inputs: ResidualNetwork::INPUTS,
///     hidden: 1,
///     input_weights: vec![0.0; ResidualNetwork::INPUTS],
///     hidden_bias: vec![0.0],
///     output_weights: vec![0.0],
///     output_bias: 1e3,
///     skip: vec![],
/// })?;
/// let (sample, estimate) = (CableSample::default(), CableEstimate::default());
/// assert!((ResidualNetwork::new(network)?.step(1e-3, &sample, &estimate)? - 4.0).abs() < 1e-12);
/// # Ok::<(), sinew::Error>(())
/// ```
///
/// # Source
/// Residual learning on a physical model, as usual; the network is that of `yuan2023` (12), its inputs are
/// our own.
#[derive(Debug, Clone)]
pub struct ResidualNetwork {
    network: Perceptron,
    inputs: ResidualInputs,
}

impl ResidualNetwork {
    /// Inputs of the network.
    pub const INPUTS: usize = 4;
    /// Largest correction, N: a larger residual means that the cable's parameters have changed.
    pub const LIMIT_N: f64 = 4.0;

    /// A correction without history.
    ///
    /// # Errors
    /// [`Error::WrongLength`] unless the network has [`INPUTS`](Self::INPUTS).
    pub fn new(network: Perceptron) -> Result<Self, Error> {
        let (expected, got) = (Self::INPUTS, network.inputs());
        if got == expected {
            Ok(Self { network, inputs: ResidualInputs::default() })
        } else {
            Err(Error::WrongLength { name: "residual inputs", expected, got })
        }
    }

    /// Correction to add to the estimated tension at the anchor, N, `h` s after the sample before; nothing is
    /// allocated.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] for inputs that are not finite.
    pub fn step(&mut self, h: f64, sample: &CableSample, estimate: &CableEstimate) -> Result<f64, Error> {
        let inputs = self.inputs.update(h, sample, estimate);
        Ok(self.network.evaluate(&inputs)?.clamp(-Self::LIMIT_N, Self::LIMIT_N))
    }
}

/// Inputs of a [`ResidualNetwork`]: two tensions, and the speeds of both ends from their positions by a low
/// pass.
#[derive(Debug, Clone, Copy)]
pub struct ResidualInputs {
    /// Last measured position of motor and anchor, m; NaN before the first.
    last: [f64; 2],
    /// Filtered speed of motor and anchor, m/s.
    speed: [f64; 2],
}

/// Time constant of the low pass, s: speeds over shorter times are dominated by the encoders' quantisation.
const FILTER_TIME: f64 = 0.05;
/// `v_s`, m/s.
const SATURATION_SPEED: f64 = 5e-3;
/// Largest speed of an end, m/s: bounds the effect of a jump of its encoder.
const MAX_SPEED: f64 = 2.0;

impl Default for ResidualInputs {
    fn default() -> Self {
        Self { last: [f64::NAN; 2], speed: [0.0; 2] }
    }
}

impl ResidualInputs {
    /// The inputs, `h` s after the sample before; `h <= 0` restarts the low pass, the speed of an end whose
    /// position is not finite is kept.
    pub fn update(
        &mut self,
        h: f64,
        sample: &CableSample,
        estimate: &CableEstimate,
    ) -> [f64; ResidualNetwork::INPUTS] {
        let share = if h > 0.0 { 1.0 - libm::exp(-h / FILTER_TIME) } else { 1.0 };
        let ends = [sample.motor, sample.anchor].into_iter().zip(&mut self.last).zip(&mut self.speed);
        for ((position, last), filtered) in ends {
            if !position.is_finite() {
                continue;
            }
            let speed = (position - *last) / h;
            let speed = if h > 0.0 && speed.is_finite() { speed.clamp(-MAX_SPEED, MAX_SPEED) } else { 0.0 };
            (*last, *filtered) = (position, *filtered + share * (speed - *filtered));
        }
        let [motor, anchor] = self.speed.map(|v| tanh(v / SATURATION_SPEED));
        [estimate.tension_in, estimate.tension_out, motor, anchor]
    }
}
