//! One tracking run: an arm drawn from a seed, calibrated cable by cable, and controlled along a trajectory.

use super::calibrate::{CalibrationProgramme, calibrate_arm};
use super::controller::{Parts, controller};
use super::outcome::joint_error_limits;
use super::report::TrackingNumbers;
use super::stop_reason::fault_name;
use super::trace::{CycleSignals, Trace, TraceRow};
use crate::experiment::arm::{TrackRun, TrackSession};
use crate::experiment::{TrackRow, TrackSummary, oracle_models};
use crate::{CompensationVariant, Error};
use sinew::body::Robot;
use sinew::control::arm::{ArmController, ArmGains, ArmStatus, synthesize};
use sinew::control::supervisor::{Limits, Mode, Request, Supervisor};
use sinew::drive::DriveCommand;
use sinew::machine::{Characteristics, Machine};
use sinew::predictor::CableModel;
use sinew::trajectory::{Reference, Trajectory};
use sinew::twin::arm::{ArmSpecimen, InjectedFault};

/// A trajectory with the conditions under which it is tracked.
#[derive(Debug, Clone)]
pub struct TrackingTask<'a> {
    /// Reference of the joints.
    pub trajectory: &'a Trajectory,
    /// Number of repeats, one after the other.
    pub repeats: u32,
    /// Whether iterative learning carries over from repeat to repeat.
    pub learning: bool,
    /// Rest after the last repeat, s.
    pub final_rest: f64,
    /// Failures that the plant is subjected to; the motion begins at [`INITIAL_REST_S`] s.
    pub faults: &'a [InjectedFault],
    /// Gains of the controller; none: derived for the trajectory.
    pub gains: Option<&'a ArmGains>,
    /// Sampling interval of the trace, s, at least a millisecond.
    pub trace_interval: f64,
}

/// Rest before a motion, s.
pub const INITIAL_REST_S: f64 = 3.0;

/// An arm as built, with the cable models that its calibration identified.
#[derive(Debug, Clone)]
pub struct CalibratedArm {
    /// As designed, with its payload: the model of the controller.
    pub machine: Machine,
    /// As built: the plant.
    pub specimen: ArmSpecimen,
    /// Identified model of every cable: `[muscles]`.
    pub models: Vec<CableModel>,
    /// Programme of every calibration: `[muscles]`.
    pub programmes: Vec<CalibrationProgramme>,
    seed: u64,
    /// As [`with_normal_errors`](Self::with_normal_errors).
    normal_errors: Vec<f64>,
}

/// Poses over the ranges of the joints that a machine is calibrated for.
const CALIBRATION_PLACES: usize = 40;
/// Poses of a motion for which gains are derived.
const MOTION_PLACES: usize = 60;

impl CalibratedArm {
    /// Draws a machine around the design, calibrates its cables, and loads it with its payload.
    ///
    /// # Errors
    /// As [`calibrate_arm`] and [`ArmSpecimen::draw`]; [`Error::Physics`] where a payload has no end point.
    pub fn new(machine: &Machine, seed: u64) -> Result<Self, Error> {
        let design = ArmSpecimen::nominal(machine)?;
        let specimen = ArmSpecimen::drawn_around(&design, machine, seed)?;
        let programmes = calibration_programmes(machine, &design)?;
        let models = calibrate_arm(&specimen, machine, &design, &programmes, seed)?;
        let bare = Machine { payload: 0.0, ..machine.clone() };
        Self { machine: bare, specimen, models, programmes, seed, normal_errors: Vec::new() }
            .loaded(machine.payload)
    }

    /// The same with a payload, kg, of an arm that was calibrated without one.
    ///
    /// # Errors
    /// [`Error::Physics`] for a payload without an end point.
    pub fn loaded(&self, payload: f64) -> Result<Self, Error> {
        let mut arm = self.clone();
        if let Some(site) = self.machine.payload_site().filter(|_| payload > 0.0) {
            let site = &self.machine.robot.parts().sites[site];
            arm.specimen = arm.specimen.with_payload(site.body, site.position, payload)?;
        }
        arm.machine = Machine { payload, ..arm.machine }.loaded()?;
        Ok(arm)
    }

    /// The same, judged in joint space by what is normal for its motion: the largest error of every joint in its verification, rad or
    /// m: `[joints]`, or empty where it is not known; see [`VerifiedMotion::joint_errors`](super::VerifiedMotion::joint_errors).
    #[must_use]
    pub fn with_normal_errors(self, joint_errors: Vec<f64>) -> Self {
        Self { normal_errors: joint_errors, ..self }
    }

    /// Largest error of every joint of a run that counts as completed, rad or m: `[joints]`; infinite for one without a range.
    #[must_use]
    pub fn joint_error_limits(&self) -> Vec<f64> {
        joint_error_limits(&self.machine, &self.normal_errors)
    }

    /// The controller of a variant for a motion.
    ///
    /// # Errors
    /// As [`gains`](Self::gains); as [`calibrate_arm`] where networks are trained.
    pub fn controller(
        &self,
        variant: CompensationVariant,
        trajectory: &Trajectory,
    ) -> Result<ArmController, Error> {
        self.controller_with(variant, self.gains(trajectory)?.0)
    }

    /// The same with these gains.
    fn controller_with(&self, variant: CompensationVariant, gains: ArmGains) -> Result<ArmController, Error> {
        let Self { machine, specimen, models, programmes, seed, .. } = self;
        controller(variant, &Parts { machine, specimen, models, programmes, gains, seed: *seed })
    }

    /// The gains for a motion, from the identified cables, with the characteristics they follow from.
    ///
    /// # Errors
    /// As [`synthesize`].
    pub fn gains(&self, trajectory: &Trajectory) -> Result<(ArmGains, Characteristics), Error> {
        Ok(synthesize(&self.machine, &self.models, &poses_along(trajectory)?)?)
    }
}

/// Poses spread evenly over the duration of a trajectory: `[places][joints]`.
pub(super) fn poses_along(trajectory: &Trajectory) -> Result<Vec<Vec<f64>>, Error> {
    let mut reference = Reference::new(trajectory.joints());
    let place = |k: usize| {
        let time = trajectory.duration() * k as f64 / (MOTION_PLACES - 1) as f64;
        trajectory.sample(time, &mut reference)?;
        Ok(reference.q.clone())
    };
    (0..MOTION_PLACES).map(place).collect()
}

/// The calibration programme of every muscle, from the design: `[muscles]`.
///
/// # Errors
/// As [`synthesize`].
pub fn calibration_programmes(
    machine: &Machine,
    design: &ArmSpecimen,
) -> Result<Vec<CalibrationProgramme>, Error> {
    let (gains, found) = synthesize(machine, &oracle_models(design), &machine.poses(CALIBRATION_PLACES)?)?;
    let muscles = gains.muscles.iter().zip(&found.muscles).zip(&machine.muscles);
    Ok(muscles
        .map(|((gains, muscle), design)| {
            CalibrationProgramme::new(muscle, gains, design.drive.winch.capacity())
        })
        .collect())
}

/// Result of a tracking run.
#[derive(Debug, Clone)]
pub struct TrackingResult {
    /// In full.
    pub summary: TrackSummary,
    /// For reports and files.
    pub numbers: TrackingNumbers,
    /// Sampled at the task's interval.
    pub trace: Trace,
}

/// A calibrated arm before a run: its controller, and what plant and evaluation need.
#[derive(Debug)]
pub struct PreparedRun<'a> {
    /// In its initial state.
    pub controller: ArmController,
    /// Its gains, before a variant without observers lowers them.
    pub gains: ArmGains,
    arm: &'a CalibratedArm,
    task: TrackingTask<'a>,
    /// N: `[muscles]`.
    tension_limits: Vec<[f64; 2]>,
}

impl<'a> PreparedRun<'a> {
    /// The controller of a variant for a task.
    ///
    /// # Errors
    /// [`Error::Physics`] where trajectory and arm are not of one robot; as [`calibrate_arm`] where networks are
    /// trained.
    pub fn new(
        arm: &'a CalibratedArm,
        variant: CompensationVariant,
        task: &TrackingTask<'a>,
    ) -> Result<Self, Error> {
        let gains = match task.gains {
            Some(gains) => gains.clone(),
            None => arm.gains(task.trajectory)?.0,
        };
        let tension_limits = gains.tension_limits();
        let mut controller = arm.controller_with(variant, gains.clone())?;
        if task.learning && task.repeats > 1 {
            controller = controller.with_iterative_learning(task.trajectory.duration())?;
        }
        Ok(Self { controller, gains, arm, task: task.clone(), tension_limits })
    }

    /// The controller under the supervisor of the machine.
    ///
    /// # Errors
    /// As [`Limits::of`] and [`Supervisor::new`].
    pub fn supervisor(&self) -> Result<Supervisor, Error> {
        let limits = Limits::of(&self.arm.machine, self.controller.gains())?;
        Ok(Supervisor::new(self.controller.clone(), limits)?)
    }

    /// Plant, reference and conditions of the run.
    #[must_use]
    pub fn run(&self) -> TrackRun<'_> {
        let CalibratedArm { machine, specimen, seed, .. } = self.arm;
        TrackRun {
            specimen,
            robot: &machine.robot,
            site: machine.task.site(),
            tension_limits: &self.tension_limits,
            trajectory: self.task.trajectory,
            repeats: self.task.repeats,
            before: INITIAL_REST_S,
            after: self.task.final_rest,
            faults: self.task.faults,
            seed: *seed,
        }
    }
}

/// Runs a tracking task with the controller of a variant.
///
/// # Errors
/// As [`PreparedRun::new`], [`PreparedRun::supervisor`] and [`track_supervised`].
///
/// [`track_supervised`]: crate::experiment::arm::track_supervised
pub fn track_arm(
    arm: &CalibratedArm,
    variant: CompensationVariant,
    task: &TrackingTask<'_>,
) -> Result<TrackingResult, Error> {
    track_arm_watched(arm, variant, task, |_| Some(Request::Run))
}

/// The same under somebody's eyes: `watch` sees every row and says what is asked of the supervisor next; none ends the run. The
/// errors are those until something else than to run is asked for.
///
/// # Errors
/// As [`track_arm`].
pub fn track_arm_watched(
    arm: &CalibratedArm,
    variant: CompensationVariant,
    task: &TrackingTask<'_>,
    mut watch: impl FnMut(&TrackRow<'_>) -> Option<Request>,
) -> Result<TrackingResult, Error> {
    let prepared = PreparedRun::new(arm, variant, task)?;
    let stride = (task.trace_interval * 1e3).round().clamp(1.0, 1e9) as u64;
    let (mut trace, mut count) = (Vec::new(), 0_u64);
    let run = prepared.run();
    let mut session = TrackSession::supervised(&run, prepared.supervisor()?)?;
    let (mut request, mut followed) = (Some(Request::Run), None);
    while let Some(asked) = request {
        if asked != Request::Run && followed.is_none() {
            followed = Some(session.clone().finish());
        }
        session.ask(asked);
        let goes_on = session.step(|row| {
            if count.is_multiple_of(stride) {
                trace.push(trace_row(row, &arm.machine.robot));
            }
            count += 1;
            request = watch(row);
        })?;
        if !goes_on {
            break;
        }
    }
    let summary = followed.unwrap_or_else(|| session.finish());
    let numbers =
        TrackingNumbers::new(&summary, &arm.machine, &prepared.tension_limits, &arm.joint_error_limits())?;
    Ok(TrackingResult { numbers, summary, trace })
}

fn trace_row(row: &TrackRow<'_>, robot: &Robot) -> TraceRow {
    TraceRow {
        time_s: row.time,
        repeat: row.repeat,
        wanted_m: row.reference_point,
        end_point_m: row.end_point,
        length_m: row.length.to_vec(),
        length_error_m: row.length_error.to_vec(),
        wanted_n: row.command.desired_tension.to_vec(),
        anchor_n: row.truth.cables.iter().map(|cable| cable.tension_out).collect(),
        drive_n: row.truth.cables.iter().map(|cable| cable.tension_in).collect(),
        cycle: CycleSignals {
            status: status(row, robot),
            joint_reference: row.reference.q.clone(),
            joint_true: row.truth.q.to_vec(),
            joint_read: row.reading.joint.clone(),
            joint_believed: row.command.q.to_vec(),
            winch_read_m: row.reading.motor.clone(),
            winch_command_m_per_s: row.command.drives.iter().map(commanded_speed).collect(),
            load_cell_n: row.reading.tension.clone(),
            anchor_believed_n: row.command.estimated_tension.to_vec(),
        },
    }
}

/// Operating state in words.
fn status(row: &TrackRow<'_>, robot: &Robot) -> String {
    if !row.mode.is_controlled() && !matches!(row.mode, Mode::SafeStop | Mode::Fault) {
        return row.mode.name().replace('_', " ");
    }
    match row.command.status {
        ArmStatus::Following => "following".to_owned(),
        ArmStatus::Holding => "holding".to_owned(),
        ArmStatus::Degraded(fault) => format!("degraded: {}", fault_name(fault, robot)),
        ArmStatus::Stopped(fault) => format!("stopped: {}", fault_name(fault, robot)),
    }
}

/// Commanded cable speed, m/s; NaN where none is commanded.
fn commanded_speed(command: &DriveCommand) -> f64 {
    match *command {
        DriveCommand::Velocity(speed) => speed,
        DriveCommand::Tension { feed, .. } => feed,
        DriveCommand::Off | DriveCommand::Brake | DriveCommand::Current(_) => f64::NAN,
    }
}
