//! Physics plus a correction that is trusted as far as its networks agree.

use super::ensemble::Ensemble;
use super::memory::{Memory, MemoryLaw};
use crate::transmission::Perceptron;
use serde::{Deserialize, Serialize};

/// How much disagreement halves the trust in the correction: the gate falls to 1/2 where the variance over
/// the networks is an eighth of the correction's mean square.
pub const GATE_STRENGTH: f64 = 8.0;

/// From the memory of a sequence to the far end: clamp cell plus gated networks.
///
/// ```text
/// y = s + g c,   g = P / (P + 8 V),   sigma^2 = sigma_0^2 + V + (w^2 / 12 while the state is a guess)
/// ```
///
/// | symbol  | field        | unit  | meaning                                                    |
/// |---------|--------------|-------|------------------------------------------------------------|
/// | s, w    | `law.cell`   | far   | state and band width of the cell (0 without a cell)        |
/// | c, V    | `ensemble`   | far   | median of the networks and their variance                  |
/// | P       | `gate_power` | far^2 | mean square of c in training; without it g = 1             |
/// | sigma_0 | `sigma0`     | far   | root mean square error in training                         |
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Estimator {
    /// Signals, cell and features.
    pub law: MemoryLaw,
    /// The learned correction, or the whole model where there is no cell.
    pub ensemble: Option<Ensemble>,
    /// Mean square of the correction in training.
    pub gate_power: Option<f64>,
    /// One plain network in place of the ensemble: the paper's way, for comparison.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub perceptron: Option<Perceptron>,
    /// Root mean square error in training.
    pub sigma0: f64,
}

/// What an [`Estimator`] says after a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The far end.
    pub mean: f64,
    /// Its variance, before the calibration of the band.
    pub variance: f64,
    /// Trust in the learned correction, 0 to 1; 1 where there is none to distrust.
    pub gate: f64,
    /// Whether the physics knows its state since the last reset (true without physics).
    pub known: bool,
    /// Network inputs outside the box of the training data.
    pub clipped: usize,
}

impl Estimator {
    /// The estimate after the sample that `memory` took last; `scratch: [law.features]`.
    #[inline]
    #[must_use]
    pub fn estimate(&self, memory: &Memory, scratch: &mut [f32]) -> Estimate {
        let cell = memory.cell();
        let known = !self.law.has_physics() || cell.known;
        let width = cell.high - cell.low;
        let guess = if known { 0.0 } else { width * width / 12.0 };
        let physics = self.sigma0 * self.sigma0 + guess;
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
