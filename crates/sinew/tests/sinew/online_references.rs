//! References that are made while the machine moves, on every machine of the repository.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

use sinew::description::machine_from_toml;
use sinew::machine::{Machine, Task};
use sinew::random::Random;
use sinew::trajectory::online::{
    EndPointStep, JointLimits, Limited, MuscleLengthStep, Setpoint, SetpointFollower,
};
use sinew::trajectory::{Reference, finite_ranges};

const H: f64 = 1e-3;
const HORIZON: f64 = 0.12;
const MACHINES: [&str; 8] = [
    "bench_joint",
    "chain10",
    "exosuit_elbow",
    "finger",
    "lm_arm",
    "planar_leg",
    "shoulder",
    "surgical_wrist",
];

fn machine(name: &str) -> Machine {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../models");
    let read = |file: &str| std::fs::read_to_string(format!("{folder}/{file}"));
    let text = read(&format!("{name}.toml")).unwrap();
    machine_from_toml(name, &text, &mut |file| read(file.path).map_err(|e| e.to_string())).unwrap().machine
}

fn limits(machine: &Machine) -> JointLimits {
    let range = finite_ranges(&machine.robot, &machine.start).unwrap();
    let speed = range.iter().map(|[low, high]| 0.5 * (high - low)).collect();
    let acceleration = range.iter().map(|[low, high]| 2.0 * (high - low)).collect();
    JointLimits { range, speed, acceleration }
}

fn end_point(machine: &Machine) -> Option<(usize, [bool; 3])> {
    match machine.task {
        Task::EndPoint { site, axes } => Some((site, axes)),
        Task::Joints => None,
    }
}

fn follower(machine: &Machine) -> SetpointFollower {
    let point = end_point(machine).map(|(site, axes)| (site, axes, &machine.redundancy));
    SetpointFollower::new(&machine.robot, limits(machine), point, &machine.start, [HORIZON, H]).unwrap()
}

/// A pose within the middle 80 % of the ranges.
fn pose(limits: &JointLimits, random: &mut Random) -> Vec<f64> {
    let inside = |[low, high]: &[f64; 2]| low + (high - low) * (0.1 + 0.8 * random.unit());
    limits.range.iter().map(inside).collect()
}

/// Follows one set-point; checks the limits in every cycle.
fn follow(follower: &mut SetpointFollower, setpoint: Setpoint<'_>, seconds: f64) -> (Reference, Limited) {
    let limits = follower.limits().clone();
    let [mut now, mut soon] = [(); 2].map(|()| Reference::new(limits.range.len()));
    let mut limited = Limited::No;
    let mut last: Option<Vec<f64>> = None;
    for _ in 0..(seconds / H) as usize {
        limited = follower.step(setpoint, &mut now, &mut soon).unwrap();
        for (k, [low, high]) in limits.range.iter().enumerate() {
            assert!((*low..=*high).contains(&now.q[k]), "range of joint {k}");
            assert!(now.v[k].abs() <= limits.speed[k] * (1.0 + 1e-9), "speed of joint {k}");
            assert!(now.a[k].abs() <= limits.acceleration[k], "acceleration of joint {k}");
            if let Some(last) = &last {
                assert!((now.q[k] - last[k]).abs() <= H * limits.speed[k] * (1.0 + 1e-6) + 1e-7, "a jump");
            }
        }
        last = Some(now.q.clone());
    }
    (now, limited)
}

#[test]
fn joint_set_points_are_reached_exactly_on_every_machine() {
    for name in MACHINES {
        let (machine, mut random) = (machine(name), Random::new(3));
        let mut follower = follower(&machine);
        let none = vec![0.0; machine.start.len()];
        for _ in 0..5 {
            let desired = pose(follower.limits(), &mut random);
            let (reached, limited) = follow(&mut follower, Setpoint::Joints(&desired, &none), 6.0);
            assert_eq!((reached.q, limited), (desired, Limited::No), "{name}");
        }
        let (held, _) = follow(&mut follower, Setpoint::Hold, 1.0);
        assert!(held.v.iter().all(|v| *v == 0.0), "{name}");
    }
}

#[test]
fn end_points_of_random_poses_are_reached_on_every_machine_that_has_one() {
    let (mut tried, mut reached, mut machines) = (0, 0, 0);
    for name in MACHINES {
        let machine = machine(name);
        let Some((site, axes)) = end_point(&machine) else { continue };
        machines += 1;
        let (mut follower, mut random) = (follower(&machine), Random::new(5));
        let ranges = follower.limits().range.clone();
        let mut kinematics =
            EndPointStep::new(&machine.robot, &machine.redundancy, site, axes, &ranges).unwrap();
        for _ in 0..25 {
            let target = kinematics.position(&pose(follower.limits(), &mut random)).unwrap();
            let (at, _) = follow(&mut follower, Setpoint::EndPoint(target), 6.0);
            let point = kinematics.position(&at.q).unwrap();
            let off = (0..3).filter(|k| axes[*k]).map(|k| (point[k] - target[k]).abs()).fold(0.0, f64::max);
            tried += 1;
            reached += usize::from(off < 1e-4);
        }
    }
    assert!(machines >= 2, "{machines} machines have an end point");
    eprintln!("{reached} of {tried} reached");
    // From any pose to any other within the ranges, without a planned path: some end against a range.
    assert!(reached * 100 >= tried * 90, "{reached} of {tried}");
}

#[test]
fn an_end_point_out_of_reach_is_approached_and_reported() {
    let machine = machine("lm_arm");
    let mut follower = follower(&machine);
    let (site, axes) = end_point(&machine).unwrap();
    let ranges = follower.limits().range.clone();
    let mut kinematics = EndPointStep::new(&machine.robot, &machine.redundancy, site, axes, &ranges).unwrap();
    let before = kinematics.position(&machine.start).unwrap();
    let far = [before[0] + 5.0, before[1], before[2]];
    let (at, limited) = follow(&mut follower, Setpoint::EndPoint(far), 8.0);
    let after = kinematics.position(&at.q).unwrap();
    assert_eq!(limited, Limited::Yes);
    assert!(after[0] > before[0] + 0.05, "{before:?} {after:?}");
    assert!(at.v.iter().all(|v| v.abs() < 1e-2), "it comes to rest: {:?}", at.v);
}

#[test]
fn lengths_of_random_poses_lead_back_to_their_poses() {
    let mut worst = 0.0_f64;
    for name in MACHINES {
        let machine = machine(name);
        let (mut follower, mut random) = (follower(&machine), Random::new(7));
        let mut muscles = MuscleLengthStep::new(&machine.robot, &follower.limits().range.clone()).unwrap();
        for _ in 0..5 {
            let desired = pose(follower.limits(), &mut random);
            let lengths = muscles.lengths(&desired).unwrap().to_vec();
            let (at, limited) = follow(&mut follower, Setpoint::MuscleLengths(&lengths), 6.0);
            let reached = muscles.lengths(&at.q).unwrap();
            let off = reached.iter().zip(&lengths).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            worst = worst.max(off);
            assert!(off < 1e-5 && limited == Limited::No, "{name}: {off}");
        }
    }
    eprintln!("largest error of a length {worst:e} m");
}

#[test]
fn a_set_point_that_is_no_number_or_of_another_machine_is_refused() {
    let machine = machine("planar_leg");
    let mut follower = follower(&machine);
    let joints = machine.start.len();
    let [mut now, mut soon] = [(); 2].map(|()| Reference::new(joints));
    let nan = vec![f64::NAN; joints];
    for setpoint in [
        Setpoint::Joints(&nan, &nan),
        Setpoint::Joints(&[0.0], &[0.0]),
        Setpoint::EndPoint([f64::INFINITY; 3]),
        Setpoint::MuscleLengths(&[0.1]),
        Setpoint::MuscleLengths(&[f64::NAN; 4]),
    ] {
        assert!(follower.step(setpoint, &mut now, &mut soon).is_err(), "{setpoint:?}");
    }
    assert!(follower.step(Setpoint::Hold, &mut now, &mut soon).is_ok());
}
