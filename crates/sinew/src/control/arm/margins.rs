use super::gains::ArmGains;
use crate::drive::VelocityLoop;
use crate::machine::Characteristics;
use alloc::vec::Vec;

/// Stability margins of the loop in which the winches damp the motion of the joints.
///
/// ```text
/// L(s) = w_c/s  1/(1 + t_v s)  1/(1 + s/K)  e^(-s T),      w_c = sum_j B_kj t_d,j
/// ```
///
/// | symbol | meaning                                                       | unit  |
/// |--------|---------------------------------------------------------------|-------|
/// | w_c    | rate at which all muscles together take the speed of anchor `k`  | rad/s |
/// | t_v    | time constant of the winch's travel                             | s     |
/// | K      | gain of the drive's velocity loop                               | 1/s   |
/// | T      | dead time: reading, transport and half a period of hold          | s     |
///
/// # Assumes
/// The whole cable slides, speeds and accelerations are below their limits. A cable that sticks in part is
/// stiffer; its dead band, not this loop, then decides.
///
/// # Source
/// Textbook: margins of an open loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DampingMargins {
    /// `w_c`, rad/s.
    pub crossover: f64,
    /// Phase margin at the crossover of `|L| = 1`, rad.
    pub phase: f64,
    /// Factor by which `w_c` may grow before the loop oscillates, 1.
    pub gain: f64,
    /// Additional delay that makes the loop oscillate, s; infinite without damping.
    pub delay: f64,
}

impl DampingMargins {
    /// Of a loop with this crossover, rad/s, time constant of the winch, s, and dead time, s.
    #[must_use]
    pub fn new(crossover: f64, time_constant: f64, dead_time: f64) -> Self {
        let winch = WinchLag { time_constant, dead_time };
        let magnitude = |w: f64| winch.magnitude(w) / w;
        let quarter = core::f64::consts::FRAC_PI_2;
        let unity = bisect(|w| crossover * magnitude(w) - 1.0);
        let turning = bisect(|w| quarter - winch.lag(w));
        let phase = quarter - winch.lag(unity);
        let delay = if crossover > 0.0 { phase / unity } else { f64::INFINITY };
        Self { crossover, phase, gain: 1.0 / (crossover * magnitude(turning)), delay }
    }

    /// Of every muscle of a machine with this dead time, s: `[muscles]`.
    #[must_use]
    pub fn from_gains(gains: &ArmGains, found: &Characteristics, dead_time: f64) -> Vec<Self> {
        let rows = found.interaction.chunks_exact(gains.muscles.len().max(1)).zip(&gains.muscles);
        rows.map(|(row, muscle)| {
            let rate = row.iter().zip(&gains.muscles).map(|(b, other)| b * other.rate_gain).sum();
            Self::new(rate, muscle.stretch_time_constant, dead_time)
        })
        .collect()
    }
}

/// `W(s) = 1/(1 + t_v s)  1/(1 + s/K)  e^(-s T)`, response of a winch to the travel that is asked of it, as
/// of [`DampingMargins`].
#[derive(Debug, Clone, Copy)]
pub(super) struct WinchLag {
    /// `t_v`, s.
    pub(super) time_constant: f64,
    /// `T`, s.
    pub(super) dead_time: f64,
}

impl WinchLag {
    /// Lag at `w` rad/s, rad.
    pub(super) fn lag(&self, w: f64) -> f64 {
        let poles = libm::atan(w * self.time_constant) + libm::atan(w / VelocityLoop::DRIVE_GAIN);
        poles + w * self.dead_time
    }

    /// Magnitude at `w` rad/s, 1.
    pub(super) fn magnitude(&self, w: f64) -> f64 {
        let (winch, drive) = (w * self.time_constant, w / VelocityLoop::DRIVE_GAIN);
        1.0 / (libm::sqrt(1.0 + winch * winch) * libm::sqrt(1.0 + drive * drive))
    }
}

/// The root of a function that falls from positive to negative, in 1e-6 to 1e6 rad/s.
fn bisect(f: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (1e-6_f64, 1e6_f64);
    for _ in 0..80 {
        let middle = libm::sqrt(low * high);
        if f(middle) > 0.0 { low = middle } else { high = middle }
    }
    libm::sqrt(low * high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::MuscleCharacteristics;

    #[test]
    fn a_slow_loop_has_a_quarter_turn_and_a_loop_at_its_gain_margin_none() {
        let slow = DampingMargins::new(0.01, 5.6e-3, 1.5e-3);
        assert!((slow.phase - core::f64::consts::FRAC_PI_2).abs() < 1e-3 && slow.gain > 1e3);
        let usual = DampingMargins::new(60.0, 5.6e-3, 1.5e-3);
        assert!(usual.phase > 0.5 && usual.gain > 2.0 && usual.delay > 5e-3, "{usual:?}");
        let edge = DampingMargins::new(60.0 * usual.gain, 5.6e-3, 1.5e-3);
        assert!(edge.phase.abs() < 1e-6 && (edge.gain - 1.0).abs() < 1e-6, "{edge:?}");
    }

    #[test]
    fn muscles_that_damp_the_same_motion_add_to_its_crossover() {
        let mut gains = ArmGains::for_tests(2, 1);
        (gains.muscles[0].rate_gain, gains.muscles[1].rate_gain) = (0.1, 0.05);
        gains.muscles[1].stretch_time_constant = 0.01;
        let found = Characteristics {
            muscles: alloc::vec![MuscleCharacteristics::default(); 2],
            joints: Vec::new(),
            arms: Vec::new(),
            interaction: alloc::vec![200.0, 400.0, 100.0, 600.0],
            stuck_mode: 0.0,
            damping_rate: 0.0,
        };
        let margins = DampingMargins::from_gains(&gains, &found, 1.5e-3);
        assert!((margins[0].crossover - 40.0).abs() < 1e-12 && (margins[1].crossover - 40.0).abs() < 1e-12);
        // At the same crossover the slower winch has the smaller margins.
        assert!(margins[1].phase < margins[0].phase - 0.1 && margins[1].gain < margins[0].gain);
    }
}
