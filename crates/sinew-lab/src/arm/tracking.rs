//! One tracking run: an arm sampled from a seed, calibrated cable by cable, and controlled along a
//! trajectory.

use super::by_current::with_gears;
use super::calibrate::{CalibrationProgramme, calibrate_arm};
use super::controller::{Parts, controller};
use super::outcome::joint_error_limits;
use super::report::TrackingNumbers;
use super::trace::{Trace, TraceRow};
use crate::experiment::arm::{TrackRun, TrackSession};
use crate::experiment::{TrackRow, TrackSummary, oracle_models};
use crate::{CompensationVariant, Error};
use sinew::control::arm::{ArmController, ArmGains, synthesize};
use sinew::control::supervisor::{Limits, Supervisor};
use sinew::machine::{Characteristics, Machine};
use sinew::predictor::CableModel;
use sinew::trajectory::{Reference, Trajectory};
use sinew::twin::arm::{ArmSpecimen, InjectedFault};
use sinew_identify::gear::GearFit;

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
    /// Failures that the plant is subjected to; the motion begins at [`INITIAL_REST_S`] s, or
    /// after the way to its first pose.
    pub faults: &'a [InjectedFault],
    /// Gains of the controller; none: derived for the trajectory.
    pub gains: Option<&'a ArmGains>,
    /// Sampling interval of the trace, s, at least a period of the control cycle.
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
    /// Losses of the gear of every muscle without a load cell, which its calibration has identified:
    /// `[muscles]`.
    pub gears: Vec<Option<GearFit>>,
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
        let specimen = ArmSpecimen::sampled_around(&design, machine, seed)?;
        let programmes = calibration_programmes(machine, &design)?;
        let muscles = calibrate_arm(&specimen, machine, &design, &programmes, seed)?;
        let (models, gears) = muscles.into_iter().map(|muscle| (muscle.cable, muscle.gear)).unzip();
        let bare = Machine { payload: 0.0, ..machine.clone() };
        let normal_errors = Vec::new();
        Self { machine: bare, specimen, models, gears, programmes, seed, normal_errors }
            .loaded(machine.payload)
    }

    /// The same with a controller that knows another geometry of the machine, as a calibration found it.
    ///
    /// # Errors
    /// As [`Machine::loaded`].
    pub fn known_as(mut self, calibrated: &Machine) -> Result<Self, Error> {
        self.machine = with_gears(calibrated.loaded()?, &self.gears);
        Ok(self)
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
        arm.machine = with_gears(Machine { payload, ..arm.machine }.loaded()?, &self.gears);
        Ok(arm)
    }

    /// The same, judged in joint space by what is normal for its motion: the largest error of every joint in
    /// its verification, rad or m: `[joints]`, or empty where it is not known; see
    /// [`VerifiedMotion::joint_errors`](super::VerifiedMotion::joint_errors).
    #[must_use]
    pub fn with_normal_errors(self, joint_errors: Vec<f64>) -> Self {
        Self { normal_errors: joint_errors, ..self }
    }

    /// Largest error of every joint of a run that counts as completed, rad or m: `[joints]`; infinite for one
    /// without a range.
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
    /// Rad or m: `[joints]`.
    standing: Vec<f64>,
}

impl<'a> PreparedRun<'a> {
    /// The controller of a variant for a task.
    ///
    /// # Errors
    /// [`Error::Physics`] where trajectory and arm are not of one robot; as [`calibrate_arm`] where networks
    /// are trained.
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
        let standing = arm.machine.standing(task.trajectory)?;
        Ok(Self { controller, gains, arm, task: task.clone(), tension_limits, standing })
    }

    /// The controller under the supervisor of the machine.
    ///
    /// # Errors
    /// As [`Limits::from_machine`] and [`Supervisor::new`].
    pub fn supervisor(&self) -> Result<Supervisor, Error> {
        let limits = Limits::from_machine(&self.arm.machine, self.controller.gains())?;
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
            standing: Some(&self.standing),
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
/// As [`PreparedRun::new`], [`PreparedRun::supervisor`] and [`TrackSession::step`].
pub fn track_arm(
    arm: &CalibratedArm,
    variant: CompensationVariant,
    task: &TrackingTask<'_>,
) -> Result<TrackingResult, Error> {
    let prepared = PreparedRun::new(arm, variant, task)?;
    let stride = (task.trace_interval / arm.machine.period).round().clamp(1.0, 1e9) as u64;
    let (mut trace, mut count) = (Vec::new(), 0_u64);
    let run = prepared.run();
    let mut session = TrackSession::supervised(&run, prepared.supervisor()?)?;
    let mut see = |row: &TrackRow<'_>| {
        if count.is_multiple_of(stride) {
            trace.push(TraceRow::new(row, &arm.machine.robot));
        }
        count += 1;
    };
    while session.step(&mut see)? {}
    let summary = session.finish();
    let numbers =
        TrackingNumbers::new(&summary, &arm.machine, &prepared.tension_limits, &arm.joint_error_limits())?;
    Ok(TrackingResult { numbers, summary, trace })
}
