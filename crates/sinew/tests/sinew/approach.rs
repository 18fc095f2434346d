//! The way to a motion's first pose.

use sinew::body::Robot;
use sinew::trajectory::{
    Approach, JointWaypoint, MinimumJerk, Reference, Trajectory, through_joint_waypoints,
};

/// Two hinges with ranges of 2 rad and of 0.5 rad.
fn robot() -> Robot {
    let text = sinew_models::PLANAR_LEG;
    let mut parts = sinew::description::from_toml("planar_leg.toml", text).unwrap().parts;
    parts.joints[0].range = Some([-1.0, 1.0]);
    parts.joints[1].range = Some([0.0, 0.5]);
    Robot::new(parts).unwrap()
}

fn motion() -> Trajectory {
    Trajectory::PointToPoint(MinimumJerk::new(&[0.2, 0.1], &[0.8, 0.1], 1.5).unwrap())
}

#[test]
fn a_joint_takes_a_quarter_of_the_pace_of_the_motion_whether_it_moves_in_it_or_not() {
    // 1.875 x 0.6 rad/1.5 s in a range of 2 rad.
    let pace = 0.25 * 0.375;
    for (standing, moved, range) in [([-0.8, 0.1], 1.0, 2.0), ([0.2, 0.5], 0.4, 0.5)] {
        let approach = Approach::new(&robot(), &motion(), &standing).unwrap();
        let expected = 1.875 * moved / (pace * range);
        assert!((approach.duration() / expected - 1.0).abs() < 1e-4, "{} {expected}", approach.duration());
        let (mut now, mut soon) = (Reference::new(2), Reference::new(2));
        approach.sample(0.5 * expected, 0.1, &mut now, &mut soon);
        let fastest = now.v.iter().map(|v| v.abs()).fold(0.0, f64::max);
        assert!((fastest / (pace * range) - 1.0).abs() < 1e-3, "{fastest}");
        approach.sample(expected, 0.1, &mut now, &mut soon);
        assert!(now.q.iter().zip([0.2, 0.1]).all(|(q, first)| (q - first).abs() < 1e-12));
    }
}

#[test]
fn it_begins_anew_wherever_the_machine_is_and_is_over_at_once_in_the_first_pose() {
    let mut approach = Approach::new(&robot(), &motion(), &[0.2, 0.1]).unwrap();
    assert!(approach.duration().abs() < 1e-18 && approach.motion().is_none());
    approach.begin(&[0.2, 0.1 + 1e-3]);
    assert!((approach.duration() - 1.0).abs() < 1e-12, "not shorter than a second");
    approach.begin(&[-0.7, 0.3]);
    let (mut now, mut soon) = (Reference::new(2), Reference::new(2));
    approach.sample(0.0, approach.duration(), &mut now, &mut soon);
    assert_eq!((&now.q[..], &now.v[..]), (&[-0.7, 0.3][..], &[0.0; 2][..]));
    assert!(soon.q.iter().zip([0.2, 0.1]).all(|(q, first)| (q - first).abs() < 1e-12));
    approach.rest(&mut now, &mut soon);
    assert_eq!((&now.q[..], &soon.q[..]), (&[-0.7, 0.3][..], &[-0.7, 0.3][..]));
}

#[test]
fn a_machine_that_is_found_nearly_where_it_is_taken_to_stand_is_taken_to_stand_there() {
    let mut approach = Approach::new(&robot(), &motion(), &[0.2, 0.1]).unwrap();
    let (mut now, mut soon) = (Reference::new(2), Reference::new(2));
    // 2 % of ranges of 2 rad and 0.5 rad.
    for (found, at, moved) in [
        ([0.239, 0.109], [0.2, 0.1], false),
        ([0.241, 0.1], [0.241, 0.1], true),
        ([0.2, 0.111], [0.2, 0.111], true),
        ([0.161, 0.091], [0.2, 0.1], false),
    ] {
        approach.found_at(&found);
        approach.rest(&mut now, &mut soon);
        assert_eq!(now.q, at, "{found:?}");
        assert_eq!(approach.motion().is_some(), moved, "{found:?}");
    }
}

#[test]
fn a_motion_that_stands_still_is_approached_too() {
    let still = |time| JointWaypoint { time, q: vec![0.2, 0.1] };
    let motion = through_joint_waypoints(&[still(0.0), still(1.0)]).unwrap();
    let approach = Approach::new(&robot(), &motion, &[0.5, 0.1]).unwrap();
    assert!((approach.duration() - 1.875 * 0.3 / (0.02 * 2.0)).abs() < 1e-9, "{}", approach.duration());
}
