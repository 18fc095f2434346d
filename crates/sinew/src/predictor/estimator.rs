//! The physical prediction plus a learned correction, gated by the variance over its networks.

use super::cable::CablePlace;
use super::ensemble::Ensemble;
use super::linear::LinearLaw;
use super::memory::{Memory, MemoryLaw};
use crate::transmission::Perceptron;
use alloc::vec;
use alloc::vec::Vec;
use serde::{Deserialize, Serialize};

/// Ratio of the correction's mean square to the variance over the networks at which the gate is 1/2.
pub const GATE_STRENGTH: f64 = 8.0;

/// Distance from the training data, in standard deviations of the feature that is farthest, beyond which a
/// member counts no more that is right [inside](Member::inside) alone.
pub const FADE: f64 = 0.5;

/// Estimate of the far end from near-side samples: clamp cell or regression, gated networks, and other
/// estimators whose mean or sum it is.
///
/// ```text
/// y = z + a . x + g c + W sum_k v_k y_k / sum_k v_k
/// g = P / (P + 8 V),   v_k = w_k f,   W = sum_k w_k
/// sigma^2 = sigma_0^2 + V + w^2 / 12 + sum_k v_k ((y_k - m)^2 + s_k) / sum_k v_k
/// ```
///
/// | symbol  | field        | unit  | meaning                                             |
/// |---------|--------------|-------|-----------------------------------------------------|
/// | z, w    | `law.cell`   | far   | state of the cell, width of the band where it is unknown (0 without a cell) |
/// | a . x   | `linear`     | far   | regression on the features (0 without one)          |
/// | c, V    | `ensemble`   | far   | median of the networks and their variance           |
/// | P       | `gate_power` | far^2 | mean square of c in training; without it g = 1      |
/// | sigma_0 | `sigma0`     | far   | root mean square error in training                  |
/// | y_k, w_k | `members`   | far, 1 | other estimators and their weights                 |
/// | f       |              | 1     | 1; for a member that is right inside alone, 1 - d / 0.5, at least 0 |
/// | d       |              | 1     | largest distance of a network's input from its training data since the sequence began, in its standard deviations, over the members that count everywhere |
/// | m, s_k  |              | far, far^2 | mean of the members; their `sigma^2 - sigma_0^2` |
///
/// `w` is that of the branches that have not slid yet, `w^2 / 12` the variance of a state uniformly
/// distributed over it. With a cable observer in place of the cell, `z` is its far tension and `w` zero.
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
    /// Linear regression on the features.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub linear: Option<LinearLaw>,
    /// Other estimators whose weighted sum is added.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub members: Vec<Member>,
}

/// An estimator within another.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Member {
    /// Its weight, above 0.
    pub weight: f64,
    /// Whether it counts inside the range of the training data alone.
    pub inside: bool,
    /// The estimator.
    pub estimator: Estimator,
}

/// Output of an [`Estimator`] at one sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Estimated far end, far unit.
    pub mean: f64,
    /// Variance of its error before the calibration of the band, far unit squared.
    pub variance: f64,
    /// Gate `g` on the learned correction, 0 to 1; 1 where there is no correction or no gate. Of members, the
    /// weighted mean.
    pub gate: f64,
    /// Whether the state no longer depends on its start (true without physics).
    pub known: bool,
    /// Network inputs outside the box of the training data.
    pub clipped: usize,
    /// Largest distance of one from it since the sequence began, in its standard deviations; of a mean that
    /// of the members that count everywhere.
    pub beyond: f64,
}

impl Estimator {
    /// An estimator of one law that predicts nothing yet.
    #[must_use]
    pub fn of(law: MemoryLaw) -> Self {
        let (ensemble, gate_power, perceptron, linear) = (None, None, None, None);
        Self { law, ensemble, gate_power, perceptron, sigma0: 0.0, linear, members: Vec::new() }
    }

    /// The estimate of an estimator that is nothing but its members, given theirs.
    #[must_use]
    pub fn combined(&self, members: impl Iterator<Item = Estimate> + Clone) -> Estimate {
        let variance = self.sigma0 * self.sigma0;
        self.with_members(Estimate { variance, known: true, ..NOTHING }, members)
    }

    /// The estimate of the own law, without the members.
    #[inline]
    pub(super) fn estimate(&self, memory: &Memory, scratch: &mut [f32]) -> Estimate {
        let cell = memory.cell();
        let known = !self.law.has_physics() || cell.known;
        let physics = self.sigma0 * self.sigma0 + cell.unknown * cell.unknown / 12.0;
        let mut mean = cell.state;
        if let Some(linear) = &self.linear {
            mean += linear.value(memory.features());
        }
        let Some(ensemble) = &self.ensemble else {
            if let Some(Ok(plain)) = self.perceptron.as_ref().map(|p| p.evaluate(memory.features())) {
                mean += plain;
            }
            return Estimate { mean, variance: physics, gate: 1.0, known, clipped: 0, beyond: 0.0 };
        };
        let output = ensemble.evaluate(memory.features(), scratch);
        let gate =
            self.gate_power.map_or(1.0, |p| p / (p + GATE_STRENGTH * output.variance).max(f64::MIN_POSITIVE));
        Estimate {
            mean: mean + gate * output.median,
            variance: physics + output.variance,
            gate,
            known,
            clipped: output.clipped,
            beyond: output.beyond,
        }
    }

    /// Adds the weighted members, given their estimates.
    fn with_members(&self, mut own: Estimate, members: impl Iterator<Item = Estimate> + Clone) -> Estimate {
        let pairs = self.members.iter().zip(members);
        for (member, estimate) in pairs.clone() {
            own.known &= estimate.known;
            own.clipped += estimate.clipped;
            let farther = !member.inside && estimate.beyond > own.beyond;
            own.beyond = if farther { estimate.beyond } else { own.beyond };
        }
        let outside = (1.0 - own.beyond / FADE).max(0.0);
        let weight = |member: &Member| member.weight * if member.inside { outside } else { 1.0 };
        let (mut all, mut sum, mut total, mut gate) = (0.0, 0.0, 0.0, 0.0);
        for (member, estimate) in pairs.clone() {
            let w = weight(member);
            all += member.weight;
            total += w;
            sum += w * estimate.mean;
            gate += w * estimate.gate;
        }
        // Members that are right inside alone are not alone.
        let total = total.max(f64::MIN_POSITIVE);
        let mean = sum / total;
        let mut spread = 0.0;
        for (member, estimate) in pairs {
            let (difference, sigma0) = (estimate.mean - mean, member.estimator.sigma0);
            spread += weight(member) * (difference * difference + estimate.variance - sigma0 * sigma0);
        }
        own.mean += all * mean;
        own.variance += (spread / total).max(0.0);
        own.gate = gate / total;
        own
    }
}

/// The state of an [`Estimator`] and of its members along one sequence; no allocation after construction.
#[derive(Debug, Clone)]
pub struct EstimatorState {
    memory: Memory,
    scratch: Vec<f32>,
    members: Vec<(Self, Estimate)>,
    /// [`Estimate::beyond`] of the own networks.
    beyond: f64,
}

const NOTHING: Estimate =
    Estimate { mean: 0.0, variance: 0.0, gate: 0.0, known: false, clipped: 0, beyond: 0.0 };

impl EstimatorState {
    /// The state before the first sample.
    #[must_use]
    pub fn new(estimator: &Estimator) -> Self {
        Self {
            memory: Memory::new(&estimator.law),
            scratch: vec![0.0; estimator.law.features.len()],
            members: estimator.members.iter().map(|m| (Self::new(&m.estimator), NOTHING)).collect(),
            beyond: 0.0,
        }
    }

    /// Clears the state: the next sample starts a new sequence.
    pub fn reset(&mut self) {
        self.memory.reset();
        self.beyond = 0.0;
        self.members.iter_mut().for_each(|(state, _)| state.reset());
    }

    /// Advances by one sample, `dt_s` after the one before, and estimates the far end there.
    #[inline]
    pub fn step(&mut self, estimator: &Estimator, dt_s: f64, inputs: &[f64]) -> Estimate {
        self.memory.step(&estimator.law, dt_s, inputs);
        self.conclude(estimator, dt_s, inputs)
    }

    /// [`Memory::step_expecting`], and the estimate there.
    pub(super) fn step_expecting(
        &mut self,
        estimator: &Estimator,
        dt_s: f64,
        inputs: &mut [f64],
        tension: usize,
    ) -> Estimate {
        self.memory.step_expecting(&estimator.law, dt_s, inputs, tension);
        self.conclude(estimator, dt_s, inputs)
    }

    /// Where the observed cable is; none without one, and before the first sample.
    pub(super) fn cable_place(&self) -> Option<CablePlace> {
        self.memory.cable_place()
    }

    /// Takes over the state of an estimator of the same kind; nothing is allocated.
    pub(super) fn copy_state(&mut self, from: &Self) {
        self.memory.copy_state(&from.memory);
        self.beyond = from.beyond;
        for ((state, _), (from, _)) in self.members.iter_mut().zip(&from.members) {
            state.copy_state(from);
        }
    }

    #[inline]
    fn conclude(&mut self, estimator: &Estimator, dt_s: f64, inputs: &[f64]) -> Estimate {
        let mut own = estimator.estimate(&self.memory, &mut self.scratch);
        own.beyond = if self.beyond > own.beyond { self.beyond } else { own.beyond };
        self.beyond = own.beyond;
        if self.members.is_empty() {
            return own;
        }
        for ((state, estimate), member) in self.members.iter_mut().zip(&estimator.members) {
            *estimate = state.step(&member.estimator, dt_s, inputs);
        }
        estimator.with_members(own, self.members.iter().map(|(_, estimate)| *estimate))
    }
}
