//! One tracking run: an arm drawn from a seed, calibrated cable by cable, and controlled along a trajectory.

use super::calibrate::calibrate_arm;
use super::controller::controller;
use super::report::{Trace, TraceRow, TrackingNumbers};
use crate::experiment::arm::{TrackRun, track};
use crate::experiment::{TrackRow, TrackSummary};
use crate::{CompensationVariant, Error};
use sinew::body::Robot;
use sinew::predictor::CableModel;
use sinew::trajectory::Trajectory;
use sinew::twin::arm::{ArmSpecimen, InjectedFault};

/// A trajectory with the conditions under which it is tracked.
#[derive(Debug, Clone)]
pub struct TrackingTask<'a> {
    /// Reference of the joints.
    pub trajectory: &'a Trajectory,
    /// Index of the site whose position error is measured.
    pub site: usize,
    /// Number of repeats, one after the other.
    pub repeats: u32,
    /// Whether iterative learning carries over from repeat to repeat.
    pub learning: bool,
    /// Rest after the last repeat, s.
    pub final_rest: f64,
    /// Failures that the plant is subjected to; the motion begins at [`INITIAL_REST_S`] s.
    pub faults: &'a [InjectedFault],
    /// Sampling interval of the trace, s, at least a millisecond.
    pub trace_interval: f64,
}

/// Rest before a motion, s.
pub const INITIAL_REST_S: f64 = 3.0;

/// An arm as built, with the cable models that its calibration identified.
#[derive(Debug, Clone)]
pub struct CalibratedArm {
    /// As designed: the body model of the controller.
    pub robot: Robot,
    /// As built: the plant.
    pub specimen: ArmSpecimen,
    /// Identified model of every cable: `[muscles]`.
    pub models: Vec<CableModel>,
    /// kg.
    payload: f64,
    seed: u64,
}

impl CalibratedArm {
    /// Draws an arm around the design and calibrates it; `pose` sets the free lengths of the cables.
    ///
    /// # Errors
    /// As [`calibrate_arm`]; [`Error::Physics`] where the robot has no cables in sheaths.
    pub fn new(robot: &Robot, pose: &[f64], seed: u64) -> Result<Self, Error> {
        let design = ArmSpecimen::nominal(robot, pose)?;
        let specimen = ArmSpecimen::draw(robot, pose, seed)?;
        let models = calibrate_arm(&specimen, &design, seed)?.into_iter().map(|fit| fit.model).collect();
        Ok(Self { robot: robot.clone(), specimen, models, payload: 0.0, seed })
    }

    /// The same with a point mass, kg, on a body of the robot; plant and controller have the same payload.
    ///
    /// # Errors
    /// [`Error::Physics`] for an invalid mass, position or body.
    pub fn with_payload(mut self, body: usize, position: [f64; 3], mass: f64) -> Result<Self, Error> {
        self.robot = self.robot.with_payload(body, position, mass)?;
        self.specimen = self.specimen.with_payload(body, position, mass)?;
        self.payload += mass;
        Ok(self)
    }
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

/// Runs a tracking task with the controller of a variant.
///
/// # Errors
/// [`Error::Physics`] where trajectory and arm are not of one robot; as [`calibrate_arm`] where networks are
/// trained.
pub fn track_arm(
    arm: &CalibratedArm,
    variant: CompensationVariant,
    task: &TrackingTask<'_>,
) -> Result<TrackingResult, Error> {
    let CalibratedArm { robot, specimen, models, payload, seed } = arm;
    let mut controller = controller(variant, robot, specimen, models, *payload, *seed)?;
    if task.learning && task.repeats > 1 {
        controller = controller.with_iterative_learning(task.trajectory.duration())?;
    }
    let run = TrackRun {
        specimen,
        robot,
        site: task.site,
        trajectory: task.trajectory,
        repeats: task.repeats,
        before: INITIAL_REST_S,
        after: task.final_rest,
        faults: task.faults,
        seed: *seed,
    };
    let stride = (task.trace_interval * 1e3).round().clamp(1.0, 1e9) as u64;
    let (mut trace, mut count) = (Vec::new(), 0_u64);
    let summary = track(&run, controller, |row| {
        if count.is_multiple_of(stride) {
            trace.push(trace_row(row));
        }
        count += 1;
    })?;
    Ok(TrackingResult { numbers: TrackingNumbers::new(&summary, robot), summary, trace })
}

fn trace_row(row: &TrackRow<'_>) -> TraceRow {
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
    }
}
