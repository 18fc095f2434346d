use sinew::Error;
use sinew::body::{Poses, Robot};
use sinew::muscle::{Geometry, Muscles};
use sinew::twin::arm::ArmSpecimen;

/// Errors of end point and muscle lengths, evaluated on the arm as built.
#[derive(Debug, Clone)]
pub(super) struct TrackingErrors<'a> {
    specimen: &'a ArmSpecimen,
    poses: Poses,
    muscles: Muscles,
    geometry: Geometry,
    body: usize,
    /// Position of the end point on its body, m.
    position: [f64; 3],
    /// Pose in which every encoder reads its reference, rad.
    encoder_pose: Vec<f64>,
    /// End point of the reference, of the true pose, and of the pose in which every encoder reads its
    /// reference, m.
    pub(super) reference_point: [f64; 3],
    pub(super) end_point: [f64; 3],
    pub(super) encoder_point: [f64; 3],
    /// Lengths in the reference, and true minus reference lengths, m: `[muscles]`.
    pub(super) length: Vec<f64>,
    pub(super) length_error: Vec<f64>,
}

impl<'a> TrackingErrors<'a> {
    /// For a site of the design, `robot`.
    pub(super) fn new(specimen: &'a ArmSpecimen, robot: &Robot, site: usize) -> Self {
        let built = &specimen.robot;
        let muscles = Muscles::new(built);
        let site = &robot.parts().sites[site];
        Self {
            specimen,
            poses: Poses::new(built),
            geometry: Geometry::new(built, &muscles),
            body: site.body,
            position: site.position,
            encoder_pose: vec![0.0; built.nv()],
            reference_point: [0.0; 3],
            end_point: [0.0; 3],
            encoder_point: [0.0; 3],
            length: vec![0.0; muscles.count()],
            length_error: vec![0.0; muscles.count()],
            muscles,
        }
    }

    /// Evaluates all errors for a reference and a true pose, rad.
    pub(super) fn evaluate(&mut self, reference: &[f64], q: &[f64]) -> Result<(), Error> {
        let built = &self.specimen.robot;
        let readings = reference.iter().zip(&self.specimen.encoders);
        for (angle, (reference, encoder)) in self.encoder_pose.iter_mut().zip(readings) {
            *angle = reference - encoder.zero;
        }
        let poses = [
            (reference, &mut self.reference_point),
            (q, &mut self.end_point),
            (self.encoder_pose.as_slice(), &mut self.encoder_point),
        ];
        for (q, point) in poses {
            built.forward_kinematics(q, &mut self.poses)?;
            *point = built.body_pose(&self.poses, self.body).point(self.position);
        }
        self.muscles.evaluate(reference, &mut self.geometry)?;
        self.length.copy_from_slice(self.geometry.lengths());
        self.muscles.evaluate(q, &mut self.geometry)?;
        let lengths = self.geometry.lengths().iter().zip(&self.length);
        for (error, (true_length, reference)) in self.length_error.iter_mut().zip(lengths) {
            *error = true_length - reference;
        }
        Ok(())
    }
}
