//! Axes that carry a mass: force from motion, and motion from force, beside a linear regression.

#![allow(
    clippy::unwrap_used,
    clippy::print_stderr,
    reason = "a failing test may panic, a campaign says what it measured"
)]

use crate::common;

use common::axes::AxisRig;
use common::options;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use sinew_identify::evaluate::{evaluate, roles_of};
use sinew_identify::identify::{Options, identify};
use sinew_identify::log::{RequestedRoles, read_bytes, read_bytes_with_roles};

/// What is predicted from what.
fn task(far: &str, near: &[&str]) -> RequestedRoles {
    let of = |effort: bool| -> Vec<String> {
        near.iter().filter(|name| (**name == "force") == effort).map(|name| (*name).to_owned()).collect()
    };
    RequestedRoles {
        far: Some(far.to_owned()),
        effort: of(true),
        motion: of(false),
        time: Some("t_s".to_owned()),
        ..RequestedRoles::default()
    }
}

fn slices<'a>(logs: &'a [(&'static str, Vec<u8>)]) -> Vec<(&'a str, &'a [u8])> {
    logs.iter().map(|(name, text)| (*name, text.as_slice())).collect()
}

/// Error on fresh logs in % of their range and the name of the model, for each list of models.
fn errors(rig: &AxisRig, roles: &RequestedRoles, models: &[&[&str]], seed: u64) -> Vec<(f64, String)> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let logs: Vec<String> = (0..3).map(|_| rig.log(6.0, &mut random)).collect();
    let fresh: Vec<String> = (0..2).map(|_| rig.log(6.0, &mut random)).collect();
    let names = ["0.csv", "1.csv", "2.csv"];
    let bytes = |texts: &'_ [String]| -> Vec<(&'static str, Vec<u8>)> {
        names.into_iter().zip(texts).map(|(name, text)| (name, text.clone().into_bytes())).collect()
    };
    let (logs, fresh) = (bytes(&logs), bytes(&fresh));
    let data = read_bytes(&slices(&logs), roles, &options()).unwrap();
    let one = |models: &&[&str]| {
        let models = models.iter().map(|name| (*name).to_owned()).collect();
        let found = identify(&data, &Options { seed, models, ..Options::default() }, &|_, _| {}).unwrap();
        let fresh = read_bytes_with_roles(&slices(&fresh), &roles_of(&found.model), &options()).unwrap();
        let scores = evaluate(&found.model, &fresh, None).unwrap().overall;
        (scores.percent_of_range.unwrap(), found.model.provenance.member)
    };
    models.iter().map(one).collect()
}

#[test]
fn the_force_of_an_axis_is_predicted_within_two_percent_from_its_position_and_from_position_and_velocity() {
    for near in [&["position"][..], &["position", "velocity"]] {
        let found = errors(&AxisRig::ball_screw(), &task("force", near), &[&["inertia"], &["linear"]], 1);
        eprintln!("{near:?}: {found:?}");
        assert!(found[0].0 < 2.0 && found[0].0 < 0.85 * found[1].0, "{near:?}: {found:?}");
    }
}

#[test]
fn the_velocity_of_an_axis_is_predicted_within_half_a_percent_from_its_force() {
    let found =
        errors(&AxisRig::ball_screw(), &task("velocity", &["force"]), &[&["inertia"], &["linear"]], 1);
    eprintln!("{found:?}");
    assert!(found[0].0 < 0.5 && found[0].0 < 0.1 * found[1].0, "{found:?}");
}

/// Seeds of the campaign.
const SEEDS: u64 = 8;

#[test]
fn long_axes_of_any_mass_friction_and_sampling_rate() {
    if std::env::var_os("SINEW_LONG").is_none() {
        eprintln!("skipped: SINEW_LONG is not set");
        return;
    }
    let tasks = [
        ("force", &["position"][..]),
        ("force", &["position", "velocity"]),
        ("velocity", &["force"]),
        ("position", &["force"]),
    ];
    for (far, near) in tasks {
        let scores: Vec<[f64; 2]> = (0..SEEDS)
            .filter_map(|seed| {
                let rig = AxisRig::sampled(&mut ChaCha8Rng::seed_from_u64(100 + seed));
                // Without a spring the force does not tell the position.
                if far == "position" && rig.stiffness <= 0.0 {
                    return None;
                }
                let found = errors(&rig, &task(far, near), &[&[], &["linear"]], seed);
                eprintln!("{far} from {near:?}, seed {seed}: {found:.2?}");
                Some([found[0].0, found[1].0])
            })
            .collect();
        let median = |k: usize| {
            let mut values: Vec<f64> = scores.iter().map(|s| s[k]).collect();
            values.sort_by(f64::total_cmp);
            values[values.len() / 2]
        };
        eprintln!("{far} from {near:?}: median {:.2} %, linear regression {:.2} %", median(0), median(1));
        assert!(median(0) < median(1), "{far} from {near:?}: {scores:?}");
    }
}
