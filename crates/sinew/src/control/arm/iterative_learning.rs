use crate::Error;
use crate::error::within;
use alloc::vec;
use alloc::vec::Vec;

/// What feedback had to add in one repeat of a motion is there from the start in the next.
///
/// ```text
/// U_(n+1)(t) = U_n(t) + gamma f_n(t),     u_n(t) = U_n(t + t_a)
/// ```
///
/// | symbol | meaning                                                                        | unit |
/// |--------|--------------------------------------------------------------------------------|------|
/// | u_n    | what is known beforehand in repeat n, 0 in the first                              | 1    |
/// | f_n    | what feedback then had to add, mean over one of [`BINS`]                          | 1    |
/// | gamma  | [`SHARE`]                                                                      | 1    |
/// | t_a    | [`AHEAD`]: feedback is late by so much                                          | s    |
///
/// Friction, bends and masses that are believed wrongly are wrong at the same places of every repeat.
///
/// # Source
/// Kawato, feedback-error learning; as an iterative learning control of type P with a forward shift.
#[derive(Debug, Clone)]
pub(super) struct IterativeLearning {
    muscles: usize,
    /// Of a bin, s.
    width: f64,
    /// `u_n` and, as far as it is known, `u_(n+1)`: `[bins x muscles]`.
    known: Vec<f64>,
    next: Vec<f64>,
    /// `f_n` of the present bin: sum, and samples in it. `[muscles]`
    sum: Vec<f64>,
    samples: f64,
    present: usize,
    /// `u_n` now: `[muscles]`.
    pub(super) now: Vec<f64>,
}

/// Bins of a motion: what is finer is not the same twice where cables stick and slip.
const BINS: usize = 288;
/// `t_a`, s.
const AHEAD: f64 = 0.12;
/// `gamma`.
const SHARE: f64 = 0.4;
/// Longest motion that is learned, s.
const LONGEST: f64 = 3600.0;

impl IterativeLearning {
    pub(super) fn new(muscles: usize, duration: f64) -> Result<Self, Error> {
        within("duration", "a number in (0, 3600] s", duration, duration > 0.0 && duration <= LONGEST)?;
        Ok(Self {
            muscles,
            width: duration / BINS as f64,
            known: vec![0.0; BINS * muscles],
            next: vec![0.0; BINS * muscles],
            sum: vec![0.0; muscles],
            samples: 0.0,
            present: 0,
            now: vec![0.0; muscles],
        })
    }

    /// Goes to a time in the repeat, s.
    pub(super) fn go(&mut self, time: f64) {
        let last = (BINS - 1) as f64;
        let bin = (time / self.width).clamp(0.0, last) as usize;
        if bin != self.present {
            self.close();
            if bin < self.present {
                core::mem::swap(&mut self.known, &mut self.next);
                self.next.copy_from_slice(&self.known);
            }
            self.present = bin;
        }
        // Values stand for the middles of their bins.
        let from = ((time + AHEAD) / self.width - 0.5).clamp(0.0, last);
        let (first, share) = (from as usize, from - libm::floor(from));
        let second = (first + 1).min(BINS - 1);
        for (k, now) in self.now.iter_mut().enumerate() {
            let [a, b] = [first, second].map(|bin| self.known[bin * self.muscles + k]);
            *now = a + share * (b - a);
        }
    }

    /// Takes what feedback adds now.
    pub(super) fn take(&mut self, muscle: usize, feedback: f64) {
        self.sum[muscle] += feedback;
        if muscle + 1 == self.muscles {
            self.samples += 1.0;
        }
    }

    /// What feedback added in the present bin is known from now on.
    fn close(&mut self) {
        if self.samples > 0.0 {
            for (k, sum) in self.sum.iter().enumerate() {
                let place = self.present * self.muscles + k;
                self.next[place] = self.known[place] + SHARE * sum / self.samples;
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
    fn what_is_needed_at_every_repeat_is_known_after_some() {
        let (duration, h) = (10.0, 1e-3);
        let needed = |t: f64| libm::sin(core::f64::consts::TAU * t / duration);
        let mut practice = IterativeLearning::new(2, duration).unwrap();
        let mut added = [0.0_f64; 8];
        for added in &mut added {
            for k in 0..10_000 {
                let t = f64::from(k) * h;
                practice.go(t);
                // Feedback finds what is missing, and finds it late.
                let missing = needed(t - AHEAD) - practice.now[1];
                practice.take(0, 0.0);
                practice.take(1, missing);
                *added = added.max(missing.abs());
            }
        }
        assert!(practice.now[0].abs() < 1e-12, "who needs nothing learns nothing");
        assert!(added.windows(2).all(|pair| pair[1] < pair[0]) && added[7] < 0.2 * added[0], "{added:?}");
    }

    #[test]
    fn a_motion_without_an_end_is_refused() {
        assert!([0.0, -1.0, f64::NAN, f64::INFINITY].iter().all(|t| IterativeLearning::new(1, *t).is_err()));
    }
}
