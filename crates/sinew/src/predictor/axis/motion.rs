//! The motion of an axis, from the force that drives it.

use super::super::conditioner::MAX_MAGNITUDE;
use super::super::model_file_error::{ModelFileError, require};
use super::output::AxisOutput;
use alloc::format;
use serde::{Deserialize, Serialize};

/// Forward dynamics of an axis, per unit of its mass.
///
/// ```text
/// v' = b F - d v - k x - c - f sign(v),   x' = v;   y = v + o  or  y = x + o
/// ```
///
/// | symbol | field                     | meaning                                         | unit                  |
/// |--------|---------------------------|-------------------------------------------------|-----------------------|
/// | F      | `force`                   | the near force                                   | \[F\]                   |
/// | b      | `gain`                    | inverse of the mass                               | \[v\]/s/\[F\]             |
/// | d      | `damping`                 | viscous friction over mass                        | 1/s, > 0              |
/// | k      | `stiffness`               | spring over mass                                  | 1/s^2, >= 0           |
/// | f, c   | `friction`, `bias`        | dry friction and constant force over mass         | \[v\]/s, f >= 0         |
/// | y      | `far_is_velocity`         | the far side: velocity, or position               | \[v\], or \[v\] s         |
/// | o      | `offset`                  | zero of the far side                              | \[y\]                   |
///
/// A step takes the mean force of its two samples and the mean velocity `u` by the trapezoidal rule, with dry friction as
/// a threshold on it: where `|v + dt/2 (b F - c - k x)| <= dt/2 f` the axis sticks. It is stable for every `dt`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AxisMotion {
    /// Signal of the force.
    pub force: usize,
    /// `b`.
    pub gain: f64,
    /// `d`.
    pub damping: f64,
    /// `k`.
    pub stiffness: f64,
    /// `f`.
    pub friction: f64,
    /// `c`.
    pub bias: f64,
    /// `o`.
    pub offset: f64,
    /// Whether the far side is the velocity.
    pub far_is_velocity: bool,
}

impl AxisMotion {
    /// The same axis for another unit and zero of the far side.
    pub(super) fn rescaled(&self, gain: f64, offset: f64) -> Self {
        Self {
            gain: gain * self.gain,
            friction: gain.abs() * self.friction,
            bias: gain * self.bias,
            offset: gain * self.offset + offset,
            ..self.clone()
        }
    }

    pub(super) fn validate(&self, signals: usize) -> Result<(), ModelFileError> {
        require("law.axis.motion", &format!("signal below {signals}"), self.force < signals, self.force)?;
        for value in [self.gain, self.damping, self.stiffness, self.friction, self.bias, self.offset] {
            require("law.axis.motion", "numbers within +-1e30", value.abs() <= MAX_MAGNITUDE, value)?;
        }
        let damped = self.damping >= 1.0 / MAX_MAGNITUDE;
        require("law.axis.motion.damping", "> 0", damped, self.damping)?;
        let least = self.stiffness.min(self.friction);
        require("law.axis.motion", "stiffness and friction >= 0", least >= 0.0, least)
    }
}

/// The state of an [`AxisMotion`].
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct MotionState {
    position: f64,
    velocity: f64,
    force: f64,
    elapsed_s: f64,
}

impl MotionState {
    /// Decay times of the start after which it has no effect any more: `exp(-4) = 2 %`.
    const FORGOTTEN: f64 = 4.0;

    /// At rest, in equilibrium with the spring where there is one; at the far side where that is measured.
    pub(super) fn start(&mut self, law: &AxisMotion, signals: &[f64], far: Option<f64>) -> AxisOutput {
        let force = signals[law.force];
        let rest = if law.stiffness > 0.0 { (law.gain * force - law.bias) / law.stiffness } else { 0.0 };
        let rest = rest.clamp(-MAX_MAGNITUDE, MAX_MAGNITUDE);
        let far = far.map(|far| far - law.offset);
        let (position, velocity) =
            if law.far_is_velocity { (rest, far.unwrap_or(0.0)) } else { (far.unwrap_or(rest), 0.0) };
        *self = Self { position, velocity, force, elapsed_s: 0.0 };
        self.output(law)
    }

    #[inline]
    pub(super) fn step(&mut self, law: &AxisMotion, dt_s: f64, signals: &[f64]) -> AxisOutput {
        let force = signals[law.force];
        let half = 0.5 * dt_s;
        let driven = 0.5 * law.gain * (self.force + force) - law.bias - law.stiffness * self.position;
        let free = self.velocity + half * driven;
        let excess = free.abs() - half * law.friction;
        if excess > 0.0 {
            let mean = libm::copysign(excess, free) / (1.0 + half * (law.damping + half * law.stiffness));
            self.velocity = 2.0 * mean - self.velocity;
            self.position += dt_s * mean;
        } else {
            self.velocity = 0.0;
        }
        self.force = force;
        self.elapsed_s += dt_s;
        self.output(law)
    }

    #[inline]
    fn output(&self, law: &AxisMotion) -> AxisOutput {
        let state = if law.far_is_velocity { self.velocity } else { self.position };
        // With a spring the start decays at half the rate.
        let rate = if law.stiffness > 0.0 { 0.5 * law.damping } else { law.damping };
        AxisOutput {
            value: state + law.offset,
            half_width: 0.0,
            known: self.elapsed_s * rate >= Self::FORGOTTEN,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis() -> AxisMotion {
        AxisMotion {
            force: 0,
            gain: 1.0 / 95.0,
            damping: 2.1,
            stiffness: 0.0,
            friction: 0.2,
            bias: 0.0,
            offset: 0.0,
            far_is_velocity: true,
        }
    }

    #[test]
    fn an_axis_reaches_its_terminal_velocity_and_sticks_below_its_friction() {
        let (law, mut state) = (axis(), MotionState::default());
        state.start(&law, &[60.0], None);
        for _ in 0..5000 {
            state.step(&law, 1e-3, &[60.0]);
        }
        assert!((state.velocity - (60.0 / 95.0 - 0.2) / 2.1).abs() < 1e-4, "{state:?}");
        for _ in 0..5000 {
            state.step(&law, 1e-3, &[10.0]);
        }
        assert!(state.velocity.abs() < f64::MIN_POSITIVE, "{}", state.velocity);
    }

    #[test]
    fn a_spring_oscillates_at_its_frequency_and_any_interval_stays_finite() {
        let law =
            AxisMotion { stiffness: 400.0, damping: 0.02, friction: 0.0, far_is_velocity: false, ..axis() };
        let mut state = MotionState::default();
        state.start(&law, &[0.0], Some(1.0));
        let mut crossings = 0;
        for _ in 0..10_000 {
            let before = state.position;
            crossings += usize::from(before * state.step(&law, 1e-3, &[0.0]).value < 0.0);
        }
        // 20 rad/s: 31.8 periods in ten seconds.
        assert!((62..=65).contains(&crossings), "{crossings}");
        let stiff = AxisMotion { stiffness: 1e30, damping: 1e30, ..law };
        for k in 0..1000 {
            let output = state.step(&stiff, 10.0, &[if k % 2 == 0 { 1e30 } else { -1e30 }]);
            assert!(output.value.is_finite(), "{state:?}");
        }
    }
}
