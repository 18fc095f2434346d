//! Data of a page's three-dimensional view: shapes of bodies, cables, wrapping surfaces and joints in the
//! poses that can be shown, and paths of points.

use super::error::Error;
use askama::Template;
use serde_json::{Value, json};
use sinew::body::{Poses, Robot};
use sinew::muscle::{Geometry, Muscles};

/// A view with its controls, to be put into a page.
#[derive(Debug, Template)]
#[template(path = "scene.html")]
pub(super) struct SceneFigure {
    title: String,
    caption: String,
    /// Groups of choices: heading, then number and name of each.
    choices: Vec<(&'static str, Vec<(String, String)>)>,
    /// The choice that is shown first.
    start: usize,
    data: String,
    entries: Vec<(&'static str, String)>,
}

/// A joint over its range, or another quantity: name, unit, values and a pose for each value.
#[derive(Debug)]
pub struct Sweep {
    /// Of the joint.
    pub name: String,
    /// Of its values.
    pub unit: String,
    /// Its values.
    pub at: Vec<f64>,
    /// By [`Scenery::pose`].
    pub frames: Vec<Value>,
}

/// What a view shows.
#[derive(Debug, Default)]
pub struct SceneData {
    /// By [`Scenery::fixed`]; none where only paths are shown.
    pub fixed: Option<Value>,
    /// Names and poses by [`Scenery::pose`].
    pub poses: Vec<(String, Value)>,
    /// Joints over their ranges.
    pub sweeps: Vec<Sweep>,
    /// Paths of points, each with the class and the name of its line.
    pub paths: Vec<Value>,
}

impl SceneFigure {
    /// `start`: index of the choice that is shown first, poses before sweeps.
    pub(super) fn new(
        title: &str,
        caption: &str,
        scene: &SceneData,
        start: usize,
        entries: &[(&'static str, &str)],
    ) -> Result<Self, Error> {
        let numbered = |first: usize, names: &mut dyn Iterator<Item = &String>| -> Vec<(String, String)> {
            names.enumerate().map(|(k, name)| ((first + k).to_string(), name.clone())).collect()
        };
        let poses = numbered(0, &mut scene.poses.iter().map(|(name, _)| name));
        let sweeps = numbered(poses.len(), &mut scene.sweeps.iter().map(|sweep| &sweep.name));
        let several = poses.len() + sweeps.len() > 1;
        let named = scene.poses.iter().map(|(name, scene)| json!({"name": name, "scene": scene}));
        let ranges = scene.sweeps.iter().map(
            |sweep| json!({"joint": sweep.name, "unit": sweep.unit, "at": sweep.at, "frames": sweep.frames}),
        );
        let data = json!({"fixed": scene.fixed, "poses": named.collect::<Value>(),
            "sweeps": ranges.collect::<Value>(), "paths": scene.paths});
        Ok(Self {
            title: title.to_owned(),
            caption: caption.to_owned(),
            choices: if several { vec![("a pose", poses), ("over a range", sweeps)] } else { Vec::new() },
            start,
            data: embedded(&data)?,
            entries: entries.iter().map(|(class, name)| (*class, (*name).to_owned())).collect(),
        })
    }
}

/// A machine in its start pose and over the ranges of its joints.
pub(super) fn machine_figure(scene: &SceneData) -> Result<SceneFigure, Error> {
    let caption = "The machine as designed: bodies with their shapes, or where the file has none, as bones \
        from joint to joint; cables with their wrapping; transparent shapes are wrapping surfaces.";
    SceneFigure::new("The machine in its poses, and over the range of each joint", caption, scene, 0, &[])
}

/// Upper bound of the points of all poses of a page together: about 26 bytes each, beside 1.1 MB for the view
/// itself.
pub const POINTS: usize = 60_000;

/// Angle between two points of an arc, rad.
const ARC_STEP: f64 = 0.25;

/// Evaluates the poses of a robot one at a time.
#[derive(Debug)]
pub struct Scenery<'a> {
    robot: &'a Robot,
    muscles: Muscles,
    geometry: Geometry,
    frames: Poses,
    base: Option<ScenePose>,
}

/// Poses of the bodies and branches of the cables.
#[derive(Debug, Clone, PartialEq)]
pub struct ScenePose {
    /// Position, m, and orientation `[w, x, y, z]` of every body.
    bodies: Vec<([f64; 3], [f64; 4])>,
    cables: Vec<Vec<Vec<[f64; 3]>>>,
}

impl<'a> Scenery<'a> {
    /// For a robot.
    #[must_use]
    pub fn new(robot: &'a Robot) -> Self {
        let muscles = Muscles::new(robot);
        let geometry = Geometry::new(robot, &muscles);
        Self { robot, muscles, geometry, frames: Poses::new(robot), base: None }
    }

    /// What all poses share.
    #[must_use]
    pub fn fixed(&self) -> Value {
        let parts = self.robot.parts();
        let joints: Vec<Value> = parts
            .joints
            .iter()
            .map(|joint| {
                json!({"name": joint.name, "unit": joint.kind.unit(), "range": joint.range, "body": joint.body,
                    "axis": joint.axis, "position": point(&joint.anchor)})
            })
            .collect();
        let muscles: Vec<Value> = parts.tendons.iter().map(|tendon| json!({"name": tendon.name})).collect();
        let bodies: Vec<Value> =
            parts.bodies.iter().map(|body| json!({"name": body.name, "parent": body.parent})).collect();
        json!({"gravity": parts.gravity, "bodies": bodies, "shapes": sinew_view::shapes(parts),
            "meshes": sinew_view::meshes(parts), "joints": joints, "muscles": muscles})
    }

    /// A pose, all coordinates `q: [nq]`. Bodies and cables where they are in the first pose are null.
    ///
    /// # Errors
    /// [`Error::Drawing`] for coordinates of another robot.
    pub fn pose(&mut self, q: &[f64]) -> Result<Value, Error> {
        self.robot.forward_kinematics(q, &mut self.frames)?;
        self.muscles.evaluate(q, &mut self.geometry)?;
        let bodies = (0..self.robot.parts().bodies.len()).map(|body| {
            let pose = self.robot.body_pose(&self.frames, body);
            (pose.origin, pose.quaternion())
        });
        let cables = (0..self.muscles.count())
            .map(|muscle| self.muscles.drawn(self.robot, &self.frames, &self.geometry, muscle, ARC_STEP));
        let pose = ScenePose { bodies: bodies.collect(), cables: cables.collect::<Result<_, _>>()? };
        let value = pose.json(self.base.as_ref());
        self.base.get_or_insert(pose);
        Ok(value)
    }

    /// Number of points of the cables of the first pose, by which the number of poses of a page can be
    /// limited.
    #[must_use]
    pub fn points(&self) -> usize {
        self.base.as_ref().map_or(0, |base| base.cables.iter().flatten().map(Vec::len).sum())
    }
}

impl ScenePose {
    fn json(&self, base: Option<&ScenePose>) -> Value {
        let cables = self.cables.iter().enumerate().map(|(i, cable)| {
            let same = base.is_some_and(|base| base.cables.get(i) == Some(cable));
            let lines = || cable.iter().map(|line| line.iter().map(point).collect::<Value>()).collect();
            if same { Value::Null } else { lines() }
        });
        let numbers = |(at, turn): &([f64; 3], [f64; 4])| -> Vec<f64> {
            at.iter().chain(turn).map(|x| rounded(*x)).collect()
        };
        let bodies = self.bodies.iter().enumerate().map(|(i, body)| {
            let same = base.is_some_and(|base| numbers(&base.bodies[i]) == numbers(body));
            if same { Value::Null } else { json!(numbers(body)) }
        });
        json!({"bodies": bodies.collect::<Value>(), "cables": cables.collect::<Value>()})
    }
}

/// A path of a point, by the class and the name of its line.
pub(super) fn path(class: &str, name: &str, points: impl Iterator<Item = [f64; 3]>) -> Value {
    let points: Vec<Value> = points.filter(|p| p.iter().all(|x| x.is_finite())).map(|p| point(&p)).collect();
    json!({"class": class, "name": name, "points": points})
}

fn point(point: &[f64; 3]) -> Value {
    json!(point.map(rounded))
}

/// To 0.01 mm, below the resolution of the view, so that the page stays small.
fn rounded(x: f64) -> f64 {
    (x * 1e5).round() / 1e5
}

/// What shows the figures of a page: the view of the live page, without a server, with its licence.
pub(super) fn scene_script() -> String {
    let view = sinew_view::inline_view();
    format!("<!-- three.js:\n{} -->\n{}", view.licence.trim(), view.scripts)
}

/// JSON, safe within a script element.
fn embedded(data: &Value) -> Result<String, Error> {
    Ok(serde_json::to_string(data)?.replace('<', "\\u003c"))
}

#[cfg(test)]
mod tests {
    use crate::shapes::rotated;
    use sinew::body::Pose;

    #[test]
    fn a_rotation_comes_back_from_the_images_of_the_axes() {
        for k in 0..200 {
            let raw: [f64; 4] = std::array::from_fn(|i| (1.7 * f64::from(k) + 2.3 * i as f64).sin());
            let norm = raw.iter().map(|x| x * x).sum::<f64>().sqrt();
            let q = raw.map(|x| x / norm);
            let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
            let pose = Pose { axes: axes.map(|axis| rotated(q, axis)), origin: [0.0; 3] };
            let found = pose.quaternion();
            let same: f64 = q.iter().zip(found).map(|(a, b)| a * b).sum();
            assert!((same.abs() - 1.0).abs() < 1e-12, "{q:?} {found:?}");
        }
    }
}
