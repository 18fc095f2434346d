//! Machines that stand elsewhere than where their motion begins.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]
#![allow(clippy::print_stderr, reason = "what was tried is printed")]

use crate::common::machines;
use rayon::prelude::*;
use sinew::control::arm::{ActuationMode, ArmController, CableStateSource, synthesize};
use sinew::control::supervisor::{Limits, Mode, Supervisor};
use sinew::machine::Machine;
use sinew::random::EvenPoints;
use sinew::trajectory::{Approach, MinimumJerk, Trajectory};
use sinew::twin::arm::ArmSpecimen;
use sinew_lab::arm::infeasible_motion;
use sinew_lab::experiment::arm::{TrackRun, TrackSession};
use sinew_lab::experiment::oracle_models;

/// Rests before and after the motion, s.
const RESTS: [f64; 2] = [1.0, 0.5];

/// A pose within a fraction of the ranges about the start.
fn about(machine: &Machine, point: &[f64], fraction: f64) -> Vec<f64> {
    let ranges = machine.ranges().unwrap();
    let places = machine.start.iter().zip(&ranges).zip(point);
    places
        .map(|((start, [low, high]), u)| (start + fraction * (u - 0.5) * (high - low)).clamp(*low, *high))
        .collect()
}

/// Largest error of a joint from the first cycle in which the machine follows on, as a fraction of what its
/// controller takes for a fault, and the same on the motion alone; none where it cannot go there.
fn led(machine: &Machine, standing: &[f64], first: &[f64], seed: u64) -> Option<[f64; 2]> {
    let end: Vec<f64> = first
        .iter()
        .zip(about(machine, &vec![0.6; first.len()], 0.5))
        .map(|(a, b)| 0.8 * a + 0.2 * b)
        .collect();
    let trajectory = Trajectory::PointToPoint(MinimumJerk::new(first, &end, 2.0).unwrap());
    let approach = Approach::new(&machine.robot, &trajectory, standing).unwrap();
    for way in [Some(trajectory.clone()), approach.motion()].into_iter().flatten() {
        if infeasible_motion(machine, &way, 1).unwrap().is_some() {
            return None;
        }
    }
    let design = ArmSpecimen::nominal(machine).unwrap();
    let specimen = ArmSpecimen::sampled_around(&design, machine, seed).unwrap();
    let models = oracle_models(&specimen);
    let (gains, _) = synthesize(machine, &models, &[standing.to_vec(), first.to_vec(), end]).unwrap();
    let allowed: Vec<f64> = gains.joints.iter().map(|joint| joint.tracking_error).collect();
    let limits = gains.tension_limits();
    let mode = ActuationMode::WinchSpeed(CableStateSource::Observer);
    let controller = ArmController::new(&machine.robot, &models, gains, mode).unwrap();
    let run = TrackRun {
        specimen: &specimen,
        robot: &machine.robot,
        site: None,
        tension_limits: &limits,
        standing: Some(standing),
        trajectory: &trajectory,
        repeats: 1,
        before: RESTS[0],
        after: RESTS[1],
        faults: &[],
        seed,
    };
    let limits = Limits::from_machine(machine, controller.gains()).unwrap();
    let supervisor = Supervisor::new(controller, limits).unwrap();
    let mut session = TrackSession::supervised(&run, supervisor).unwrap();
    let (mut largest, mut cycles, mut moved) = ([0.0_f64; 2], 0_u64, 0_u64);
    let mut before: Option<Vec<f64>> = None;
    let mut see = |row: &sinew_lab::experiment::TrackRow<'_>| {
        cycles += 1;
        moved += u64::from(row.repeat.is_some());
        if row.mode != Mode::Run {
            before = None;
            return;
        }
        let reference = &row.reference.q;
        for (k, (q, allowed)) in row.truth.q.iter().zip(&allowed).enumerate() {
            let error = (q - reference[k]).abs() / allowed;
            largest[0] = largest[0].max(error);
            largest[1] = if row.repeat.is_some() { largest[1].max(error) } else { largest[1] };
            let step = before.as_ref().map_or(0.0, |before| (reference[k] - before[k]).abs());
            assert!(step <= 5.0 * machine.period, "the reference of joint {k} jumps by {step}");
        }
        before = Some(reference.clone());
    };
    while session.step(&mut see).unwrap() {}
    let (delay, mode) = (session.delay(), session.supervisor().mode());
    let summary = session.finish();
    assert!(summary.stopped.is_none() && summary.plant_failed.is_none(), "{:?}", summary.stopped);
    assert_eq!(mode, Mode::Run);
    let expected = delay + RESTS[0] + trajectory.duration() + RESTS[1];
    assert!((cycles as f64 * machine.period - expected).abs() < 2.0 * machine.period);
    assert!(
        (moved as f64 * machine.period - trajectory.duration()).abs() < 2.0 * machine.period,
        "all of it"
    );
    // A pretension without load cells moves a finger with springs: its way begins from there.
    assert!(delay > 0.0 || approach.motion().is_none());
    Some(largest)
}

/// What a machine may stray by, as a fraction of a fault.
const MOST: f64 = 0.2;

/// How many of the poses that were tried a machine was led from.
fn campaign(name: &str, count: usize, without: [bool; 2]) -> usize {
    let mut machine = machines::machine(name);
    let [cells, encoders] = without;
    if cells {
        machine.muscles.iter_mut().for_each(|muscle| muscle.drive.has_load_cell = false);
    }
    if encoders {
        machine.encoders.fill(None);
    }
    let joints = machine.start.len();
    let points: Vec<Vec<f64>> = EvenPoints::new(2 * joints).take(count).collect();
    let tried: Vec<_> = points
        .par_iter()
        .enumerate()
        .map(|(k, point)| {
            let first = about(&machine, &point[..joints], 0.4);
            let elsewhere = about(&machine, &point[joints..], 0.7);
            let standing = if encoders { machine.start.clone() } else { elsewhere };
            led(&machine, &standing, &first, 7000 + k as u64)
        })
        .collect();
    let led: Vec<_> = tried.into_iter().flatten().collect();
    // Its cables leave one of its poses to springs, which know of no straight way.
    let most = if name == "spring_finger" { f64::INFINITY } else { MOST };
    for [all, motion] in &led {
        assert!(*all < most && *motion < most, "{name} {without:?}: {all} {motion}");
    }
    eprintln!("{name} {without:?}: {} of {count} led there, {led:.2?}", led.len());
    led.len()
}

const MACHINES: [&str; 5] = ["bench_joint", "planar_leg", "finger", "exosuit_elbow", "surgical_wrist"];

#[test]
fn a_machine_that_stands_elsewhere_is_led_to_its_motion() {
    let led: usize = MACHINES.par_iter().map(|name| campaign(name, 3, [false, false])).sum();
    assert!(led >= 10, "{led}");
}

#[test]
fn joints_that_nothing_measures_are_led_to_the_motion_from_the_start_of_the_machine() {
    let led: usize = MACHINES.par_iter().map(|name| campaign(name, 2, [false, true])).sum();
    assert!(led >= 6, "{led}");
}

#[test]
fn long_machines_with_any_sensors_are_led_to_their_motion_from_anywhere() {
    if std::env::var_os("SINEW_LONG").is_none() {
        eprintln!("skipped: SINEW_LONG is not set");
        return;
    }
    let names = ["lm_arm", "shoulder", "chain10", "spring_finger", "two_finger_hand"];
    for without in [[false, false], [true, false], [false, true], [true, true]] {
        for name in MACHINES.iter().chain(&names) {
            campaign(name, 10, without);
        }
    }
}
