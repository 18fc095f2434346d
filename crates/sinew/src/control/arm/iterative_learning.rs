use crate::Error;
use crate::error::within;
use alloc::vec;
use alloc::vec::Vec;

/// Iterative learning control of a repeated motion: feedback of one repeat becomes feedforward of the next.
///
/// ```text
/// U_(n+1)(t) = U_m(t) + gamma f_m(t),     u_n(t) = U_n(t + t_a),     m = argmin_(k <= n) |f_k|^2
/// ```
///
/// | symbol | meaning                                                                    | unit |
/// |--------|----------------------------------------------------------------------------|------|
/// | u_n    | feedforward in repeat n, `s_k` in the law of the winches; 0 in the first       | 1    |
/// | f_n    | contribution of feedback in repeat n, mean over a bin                        | 1    |
/// | gamma  | at most [`LEARNING_GAIN`]; halved by a repeat with more feedback than the least | 1 |
/// | b      | width of a bin: at least [`MIN_BIN_WIDTH`], at most [`BINS`] of them        | s    |
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
    /// Number of bins, and the duration of one, s.
    bins: usize,
    bin_width: f64,
    /// `gamma` of the next repeat.
    gain: f64,
    /// `U_n` and `f_n`: `[bins x muscles]`.
    present: Repeat,
    /// Those of the repeat with the least feedback.
    best: Repeat,
    /// Repeats with more feedback since then.
    worse: u32,
    /// Sum of `f_n` over the samples of the current bin, `[muscles]`, and their number.
    sum: Vec<f64>,
    samples: f64,
    current_bin: usize,
    /// `u_n` at the present time: `[muscles]`.
    pub(super) output: Vec<f64>,
}

/// One repeat of the motion.
#[derive(Debug, Clone)]
struct Repeat {
    feedforward: Vec<f64>,
    feedback: Vec<f64>,
    /// Sum of the squares of `f_n`.
    power: f64,
}

/// Most bins of a motion: finer details of stick-slip do not repeat.
const BINS: usize = 288;
/// Least `b`, s: faster than the feedback's delay allows, repeats would increase errors instead of reducing
/// them.
const MIN_BIN_WIDTH: f64 = 0.2;
/// `t_a`, s.
const FORWARD_SHIFT: f64 = 0.12;
/// Largest `gamma`, 1, and its factors after a repeat with less feedback and with more.
const LEARNING_GAIN: f64 = 0.4;
const GROWTH: f64 = 1.5;
const REDUCTION: f64 = 0.5;
/// Repeats in a row with more feedback than the least before that one is given up: the machine has changed.
const PATIENCE: u32 = 2;
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
        let bins = (libm::floor(duration / MIN_BIN_WIDTH) as usize).clamp(1, BINS);
        let none = || vec![0.0; bins * muscles];
        let first = Repeat { feedforward: none(), feedback: none(), power: f64::INFINITY };
        Ok(Self {
            muscles,
            bins,
            bin_width: duration / bins as f64,
            gain: LEARNING_GAIN,
            present: first.clone(),
            best: first,
            worse: 0,
            sum: vec![0.0; muscles],
            samples: 0.0,
            current_bin: 0,
            output: vec![0.0; muscles],
        })
    }

    /// Evaluates the feedforward at a time of the repeat, s; a time in an earlier bin begins the next repeat.
    pub(super) fn advance(&mut self, time: f64) {
        let last = (self.bins - 1) as f64;
        let bin = (time / self.bin_width).clamp(0.0, last) as usize;
        if bin != self.current_bin {
            self.complete_bin();
            if bin < self.current_bin {
                self.next_repeat();
            }
            self.current_bin = bin;
        }
        // Linear interpolation between the middles of the bins.
        let place = ((time + FORWARD_SHIFT) / self.bin_width - 0.5).clamp(0.0, last);
        let (first, fraction) = (place as usize, place - libm::floor(place));
        let second = (first + 1).min(self.bins - 1);
        for (k, output) in self.output.iter_mut().enumerate() {
            let [a, b] = [first, second].map(|bin| self.present.feedforward[bin * self.muscles + k]);
            *output = a + fraction * (b - a);
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

    /// `f_n` of the current bin.
    fn complete_bin(&mut self) {
        if self.samples > 0.0 {
            for (k, sum) in self.sum.iter().enumerate() {
                self.present.feedback[self.current_bin * self.muscles + k] = sum / self.samples;
            }
        }
        self.sum.fill(0.0);
        self.samples = 0.0;
    }

    /// `U_(n+1)`.
    fn next_repeat(&mut self) {
        let Self { present, best, gain, worse, .. } = self;
        present.power = present.feedback.iter().map(|feedback| feedback * feedback).sum();
        let better = present.power <= best.power;
        *worse = if better { 0 } else { *worse + 1 };
        *gain = if better { (GROWTH * *gain).min(LEARNING_GAIN) } else { REDUCTION * *gain };
        if better || *worse == PATIENCE {
            *worse = 0;
            best.power = present.power;
            best.feedforward.copy_from_slice(&present.feedforward);
            best.feedback.copy_from_slice(&present.feedback);
        }
        for ((next, of), feedback) in
            present.feedforward.iter_mut().zip(&best.feedforward).zip(&best.feedback)
        {
            *next = of + *gain * feedback;
        }
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

    /// A plant whose answer to the feedforward comes with a delay of other size than the one compensated:
    /// largest feedback of every repeat.
    fn repeated(duration: f64, disturbance: impl Fn(f64) -> f64, gain: f64, delay: usize) -> Vec<f64> {
        let h = 1e-3;
        let mut learning = IterativeLearning::new(1, duration).unwrap();
        let mut past = vec![0.0; delay + 1];
        let steps = (duration / h) as usize;
        let repeats = (0..40).map(|_| {
            let mut largest = 0.0_f64;
            for k in 0..steps {
                let t = k as f64 * h;
                learning.advance(t);
                past.rotate_right(1);
                past[0] = learning.output[0];
                let feedback = disturbance(t) - gain * past[delay];
                learning.record(0, feedback);
                largest = largest.max(feedback.abs());
            }
            largest
        });
        repeats.collect()
    }

    #[test]
    fn feedback_does_not_grow_without_bound_where_learning_diverges() {
        // The answer is four times as strong as assumed, and inverted for fast details.
        for (frequency, gain, delay) in [(1.0, 8.0, 120), (2.0, 1.0, 370), (5.0, 2.0, 220), (0.5, -1.0, 0)] {
            let disturbance = |t: f64| libm::sin(core::f64::consts::TAU * frequency * t);
            let largest = repeated(3.0, disturbance, gain, delay);
            let worst = largest.iter().copied().fold(0.0, f64::max);
            assert!(worst < 6.0, "{frequency} Hz, gain {gain}: {largest:?}");
        }
    }

    #[test]
    fn a_changed_machine_is_learned_again() {
        let mut learning = IterativeLearning::new(1, 4.0).unwrap();
        let mut last = 0.0;
        for repeat in 0..60 {
            let disturbance = if repeat < 20 { 0.1 } else { 1.0 };
            for k in 0..4000 {
                learning.advance(f64::from(k) * 1e-3);
                last = disturbance - learning.output[0];
                learning.record(0, last);
            }
        }
        assert!(last.abs() < 0.2, "{last}");
    }

    #[test]
    fn a_duration_outside_its_domain_is_refused() {
        assert!([0.0, -1.0, f64::NAN, f64::INFINITY].iter().all(|t| IterativeLearning::new(1, *t).is_err()));
    }

    #[test]
    fn the_feedforward_is_the_learned_one_a_shift_ahead_linear_between_the_middles_of_the_bins() {
        // 10 bins of 0.2 s and a learned ramp of the time itself, the second muscle twice as steep.
        let mut learning = IterativeLearning::new(2, 2.0).unwrap();
        for bin in 0..10 {
            let middle = (bin as f64 + 0.5) * 0.2;
            learning.present.feedforward[2 * bin] = middle;
            learning.present.feedforward[2 * bin + 1] = 2.0 * middle;
        }
        for k in 0..200 {
            let time = 0.01 * f64::from(k);
            learning.advance(time);
            // The halves of the first and the last bin hold their middles' values.
            let expected = (time + 0.12).clamp(0.1, 1.9);
            assert!((learning.output[0] - expected).abs() < 1e-12, "{time}: {:?}", learning.output);
            assert!((learning.output[1] - 2.0 * expected).abs() < 1e-12, "{time}: {:?}", learning.output);
        }
    }

    /// The feedforward in every repeat of a motion of 1 s in which the feedback is constant.
    fn learned(feedback: &[f64]) -> Vec<f64> {
        let mut learning = IterativeLearning::new(1, 1.0).unwrap();
        let repeat = |feedback: &f64| {
            for k in 0..100 {
                learning.advance(0.01 * f64::from(k));
                learning.record(0, *feedback);
            }
            learning.output[0]
        };
        feedback.iter().map(repeat).collect()
    }

    #[test]
    fn the_gain_halves_with_more_feedback_and_grows_by_half_with_less_and_the_best_repeat_is_built_on() {
        let found = learned(&[1.0, 1.5, 0.9, 0.8, 0.7, 0.6, 0.0]);
        let second = 0.4 * 1.0;
        // 1.5 is more than 1: from the first repeat with half the gain.
        let third = 0.2 * 1.0;
        let fourth = third + 0.3 * 0.9;
        // The gain is 0.4 again, and not more.
        let fifth = fourth + 0.4 * 0.8;
        let sixth = fifth + 0.4 * 0.7;
        let seventh = sixth + 0.4 * 0.6;
        for (found, expected) in found.iter().zip([0.0, second, third, fourth, fifth, sixth, seventh]) {
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
    }

    #[test]
    fn a_best_repeat_is_given_up_after_two_repeats_in_a_row_with_more_feedback() {
        let found = learned(&[1.0, 2.0, 3.0, 0.5]);
        // After one it is kept; after two the last repeat takes its place, with a quarter of the gain.
        assert!((found[2] - 0.2).abs() < 1e-12, "{found:?}");
        assert!((found[3] - (0.2 + 0.1 * 3.0)).abs() < 1e-12, "{found:?}");
    }

    #[test]
    fn a_bin_without_samples_keeps_the_feedback_of_the_repeat_before() {
        let mut learning = IterativeLearning::new(1, 1.0).unwrap();
        let mut outputs = Vec::new();
        for repeat in 0..3 {
            for k in 0..100 {
                learning.advance(0.01 * f64::from(k));
                if repeat == 0 || k >= 50 {
                    learning.record(0, 0.5);
                }
                if k == 10 {
                    outputs.push(learning.output[0]);
                }
            }
        }
        assert!((outputs[1] - 0.2).abs() < 1e-12 && (outputs[2] - 0.4).abs() < 1e-12, "{outputs:?}");
    }
}
