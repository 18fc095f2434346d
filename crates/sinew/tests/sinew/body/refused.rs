//! Descriptions and calls that make no sense are refused, and the part is named.

use super::robots::{parts, robot};
use sinew::Error;
use sinew::body::{
    Coupling, JointKind, Key, Parts, PathElement, Poses, Reduction, Robot, Scratch, TendonPath,
};
use sinew::muscle::{Geometry, Muscles};

/// What `Robot::new` says to the arm after `change`.
fn told(change: impl FnOnce(&mut Parts)) -> String {
    let mut parts = parts("lm_arm");
    change(&mut parts);
    Robot::new(parts).unwrap_err().to_string()
}

#[test]
fn every_part_that_makes_no_sense_is_named_with_what_was_expected() {
    let spatial =
        |parts: &mut Parts, elements: Vec<PathElement>| parts.tendons[2].path = TendonPath::Spatial(elements);
    let couple = |follower, leader| Coupling {
        follower,
        leader,
        coefficients: [0.0, 1.0, 0.0, 0.0, 0.0],
        pieces: Vec::new(),
    };
    let (site, wrap) = (PathElement::Site, |wrap| PathElement::Wrap { wrap, side: None });
    type Change<'a> = Box<dyn FnOnce(&mut Parts) + 'a>;
    let cases: Vec<(Change, &str)> = vec![
        (Box::new(|p| p.gravity[1] = f64::NAN), "robot `golden`: gravity must be finite, but is NaN"),
        (Box::new(|p| p.bodies.clear()), "at least the world"),
        (
            Box::new(|p| p.bodies[3].mass = -1.0),
            "body `ulna`: its mass must be a finite number >= 0, but is -1",
        ),
        (Box::new(|p| p.bodies[3].inertia[0] = 1.0), "no principal moment above the sum of the two others"),
        (
            Box::new(|p| p.bodies[3].inertia = [-1.0, 1.0, 1.0, 0.0, 0.0, 0.0]),
            "without negative principal moments",
        ),
        (Box::new(|p| p.bodies[3].inertia[4] = f64::INFINITY), "body `ulna`: its inertia must be finite"),
        (Box::new(|p| p.bodies[3].parent = 3), "body `ulna`: its parent must be a body before it, but is 3"),
        (
            Box::new(|p| p.bodies[3].orientation = [0.0; 4]),
            "body `ulna`: its orientation must be of unit length",
        ),
        (Box::new(|p| p.bodies[3].name = "hand".into()), "body `hand`: its name must be its own"),
        (Box::new(|p| p.joints[3].axis = [0.0; 3]), "joint `elbow_flexion`: its axis must be of unit length"),
        (
            Box::new(|p| p.joints[3].range = Some([1.0, -1.0])),
            "joint `elbow_flexion`: its range must be a low end",
        ),
        (Box::new(|p| p.joints[3].range = Some([f64::NAN, 1.0])), "joint `elbow_flexion`: its range"),
        (Box::new(|p| p.joints[3].body = 77), "joint `elbow_flexion`: its body must be below 6"),
        (Box::new(|p| p.joints[3].body = 0), "one that moves"),
        (Box::new(|p| p.joints[3].damping = -0.1), "joint `elbow_flexion`: its damping"),
        (Box::new(|p| p.joints[3].kind = JointKind::Free), "a child of the world, as the joint is free"),
        (Box::new(|p| p.joints[0].kind = JointKind::Ball), "without another turn after a ball"),
        (
            Box::new(|p| p.wraps[0].radius = 0.0),
            "wrap `humeral_head`: its radius must be a finite number > 0",
        ),
        (Box::new(|p| p.sites[4].body = 9), "its body must be below 6"),
        (
            Box::new(|p| spatial(p, vec![site(0)])),
            "tendon `deltoid_posterior`: its path must be through at least two",
        ),
        (Box::new(|p| spatial(p, vec![])), "through at least two sites, in each branch"),
        (Box::new(|p| spatial(p, vec![site(0), wrap(0)])), "a site before and after every wrap"),
        (Box::new(|p| spatial(p, vec![wrap(0), site(0), site(1)])), "a site before and after every wrap"),
        (Box::new(|p| spatial(p, vec![site(0), wrap(99), site(1)])), "a wrap of its path must be below"),
        (Box::new(|p| spatial(p, vec![site(0), site(999)])), "a site of its path must be below"),
        (
            Box::new(|p| spatial(p, vec![site(0), site(1), PathElement::Pulley(0.0), site(2), site(3)])),
            "the divisor of its pulley must be a finite number > 0",
        ),
        (
            Box::new(|p| spatial(p, vec![site(0), site(1), PathElement::Pulley(2.0), site(2)])),
            "its path must be through at least two sites",
        ),
        (Box::new(|p| p.tendons[2].path = TendonPath::Fixed(vec![])), "a sum of at least one joint"),
        (Box::new(|p| p.tendons[2].path = TendonPath::Fixed(vec![(1, 1.0), (1, 1.0)])), "named once"),
        (
            Box::new(|p| p.couplings = vec![couple(1, Some(2)), couple(2, Some(1))]),
            "independent of its follower",
        ),
        (Box::new(|p| p.couplings = vec![couple(1, Some(1))]), "independent of its follower"),
        (
            Box::new(|p| p.couplings = vec![couple(1, Some(2)), couple(1, None)]),
            "a joint that follows nothing else",
        ),
        (Box::new(|p| p.couplings = vec![couple(1, Some(22))]), "its leader must be below 7"),
        (
            Box::new(|p| p.keys = vec![Key { name: "rest".into(), q: vec![0.0; 6] }]),
            "key `rest`: its number of coordinates must be 7, but is 6",
        ),
    ];
    for (change, expected) in cases {
        let message = told(change);
        assert!(message.contains(expected), "{message}\n  should contain: {expected}");
    }
}

#[test]
fn directions_that_are_unit_but_for_rounding_are_made_so() {
    let mut parts = parts("lm_arm");
    parts.joints[3].axis = [0.0, -1.000_01, 0.0];
    parts.bodies[3].orientation = [0.600_01, 0.8, 0.0, 0.0];
    let robot = Robot::new(parts).unwrap();
    assert!((robot.parts().joints[3].axis[1] + 1.0).abs() < 1e-15);
    let length: f64 = robot.parts().bodies[3].orientation.iter().map(|x| x * x).sum();
    assert!((length - 1.0).abs() < 1e-15);
}

#[test]
fn wrong_lengths_and_numbers_that_are_not_finite_pass_no_boundary() {
    let arm = robot("lm_arm");
    let (mut scratch, mut poses) = (Scratch::new(&arm), Poses::new(&arm));
    let (q, mut out) = ([0.0; 7], [0.0; 7]);
    let muscles = Muscles::new(&arm);
    let mut geometry = Geometry::new(&arm, &muscles);
    let wrong =
        |result: Result<(), Error>| assert!(matches!(result, Err(Error::WrongLength { .. })), "{result:?}");
    let outside = |result: Result<(), Error>| {
        assert!(
            matches!(result, Err(Error::OutOfDomain { .. } | Error::EntryOutOfDomain { .. })),
            "{result:?}"
        );
    };
    wrong(arm.forward_kinematics(&q[..6], &mut poses));
    wrong(arm.inverse_dynamics(&q, &q[..6], &q, &mut scratch, &mut out));
    wrong(arm.inverse_dynamics(&q, &q, &q, &mut scratch, &mut out[..6]));
    wrong(arm.mass_matrix(&q, &mut scratch, &mut out));
    wrong(arm.forward_dynamics(&q, &q, &[], &mut scratch, &mut out));
    wrong(muscles.evaluate(&q[..3], &mut geometry));
    wrong(muscles.torque(&geometry, &q, &mut out));
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for k in 0..7 {
            let mut bent = q;
            bent[k] = bad;
            outside(arm.forward_kinematics(&bent, &mut poses));
            outside(arm.inverse_dynamics(&bent, &q, &q, &mut scratch, &mut out));
            outside(arm.inverse_dynamics(&q, &bent, &q, &mut scratch, &mut out));
            outside(arm.inverse_dynamics(&q, &q, &bent, &mut scratch, &mut out));
            outside(arm.forward_dynamics(&q, &q, &bent, &mut scratch, &mut out));
            outside(muscles.evaluate(&bent, &mut geometry));
        }
    }
    // Another robot's room.
    let finger = robot("finger");
    let mut other = Scratch::new(&finger);
    wrong(arm.inverse_dynamics(&q, &q, &q, &mut other, &mut out));
    wrong(arm.forward_kinematics(&q, &mut Poses::new(&finger)));
    wrong(muscles.evaluate(&q, &mut Geometry::new(&finger, &Muscles::new(&finger))));
    assert!(Reduction::new(&finger).update(&arm, &q).is_err());
    // Huge but finite numbers give an error, not an infinity.
    assert!(arm.inverse_dynamics(&q, &[1e300; 7], &q, &mut scratch, &mut out).is_err());
}

#[test]
fn ten_thousand_nested_bodies_are_no_trouble() {
    let mut parts = parts("chain7");
    let (body, joint) = (parts.bodies[1].clone(), parts.joints[0].clone());
    for k in parts.bodies.len()..10_000 {
        parts.bodies.push(sinew::body::Body { parent: k - 1, name: String::new(), ..body.clone() });
        parts.joints.push(sinew::body::Joint { body: k, name: String::new(), ..joint.clone() });
    }
    let robot = Robot::new(parts).unwrap();
    let (q, zero) = (robot.reference_pose(), vec![0.0; robot.nv()]);
    let mut tau = zero.clone();
    robot.inverse_dynamics(&q, &zero, &zero, &mut Scratch::new(&robot), &mut tau).unwrap();
    assert!(tau.iter().all(|tau| tau.is_finite()));
}

#[test]
fn inverse_dynamics_names_what_is_not_finite_wherever_it_stands() {
    for name in ["lm_arm", "finger", "random_0", "random_1", "random_2", "random_3", "random_4"] {
        names_what_is_not_finite(&robot(name));
    }
}

fn names_what_is_not_finite(robot: &Robot) {
    let mut scratch = Scratch::new(robot);
    let (nq, nv) = (robot.nq(), robot.nv());
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for (name, place) in (0..nq).map(|k| ("q", k)).chain((0..nv).flat_map(|k| [("v", k), ("a", k)])) {
            let (mut q, mut v, mut a) = (robot.reference_pose(), vec![0.0; nv], vec![0.0; nv]);
            match name {
                "q" => q[place] = bad,
                "v" => v[place] = bad,
                _ => a[place] = bad,
            }
            let error = robot.inverse_dynamics(&q, &v, &a, &mut scratch, &mut vec![0.0; nv]).unwrap_err();
            assert!(error.to_string().starts_with(name), "{name}[{place}] = {bad}: {error}");
        }
    }
}
