use crate::observation::{Layout, ObservationPart};
use crate::randomisation::Randomisation;
use crate::settings::{Actuation, Settings, periods_in};
use crate::task::Task;
use sinew::Error;
use sinew::body::{Poses, Robot};
use sinew::control::arm::tension_limits;
use sinew::drive::{DriveCommand, DriveParameters};
use sinew::machine::{Machine, Task as Space};
use sinew::muscle::MuscleDynamics;
use sinew::transmission::cable::CableLaw;
use sinew::twin::arm::ArmSpecimen;

/// A machine, a task and the conditions, checked together; what environments have in common.
///
/// # Example
/// ```
/// use sinew::machine::Machine;
/// use sinew_gym::{Environment, EnvironmentDesign, Randomisation, Settings, Task};
/// use std::sync::Arc;
/// let text = sinew_models::BENCH_JOINT;
/// let machine = sinew::description::machine_from_toml("bench_joint.toml", text, &mut |_| Err("no other file".into()))?.machine;
/// let design = EnvironmentDesign::new(&machine, Task::Reach, Settings::default(), Randomisation::default())?;
/// let mut environment = Environment::new(Arc::new(design), 1)?;
/// let outcome = environment.step(&[0.0, 0.1])?;
/// assert!(outcome.reward < 1.0 && !outcome.terminated);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct EnvironmentDesign {
    /// As designed, with its payload.
    pub(crate) machine: Machine,
    /// As designed, as a plant.
    pub(crate) specimen: ArmSpecimen,
    pub(crate) task: Task,
    pub(crate) settings: Settings,
    /// Control cycles of the drives for which an action holds.
    pub(crate) cycles: u32,
    pub(crate) randomisation: Randomisation,
    /// Finite ranges of the independent joints, rad or m: `[joints]`.
    pub(crate) ranges: Vec<[f64; 2]>,
    /// Indices of the independent joints with encoders.
    pub(crate) encoded: Vec<usize>,
    /// Smallest and largest tension at the anchors, N: `[muscles]`.
    pub(crate) tensions: Vec<[f64; 2]>,
    /// Lengths from sheath to anchor in the start, where the motors' encoders are zero, m: `[muscles]`.
    pub(crate) home: Vec<f64>,
    /// Torque or force of the strongest muscle on every joint in the start, Nm or N: `[joints]`.
    pub(crate) strength: Vec<f64>,
    /// Commands of the actions -1 and 1: m/s, N or A: `[muscles]`.
    commands: Vec<[f64; 2]>,
    /// Error at which the reward is a half: m for an end point, else 1.
    pub(crate) half_error: f64,
    pub(crate) layout: Layout,
}

/// Poses over the ranges in which the error's scale is found.
const PLACES: usize = 40;
/// Fraction of the mean error of these poses from the start at which the reward is a half.
const HALF_ERROR: f64 = 0.2;
/// Tensions are commanded from this many times the least one below which a drive does not pay out.
const MIN_TENSION: f64 = 1.5;

/// Cycles of a machine with this period, s, in the interval of an action.
fn cycles(settings: &Settings, period: f64) -> Result<u32, Error> {
    let expected = "such that the interval of an action is a whole number of them";
    let periods = periods_in(settings.interval_ms, period);
    periods.ok_or(Error::OutOfDomain { name: "period of the machine", expected, got: period })
}

impl EnvironmentDesign {
    /// Checks everything and derives what all environments share.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] and others name what is not valid, or why the machine cannot be simulated; see
    /// [`ArmSpecimen::nominal_at`].
    pub fn new(
        machine: &Machine,
        task: Task,
        settings: Settings,
        randomisation: Randomisation,
    ) -> Result<Self, Error> {
        settings.validate()?;
        randomisation.validate()?;
        machine.validate()?;
        let machine = machine.loaded()?;
        task.validate(machine.start.len())?;
        let cycles = cycles(&settings, machine.period)?;
        let specimen = ArmSpecimen::nominal_at(&machine, settings.resolution)?;
        let cells = specimen.resolution.cells;
        let laws = specimen.cables.iter().map(|cable| CableLaw::new(&cable.path, &cable.parameters, cells));
        let tensions = tension_limits(&machine, &laws.collect::<Result<Vec<_>, Error>>()?);
        let mut model = MuscleDynamics::new(&machine.robot)?;
        model.evaluate(&machine.start)?;
        let ranges = machine.ranges()?;
        let encoders = machine.encoders.iter().enumerate();
        let encoded: Vec<usize> = encoders.filter_map(|(k, encoder)| encoder.map(|_| k)).collect();
        let command = |drive: &DriveParameters| bounds(settings.actuation, drive);
        let mut design = Self {
            layout: Layout::new(&machine, &ranges, &encoded, task.moves()),
            commands: machine.muscles.iter().map(|muscle| command(&muscle.drive)).collect(),
            home: model.lengths().to_vec(),
            strength: strength(&model, &tensions, ranges.len()),
            half_error: 1.0,
            machine,
            specimen,
            task,
            settings,
            cycles,
            randomisation,
            ranges,
            encoded,
            tensions,
        };
        design.half_error = design.mean_error()? * HALF_ERROR;
        Ok(design)
    }

    /// Entries of an action: one for every muscle, from -1 to 1.
    #[must_use]
    pub fn actions(&self) -> usize {
        self.commands.len()
    }

    /// Entries of an observation.
    #[must_use]
    pub fn observations(&self) -> usize {
        self.layout.len()
    }

    /// What the entries of an observation are.
    #[must_use]
    pub fn observation_parts(&self) -> &[ObservationPart] {
        &self.layout.parts
    }

    /// Bounds within which every entry of an observation is kept: `[observations]`.
    #[must_use]
    pub fn observation_bounds(&self) -> &[[f32; 2]] {
        &self.layout.bounds
    }

    /// Commands of the actions -1 and 1, m/s, N or A of the motor: `[muscles]`.
    #[must_use]
    pub fn command_bounds(&self) -> &[[f64; 2]] {
        &self.commands
    }

    /// The machine as designed, with its payload.
    #[must_use]
    pub fn machine(&self) -> &Machine {
        &self.machine
    }

    /// Control cycles for which an action holds.
    #[must_use]
    pub fn cycles(&self) -> u32 {
        self.cycles
    }

    /// Steps of drives and sensors in a cycle, and their length, s.
    #[must_use]
    pub fn steps_of_cycle(&self) -> (u32, f64) {
        let step = self.specimen.step();
        ((self.machine.period / step).round() as u32, step)
    }

    /// Longest delay of a reading in any episode, ms.
    #[must_use]
    pub fn longest_delay_ms(&self) -> f64 {
        let drives = self.specimen.drives.iter().map(|drive| drive.delay_ms);
        drives.fold(0.0, f64::max) + self.randomisation.delay_ms[1]
    }

    /// Ranges of the independent joints, rad or m: `[joints]`.
    #[must_use]
    pub fn ranges(&self) -> &[[f64; 2]] {
        &self.ranges
    }

    /// Indices of the independent joints with encoders.
    #[must_use]
    pub fn encoded(&self) -> &[usize] {
        &self.encoded
    }

    /// Error at which the reward is a half, m for an end point, else 1 as a fraction of the joints' ranges.
    #[must_use]
    pub fn half_error(&self) -> f64 {
        self.half_error
    }

    /// Cells of the cables, and substeps of a millisecond.
    #[must_use]
    pub fn resolution(&self) -> sinew::twin::cable::Resolution {
        self.specimen.resolution
    }

    /// Conditions beside machine and task.
    #[must_use]
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The command of an action of one muscle.
    pub(crate) fn command(&self, muscle: usize, action: f64) -> DriveCommand {
        let [low, high] = self.commands[muscle];
        let number = low + 0.5 * (action + 1.0) * (high - low);
        match self.settings.actuation {
            Actuation::Speed => DriveCommand::Velocity(number),
            Actuation::Tension => DriveCommand::Tension { tension: number, feed: 0.0 },
            Actuation::Torque => DriveCommand::Current(number),
        }
    }

    /// Mean error of poses over the ranges whose target is the start.
    fn mean_error(&self) -> Result<f64, Error> {
        let mut place = Place::new(&self.machine);
        let robot = &self.machine.robot;
        let desired = place.point_of(robot, &self.machine.start)?;
        let poses = self.machine.poses(PLACES)?;
        let mut sum = 0.0;
        for pose in &poses {
            let point = place.point_of(robot, pose)?;
            sum += self.error(pose, point, &self.machine.start, desired);
        }
        // A machine that hardly moves has a finite scale as well.
        Ok((sum / poses.len() as f64).max(1e-6))
    }

    /// Distance between the end point and the one that is desired, along the axes that are tracked, m;
    /// without an end point the root-mean-square error of the joints as a fraction of their ranges, 1.
    pub(crate) fn error(&self, q: &[f64], point: [f64; 3], target: &[f64], desired: [f64; 3]) -> f64 {
        let squares: f64 = match self.machine.task {
            Space::EndPoint { axes, .. } => {
                let along = axes.iter().zip(point.iter().zip(desired)).filter(|(tracked, _)| **tracked);
                along.map(|(_, (at, desired))| (at - desired) * (at - desired)).sum()
            }
            Space::Joints => {
                let joints = q.iter().zip(target).zip(&self.ranges);
                let fractions =
                    joints.map(|((q, target), [low, high])| (q - target) / (high - low).max(1e-6));
                fractions.map(|fraction| fraction * fraction).sum::<f64>() / q.len() as f64
            }
        };
        libm::sqrt(squares)
    }
}

/// Positions of a machine's end point, by its design.
#[derive(Debug, Clone)]
pub(crate) struct Place {
    /// None for a task of the joints.
    site: Option<usize>,
    poses: Poses,
    /// All coordinates, and which of them are independent.
    q: Vec<f64>,
    independent: Vec<usize>,
}

impl Place {
    pub(crate) fn new(machine: &Machine) -> Self {
        let robot = &machine.robot;
        let joints = robot.independent_joints().into_iter();
        Self {
            site: machine.task.site(),
            poses: Poses::new(robot),
            q: robot.reference_pose(),
            independent: joints.map(|joint| robot.coordinates_of(joint).start).collect(),
        }
    }

    /// The end point in a pose of the independent joints, m; the origin without one.
    pub(crate) fn point_of(&mut self, robot: &Robot, pose: &[f64]) -> Result<[f64; 3], Error> {
        let Some(site) = self.site else { return Ok([0.0; 3]) };
        for (k, q) in self.independent.iter().zip(pose) {
            self.q[*k] = *q;
        }
        if !robot.parts().couplings.is_empty() {
            robot.apply_couplings(&mut self.q)?;
        }
        robot.forward_kinematics(&self.q, &mut self.poses)?;
        Ok(robot.site_pose(&self.poses, site).origin)
    }
}

/// Commands of the actions -1 and 1.
fn bounds(actuation: Actuation, drive: &DriveParameters) -> [f64; 2] {
    match actuation {
        Actuation::Speed => {
            let speed = drive.speed_at(0.5 * drive.working_tension());
            [-speed, speed]
        }
        Actuation::Tension => {
            let most = drive.working_tension();
            [(MIN_TENSION * drive.min_tension).min(most), most]
        }
        Actuation::Torque => [-drive.motor.continuous_current, drive.motor.continuous_current],
    }
}

/// Torque or force of the strongest muscle on every joint in the evaluated pose.
fn strength(model: &MuscleDynamics, tensions: &[[f64; 2]], joints: usize) -> Vec<f64> {
    let of = |joint: usize| {
        let arms = model.moment_arms().iter().skip(joint).step_by(joints);
        arms.zip(tensions).map(|(arm, [_, most])| arm.abs() * most).fold(0.0, f64::max)
    };
    (0..joints).map(of).collect()
}
