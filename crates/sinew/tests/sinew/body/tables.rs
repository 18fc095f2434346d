//! Tables of Denavit and Hartenberg: a robot made of its own table moves alike.

use super::robots::Random;
use sinew::body::{Body, Joint, JointKind, Parts, Poses, Robot, Site};

/// A chain of hinges and slides with a site at its end, and every second one with parallel or intersecting axes.
fn chain(random: &mut Random, joints: usize) -> Robot {
    let unit = |random: &mut Random| {
        let raw: [f64; 4] = core::array::from_fn(|_| random.next());
        let length = raw.iter().map(|x| x * x).sum::<f64>().sqrt();
        raw.map(|x| x / length)
    };
    let world = Body {
        name: "world".into(),
        parent: 0,
        position: [0.0; 3],
        orientation: [1.0, 0.0, 0.0, 0.0],
        mass: 0.0,
        center_of_mass: [0.0; 3],
        inertia: [0.0; 6],
    };
    let mut parts = Parts { name: "chain".into(), bodies: vec![world.clone()], ..Parts::default() };
    for k in 0..joints {
        let special = random.next();
        // The axis is the link's z; the next link's frame decides whether two axes are parallel or meet.
        let orientation = if special > 0.4 { [1.0, 0.0, 0.0, 0.0] } else { unit(random) };
        let position = if special < -0.4 { [0.0; 3] } else { [random.next(), random.next(), random.next()] };
        parts.bodies.push(Body { name: format!("b{k}"), parent: k, position, orientation, ..world.clone() });
        parts.joints.push(Joint {
            name: format!("j{k}"),
            body: k + 1,
            kind: if random.next() > 0.3 { JointKind::Slide } else { JointKind::Hinge },
            anchor: [0.0; 3],
            axis: [0.0, 0.0, 1.0],
            reference: 0.3 * random.next(),
            range: None,
            armature: 0.0,
            damping: 0.0,
            friction: 0.0,
            stiffness: 0.0,
            spring_reference: 0.0,
        });
    }
    let position = [random.next(), random.next(), random.next()];
    parts.sites.push(Site { name: "end".into(), body: joints, position, orientation: [1.0, 0.0, 0.0, 0.0] });
    Robot::new(parts).unwrap()
}

fn end(robot: &Robot, q: &[f64]) -> [f64; 3] {
    let mut poses = Poses::new(robot);
    robot.forward_kinematics(q, &mut poses).unwrap();
    robot.site_pose(&poses, robot.site("end").unwrap()).origin
}

#[test]
fn a_robot_made_of_the_table_of_a_chain_moves_its_end_as_the_chain_does() {
    let mut random = Random(11);
    let mut kinds = [0; 2];
    for case in 0..300 {
        let robot = chain(&mut random, 1 + case % 6);
        let table = robot.dh_table(robot.site("end").unwrap()).unwrap();
        let parts = table.parts();
        assert!(parts.gravity.iter().zip([0.0, 0.0, -9.81]).all(|(g, wanted)| (g - wanted).abs() < 1e-12));
        let names: Vec<&str> = parts.bodies.iter().map(|body| body.name.as_str()).collect();
        assert_eq!(names[..2], ["world", "base"]);
        let same = Robot::new(parts).unwrap();
        for row in &table.rows {
            kinds[usize::from(row.kind == JointKind::Slide)] += 1;
        }
        for _ in 0..3 {
            let q: Vec<f64> = table.rows.iter().map(|_| 2.0 * random.next()).collect();
            for (one, other) in end(&robot, &q).iter().zip(end(&same, &q)) {
                assert!((one - other).abs() < 1e-12, "case {case}: {table:?}");
            }
        }
    }
    assert!(kinds.iter().all(|count| *count > 300), "{kinds:?}");
}

#[test]
fn common_normals_point_from_one_axis_to_the_next() {
    let mut random = Random(12);
    for case in 0..300 {
        let robot = chain(&mut random, 2 + case % 5);
        let table = robot.dh_table(0).unwrap();
        for row in &table.rows[1..] {
            assert!(row.a > -1e-12, "case {case}: {table:?}");
        }
    }
}

#[test]
fn parallel_axes_have_no_offset_between_them_and_a_turn_of_the_reference_is_part_of_the_angle() {
    // Two parallel hinges 0.3 m apart, and an end 0.2 m further: the planar arm of every textbook.
    let mut random = Random(13);
    let mut parts = chain(&mut random, 2).parts().clone();
    for (k, body) in parts.bodies.iter_mut().enumerate().skip(1) {
        body.orientation = [1.0, 0.0, 0.0, 0.0];
        body.position = [if k == 2 { 0.3 } else { 0.0 }, 0.0, if k == 2 { 0.1 } else { 0.0 }];
    }
    for joint in &mut parts.joints {
        (joint.kind, joint.reference) = (JointKind::Hinge, 0.25);
    }
    parts.sites[0].position = [0.2, 0.0, 0.05];
    let table = Robot::new(parts).unwrap().dh_table(0).unwrap();
    let row = table.rows[1];
    assert!((row.a - 0.3).abs() < 1e-12 && row.alpha.abs() < 1e-12, "{table:?}");
    assert!((table.rows[0].theta + 0.25).abs() < 1e-12 && (row.theta + 0.25).abs() < 1e-12, "{table:?}");
    assert!(table.rows[0].d.abs() < 1e-12, "{table:?}");
}
