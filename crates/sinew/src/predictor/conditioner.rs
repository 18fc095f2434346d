//! Raw samples made fit for a model, looking only backwards.

use alloc::vec;
use alloc::vec::Vec;
use serde::{Deserialize, Serialize};

/// What one input may do before it is doubted.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InputLimits {
    /// Largest credible change from one sample to the next, input unit; a larger one is held back for
    /// [`MAX_HELD_SAMPLES`] samples and believed if it stays.
    pub jump: f64,
    /// Smallest value seen in training.
    pub low: f64,
    /// Largest value seen in training.
    pub high: f64,
    /// Stands in for a value that is missing before any was seen.
    pub typical: f64,
}

/// Samples for which a jump is held back: a spike is shorter, a real step is not.
pub const MAX_HELD_SAMPLES: u32 = 2;

/// No quantity of a transmission is larger in any unit. What is, counts as missing, so that products and squares
/// of inputs and coefficients stay finite.
pub const MAX_MAGNITUDE: f64 = 1e30;

/// How a sample follows the one before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SampleKind {
    /// The first of a sequence: at the start, after a gap, where time runs backwards.
    First,
    /// An ordinary sample.
    Next,
    /// The same time stamp again: nothing has happened.
    Repeated,
}

/// Holds spikes and missing values, finds gaps and repeated rows; causal, no allocation.
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

    /// Forgets everything: the next sample starts a new sequence.
    pub fn reset(&mut self) {
        self.held.fill(0);
        self.time_s = 0.0;
        self.dt_s = 0.0;
        self.started = false;
    }

    /// Takes a sample. An entry of `inputs` that is not there, no number or beyond [`MAX_MAGNITUDE`] counts as missing;
    /// a time that is not finite counts as one interval after the last.
    #[inline]
    pub fn update(&mut self, guards: &[InputLimits], gap_s: f64, time_s: f64, inputs: &[f64]) -> SampleKind {
        let dt_s = if time_s.is_finite() { time_s - self.time_s } else { self.dt_s };
        if self.started && dt_s == 0.0 {
            return SampleKind::Repeated;
        }
        let first = !self.started || dt_s < 0.0 || dt_s > gap_s;
        self.any_held = false;
        for (i, guard) in guards.iter().enumerate() {
            let value = inputs.get(i).copied().unwrap_or(f64::NAN);
            let last = self.values[i];
            let spike = !first && (value - last).abs() > guard.jump && self.held[i] < MAX_HELD_SAMPLES;
            if value.abs() <= MAX_MAGNITUDE && !spike {
                self.values[i] = value;
                self.held[i] = 0;
            } else {
                if !self.started {
                    self.values[i] = guard.typical;
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

    /// The inputs as the model sees them: `[inputs]`.
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

    /// Whether any input of the last sample was held back.
    #[inline]
    #[must_use]
    pub fn any_held(&self) -> bool {
        self.any_held
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GUARD: InputLimits = InputLimits { jump: 1.0, low: 0.0, high: 2.0, typical: 0.5 };

    #[test]
    fn a_spike_is_held_and_a_step_is_believed_after_two_samples() {
        let mut conditioner = Conditioner::new(1);
        let mut seen = Vec::new();
        for (i, value) in [0.0, 9.0, 0.1, 5.0, 5.0, 5.0, 5.1].iter().enumerate() {
            conditioner.update(&[GUARD], 1.0, i as f64 * 0.01, &[*value]);
            seen.push(conditioner.values()[0]);
        }
        assert_eq!(seen, [0.0, 0.0, 0.1, 0.1, 0.1, 5.0, 5.1]);
    }

    #[test]
    fn missing_values_hold_the_last_and_start_from_the_typical() {
        let mut conditioner = Conditioner::new(1);
        conditioner.update(&[GUARD], 1.0, 0.0, &[f64::NAN]);
        assert_eq!(conditioner.values(), [0.5]);
        conditioner.update(&[GUARD], 1.0, 0.1, &[0.7]);
        conditioner.update(&[GUARD], 1.0, 0.2, &[f64::INFINITY]);
        assert_eq!(conditioner.values(), [0.7]);
        assert!(conditioner.any_held());
        conditioner.update(&[GUARD], 1.0, 0.3, &[]);
        assert_eq!(conditioner.values(), [0.7]);
    }

    #[test]
    fn gaps_and_backward_time_start_anew_and_repeated_rows_do_nothing() {
        let mut conditioner = Conditioner::new(1);
        let mut at = |time_s| conditioner.update(&[GUARD], 0.5, time_s, &[1.0]);
        assert_eq!(at(0.0), SampleKind::First);
        assert_eq!(at(0.1), SampleKind::Next);
        assert_eq!(at(0.1), SampleKind::Repeated);
        assert_eq!(at(0.7), SampleKind::First);
        assert_eq!(at(0.6), SampleKind::First);
        assert_eq!(at(f64::NAN), SampleKind::Repeated);
    }
}
