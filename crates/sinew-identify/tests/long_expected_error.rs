//! The error that an identification expects, against the error on fresh logs, over 30 seeds of three simulated families.
//!
//! Minutes long: it runs only where the environment variable `SINEW_LONG` is set.

#![allow(
    clippy::unwrap_used,
    clippy::print_stderr,
    reason = "a failing test may panic, a skipped one says so"
)]

mod common;

use common::csv;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sinew_identify::evaluate::{evaluate, roles_of};
use sinew_identify::identify::{Options, identify};
use sinew_identify::log::{Dataset, ReadOptions, RequestedRoles, read_bytes, read_bytes_with_roles};

/// Seeds per family.
const SEEDS: u64 = 30;

/// Laws of the simulated far tension.
#[derive(Debug, Clone, Copy)]
enum Family {
    /// Capstan play: a clamp cell.
    Play,
    /// Three plays of different width and a curved characteristic: no clamp cell of the candidates.
    Distributed,
    /// A low-pass with a sine in its characteristic: no friction at all.
    Lag,
}

/// A specimen of a family.
struct Specimen {
    family: Family,
    friction: f64,
    lag_s: f64,
    gain: f64,
}

impl Specimen {
    fn drawn(family: Family, random: &mut ChaCha8Rng) -> Self {
        let mut between = |low: f64, high: f64| low + (high - low) * random.random::<f64>();
        Self { family, friction: between(0.1, 0.35), lag_s: between(0.03, 0.15), gain: between(0.6, 0.9) }
    }

    /// Six seconds of another day: other motion, friction or gain off by up to 3 %, noise.
    fn log(&self, random: &mut ChaCha8Rng) -> String {
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
        let samples: Vec<common::Sample> = near
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

fn read(logs: &[(String, String)]) -> Vec<(&str, &[u8])> {
    logs.iter().map(|(name, text)| (name.as_str(), text.as_bytes())).collect()
}

/// Expected error over the error on four fresh logs.
fn ratio(family: Family, seed: u64) -> f64 {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let specimen = Specimen::drawn(family, &mut random);
    let mut logs = |count: usize| -> Vec<(String, String)> {
        (0..count).map(|k| (format!("{k}.csv"), specimen.log(&mut random))).collect()
    };
    let options = ReadOptions { skip_s: 0.0, far_required: true, paths: Vec::new() };
    let (training, fresh) = (logs(3), logs(4));
    let data: Dataset = read_bytes(&read(&training), &RequestedRoles::default(), &options).unwrap();
    let found = identify(&data, &Options { seed, models: Vec::new() }, &|_, _| {}).unwrap();
    let fresh = read_bytes_with_roles(&read(&fresh), &roles_of(&found.model), &options).unwrap();
    found.report.expected.rmse / evaluate(&found.model, &fresh).unwrap().overall.rmse.unwrap()
}

#[test]
fn the_expected_error_is_within_a_fifth_of_the_fresh_one_in_the_median() {
    if std::env::var_os("SINEW_LONG").is_none() {
        eprintln!("skipped: SINEW_LONG is not set");
        return;
    }
    for family in [Family::Play, Family::Distributed, Family::Lag] {
        let mut ratios: Vec<f64> = (0..SEEDS).map(|seed| ratio(family, seed)).collect();
        ratios.sort_by(f64::total_cmp);
        let at = |share: f64| ratios[(share * (ratios.len() - 1) as f64).round() as usize];
        eprintln!("{family:?}: median {:.2}, 10 % {:.2}, 90 % {:.2}", at(0.5), at(0.1), at(0.9));
        assert!((at(0.5) - 1.0).abs() <= 0.2, "{family:?}: {}", at(0.5));
    }
}
