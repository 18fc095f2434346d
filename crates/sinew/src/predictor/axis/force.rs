//! The force that moves an axis, from its motion.

use super::super::conditioner::MAX_MAGNITUDE;
use super::super::model_file_error::{ModelFileError, require};
use super::differentiator::Differentiator;
use super::output::AxisOutput;
use crate::transmission::saturate;
use alloc::format;
use alloc::vec::Vec;
use serde::{Deserialize, Serialize};

/// Inverse dynamics of an axis.
///
/// ```text
/// y = m x'' + d x' + k x + sum_j f_j s_j/r_j + sum_i g_i F_i + c
/// s_j <- clamp(s_j + dx, -r_j, r_j)
/// ```
///
/// | symbol     | field                          | meaning                                                | unit              |
/// |------------|--------------------------------|--------------------------------------------------------|-------------------|
/// | x          | `position`                     | position; `x'` and `x''` by a [`Differentiator`]        | \[x\]               |
/// | x'         | `velocity`                     | in place of the derivative, where it is measured         | \[x\]/s, any factor |
/// | m, d, k    | `mass`, `damping`, `stiffness` | inertia, viscous friction, spring                        | \[y\] per s^2/\[x\], s/\[x\], 1/\[x\] |
/// | f, r       | `slips`                        | Maxwell slip: dry friction after presliding over `r`      | \[y\], \[x\]          |
/// | g, F       | `gains`                        | forces of the near side that pass through the axis        | \[y\]/\[F\], \[F\]      |
/// | c          | `offset`                       | constant force                                           | \[y\]               |
///
/// Without a position `dx = x' dt`, and there is no spring. The constants are those of the motion itself,
/// whatever the lag of the differentiator.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AxisForce {
    /// Signal of the position.
    pub position: Option<usize>,
    /// Signal of the velocity, where it is measured.
    pub velocity: Option<usize>,
    /// Velocity of the axis per unit of that signal; 1 without a position.
    pub velocity_gain: f64,
    /// `tau` of the differentiator, s.
    pub tau_s: f64,
    /// `m`.
    pub mass: f64,
    /// `d`.
    pub damping: f64,
    /// `k`.
    pub stiffness: f64,
    /// Elements of dry friction, at most [`AxisForce::MAX_SLIPS`].
    pub slips: Vec<AxisSlip>,
    /// Signals of near forces with their factors.
    pub gains: Vec<(usize, f64)>,
    /// `c`.
    pub offset: f64,
}

/// An element of dry friction.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AxisSlip {
    /// `r`, half the travel over which its force reverses.
    pub distance: f64,
    /// `f`, its force while it slips forwards.
    pub force: f64,
}

impl AxisForce {
    /// Most elements of dry friction.
    pub const MAX_SLIPS: usize = 4;

    /// The same axis for another unit and zero of the far side.
    pub(super) fn rescaled(&self, gain: f64, offset: f64) -> Self {
        let slip = |slip: &AxisSlip| AxisSlip { force: gain * slip.force, ..*slip };
        Self {
            mass: gain * self.mass,
            damping: gain * self.damping,
            stiffness: gain * self.stiffness,
            slips: self.slips.iter().map(slip).collect(),
            gains: self.gains.iter().map(|(signal, factor)| (*signal, gain * factor)).collect(),
            offset: gain * self.offset + offset,
            ..self.clone()
        }
    }

    pub(super) fn validate(&self, signals: usize) -> Result<(), ModelFileError> {
        let moves = self.position.is_some() || self.velocity.is_some();
        require("law.axis.force", "a position or a velocity", moves, "neither")?;
        let gains = self.gains.iter().map(|(signal, _)| *signal);
        for signal in self.position.into_iter().chain(self.velocity).chain(gains) {
            require("law.axis.force", &format!("signal below {signals}"), signal < signals, signal)?;
        }
        let tau = (1e-6..=MAX_MAGNITUDE).contains(&self.tau_s);
        require("law.axis.force.tau_s", "in 1e-6..1e30", tau, self.tau_s)?;
        let constants = [self.mass, self.damping, self.stiffness, self.offset, self.velocity_gain];
        let factors = self.gains.iter().map(|(_, factor)| *factor);
        for value in constants.into_iter().chain(factors).chain(self.slips.iter().map(|slip| slip.force)) {
            require("law.axis.force", "numbers within +-1e30", value.abs() <= MAX_MAGNITUDE, value)?;
        }
        let count = self.slips.len();
        require("law.axis.force.slips", "at most 4", count <= Self::MAX_SLIPS, count)?;
        for slip in &self.slips {
            let inside = (1.0 / MAX_MAGNITUDE..=MAX_MAGNITUDE).contains(&slip.distance);
            require("law.axis.force.slips.distance", "in 1e-30..1e30", inside, slip.distance)?;
        }
        Ok(())
    }

    /// Position, where there is one, and measured velocity, where there is one.
    #[inline]
    fn motion(&self, signals: &[f64]) -> (Option<f64>, Option<f64>) {
        let at = |signal: Option<usize>| signal.map(|i| signals[i]);
        (at(self.position), at(self.velocity).map(|v| v * self.velocity_gain))
    }

    #[inline]
    fn force(&self, [position, velocity, acceleration]: [f64; 3], slips: &[f64], signals: &[f64]) -> f64 {
        let spring = if self.position.is_some() { self.stiffness * position } else { 0.0 };
        let dry: f64 = self.slips.iter().zip(slips).map(|(slip, s)| slip.force * s / slip.distance).sum();
        let passed: f64 = self.gains.iter().map(|(i, factor)| factor * signals[*i]).sum();
        self.mass * acceleration + self.damping * velocity + spring + dry + passed + self.offset
    }
}

/// The state of an [`AxisForce`].
#[derive(Debug, Clone, Default)]
pub(super) struct ForceState {
    /// Of the position, or one derivative higher of the velocity where that is measured.
    derivative: Differentiator,
    position: f64,
    slips: [f64; AxisForce::MAX_SLIPS],
    known: bool,
}

impl ForceState {
    pub(super) fn start(&mut self, law: &AxisForce, signals: &[f64]) -> AxisOutput {
        let (position, velocity) = law.motion(signals);
        *self = Self {
            derivative: Differentiator::at(velocity.or(position).unwrap_or(0.0)),
            position: position.unwrap_or(0.0),
            ..Self::default()
        };
        self.output(law, signals, velocity)
    }

    #[inline]
    pub(super) fn step(&mut self, law: &AxisForce, dt_s: f64, signals: &[f64]) -> AxisOutput {
        let (position, velocity) = law.motion(signals);
        self.derivative.step(velocity.or(position).unwrap_or(0.0), law.tau_s, dt_s);
        let travel = match (position, velocity) {
            (Some(position), _) => position - self.position,
            (None, velocity) => velocity.unwrap_or(0.0) * dt_s,
        };
        self.position = position.unwrap_or(0.0);
        let mut all_slip = true;
        for (s, slip) in self.slips.iter_mut().zip(&law.slips) {
            *s = saturate(*s + travel, -slip.distance, slip.distance);
            all_slip &= s.abs() >= slip.distance;
        }
        self.known |= all_slip;
        self.output(law, signals, velocity)
    }

    #[inline]
    fn output(&self, law: &AxisForce, signals: &[f64], velocity: Option<f64>) -> AxisOutput {
        let Differentiator { value, rate, second_rate, .. } = self.derivative;
        // The rate of a measured velocity is the acceleration.
        let motion = velocity.map_or([value, rate, second_rate], |velocity| [self.position, velocity, rate]);
        let dry: f64 = law.slips.iter().map(|slip| slip.force.abs()).sum();
        AxisOutput { value: law.force(motion, &self.slips, signals), half_width: dry, known: self.known }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec;

    /// A change and the field that is then refused.
    type Case = (fn(&mut AxisForce), &'static str);

    fn axis() -> AxisForce {
        AxisForce {
            position: Some(0),
            velocity: None,
            velocity_gain: 1.0,
            tau_s: 0.004,
            mass: 90.0,
            damping: 200.0,
            stiffness: 0.0,
            slips: vec![AxisSlip { distance: 1e-4, force: 20.0 }],
            gains: vec![],
            offset: -3.0,
        }
    }

    /// Largest error of the force on a sine of 0.1 m, over that of the exact law.
    fn worst(law: &AxisForce) -> f64 {
        let mut state = ForceState::default();
        let mut worst = 0.0_f64;
        for k in 0..6000 {
            let (t, w) = (f64::from(k) * 1e-3, 2.0);
            let (x, v, a) = (0.1 * (w * t).sin(), 0.1 * w * (w * t).cos(), -0.1 * w * w * (w * t).sin());
            let output = if k == 0 { state.start(law, &[x, v]) } else { state.step(law, 1e-3, &[x, v]) };
            let exact = 90.0 * a + 200.0 * v + 20.0 * v.signum() - 3.0;
            if output.known && k > 100 && v.abs() > 0.03 {
                worst = worst.max((output.value - exact).abs());
            }
        }
        worst
    }

    #[test]
    fn the_force_of_a_sine_is_that_of_the_law_from_position_velocity_or_both() {
        // A sine is no parabola: its jerk of 0.8 m/s^3 lags by three time constants.
        assert!(worst(&axis()) < 1.2 * 90.0 * 0.8 * 3.0 * 0.004, "{}", worst(&axis()));
        let both = AxisForce { velocity: Some(1), ..axis() };
        assert!(worst(&both) < 0.1, "{}", worst(&both));
        let velocity = AxisForce { position: None, velocity: Some(1), ..axis() };
        assert!(worst(&velocity) < 0.1, "{}", worst(&velocity));
    }

    #[test]
    fn a_far_side_in_another_unit_has_another_axis() {
        let (signals, mut one, mut other) = ([0.01, 0.0], ForceState::default(), ForceState::default());
        let (law, scaled) = (axis(), axis().rescaled(2.0, 5.0));
        let mut pair = (one.start(&law, &signals).value, other.start(&scaled, &signals).value);
        for k in 1..50 {
            assert!((2.0 * pair.0 + 5.0 - pair.1).abs() < 1e-9, "{pair:?}");
            let signals = [0.01 * f64::from(k), 0.0];
            pair = (one.step(&law, 0.01, &signals).value, other.step(&scaled, 0.01, &signals).value);
        }
    }

    /// A law with every term.
    fn whole() -> AxisForce {
        AxisForce {
            position: Some(0),
            velocity: Some(1),
            velocity_gain: 2.0,
            tau_s: 0.004,
            mass: 3.0,
            damping: 5.0,
            stiffness: 7.0,
            slips: vec![AxisSlip { distance: 0.01, force: 2.0 }, AxisSlip { distance: 0.04, force: -0.5 }],
            gains: vec![(2, 0.3), (3, -4.0)],
            offset: -1.5,
        }
    }

    #[test]
    fn every_term_of_the_law_adds_to_the_force_from_position_velocity_or_both() {
        // A constant acceleration, which the differentiator follows exactly, and two constant forces of the
        // near side.
        let (x0, v0, a, dt) = (0.2, 0.05, 0.4, 0.01);
        let (near, passed) = ([2.0, 0.7], 0.3 * 2.0 - 4.0 * 0.7);
        for (position, velocity) in [(Some(0), None), (None, Some(1)), (Some(0), Some(1))] {
            let law = AxisForce { position, velocity, ..whole() };
            let mut state = ForceState::default();
            let mut travel = 0.0;
            for k in 0..60 {
                let t = dt * f64::from(k);
                let (x, v) = (x0 + v0 * t + 0.5 * a * t * t, v0 + a * t);
                // The measured velocity in half its unit.
                let signals = [x, 0.5 * v, near[0], near[1]];
                let output =
                    if k == 0 { state.start(&law, &signals) } else { state.step(&law, dt, &signals) };
                travel = match position {
                    Some(_) => x - x0,
                    None if k == 0 => 0.0,
                    None => travel + v * dt,
                };
                let spring = if position.is_some() { 7.0 * x } else { 0.0 };
                let dry = 2.0 * (travel / 0.01).min(1.0) - 0.5 * (travel / 0.04).min(1.0);
                // Where nothing is measured but the position, rates are known from the third sample on.
                let rates = match k {
                    0 if velocity.is_some() => 5.0 * v,
                    0 => 0.0,
                    1 | 2 => continue,
                    _ => 3.0 * a + 5.0 * v,
                };
                let desired = rates + spring + dry + passed - 1.5;
                assert!(
                    (output.value - desired).abs() < 2e-12,
                    "{position:?} {velocity:?} {k}: {output:?} {desired}"
                );
                assert!((output.half_width - 2.5).abs() < 1e-15);
                assert_eq!(output.known, travel >= 0.04, "{k}: {travel}");
            }
            assert!(travel > 0.05);
            // What is known once stays so where the motion turns.
            let back = [x0 + v0 * 0.59 + 0.5 * a * 0.59 * 0.59 - 0.02, -0.4, near[0], near[1]];
            assert!(state.step(&law, dt, &back).known);
        }
    }

    #[test]
    fn another_unit_of_the_far_side_scales_every_term_of_the_law() {
        let (law, scaled) = (whole(), whole().rescaled(-2.0, 5.0));
        let (mut one, mut other) = (ForceState::default(), ForceState::default());
        for k in 0..40 {
            let wave = |rate: f64| libm::sin(rate * f64::from(k));
            let signals = [0.05 * wave(0.3), 0.4 * wave(0.2), wave(0.7), 2.0 * wave(0.9)];
            let [y, scaled_y] = [(&law, &mut one), (&scaled, &mut other)].map(|(law, state)| match k {
                0 => state.start(law, &signals).value,
                _ => state.step(law, 0.01, &signals).value,
            });
            assert!((-2.0 * y + 5.0 - scaled_y).abs() < 1e-12, "{k}: {y} {scaled_y}");
        }
    }

    #[test]
    fn a_law_is_refused_by_the_name_of_what_is_outside_its_domain_and_only_then() {
        let changed = |change: fn(&mut AxisForce)| {
            let mut law = whole();
            change(&mut law);
            law.validate(4).map_err(|error| error.name)
        };
        let many = |count| vec![AxisSlip { distance: 1e-4, force: 1.0 }; count];
        assert_eq!(AxisForce { slips: many(4), ..whole() }.validate(4), Ok(()));
        assert!(AxisForce { slips: many(5), ..whole() }.validate(4).is_err());
        let accepted: [fn(&mut AxisForce); 6] = [
            |law| law.position = None,
            |law| law.velocity = None,
            |law| law.mass = -1e30,
            |law| law.slips[0] = AxisSlip { distance: 1e-30, force: 1e30 },
            |law| law.tau_s = 1e-6,
            |law| law.gains.clear(),
        ];
        for change in accepted {
            assert_eq!(changed(change), Ok(()));
        }
        let (law, tau) = ("law.axis.force", "law.axis.force.tau_s");
        let cases: [Case; 13] = [
            (|law| (law.position, law.velocity) = (None, None), law),
            (|law| law.position = Some(4), law),
            (|law| law.velocity = Some(9), law),
            (|law| law.gains[1].0 = 4, law),
            (|law| law.gains[0].1 = f64::NAN, law),
            (|law| law.mass = 2e30, law),
            (|law| law.damping = f64::INFINITY, law),
            (|law| law.offset = f64::NAN, law),
            (|law| law.slips[1].force = -2e30, law),
            (|law| law.tau_s = 0.0, tau),
            (|law| law.tau_s = f64::NAN, tau),
            (|law| law.slips[1].distance = 0.0, "law.axis.force.slips.distance"),
            (|law| law.slips[0].distance = 2e30, "law.axis.force.slips.distance"),
        ];
        for (change, name) in cases {
            assert_eq!(changed(change), Err(name.into()));
        }
    }
}
