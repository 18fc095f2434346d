//! Conditioning of raw samples: time stamps, missing values and spikes; causal.

use alloc::vec;
use alloc::vec::Vec;
use serde::{Deserialize, Serialize};

/// Plausible range and rate of one input, estimated from the training logs.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InputLimits {
    /// Largest plausible change from one sample to the next, input unit; a larger one is rejected for
    /// [`MAX_HELD_SAMPLES`] samples and accepted if it persists.
    pub jump: f64,
    /// Smallest value in training, input unit.
    pub low: f64,
    /// Largest value in training, input unit.
    pub high: f64,
    /// Replaces a value that is missing at the first sample, input unit.
    pub typical: f64,
}

/// Samples for which a jump is rejected: a spike is at most this long, a step in the signal is longer.
pub const MAX_HELD_SAMPLES: u32 = 2;

/// Largest magnitude of an input or coefficient in any unit. Larger inputs count as missing, larger
/// coefficients are refused, so that products and squares of both stay finite.
pub const MAX_MAGNITUDE: f64 = 1e30;

/// Relation of a sample to the one before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SampleKind {
    /// First of a sequence: at the start, after a gap, or where time runs backwards.
    First,
    /// An ordinary sample.
    Next,
    /// The same time stamp as the sample before.
    Repeated,
}

/// Replaces spikes and missing values by the last accepted value, detects gaps and repeated rows; no
/// allocation.
#[derive(Debug, Clone)]
pub struct Conditioner {
    values: Vec<f64>,
    held: Vec<u32>,
    time_s: f64,
    dt_s: f64,
    started: bool,
    any_held: bool,
}

impl Conditioner {
    /// A conditioner for a number of inputs.
    #[must_use]
    pub fn new(inputs: usize) -> Self {
        Self {
            values: vec![0.0; inputs],
            held: vec![0; inputs],
            time_s: 0.0,
            dt_s: 0.0,
            started: false,
            any_held: false,
        }
    }

    /// Clears the state: the next sample starts a new sequence.
    pub fn reset(&mut self) {
        self.held.fill(0);
        self.time_s = 0.0;
        self.dt_s = 0.0;
        self.started = false;
    }

    /// Takes over the state of a conditioner of as many inputs; nothing is allocated.
    pub(super) fn copy_state(&mut self, from: &Self) {
        self.values.copy_from_slice(&from.values);
        self.held.copy_from_slice(&from.held);
        (self.time_s, self.dt_s) = (from.time_s, from.dt_s);
        (self.started, self.any_held) = (from.started, from.any_held);
    }

    /// Processes one sample. An entry of `inputs` that is absent, NaN or beyond [`MAX_MAGNITUDE`] counts as
    /// missing; a time that is not finite counts as one interval after the last.
    #[inline]
    pub fn update(&mut self, limits: &[InputLimits], gap_s: f64, time_s: f64, inputs: &[f64]) -> SampleKind {
        let dt_s = if time_s.is_finite() { time_s - self.time_s } else { self.dt_s };
        if self.started && dt_s == 0.0 {
            return SampleKind::Repeated;
        }
        let first = !self.started || dt_s < 0.0 || dt_s > gap_s;
        self.any_held = false;
        for (i, limit) in limits.iter().enumerate() {
            let value = inputs.get(i).copied().unwrap_or(f64::NAN);
            let last = self.values[i];
            let spike = !first && (value - last).abs() > limit.jump && self.held[i] < MAX_HELD_SAMPLES;
            if value.abs() <= MAX_MAGNITUDE && !spike {
                self.values[i] = value;
                self.held[i] = 0;
            } else {
                if !self.started {
                    self.values[i] = limit.typical;
                }
                self.held[i] = self.held[i].saturating_add(u32::from(spike));
                self.any_held = true;
            }
        }
        self.dt_s = if first { 0.0 } else { dt_s };
        self.time_s = if time_s.is_finite() { time_s } else { self.time_s + self.dt_s };
        self.started = true;
        if first { SampleKind::First } else { SampleKind::Next }
    }

    /// The conditioned inputs: `[inputs]`.
    #[inline]
    #[must_use]
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Seconds since the sample before; 0 at the first of a sequence.
    #[inline]
    #[must_use]
    pub fn dt_s(&self) -> f64 {
        self.dt_s
    }

    /// Whether any input of the last sample was replaced.
    #[inline]
    #[must_use]
    pub fn any_held(&self) -> bool {
        self.any_held
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: InputLimits = InputLimits { jump: 1.0, low: 0.0, high: 2.0, typical: 0.5 };

    #[test]
    fn a_spike_is_rejected_and_a_step_is_accepted_after_two_samples() {
        let mut conditioner = Conditioner::new(1);
        let mut accepted = Vec::new();
        for (i, value) in [0.0, 9.0, 0.1, 5.0, 5.0, 5.0, 5.1].iter().enumerate() {
            conditioner.update(&[LIMITS], 1.0, i as f64 * 0.01, &[*value]);
            accepted.push(conditioner.values()[0]);
        }
        assert_eq!(accepted, [0.0, 0.0, 0.1, 0.1, 0.1, 5.0, 5.1]);
    }

    #[test]
    fn missing_values_keep_the_last_value_and_start_from_the_typical_one() {
        let mut conditioner = Conditioner::new(1);
        conditioner.update(&[LIMITS], 1.0, 0.0, &[f64::NAN]);
        assert_eq!(conditioner.values(), [0.5]);
        conditioner.update(&[LIMITS], 1.0, 0.1, &[0.7]);
        conditioner.update(&[LIMITS], 1.0, 0.2, &[f64::INFINITY]);
        assert_eq!(conditioner.values(), [0.7]);
        assert!(conditioner.any_held());
        conditioner.update(&[LIMITS], 1.0, 0.3, &[]);
        assert_eq!(conditioner.values(), [0.7]);
    }

    #[test]
    fn gaps_and_backward_time_start_a_sequence_and_repeated_rows_change_nothing() {
        let mut conditioner = Conditioner::new(1);
        let mut at = |time_s| conditioner.update(&[LIMITS], 0.5, time_s, &[1.0]);
        assert_eq!(at(0.0), SampleKind::First);
        assert_eq!(at(0.1), SampleKind::Next);
        assert_eq!(at(0.1), SampleKind::Repeated);
        assert_eq!(at(0.7), SampleKind::First);
        assert_eq!(at(0.6), SampleKind::First);
        assert_eq!(at(f64::NAN), SampleKind::Repeated);
    }

    #[test]
    fn a_change_and_an_interval_of_exactly_the_limit_are_accepted() {
        let mut conditioner = Conditioner::new(1);
        let mut at = |time_s, value| {
            let kind = conditioner.update(&[LIMITS], 0.5, time_s, &[value]);
            (kind, conditioner.values()[0], conditioner.any_held())
        };
        assert_eq!(at(1.0, 0.0), (SampleKind::First, 0.0, false));
        assert_eq!(at(1.5, 1.0), (SampleKind::Next, 1.0, false));
        assert_eq!(at(2.0, 2.25), (SampleKind::Next, 1.0, true));
        assert_eq!(at(2.625, 1.5), (SampleKind::First, 1.5, false));
    }

    #[test]
    fn a_missing_time_is_one_interval_after_the_last() {
        let mut conditioner = Conditioner::new(1);
        for (time_s, interval) in
            [(3.0, 0.0), (3.25, 0.25), (f64::NAN, 0.25), (f64::INFINITY, 0.25), (4.0, 0.25), (4.125, 0.125)]
        {
            conditioner.update(&[LIMITS], 0.5, time_s, &[1.0]);
            assert!((conditioner.dt_s() - interval).abs() < 1e-15, "{time_s}: {}", conditioner.dt_s());
        }
    }
}
