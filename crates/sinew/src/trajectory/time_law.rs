use crate::error::{Error, positive, within};

/// Phase of a path and its time derivatives.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PhaseState {
    /// `th`.
    pub phase: f64,
    /// `th'`, 1/s.
    pub rate: f64,
    /// `th''`, 1/s^2.
    pub acceleration: f64,
}

/// Time law from rest to rest, with a constant rate between two ramps or with minimum jerk.
///
/// ```text
/// u(x) = 10 x^3 - 15 x^4 + 6 x^5,   U(x) = x^4 (2.5 - 3 x + x^2),   w = Th/(T - Tr)
/// t < Tr        th = w Tr U(t/Tr),            th' = w u(t/Tr),        th'' =  (w/Tr) u'(t/Tr)
/// between       th = w (t - Tr/2),            th' = w,                th'' = 0
/// t > T - Tr    th = Th - w Tr U((T-t)/Tr),   th' = w u((T-t)/Tr),    th'' = -(w/Tr) u'((T-t)/Tr)
/// minimum jerk  th = Th u(t/T),               th' = (Th/T) u'(t/T),   th'' = (Th/T^2) u''(t/T)
/// ```
///
/// | symbol | argument   | unit | domain    | meaning                   |
/// |--------|------------|------|-----------|---------------------------|
/// | Th     | `length`   | rad  | > 0       | final phase                 |
/// | T      | `duration` | s    | > 0       | total duration              |
/// | Tr     | `ramp`     | s    | (0, T/2]  | duration of each ramp       |
///
/// # Source
/// `flash1985` for minimum jerk; its quintic as the rate profile of the ramps is ours.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimeLaw {
    length: f64,
    duration: f64,
    /// `None` for minimum jerk.
    ramp: Option<f64>,
}

impl TimeLaw {
    /// Ramps of a tenth of the duration each.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] for a length or a duration that is not positive.
    pub fn new(length: f64, duration: f64) -> Result<Self, Error> {
        Self::with_ramp(length, duration, 0.1 * duration)
    }

    /// Ramps of `ramp` seconds.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] for numbers that are not positive, or a ramp of more than half of the duration.
    pub fn with_ramp(length: f64, duration: f64, ramp: f64) -> Result<Self, Error> {
        positive("length of the path", length)?;
        positive("duration", duration)?;
        within(
            "ramp",
            "above 0 and at most half of the duration",
            ramp,
            ramp > 0.0 && 2.0 * ramp <= duration,
        )?;
        Ok(Self { length, duration, ramp: Some(ramp) })
    }

    /// Minimum jerk over the whole duration.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn minimum_jerk(length: f64, duration: f64) -> Result<Self, Error> {
        positive("length of the path", length)?;
        positive("duration", duration)?;
        Ok(Self { length, duration, ramp: None })
    }

    /// `T`, s.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// The phase at a time; at rest before 0 and after the end.
    #[must_use]
    pub fn at(&self, time: f64) -> PhaseState {
        let Self { length, duration, ramp } = *self;
        // NaN counts as a time before the start.
        let t = if time > 0.0 { time.min(duration) } else { 0.0 };
        let Some(ramp) = ramp else {
            let (x, rate) = (t / duration, length / duration);
            return PhaseState {
                phase: length * quintic(x),
                rate: rate * slope(x),
                acceleration: rate / duration * curvature(x),
            };
        };
        let rate = length / (duration - ramp);
        let rise = |x: f64| PhaseState {
            phase: rate * ramp * integral(x),
            rate: rate * quintic(x),
            acceleration: rate / ramp * slope(x),
        };
        if t < ramp {
            rise(t / ramp)
        } else if t > duration - ramp {
            let left = rise((duration - t) / ramp);
            PhaseState { phase: length - left.phase, rate: left.rate, acceleration: -left.acceleration }
        } else {
            PhaseState { phase: rate * (t - 0.5 * ramp), rate, acceleration: 0.0 }
        }
    }
}

/// `u`, from 0 to 1 with neither slope nor curvature at the ends: minimum jerk.
pub(super) fn quintic(x: f64) -> f64 {
    x * x * x * (10.0 - 15.0 * x + 6.0 * x * x)
}

/// `u'`.
pub(super) fn slope(x: f64) -> f64 {
    let y = x * (1.0 - x);
    30.0 * y * y
}

/// `u''`.
pub(super) fn curvature(x: f64) -> f64 {
    60.0 * x * (1.0 - x) * (1.0 - 2.0 * x)
}

/// `U`.
fn integral(x: f64) -> f64 {
    let square = x * x;
    square * square * (2.5 - 3.0 * x + square)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rate_and_acceleration_are_the_derivatives_of_the_phase() {
        let turns = 4.0 * core::f64::consts::PI;
        let h = 1e-4;
        for law in [TimeLaw::new(turns, 11.5), TimeLaw::minimum_jerk(turns, 11.5)].map(Result::unwrap) {
            for k in 1..1149 {
                let t = 0.01 * f64::from(k);
                let [before, now, after] = [t - h, t, t + h].map(|t| law.at(t));
                assert!(((after.phase - before.phase) / (2.0 * h) - now.rate).abs() < 1e-7, "{t}");
                assert!(((after.rate - before.rate) / (2.0 * h) - now.acceleration).abs() < 1e-4, "{t}");
            }
        }
    }

    #[test]
    fn the_phase_is_at_rest_at_both_ends_and_beyond() {
        let close = |a: PhaseState, phase: f64| {
            (a.phase - phase).abs() < 1e-12 && a.rate.abs() < 1e-12 && a.acceleration.abs() < 1e-12
        };
        for law in [TimeLaw::new(2.0, 3.0), TimeLaw::minimum_jerk(2.0, 3.0)].map(Result::unwrap) {
            for (time, phase) in [(0.0, 0.0), (-1.0, 0.0), (f64::NAN, 0.0), (3.0, 2.0), (9.0, 2.0)] {
                assert!(close(law.at(time), phase), "{time}");
            }
        }
        assert!(TimeLaw::new(1.0, 0.0).is_err() && TimeLaw::with_ramp(1.0, 1.0, 0.6).is_err());
        assert!(TimeLaw::minimum_jerk(1.0, f64::NAN).is_err() && TimeLaw::minimum_jerk(0.0, 1.0).is_err());
    }
}
