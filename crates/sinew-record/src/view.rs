//! What Foxglove shows: the bodies and the muscles at reduced rates.

use crate::messages::{
    Color, FrameTransform, FrameTransforms, LinePrimitive, Quaternion, SceneEntity, SceneUpdate, Timestamp,
    Vector3,
};
use sinew::Error;
use sinew::body::{PathElement, Pose, Poses, TendonPath};
use sinew::machine::Machine;
use sinew::muscle::{Geometry, MuscleDynamics, Muscles};

/// Angle between two points of an arc, rad.
const ARC_STEP: f64 = 0.5;
/// Frame of the machine's base.
const WORLD: &str = "world";

/// Kinematics of a machine for pictures.
pub(crate) struct View {
    machine: Machine,
    model: MuscleDynamics,
    poses: Poses,
    muscles: Muscles,
    geometry: Geometry,
    frames: Vec<String>,
    /// N: colour of the scale's end.
    full_tension: f64,
}

impl View {
    pub(crate) fn new(machine: &Machine) -> Result<Self, Error> {
        let robot = &machine.robot;
        let muscles = Muscles::new(robot);
        let named = |(k, body): (usize, &sinew::body::Body)| match (k, body.name.as_str()) {
            (0, _) => WORLD.to_owned(),
            (k, "") => format!("body_{k}"),
            (_, name) => name.to_owned(),
        };
        Ok(Self {
            model: MuscleDynamics::new(robot)?,
            poses: Poses::new(robot),
            geometry: Geometry::new(robot, &muscles),
            muscles,
            frames: robot.parts().bodies.iter().enumerate().map(named).collect(),
            full_tension: 0.0,
            machine: machine.clone(),
        })
    }

    /// Sets the pose, rad or m: `[joints]`.
    fn evaluate(&mut self, q: &[f64]) -> Result<(), Error> {
        self.model.evaluate(q)?;
        self.machine.robot.forward_kinematics(self.model.coordinates(), &mut self.poses)
    }

    /// Torques or forces of tensions at the anchors on the independent joints, `R^T F`, Nm or N.
    ///
    /// # Shapes
    /// `q, out: [joints]`; `tension: [muscles]`, N.
    pub(crate) fn torques(&mut self, q: &[f64], tension: &[f64], out: &mut [f64]) -> Result<(), Error> {
        self.evaluate(q)?;
        out.fill(0.0);
        for (arms, tension) in self.model.moment_arms().chunks_exact(q.len().max(1)).zip(tension) {
            out.iter_mut().zip(arms).for_each(|(torque, arm)| *torque += arm * tension);
        }
        Ok(())
    }

    /// Lengths of the muscles, m, and their rates, m/s.
    ///
    /// # Shapes
    /// `q, v: [joints]`; each of the results `[muscles]`.
    pub(crate) fn lengths(&mut self, q: &[f64], v: &[f64]) -> Result<[Vec<f64>; 2], Error> {
        self.model.evaluate(q)?;
        let length = self.model.lengths().to_vec();
        let mut rate = vec![0.0; length.len()];
        self.model.anchor_motion(v, &mut rate);
        rate.iter_mut().for_each(|rate| *rate = -*rate);
        Ok([length, rate])
    }

    /// Frames of the bodies with respect to those that carry them; with `all` also those that no joint moves.
    pub(crate) fn transforms(&mut self, q: &[f64], time: u64, all: bool) -> Result<FrameTransforms, Error> {
        self.evaluate(q)?;
        let parts = self.machine.robot.parts();
        let moved = |body: usize| parts.joints.iter().any(|joint| joint.body == body);
        let transform = |body: usize| {
            let parent = parts.bodies[body].parent;
            let [pose, base] = [body, parent].map(|body| self.machine.robot.body_pose(&self.poses, body));
            let (translation, rotation) = relative(&base, &pose);
            FrameTransform {
                timestamp: Some(Timestamp::from_ns(time)),
                parent_frame_id: self.frames[parent].clone(),
                child_frame_id: self.frames[body].clone(),
                translation: Some(translation),
                rotation: Some(rotation),
            }
        };
        let shown = (1..parts.bodies.len()).filter(|body| all || moved(*body));
        Ok(FrameTransforms { transforms: shown.map(transform).collect() })
    }

    /// Every body as lines from its origin to what it carries, fixed to its frame.
    pub(crate) fn bodies(&mut self, q: &[f64], time: u64) -> Result<SceneUpdate, Error> {
        self.evaluate(q)?;
        let (robot, parts) = (&self.machine.robot, self.machine.robot.parts());
        let local = |body: usize, point: [f64; 3]| {
            let pose = robot.body_pose(&self.poses, body);
            local_point(&pose, point)
        };
        let mut points: Vec<Vec<[f64; 3]>> = vec![Vec::new(); parts.bodies.len()];
        for (index, body) in parts.bodies.iter().enumerate().skip(1) {
            points[body.parent].push(local(body.parent, robot.body_pose(&self.poses, index).origin));
        }
        for tendon in &parts.tendons {
            let TendonPath::Spatial(elements) = &tendon.path else { continue };
            for element in elements {
                if let PathElement::Site(site) = element {
                    points[parts.sites[*site].body].push(parts.sites[*site].position);
                }
            }
        }
        if let Some(site) = self.machine.payload_site() {
            points[parts.sites[site].body].push(parts.sites[site].position);
        }
        let entity = |(body, points): (usize, Vec<[f64; 3]>)| SceneEntity {
            timestamp: Some(Timestamp::from_ns(time)),
            frame_id: self.frames[body].clone(),
            id: format!("body {}", self.frames[body]),
            frame_locked: true,
            lines: vec![line(PAIRS, points.into_iter().flat_map(|point| [[0.0; 3], point]), BODY, 0.004)],
        };
        let entities = points.into_iter().enumerate().filter(|(_, points)| !points.is_empty()).map(entity);
        Ok(SceneUpdate { entities: entities.collect() })
    }

    /// Every muscle as a line, from blue without tension to red at the largest tension so far.
    pub(crate) fn muscles(&mut self, q: &[f64], tension: &[f64], time: u64) -> Result<SceneUpdate, Error> {
        self.evaluate(q)?;
        let largest = tension.iter().copied().filter(|x| x.is_finite()).fold(0.0, f64::max);
        self.full_tension = self.full_tension.max(largest);
        self.muscles.evaluate(self.model.coordinates(), &mut self.geometry)?;
        let mut lines = Vec::new();
        for muscle in 0..self.muscles.count() {
            let fraction = tension.get(muscle).map_or(0.0, |tension| tension / self.full_tension.max(1e-9));
            let fraction = if fraction.is_finite() { fraction.clamp(0.0, 1.0) } else { 0.0 };
            let color = [f64::from((fraction * 16.0).round() as u8) / 16.0, 0.25, 1.0 - fraction.round()];
            let robot = &self.machine.robot;
            for branch in self.muscles.drawn(robot, &self.poses, &self.geometry, muscle, ARC_STEP)? {
                lines.push(line(STRIP, branch.into_iter(), color, 0.003));
            }
        }
        let entity = SceneEntity {
            timestamp: Some(Timestamp::from_ns(time)),
            frame_id: WORLD.to_owned(),
            id: "muscles".to_owned(),
            frame_locked: true,
            lines,
        };
        Ok(SceneUpdate { entities: vec![entity] })
    }
}

/// Kinds of a line.
const STRIP: i32 = 0;
const PAIRS: i32 = 2;
/// Colour of a body.
const BODY: [f64; 3] = [0.5, 0.5, 0.5];

fn line(
    kind: i32,
    points: impl Iterator<Item = [f64; 3]>,
    [r, g, b]: [f64; 3],
    thickness: f64,
) -> LinePrimitive {
    LinePrimitive {
        kind,
        thickness,
        scale_invariant: false,
        points: points.map(|point| Vector3::from_array(point.map(to_micrometre))).collect(),
        color: Some(Color { r, g, b, a: 1.0 }),
    }
}

/// Rounded, so that what is 0 but for rounding takes no bytes.
fn to_micrometre(x: f64) -> f64 {
    (1e6 * x).round() / 1e6
}

/// A point of the world in a frame.
fn local_point(frame: &Pose, point: [f64; 3]) -> [f64; 3] {
    let from: [f64; 3] = std::array::from_fn(|k| point[k] - frame.origin[k]);
    // The axes are the columns of the rotation's transpose: x', y', z' in the world.
    std::array::from_fn(|axis| (0..3).map(|k| axis_of(frame, axis)[k] * from[k]).sum())
}

/// An axis of a frame in the world.
fn axis_of(frame: &Pose, axis: usize) -> [f64; 3] {
    let unit = std::array::from_fn(|k| if k == axis { 1.0 } else { 0.0 });
    let tip = frame.point(unit);
    std::array::from_fn(|k| tip[k] - frame.origin[k])
}

/// A frame with respect to another one.
fn relative(base: &Pose, frame: &Pose) -> (Vector3, Quaternion) {
    // Entry (i, j): component along axis i of the base of axis j of the frame.
    let columns: [[f64; 3]; 3] = std::array::from_fn(|j| axis_of(frame, j));
    let rows: [[f64; 3]; 3] = std::array::from_fn(|i| axis_of(base, i));
    let at = |i: usize, j: usize| (0..3).map(|k| rows[i][k] * columns[j][k]).sum::<f64>();
    let [w, x, y, z] = quaternion(at);
    let translation = Vector3::from_array(local_point(base, frame.origin).map(to_micrometre));
    let [w, x, y, z] = [w, x, y, z].map(to_micrometre);
    (translation, Quaternion { x, y, z, w })
}

/// Quaternion w, x, y, z of a rotation matrix, from its largest component (Shepperd 1978).
fn quaternion(at: impl Fn(usize, usize) -> f64) -> [f64; 4] {
    let trace = at(0, 0) + at(1, 1) + at(2, 2);
    if trace > 0.0 {
        let s = 2.0 * (1.0 + trace).sqrt();
        return [0.25 * s, (at(2, 1) - at(1, 2)) / s, (at(0, 2) - at(2, 0)) / s, (at(1, 0) - at(0, 1)) / s];
    }
    let largest = (0..3).fold(0, |best, k| if at(k, k) > at(best, best) { k } else { best });
    let (i, j, k) = (largest, (largest + 1) % 3, (largest + 2) % 3);
    let s = 2.0 * (1.0 + at(i, i) - at(j, j) - at(k, k)).max(0.0).sqrt();
    let mut found = [(at(k, j) - at(j, k)) / s, 0.0, 0.0, 0.0];
    found[1 + i] = 0.25 * s;
    found[1 + j] = (at(j, i) + at(i, j)) / s;
    found[1 + k] = (at(k, i) + at(i, k)) / s;
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quaternion_turns_as_its_matrix_does() {
        for [w, x, y, z] in
            [[1.0, 0.0, 0.0, 0.0], [0.5, 0.5, -0.5, 0.5], [0.0, 0.6, 0.8, 0.0], [0.1, 0.7, -0.1, 0.7]]
        {
            let matrix: [[f64; 3]; 3] = [
                [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
                [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
                [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
            ];
            let found = quaternion(|i, j| matrix[i][j]);
            let product: f64 = found.iter().zip([w, x, y, z]).map(|(a, b): (&f64, f64)| a * b).sum();
            assert!((product.abs() - 1.0).abs() < 1e-9, "{found:?}");
        }
    }
}
