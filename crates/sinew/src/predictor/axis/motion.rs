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
/// A step takes the mean force of its two samples and the mean velocity `u` by the trapezoidal rule, with dry
/// friction as a threshold on it: where `|v + dt/2 (b F - c - k x)| <= dt/2 f` the axis sticks. It is stable
/// for every `dt`.
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

    /// A change and the field that is then refused.
    type Case = (fn(&mut AxisMotion), &'static str);

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

    /// A law with every term but dry friction.
    fn sprung() -> AxisMotion {
        AxisMotion {
            gain: 2.0,
            damping: 1.5,
            stiffness: 9.0,
            friction: 0.0,
            bias: 0.8,
            offset: 0.3,
            ..axis()
        }
    }

    #[test]
    fn a_damped_spring_swings_about_its_equilibrium_as_in_closed_form() {
        let (force, far, dt) = (3.0, 1.1, 1e-3);
        let rest = (2.0 * force - 0.8) / 9.0;
        let (decay, frequency) = (0.75, libm::sqrt(9.0 - 0.75 * 0.75));
        for far_is_velocity in [false, true] {
            let law = AxisMotion { far_is_velocity, ..sprung() };
            let mut state = MotionState::default();
            let mut output = state.start(&law, &[force], Some(far));
            // The far side is measured with its offset; the other begins at rest, or where the spring rests.
            let (x, v) = if far_is_velocity { (0.0, far - 0.3) } else { (far - 0.3 - rest, 0.0) };
            for k in 0..4000 {
                let t = dt * f64::from(k);
                let (sine, cosine) = libm::sincos(frequency * t);
                let fading = libm::exp(-decay * t);
                let lean = (v + decay * x) / frequency;
                let position = fading * (x * cosine + lean * sine);
                let velocity = -decay * position + fading * frequency * (lean * cosine - x * sine);
                let desired = if far_is_velocity { velocity } else { rest + position };
                assert!((output.value - 0.3 - desired).abs() < 2e-6, "{k}: {output:?} {desired}");
                output = state.step(&law, dt, &[force]);
            }
        }
    }

    #[test]
    fn an_axis_that_is_not_measured_starts_at_rest_where_it_stays() {
        let (force, rest) = ([3.0], (2.0 * 3.0 - 0.8) / 9.0 + 0.3);
        let mut state = MotionState::default();
        let law = AxisMotion { far_is_velocity: false, ..sprung() };
        let mut output = state.start(&law, &force, None);
        for _ in 0..100 {
            assert!((output.value - rest).abs() < 1e-14, "{output:?}");
            output = state.step(&law, 0.01, &force);
        }
        // Without a spring at zero, with a spring that is too soft at the largest number.
        let start = |stiffness, bias| {
            MotionState::default().start(&AxisMotion { stiffness, bias, ..law.clone() }, &force, None).value
        };
        assert!((start(0.0, 0.8) - 0.3).abs() < 1e-15 && (start(0.0, 6.0) - 0.3).abs() < 1e-15);
        assert!((start(1e-30, 0.8) - 1e30).abs() < 1e15 && (start(1e-30, 9.0) + 1e30).abs() < 1e15);
    }

    #[test]
    fn a_start_is_forgotten_after_four_decay_times_of_the_velocity_and_eight_with_a_spring() {
        // Numbers without rounding: the velocity decays in half a second, the swing in one.
        for (stiffness, samples) in [(0.0, 8), (9.0, 16)] {
            let law = AxisMotion { damping: 2.0, stiffness, ..sprung() };
            let mut state = MotionState::default();
            assert!(!state.start(&law, &[1.0], Some(4.0)).known);
            for k in 1..=20 {
                assert_eq!(state.step(&law, 0.25, &[1.0]).known, k >= samples, "{stiffness} {k}");
            }
        }
    }

    #[test]
    fn another_unit_of_the_far_side_scales_the_whole_motion() {
        for far_is_velocity in [false, true] {
            for (gain, far) in [(-2.0, None), (3.0, Some(0.4))] {
                let law = AxisMotion { friction: 0.7, far_is_velocity, ..sprung() };
                let scaled = law.rescaled(gain, 5.0);
                let (mut one, mut other) = (MotionState::default(), MotionState::default());
                let mut pair = (
                    one.start(&law, &[1.0], far),
                    other.start(&scaled, &[1.0], far.map(|far: f64| gain * far + 5.0)),
                );
                for k in 0..300 {
                    assert!((gain * pair.0.value + 5.0 - pair.1.value).abs() < 3e-14, "{k}: {pair:?}");
                    let force = [1.0 + 2.0 * libm::sin(0.05 * f64::from(k))];
                    pair = (one.step(&law, 0.02, &force), other.step(&scaled, 0.02, &force));
                }
            }
        }
    }

    #[test]
    fn a_law_is_refused_by_the_name_of_what_is_outside_its_domain_and_only_then() {
        let changed = |change: fn(&mut AxisMotion)| {
            let mut law = AxisMotion { force: 1, ..sprung() };
            change(&mut law);
            law.validate(2).map_err(|error| error.name)
        };
        let accepted: [fn(&mut AxisMotion); 5] = [
            |law| law.damping = 1e-30,
            |law| law.bias = -1e30,
            |law| law.stiffness = 0.0,
            |law| law.force = 0,
            |law| law.force = 1,
        ];
        for change in accepted {
            assert_eq!(changed(change), Ok(()));
        }
        let (law, damping) = ("law.axis.motion", "law.axis.motion.damping");
        let cases: [Case; 8] = [
            (|law| law.force = 2, law),
            (|law| law.gain = 2e30, law),
            (|law| law.offset = f64::NAN, law),
            (|law| law.bias = f64::NEG_INFINITY, law),
            (|law| law.damping = 0.0, damping),
            (|law| law.damping = -1.0, damping),
            (|law| law.stiffness = -1e-9, law),
            (|law| law.friction = -1e-9, law),
        ];
        for (change, name) in cases {
            assert_eq!(changed(change), Err(name.into()));
        }
    }
}
