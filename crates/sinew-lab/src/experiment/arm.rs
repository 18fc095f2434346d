//! An arm along a trajectory: the twin as the plant, under a controller.

use super::oracle::CableTruth;
use super::track_row::TrackRow;
use super::track_summary::TrackSummary;
use super::tracking_errors::TrackingErrors;
use sinew::Error;
use sinew::body::{Robot, Scratch};
use sinew::control::arm::{ArmController, ArmMeasurement, PreviewedReference};
use sinew::control::stretch::PREVIEW_HORIZON;
use sinew::control::tension::{Distribution, Problem};
use sinew::drive::DriveCommand;
use sinew::muscle::{Geometry, Muscles};
use sinew::trajectory::{Reference, Trajectory};
use sinew::twin::arm::{ArmSpecimen, ArmTwin, InjectedFault};

/// One run of an arm.
#[derive(Debug, Clone)]
pub struct TrackRun<'a> {
    /// The arm as built: the plant.
    pub specimen: &'a ArmSpecimen,
    /// The arm as designed: the body model of the controller.
    pub robot: &'a Robot,
    /// Index of the site whose position error is measured.
    pub site: usize,
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
/// The arm starts at rest in the first pose of the trajectory, with tensions that balance gravity and cables
/// that have slid toward their motors. The controller gets true states of the cables only where it is an
/// oracle.
///
/// # Errors
/// As [`ArmTwin::new`], [`ArmController::step`] and [`Trajectory::sample`] for parts of different robots;
/// [`Error::OutOfDomain`] where an open trajectory is to be repeated.
pub fn track(
    run: &TrackRun<'_>,
    controller: &mut ArmController,
    mut see: impl FnMut(&TrackRow<'_>),
) -> Result<TrackSummary, Error> {
    let repeatable = run.repeats <= 1 || run.trajectory.is_closed();
    if !repeatable {
        let (name, expected) = ("repeats", "1 for a trajectory that does not come back");
        return Err(Error::OutOfDomain { name, expected, got: f64::from(run.repeats) });
    }
    let mut current = Reference::new(run.robot.nv());
    let mut previewed = current.clone();
    run.trajectory.sample(0.0, &mut current)?;
    let tensions = resting_tensions(&run.specimen.robot, &current.q)?;
    let mut arm = ArmTwin::new(run.specimen, &current.q, &tensions, run.seed)?.with_faults(run.faults)?;
    let mut errors = TrackingErrors::new(run.specimen, run.robot, run.site);
    let mut summary = TrackSummary::new(tensions.len());
    let mut cable_truth = CableTruth::new(tensions.len());
    let mut commands = vec![DriveCommand::Velocity(0.0); tensions.len()];
    let motion = run.trajectory.duration() * f64::from(run.repeats);
    let steps = libm::round((run.before + motion + run.after) / STEP) as u64;
    for k in 0..steps {
        let time = k as f64 * STEP;
        let since_start = time - run.before;
        run.trajectory.sample(time_in_repeat(run, since_start), &mut current)?;
        run.trajectory.sample(time_in_repeat(run, since_start + PREVIEW_HORIZON), &mut previewed)?;
        let moving = since_start >= 0.0 && since_start < motion;
        let repeat = moving.then(|| (since_start / run.trajectory.duration()) as u32);
        let reading = arm.reading();
        let measurement =
            ArmMeasurement { motor: &reading.motor, tension: &reading.tension, joint: &reading.joint };
        let reference = PreviewedReference {
            current: &current,
            previewed: &previewed,
            repeat_time: repeat.map(|_| time_in_repeat(run, since_start)),
        };
        let truth = controller.requires_ground_truth().then(|| cable_truth.update(&arm));
        let command = controller.step(STEP, &measurement, &reference, truth.as_ref())?;
        commands.copy_from_slice(command.drives);
        errors.evaluate(&current.q, arm.truth().q)?;
        let row = TrackRow {
            time,
            repeat,
            rested: (since_start - motion).max(0.0),
            reference: &current,
            reference_point: errors.reference_point,
            end_point: errors.end_point,
            encoder_point: errors.encoder_point,
            length: &errors.length,
            length_error: &errors.length_error,
            command: &command,
            reading,
            truth: &arm.truth(),
        };
        summary.record(&row);
        see(&row);
        if arm.step(&commands, STEP).is_err() {
            summary.plant_failed = Some(time);
            break;
        }
    }
    Ok(summary)
}

/// Time within the present repeat, s; its ends at rest before the first and after the last.
fn time_in_repeat(run: &TrackRun<'_>, since_start: f64) -> f64 {
    let duration = run.trajectory.duration();
    if since_start >= duration * f64::from(run.repeats) { duration } else { since_start.max(0.0) % duration }
}

/// Tensions that balance gravity in a pose, N: `[muscles]`.
///
/// # Errors
/// [`Error::WrongLength`] where the pose is another robot's.
pub fn resting_tensions(robot: &Robot, q: &[f64]) -> Result<Vec<f64>, Error> {
    let muscles = Muscles::new(robot);
    let n = muscles.count();
    let mut geometry = Geometry::new(robot, &muscles);
    let (mut arms, mut torque) = (vec![0.0; n * robot.nv()], vec![0.0; robot.nv()]);
    muscles.evaluate(q, &mut geometry)?;
    muscles.dense(&geometry, &mut arms)?;
    robot.gravity_force(q, &mut Scratch::new(robot), &mut torque)?;
    let [least, most] = RESTING_TENSION;
    let problem = Problem {
        moment_arms: &arms,
        torque: &torque,
        minimum: &vec![least; n],
        maximum: &vec![most; n],
        reference: &vec![0.0; n],
        weight: &vec![1.0; n],
    };
    Ok(Distribution::new(n, robot.nv()).solve(&problem)?.tension.to_vec())
}

/// Least and largest tension of an arm at rest before a run, N.
const RESTING_TENSION: [f64; 2] = [25.0, 400.0];
