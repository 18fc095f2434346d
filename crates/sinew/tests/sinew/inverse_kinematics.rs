//! Inverse kinematics on random machines: whatever a pose within the ranges reaches is found, and what is not
//! reached is explained.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

use crate::common;

use common::chains::{Chain, chain, pose_within};
use sinew::body::{Poses, Robot};
use sinew::random::Random;
use sinew::trajectory::{
    EndPointPath, JointPath, Loop, Redundancy, UnreachedCause, Waypoint, independent_ranges,
};

fn end_point(robot: &Robot, x: &[f64]) -> [f64; 3] {
    let mut poses = Poses::new(robot);
    robot.forward_kinematics(&robot.pose_from_independent(x).unwrap(), &mut poses).unwrap();
    robot.site_pose(&poses, robot.site("endpoint").unwrap()).origin
}

/// Resolves a place as a path of two equal points.
fn resolve(robot: &Robot, axes: [bool; 3], place: [f64; 3], rest: &[f64]) -> JointPath {
    let ends = [0.0, 1.0].map(|time| Waypoint { time, position: place });
    let path = EndPointPath::through(&ends).unwrap();
    let site = robot.site("endpoint").unwrap();
    JointPath::resolve_axes(robot, site, axes, &path, &Redundancy::near(rest), 4).unwrap()
}

fn off(axes: [bool; 3], a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).filter(|&k| axes[k]).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

/// Number of places that are not found among `count` on chains of every number of joints.
fn missed(count: u64, kind: Chain) -> (u64, u64) {
    let (mut missed, mut tried) = (0, 0);
    for seed in 0..count {
        let mut random = Random::new(seed);
        let robot = chain(&mut random, 1 + (seed % 11) as usize, kind);
        let axes = [0.3, 0.3, 0.3].map(|fraction| random.unit() > fraction);
        let axes = if axes.contains(&true) { axes } else { [true; 3] };
        let ranges = independent_ranges(&robot).unwrap();
        let (x, rest) = (pose_within(&mut random, &ranges), pose_within(&mut random, &ranges));
        let place = end_point(&robot, &x);
        let joints = resolve(&robot, axes, place, &rest);
        let found = joints.pose(0.0);
        tried += 1;
        if joints.first_unreached().is_some() {
            missed += 1;
            continue;
        }
        assert!(off(axes, end_point(&robot, &found), place) < 1e-9, "{seed}");
        let full = robot.pose_from_independent(&found).unwrap();
        for (index, joint) in robot.parts().joints.iter().enumerate() {
            let [low, high] = joint.range.unwrap();
            let at = full[robot.coordinates_of(index).start];
            assert!(at >= low - 1e-9 && at <= high + 1e-9, "{seed}: {} at {at}", joint.name);
        }
    }
    (missed, tried)
}

#[test]
fn places_that_a_pose_within_the_ranges_reaches_are_found_on_chains_of_one_to_eleven_joints() {
    for kind in [Chain::Hinges, Chain::Planar, Chain::Slides, Chain::Coupled] {
        let (missed, tried) = missed(600, kind);
        eprintln!("{kind:?}: {missed} of {tried}");
        assert!(missed * 200 <= tried, "{kind:?}: {missed} of {tried} places are not found");
    }
}

#[test]
fn a_place_beyond_the_workspace_is_refused_with_its_distance() {
    for seed in 0..60 {
        let mut random = Random::new(1000 + seed);
        let robot = chain(&mut random, 3 + (seed % 6) as usize, Chain::Free);
        let rest = vec![0.1; robot.independent_joints().len()];
        let reach = reach(&robot);
        let base = robot.parts().bodies[1].position;
        let direction = unit(&mut random);
        let place = std::array::from_fn(|k| base[k] + direction[k] * (reach + 0.05));
        let joints = resolve(&robot, [true; 3], place, &rest);
        let point = joints.first_unreached().unwrap();
        assert_eq!(point.cause, UnreachedCause::OutsideWorkspace, "{seed}: {point}");
        assert!(point.distance >= 0.05 - 1e-9 && point.distance < 0.05 + 2.0 * reach, "{seed}: {point}");
        assert!(point.to_string().contains("target unreachable, missed by"));
    }
}

/// Length of the links, m.
fn reach(robot: &Robot) -> f64 {
    let links: f64 = robot.parts().bodies[2..].iter().map(|body| body.position[2]).sum();
    links + robot.parts().sites[0].position[2]
}

fn unit(random: &mut Random) -> [f64; 3] {
    let v: [f64; 3] = std::array::from_fn(|_| random.normal());
    let norm = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    v.map(|x| x / norm)
}

#[test]
fn a_place_behind_a_limit_names_the_joint_that_keeps_the_end_point_away() {
    // Two links in the plane; the elbow is limited to 0.5..1 rad: its distance from the shoulder is fixed
    // within bounds.
    let mut random = Random::new(3);
    let robot = chain(&mut random, 2, Chain::Elbow);
    let at = |x: &[f64]| end_point(&robot, x);
    let straight = at(&[0.0, 0.5]);
    let base = robot.parts().bodies[1].position;
    let farther = std::array::from_fn(|k| base[k] + 1.02 * (straight[k] - base[k]));
    let joints = resolve(&robot, [true; 3], farther, &[0.3, 0.8]);
    let point = joints.first_unreached().unwrap();
    assert_eq!(point.cause, UnreachedCause::JointRanges(vec!["joint_1".into()]), "{point}");
    let distance = off([true; 3], farther, straight);
    assert!((point.distance / distance - 1.0).abs() < 0.05, "{point} {distance}");
    assert!(point.to_string().contains("`joint_1` at the limit of its range"), "{point}");
}

#[test]
fn a_rest_pose_outside_of_the_ranges_is_no_obstacle() {
    let mut random = Random::new(4);
    for seed in 0..40 {
        let robot = chain(&mut random, 2 + seed % 7, Chain::Hinges);
        let ranges = independent_ranges(&robot).unwrap();
        let place = end_point(&robot, &pose_within(&mut random, &ranges));
        let rest: Vec<f64> = ranges.iter().map(|[low, high]| high + (high - low)).collect();
        assert!(resolve(&robot, [true; 3], place, &rest).first_unreached().is_none(), "{seed}");
    }
}

#[test]
fn a_planar_leg_of_two_joints_follows_a_closed_path_in_its_plane_and_one_joint_an_axis() {
    let mut random = Random::new(5);
    let robot = chain(&mut random, 2, Chain::Elbow);
    let center = end_point(&robot, &[0.2, 0.75]);
    // Of the saddle [sin, cos, sin 2] the leg's plane contains x and z.
    let path = EndPointPath::Loop { shape: Loop::Saddle, center, amplitude: 0.02 * reach(&robot) };
    let site = robot.site("endpoint").unwrap();
    let rule = Redundancy::near(&[0.2, 0.75]);
    let follow = |axes| JointPath::resolve_axes(&robot, site, axes, &path, &rule, 360).unwrap();
    let joints = follow([true, false, true]);
    assert!(joints.first_unreached().is_none(), "{}", joints.first_unreached().unwrap());
    for k in 0..360 {
        let phase = f64::from(k).to_radians();
        let place = end_point(&robot, &joints.pose(phase));
        assert!(off([true, false, true], place, path.point(phase)) < 1e-9);
    }
    let all = follow([true; 3]);
    assert!(all.first_unreached().is_some(), "the path leaves the plane");
    let one = chain(&mut random, 1, Chain::Elbow);
    let center = end_point(&one, &[0.75]);
    let path = EndPointPath::Loop { shape: Loop::Sine, center, amplitude: 0.02 * reach(&one) };
    let rule = Redundancy::near(&[0.75]);
    let site = one.site("endpoint").unwrap();
    let joints = JointPath::resolve_axes(&one, site, [true, false, false], &path, &rule, 90).unwrap();
    assert!(joints.first_unreached().is_none());
}

#[test]
fn small_closed_paths_about_a_pose_are_followed_or_the_cause_is_named() {
    let (mut followed, mut beyond, mut tried) = (0, 0, 0);
    for seed in 0..45 {
        let mut random = Random::new(5000 + seed);
        let kind = [Chain::Hinges, Chain::Slides, Chain::Coupled][(seed % 3) as usize];
        let robot = chain(&mut random, 5 + (seed % 6) as usize, kind);
        let ranges = independent_ranges(&robot).unwrap();
        let middle: Vec<f64> = pose_within(&mut random, &ranges)
            .iter()
            .zip(&ranges)
            .map(|(x, [low, high])| 0.5 * (low + high) + 0.6 * (x - 0.5 * (low + high)))
            .collect();
        let center = end_point(&robot, &middle);
        let shape = if seed % 2 == 0 { Loop::Sine } else { Loop::Saddle };
        let path = EndPointPath::Loop { shape, center, amplitude: 0.02 * reach(&robot) };
        let site = robot.site("endpoint").unwrap();
        let joints = JointPath::resolve(&robot, site, &path, &Redundancy::near(&middle), 360).unwrap();
        tried += 1;
        match joints.first_unreached().map(|point| &point.cause) {
            None => {
                followed += 1;
                for k in 0..360 {
                    let phase = f64::from(k).to_radians();
                    let place = end_point(&robot, &joints.pose(phase));
                    assert!(off([true; 3], place, path.point(phase)) < 1e-9, "{seed} {k}");
                }
            }
            // Some place of the path cannot be reached from other rest poses either.
            Some(UnreachedCause::OutsideWorkspace | UnreachedCause::JointRanges(_)) => {
                let unreachable = (0..12).any(|k| {
                    let place = path.point(f64::from(30 * k).to_radians());
                    let rests = (0..2).map(|_| pose_within(&mut random, &ranges));
                    rests
                        .map(|rest| resolve(&robot, [true; 3], place, &rest))
                        .all(|one| one.first_unreached().is_some())
                });
                assert!(unreachable, "{seed}: {}", joints.first_unreached().unwrap());
                beyond += 1;
            }
            Some(_) => eprintln!("{seed} {kind:?} {}: {}", ranges.len(), joints.first_unreached().unwrap()),
        }
    }
    eprintln!("{followed} followed, {beyond} beyond reach, of {tried}");
    assert!((followed + beyond) * 20 >= tried * 19, "{followed} {beyond} of {tried}");
    assert!(followed * 2 > tried);
}
