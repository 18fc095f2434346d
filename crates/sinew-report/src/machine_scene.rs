//! A machine in one pose, as points of the world: bodies, joints, cables, wrapping surfaces.

use super::error::Error;
use super::shapes::shapes;
use sinew::body::{Poses, WrapKind};
use sinew::machine::Machine;
use sinew::muscle::{Geometry, MuscleDynamics, Muscles};

/// Angle between two points of an arc, rad.
const ARC_STEP: f64 = 0.3;

/// Points of the world, m.
pub(super) struct MachineScene {
    /// Direction against gravity, of unit length; z without gravity.
    pub(super) up: [f64; 3],
    pub(super) bodies: Vec<BodyPoints>,
    pub(super) joints: Vec<[f64; 3]>,
    /// Of every muscle: branches as lines.
    pub(super) cables: Vec<Vec<Vec<[f64; 3]>>>,
    /// Circles of wrapping surfaces: centre, axis of a cylinder, radius.
    pub(super) surfaces: Vec<([f64; 3], Option<[f64; 3]>, f64)>,
    pub(super) end_point: Option<[f64; 3]>,
}

/// A shape of a body: a convex hull, widened by a radius.
pub(super) struct BodyPoints {
    /// Whether no joint moves it.
    pub(super) fixed: bool,
    pub(super) points: Vec<[f64; 3]>,
    /// Radius by which the hull is widened, m.
    pub(super) radius: f64,
}

impl MachineScene {
    /// In the pose in which motions start.
    pub(super) fn at_start(machine: &Machine) -> Result<Self, Error> {
        let (robot, parts) = (&machine.robot, machine.robot.parts());
        let mut model = MuscleDynamics::new(robot)?;
        model.evaluate(&machine.start)?;
        let mut frames = Poses::new(robot);
        robot.forward_kinematics(model.coordinates(), &mut frames)?;
        let place = |body: usize, point: [f64; 3]| robot.body_pose(&frames, body).point(point);
        let site = |index: usize| place(parts.sites[index].body, parts.sites[index].position);

        let mut fixed: Vec<bool> = Vec::new();
        for (index, body) in parts.bodies.iter().enumerate() {
            let moved = parts.joints.iter().any(|joint| joint.body == index);
            fixed.push(index == 0 || (!moved && fixed[body.parent]));
        }
        let end_point = machine.payload_site();
        let shapes = shapes(parts).into_iter();
        let bodies = shapes.map(|shape| BodyPoints {
            fixed: fixed[shape.body],
            points: shape.points.iter().map(|point| place(shape.body, *point)).collect(),
            radius: shape.radius,
        });

        let muscles = Muscles::new(robot);
        let mut geometry = Geometry::new(robot, &muscles);
        muscles.evaluate(model.coordinates(), &mut geometry)?;
        let cables =
            (0..muscles.count()).map(|muscle| muscles.drawn(robot, &frames, &geometry, muscle, ARC_STEP));
        let surfaces = parts.wraps.iter().map(|wrap| {
            let [w, x, y, z] = wrap.orientation;
            let along = [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), w * w - x * x - y * y + z * z];
            let tip: [f64; 3] = core::array::from_fn(|k| wrap.position[k] + along[k]);
            let (centre, tip) = (place(wrap.body, wrap.position), place(wrap.body, tip));
            let axis = core::array::from_fn(|k| tip[k] - centre[k]);
            (centre, (wrap.kind == WrapKind::Cylinder).then_some(axis), wrap.radius)
        });
        Ok(Self {
            up: unit(parts.gravity.map(|g| -g)).unwrap_or([0.0, 0.0, 1.0]),
            joints: parts.joints.iter().map(|joint| place(joint.body, joint.anchor)).collect(),
            cables: cables.collect::<Result<_, _>>()?,
            surfaces: surfaces.collect(),
            end_point: end_point.map(site),
            bodies: bodies.collect(),
        })
    }
}

/// Of unit length; none for a vector of no length.
pub(super) fn unit(vector: [f64; 3]) -> Option<[f64; 3]> {
    let length = vector.iter().map(|x| x * x).sum::<f64>().sqrt();
    (length > 1e-12).then(|| vector.map(|x| x / length))
}
