use crate::Error;
use crate::math::tanh;
use crate::predictor::{CableEstimate, CableSample};
use crate::transmission::Perceptron;

/// What an observer leaves of the tension at an anchor, as a small network has it; added to what the observer believes.
///
/// ```text
/// T_out <- T_out + clamp(y(T_in, T_out, s(v_motor), s(v_anchor)), -4 N, 4 N),   s(v) = tanh(v / v_s)
/// ```
///
/// | symbol                | unit | domain  | meaning                                                            |
/// |-----------------------|------|---------|--------------------------------------------------------------------|
/// | `T_in`, `T_out`       | N    | finite  | tension at the drive's outlet and at the anchor, as the observer believes |
/// | `v_motor`, `v_anchor` | m/s  | finite  | speed of the cable's ends, + toward the motor, over 50 ms            |
/// | `v_s`                 | m/s  | 0.005   | speed beyond which only the direction is told                        |
/// | y                     | N    | finite  | the network, of [`INPUTS`](Self::INPUTS) inputs                          |
///
/// # Assumes
/// The observer's error depends on the state alone. What it does not know of the past is no input.
///
/// # Errors
/// [`Error::WrongLength`] for a network of other inputs; [`Error::OutOfDomain`] for what is not finite.
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
/// let (seen, believed) = (CableSample::default(), CableEstimate::default());
/// assert!((ResidualNetwork::new(network)?.step(1e-3, &seen, &believed)? - 4.0).abs() < 1e-12);
/// # Ok::<(), sinew::Error>(())
/// ```
///
/// # Source
/// None: the residual of a physical observer left to a network, as usual.
#[derive(Debug, Clone)]
pub struct ResidualNetwork {
    network: Perceptron,
    ends: ResidualInputs,
}

impl ResidualNetwork {
    /// Inputs of the network.
    pub const INPUTS: usize = 4;
    /// Largest correction, N: what an observer may err by before it is another cable.
    pub const LIMIT_N: f64 = 4.0;

    /// A network that has seen nothing.
    ///
    /// # Errors
    /// [`Error::WrongLength`] unless it has [`INPUTS`](Self::INPUTS).
    pub fn new(network: Perceptron) -> Result<Self, Error> {
        let (expected, got) = (Self::INPUTS, network.inputs());
        if got == expected {
            Ok(Self { network, ends: ResidualInputs::default() })
        } else {
            Err(Error::WrongLength { name: "residual inputs", expected, got })
        }
    }

    /// What to add to the tension at the anchor, N, `h` s after the sample before; nothing is allocated.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] for what is not finite.
    pub fn step(&mut self, h: f64, seen: &CableSample, believed: &CableEstimate) -> Result<f64, Error> {
        let inputs = self.ends.inputs(h, seen, believed);
        Ok(self.network.evaluate(&inputs)?.clamp(-Self::LIMIT_N, Self::LIMIT_N))
    }
}

/// The ends of a cable, followed to make the inputs of a [`ResidualNetwork`]'s network.
#[derive(Debug, Clone, Copy)]
pub struct ResidualInputs {
    /// Position of either end where it was last seen, m; not a number before.
    last: [f64; 2],
    /// Its speed, m/s.
    speed: [f64; 2],
}

/// Over which speeds are taken, s: below, an encoder's steps are all there is.
const LAG: f64 = 0.05;
/// `v_s`, m/s.
const SPEED: f64 = 5e-3;
/// Speed beyond which an end jumped, m/s.
const FASTEST: f64 = 2.0;

impl Default for ResidualInputs {
    fn default() -> Self {
        Self { last: [f64::NAN; 2], speed: [0.0; 2] }
    }
}

impl ResidualInputs {
    /// The inputs, `h` s after the sample before; `h` not above zero starts afresh, an end that is not seen goes on as before.
    pub fn inputs(
        &mut self,
        h: f64,
        seen: &CableSample,
        believed: &CableEstimate,
    ) -> [f64; ResidualNetwork::INPUTS] {
        let share = if h > 0.0 { 1.0 - libm::exp(-h / LAG) } else { 1.0 };
        for ((now, last), speed) in
            [seen.motor, seen.anchor].into_iter().zip(&mut self.last).zip(&mut self.speed)
        {
            let gone = (now - *last) / h;
            if !now.is_finite() {
                continue;
            }
            let gone = if h > 0.0 && gone.is_finite() { gone.clamp(-FASTEST, FASTEST) } else { 0.0 };
            (*last, *speed) = (now, *speed + share * (gone - *speed));
        }
        let [motor, anchor] = self.speed.map(|v| tanh(v / SPEED));
        [believed.tension_in, believed.tension_out, motor, anchor]
    }
}
