//! The physical prediction plus a learned correction, gated by the variance over its networks.

use super::ensemble::Ensemble;
use super::memory::{Memory, MemoryLaw};
use crate::transmission::Perceptron;
use serde::{Deserialize, Serialize};

/// Ratio of the correction's mean square to the variance over the networks at which the gate is 1/2.
pub const GATE_STRENGTH: f64 = 8.0;

/// Estimate of the far end from the state of a [`Memory`]: clamp cell plus gated networks.
///
/// ```text
/// y = z + g c,   g = P / (P + 8 V),   sigma^2 = sigma_0^2 + V + (w^2 / 12 while the state is unknown)
/// ```
///
/// | symbol  | field        | unit  | meaning                                             |
/// |---------|--------------|-------|-----------------------------------------------------|
/// | z, w    | `law.cell`   | far   | state and band width of the cell (0 without a cell) |
/// | c, V    | `ensemble`   | far   | median of the networks and their variance           |
/// | P       | `gate_power` | far^2 | mean square of c in training; without it g = 1      |
/// | sigma_0 | `sigma0`     | far   | root mean square error in training                  |
///
/// `w^2 / 12` is the variance of a state uniformly distributed over its band. With a cable observer in place
/// of the cell, `z` is its far tension and `w` zero.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Estimator {
    /// Signals, cell and features.
    pub law: MemoryLaw,
    /// The learned correction, or the whole model where there is no cell.
    pub ensemble: Option<Ensemble>,
    /// Mean square of the correction in training.
    pub gate_power: Option<f64>,
    /// One plain network in place of the ensemble, as in `yuan2023`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub perceptron: Option<Perceptron>,
    /// Root mean square error in training.
    pub sigma0: f64,
}

/// Output of an [`Estimator`] at one sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Estimated far end, far unit.
    pub mean: f64,
    /// Variance of its error before the calibration of the band, far unit squared.
    pub variance: f64,
    /// Gate `g` on the learned correction, 0 to 1; 1 where there is no correction or no gate.
    pub gate: f64,
    /// Whether the state no longer depends on its start (true without physics).
    pub known: bool,
    /// Network inputs outside the box of the training data.
    pub clipped: usize,
}

impl Estimator {
    /// The estimate after the last step of `memory`; `scratch: [law.features]`.
    #[inline]
    #[must_use]
    pub fn estimate(&self, memory: &Memory, scratch: &mut [f32]) -> Estimate {
        let cell = memory.cell();
        let known = !self.law.has_physics() || cell.known;
        let width = cell.high - cell.low;
        let start = if known { 0.0 } else { width * width / 12.0 };
        let physics = self.sigma0 * self.sigma0 + start;
        let Some(ensemble) = &self.ensemble else {
            let plain = self.perceptron.as_ref().and_then(|p| p.evaluate(memory.features()).ok());
            let mean = cell.state + plain.unwrap_or(0.0);
            return Estimate { mean, variance: physics, gate: 1.0, known, clipped: 0 };
        };
        let output = ensemble.evaluate(memory.features(), scratch);
        let gate =
            self.gate_power.map_or(1.0, |p| p / (p + GATE_STRENGTH * output.variance).max(f64::MIN_POSITIVE));
        Estimate {
            mean: cell.state + gate * output.median,
            variance: physics + output.variance,
            gate,
            known,
            clipped: output.clipped,
        }
    }
}
