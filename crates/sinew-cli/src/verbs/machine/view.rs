//! Poses of the page's three-dimensional view: the reference, the keys, each joint over its range.

use super::names::display_name;
use super::poses::apply_couplings;
use super::survey::{coupled_reference_pose, joint_range};
use crate::error::Error;
use crate::verbs::meshes::read_meshes;
use sinew::body::Robot;
use sinew::machine::Machine;
use sinew::muscle::MuscleDynamics;
use sinew_report::scene::{POINTS, SceneData, Scenery, Sweep};
use std::path::Path;

/// Minimum and maximum number of poses over the range of a joint.
const FRAMES: [usize; 2] = [5, 25];

/// The pose in which motions of a machine start, then what [`scene`] shows; with the shapes of mesh files
/// beside `path`.
pub(crate) fn machine_scene(machine: &Machine, path: &Path, root: Option<&Path>) -> Result<SceneData, Error> {
    let mut robot = machine.robot.clone();
    read_meshes(&mut robot, path, root);
    let mut model = MuscleDynamics::new(&robot)?;
    model.evaluate(&machine.start)?;
    posed(&robot, vec![("start".to_owned(), model.coordinates().to_vec())])
}

/// Reference and key poses by name, and each joint by itself over its range.
pub(super) fn scene(robot: &Robot) -> Result<SceneData, Error> {
    posed(robot, Vec::new())
}

fn posed(robot: &Robot, first: Vec<(String, Vec<f64>)>) -> Result<SceneData, Error> {
    let mut scenery = Scenery::new(robot);
    let mut scene = SceneData { fixed: Some(scenery.fixed()), ..SceneData::default() };
    for (name, q) in first {
        scene.poses.push((name, scenery.pose(&q)?));
    }
    let rest = coupled_reference_pose(robot);
    scene.poses.push(("reference".to_owned(), scenery.pose(&rest)?));
    for (index, key) in robot.parts().keys.iter().enumerate() {
        scene.poses.push((display_name("key", &key.name, index), scenery.pose(&key.q)?));
    }
    let joints = robot.parts().joints.len();
    let points = scenery.points() + 3 * robot.parts().bodies.len();
    let count = (POINTS / (points * joints).max(1)).clamp(FRAMES[0], FRAMES[1]);
    for joint in 0..joints {
        let follows = robot.parts().couplings.iter().any(|coupling| coupling.follower == joint);
        let Some([low, high]) = joint_range(robot, joint).filter(|_| !follows) else { continue };
        let part = &robot.parts().joints[joint];
        let name = display_name("joint", &part.name, joint);
        let mut sweep = Sweep { name, unit: part.kind.unit().to_owned(), at: Vec::new(), frames: Vec::new() };
        for k in 0..count {
            let mut q = rest.clone();
            #[expect(clippy::cast_precision_loss, reason = "a few dozen frames")]
            let value = low + k as f64 / (count - 1) as f64 * (high - low);
            q[robot.coordinates_of(joint).start] = value;
            apply_couplings(robot, &[], &mut q);
            sweep.at.push(value);
            sweep.frames.push(scenery.pose(&q)?);
        }
        scene.sweeps.push(sweep);
    }
    Ok(scene)
}
