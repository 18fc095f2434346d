//! A robot as described: plain data, not validated. `Robot::new` validates it.
//!
//! Conventions are MuJoCo's where it has one: quaternions are `[w, x, y, z]`; a frame's pose is given in its
//! parent body; joints of one body act in the order they are listed, anchor and axis in the body's own frame
//! (at the reference pose the joints move nothing); the world is body 0.

use super::geom::{Geom, MeshGeom};
use alloc::collections::BTreeMap;
use alloc::string::String;
use alloc::vec::Vec;
use serde::{Deserialize, Serialize};

/// The content of a robot file that matters for cables, muscles and dynamics. Indices refer to these lists.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Parts {
    /// Name of the robot.
    pub name: String,
    /// Acceleration of gravity in the world, m/s^2.
    pub gravity: [f64; 3],
    /// Bodies; the first is the world; every parent stands before its children.
    pub bodies: Vec<Body>,
    /// Joints, grouped by body in the order of bodies.
    pub joints: Vec<Joint>,
    /// Points fixed to bodies.
    pub sites: Vec<Site>,
    /// Surfaces that cables wrap around.
    pub wraps: Vec<Wrap>,
    /// Shapes of the bodies, for drawings.
    #[serde(default)]
    pub geoms: Vec<Geom>,
    /// Shapes of the bodies that other files describe, for drawings.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub meshes: Vec<MeshGeom>,
    /// Tendons: each is a muscle.
    pub tendons: Vec<Tendon>,
    /// Tendons that nothing pulls: passive springs and dampers.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub springs: Vec<Tendon>,
    /// Joints that follow other joints.
    pub couplings: Vec<Coupling>,
    /// Actuators of tendons.
    pub actuators: Vec<Actuator>,
    /// Named poses.
    pub keys: Vec<Key>,
}

/// A rigid body.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Body {
    /// Its name; unique; may be empty in files that name nothing.
    pub name: String,
    /// Index of the parent; the world's is 0.
    pub parent: usize,
    /// Origin in the parent's frame, m.
    pub position: [f64; 3],
    /// Orientation in the parent's frame, unit quaternion `[w, x, y, z]`.
    pub orientation: [f64; 4],
    /// Mass, kg.
    pub mass: f64,
    /// Centre of mass in the body's frame, m.
    pub center_of_mass: [f64; 3],
    /// Inertia about the centre of mass in the body's axes, kg m^2, `[xx, yy, zz, xy, xz, yz]`.
    pub inertia: [f64; 6],
    /// Fraction of its weight that something holds, which no joint or muscle feels: 0 holds nothing; see
    /// [`Robot::gravity_compensation`](super::Robot::gravity_compensation).
    #[serde(default, skip_serializing_if = "is_zero")]
    pub gravity_compensation: f64,
}

/// Kind of a joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum JointKind {
    /// About an axis; one coordinate, rad.
    Hinge,
    /// Along an axis; one coordinate, m.
    Slide,
    /// About a point; four coordinates (a unit quaternion), three velocities in the body's frame.
    Ball,
    /// Unconstrained; seven coordinates (position in the world, quaternion), six velocities (linear in
    /// the world, angular in the body).
    Free,
}

impl JointKind {
    /// Unit of its coordinate: m of a slide, rad of the others.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            JointKind::Slide => "m",
            JointKind::Hinge | JointKind::Ball | JointKind::Free => "rad",
        }
    }

    /// Unit of its torque: N of a slide, N m of the others.
    #[must_use]
    pub fn torque_unit(self) -> &'static str {
        match self {
            JointKind::Slide => "N",
            JointKind::Hinge | JointKind::Ball | JointKind::Free => "N m",
        }
    }
}

/// A joint between a body and its parent.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Joint {
    /// Its name.
    pub name: String,
    /// The body it moves.
    pub body: usize,
    /// Its kind.
    pub kind: JointKind,
    /// Anchor in the body's frame, m.
    pub anchor: [f64; 3],
    /// Unit axis in the body's frame (hinge and slide).
    pub axis: [f64; 3],
    /// Coordinate in the pose of the description (hinge, slide): rad or m.
    pub reference: f64,
    /// Limits, rad or m; a ball's is its largest angle.
    pub range: Option<[f64; 2]>,
    /// Rotor inertia seen at the joint, kg m^2 or kg.
    pub armature: f64,
    /// Viscous damping, Nm s/rad or N s/m.
    pub damping: f64,
    /// Dry friction, Nm or N.
    pub friction: f64,
    /// Spring, Nm/rad or N/m.
    pub stiffness: f64,
    /// Coordinate where the spring is at rest.
    pub spring_reference: f64,
    /// Bend of the link behind it by the moment of gravity, rad/Nm, on positions alone; see
    /// [`Robot::bent_kinematics`](super::Robot::bent_kinematics).
    #[serde(default, skip_serializing_if = "is_zero")]
    pub flex: f64,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn is_zero(x: &f64) -> bool {
    *x == 0.0
}

/// A point fixed to a body.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Site {
    /// Its name.
    pub name: String,
    /// The body.
    pub body: usize,
    /// Place in the body's frame, m.
    pub position: [f64; 3],
    /// Orientation in the body's frame.
    pub orientation: [f64; 4],
    /// The joint, a hinge or a slide, and its range in which paths pass through the site; elsewhere they go
    /// past it, straight from the site before to the one behind. `None`: paths always pass through it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub active: Option<(usize, [f64; 2])>,
}

/// Shape of a wrapping surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum WrapKind {
    /// A sphere.
    Sphere,
    /// A cylinder about its own z axis, without ends.
    Cylinder,
}

/// A wrapping surface fixed to a body.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Wrap {
    /// Its name.
    pub name: String,
    /// The body.
    pub body: usize,
    /// Its shape.
    pub kind: WrapKind,
    /// Radius, m.
    pub radius: f64,
    /// Centre in the body's frame, m.
    pub position: [f64; 3],
    /// Orientation in the body's frame.
    pub orientation: [f64; 4],
}

/// One element of a tendon's path.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum PathElement {
    /// Through a site.
    Site(usize),
    /// Around a surface, where the straight cable would penetrate it; the site `side` selects the side, or
    /// the inside if it lies within the surface.
    Wrap {
        /// The surface.
        wrap: usize,
        /// The site.
        side: Option<usize>,
    },
    /// Begins a new branch whose length counts divided by this number (a tackle).
    Pulley(f64),
}

/// The path of a tendon.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum TendonPath {
    /// Through space.
    Spatial(Vec<PathElement>),
    /// A weighted sum of joint coordinates: joint, coefficient.
    Fixed(Vec<(usize, f64)>),
}

/// The sheath of a cable between its drive and the first site.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SheathGeometry {
    /// Length, m.
    pub length: f64,
    /// Bend, rad.
    pub bend: f64,
    /// Direction in which the cable leaves the sheath, in the first site's body frame; unit.
    pub end_axis: Option<[f64; 3]>,
}

/// A cable or a spring.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Tendon {
    /// Its name.
    pub name: String,
    /// Its path.
    #[serde(rename = "route")]
    pub path: TendonPath,
    /// Its sheath, if described.
    pub sheath: Option<SheathGeometry>,
    /// Limits of length, m.
    pub range: Option<[f64; 2]>,
    /// Damping, N s/m; beside the muscle, where it is one.
    pub damping: f64,
    /// Stiffness, N/m; beside the muscle, where it is one.
    pub stiffness: f64,
    /// Lengths between which the spring is slack, m; `None`: the length in the pose in which the springs of
    /// the joints are at rest.
    pub spring_length: Option<[f64; 2]>,
}

/// A joint that follows another: `q1 - r1 = c0 + c1 x + c2 x^2 + c3 x^3 + c4 x^4`, `x = q2 - r2`, with
/// the references `r`; without a leader `q1 - r1 = c0`. With pieces it follows these instead of the
/// polynomial: from `x_k` on `q1 - r1 = a + b s + c s^2 + d s^3`, `s = x - x_k`; before the first it goes
/// straight on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Coupling {
    /// The joint that follows.
    pub follower: usize,
    /// The joint it follows.
    pub leader: Option<usize>,
    /// Coefficients.
    pub coefficients: [f64; 5],
    /// Pieces `[x_k, a, b, c, d]` of a curve, `x_k` rising.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub pieces: Vec<[f64; 5]>,
}

/// Kind of an actuator.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum ActuatorKind {
    /// A force proportional to the control.
    Motor,
    /// MuJoCo's general actuator.
    General,
    /// MuJoCo's biological muscle.
    Muscle,
    /// A servo of length.
    Position,
    /// A servo of speed.
    Velocity,
    /// A servo of length whose control is a speed.
    IntVelocity,
    /// Damping by the control.
    Damper,
    /// A pneumatic or hydraulic cylinder.
    Cylinder,
    /// A servo with an integral part.
    Pid,
    /// A motor with its electrical side.
    DcMotor,
}

impl ActuatorKind {
    /// Every kind with its MJCF element.
    pub const WORDS: [(ActuatorKind, &'static str); 10] = [
        (ActuatorKind::Motor, "motor"),
        (ActuatorKind::General, "general"),
        (ActuatorKind::Muscle, "muscle"),
        (ActuatorKind::Position, "position"),
        (ActuatorKind::Velocity, "velocity"),
        (ActuatorKind::IntVelocity, "intvelocity"),
        (ActuatorKind::Damper, "damper"),
        (ActuatorKind::Cylinder, "cylinder"),
        (ActuatorKind::Pid, "pid"),
        (ActuatorKind::DcMotor, "dcmotor"),
    ];

    /// Its MJCF element.
    #[must_use]
    pub fn word(self) -> &'static str {
        ActuatorKind::WORDS.iter().find(|(kind, _)| *kind == self).map_or("motor", |(_, word)| word)
    }

    /// The kind of an MJCF element.
    #[must_use]
    pub fn from_word(word: &str) -> Option<ActuatorKind> {
        ActuatorKind::WORDS.iter().find(|(_, known)| *known == word).map(|(kind, _)| *kind)
    }
}

/// An actuator on a tendon.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Actuator {
    /// Its name.
    pub name: String,
    /// Its kind.
    pub kind: ActuatorKind,
    /// The tendon.
    pub tendon: usize,
    /// Force at the tendon per unit of its own.
    pub gear: f64,
    /// Limits of the control.
    pub control_range: Option<[f64; 2]>,
    /// Limits of the force, N.
    pub force_range: Option<[f64; 2]>,
    /// Its law of force (gain, bias, dynamics) as MJCF's attributes: kept verbatim, not used here.
    #[serde(default)]
    pub law: BTreeMap<String, String>,
}

impl Actuator {
    /// The largest tension that its ranges allow in its cable, N; `None` where they limit none.
    ///
    /// ```text
    /// T_max = |gear| max(|f_low|, |f_high|),   f: force range, and the control range of a motor, whose control is its force
    /// ```
    ///
    /// A cable pulls whichever sign its author gave to pulling. The control of other kinds is an activation,
    /// a position or a speed and limits no force.
    #[must_use]
    pub fn largest_tension(&self) -> Option<f64> {
        let control = self.control_range.filter(|_| self.kind == ActuatorKind::Motor);
        let ranges = [control, self.force_range].into_iter().flatten();
        let largest = ranges.map(|[low, high]| self.gear.abs() * low.abs().max(high.abs()));
        largest.reduce(f64::min)
    }
}

/// A named pose.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Key {
    /// Its name.
    pub name: String,
    /// All coordinates, joints in order.
    pub q: Vec<f64>,
}
