use crate::Error;
use crate::error::within;
use alloc::vec;
use alloc::vec::Vec;

/// Iterative learning control of a repeated motion: feedback of one repeat becomes feedforward of the next.
///
/// ```text
/// U_(n+1)(t) = U_n(t) + gamma f_n(t),     u_n(t) = U_n(t + t_a)
/// ```
///
/// | symbol | meaning                                                                    | unit |
/// |--------|----------------------------------------------------------------------------|------|
/// | u_n    | feedforward in repeat n, `s_k` in the law of the winches; 0 in the first       | 1    |
/// | f_n    | contribution of feedback in repeat n, mean over one of [`BINS`]               | 1    |
/// | gamma  | [`LEARNING_GAIN`]                                                          | 1    |
/// | t_a    | [`FORWARD_SHIFT`]: delay of the feedback, compensated                         | s    |
///
/// # Assumes
/// Errors of friction, wrap angles and masses recur at the same phase of every repeat.
///
/// # Source
/// P-type iterative learning control with forward shift; Kawato's feedback-error learning.
#[derive(Debug, Clone)]
pub(super) struct IterativeLearning {
    muscles: usize,
    /// Duration of a bin, s.
    bin_width: f64,
    /// `U_n`, and `U_(n+1)` as far as it is complete: `[bins x muscles]`.
    feedforward: Vec<f64>,
    next: Vec<f64>,
    /// Sum of `f_n` over the samples of the current bin, `[muscles]`, and their number.
    sum: Vec<f64>,
    samples: f64,
    current_bin: usize,
    /// `u_n` at the present time: `[muscles]`.
    pub(super) output: Vec<f64>,
}

/// Bins of a motion: finer details of stick-slip do not repeat.
const BINS: usize = 288;
/// `t_a`, s.
const FORWARD_SHIFT: f64 = 0.12;
/// `gamma`, 1.
const LEARNING_GAIN: f64 = 0.4;
/// Longest motion, s.
const MAX_DURATION: f64 = 3600.0;

impl IterativeLearning {
    /// For a motion of this duration, s.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] outside of (0, 3600].
    pub(super) fn new(muscles: usize, duration: f64) -> Result<Self, Error> {
        let valid = duration > 0.0 && duration <= MAX_DURATION;
        within("duration", "a number in (0, 3600] s", duration, valid)?;
        Ok(Self {
            muscles,
            bin_width: duration / BINS as f64,
            feedforward: vec![0.0; BINS * muscles],
            next: vec![0.0; BINS * muscles],
            sum: vec![0.0; muscles],
            samples: 0.0,
            current_bin: 0,
            output: vec![0.0; muscles],
        })
    }

    /// Evaluates the feedforward at a time of the repeat, s; a time in an earlier bin begins the next repeat.
    pub(super) fn advance(&mut self, time: f64) {
        let last = (BINS - 1) as f64;
        let bin = (time / self.bin_width).clamp(0.0, last) as usize;
        if bin != self.current_bin {
            self.complete_bin();
            if bin < self.current_bin {
                core::mem::swap(&mut self.feedforward, &mut self.next);
                self.next.copy_from_slice(&self.feedforward);
            }
            self.current_bin = bin;
        }
        // Linear interpolation between the middles of the bins.
        let place = ((time + FORWARD_SHIFT) / self.bin_width - 0.5).clamp(0.0, last);
        let (first, share) = (place as usize, place - libm::floor(place));
        let second = (first + 1).min(BINS - 1);
        for (k, output) in self.output.iter_mut().enumerate() {
            let [a, b] = [first, second].map(|bin| self.feedforward[bin * self.muscles + k]);
            *output = a + share * (b - a);
        }
    }

    /// Records the contribution of feedback of one muscle; muscles come in their order, once per control
    /// cycle.
    pub(super) fn record(&mut self, muscle: usize, feedback: f64) {
        self.sum[muscle] += feedback;
        if muscle + 1 == self.muscles {
            self.samples += 1.0;
        }
    }

    /// `U_(n+1)` of the current bin.
    fn complete_bin(&mut self) {
        if self.samples > 0.0 {
            for (k, sum) in self.sum.iter().enumerate() {
                let place = self.current_bin * self.muscles + k;
                self.next[place] = self.feedforward[place] + LEARNING_GAIN * sum / self.samples;
            }
        }
        self.sum.fill(0.0);
        self.samples = 0.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_recurring_disturbance_is_compensated_by_feedforward_after_some_repeats() {
        let (duration, h) = (10.0, 1e-3);
        let disturbance = |t: f64| libm::sin(core::f64::consts::TAU * t / duration);
        let mut learning = IterativeLearning::new(2, duration).unwrap();
        let mut largest = [0.0_f64; 8];
        for largest in &mut largest {
            for k in 0..10_000 {
                let t = f64::from(k) * h;
                learning.advance(t);
                // Feedback compensates the rest of the disturbance with a delay.
                let feedback = disturbance(t - FORWARD_SHIFT) - learning.output[1];
                learning.record(0, 0.0);
                learning.record(1, feedback);
                *largest = largest.max(feedback.abs());
            }
        }
        assert!(learning.output[0].abs() < 1e-12, "no feedback, no feedforward");
        let falls = largest.windows(2).all(|pair| pair[1] < pair[0]);
        assert!(falls && largest[7] < 0.2 * largest[0], "{largest:?}");
    }

    #[test]
    fn a_duration_outside_its_domain_is_refused() {
        assert!([0.0, -1.0, f64::NAN, f64::INFINITY].iter().all(|t| IterativeLearning::new(1, *t).is_err()));
    }
}
