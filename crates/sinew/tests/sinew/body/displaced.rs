//! Joints away from their drawing, and links that bend.

use sinew::body::{Displacement, Poses, Robot, Site};
use sinew::random::Random;

type Matrix = [[f64; 3]; 3];
/// A rotation and a translation.
type Rigid = (Matrix, [f64; 3]);

const HERE: Rigid = ([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], [0.0; 3]);

/// The arm of the repository, whose shoulder has three joints.
fn arm() -> Robot {
    let text = sinew_models::LM_ARM;
    Robot::new(sinew::description::from_toml("lm_arm.toml", text).unwrap().parts).unwrap()
}

fn tip(robot: &Robot, q: &[f64]) -> [f64; 3] {
    let mut poses = Poses::new(robot);
    robot.forward_kinematics(q, &mut poses).unwrap();
    robot.site_pose(&poses, robot.site("endpoint").unwrap()).origin
}

fn rotated(a: &Matrix, v: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| (0..3).map(|k| a[i][k] * v[k]).sum())
}

fn after(a: &Rigid, b: &Rigid) -> Rigid {
    let turned = rotated(&a.0, b.1);
    let product = |i: usize, j: usize| (0..3).map(|k| a.0[i][k] * b.0[k][j]).sum();
    (
        std::array::from_fn(|i| std::array::from_fn(|j| product(i, j))),
        std::array::from_fn(|i| a.1[i] + turned[i]),
    )
}

fn of_quaternion([w, x, y, z]: [f64; 4]) -> Matrix {
    [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
}

/// By an angle about a unit axis.
fn about(axis: [f64; 3], angle: f64) -> Matrix {
    let (sine, cosine) = (0.5 * angle).sin_cos();
    of_quaternion([cosine, sine * axis[0], sine * axis[1], sine * axis[2]])
}

/// The frame with an axis as z whose x is nearest to the axis of the body that is most across.
fn frame_about(z: [f64; 3]) -> Matrix {
    let most = (0..3).min_by(|&i, &j| z[i].abs().total_cmp(&z[j].abs())).unwrap();
    let across: [f64; 3] = std::array::from_fn(|i| f64::from(u8::from(i == most)) - z[most] * z[i]);
    let length = across.iter().map(|x| x * x).sum::<f64>().sqrt();
    let x = across.map(|part| part / length);
    let y = [z[1] * x[2] - z[2] * x[1], z[2] * x[0] - z[0] * x[2], z[0] * x[1] - z[1] * x[0]];
    std::array::from_fn(|i| [x[i], y[i], z[i]])
}

fn inverse(a: &Rigid) -> Rigid {
    let transposed: Matrix = std::array::from_fn(|i| std::array::from_fn(|j| a.0[j][i]));
    (transposed, rotated(&transposed, a.1).map(|x| -x))
}

#[test]
fn displaced_joints_move_the_tip_as_the_product_of_their_frames_does() {
    let robot = arm();
    let mut random = Random::new(3);
    for _ in 0..50 {
        let mut draw = |size: f64| size * (2.0 * random.unit() - 1.0);
        let parts = robot.parts();
        let errors: Vec<Displacement> = parts
            .joints
            .iter()
            .map(|_| Displacement {
                offset: std::array::from_fn(|_| draw(0.01)),
                tilt: std::array::from_fn(|_| draw(0.1)),
            })
            .collect();
        let q: Vec<f64> = (0..robot.nq()).map(|_| draw(0.6)).collect();
        let site = &parts.sites[robot.site("endpoint").unwrap()];
        let (mut at, mut joint) = (HERE, 0);
        // The arm is one chain: every body hangs on the one before.
        for (index, body) in parts.bodies.iter().enumerate().take(site.body + 1).skip(1) {
            assert_eq!(body.parent, index - 1);
            at = after(&at, &(of_quaternion(body.orientation), body.position));
            while parts.joints.get(joint).is_some_and(|next| next.body == index) {
                let part = &parts.joints[joint];
                let own = (frame_about(part.axis), part.anchor);
                let Displacement { offset, tilt: [x, y] } = errors[joint];
                let tilt = x.hypot(y);
                at = after(&at, &own);
                at = after(&at, &(about([x / tilt, y / tilt, 0.0], tilt), offset));
                at = after(&at, &(about([0.0, 0.0, 1.0], q[joint] - part.reference), [0.0; 3]));
                at = after(&at, &inverse(&own));
                joint += 1;
            }
        }
        let turned = rotated(&at.0, site.position);
        let found = tip(&Robot::new(parts.displaced(&errors)).unwrap(), &q);
        let expected: [f64; 3] = std::array::from_fn(|i| at.1[i] + turned[i]);
        assert!((0..3).all(|k| (found[k] - expected[k]).abs() < 1e-12), "{found:?} {expected:?}");
    }
}

/// Distance of a site from the axis of a cylinder.
fn from_axis(robot: &Robot, q: &[f64], site: &str, wrap: &str) -> f64 {
    let parts = robot.parts();
    let wrap = parts.wraps.iter().find(|part| part.name == wrap).unwrap();
    let mut poses = Poses::new(robot);
    robot.forward_kinematics(q, &mut poses).unwrap();
    // Two points of its axis as sites of its body.
    let mut with_ends = parts.clone();
    let axes = of_quaternion(wrap.orientation);
    for (name, along) in [("end_0", 0.0), ("end_1", 1.0)] {
        let position = std::array::from_fn(|i| wrap.position[i] + along * axes[i][2]);
        with_ends.sites.push(Site { name: name.into(), body: wrap.body, position, ..parts.sites[0].clone() });
    }
    let robot = Robot::new(with_ends).unwrap();
    let at = |name: &str| robot.site_pose(&poses, robot.site(name).unwrap()).origin;
    let [foot, end, point] = ["end_0", "end_1", site].map(at);
    let [axis, to] = [end, point].map(|of| -> [f64; 3] { std::array::from_fn(|i| of[i] - foot[i]) });
    let along: f64 = (0..3).map(|i| axis[i] * to[i]).sum();
    (to.iter().map(|x| x * x).sum::<f64>() - along * along).sqrt()
}

#[test]
fn a_pulley_on_the_shaft_of_a_displaced_joint_stays_on_it_so_that_no_attachment_gets_inside() {
    let text = sinew_models::PLANAR_LEG;
    let parts = sinew::description::from_toml("planar_leg.toml", text).unwrap().parts;
    let design = Robot::new(parts.clone()).unwrap();
    let mut random = Random::new(5);
    for _ in 0..20 {
        let mut draw = |size: f64| size * (2.0 * random.unit() - 1.0);
        let errors: Vec<Displacement> = (0..2)
            .map(|_| Displacement {
                offset: std::array::from_fn(|_| draw(3e-3)),
                tilt: std::array::from_fn(|_| draw(8e-3)),
            })
            .collect();
        let built = Robot::new(parts.displaced(&errors)).unwrap();
        for q in [[-0.4, 0.1], [0.4, 1.0], [1.0, 1.9]] {
            for (site, wrap) in [
                ("rectus_femoris_i", "knee_drum"),
                ("hamstrings_i", "knee_drum"),
                ("hip_flexor_i", "hip_drum"),
            ] {
                let [drawn, found] = [&design, &built].map(|robot| from_axis(robot, &q, site, wrap));
                assert!((found - drawn).abs() < 1e-12, "{site} {q:?}: {found} for {drawn}");
            }
        }
    }
}

#[test]
fn no_displacement_and_no_flex_change_no_bit() {
    let robot = arm();
    let still = vec![Displacement::default(); robot.parts().joints.len()];
    assert_eq!(&robot.parts().displaced(&still), robot.parts());
    let (mut rigid, mut bent) = (Poses::new(&robot), Poses::new(&robot));
    let q = vec![0.3; robot.nq()];
    robot.forward_kinematics(&q, &mut rigid).unwrap();
    robot.bent_kinematics(&q, &mut bent).unwrap();
    assert_eq!(rigid, bent);
}

#[test]
fn a_link_that_bends_sinks_and_by_the_product_of_flex_moment_and_arm() {
    let robot = arm();
    let q = vec![0.3; robot.nq()];
    let mut poses = Poses::new(&robot);
    let mut height = |flex: f64| {
        let mut parts = robot.parts().clone();
        parts.joints.iter_mut().for_each(|joint| joint.flex = flex);
        let robot = Robot::new(parts).unwrap();
        robot.bent_kinematics(&q, &mut poses).unwrap();
        robot.site_pose(&poses, robot.site("endpoint").unwrap()).origin[2]
    };
    let (rigid, soft, softer) = (height(0.0), height(1e-4), height(2e-4));
    assert!(
        soft < rigid && ((rigid - softer) / (rigid - soft) - 2.0).abs() < 0.02,
        "{rigid} {soft} {softer}"
    );
}
