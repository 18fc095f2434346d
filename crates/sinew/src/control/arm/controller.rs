use super::acceleration_law::AccelerationLaw;
use super::actuation::{Actuation, ActuationInputs, ActuationMode};
use super::anchor_motion::AnchorMotion;
use super::cable_states::{CableStateSource, CableStates};
use super::end_point_integral::EndPointIntegral;
use super::fault_detector::{FaultDetector, Prediction};
use super::gains::{ArmGains, MuscleGains};
use super::isolation::Seen;
use super::joint_monitor::EncoderCheck;
use super::joint_observer::JointObserver;
use super::joint_stiffness::JointStiffness;
use super::signals::{ArmCommand, ArmMeasurement, Dimensions, PreviewedReference};
use super::status::{ArmStatus, Fault, Symptom};
use super::tension_following::TensionFollowing;
use super::unmeasured_joints::UnmeasuredJoints;
use crate::Error;
use crate::body::Robot;
use crate::control::tension::{Distribution, Problem, Settings, Status};
use crate::drive::DriveCommand;
use crate::error::check_length;
use crate::muscle::MuscleDynamics;
use crate::predictor::CableModel;
use crate::trajectory::{ControllableMotion, Reference};
use crate::transmission::SheathBend;
use alloc::vec;
use alloc::vec::Vec;

/// Tracks a reference of the joints with an arm on cables: computed muscle force with observers.
///
/// ```text
/// measurement -> fault detection -> cable observers (7, 10) -> joint observers (19, 20, 23)
///   q''_d = q''_r + w^2 (q_r - q^) + 2 zeta w (q'_r - q'^) - d_u                     (24) to (26)
///   tau   = M q''_d + c + g                                                         (23)
///   F_d   = argmin |F|^2   subject to   R^T F = tau,  F_min <= F <= F_max            (21, 22)
/// -> winch speeds, or drive tensions (8)
/// ```
///
/// | symbol            | meaning                                         | unit         |
/// |-------------------|-------------------------------------------------|--------------|
/// | q_r, q^           | reference and estimated joint angles              | rad          |
/// | d_u               | compensated disturbance                           | rad/s^2      |
/// | w, zeta           | [`ArmGains`]                                      | rad/s, 1     |
/// | tau, M, c, g      | torque, inertia, velocity and gravity terms        | Nm, kg m^2, Nm, Nm |
/// | F, R              | tensions at the anchors, moment arms `-dl/dq`       | N, m         |
///
/// Where cables leave joints to springs, the errors `q_r - q^` and `q'_r - q'^` are what of them the cables
/// control by [`ControllableMotion`], and the tensions those with `(R S)^T F = S^T tau`.
///
/// # Departs
/// `yuan2023` commands the drives' tensions without knowing the far ones; see [`ActuationMode`] for both.
///
/// # Source
/// `yuan2023`, eqs. 19 to 26, corrected; observers and the law of the winches are our own.
#[derive(Debug, Clone)]
pub struct ArmController {
    gains: ArmGains,
    source: CableStateSource,
    dimensions: Dimensions,
    faults: FaultDetector,
    unmeasured: UnmeasuredJoints,
    body: MuscleDynamics,
    cables: CableStates,
    stiffness: JointStiffness,
    joints: JointObserver,
    law: AccelerationLaw,
    /// Where cables leave joints to springs: what of their motion the motors control.
    controllable: Option<ControllableMotion>,
    end_point: Option<EndPointIntegral>,
    anchors: AnchorMotion,
    distribution: Distribution,
    actuation: Actuation,
    tensions: TensionFollowing,
    started: bool,
    disturbance_initialized: bool,
    /// Time since sensors were held against each other, s.
    since_isolation: f64,
    /// Whether the reference is at rest and the arm near it.
    at_rest: bool,
    /// Whether, beside that, all errors are within their tolerances.
    holding: bool,
    reached: Status,
    /// Force that accelerates the joints by the model under the estimated tensions, Nm: `[joints]`.
    model_force: Vec<f64>,
    /// `tau`, Nm: `[joints]`.
    torque: Vec<f64>,
    /// `S^T tau`, Nm, of fewer motors than joints: `[coordinates]`.
    controllable_torque: Vec<f64>,
    /// `F_d`, `F_min`, `F_max`, N: `[muscles]`.
    desired_tension: Vec<f64>,
    min_tension: Vec<f64>,
    max_tension: Vec<f64>,
    ones: Vec<f64>,
    zeros: Vec<f64>,
}

/// Multiplications allowed to the tension distribution in one cycle, per group of joints: a fraction of a
/// millisecond. Attainable torques of an arm need some thousands.
const MAX_OPERATIONS: u64 = 1_000_000;

/// Factor of the tolerances of the joint encoders where estimated far tensions are not fed back: the arm
/// oscillates more.
const TOLERANCE_WITHOUT_ESTIMATES: f64 = 2.5;

/// Largest speed of a reference at rest, rad/s or m/s.
const REST_REFERENCE_SPEED: f64 = 1e-9;

/// What the controller has observed in a control cycle: `[muscles]` but where stated.
#[derive(Debug, Clone, Copy)]
pub(in crate::control) struct Observed<'a> {
    /// Moment arms in the estimated pose, m: `[muscles x joints]`.
    pub(in crate::control) moment_arms: &'a [f64],
    /// Lengths of the muscles in the estimated pose, m.
    pub(in crate::control) lengths: &'a [f64],
    /// Accepted or continued motor positions, m.
    pub(in crate::control) motor: &'a [f64],
    /// Accepted coordinates, rad or m; NaN where rejected: `[joints]`.
    pub(in crate::control) joint: &'a [f64],
    /// Accepted tensions at the drives' outlets, N; NaN where rejected.
    pub(in crate::control) tension: &'a [f64],
    /// The same, estimated.
    pub(in crate::control) tension_in: &'a [f64],
    /// Estimated tensions at the anchors, N.
    pub(in crate::control) tension_out: &'a [f64],
    /// Travel of the winch in addition to its encoder's that explains the tensions, m.
    pub(in crate::control) unexplained: &'a [f64],
    /// Drag that the cables' observers have learned, as a multiple of the law's, 1.
    pub(in crate::control) drag_factor: &'a [f64],
    /// Measured less estimated coordinates, rad or m; 0 without a measurement: `[joints]`.
    pub(in crate::control) joint_innovation: &'a [f64],
    /// Nm or N: `[joints]`.
    pub(in crate::control) disturbance_torque: &'a [f64],
    /// Estimated speed of the anchors, m/s, + toward the motor.
    pub(in crate::control) anchor_speed: &'a [f64],
    /// How the sensor or drive of the present fault behaves.
    pub(in crate::control) symptom: Symptom,
}

/// Models with the gain of the load cell's correction that the machine allows.
fn corrected(models: &[CableModel], gains: &ArmGains) -> Vec<CableModel> {
    let corrected = |(model, gains): (&CableModel, &MuscleGains)| CableModel {
        correction: gains.correction_fraction * model.correction,
        ..model.clone()
    };
    models.iter().zip(&gains.muscles).map(corrected).collect()
}

impl ArmController {
    /// A controller in its initial state, from the nominal body and the identified model of every cable.
    ///
    /// # Errors
    /// [`Error::WrongLength`] for models or compensations of another number than muscles; as
    /// [`ArmGains::validate`] and [`CableModel::law`]; [`Error::OutOfDomain`] for no site.
    pub fn new(
        robot: &Robot,
        models: &[CableModel],
        gains: ArmGains,
        mode: ActuationMode,
    ) -> Result<Self, Error> {
        let body = MuscleDynamics::new(robot)?;
        let (muscles, joints) = (body.muscles(), body.joints());
        gains.validate(muscles, joints)?;
        check_length("models", models.len(), muscles)?;
        let source = mode.cable_state_source();
        let stiffness = JointStiffness::new(models, joints)?;
        let estimated = matches!(mode, ActuationMode::WinchSpeed(CableStateSource::Observer));
        let joint_tolerance = if estimated { 1.0 } else { TOLERANCE_WITHOUT_ESTIMATES };
        let controllable = ControllableMotion::new(robot)?;
        let coordinates = controllable.as_ref().map_or(joints, ControllableMotion::count);
        Ok(Self {
            source,
            dimensions: Dimensions { muscles, joints },
            faults: FaultDetector::new(&stiffness.cables, &gains, joint_tolerance),
            unmeasured: UnmeasuredJoints::new(&body, &gains, &stiffness.cables),
            cables: CableStates::new(&corrected(models, &gains), source, joints)?,
            stiffness,
            joints: JointObserver::new(models, &gains)?,
            law: AccelerationLaw::new(joints),
            end_point: gains.end_point.map(|gains| EndPointIntegral::new(robot, gains)).transpose()?,
            anchors: AnchorMotion::new(muscles),
            distribution: Distribution::with_settings(
                muscles,
                coordinates,
                &Settings { max_operations: MAX_OPERATIONS, ..Settings::default() },
            ),
            actuation: Actuation::new(muscles, mode)?,
            tensions: TensionFollowing::new(muscles),
            started: false,
            disturbance_initialized: false,
            since_isolation: 0.0,
            at_rest: false,
            holding: false,
            reached: Status::Optimal,
            model_force: vec![0.0; joints],
            torque: vec![0.0; joints],
            controllable_torque: vec![0.0; coordinates],
            controllable,
            desired_tension: vec![0.0; muscles],
            min_tension: gains.muscles.iter().map(|muscle| muscle.tension[0]).collect(),
            max_tension: gains.muscles.iter().map(|muscle| muscle.tension[1]).collect(),
            ones: vec![1.0; muscles],
            zeros: vec![0.0; muscles],
            body,
            gains,
        })
    }

    /// Adds iterative learning control over the repeats of a motion of this duration, s.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] outside of (0, 3600].
    pub fn with_iterative_learning(mut self, duration: f64) -> Result<Self, Error> {
        self.actuation.set_learning(duration)?;
        Ok(self)
    }

    /// Lets the bends of the sheaths that pass joints follow the estimated pose: `[muscles]`, as designed.
    /// The friction angle of a model holds in the bends' reference, in which it was identified, and changes
    /// in proportion to the bend.
    ///
    /// # Errors
    /// [`Error::WrongLength`] for bends of another number than muscles; as [`SheathBend::scaled_to`].
    pub fn with_sheath_bends(mut self, bends: &[SheathBend]) -> Result<Self, Error> {
        self.cables.set_sheath_bends(bends)?;
        Ok(self)
    }

    /// Tensions at the anchors to be followed from the next control cycle on, N, within the gains' limits:
    /// `[muscles]`; none lets the joints follow their reference again. The reference is to be the estimated
    /// pose meanwhile.
    ///
    /// # Errors
    /// [`Error::WrongLength`], [`Error::OutOfDomain`] for tensions that are not finite.
    pub fn set_tensions(&mut self, tensions: Option<&[f64]>) -> Result<(), Error> {
        self.tensions.set(tensions)
    }

    /// Number of muscles and of independent joints.
    #[must_use]
    pub fn dimensions(&self) -> [usize; 2] {
        [self.dimensions.muscles, self.dimensions.joints]
    }

    /// Stops the arm for a fault that was found outside of the controller: from the next control cycle on its
    /// winches are braked to rest. A controller that has stopped keeps its first fault.
    pub fn stop(&mut self, fault: Fault) {
        self.faults.stop(fault, Symptom::Reported);
    }

    /// The same with the way in which the fault showed.
    pub(in crate::control) fn stop_as(&mut self, fault: Fault, symptom: Symptom) {
        self.faults.stop(fault, symptom);
    }

    /// Checks the lengths of all slices of a control cycle, and that the references are finite.
    pub(in crate::control) fn check(
        &self,
        measurement: &ArmMeasurement<'_>,
        reference: &PreviewedReference<'_>,
    ) -> Result<(), Error> {
        self.dimensions.check(measurement, reference)
    }

    /// Its gains, limits and thresholds.
    #[must_use]
    pub fn gains(&self) -> &ArmGains {
        &self.gains
    }

    /// The next control cycle is its first: observers, detected faults and the state of the winches' laws
    /// begin anew. What iterative learning has learned is kept. Nothing is allocated.
    pub fn restart(&mut self) {
        self.faults.restart();
        self.unmeasured.restart();
        self.cables.restart();
        self.actuation.restart();
        self.law.error.fill(0.0);
        self.end_point.iter_mut().for_each(EndPointIntegral::restart);
        self.anchors.slip.fill(0.0);
        (self.started, self.disturbance_initialized, self.since_isolation) = (false, false, 0.0);
        (self.at_rest, self.holding) = (false, false);
    }

    /// The robot that it controls, as designed.
    #[must_use]
    pub fn robot(&self) -> &Robot {
        self.body.robot()
    }

    /// Takes the measured coordinates, rad or m: `[joints]`, for its estimates, in modes in which it does not
    /// command; far tensions are then not estimated (NaN).
    pub(in crate::control) fn observe_pose(&mut self, joint: &[f64]) {
        let measured = self.joints.q.iter_mut().zip(joint).filter(|(_, measured)| measured.is_finite());
        measured.for_each(|(q, measured)| *q = *measured);
        self.joints.v.fill(0.0);
        self.cables.tension_out.fill(f64::NAN);
        self.desired_tension.fill(0.0);
    }

    /// These commands with what the controller's last cycle left: for modes in which it does not command.
    #[must_use]
    pub(in crate::control) fn outputs<'a>(
        &'a self,
        drives: &'a [DriveCommand],
        status: ArmStatus,
    ) -> ArmCommand<'a> {
        ArmCommand {
            drives,
            desired_tension: &self.desired_tension,
            estimated_tension: &self.cables.tension_out,
            q: &self.joints.q,
            distribution: self.reached,
            status,
        }
    }

    /// The sensors that explain a limit that has been passed, if any do.
    #[must_use]
    pub(in crate::control) fn cause_of(&self, found: Fault) -> Option<Fault> {
        self.faults.isolation.cause_of(found)
    }

    /// Observed state of the cables and of the joints in the last control cycle.
    #[must_use]
    pub(in crate::control) fn observed(&self) -> Observed<'_> {
        Observed {
            moment_arms: self.body.moment_arms(),
            lengths: self.body.lengths(),
            motor: &self.faults.motor,
            joint: &self.faults.joint,
            tension: &self.faults.tension,
            tension_in: &self.cables.tension_in,
            tension_out: &self.cables.tension_out,
            unexplained: &self.cables.unexplained,
            drag_factor: &self.cables.drag_factor,
            joint_innovation: &self.joints.innovation,
            disturbance_torque: &self.stiffness.disturbance_torque,
            anchor_speed: &self.anchors.estimated,
            symptom: self.faults.symptom,
        }
    }

    /// Whether a whole cable slid in one direction in the last control cycle.
    pub(in crate::control) fn slides(&self, cable: usize) -> bool {
        self.cables.slides(cable)
    }

    /// The law of a cable at its present wrap angles and bend.
    pub(in crate::control) fn cable_law(
        &self,
        cable: usize,
    ) -> Result<&crate::transmission::cable::CableLaw, Error> {
        self.cables.law(cable)
    }

    /// Operating state of the arm.
    #[must_use]
    pub fn status(&self) -> ArmStatus {
        match self.faults.status {
            ArmStatus::Following if self.holding => ArmStatus::Holding,
            status => status,
        }
    }

    /// One control cycle: the commands for the `h` s to come, from measurements and references at their
    /// beginning. Nothing is allocated.
    ///
    /// # Errors
    /// [`Error::WrongLength`] for slices of another robot; [`Error::EntryOutOfDomain`] for references that
    /// are not finite.
    pub fn step(
        &mut self,
        h: f64,
        measurement: &ArmMeasurement<'_>,
        reference: &PreviewedReference<'_>,
    ) -> Result<ArmCommand<'_>, Error> {
        self.dimensions.check(measurement, reference)?;
        self.detect_faults(h, measurement, reference.current);
        if self.faults.is_stopped() {
            self.actuation.brake(h, &self.gains.muscles);
        } else {
            self.estimate_cables(h, reference.current)?; // (7), (10) at the lengths of (19)
            self.estimate_joints(h)?; // (21), (23)
            self.isolate_faults(h)?;
            self.evaluate_errors(h, reference)?; // (24), and (20)
            self.detect_rest(reference);
            self.law.evaluate(&self.gains, reference.current, self.at_rest); // (25), (26)
            self.evaluate_torque()?; // (23)
            self.distribute_tensions(h)?; // (22)
            self.command_drives(h, reference.repeat_time)?; // (8), or the law of the winches
        }
        Ok(ArmCommand {
            drives: &self.actuation.drives,
            desired_tension: &self.desired_tension,
            estimated_tension: &self.cables.tension_out,
            q: &self.joints.q,
            distribution: self.reached,
            status: self.status(),
        })
    }

    fn detect_faults(&mut self, h: f64, measurement: &ArmMeasurement<'_>, reference: &Reference) {
        self.unmeasured.update(h, measurement.tension, &self.cables.tension_in, &self.body);
        let prediction = Prediction {
            winch_speed: &self.actuation.winch_speed,
            tension_in: &self.cables.tension_in,
            tension_out: &self.cables.tension_out,
            unexplained_speed: &self.cables.unexplained_speed,
            joint: [&self.joints.q, &self.joints.v, &self.joints.disturbance],
            disturbance_torque: &self.stiffness.disturbance_torque,
            joint_stiffness: &self.stiffness.joints,
            reference,
            unmeasured: &self.unmeasured,
        };
        self.faults.update(h, measurement, &prediction);
    }

    /// Far tensions and stretches, in the pose estimated last.
    fn estimate_cables(&mut self, h: f64, reference: &Reference) -> Result<(), Error> {
        self.bridge_joints(h, reference);
        self.body.evaluate(&self.joints.q)?;
        let accepted = (&self.faults.motor[..], &self.faults.tension[..]);
        self.cables.update(h, accepted, (&self.body, &self.joints.q), &self.desired_tension)
    }

    /// Prepares the joint observers for encoders that were rejected or have returned. Without estimated far
    /// tensions the model does not hold a joint to its muscles: it then follows its reference's speed.
    fn bridge_joints(&mut self, h: f64, reference: &Reference) {
        if !self.started {
            self.started = true;
            for (angle, reference) in self.faults.joint.iter_mut().zip(&reference.q) {
                *angle = if angle.is_finite() { *angle } else { *reference };
            }
            self.joints.initialize(&self.faults.joint);
        }
        for (k, check) in self.faults.checks.iter().enumerate() {
            match *check {
                EncoderCheck::Accepted | EncoderCheck::Rejected | EncoderCheck::Absent => {}
                EncoderCheck::Returned => self.joints.q[k] = self.faults.joint[k],
                EncoderCheck::Withdrawn { shift, disturbance } => {
                    self.joints.q[k] += shift;
                    self.joints.disturbance[k] = disturbance;
                    if shift != 0.0 {
                        self.joints.v[k] = reference.v[k];
                    }
                }
            }
            if self.source == CableStateSource::Encoders && self.faults.joint[k].is_nan() {
                self.faults.joint[k] = self.joints.q[k] + h * reference.v[k];
            }
        }
    }

    /// Angles, velocities and disturbances of the joints under the estimated tensions.
    fn estimate_joints(&mut self, h: f64) -> Result<(), Error> {
        let Self { body, joints, cables, model_force, .. } = self;
        if !self.disturbance_initialized {
            self.disturbance_initialized = true;
            // The arm starts at rest: the disturbance balances the model's acceleration.
            body.forward_dynamics(&joints.v, &cables.tension_out, None, &mut joints.disturbance)?;
            joints.disturbance.iter_mut().for_each(|d| *d = -*d);
            self.law.initialize(&self.gains, &joints.disturbance);
        }
        body.accelerating_force(&joints.v, &cables.tension_out, model_force)?;
        joints.update(h, &self.faults.joint, model_force, body)?;
        self.stiffness.update(body, joints);
        if !self.at_rest {
            let known = self.source != CableStateSource::Encoders;
            self.law.update_disturbance(h, &self.gains, known.then_some(&joints.disturbance[..]));
        }
        Ok(())
    }

    /// Holds the sensors of every drive against each other and against the joints.
    fn isolate_faults(&mut self, h: f64) -> Result<(), Error> {
        let Self { body, cables, joints, stiffness, faults, unmeasured, .. } = self;
        self.since_isolation += h;
        let quiet = faults.isolation.is_quiet();
        if !cables.step_open_loop(h, &joints.q, &stiffness.disturbance_torque, quiet)? {
            return Ok(());
        }
        let seen = Seen {
            body,
            tension: &unmeasured.correcting,
            tension_in: &cables.tension_in,
            tension_out: &cables.tension_out,
            unexplained: &cables.unexplained,
            known: &cables.known,
            pose: &joints.q,
            joint_innovation: &joints.innovation,
            disturbance_torque: &stiffness.disturbance_torque,
            copy: cables.open_loop(),
        };
        let elapsed = core::mem::take(&mut self.since_isolation);
        match faults.isolate(elapsed, &seen) {
            Some(muscle) => cables.forget_load_cell(muscle),
            None => Ok(()),
        }
    }

    /// Errors of the joints and of the anchors.
    fn evaluate_errors(&mut self, h: f64, reference: &PreviewedReference<'_>) -> Result<(), Error> {
        let Self { law, end_point, joints, controllable, .. } = self;
        law.update_error(reference.current, &joints.q, &joints.v);
        if let Some(controllable) = controllable {
            controllable.evaluate(&joints.q, &self.desired_tension)?;
            controllable.project(&mut law.error);
            controllable.project(&mut law.speed_error);
        }
        self.faults.check_tracking(&law.error);
        if let Some(integral) = end_point {
            let h = if moves(reference) && !self.tensions.is_active() { h } else { 0.0 };
            integral.update(h, self.body.robot(), &joints.q, &law.error)?;
            law.error.iter_mut().zip(&integral.shift).for_each(|(error, shift)| *error += shift);
        }
        let filter_fraction = (h / self.gains.slip_filter_time).min(1.0);
        self.anchors.update(&self.body, reference, &self.joints, &self.law.error, filter_fraction);
        Ok(())
    }

    /// Rest begins with small errors and speeds and ends with larger errors, so that it does not toggle.
    fn detect_rest(&mut self, reference: &PreviewedReference<'_>) {
        let muscles = self.gains.muscles.iter();
        let near = if self.at_rest {
            self.anchors.is_near(muscles.map(|muscle| [muscle.rest_error[1], f64::INFINITY]))
        } else {
            self.anchors.is_near(muscles.map(|muscle| [muscle.rest_error[0], muscle.rest_speed]))
        };
        self.at_rest = !moves(reference) && near && !self.tensions.is_active();
        self.holding = self.at_rest && self.actuation.is_within_tolerance(&self.anchors);
    }

    fn evaluate_torque(&mut self) -> Result<(), Error> {
        self.body.inverse_dynamics(&self.joints.v, &self.law.output, &mut self.torque)
    }

    fn distribute_tensions(&mut self, h: f64) -> Result<(), Error> {
        if self.tensions.is_active() {
            self.tensions.advance(
                h,
                &self.gains.muscles,
                &self.cables.tension_out,
                &mut self.desired_tension,
            );
            self.reached = Status::Optimal;
            return Ok(());
        }
        let (moment_arms, torque) = match &self.controllable {
            None => (self.body.moment_arms(), &self.torque),
            Some(controllable) => {
                controllable.torque(&self.torque, &mut self.controllable_torque);
                (controllable.arms(), &self.controllable_torque)
            }
        };
        let solution = self.distribution.solve(&Problem {
            moment_arms,
            torque,
            minimum: &self.min_tension,
            maximum: &self.max_tension,
            reference: &self.zeros,
            weight: &self.ones,
        })?;
        self.desired_tension.copy_from_slice(solution.tension);
        self.reached = solution.status;
        Ok(())
    }

    fn command_drives(&mut self, h: f64, repeat_time: Option<f64>) -> Result<(), Error> {
        let inputs = ActuationInputs {
            tension: &self.desired_tension,
            anchors: &self.anchors,
            cables: &self.cables,
            lengths: self.body.lengths(),
            faults: &self.faults,
            repeat_time,
            at_rest: self.at_rest,
            tension_alone: self.tensions.integral(),
        };
        self.actuation.command(h, &self.gains, &inputs)
    }
}

/// Whether a reference moves, now or as far as it is previewed.
fn moves(reference: &PreviewedReference<'_>) -> bool {
    let mut speeds = reference.current.v.iter().chain(&reference.previewed.v);
    speeds.any(|v| v.abs() > REST_REFERENCE_SPEED)
}

#[cfg(test)]
mod tests;
