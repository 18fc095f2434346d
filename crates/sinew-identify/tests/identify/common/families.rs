//! Specimens of three simulated families of transmissions, and their logs on different days.

use super::csv;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// Laws of the simulated far tension.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Family {
    /// Capstan play: a clamp cell.
    Play,
    /// Three plays of different width and a curved characteristic: no clamp cell of the candidates.
    Distributed,
    /// A low-pass with a sine in its characteristic: no friction at all.
    Lag,
}

impl Family {
    pub(crate) const ALL: [Self; 3] = [Self::Play, Self::Distributed, Self::Lag];
}

/// A specimen of a family.
#[derive(Debug, Clone)]
pub(crate) struct Specimen {
    pub(crate) family: Family,
    pub(crate) friction: f64,
    pub(crate) lag_s: f64,
    pub(crate) gain: f64,
}

impl Specimen {
    pub(crate) fn sampled(family: Family, random: &mut ChaCha8Rng) -> Self {
        let mut between = |low: f64, high: f64| low + (high - low) * random.random::<f64>();
        Self { family, friction: between(0.1, 0.35), lag_s: between(0.03, 0.15), gain: between(0.6, 0.9) }
    }

    /// Six seconds of another day: other motion, friction or gain off by up to 3 %, noise.
    pub(crate) fn log(&self, random: &mut ChaCha8Rng) -> String {
        let mut between = |low: f64, high: f64| low + (high - low) * random.random::<f64>();
        let day = between(0.97, 1.03);
        let waves: Vec<[f64; 3]> =
            (0..4).map(|_| [between(0.3, 1.0), between(1.2, 7.5), between(0.0, 6.3)]).collect();
        let near: Vec<f64> = (0..600)
            .map(|i| {
                let t = f64::from(i) * 0.01;
                let sum: f64 = waves.iter().map(|[a, w, p]| a * (w * t + p).sin()).sum();
                (6.0 + 1.2 * sum).max(0.5)
            })
            .collect();
        let play = |friction: f64| -> Vec<f64> {
            let mut state = near[0];
            let clamp = |u: &f64| {
                state = state.clamp(u * (-friction).exp(), u * friction.exp());
                state
            };
            near.iter().map(clamp).collect()
        };
        let far = match self.family {
            Family::Play => play(self.friction * day),
            Family::Distributed => {
                let parts = [1.0, 0.6, 0.25].map(|width| play(self.friction * day * width));
                let curved = |i: usize| 0.02 * (near[i] - 6.0) * (near[i] - 6.0) / 6.0;
                (0..near.len()).map(|i| parts.iter().map(|p| p[i]).sum::<f64>() / 3.0 + curved(i)).collect()
            }
            Family::Lag => {
                let mut low_pass = near[0];
                let step = |u: &f64| {
                    low_pass += (u - low_pass) * 0.01 / self.lag_s;
                    day * (self.gain * low_pass + 0.2 * (1.5 * u).sin())
                };
                near.iter().map(step).collect()
            }
        };
        let samples: Vec<super::Sample> = near
            .iter()
            .zip(far)
            .enumerate()
            .map(|(i, (near, far))| {
                [i as f64 * 0.01, near + between(-0.02, 0.02), far + between(-0.04, 0.04)]
            })
            .collect();
        csv(&samples)
    }
}
