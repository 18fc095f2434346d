//! Data of the page's three-dimensional view: bones, cable paths and wrapping surfaces in every pose that can
//! be shown.

use super::model::display_name;
use super::poses::apply_couplings;
use super::survey::{coupled_reference_pose, joint_range};
use crate::error::Error;
use serde_json::{Value, json};
use sinew::body::{Poses, Robot, WrapKind};
use sinew::muscle::{Geometry, Muscles};

/// Minimum and maximum number of poses over the range of a joint.
const FRAMES: [usize; 2] = [5, 25];
/// Angle between two points of an arc, rad.
const ARC_STEP: f64 = 0.2;
/// Upper bound of the points of all poses together, which limits the size of the page.
const POINTS: usize = 200_000;

/// Working data for one pose at a time.
struct SceneEvaluator<'a> {
    robot: &'a Robot,
    muscles: Muscles,
    geometry: Geometry,
    frames: Poses,
}

/// One pose: lines between bodies, branches of each cable, surfaces as center, axis and radius (no axis: a
/// sphere).
#[derive(PartialEq)]
struct Scene {
    bones: Vec<[[f64; 3]; 2]>,
    cables: Vec<Vec<Vec<[f64; 3]>>>,
    surfaces: Vec<([f64; 3], Option<[f64; 3]>, f64)>,
}

/// Reference and key poses by name, and each joint by itself over its range.
pub(super) fn view_data(robot: &Robot) -> Result<Value, Error> {
    let muscles = Muscles::new(robot);
    let geometry = Geometry::new(robot, &muscles);
    let mut evaluator = SceneEvaluator { robot, muscles, geometry, frames: Poses::new(robot) };
    let rest = coupled_reference_pose(robot);
    let base = evaluator.scene(&rest)?;
    let mut poses = vec![json!({"name": "reference", "scene": base.json(None)})];
    for (index, key) in robot.parts().keys.iter().enumerate() {
        let scene = evaluator.scene(&key.q)?;
        poses.push(json!({"name": display_name("key", &key.name, index), "scene": scene.json(None)}));
    }
    let joints = robot.parts().joints.len();
    let points: usize = base.cables.iter().flatten().map(Vec::len).sum();
    let count = (POINTS / (points * joints).max(1)).clamp(FRAMES[0], FRAMES[1]);
    let mut sweeps = Vec::new();
    for joint in 0..joints {
        let follows = robot.parts().couplings.iter().any(|coupling| coupling.follower == joint);
        let Some([low, high]) = joint_range(robot, joint).filter(|_| !follows) else { continue };
        let (mut at, mut frames) = (Vec::new(), Vec::new());
        for k in 0..count {
            let mut q = rest.clone();
            #[expect(clippy::cast_precision_loss, reason = "a few dozen frames")]
            let value = low + k as f64 / (count - 1) as f64 * (high - low);
            q[robot.coordinates_of(joint).start] = value;
            apply_couplings(robot, &[], &mut q);
            at.push(value);
            frames.push(evaluator.scene(&q)?.json(Some(&base)));
        }
        let name = display_name("joint", &robot.parts().joints[joint].name, joint);
        sweeps.push(json!({"joint": name, "at": at, "frames": frames}));
    }
    Ok(json!({"poses": poses, "sweeps": sweeps}))
}

impl SceneEvaluator<'_> {
    fn scene(&mut self, q: &[f64]) -> Result<Scene, Error> {
        let parts = self.robot.parts();
        self.robot.forward_kinematics(q, &mut self.frames)?;
        self.muscles.evaluate(q, &mut self.geometry)?;
        let pose = |body: usize| self.robot.body_pose(&self.frames, body);
        let bones = (1..parts.bodies.len()).filter(|&body| parts.bodies[body].parent > 0);
        let bones =
            bones.map(|body| [parts.bodies[body].parent, body].map(|body| pose(body).origin)).collect();
        let cables = (0..self.muscles.count())
            .map(|muscle| self.muscles.path(&self.geometry, muscle, ARC_STEP))
            .collect::<Result<_, _>>()?;
        let surfaces = parts.wraps.iter().map(|wrap| {
            let (center, tip) = (wrap.position, axis_tip(wrap.position, wrap.orientation));
            let (center, tip) = (pose(wrap.body).point(center), pose(wrap.body).point(tip));
            let axis = core::array::from_fn(|i| tip[i] - center[i]);
            (center, (wrap.kind == WrapKind::Cylinder).then_some(axis), wrap.radius)
        });
        Ok(Scene { bones, cables, surfaces: surfaces.collect() })
    }
}

/// The point one metre along the z axis of a frame.
fn axis_tip(position: [f64; 3], [w, x, y, z]: [f64; 4]) -> [f64; 3] {
    let axis = [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), w * w - x * x - y * y + z * z];
    core::array::from_fn(|i| position[i] + axis[i])
}

impl Scene {
    /// Cables with the same path as in `base` are null.
    fn json(&self, base: Option<&Scene>) -> Value {
        let cables = self.cables.iter().enumerate().map(|(i, cable)| {
            let same = base.is_some_and(|base| base.cables.get(i) == Some(cable));
            if same {
                Value::Null
            } else {
                cable.iter().map(|line| line.iter().map(point).collect::<Value>()).collect()
            }
        });
        json!({
            "bones": self.bones.iter().map(|bone| bone.iter().map(point).collect::<Value>()).collect::<Value>(),
            "cables": cables.collect::<Value>(),
            "surfaces": self.surfaces.iter()
                .map(|(center, axis, radius)| json!([point(center), axis.as_ref().map(point), radius])).collect::<Value>(),
        })
    }
}

/// Rounded to 0.01 mm, below the resolution of the view, so that the page stays small.
fn point(point: &[f64; 3]) -> Value {
    json!(point.map(|x| (x * 1e5).round() / 1e5))
}
