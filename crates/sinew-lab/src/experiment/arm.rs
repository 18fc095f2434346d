//! An arm along a trajectory: the twin on one side, a controller on the other, and what became of it.

use super::tally::{Spread, TrackSummary};
use sinew::Error;
use sinew::body::{Poses, Robot, Scratch};
use sinew::control::arm::{ArmCommand, ArmController, ArmMeasurement, GroundTruth, PreviewedReference};
use sinew::control::stretch::PREVIEW_HORIZON;
use sinew::control::tension::{Distribution, Problem};
use sinew::drive::DriveCommand;
use sinew::muscle::{Geometry, Muscles};
use sinew::predictor::CableModel;
use sinew::trajectory::{Reference, Trajectory};
use sinew::transmission::cable::{CablePath, Segment};
use sinew::twin::arm::{ArmReading, ArmSpecimen, ArmTruth, ArmTwin, InjectedFault};
use sinew::twin::cable::Specimen;

/// One run of an arm.
#[derive(Debug, Clone)]
pub struct TrackRun<'a> {
    /// What was built.
    pub specimen: &'a ArmSpecimen,
    /// What was designed, as the controller believes it.
    pub robot: &'a Robot,
    /// The site that is to follow.
    pub site: usize,
    /// Where the joints are to be, from rest to rest.
    pub trajectory: &'a Trajectory,
    /// How often, one after the other.
    pub repeats: u32,
    /// Rest before the start, s; not counted.
    pub before: f64,
    /// Rest after the end, s.
    pub after: f64,
    /// What fails; times are those of the rows.
    pub faults: &'a [InjectedFault],
    /// Of the sensors' noise.
    pub seed: u64,
}

/// One millisecond of a run.
#[derive(Debug, Clone, Copy)]
pub struct TrackRow<'a> {
    /// Since the run began, s: the motion starts at [`TrackRun::before`].
    pub time: f64,
    /// Which repeat, from 0; none at rest before and after.
    pub repeat: Option<u32>,
    /// How long the reference has been at rest after the last repeat, s; 0 before.
    pub rested: f64,
    /// What the joints were to do.
    pub goal: &'a Reference,
    /// Where the end point was to be, m.
    pub wanted: [f64; 3],
    /// Where it truly is, m.
    pub end_point: [f64; 3],
    /// Where it would be if every joint's encoder read what was wanted, m: their zeros are off, and no controller
    /// without a sensor at the end point knows.
    pub read_as_wanted: [f64; 3],
    /// How long every muscle was to be, m: `[muscles]`.
    pub length: &'a [f64],
    /// By how much every muscle is truly longer than it was to be, m: `[muscles]`.
    pub length_error: &'a [f64],
    /// What the controller said.
    pub command: &'a ArmCommand<'a>,
    /// What sensors said.
    pub reading: &'a ArmReading,
    /// What no controller knows.
    pub truth: &'a ArmTruth<'a>,
}

/// Step of all loops, s.
pub const STEP: f64 = 1e-3;

/// Moves the arm and hands every row to `see`; what became of it.
///
/// The arm starts at rest in the first pose, cables as after a pull, with tensions that hold its weight.
///
/// # Errors
/// As [`ArmTwin::new`], [`ArmController::step`] and [`Trajectory::sample`] where they are made for different robots;
/// [`Error::OutOfDomain`] where a trajectory that does not come back is to be repeated.
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
    let mut now = Reference::new(run.robot.nv());
    let mut coming = now.clone();
    run.trajectory.sample(0.0, &mut now)?;
    let tensions = resting_tensions(&run.specimen.robot, &now.q)?;
    let mut arm = ArmTwin::new(run.specimen, &now.q, &tensions, run.seed)?.with_faults(run.faults)?;
    let mut errors = TrackingErrors::new(run, tensions.len());
    let mut summary = TrackSummary::new(tensions.len());
    let mut told = Known::new(tensions.len());
    let mut commands = vec![DriveCommand::Velocity(0.0); tensions.len()];
    let moving = run.trajectory.duration() * f64::from(run.repeats);
    let steps = libm::round((run.before + moving + run.after) / STEP) as u64;
    for k in 0..steps {
        let time = k as f64 * STEP;
        let since = time - run.before;
        run.trajectory.sample(within_repeat(run, since), &mut now)?;
        run.trajectory.sample(within_repeat(run, since + PREVIEW_HORIZON), &mut coming)?;
        let repeat = (since >= 0.0 && since < moving).then(|| (since / run.trajectory.duration()) as u32);
        told.look(&arm);
        let reading = arm.reading();
        let sample =
            ArmMeasurement { motor: &reading.motor, tension: &reading.tension, joint: &reading.joint };
        let goal = PreviewedReference {
            current: &now,
            previewed: &coming,
            repeat_time: repeat.map(|_| within_repeat(run, since)),
        };
        let answer = controller.step(STEP, &sample, &goal, Some(&told.told()))?;
        commands.copy_from_slice(answer.drives);
        errors.evaluate(&now.q, arm.truth().q)?;
        let row = TrackRow {
            time,
            repeat,
            rested: (since - moving).max(0.0),
            goal: &now,
            wanted: errors.wanted,
            end_point: errors.end_point,
            read_as_wanted: errors.read_as_wanted,
            length: &errors.length,
            length_error: &errors.length_error,
            command: &answer,
            reading,
            truth: &arm.truth(),
        };
        summary.count(&row);
        see(&row);
        if arm.step(&commands, STEP).is_err() {
            summary.lost = Some(time);
            break;
        }
    }
    Ok(summary)
}

/// Time within a repeat; at rest before the first and after the last.
fn within_repeat(run: &TrackRun<'_>, since: f64) -> f64 {
    let duration = run.trajectory.duration();
    if since >= duration * f64::from(run.repeats) { duration } else { since.max(0.0) % duration }
}

/// Tensions that hold the robot at rest, N: `[muscles]`.
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
    let problem = Problem {
        moment_arms: &arms,
        torque: &torque,
        minimum: &vec![RESTING; n],
        maximum: &vec![400.0; n],
        reference: &vec![0.0; n],
        weight: &vec![1.0; n],
    };
    Ok(Distribution::new(n, robot.nv()).solve(&problem)?.tension.to_vec())
}

/// Least tension of an arm at rest before a run, N.
const RESTING: f64 = 25.0;

/// Measures end point and lengths, on what was built.
struct TrackingErrors<'a> {
    run: &'a TrackRun<'a>,
    poses: Poses,
    muscles: Muscles,
    geometry: Geometry,
    body: usize,
    position: [f64; 3],
    wanted: [f64; 3],
    end_point: [f64; 3],
    read_as_wanted: [f64; 3],
    /// Pose in which every encoder reads what is wanted.
    misread: Vec<f64>,
    length: Vec<f64>,
    length_error: Vec<f64>,
}

impl<'a> TrackingErrors<'a> {
    fn new(run: &'a TrackRun<'a>, muscles: usize) -> Self {
        let built = &run.specimen.robot;
        let of = Muscles::new(built);
        let site = &run.robot.parts().sites[run.site];
        Self {
            poses: Poses::new(built),
            geometry: Geometry::new(built, &of),
            muscles: of,
            body: site.body,
            position: site.position,
            wanted: [0.0; 3],
            end_point: [0.0; 3],
            read_as_wanted: [0.0; 3],
            misread: vec![0.0; built.nv()],
            length: vec![0.0; muscles],
            length_error: vec![0.0; muscles],
            run,
        }
    }

    fn evaluate(&mut self, wanted: &[f64], q: &[f64]) -> Result<(), Error> {
        let built = &self.run.specimen.robot;
        for ((misread, wanted), encoder) in
            self.misread.iter_mut().zip(wanted).zip(&self.run.specimen.encoders)
        {
            *misread = wanted - encoder.zero;
        }
        let poses = [
            (wanted, &mut self.wanted),
            (q, &mut self.end_point),
            (self.misread.as_slice(), &mut self.read_as_wanted),
        ];
        for (q, point) in poses {
            built.forward_kinematics(q, &mut self.poses)?;
            *point = built.body_pose(&self.poses, self.body).point(self.position);
        }
        self.muscles.evaluate(wanted, &mut self.geometry)?;
        self.length.copy_from_slice(self.geometry.lengths());
        self.muscles.evaluate(q, &mut self.geometry)?;
        let lengths = self.geometry.lengths().iter().zip(&self.length);
        for (error, (true_length, wanted)) in self.length_error.iter_mut().zip(lengths) {
            *error = true_length - wanted;
        }
        Ok(())
    }
}

/// Cables as they are, for the yardstick of perfect knowledge: what no identification can find. Grease that warms is not in them: it is
/// told as it goes.
#[must_use]
pub fn oracle_models(specimen: &ArmSpecimen) -> Vec<CableModel> {
    let model = |cable: &Specimen| {
        let mut parameters = cable.parameters;
        parameters.weakening = cable.effects.slow.map(|slow| slow.weakening);
        parameters.sheath_compliance += cable.effects.sheath.map_or(0.0, |sheath| sheath.compliance);
        CableModel { path: bent(cable), parameters, start: 1.0, ..CableModel::bench() }
    };
    specimen.cables.iter().map(model).collect()
}

/// The path of a cable with its sheaths bent as unevenly as they are.
fn bent(cable: &Specimen) -> CablePath {
    let mut segments = cable.path.segments().to_vec();
    for segment in &mut segments {
        if let (Segment::Sheath { curvature, .. }, Some(uneven)) = (segment, &cable.effects.curvature) {
            curvature.clone_from(&uneven.parts);
        }
    }
    CablePath::new(segments).unwrap_or_else(|_| cable.path.clone())
}

/// What only an experiment can tell a controller.
struct Known {
    tension_out: Vec<f64>,
    stretch: Vec<f64>,
    drag_factor: Vec<f64>,
}

impl Known {
    fn new(muscles: usize) -> Self {
        Self { tension_out: vec![0.0; muscles], stretch: vec![0.0; muscles], drag_factor: vec![1.0; muscles] }
    }

    fn look(&mut self, arm: &ArmTwin) {
        for (k, cable) in arm.truth().cables.iter().enumerate() {
            self.tension_out[k] = cable.tension_out;
            self.stretch[k] = cable.stretch;
            let heat = arm.specimen().cables[k].effects.heat;
            self.drag_factor[k] = heat.map_or(1.0, |heat| libm::exp(-heat.softening * cable.warming));
        }
    }

    fn told(&self) -> GroundTruth<'_> {
        GroundTruth { tension_out: &self.tension_out, stretch: &self.stretch, drag_factor: &self.drag_factor }
    }
}

/// Distance of two points, m.
pub(super) fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    libm::sqrt((0..3).map(|i| (a[i] - b[i]) * (a[i] - b[i])).sum())
}

/// Spread of nothing yet.
pub(super) const NOTHING: Spread = Spread { mean: 0.0, std: 0.0, max: 0.0, count: 0.0, squares: 0.0 };
