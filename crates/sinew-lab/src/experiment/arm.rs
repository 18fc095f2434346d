//! An arm along a trajectory: the twin as the plant, under a controller.

use super::evaluation::Evaluation;
use super::track_row::TrackRow;
use super::track_summary::TrackSummary;
use sinew::Error;
use sinew::body::Robot;
use sinew::control::arm::{ArmController, ArmMeasurement, PreviewedReference};
use sinew::control::stretch::PREVIEW_HORIZON;
use sinew::control::tension::{Distribution, Problem};
use sinew::drive::DriveCommand;
use sinew::muscle::MuscleDynamics;
use sinew::trajectory::{Reference, Schedule, Trajectory};
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
    schedule: Schedule<'a>,
    arm: ArmTwin,
    controller: ArmController,
    evaluation: Evaluation<'a>,
    commands: Vec<DriveCommand>,
    current: Reference,
    previewed: Reference,
    cycle: u64,
}

impl<'a> TrackRun<'a> {
    /// When the reference rests and moves.
    ///
    /// # Errors
    /// As [`Schedule::new`].
    pub fn schedule(&self) -> Result<Schedule<'a>, Error> {
        Schedule::new(self.trajectory, self.repeats, self.before, self.after)
    }

    /// The plant at the start of the run.
    ///
    /// # Errors
    /// As [`ArmTwin::new`], [`ArmTwin::with_faults`] and [`Trajectory::sample`] for parts of different robots.
    pub fn plant(&self) -> Result<ArmTwin, Error> {
        let mut start = Reference::new(self.trajectory.joints());
        self.trajectory.sample(0.0, &mut start)?;
        let tensions = resting_tensions(&self.specimen.robot, &start.q, self.tension_limits)?;
        ArmTwin::new(self.specimen, &start.q, &tensions, self.seed)?.with_faults(self.faults)
    }
}

impl<'a> TrackSession<'a> {
    /// A run before its first control cycle.
    ///
    /// # Errors
    /// As [`TrackRun::schedule`] and [`TrackRun::plant`].
    pub fn new(run: &TrackRun<'a>, controller: ArmController) -> Result<Self, Error> {
        let schedule = run.schedule()?;
        let current = Reference::new(run.robot.independent_joints().len());
        let arm = run.plant()?;
        Ok(Self {
            commands: vec![DriveCommand::Velocity(0.0); arm.specimen().drives.len()],
            arm,
            controller,
            evaluation: Evaluation::new(run)?,
            previewed: current.clone(),
            current,
            cycle: 0,
            schedule,
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
        let time = self.time();
        let Self { schedule, arm, controller, evaluation, current, previewed, .. } = self;
        let cycles = libm::round(schedule.duration() / STEP) as u64;
        if self.cycle >= cycles || evaluation.summary().plant_failed.is_some() {
            return Ok(false);
        }
        let moment = schedule.sample(time, PREVIEW_HORIZON, current, previewed)?;
        let reading = arm.reading();
        let measurement =
            ArmMeasurement { motor: &reading.motor, tension: &reading.tension, joint: &reading.joint };
        let reference = PreviewedReference { current, previewed, repeat_time: moment.repeat_time };
        let command = controller.step(STEP, &measurement, &reference)?;
        self.commands.copy_from_slice(command.drives);
        see(&evaluation.record(&moment, current, &command, arm)?);
        self.cycle += 1;
        let failed = arm.step(&self.commands, STEP).is_err();
        if failed {
            evaluation.plant_failed(time);
        }
        Ok(!failed)
    }

    /// The errors of the control cycles so far.
    #[must_use]
    pub fn finish(self) -> TrackSummary {
        self.evaluation.finish()
    }
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
