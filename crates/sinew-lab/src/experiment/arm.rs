//! An arm along a trajectory: the twin as the plant, under a controller.

use super::track_row::TrackRow;
use super::track_summary::{TrackSummary, slack_below};
use super::tracking_errors::TrackingErrors;
use sinew::Error;
use sinew::body::Robot;
use sinew::control::arm::{ArmController, ArmMeasurement, PreviewedReference};
use sinew::control::stretch::PREVIEW_HORIZON;
use sinew::control::tension::{Distribution, Problem};
use sinew::drive::DriveCommand;
use sinew::muscle::MuscleDynamics;
use sinew::trajectory::{Reference, Trajectory};
use sinew::twin::arm::{ArmSpecimen, ArmTwin, InjectedFault};

/// One run of an arm.
#[derive(Debug, Clone)]
pub struct TrackRun<'a> {
    /// The arm as built: the plant.
    pub specimen: &'a ArmSpecimen,
    /// The arm as designed: the body model of the controller.
    pub robot: &'a Robot,
    /// Index of the site whose position error is measured; none where only the joints are the task.
    pub site: Option<usize>,
    /// Tensions at the start are between these limits, N: `[muscles]`.
    pub tension_limits: &'a [[f64; 2]],
    /// Reference of the joints, from rest to rest.
    pub trajectory: &'a Trajectory,
    /// Number of repeats, one after the other.
    pub repeats: u32,
    /// Rest before the first repeat, s; not part of the errors.
    pub before: f64,
    /// Rest after the last repeat, s.
    pub after: f64,
    /// Failures of the plant; times are those of the rows.
    pub faults: &'a [InjectedFault],
    /// Seed of the sensors' noise.
    pub seed: u64,
}

/// Control cycle, s.
pub const STEP: f64 = 1e-3;

/// Runs the plant under the controller, calls `see` with every row, and returns the errors of the run.
///
/// # Errors
/// As [`TrackSession::new`] and [`TrackSession::step`].
pub fn track(
    run: &TrackRun<'_>,
    controller: ArmController,
    mut see: impl FnMut(&TrackRow<'_>),
) -> Result<TrackSummary, Error> {
    let mut session = TrackSession::new(run, controller)?;
    while session.step(&mut see)? {}
    Ok(session.finish())
}

/// A run in progress, one control cycle per step. A clone continues independently of the original.
///
/// The arm starts at rest in the first pose of the trajectory, with tensions that balance gravity and cables
/// that have slid toward their motors.
#[derive(Debug, Clone)]
pub struct TrackSession<'a> {
    run: TrackRun<'a>,
    arm: ArmTwin,
    controller: ArmController,
    errors: TrackingErrors<'a>,
    summary: TrackSummary,
    /// N: `[muscles]`.
    pretension: Vec<f64>,
    commands: Vec<DriveCommand>,
    current: Reference,
    previewed: Reference,
    cycle: u64,
}

impl<'a> TrackSession<'a> {
    /// A run before its first control cycle.
    ///
    /// # Errors
    /// As [`ArmTwin::new`], [`ArmTwin::with_faults`] and [`Trajectory::sample`] for parts of different robots;
    /// [`Error::OutOfDomain`] where an open trajectory is to be repeated.
    pub fn new(run: &TrackRun<'a>, controller: ArmController) -> Result<Self, Error> {
        let repeatable = run.repeats <= 1 || run.trajectory.is_closed();
        if !repeatable {
            let (name, expected) = ("repeats", "1 for a trajectory that does not come back");
            return Err(Error::OutOfDomain { name, expected, got: f64::from(run.repeats) });
        }
        let mut current = Reference::new(run.robot.independent_joints().len());
        run.trajectory.sample(0.0, &mut current)?;
        let tensions = resting_tensions(&run.specimen.robot, &current.q, run.tension_limits)?;
        let pretension: Vec<f64> =
            run.specimen.cables.iter().map(|cable| cable.parameters.pretension).collect();
        let least = run.tension_limits.iter().map(|[least, _]| *least);
        let slack_below = least.zip(&pretension).map(|(least, pretension)| slack_below(least, *pretension));
        Ok(Self {
            arm: ArmTwin::new(run.specimen, &current.q, &tensions, run.seed)?.with_faults(run.faults)?,
            controller,
            errors: TrackingErrors::new(run.specimen, run.robot, run.site)?,
            summary: TrackSummary::new(slack_below.collect(), current.q.len()),
            pretension,
            commands: vec![DriveCommand::Velocity(0.0); tensions.len()],
            previewed: current.clone(),
            current,
            cycle: 0,
            run: run.clone(),
        })
    }

    /// Replaces the failures of the plant.
    ///
    /// # Errors
    /// As [`ArmTwin::with_faults`].
    pub fn with_faults(mut self, faults: &[InjectedFault]) -> Result<Self, Error> {
        self.arm = self.arm.with_faults(faults)?;
        Ok(self)
    }

    /// Time of the next control cycle, s.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.cycle as f64 * STEP
    }

    /// One control cycle; `false` after the last one, and where the integration of the plant failed.
    ///
    /// # Errors
    /// As [`ArmController::step`] and [`Trajectory::sample`].
    pub fn step(&mut self, mut see: impl FnMut(&TrackRow<'_>)) -> Result<bool, Error> {
        let Self { run, arm, controller, errors, summary, current, previewed, .. } = self;
        let motion = run.trajectory.duration() * f64::from(run.repeats);
        let cycles = libm::round((run.before + motion + run.after) / STEP) as u64;
        if self.cycle >= cycles || summary.plant_failed.is_some() {
            return Ok(false);
        }
        let time = self.cycle as f64 * STEP;
        let since_start = time - run.before;
        run.trajectory.sample(time_in_repeat(run, since_start), current)?;
        run.trajectory.sample(time_in_repeat(run, since_start + PREVIEW_HORIZON), previewed)?;
        let moving = since_start >= 0.0 && since_start < motion;
        let repeat = moving.then(|| (since_start / run.trajectory.duration()) as u32);
        let reading = arm.reading();
        let measurement =
            ArmMeasurement { motor: &reading.motor, tension: &reading.tension, joint: &reading.joint };
        let reference = PreviewedReference {
            current,
            previewed,
            repeat_time: repeat.map(|_| time_in_repeat(run, since_start)),
        };
        let command = controller.step(STEP, &measurement, &reference)?;
        self.commands.copy_from_slice(command.drives);
        errors.evaluate(&current.q, arm.truth().q)?;
        let row = TrackRow {
            time,
            repeat,
            rested: (since_start - motion).max(0.0),
            reference: current,
            reference_point: errors.reference_point,
            end_point: errors.end_point,
            encoder_point: errors.encoder_point,
            joint_error: &errors.joint_error,
            pretension: &self.pretension,
            length: &errors.length,
            length_error: &errors.length_error,
            command: &command,
            reading,
            truth: &arm.truth(),
        };
        summary.record(&row);
        see(&row);
        self.cycle += 1;
        if arm.step(&self.commands, STEP).is_err() {
            summary.plant_failed = Some(time);
        }
        Ok(summary.plant_failed.is_none())
    }

    /// The errors of the control cycles so far.
    #[must_use]
    pub fn finish(self) -> TrackSummary {
        self.summary
    }
}

/// Time within the present repeat, s; its ends at rest before the first and after the last.
fn time_in_repeat(run: &TrackRun<'_>, since_start: f64) -> f64 {
    let duration = run.trajectory.duration();
    if since_start >= duration * f64::from(run.repeats) { duration } else { since_start.max(0.0) % duration }
}

/// Tensions that balance gravity in a pose, N: `[muscles]`, between these limits, a fifth of the least
/// ones above them.
///
/// # Errors
/// [`sinew::Error::WrongLength`] where the pose is another robot's.
pub fn resting_tensions(robot: &Robot, q: &[f64], limits: &[[f64; 2]]) -> Result<Vec<f64>, Error> {
    let mut model = MuscleDynamics::new(robot)?;
    let (n, joints) = (model.muscles(), model.joints());
    let (zero, mut torque) = (vec![0.0; joints], vec![0.0; joints]);
    model.evaluate(q)?;
    model.inverse_dynamics(&zero, &zero, &mut torque)?;
    let (minimum, maximum): (Vec<f64>, Vec<f64>) =
        limits.iter().map(|[least, most]| ((1.0 + RESTING_SHARE) * least, *most)).unzip();
    let maximum: Vec<f64> = maximum.iter().zip(&minimum).map(|(most, least)| most.max(*least)).collect();
    let problem = Problem {
        moment_arms: model.moment_arms(),
        torque: &torque,
        minimum: &minimum,
        maximum: &maximum,
        reference: &vec![0.0; n],
        weight: &vec![1.0; n],
    };
    Ok(Distribution::new(n, joints).solve(&problem)?.tension.to_vec())
}

/// Share by which the tensions of a machine at rest before a run exceed the least desired ones.
const RESTING_SHARE: f64 = 0.2;
