//! Motions of the joints: through poses, and tours of their ranges, with and without couplings.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

use crate::common;

use common::chains::{Chain, chain};
use common::lm_arm;
use sinew::body::{Coupling, Reduction, Robot, Scratch};
use sinew::muscle::{Geometry, Muscles};
use sinew::random::Random;
use sinew::trajectory::{
    Infeasibility, JointWaypoint, Limits, Reference, Tour, Trajectory, Violation, feasible_tour,
    first_infeasibility, independent_ranges, through_joint_waypoints,
};

/// The arm whose wrist deviation follows the pronation, which follows the elbow.
fn coupled_arm() -> Robot {
    let mut parts = lm_arm().parts().clone();
    let place = |name: &str| parts.joints.iter().position(|joint| joint.name == name).unwrap();
    let (elbow, pronation, wrist) =
        (place("elbow_flexion"), place("forearm_pronation"), place("wrist_deviation"));
    parts.keys.clear();
    parts.couplings = vec![
        Coupling {
            follower: wrist,
            leader: Some(pronation),
            coefficients: [0.0, 0.3, 0.0, 0.0, 0.0],
            pieces: Vec::new(),
        },
        Coupling {
            follower: pronation,
            leader: Some(elbow),
            coefficients: [-0.3, 1.1, 0.05, 0.0, 0.0],
            pieces: Vec::new(),
        },
    ];
    Robot::new(parts).unwrap()
}

fn at(trajectory: &Trajectory, time: f64) -> Reference {
    let mut now = Reference::new(trajectory.joints());
    trajectory.sample(time, &mut now).unwrap();
    now
}

fn off(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |worst: f64, (a, b)| worst.max((a - b).abs()))
}

/// Limits of the speed of joints and cables and of the acceleration of cables, the same for all.
fn limits([joint_speed, cable_speed, cable_acceleration]: [f64; 3], interval: f64) -> Limits {
    let each = |limit| vec![limit; 15];
    Limits {
        joint_speed,
        cable_speed: each(cable_speed),
        cable_acceleration: each(cable_acceleration),
        interval,
    }
}

#[test]
fn poses_are_reached_at_their_times_and_a_repeated_one_is_a_stop() {
    let mut random = Random::new(1);
    for joints in 1..6 {
        let mut pose = || (0..joints).map(|_| random.normal()).collect::<Vec<f64>>();
        let (a, b, c) = (pose(), pose(), pose());
        let times = [2.0, 3.0, 4.5, 5.5, 7.0];
        let poses = [&a, &b, &c, &c, &a];
        let points: Vec<JointWaypoint> =
            times.iter().zip(poses).map(|(&time, q)| JointWaypoint { time, q: q.clone() }).collect();
        let trajectory = through_joint_waypoints(&points).unwrap();
        assert!((trajectory.duration() - 5.0).abs() < 1e-12 && trajectory.is_closed());
        for (time, pose) in times.iter().zip(poses) {
            assert!(off(&at(&trajectory, time - 2.0).q, pose) < 1e-9, "{time}");
        }
        for time in [0.0, 2.5, 2.9, 3.2, 3.5, 5.0] {
            let now = at(&trajectory, time);
            assert!(
                off(&now.v, &vec![0.0; joints]) < 1e-9 && off(&now.a, &vec![0.0; joints]) < 1e-6,
                "{time}"
            );
        }
        assert!(off(&at(&trajectory, 1.0).v, &vec![0.0; joints]) > 0.1, "no stop at a pose given once");
        assert!(through_joint_waypoints(&points[..1]).is_err());
        let mut odd = points.clone();
        odd[1].q.push(0.0);
        assert!(through_joint_waypoints(&odd).is_err());
        odd = points;
        odd.swap(1, 2);
        assert!(through_joint_waypoints(&odd).is_err());
    }
}

#[test]
fn a_tour_uses_every_joint_over_half_of_its_range_and_reverses_every_cable() {
    for robot in [lm_arm(), coupled_arm()] {
        let n = robot.independent_joints().len();
        let start = vec![0.1; n];
        let ranges = independent_ranges(&robot).unwrap();
        let trajectory = feasible_tour(&robot, &start, None, |_| Ok::<_, sinew::Error>(None)).unwrap();
        assert!(trajectory.is_closed() && (trajectory.duration() - 12.0).abs() < 1e-12);
        assert!(off(&at(&trajectory, 0.0).v, &vec![0.0; n]) < 1e-12);
        let muscles = Muscles::new(&robot);
        let (mut reduction, mut geometry) = (Reduction::new(&robot), Geometry::new(&robot, &muscles));
        let (mut q, mut v) = (vec![0.0; robot.nq()], vec![0.0; robot.nv()]);
        let mut rates = vec![0.0; muscles.count()];
        let mut extremes = vec![[f64::INFINITY, f64::NEG_INFINITY]; n];
        let mut fastest = vec![[0.0_f64; 2]; muscles.count()];
        for k in 0..=1200 {
            let now = at(&trajectory, 0.01 * f64::from(k));
            reduction.expand(&robot, &now.q, &mut q).unwrap();
            reduction.velocities(&now.v, &mut v).unwrap();
            muscles.evaluate(&q, &mut geometry).unwrap();
            muscles.velocities(&geometry, &v, &mut rates).unwrap();
            for ([low, high], q) in extremes.iter_mut().zip(&now.q) {
                (*low, *high) = (low.min(*q), high.max(*q));
            }
            for ([least, most], rate) in fastest.iter_mut().zip(&rates) {
                (*least, *most) = (least.min(*rate), most.max(*rate));
            }
        }
        for (used, range) in extremes.iter().zip(&ranges) {
            let fraction = (used[1] - used[0]) / (range[1] - range[0]);
            assert!((0.4..0.6).contains(&fraction), "{fraction}");
            assert!(used[0] > range[0] && used[1] < range[1]);
        }
        for (muscle, [least, most]) in fastest.iter().enumerate() {
            assert!(*least < -2e-3 && *most > 2e-3, "{muscle}: {least} {most}");
        }
    }
}

#[test]
fn a_tour_is_made_slower_until_the_check_is_content_and_is_the_same_every_time() {
    let robot = lm_arm();
    let tour = |duration| {
        let check = |trajectory: &Trajectory| {
            let limits = limits([5.0, 0.02, 0.05], 0.01);
            first_infeasibility(&robot, trajectory, &limits, |_| Ok(None))
        };
        feasible_tour(&robot, &[0.1; 7], duration, check).unwrap()
    };
    let slow = tour(None);
    assert!(slow.duration() > 13.0 && slow.duration() < 120.0, "{}", slow.duration());
    assert_eq!(slow, tour(None));
    assert!((tour(Some(5.0)).duration() - 5.0).abs() < 1e-12, "the duration was given");
    let mut random = Random::new(9);
    for joints in 1..9 {
        let robot = chain(&mut random, joints, Chain::Slides);
        for tour in Tour::candidates(&robot, &vec![0.0; joints], 0.5).unwrap() {
            assert!(tour.stroke > 0.0 && tour.trajectory(9.0).unwrap().is_closed());
        }
    }
}

#[test]
fn a_coupled_joint_beyond_its_range_is_named_and_limits_its_leader() {
    let robot = coupled_arm();
    let ranges = independent_ranges(&robot).unwrap();
    let names: Vec<&str> =
        robot.independent_joints().iter().map(|&j| robot.parts().joints[j].name.as_str()).collect();
    let elbow = names.iter().position(|name| *name == "elbow_flexion").unwrap();
    let own = robot.parts().joints[robot.joint("elbow_flexion").unwrap()].range.unwrap();
    assert!(ranges[elbow][0] >= own[0] && ranges[elbow][1] < own[1], "{:?} {own:?}", ranges[elbow]);
    let travel = |end: f64| {
        let mut q: Vec<f64> = ranges.iter().map(|[low, high]| 0.5 * (low + high)).collect();
        let from = JointWaypoint { time: 0.0, q: q.clone() };
        q[elbow] = end;
        let motion = through_joint_waypoints(&[from, JointWaypoint { time: 20.0, q }]).unwrap();
        first_infeasibility(&robot, &motion, &Limits::default(), |_| Ok(None)).unwrap()
    };
    assert_eq!(travel(ranges[elbow][1]), None);
    let Some(Infeasibility { violation: Violation::JointRange { joint, .. }, .. }) =
        travel(ranges[elbow][1] + 1e-3)
    else {
        panic!("the follower leaves its range")
    };
    assert!(["forearm_pronation", "wrist_deviation"].contains(&joint.as_str()), "{joint}");
}

#[test]
fn the_torque_demand_of_a_coupled_robot_accelerates_it_as_planned() {
    let robot = coupled_arm();
    let n = robot.independent_joints().len();
    let ranges = independent_ranges(&robot).unwrap();
    let tour = Tour::candidates(&robot, &vec![0.1; n], 0.5).unwrap().remove(0);
    assert_eq!(tour.center.len(), ranges.len());
    let trajectory = tour.trajectory(6.0).unwrap();
    let (mut reduction, mut scratch) = (Reduction::new(&robot), Scratch::new(&robot));
    let (mut q, mut v, mut full) = (vec![0.0; 7], vec![0.0; 7], vec![0.0; 7]);
    let (mut du, mut k) = (vec![0.0; n], 0);
    let limits = limits([50.0, 5.0, 50.0], 0.05);
    let found = first_infeasibility(&robot, &trajectory, &limits, |demand| {
        assert_eq!((demand.torque.len(), demand.moment_arms.len()), (n, 15 * n));
        let now = at(&trajectory, 0.05 * f64::from(k));
        k += 1;
        reduction.expand(&robot, &now.q, &mut q)?;
        reduction.velocities(&now.v, &mut v)?;
        robot.passive_force(&q, &v, &mut full)?;
        for (place, tau) in reduction.independent().iter().zip(demand.torque) {
            full[*place] += tau;
        }
        reduction.forward_dynamics(&robot, &q, &now.v, &full, &mut scratch, &mut du)?;
        assert!(off(&du, &now.a) < 1e-8 * (1.0 + off(&now.a, &vec![0.0; n])), "{k}: {du:?} {:?}", now.a);
        Ok(None)
    });
    assert_eq!(found.unwrap(), None);
    assert!(k > 100);
}
