//! Springs and dry friction of joints, and what is found by its name.

use super::robots::{Random, parts};
use sinew::body::{Actuator, ActuatorKind, Body, Joint, JointKind, Parts, Poses, Robot, Scratch};

/// A free body that carries another one on a joint of this kind, both with springs.
fn sprung(kind: JointKind, random: &mut Random) -> Robot {
    let mut unit = || {
        let raw: [f64; 4] = core::array::from_fn(|_| random.next());
        let length = raw.iter().map(|x| x * x).sum::<f64>().sqrt();
        raw.map(|x| x / length)
    };
    let (one, two) = (unit(), unit());
    let body = |name: &str, parent: usize, orientation: [f64; 4]| Body {
        name: name.into(),
        parent,
        position: [0.1, -0.2, 0.3],
        orientation,
        mass: 1.0,
        center_of_mass: [0.0; 3],
        inertia: [0.1, 0.1, 0.1, 0.0, 0.0, 0.0],
        gravity_compensation: 0.0,
    };
    let joint = |name: &str, body: usize, kind: JointKind| Joint {
        name: name.into(),
        body,
        kind,
        anchor: [0.0; 3],
        axis: [0.6, 0.0, 0.8],
        reference: 0.0,
        range: None,
        armature: 0.0,
        damping: 0.7,
        friction: 0.4 + body as f64,
        stiffness: 3.0,
        spring_reference: 0.2,
        flex: 0.0,
    };
    let world =
        Body { mass: 0.0, position: [0.0; 3], inertia: [0.0; 6], ..body("world", 0, [1.0, 0.0, 0.0, 0.0]) };
    let bodies = vec![world, body("one", 0, one), body("two", 1, two)];
    let joints = vec![joint("free", 1, JointKind::Free), joint("next", 2, kind)];
    Robot::new(Parts { name: "sprung".into(), bodies, joints, gravity: [0.0; 3], ..Parts::default() })
        .unwrap()
}

fn energy(robot: &Robot, q: &[f64]) -> f64 {
    let mut poses = Poses::new(robot);
    robot.forward_kinematics(q, &mut poses).unwrap();
    robot.potential_energy(q, &poses).unwrap()
}

#[test]
fn springs_push_down_the_slope_of_their_energy_and_rest_where_they_are_relaxed() {
    let mut random = Random(21);
    for kind in [JointKind::Hinge, JointKind::Slide, JointKind::Ball] {
        for _ in 0..20 {
            let robot = sprung(kind, &mut random);
            let mut q = robot.reference_pose();
            let zero = vec![0.0; robot.nv()];
            let mut tau = zero.clone();
            if matches!(kind, JointKind::Hinge | JointKind::Slide) {
                q[robot.coordinates_of(1)][0] = 0.2;
            }
            robot.passive_force(&q, &zero, &mut tau).unwrap();
            assert!(tau.iter().all(|tau| tau.abs() < 1e-12), "{kind:?} at rest: {tau:?}");
            assert!(energy(&robot, &q).abs() < 1e-20);

            let away: Vec<f64> = zero.iter().map(|_| random.next()).collect();
            robot.integrate(&mut q, &away, 1.0).unwrap();
            robot.passive_force(&q, &zero, &mut tau).unwrap();
            assert!(energy(&robot, &q) > 0.0);
            for k in 0..robot.nv() {
                let beside = |step: f64| {
                    let (mut beside, mut v) = (q.clone(), zero.clone());
                    v[k] = 1.0;
                    robot.integrate(&mut beside, &v, step).unwrap();
                    energy(&robot, &beside)
                };
                let slope = (beside(1e-5) - beside(-1e-5)) / 2e-5;
                assert!((tau[k] + slope).abs() < 1e-7, "{kind:?} {k}: {} {slope}", tau[k]);
            }
            // Dampers add to it.
            let mut damped = tau.clone();
            robot.passive_force(&q, &away, &mut damped).unwrap();
            for ((damped, tau), v) in damped.iter().zip(&tau).zip(&away) {
                assert!((damped - (tau - 0.7 * v)).abs() < 1e-12);
            }
        }
    }
}

#[test]
fn parts_are_found_by_their_names_and_joints_by_their_velocities() {
    let robot = Robot::new(parts("lm_arm")).unwrap();
    for (k, part) in robot.parts().bodies.iter().enumerate() {
        assert_eq!(robot.body(&part.name), Some(k));
    }
    for (k, part) in robot.parts().joints.iter().enumerate() {
        assert_eq!(robot.joint(&part.name), Some(k));
        for v in robot.velocities_of(k) {
            assert_eq!(robot.joint_of_velocity(v), Some(k));
        }
    }
    for (k, part) in robot.parts().sites.iter().enumerate() {
        assert_eq!(robot.site(&part.name), Some(k));
    }
    for (k, part) in robot.parts().tendons.iter().enumerate() {
        assert_eq!(robot.tendon(&part.name), Some(k));
    }
    for name in ["", "no such part"] {
        assert_eq!(
            (robot.body(name), robot.joint(name), robot.site(name), robot.tendon(name)),
            (None, None, None, None)
        );
    }
    assert_eq!(robot.joint_of_velocity(robot.nv()), None);
    let mixed = sprung(JointKind::Ball, &mut Random(23));
    assert_eq!((mixed.velocities_of(0), mixed.velocities_of(1)), (0..6, 6..9));
    assert_eq!((mixed.coordinates_of(0), mixed.coordinates_of(1)), (0..7, 7..11));
    let joints: Vec<_> = (0..10).map(|v| mixed.joint_of_velocity(v)).collect();
    assert_eq!(joints, [vec![Some(0); 6], vec![Some(1); 3], vec![None]].concat());
}

#[test]
fn units_are_those_of_the_kind() {
    for kind in [JointKind::Hinge, JointKind::Ball, JointKind::Free] {
        assert_eq!((kind.unit(), kind.torque_unit()), ("rad", "N m"));
    }
    assert_eq!((JointKind::Slide.unit(), JointKind::Slide.torque_unit()), ("m", "N"));
}

#[test]
fn the_ranges_of_an_actuator_limit_the_tension_of_its_cable() {
    let actuator = |kind, control_range, force_range| Actuator {
        name: "a".into(),
        kind,
        tendon: 0,
        gear: -2.0,
        control_range,
        force_range,
        law: Default::default(),
    };
    let largest = |kind, control, force| actuator(kind, control, force).largest_tension();
    let close = |found: Option<f64>, desired: f64| (found.unwrap() - desired).abs() < 1e-12;
    assert!(close(largest(ActuatorKind::Motor, Some([-30.0, 10.0]), None), 60.0));
    assert!(close(largest(ActuatorKind::Motor, Some([-30.0, 10.0]), Some([0.0, 20.0])), 40.0));
    assert!(close(largest(ActuatorKind::Muscle, Some([0.0, 1.0]), Some([-50.0, 0.0])), 100.0));
    assert_eq!(largest(ActuatorKind::Muscle, Some([0.0, 1.0]), None), None);
    assert_eq!(largest(ActuatorKind::Motor, None, None), None);
}

#[test]
fn inertias_are_accepted_in_every_orientation_up_to_the_limit_of_a_flat_body() {
    let mut random = Random(24);
    for _ in 0..200 {
        // Columns of a rotation, from a random quaternion.
        let raw: [f64; 4] = core::array::from_fn(|_| random.next());
        let length = raw.iter().map(|x| x * x).sum::<f64>().sqrt();
        let [w, x, y, z] = raw.map(|x| x / length);
        let rotation = [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ];
        let (a, b) = (1.5 + random.next(), 1.5 + random.next());
        let accepted = |moments: [f64; 3]| {
            let entry = |i: usize, j: usize| {
                (0..3).map(|k| rotation[i][k] * moments[k] * rotation[j][k]).sum::<f64>()
            };
            let mut parts = parts("lm_arm");
            parts.bodies[3].inertia =
                [entry(0, 0), entry(1, 1), entry(2, 2), entry(0, 1), entry(0, 2), entry(1, 2)];
            Robot::new(parts).is_ok()
        };
        assert!(accepted([a, b, a + b - 1e-6]));
        assert!(!accepted([a, b, a + b + 1e-6]));
        assert!(accepted([a, a, 0.0]));
        assert!(!accepted([a, a, -1e-6]));
    }
}

#[test]
fn actuators_that_make_no_sense_are_refused() {
    let refused = |change: &dyn Fn(&mut Actuator)| {
        let mut parts = parts("lm_arm");
        let mut actuator = Actuator {
            name: "motor".into(),
            kind: ActuatorKind::Motor,
            tendon: 0,
            gear: 1.0,
            control_range: Some([0.0, 1.0]),
            force_range: None,
            law: [("gainprm".to_string(), "1".to_string())].into(),
        };
        change(&mut actuator);
        parts.actuators = vec![actuator];
        Robot::new(parts).err().map(|error| error.to_string())
    };
    assert_eq!(refused(&|_| ()), None);
    for (change, named) in [
        (&(|a: &mut Actuator| a.tendon = 99) as &dyn Fn(&mut Actuator), "its tendon"),
        (&|a| a.gear = f64::NAN, "its gear"),
        (&|a| a.control_range = Some([1.0, 0.0]), "its control range"),
        (&|a| a.force_range = Some([f64::NAN, 0.0]), "its force range"),
        (&|a| a.law = [("Gain".to_string(), "1".to_string())].into(), "a name in its law"),
        (&|a| a.law = [(String::new(), "1".to_string())].into(), "a name in its law"),
        (&|a| a.law = [("gain".to_string(), "1\u{7}".to_string())].into(), "its law"),
    ] {
        let message = refused(change).unwrap();
        assert!(message.contains("actuator `motor`") && message.contains(named), "{message}");
    }
}

#[test]
fn directions_that_are_nearly_unit_are_normalised_and_others_are_refused() {
    let with = |length: f64| {
        let mut parts = parts("lm_arm");
        parts.joints[0].axis = [0.6 * length, 0.0, 0.8 * length];
        Robot::new(parts)
    };
    for length in [1.0, 1.0 + 1e-14, 1.0005, 0.9995] {
        let axis = with(length).unwrap().parts().joints[0].axis;
        assert!((axis.iter().map(|x| x * x).sum::<f64>() - 1.0).abs() < 4e-16, "{length}: {axis:?}");
    }
    for length in [1.0015, 0.9985, 2.0, 0.0] {
        assert!(with(length).is_err(), "{length}");
    }
}

#[test]
fn frames_and_motion_axes_are_those_of_small_motions() {
    let mut random = Random(25);
    for name in ["lm_arm", "random_0", "random_3"] {
        let robot = Robot::new(parts(name)).unwrap();
        let mut poses = Poses::new(&robot);
        for _ in 0..5 {
            let mut q = robot.reference_pose();
            let away: Vec<f64> = (0..robot.nv()).map(|_| random.next()).collect();
            robot.integrate(&mut q, &away, 0.7).unwrap();
            robot.forward_kinematics(&q, &mut poses).unwrap();
            for site in 0..robot.parts().sites.len() {
                let pose = robot.site_pose(&poses, site);
                // The quaternion turns the world's axes into the frame's.
                let [w, x, y, z] = pose.quaternion();
                let columns = [
                    [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)],
                    [2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)],
                    [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)],
                ];
                for (column, axis) in columns.iter().flatten().zip(pose.axes.iter().flatten()) {
                    assert!((column - axis).abs() < 1e-12, "{name}: {columns:?} {:?}", pose.axes);
                }
            }
            // A point of the last body moves by w x p + v.
            let site = robot.parts().sites.len() - 1;
            let point = robot.site_pose(&poses, site).origin;
            let axes = poses.motion_axes().to_vec();
            assert_eq!(axes.len(), robot.nv());
            for (k, axis) in axes.iter().enumerate() {
                let ([a, b, c], [x, y, z]) = (axis.angular, point);
                let turned = [b * z - c * y, c * x - a * z, a * y - b * x];
                let beside = |step: f64| {
                    let (mut beside, mut v) = (q.clone(), vec![0.0; robot.nv()]);
                    v[k] = 1.0;
                    robot.integrate(&mut beside, &v, step).unwrap();
                    let mut poses = Poses::new(&robot);
                    robot.forward_kinematics(&beside, &mut poses).unwrap();
                    robot.site_pose(&poses, site).origin
                };
                let (ahead, behind) = (beside(1e-6), beside(-1e-6));
                for i in 0..3 {
                    let speed = (ahead[i] - behind[i]) / 2e-6;
                    let moved = turned[i] + axis.linear[i];
                    // A joint that does not carry the point does not move it.
                    assert!(
                        (moved - speed).abs() < 1e-7 || speed.abs() < 1e-9,
                        "{name} {k}: {moved} {speed}"
                    );
                }
            }
        }
    }
}

#[test]
fn the_difference_of_two_poses_undoes_an_integration() {
    let mut random = Random(26);
    for kind in [JointKind::Hinge, JointKind::Slide, JointKind::Ball] {
        let robot = sprung(kind, &mut random);
        for _ in 0..20 {
            let mut from = robot.reference_pose();
            let away: Vec<f64> = (0..robot.nv()).map(|_| 2.0 * random.next()).collect();
            robot.integrate(&mut from, &away, 1.0).unwrap();
            let v: Vec<f64> = (0..robot.nv()).map(|_| random.next()).collect();
            let (mut to, mut found) = (from.clone(), vec![0.0; robot.nv()]);
            robot.integrate(&mut to, &v, 0.5).unwrap();
            robot.difference(&from, &to, &mut found).unwrap();
            for (found, v) in found.iter().zip(&v) {
                assert!((found - 0.5 * v).abs() < 1e-12, "{kind:?}: {found} {v}");
            }
        }
    }
}

#[test]
fn a_point_mass_adds_the_energy_of_its_own_motion() {
    let mut random = Random(27);
    for name in ["lm_arm", "random_1", "random_4"] {
        let robot = Robot::new(parts(name)).unwrap();
        let body = robot.parts().bodies.len() - 1;
        let position = [0.1, -0.2, 0.15];
        let loaded = robot.with_payload(body, position, 1.7).unwrap();
        let (mut poses, mut scratch) = (Poses::new(&robot), Scratch::new(&robot));
        for _ in 0..10 {
            let mut q = robot.reference_pose();
            let away: Vec<f64> = (0..robot.nv()).map(|_| random.next()).collect();
            let v: Vec<f64> = (0..robot.nv()).map(|_| random.next()).collect();
            robot.integrate(&mut q, &away, 0.6).unwrap();
            robot.forward_kinematics(&q, &mut poses).unwrap();
            let point = robot.body_pose(&poses, body).point(position);
            let (mut linear, mut angular) = (vec![0.0; 3 * robot.nv()], vec![0.0; 3 * robot.nv()]);
            robot.jacobian(&poses, body, point, &mut linear, &mut angular).unwrap();
            let speed = |row: &[f64]| row.iter().zip(&v).map(|(a, v)| a * v).sum::<f64>();
            let square: f64 = linear.chunks_exact(robot.nv()).map(|row| speed(row).powi(2)).sum();
            let before = robot.kinetic_energy(&q, &v, &mut scratch).unwrap();
            let after = loaded.kinetic_energy(&q, &v, &mut scratch).unwrap();
            assert!((after - before - 0.5 * 1.7 * square).abs() < 1e-11 * after, "{name}");
            // The same by the velocity of another point of the body and its rate of turn.
            let other = robot.body_pose(&poses, body).point([0.3, 0.1, -0.2]);
            let mut shifted = vec![0.0; 3 * robot.nv()];
            robot.jacobian(&poses, body, other, &mut shifted, &mut angular).unwrap();
            let [w, moved]: [[f64; 3]; 2] = [&angular, &shifted]
                .map(|rows| core::array::from_fn(|i| speed(&rows[i * robot.nv()..(i + 1) * robot.nv()])));
            let arm: [f64; 3] = core::array::from_fn(|i| point[i] - other[i]);
            let turned =
                [w[1] * arm[2] - w[2] * arm[1], w[2] * arm[0] - w[0] * arm[2], w[0] * arm[1] - w[1] * arm[0]];
            let same: f64 = moved.iter().zip(turned).map(|(v, t)| (v + t).powi(2)).sum();
            assert!((same - square).abs() < 1e-11 * (1.0 + square), "{name}: {same} {square}");
        }
    }
}
