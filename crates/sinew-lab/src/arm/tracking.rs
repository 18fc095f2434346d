use super::calibrate::calibrate_arm;
use super::report::{Trace, TraceRow, TrackingNumbers};
use super::residual::calibrate_residuals;
use super::variant::Variant;
use crate::Error;
use crate::experiment::TrackSummary;
use crate::experiment::arm::{TrackRow, TrackRun, oracle_models, track};
use sinew::body::Robot;
use sinew::control::arm::ArmController;
use sinew::predictor::CableModel;
use sinew::trajectory::{Reference, Trajectory};
use sinew::twin::arm::{ArmSpecimen, Fault};

/// What is to be walked.
#[derive(Debug, Clone)]
pub struct Walk<'a> {
    /// Where the joints are to be.
    pub trajectory: &'a Trajectory,
    /// The site that follows the path.
    pub site: usize,
    /// How often.
    pub repeats: u32,
    /// Whether what a repeat showed helps the next.
    pub learning: bool,
    /// Rest after the last, s.
    pub after: f64,
    /// What fails; the motion begins at [`BEFORE`] s.
    pub faults: &'a [Fault],
    /// Seconds between the rows of the trace, at least a millisecond.
    pub every: f64,
}

/// Rest before a motion, s.
pub const BEFORE: f64 = 3.0;

/// An arm that was built, and what was found out about it.
#[derive(Debug, Clone)]
pub struct Prepared {
    /// As designed: what the controller believes of the body.
    pub robot: Robot,
    /// As built.
    pub specimen: ArmSpecimen,
    /// What was identified of every cable.
    pub models: Vec<CableModel>,
    /// kg.
    payload: f64,
    seed: u64,
}

impl Prepared {
    /// Draws an arm around the design and calibrates it; `pose` is the one that free cables are as long as in.
    ///
    /// # Errors
    /// As [`calibrate_arm`]; [`Error::Physics`] where the robot is no arm on cables.
    pub fn new(robot: &Robot, pose: &[f64], seed: u64) -> Result<Self, Error> {
        let design = ArmSpecimen::nominal(robot, pose)?;
        let specimen = ArmSpecimen::draw(robot, pose, seed)?;
        let models = calibrate_arm(&specimen, &design, seed)?.into_iter().map(|fit| fit.model).collect();
        Ok(Self { robot: robot.clone(), specimen, models, payload: 0.0, seed })
    }

    /// The same with a point mass, kg, on a body of the robot; the controller knows what it carries.
    ///
    /// # Errors
    /// [`Error::Physics`] for a mass or a place that is none.
    pub fn with_payload(mut self, body: usize, position: [f64; 3], mass: f64) -> Result<Self, Error> {
        self.robot = self.robot.with_payload(body, position, mass)?;
        self.specimen = self.specimen.with_payload(body, position, mass)?;
        self.payload += mass;
        Ok(self)
    }
}

/// What became of a walk.
#[derive(Debug, Clone)]
pub struct Tracking {
    /// In full.
    pub summary: TrackSummary,
    /// For a report.
    pub numbers: TrackingNumbers,
    /// For figures.
    pub trace: Trace,
}

/// Walks an arm.
///
/// # Errors
/// [`Error::Physics`] where trajectory and arm are not of one robot; as [`calibrate_arm`] where networks are trained.
pub fn track_arm(arm: &Prepared, variant: Variant, walk: &Walk<'_>) -> Result<Tracking, Error> {
    let perfect;
    let models = if variant == Variant::Perfect {
        perfect = oracle_models(&arm.specimen);
        &perfect
    } else {
        &arm.models
    };
    let way = variant.way(&arm.specimen, models, arm.seed)?;
    let mut controller = ArmController::new(&arm.robot, models, variant.gains(arm.payload), way)?;
    if variant == Variant::ObserverNetwork {
        let residuals = calibrate_residuals(&arm.specimen, models, arm.seed)?;
        controller = controller.with_residuals(residuals.into_iter().map(|fit| fit.network).collect())?;
    }
    if walk.learning && walk.repeats > 1 {
        controller = controller.with_iterative_learning(walk.trajectory.duration())?;
    }
    let run = TrackRun {
        specimen: &arm.specimen,
        robot: &arm.robot,
        site: walk.site,
        trajectory: walk.trajectory,
        repeats: walk.repeats,
        before: BEFORE,
        after: walk.after,
        faults: walk.faults,
        seed: arm.seed,
    };
    let every = (walk.every * 1e3).round().clamp(1.0, 1e9) as u64;
    let (mut trace, mut count) = (Vec::new(), 0_u64);
    let summary = track(&run, &mut controller, |row| {
        if count.is_multiple_of(every) {
            trace.push(thin(row));
        }
        count += 1;
    })?;
    Ok(Tracking { numbers: TrackingNumbers::new(&summary, &arm.robot), summary, trace })
}

fn thin(row: &TrackRow<'_>) -> TraceRow {
    TraceRow {
        time_s: row.time,
        repeat: row.repeat,
        wanted_m: row.wanted,
        end_point_m: row.end_point,
        length_m: row.length.to_vec(),
        length_error_m: row.length_error.to_vec(),
        wanted_n: row.command.desired_tension.to_vec(),
        anchor_n: row.truth.cables.iter().map(|cable| cable.tension_out).collect(),
        drive_n: row.truth.cables.iter().map(|cable| cable.tension_in).collect(),
    }
}

/// The pose in which a trajectory begins.
///
/// # Errors
/// None for a trajectory that was made.
pub fn first_pose(trajectory: &Trajectory) -> Result<Vec<f64>, Error> {
    let mut first = Reference::new(trajectory.joints());
    trajectory.sample(0.0, &mut first)?;
    Ok(first.q)
}
