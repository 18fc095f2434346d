//! With locked winches nothing does work on a machine: its energy only falls, and where its tensions balance
//! gravity it stands still. Every machine of `models/` and random ones, as designed and as built.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]
#![allow(clippy::print_stdout, reason = "prints the worst figures")]

use crate::common;

use rayon::prelude::*;
use sinew::control::arm::resting_tensions;
use sinew::control::arm::{least_stable_pose, tension_limits};
use sinew::drive::DriveCommand;
use sinew::machine::Machine;
use sinew::random::Random;
use sinew::twin::arm::{ArmSpecimen, ArmTwin, Failure, InjectedFault};
use std::f64::consts::PI;

/// Duration, ms.
const CYCLES: usize = 2000;
/// Joint speed below which a machine stands still, rad/s or m/s. Measured: 1.6e-4.
const STANDS_STILL: f64 = 0.05;
/// Rise above the initial energy over the initial kinetic energy: semi-implicit steps conserve energy in the
/// mean only. Measured: 2.3e-4.
const LARGEST_RISE: f64 = 4e-4;

/// One run.
#[derive(Debug)]
struct Run {
    #[allow(dead_code, reason = "printed")]
    name: String,
    /// Whether tensions within their limits balance gravity; without them a machine falls.
    held: bool,
    /// Initial kinetic energy, J.
    kinetic: f64,
    /// Largest energy above the initial one, and final energy below it, J.
    rise: f64,
    lost: f64,
    /// Largest speed of a joint at the end.
    end_speed: f64,
}

/// Holds the winches of a machine, sampled from a seed, in a random pose; `speed` bounds the initial speeds.
fn hold(name: String, machine: &Machine, seed: u64, speed: f64) -> Run {
    let mut random = Random::new(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15));
    let specimen = ArmSpecimen::draw(machine, seed).unwrap();
    let built = Machine { robot: specimen.robot.clone(), ..machine.clone() };
    let laws = machine.laws(specimen.resolution.cells).unwrap();
    let pose: Vec<f64> =
        machine.ranges().unwrap().iter().map(|[low, high]| low + random.unit() * (high - low)).collect();
    let poses = std::slice::from_ref(&pose);
    let held = least_stable_pose(&built, &laws, poses, 0.0).unwrap().is_some();
    let limits = tension_limits(machine, &laws);
    let pretension = specimen.cables.iter().map(|cable| cable.parameters.pretension);
    let tensions = resting_tensions(&built.robot, &pose, &limits).unwrap();
    let tensions: Vec<f64> = tensions.iter().zip(pretension).map(|(t, least)| t.max(least)).collect();
    let jammed = (0..tensions.len()).map(|k| InjectedFault {
        start: 0.0,
        duration: f64::INFINITY,
        failure: Failure::Winch(k),
    });
    let jammed: Vec<InjectedFault> = jammed.collect();
    let velocity: Vec<f64> = pose.iter().map(|_| speed * (PI * random.unit()).cos()).collect();
    let mut twin = ArmTwin::new(&specimen, &pose, &tensions, seed).unwrap().with_faults(&jammed).unwrap();
    let at_rest = twin.energy().unwrap();
    let mut twin = twin.with_velocities(&velocity).unwrap();
    let start = twin.energy().unwrap();
    let (commands, mut rise, mut now) = (vec![DriveCommand::Velocity(0.0); tensions.len()], 0.0, start);
    for _ in 0..CYCLES {
        twin.step(&commands, 1e-3).unwrap();
        now = twin.energy().unwrap();
        rise = f64::max(rise, now - start);
    }
    let end_speed = twin.truth().v.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
    Run { name, held, kinetic: start - at_rest, rise, lost: start - now, end_speed }
}

/// All machines, each in several poses.
fn runs(speed: f64) -> Vec<Run> {
    let models = common::machines().into_iter().flat_map(|machine| {
        let loaded = machine.loaded().unwrap();
        (0..3).map(move |seed| (loaded.clone(), seed))
    });
    let random = (2000..2040).map(|seed| (common::random_machine::machine(seed, 1.0).unwrap().machine, seed));
    let all: Vec<(Machine, u64)> = models.chain(random).collect();
    let run = |(machine, seed): (Machine, u64)| {
        let name = format!("{} {seed}", machine.robot.parts().name);
        hold(name, &machine, seed, speed)
    };
    all.into_par_iter().map(run).collect()
}

fn worst<'a>(runs: impl Iterator<Item = &'a Run>, figure: fn(&Run) -> f64) -> &'a Run {
    runs.max_by(|a, b| figure(a).total_cmp(&figure(b))).unwrap()
}

#[test]
fn a_machine_whose_tensions_balance_gravity_stands_still() {
    let runs = runs(0.0);
    let held = || runs.iter().filter(|run| run.held);
    println!(
        "{} of {} are held; fastest at the end: {:?}",
        held().count(),
        runs.len(),
        worst(held(), |r| r.end_speed)
    );
    assert!(held().count() * 2 > runs.len());
    for run in &runs {
        // From rest any rise would be energy from nowhere, those that fall included.
        assert!(run.rise <= 1e-9, "{run:?}");
        assert!(!run.held || run.end_speed < STANDS_STILL, "{run:?}");
        assert!(run.lost > 0.0, "{run:?}");
    }
}

#[test]
fn a_push_adds_no_energy_but_its_own() {
    let runs = runs(0.5);
    println!("largest rise: {:?}", worst(runs.iter(), |run| run.rise / run.kinetic));
    for run in &runs {
        assert!(run.kinetic > 0.0, "{run:?}");
        assert!(run.rise <= LARGEST_RISE * run.kinetic, "{run:?}");
        // Friction takes the push, at least.
        assert!(run.lost > 0.5 * run.kinetic, "{run:?}");
    }
}
