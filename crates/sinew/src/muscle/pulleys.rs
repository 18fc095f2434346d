use crate::body::{JointKind, Parts, Robot, Tendon, TendonPath};
use crate::error::{Error, positive, within};
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;

/// How many tendons of constant moment arms move a chain of `n` joints.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PulleyRouting {
    /// Two for every joint, on either side.
    Two,
    /// One for every joint and one more.
    OneMore,
}

/// A robot that is described by its joints alone, with tendons on pulleys.
///
/// ```text
/// 2n     R = [+r; -r]  of every joint
/// n + 1  tendon i:  R_ii = r,  R_ij = -r/(n - j) for j < i;   the last one R_nj = -r/(n - j)
/// ```
///
/// | symbol | argument | unit | domain | meaning                                                  |
/// |--------|----------|------|--------|----------------------------------------------------------|
/// | r      | `radius` | m    | > 0    | of every joint's largest pulley                           |
/// | n, i, j |         |      |        | joints of a chain, from the world on, counted from 0       |
///
/// With `n + 1` tendons every column of `R` adds up to zero: equal tensions move nothing, so that no tension
/// has to be above the others to keep them taut. A chain begins at a joint behind which no joint is the only
/// next one: fingers are chains, and the palm that carries them. Joints that follow others have no tendons; a
/// slide is pulled along. A tendon that pulls joint `J` the positive way is called `J_f`, the other one
/// `J_e`.
///
/// # Assumes
/// Tendons of a chain leave the joints before it alone.
///
/// # Errors
/// [`Error::OutOfDomain`] for a radius that is not positive, and for a robot that has tendons or joints of
/// more than one coordinate.
pub fn with_pulleys(robot: &Robot, radius: f64, routing: PulleyRouting) -> Result<Robot, Error> {
    positive("radius", radius)?;
    let mut parts = robot.parts().clone();
    let joints = robot.independent_joints();
    let tendons = parts.tendons.len() as f64;
    within("tendons", "none: pulleys are for a body of joints alone", tendons, tendons == 0.0)?;
    let single = |joint: &usize| matches!(parts.joints[*joint].kind, JointKind::Hinge | JointKind::Slide);
    let count = joints.len() as f64;
    within(
        "joints",
        "at least one, hinges and slides",
        count,
        !joints.is_empty() && joints.iter().all(single),
    )?;
    let arm = |joint: usize| if parts.joints[joint].kind == JointKind::Hinge { radius } else { 1.0 };
    let mut tendons = Vec::new();
    match routing {
        PulleyRouting::Two => {
            for &joint in &joints {
                tendons.push(tendon(name(&parts, joint, "f"), [(joint, arm(joint))]));
                tendons.push(tendon(name(&parts, joint, "e"), [(joint, -arm(joint))]));
            }
        }
        PulleyRouting::OneMore => {
            for chain in chains(&parts, &joints) {
                let n = chain.len();
                let passes = |j: usize| (chain[j], -arm(chain[j]) / (n - j) as f64);
                for (i, &joint) in chain.iter().enumerate() {
                    let arms = (0..i).map(passes).chain([(joint, arm(joint))]);
                    tendons.push(tendon(name(&parts, joint, "f"), arms));
                }
                tendons.push(tendon(name(&parts, chain[n - 1], "e"), (0..n).map(passes)));
            }
        }
    }
    parts.tendons = tendons;
    Ok(Robot::new(parts)?)
}

/// A tendon of these moment arms, m.
fn tendon(name: String, arms: impl IntoIterator<Item = (usize, f64)>) -> Tendon {
    Tendon {
        name,
        // It shortens where it pulls.
        path: TendonPath::Fixed(arms.into_iter().map(|(joint, arm)| (joint, -arm)).collect()),
        sheath: None,
        range: None,
        damping: 0.0,
        stiffness: 0.0,
        spring_length: None,
    }
}

fn name(parts: &Parts, joint: usize, side: &str) -> String {
    let name = &parts.joints[joint].name;
    let name = if name.is_empty() { format!("joint{joint}") } else { name.to_string() };
    format!("{name}_{side}")
}

/// Joints one behind the other, from the world on: the only next joint of another one continues its chain.
fn chains(parts: &Parts, joints: &[usize]) -> Vec<Vec<usize>> {
    // The joint before: in the same body the one listed before it, else the last one of a body before.
    let before = |joint: usize| {
        let mut body = parts.joints[joint].body;
        let own = joints.iter().copied().filter(|&other| other < joint && parts.joints[other].body == body);
        let mut found = own.max();
        while found.is_none() && body != 0 {
            body = parts.bodies[body].parent;
            found = joints.iter().copied().filter(|&other| parts.joints[other].body == body).max();
        }
        found
    };
    let previous: Vec<Option<usize>> = joints.iter().map(|&joint| before(joint)).collect();
    let mut chains: Vec<Vec<usize>> = Vec::new();
    for (&joint, &previous_joint) in joints.iter().zip(&previous) {
        let only = previous.iter().filter(|&&other| other == previous_joint).count() == 1;
        let end = chains
            .iter_mut()
            .find(|chain| previous_joint.is_some() && chain.last() == previous_joint.as_ref());
        match end {
            Some(chain) if only => chain.push(joint),
            _ => chains.push(Vec::from([joint])),
        }
    }
    chains
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::{Body, Joint};
    use crate::muscle::MuscleDynamics;
    use std::vec;

    /// A body with a hinge on each of these parents.
    fn tree(parents: &[usize]) -> Robot {
        let orientation = [1.0, 0.0, 0.0, 0.0];
        let body = |name: String, parent: usize, mass: f64| Body {
            name,
            parent,
            position: [0.03, 0.0, 0.0],
            orientation,
            mass,
            center_of_mass: [0.0; 3],
            inertia: [mass * 1e-4, mass * 1e-4, mass * 1e-4, 0.0, 0.0, 0.0],
            gravity_compensation: 0.0,
        };
        let joint = |k: usize| Joint {
            name: format!("j{k}"),
            body: k + 1,
            kind: JointKind::Hinge,
            anchor: [0.0; 3],
            axis: [0.0, 1.0, 0.0],
            reference: 0.0,
            range: Some([-0.5, 1.0]),
            armature: 0.0,
            damping: 0.0,
            friction: 0.0,
            stiffness: 0.0,
            spring_reference: 0.0,
            flex: 0.0,
        };
        let links = parents.iter().enumerate().map(|(k, parent)| body(format!("b{k}"), *parent, 0.02));
        let bodies = core::iter::once(body("world".into(), 0, 0.0)).chain(links).collect();
        let joints = (0..parents.len()).map(joint).collect();
        Robot::new(Parts { bodies, joints, ..Parts::default() }).unwrap()
    }

    /// Names of the tendons and their moment arms in a pose.
    fn arms(robot: &Robot, pose: f64) -> (Vec<String>, Vec<Vec<f64>>) {
        let mut dynamics = MuscleDynamics::new(robot).unwrap();
        let n = dynamics.joints();
        dynamics.evaluate(&vec![pose; n]).unwrap();
        let rows = dynamics.moment_arms().chunks_exact(n).map(<[f64]>::to_vec).collect();
        (robot.parts().tendons.iter().map(|tendon| tendon.name.clone()).collect(), rows)
    }

    #[test]
    fn two_tendons_a_joint_pull_it_either_way_by_the_radius_in_every_pose() {
        let robot = with_pulleys(&tree(&[0, 1]), 0.008, PulleyRouting::Two).unwrap();
        for pose in [-0.5, 0.0, 0.9] {
            let (names, rows) = arms(&robot, pose);
            assert_eq!(names, ["j0_f", "j0_e", "j1_f", "j1_e"]);
            assert_eq!(rows, [[0.008, 0.0], [-0.008, 0.0], [0.0, 0.008], [0.0, -0.008]]);
        }
    }

    #[test]
    fn one_tendon_more_than_joints_leaves_equal_tensions_without_a_torque() {
        for n in 1..=6 {
            let parents: Vec<usize> = (0..n).collect();
            let robot = with_pulleys(&tree(&parents), 0.01, PulleyRouting::OneMore).unwrap();
            let (names, rows) = arms(&robot, 0.3);
            assert_eq!((names.len(), names[n].clone()), (n + 1, format!("j{}_e", n - 1)));
            for j in 0..n {
                let sum: f64 = rows.iter().map(|row| row[j]).sum();
                assert!(sum.abs() < 1e-17, "{n} {j}: {sum}");
                assert!((rows[j][j] - 0.01).abs() < 1e-18 && rows[..j].iter().all(|row| row[j] == 0.0));
                assert!(rows[j + 1..].iter().all(|row| row[j] < 0.0));
            }
        }
    }

    #[test]
    fn fingers_on_a_wrist_are_chains_of_their_own() {
        // A wrist of two joints, two fingers of two joints and one.
        let robot = with_pulleys(&tree(&[0, 1, 2, 3, 2]), 0.01, PulleyRouting::OneMore).unwrap();
        let (names, rows) = arms(&robot, 0.0);
        assert_eq!(names, ["j0_f", "j1_f", "j1_e", "j2_f", "j3_f", "j3_e", "j4_f", "j4_e"]);
        assert!(rows[3..].iter().all(|row| row[0] == 0.0 && row[1] == 0.0), "{rows:?}");
        assert_eq!(rows[6], [0.0, 0.0, 0.0, 0.0, 0.01]);
    }

    #[test]
    fn a_radius_of_nothing_and_a_body_with_tendons_are_refused() {
        let robot = tree(&[0]);
        for radius in [0.0, -0.01, f64::NAN] {
            assert!(with_pulleys(&robot, radius, PulleyRouting::Two).is_err());
        }
        let routed = with_pulleys(&robot, 0.01, PulleyRouting::Two).unwrap();
        assert!(
            with_pulleys(&routed, 0.01, PulleyRouting::Two).unwrap_err().to_string().contains("joints alone")
        );
        let none =
            Robot::new(Parts { bodies: robot.parts().bodies[..1].to_vec(), ..Parts::default() }).unwrap();
        assert!(with_pulleys(&none, 0.01, PulleyRouting::Two).is_err());
    }
}
