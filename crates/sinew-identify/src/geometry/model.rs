//! Where a camera sees the markers of a machine, as a function of all that is unknown.

use super::place::Place;
use sinew::Error;
use sinew::body::{JointCorrection, JointKind, Pose, Poses, Robot};
use sinew::machine::{Machine, Marker};

/// What a parameter is of; joints are those of the parts, coordinates 0 to 2.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ParameterKind {
    /// Offset of a joint's frame along an axis.
    Offset(usize, usize),
    /// Tilt of a joint's frame about x or y.
    Tilt(usize, usize),
    /// Flex of the link behind a joint.
    Flex(usize),
    /// Zero of the encoder of a joint.
    Zero(usize),
    /// Place of a marker on its body.
    Marker(usize, usize),
    /// Relative error of the camera's lengths.
    Scale,
    /// Turn of the camera, in one of its places.
    CameraTurn(usize, usize),
    /// Place of the camera.
    CameraPlace(usize, usize),
}

/// A parameter with what is known before.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// For reports, with its unit at the end.
    pub name: String,
    /// What it is of.
    pub kind: ParameterKind,
    /// Its standard deviation before: the bound of the machine file over the root of 3. Infinite for
    /// nothing known.
    pub tolerance: f64,
}

/// Standard deviation of a camera's scale.
const SCALE_SD: f64 = 0.03;
const AXES: [&str; 3] = ["x", "y", "z"];

/// A point, m, and its derivatives by every parameter.
pub type Sensitivity = ([f64; 3], Vec<[f64; 3]>);

/// A machine, its markers and its parameters.
#[derive(Debug, Clone)]
pub struct GeometryModel {
    /// As designed.
    robot: Robot,
    pub(super) markers: Vec<Marker>,
    parameters: Vec<Parameter>,
    independent: Vec<usize>,
}

impl GeometryModel {
    /// All parameters for which the machine has a tolerance, and those of a camera in `epochs` places.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] for a machine with a joint without an encoder, or without a marker that
    /// moves.
    pub fn new(machine: &Machine, markers: &[Marker], epochs: usize) -> Result<Self, Error> {
        let refuse = |name, expected, got| Err(Error::OutOfDomain { name, expected, got });
        if let Some(k) = machine.encoders.iter().position(Option::is_none) {
            return refuse(
                "joint without an encoder",
                "an encoder at every joint that follows no other",
                k as f64,
            );
        }
        if !markers.iter().any(|marker| machine.moves(marker.body)) {
            return refuse("markers that move", "at least one", 0.0);
        }
        let (robot, tolerances) = (&machine.robot, &machine.tolerances);
        let independent = robot.independent_joints();
        let mut parameters = Vec::new();
        let mut add = |name: String, kind: ParameterKind, bound: f64| {
            if bound > 0.0 {
                parameters.push(Parameter { name, kind, tolerance: bound / 3.0_f64.sqrt() });
            }
        };
        for (j, joint) in robot.parts().joints.iter().enumerate() {
            let (name, hinge) = (&joint.name, joint.kind == JointKind::Hinge);
            for (k, axis) in AXES.iter().enumerate() {
                add(format!("{name}.offset_{axis}_m"), ParameterKind::Offset(j, k), tolerances.link);
            }
            for (k, axis) in AXES[..2].iter().enumerate() {
                add(format!("{name}.tilt_{axis}_rad"), ParameterKind::Tilt(j, k), tolerances.axis);
            }
            if independent.contains(&j) {
                let (unit, zero) =
                    if hinge { ("rad", tolerances.zero) } else { ("m", tolerances.zero_slide) };
                add(format!("{name}.zero_{unit}"), ParameterKind::Zero(j), zero);
            }
            if hinge {
                add(format!("{name}.flex_rad_per_nm"), ParameterKind::Flex(j), tolerances.flex);
            }
        }
        for (m, marker) in markers.iter().enumerate() {
            for (k, axis) in AXES.iter().enumerate() {
                let bound = marker.position_sd * 3.0_f64.sqrt();
                add(format!("{}.{axis}_m", marker.name), ParameterKind::Marker(m, k), bound);
            }
        }
        add("camera.scale".to_owned(), ParameterKind::Scale, SCALE_SD * 3.0_f64.sqrt());
        for epoch in 0..epochs {
            let camera = if epoch == 0 { "camera".to_owned() } else { format!("camera_{}", epoch + 1) };
            for (k, axis) in AXES.iter().enumerate() {
                let turn = ParameterKind::CameraTurn(epoch, k);
                add(format!("{camera}.turn_{axis}_rad"), turn, f64::INFINITY);
            }
            for (k, axis) in AXES.iter().enumerate() {
                add(format!("{camera}.{axis}_m"), ParameterKind::CameraPlace(epoch, k), f64::INFINITY);
            }
        }
        Ok(Self { robot: robot.clone(), markers: markers.to_vec(), parameters, independent })
    }

    /// Its parameters.
    #[must_use]
    pub fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    /// The corrections of all joints by these parameters: `[joints]`.
    #[must_use]
    pub fn corrections(&self, theta: &[f64]) -> Vec<JointCorrection> {
        let mut all = vec![JointCorrection::default(); self.robot.parts().joints.len()];
        for (parameter, value) in self.parameters.iter().zip(theta) {
            match parameter.kind {
                ParameterKind::Offset(j, k) => all[j].displacement.offset[k] = *value,
                ParameterKind::Tilt(j, k) => all[j].displacement.tilt[k] = *value,
                ParameterKind::Flex(j) => all[j].flex = *value,
                ParameterKind::Zero(j) => all[j].zero = *value,
                _ => {}
            }
        }
        all
    }

    /// The markers where these parameters have them.
    #[must_use]
    pub fn markers(&self, theta: &[f64]) -> Vec<Marker> {
        let mut markers = self.markers.clone();
        for (parameter, value) in self.parameters.iter().zip(theta) {
            if let ParameterKind::Marker(m, k) = parameter.kind {
                markers[m].position[k] += value;
            }
        }
        markers
    }

    /// Relative error of the camera's lengths.
    pub(super) fn scale(&self, theta: &[f64]) -> f64 {
        let at = self.parameters.iter().position(|parameter| parameter.kind == ParameterKind::Scale);
        at.map_or(0.0, |at| theta[at])
    }

    /// Points of bodies in the world, in poses by the readings: for every pose the given points, `[body,
    /// place]`.
    ///
    /// # Errors
    /// As [`Robot::new`] and [`Robot::bent_kinematics`].
    pub(super) fn points<'p>(
        &self,
        corrections: &[JointCorrection],
        poses: impl Iterator<Item = (&'p [f64], Vec<(usize, [f64; 3])>)>,
    ) -> Result<Vec<[f64; 3]>, Error> {
        let robot = Robot::new(self.robot.parts().corrected(corrections))?;
        let mut at = Poses::new(&robot);
        let mut q = robot.reference_pose();
        let mut points = Vec::new();
        for (reading, wanted) in poses {
            for (joint, value) in self.independent.iter().zip(reading) {
                q[robot.coordinates_of(*joint).start] = *value;
            }
            robot.apply_couplings(&mut q)?;
            robot.bent_kinematics(&q, &mut at)?;
            points.extend(wanted.iter().map(|(body, place)| robot.body_pose(&at, *body).point(*place)));
        }
        Ok(points)
    }

    /// Places of the markers that were seen, in the world, m: in the order of the sightings.
    pub(super) fn world(&self, theta: &[f64], places: &[Place]) -> Result<Vec<[f64; 3]>, Error> {
        let markers = self.markers(theta);
        let poses = places.iter().map(|place| {
            let points = place.seen.iter().map(|seen| {
                let marker = &markers[seen.marker];
                (marker.body, marker.position)
            });
            (place.reading.as_slice(), points.collect())
        });
        self.points(&self.corrections(theta), poses)
    }

    /// Derivatives of a function of all parameters that a camera does not see by itself: for every such
    /// parameter
    /// one column of points, by differences of a hundredth of its tolerance.
    pub(super) fn derivatives(
        &self,
        theta: &[f64],
        base: &[[f64; 3]],
        mut of: impl FnMut(&[f64]) -> Result<Vec<[f64; 3]>, Error>,
    ) -> Result<Vec<Option<Vec<[f64; 3]>>>, Error> {
        let mut trial = theta.to_vec();
        let column = |(k, parameter): (usize, &Parameter)| {
            let camera =
                [ParameterKind::Scale].contains(&parameter.kind) || parameter.tolerance.is_infinite();
            if camera {
                return Ok(None);
            }
            let step = 0.01 * parameter.tolerance;
            trial[k] = theta[k] + step;
            let moved = of(&trial)?;
            trial[k] = theta[k];
            let slope = |(a, b): (&[f64; 3], &[f64; 3])| std::array::from_fn(|i| (a[i] - b[i]) / step);
            Ok(Some(moved.iter().zip(base).map(slope).collect()))
        };
        self.parameters.iter().enumerate().map(column).collect()
    }

    /// Points of bodies, and their derivatives by every parameter of the machine, zero by those of the
    /// camera:
    /// `[points][parameters]`.
    ///
    /// # Errors
    /// As [`Robot::new`] and [`Robot::bent_kinematics`].
    pub fn sensitivity(
        &self,
        theta: &[f64],
        poses: &[Vec<f64>],
        body: usize,
        place: [f64; 3],
    ) -> Result<Vec<Sensitivity>, Error> {
        let at = |theta: &[f64]| {
            let wanted = poses.iter().map(|pose| (pose.as_slice(), vec![(body, place)]));
            self.points(&self.corrections(theta), wanted)
        };
        let base = at(theta)?;
        let columns = self.derivatives(theta, &base, at)?;
        let row = |(point, x): (usize, &[f64; 3])| {
            (*x, columns.iter().map(|column| column.as_ref().map_or([0.0; 3], |c| c[point])).collect())
        };
        Ok(base.iter().enumerate().map(row).collect())
    }
}

/// A camera in one of its places, relative to where it was first found: the world in its frame.
pub(super) fn camera(first: &Pose, parameters: &[Parameter], theta: &[f64], epoch: usize) -> Pose {
    let (mut turn, mut place) = ([0.0; 3], [0.0; 3]);
    for (parameter, value) in parameters.iter().zip(theta) {
        match parameter.kind {
            ParameterKind::CameraTurn(at, k) if at == epoch => turn[k] = *value,
            ParameterKind::CameraPlace(at, k) if at == epoch => place[k] = *value,
            _ => {}
        }
    }
    let turned = first.turned(turn);
    Pose { origin: std::array::from_fn(|k| first.origin[k] + place[k]), ..turned }
}
