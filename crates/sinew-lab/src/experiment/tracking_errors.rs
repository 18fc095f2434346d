use sinew::Error;
use sinew::body::{Poses, Robot};
use sinew::muscle::MuscleDynamics;
use sinew::trajectory::ControllableMotion;
use sinew::twin::arm::ArmSpecimen;

/// Errors of joints, end point and muscle lengths, evaluated on the machine as built.
#[derive(Debug, Clone)]
pub(super) struct TrackingErrors<'a> {
    specimen: &'a ArmSpecimen,
    robot: &'a Robot,
    poses: Poses,
    model: MuscleDynamics,
    /// Of a machine whose cables leave joints to springs.
    controllable: Option<ControllableMotion>,
    /// Body of the end point, and its position on it, m; none where only the joints are the task.
    end_point_on: Option<(usize, [f64; 3])>,
    /// Pose in which every encoder reads its reference, rad or m: `[joints]`; of a joint without an encoder
    /// the reference.
    encoder_pose: Vec<f64>,
    /// End point in the reference pose, m; NaN without an end point.
    pub(super) reference_point: [f64; 3],
    /// End point in the true pose, m; NaN without an end point.
    pub(super) end_point: [f64; 3],
    /// End point in `encoder_pose`, m; NaN without an end point.
    pub(super) encoder_point: [f64; 3],
    /// True pose minus `encoder_pose`, rad or m: `[joints]`.
    pub(super) joint_error: Vec<f64>,
    /// Lengths of the muscles in the reference pose, m: `[muscles]`.
    pub(super) length: Vec<f64>,
    /// True minus reference lengths, m: `[muscles]`.
    pub(super) length_error: Vec<f64>,
    /// True lengths minus those in `encoder_pose`, m: `[muscles]`; empty where motors hold every joint.
    pub(super) closure_error: Vec<f64>,
    /// What of `joint_error` no cable controls, rad or m: `[joints]`; empty where motors hold every joint.
    pub(super) off_manifold: Vec<f64>,
}

impl<'a> TrackingErrors<'a> {
    /// For the end point at a site of the design `robot`, by its index; none where only the joints are the
    /// task.
    ///
    /// # Errors
    /// As [`MuscleDynamics::new`].
    pub(super) fn new(
        specimen: &'a ArmSpecimen,
        robot: &'a Robot,
        site: Option<usize>,
    ) -> Result<Self, Error> {
        let model = MuscleDynamics::new(&specimen.robot)?;
        let (muscles, joints) = (model.muscles(), model.joints());
        let controllable = ControllableMotion::new(robot)?;
        let of = |count| if controllable.is_some() { vec![0.0; count] } else { Vec::new() };
        let site = site.and_then(|site| robot.parts().sites.get(site));
        Ok(Self {
            specimen,
            robot,
            poses: Poses::new(&specimen.robot),
            model,
            end_point_on: site.map(|site| (site.body, site.position)),
            encoder_pose: vec![0.0; joints],
            reference_point: [f64::NAN; 3],
            end_point: [f64::NAN; 3],
            encoder_point: [f64::NAN; 3],
            joint_error: vec![0.0; joints],
            length: vec![0.0; muscles],
            length_error: vec![0.0; muscles],
            closure_error: of(muscles),
            off_manifold: of(joints),
            controllable,
        })
    }

    /// Evaluates all errors for a reference and a true pose `q`, rad or m, `[joints]`, under desired
    /// tensions, N: `[muscles]`.
    ///
    /// # Errors
    /// As [`MuscleDynamics::evaluate`].
    pub(super) fn evaluate(&mut self, reference: &[f64], q: &[f64], tension: &[f64]) -> Result<(), Error> {
        for (k, (reference, encoder)) in reference.iter().zip(&self.specimen.encoders).enumerate() {
            self.encoder_pose[k] = reference - encoder.map_or(0.0, |encoder| encoder.error(*reference));
            self.joint_error[k] = q[k] - self.encoder_pose[k];
        }
        self.reference_point = self.desired_point(reference)?;
        self.model.evaluate(reference)?;
        self.length.copy_from_slice(self.model.lengths());
        self.model.evaluate(&self.encoder_pose)?;
        self.encoder_point = self.built_point()?;
        if let Some(controllable) = &mut self.controllable {
            self.closure_error.copy_from_slice(self.model.lengths());
            controllable.evaluate(&self.encoder_pose, tension)?;
            self.off_manifold.copy_from_slice(&self.joint_error);
            controllable.project(&mut self.off_manifold);
            let controlled = self.off_manifold.iter_mut().zip(&self.joint_error);
            controlled.for_each(|(off, error)| *off = error - *off);
        }
        self.model.evaluate(q)?;
        self.end_point = self.built_point()?;
        let lengths = self.model.lengths().iter().zip(&self.length);
        for (error, (true_length, reference)) in self.length_error.iter_mut().zip(lengths) {
            *error = true_length - reference;
        }
        for (error, true_length) in self.closure_error.iter_mut().zip(self.model.lengths()) {
            *error = true_length - *error;
        }
        Ok(())
    }

    /// End point of the machine as built in the evaluated pose, m.
    fn built_point(&mut self) -> Result<[f64; 3], Error> {
        let Some((body, position)) = self.end_point_on else { return Ok([f64::NAN; 3]) };
        let robot = self.model.robot();
        robot.bent_kinematics(self.model.coordinates(), &mut self.poses)?;
        Ok(robot.body_pose(&self.poses, body).point(position))
    }

    /// End point of the machine as its controller knows it, m.
    fn desired_point(&mut self, q: &[f64]) -> Result<[f64; 3], Error> {
        let Some((body, position)) = self.end_point_on else { return Ok([f64::NAN; 3]) };
        self.robot.bent_kinematics(&self.robot.pose_from_independent(q)?, &mut self.poses)?;
        Ok(self.robot.body_pose(&self.poses, body).point(position))
    }
}
