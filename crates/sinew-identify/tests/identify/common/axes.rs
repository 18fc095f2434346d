//! Simulated positioning axes: a mass on dry and viscous friction, with or without a spring, moved by a servo
//! loop.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use std::fmt::Write as _;

/// An axis with its sensors.
#[derive(Debug, Clone)]
pub(crate) struct AxisRig {
    /// Moving mass, kg.
    pub(crate) mass: f64,
    /// N s/m.
    pub(crate) damping: f64,
    /// Coulomb friction, N.
    pub(crate) coulomb: f64,
    /// Static over Coulomb friction.
    pub(crate) stribeck: f64,
    /// Stiffness of the spring, N/m.
    pub(crate) stiffness: f64,
    /// Amplitude and period of a ripple of the drive's force, N and m.
    pub(crate) ripple: [f64; 2],
    /// Sampling rate, Hz.
    pub(crate) sampling: f64,
    /// Step of the encoder, m.
    pub(crate) encoder: f64,
    /// Noise of the force sensor and of the velocity sensor as fractions of their sizes.
    pub(crate) noise: f64,
    /// Units of position and force, per m and per N.
    pub(crate) units: [f64; 2],
}

impl AxisRig {
    /// A ball screw of some 100 kg with an encoder of 1 um at 1 kHz.
    pub(crate) fn ball_screw() -> Self {
        Self {
            mass: 95.0,
            damping: 200.0,
            coulomb: 20.0,
            stribeck: 1.2,
            stiffness: 0.0,
            ripple: [0.4, 0.01],
            sampling: 1000.0,
            encoder: 1e-6,
            noise: 0.002,
            units: [1.0, 1.0],
        }
    }

    /// Another mass, friction, spring, sampling rate, noise and unit.
    pub(crate) fn sampled(random: &mut ChaCha8Rng) -> Self {
        let mut log_between = |low: f64, high: f64| low * (high / low).powf(random.random::<f64>());
        let mass = log_between(0.2, 200.0);
        Self {
            mass,
            damping: mass * log_between(0.5, 8.0),
            coulomb: mass * log_between(0.05, 0.5),
            stribeck: log_between(1.0, 1.4),
            stiffness: if log_between(1.0, 4.0) < 2.0 { mass * log_between(10.0, 100.0) } else { 0.0 },
            ripple: [mass * log_between(0.001, 0.02), log_between(0.005, 0.05)],
            sampling: log_between(200.0, 1000.0),
            encoder: log_between(2e-7, 1e-5),
            noise: log_between(0.001, 0.01),
            units: [[1.0, 1000.0][usize::from(mass < 5.0)], 1.0],
        }
    }

    /// `seconds` of a motion of three sines and two rests: time, force, position, velocity.
    pub(crate) fn log(&self, seconds: f64, random: &mut ChaCha8Rng) -> String {
        const STEPS: usize = 10;
        let mut between = |low: f64, high: f64| low + (high - low) * random.random::<f64>();
        let waves: Vec<[f64; 3]> = [1.0, 0.4, 0.15]
            .into_iter()
            .zip([1.5, 4.0, 9.0])
            .map(|(size, rate)| {
                [0.08 * size * between(0.7, 1.0), rate * between(0.8, 1.2), between(0.0, 6.3)]
            })
            .collect();
        let reference = |t: f64, seconds: f64| -> [f64; 2] {
            // The motion fades to rest twice.
            let phase = (2.0 * t / seconds).fract();
            let open = (8.0 * (0.9 - phase).min(phase)).clamp(0.0, 1.0);
            let sum = |f: fn(&[f64; 3], f64) -> f64| waves.iter().map(|w| f(w, t)).sum::<f64>();
            [
                open * sum(|[a, w, p], t| a * (w * t + p).sin()),
                open * sum(|[a, w, p], t| a * w * (w * t + p).cos()),
            ]
        };
        let (w, dt) = (40.0, 1.0 / self.sampling / STEPS as f64);
        let (mut x, mut v, mut bristle) = (reference(0.0, seconds)[0], 0.0, 0.0_f64);
        let mut text = String::from("t_s,force,position,velocity\n");
        for k in 0..(seconds * self.sampling) as usize {
            let t = k as f64 / self.sampling;
            let [xr, vr] = reference(t, seconds);
            let measured = (x / self.encoder).round() * self.encoder;
            let force = self.mass * (w * w * (xr - measured) + 1.6 * w * (vr - v))
                + self.mass * self.noise * between(-1.0, 1.0);
            let [length, newton] = self.units;
            let seen =
                [force * newton, measured * length, (v + 0.3 * self.noise * between(-1.0, 1.0)) * length];
            writeln!(text, "{t},{},{},{}", seen[0], seen[1], seen[2]).unwrap();
            for _ in 0..STEPS {
                let level = self.coulomb * (1.0 + (self.stribeck - 1.0) * f64::exp(-(v / 0.01) * (v / 0.01)));
                bristle = (bristle + v * dt / 2e-5).clamp(-1.0, 1.0);
                let ripple = self.ripple[0] * (std::f64::consts::TAU * x / self.ripple[1]).sin();
                let spring = self.stiffness * x;
                v += dt * (force - self.damping * v - level * bristle - ripple - spring) / self.mass;
                x += dt * v;
            }
        }
        text
    }
}
