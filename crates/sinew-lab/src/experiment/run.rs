//! What a run of an arm consists of: plant, design, reference, faults.

use sinew::Error;
use sinew::body::Robot;
use sinew::control::arm::resting_tensions;
use sinew::trajectory::{Schedule, Trajectory};
use sinew::twin::arm::{ArmSpecimen, ArmTwin, InjectedFault};
use sinew_session::Scheduled;

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
    /// Pose in which the arm stands before, rad or m: `[joints]`; none: the first of the trajectory.
    pub standing: Option<&'a [f64]>,
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

impl<'a> TrackRun<'a> {
    /// When the reference rests and moves.
    ///
    /// # Errors
    /// As [`Schedule::new`] and [`Scheduled::new`].
    pub fn scheduled(&self) -> Result<Scheduled<'a>, Error> {
        let schedule = Schedule::new(self.trajectory, self.repeats, self.before, self.after)?;
        Scheduled::new(schedule, self.robot, &self.standing()?)
    }

    /// Pose in which the arm stands before, rad or m: `[joints]`.
    fn standing(&self) -> Result<Vec<f64>, Error> {
        self.standing.map_or_else(|| self.trajectory.first(), |pose| Ok(pose.to_vec()))
    }

    /// The plant at the start of the run.
    ///
    /// # Errors
    /// As [`ArmTwin::new`], [`ArmTwin::with_faults`] and [`Trajectory::first`] for parts of different
    /// robots.
    pub fn plant(&self) -> Result<ArmTwin, Error> {
        let start = self.standing()?;
        let tensions = resting_tensions(&self.specimen.robot, &start, self.tension_limits)?;
        ArmTwin::new(self.specimen, &start, &tensions, self.seed)?.with_faults(self.faults)
    }
}
