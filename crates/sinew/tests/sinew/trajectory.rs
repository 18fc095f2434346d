//! Paths, their joints, their times, and what stops a robot from following: as laws, on the arm of `models/`.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

use crate::common;

use common::{lm_arm, lm_machine, lm_path};
use sinew::body::{Poses, Robot};
use sinew::trajectory::{
    EndPointPath, JointPath, Limits, Loop, MinimumJerk, PathSegment, Redundancy, Reference, Sequence,
    TimeLaw, TorqueDeficit, Trajectory, Violation, Waypoint, first_infeasibility, split_at_rests,
};
use std::f64::consts::PI;

fn end_point(robot: &Robot, q: &[f64]) -> [f64; 3] {
    let mut poses = Poses::new(robot);
    robot.forward_kinematics(q, &mut poses).unwrap();
    robot.site_pose(&poses, robot.site("endpoint").unwrap()).origin
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

fn resolved(robot: &Robot, path: &EndPointPath) -> JointPath {
    JointPath::resolve(robot, robot.site("endpoint").unwrap(), path, &lm_machine().redundancy, 720).unwrap()
}

fn around(robot: &Robot, shape: Loop, duration: f64) -> Trajectory {
    let joints = resolved(robot, &lm_path(shape));
    Trajectory::AlongPath { joints, law: TimeLaw::new(4.0 * PI, duration).unwrap() }
}

fn worst(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |worst: f64, (a, b)| worst.max((a - b).abs()))
}

#[test]
fn the_end_point_is_on_the_path_at_every_knot_and_the_joints_close() {
    let robot = lm_arm();
    for shape in [Loop::Sine, Loop::Saddle] {
        let path = lm_path(shape);
        let joints = resolved(&robot, &path);
        assert!(joints.first_unreached().is_none());
        for k in 0..720 {
            let phase = 2.0 * PI * f64::from(k) / 720.0;
            let off = distance(end_point(&robot, &joints.pose(phase)), path.point(phase));
            assert!(off < 1e-10, "{shape:?} {phase}: {off}");
            let between = phase + PI / 720.0;
            let off = distance(end_point(&robot, &joints.pose(between)), path.point(between));
            assert!(off < 1e-8, "{shape:?} {between}: {off}");
        }
        assert!(worst(&joints.pose(0.3), &joints.pose(0.3 + 2.0 * PI)) < 1e-12);
    }
}

#[test]
fn the_start_of_the_sine_is_the_key_of_the_model() {
    let robot = lm_arm();
    let start = resolved(&robot, &lm_path(Loop::Sine)).pose(0.0);
    assert!(worst(&start, robot.key("start").unwrap()) < 1e-8, "{start:?}");
}

#[test]
fn the_resolved_pose_satisfies_the_optimality_condition() {
    // At the minimum the gradient W (q - r) has no component in the null space of the Jacobian.
    let robot = lm_arm();
    let (rule, site) = (lm_machine().redundancy, robot.site("endpoint").unwrap());
    let joints = resolved(&robot, &lm_path(Loop::Saddle));
    for k in 0..12 {
        let phase = 2.0 * PI * f64::from(k) / 12.0;
        let q = joints.pose(phase);
        let mut poses = Poses::new(&robot);
        robot.forward_kinematics(&q, &mut poses).unwrap();
        let (mut rows, mut angular) = (vec![0.0; 21], vec![0.0; 21]);
        let (body, point) = (robot.parts().sites[site].body, robot.site_pose(&poses, site).origin);
        robot.jacobian(&poses, body, point, &mut rows, &mut angular).unwrap();
        let preferred = |j: usize| rule.rest[j] + rule.swing[j] * phase.sin();
        let mut left: Vec<f64> = (0..7).map(|j| rule.weight[j] * (q[j] - preferred(j))).collect();
        let before = norm(&left);
        let mut basis: Vec<Vec<f64>> = Vec::new();
        for row in rows.chunks(7) {
            let mut own = row.to_vec();
            basis.iter().for_each(|other| remove(&mut own, other));
            let size = norm(&own);
            basis.push(own.iter().map(|x| x / size).collect());
        }
        basis.iter().for_each(|other| remove(&mut left, other));
        assert!(before > 1e-2 && norm(&left) < 1e-9, "{phase}: {before} {}", norm(&left));
    }
}

fn norm(v: &[f64]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Removes the component along a unit vector.
fn remove(v: &mut [f64], unit: &[f64]) {
    let fraction: f64 = v.iter().zip(unit).map(|(a, b)| a * b).sum();
    v.iter_mut().zip(unit).for_each(|(v, u)| *v -= fraction * u);
}

#[test]
fn velocities_and_accelerations_are_finite_differences_of_the_pose() {
    let robot = lm_arm();
    let h = 1e-4;
    let points = [[0.66, 0.23, -0.28], [0.60, 0.20, -0.20], [0.62, 0.10, -0.25]];
    let waypoints: Vec<Waypoint> =
        points.iter().zip([0.0, 1.0, 2.5]).map(|(&position, time)| Waypoint { time, position }).collect();
    let timed = through(&robot, &waypoints);
    let jerk = MinimumJerk::new(&[0.0; 7], robot.key("start").unwrap(), 10.0).unwrap();
    for trajectory in [around(&robot, Loop::Saddle, 11.5), timed, Trajectory::PointToPoint(jerk)] {
        let at = |time: f64| {
            let mut now = Reference::new(7);
            trajectory.sample(time, &mut now).unwrap();
            now
        };
        let mut moved = 0.0_f64;
        for k in 1..200 {
            let t = trajectory.duration() * f64::from(k) / 200.0;
            let [before, now, after] = [at(t - h), at(t), at(t + h)];
            for j in 0..7 {
                let v = (after.q[j] - before.q[j]) / (2.0 * h);
                let a = (after.v[j] - before.v[j]) / (2.0 * h);
                assert!((v - now.v[j]).abs() < 1e-5, "{t} {j}: {v} {}", now.v[j]);
                // A cubic's second derivative has corners.
                assert!((a - now.a[j]).abs() < 2e-2, "{t} {j}: {a} {}", now.a[j]);
                moved = moved.max(now.v[j].abs());
            }
        }
        assert!(moved > 0.1, "nothing moved");
        // At rest before and after, with continuous acceleration in between.
        for time in [0.0, 99.0] {
            assert!(worst(&at(time).v, &[0.0; 7]) < 1e-9 && worst(&at(time).a, &[0.0; 7]) < 1e-9);
        }
    }
}

fn through(robot: &Robot, waypoints: &[Waypoint]) -> Trajectory {
    let path = EndPointPath::through(waypoints).unwrap();
    let EndPointPath::Waypoints { law, .. } = &path else { panic!("{path:?}") };
    Trajectory::AlongPath { joints: resolved(robot, &path), law: *law }
}

#[test]
fn waypoints_are_reached_at_their_times() {
    let robot = lm_arm();
    let points = [(0.0, [0.66, 0.23, -0.28]), (1.5, [0.6, 0.2, -0.2]), (3.0, [0.62, 0.1, -0.25])];
    let waypoints: Vec<Waypoint> =
        points.iter().map(|&(time, position)| Waypoint { time, position }).collect();
    let (trajectory, mut now) = (through(&robot, &waypoints), Reference::new(7));
    for (time, position) in points {
        trajectory.sample(time, &mut now).unwrap();
        assert!(distance(end_point(&robot, &now.q), position) < 1e-6, "{time}");
    }
}

#[test]
fn both_paths_and_the_motion_to_their_start_are_feasible_for_the_arm() {
    let robot = lm_arm();
    let way = MinimumJerk::new(robot.key("hanging").unwrap(), robot.key("start").unwrap(), 10.0).unwrap();
    for trajectory in [
        around(&robot, Loop::Sine, 115.0),
        around(&robot, Loop::Saddle, 115.0),
        around(&robot, Loop::Sine, 11.5),
        around(&robot, Loop::Saddle, 11.5),
        Trajectory::PointToPoint(way),
    ] {
        let mut largest = 0.0_f64;
        let found = first_infeasibility(&robot, &trajectory, &Limits::default(), |demand| {
            largest = demand.torque.iter().fold(largest, |largest, tau| largest.max(tau.abs()));
            Ok(None)
        });
        assert_eq!(found.unwrap(), None);
        assert!(largest > 3.0, "without gravity: {largest}");
    }
}

#[test]
fn the_first_violated_limit_is_reported_with_its_time() {
    let robot = lm_arm();
    let violated = |trajectory: &Trajectory, limits: Limits, largest: f64| {
        let found = first_infeasibility(&robot, trajectory, &limits, |demand| {
            let beyond = demand.torque.iter().position(|tau| tau.abs() > largest);
            Ok(beyond.map(|velocity| TorqueDeficit {
                velocity,
                torque: demand.torque[velocity].abs() - largest,
                muscle: Some((2, 7.0)),
                slack: None,
            }))
        });
        found.unwrap().unwrap()
    };
    let sine = around(&robot, Loop::Sine, 11.5);
    let free = f64::INFINITY;

    // A metre away.
    let far = EndPointPath::Loop { shape: Loop::Sine, center: [0.9, 0.1, -0.15], amplitude: 0.15 };
    let law = TimeLaw::new(4.0 * PI, 115.0).unwrap();
    let far = Trajectory::AlongPath { joints: resolved(&robot, &far), law };
    let found = violated(&far, Limits::default(), free);
    assert!(matches!(&found.violation, Violation::Unreachable(point) if point.distance > 1e-3), "{found}");
    assert!(
        (0.0..115.0).contains(&found.time) && found.to_string().contains("target unreachable"),
        "{found}"
    );

    let slow = Limits { cable_speed: vec![0.005], ..Limits::default() };
    let found = violated(&sine, slow, free);
    assert!(matches!(&found.violation, Violation::CableSpeed { speed, .. } if *speed > 0.005), "{found}");
    assert!(found.time > 0.0);

    let lazy = Limits { cable_acceleration: vec![0.003], ..Limits::default() };
    let found = violated(&sine, lazy, free);
    assert!(
        matches!(&found.violation, Violation::CableAcceleration { acceleration, .. } if *acceleration > 0.003),
        "{found}"
    );

    let found = violated(&sine, Limits { joint_speed: 0.1, ..Limits::default() }, free);
    assert!(matches!(&found.violation, Violation::JointSpeed { .. }), "{found}");

    let found = violated(&sine, Limits::default(), 1.0);
    assert!(
        matches!(&found.violation, Violation::Torque { joint, needed, .. } if joint.starts_with("shoulder") && needed.abs() > 1.0),
        "{found}"
    );
    assert!(found.to_string().contains("`deltoid_posterior` is at 7 N"), "{found}");

    let mut beyond = robot.key("start").unwrap().to_vec();
    beyond[3] = 2.5;
    let way = MinimumJerk::new(robot.key("start").unwrap(), &beyond, 10.0).unwrap();
    let found = violated(&Trajectory::PointToPoint(way), Limits::default(), free);
    assert!(
        matches!(&found.violation, Violation::JointRange { joint, position, .. } if joint == "elbow_flexion" && *position > 2.26),
        "{found}"
    );
}

#[test]
fn a_rule_for_another_robot_and_numbers_out_of_domain_are_refused() {
    let robot = lm_arm();
    let site = robot.site("endpoint").unwrap();
    let path = lm_path(Loop::Sine);
    let rule = lm_machine().redundancy;
    assert!(JointPath::resolve(&robot, 9999, &path, &rule, 720).is_err());
    assert!(JointPath::resolve(&robot, site, &path, &Redundancy::near(&[0.0; 3]), 720).is_err());
    assert!(JointPath::resolve(&robot, site, &path, &rule, 2).is_err());
    let mut heavy = rule.clone();
    heavy.weight[2] = f64::NAN;
    assert!(JointPath::resolve(&robot, site, &path, &heavy, 720).is_err());
    let nowhere = EndPointPath::Loop { shape: Loop::Sine, center: [f64::NAN; 3], amplitude: 0.1 };
    assert!(JointPath::resolve(&robot, site, &nowhere, &rule, 720).is_err());
    assert!(MinimumJerk::new(&[0.0; 7], &[0.0; 6], 1.0).is_err());
    let of_six = Trajectory::PointToPoint(MinimumJerk::new(&[0.0; 6], &[0.1; 6], 1.0).unwrap());
    assert!(of_six.sample(0.5, &mut Reference::new(7)).is_err());
    assert!(first_infeasibility(&robot, &of_six, &Limits::default(), |_| Ok(None)).is_err());
    let of_seven = Trajectory::PointToPoint(MinimumJerk::new(&[0.0; 7], &[0.1; 7], 1.0).unwrap());
    let never = Limits { interval: 0.0, ..Limits::default() };
    assert!(first_infeasibility(&robot, &of_seven, &never, |_| Ok(None)).is_err());
}

/// Path through waypoints as a sequence of segments between stops.
fn with_stops(robot: &Robot, waypoints: &[Waypoint]) -> Trajectory {
    let rule = Redundancy { swing: vec![0.0; 7], ..lm_machine().redundancy };
    let motion = |leg: &PathSegment| {
        let EndPointPath::Waypoints { law, .. } = &leg.path else { panic!("{leg:?}") };
        let joints =
            JointPath::resolve(robot, robot.site("endpoint").unwrap(), &leg.path, &rule, 720).unwrap();
        (leg.start, Trajectory::AlongPath { joints, law: *law })
    };
    let motions = split_at_rests(waypoints).unwrap().iter().map(motion).collect();
    let duration = waypoints[waypoints.len() - 1].time - waypoints[0].time;
    Trajectory::Sequence(Sequence::new(motions, duration).unwrap())
}

const STOPS: [(f64, [f64; 3]); 7] = [
    (0.0, [0.60, 0.10, -0.15]),
    (1.5, [0.66, 0.20, -0.20]),
    (3.0, [0.62, 0.15, -0.28]),
    (4.5, [0.62, 0.15, -0.28]),
    (6.5, [0.60, 0.10, -0.15]),
    (7.0, [0.60, 0.10, -0.15]),
    (8.0, [0.60, 0.10, -0.15]),
];

fn stops() -> Vec<Waypoint> {
    STOPS.iter().map(|&(time, position)| Waypoint { time, position }).collect()
}

#[test]
fn the_joints_rest_exactly_between_two_equal_waypoints() {
    let robot = lm_arm();
    let (trajectory, mut now) = (with_stops(&robot, &stops()), Reference::new(7));
    assert!((trajectory.duration() - 8.0).abs() < 1e-12 && trajectory.is_closed());
    for (time, position) in STOPS {
        trajectory.sample(time, &mut now).unwrap();
        assert!(distance(end_point(&robot, &now.q), position) < 1e-6, "{time}");
    }
    for (from, to) in [(3.0, 4.5), (6.5, 8.0)] {
        trajectory.sample(from, &mut now).unwrap();
        let still = now.q.clone();
        for k in 0..=300 {
            let time = from + (to - from) * f64::from(k) / 300.0;
            trajectory.sample(time, &mut now).unwrap();
            assert!(worst(&now.q, &still) < 1e-9, "{time}");
            assert!(worst(&now.v, &[0.0; 7]) < 1e-12 && worst(&now.a, &[0.0; 7]) < 1e-9, "{time}");
        }
    }
}

#[test]
fn velocity_and_acceleration_are_continuous_at_the_ends_of_a_stop() {
    let robot = lm_arm();
    let trajectory = with_stops(&robot, &stops());
    let (mut before, mut now) = (Reference::new(7), Reference::new(7));
    trajectory.sample(0.0, &mut before).unwrap();
    let (mut fastest, mut hardest) = (0.0_f64, 0.0_f64);
    for k in 1..=80_000 {
        trajectory.sample(1e-4 * f64::from(k), &mut now).unwrap();
        fastest = fastest.max(worst(&now.v, &[0.0; 7]));
        hardest = hardest.max(worst(&now.a, &[0.0; 7]));
        assert!(worst(&now.v, &before.v) < 1e-3 && worst(&now.a, &before.a) < 0.01, "{k}");
        core::mem::swap(&mut before, &mut now);
    }
    assert!(fastest > 0.1 && hardest > 0.1, "nothing moved");
}

#[test]
fn two_waypoints_give_a_straight_line_with_minimum_jerk() {
    let robot = lm_arm();
    let ends = [stops()[0], stops()[1]];
    let (trajectory, mut now) = (with_stops(&robot, &ends), Reference::new(7));
    for k in 0..=30 {
        let x = f64::from(k) / 30.0;
        trajectory.sample(1.5 * x, &mut now).unwrap();
        let gone = x * x * x * (10.0 + x * (6.0 * x - 15.0));
        let [from, to] = [ends[0].position, ends[1].position];
        let line = std::array::from_fn(|i| from[i] + gone * (to[i] - from[i]));
        assert!(distance(end_point(&robot, &now.q), line) < 1e-6, "{x}");
    }
    assert!(!trajectory.is_closed());
}

#[test]
fn motions_that_overlap_or_do_not_join_are_refused() {
    let robot = lm_arm();
    let start = robot.key("start").unwrap();
    let [there, back] = [(&[0.0; 7][..], start), (start, &[0.0; 7][..])]
        .map(|(from, to)| Trajectory::PointToPoint(MinimumJerk::new(from, to, 2.0).unwrap()));
    assert!(Sequence::new(vec![(0.0, there.clone()), (2.5, back.clone())], 5.0).is_ok());
    assert!(Sequence::new(vec![(0.0, there.clone()), (1.9, back.clone())], 5.0).is_err());
    assert!(Sequence::new(vec![(0.0, there.clone()), (2.5, there.clone())], 5.0).is_err());
    assert!(Sequence::new(vec![(0.0, there.clone()), (2.5, back)], 4.0).is_err());
    assert!(Sequence::new(vec![(f64::NAN, there)], 5.0).is_err());
    assert!(Sequence::new(vec![], 5.0).is_err());
}
