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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transmission::PerceptronWeights;
    use alloc::vec;
    use alloc::vec::Vec;

    const H: f64 = 1e-3;

    /// The inputs at every millisecond of two ends with these positions, m.
    fn inputs(
        cycles: u32,
        ends: impl Fn(f64) -> [f64; 2],
    ) -> impl Iterator<Item = [f64; ResidualNetwork::INPUTS]> {
        let mut state = ResidualInputs::default();
        (0..cycles).map(move |k| {
            let [motor, anchor] = ends(H * f64::from(k));
            let sample = CableSample { motor, anchor, tension_in: f64::NAN };
            state.update(
                H,
                &sample,
                &CableEstimate { tension_in: 30.0, tension_out: 20.0, ..Default::default() },
            )
        })
    }

    #[test]
    fn the_inputs_are_two_tensions_and_the_saturated_speeds_of_both_ends_behind_a_low_pass() {
        let speeds = [4e-3, -1e-3];
        for (k, inputs) in inputs(200, |t| speeds.map(|speed| 0.7 + speed * t)).enumerate() {
            let passed = 1.0 - libm::exp(-(k as f64) * H / 0.05);
            assert!((inputs[0] - 30.0).abs() < 1e-12 && (inputs[1] - 20.0).abs() < 1e-12);
            for (input, speed) in inputs[2..].iter().zip(speeds) {
                // Positions are known to 1e-16 m, speeds to 1e-13 m/s of 5 mm/s.
                assert!((input - libm::tanh(passed * speed / 5e-3)).abs() < 4e-13, "{k}: {inputs:?}");
            }
        }
    }

    #[test]
    fn a_jump_of_an_encoder_counts_as_two_metres_per_second_in_its_direction() {
        for side in [-1.0, 1.0] {
            let jumped = |t: f64| [if t > 0.0495 { side } else { 0.0 }, 0.0];
            let after = inputs(151, jumped).last().unwrap();
            // A cycle at 2 m/s, and a hundred cycles of decay.
            let speed = side * 2.0 * (1.0 - libm::exp(-H / 0.05)) * libm::exp(-100.0 * H / 0.05);
            assert!((after[2] - libm::tanh(speed / 5e-3)).abs() < 1e-12 && after[3].abs() < 1e-12);
        }
    }

    #[test]
    fn the_speed_of_an_end_without_a_position_is_kept_and_that_of_the_other_goes_on() {
        let at = |t: f64| [if t > 0.0495 { f64::NAN } else { 3e-3 * t }, 3e-3 * t];
        let all: Vec<_> = inputs(100, at).collect();
        assert!((all[99][2] - all[49][2]).abs() < 1e-15 && all[49][2] > 0.3, "{:?}", all[99]);
        assert!(all[99][3] > all[49][3] + 0.1, "{:?}", all[99]);
    }

    #[test]
    fn an_interval_that_is_not_positive_restarts_the_low_pass_from_standstill() {
        for h in [0.0, -H] {
            let mut state = ResidualInputs::default();
            let mut at = |h: f64, x: f64| {
                let sample = CableSample { motor: x, anchor: x, tension_in: 0.0 };
                state.update(h, &sample, &CableEstimate::default())
            };
            for k in 0..100 {
                at(H, 5e-3 * H * f64::from(k));
            }
            assert!(at(H, 5e-3 * H * 100.0)[2] > 0.6);
            assert!(at(h, 5e-3 * H * 101.0)[2].abs() < 1e-15);
            // From there its position counts.
            let input = at(H, 5e-3 * H * 102.0)[2];
            assert!((input - libm::tanh(1.0 - libm::exp(-H / 0.05))).abs() < 1e-10, "{input}");
        }
    }

    #[test]
    fn a_correction_is_the_networks_up_to_four_newtons() {
        let (sample, estimate) =
            (CableSample::default(), CableEstimate { tension_out: 1.0, ..Default::default() });
        for (weight, expected) in [(2.5, 2.5), (-2.5, -2.5), (9.0, 4.0), (-9.0, -4.0), (0.25, 0.25)] {
            let network = Perceptron::new(PerceptronWeights {
                inputs: ResidualNetwork::INPUTS,
                hidden: 1,
                input_weights: vec![0.0; ResidualNetwork::INPUTS],
                hidden_bias: vec![0.0],
                output_weights: vec![0.0],
                output_bias: 0.0,
                skip: vec![0.0, weight, 0.0, 0.0],
            });
            let correction = ResidualNetwork::new(network.unwrap()).unwrap().step(H, &sample, &estimate);
            assert!((correction.unwrap() - expected).abs() < 1e-12);
        }
    }
}
