use super::device::{self, Device, Signal};
use super::muscle::MuscleDesign;
use super::period::{DEFAULT_PERIOD, check_period, dead_time};
use super::rules::ControlRules;
use super::safety::SafetyLimits;
use super::task::{NamedPath, Task};
use super::tolerances::{Tolerances, Workshop};
use crate::Error;
use crate::body::{JointKind, Robot};
use crate::drive::JointEncoder;
use crate::error::{non_negative, within};
use crate::muscle::MuscleDynamics;
use crate::random::EvenPoints;
use crate::trajectory::{Equilibrium, Redundancy, Trajectory, finite_ranges, independent_ranges};
use crate::transmission::SheathBend;
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;

/// Time without commands after which drives stop by themselves: s, at least as many periods.
const WATCHDOG: f64 = 0.02;
const WATCHDOG_PERIODS: f64 = 4.0;

/// A machine on cables as designed, every number valid.
///
/// # Example
/// ```
/// use sinew::body::Robot;
/// use sinew::machine::Machine;
/// let text = sinew_models::LM_ARM;
/// let parts = sinew::description::from_toml("lm_arm.toml", text).expect("a model of this repository").parts;
/// let machine = Machine::from_robot(&Robot::new(parts)?)?;
/// assert_eq!((machine.muscles.len(), machine.encoders.len()), (15, 7));
/// # Ok::<(), sinew::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Machine {
    /// Bodies, joints and tendon paths.
    pub robot: Robot,
    /// What belongs to every tendon: `[muscles]`.
    pub muscles: Vec<MuscleDesign>,
    /// Encoder of every independent joint, or none: `[joints]`.
    pub encoders: Vec<Option<JointEncoder>>,
    /// Coordinates of the independent joints where motions start, rad or m: `[joints]`.
    pub start: Vec<f64>,
    /// What it tracks.
    pub task: Task,
    /// Preferred pose where the task leaves joints free.
    pub redundancy: Redundancy,
    /// Closed paths of the end point.
    pub paths: Vec<NamedPath>,
    /// Mass that it carries at its [`payload_site`](Self::payload_site), kg, >= 0.
    pub payload: f64,
    /// Tolerances of its manufacture.
    pub tolerances: Tolerances,
    /// Constants of the rules for its gains.
    pub rules: ControlRules,
    /// Period of its control cycle, s, in [`PERIOD_RANGE`](super::PERIOD_RANGE).
    pub period: f64,
    /// Age of its bus's readings where a cycle begins, s; the simulated machine alone has none.
    pub reading_age: f64,
    /// Limits that its supervisor keeps, and the times of its reactions.
    pub safety: SafetyLimits,
    /// Drives and sensors as devices, in the order of its file.
    pub devices: Vec<Device>,
}

/// The smallest of what the actuators of a muscle allow, N; none where they limit no tension.
fn largest_tension(parts: &crate::body::Parts, muscle: usize) -> Option<f64> {
    let actuators = parts.actuators.iter().filter(|actuator| actuator.tendon == muscle);
    actuators.filter_map(crate::body::Actuator::largest_tension).reduce(f64::min).filter(|most| *most > 0.0)
}

impl Machine {
    /// A body with defaults for everything else.
    ///
    /// The start is the key pose `start`, else the reference pose moved into the joints' ranges. The end
    /// point is the site `endpoint`; without it the joints are the task. Muscles without a described sheath
    /// have one of 0.5 m; see [`MuscleDesign::in_sheath`]. Tensions stay within the ranges of the actuators.
    ///
    /// # Errors
    /// As [`validate`](Self::validate).
    pub fn from_robot(robot: &Robot) -> Result<Self, Error> {
        let parts = robot.parts();
        let sheath =
            |tendon: &crate::body::Tendon| tendon.sheath.as_ref().map(|sheath| [sheath.length, sheath.bend]);
        let muscle = |(index, tendon): (usize, &crate::body::Tendon)| MuscleDesign {
            tension: [None, largest_tension(parts, index)],
            ..MuscleDesign::in_sheath(sheath(tendon))
        };
        check_kinds(robot)?;
        let start = robot.key("start").map_or_else(|| pose_within_ranges(robot), <[f64]>::to_vec);
        let independent = |joint: usize| start.get(robot.coordinates_of(joint).start).copied();
        let joints = robot.independent_joints();
        let mut start: Vec<f64> = joints.iter().filter_map(|joint| independent(*joint)).collect();
        if robot.key("start").is_none() && start.len() == joints.len() {
            move_into(&mut start, &independent_ranges(robot)?);
        }
        let encoder = |joint: usize| {
            Some(match parts.joints[joint].kind {
                JointKind::Slide => JointEncoder::slide(),
                _ => JointEncoder::fourteen_bits(),
            })
        };
        let mut machine = Self {
            reading_age: 0.0,
            devices: Vec::new(),
            muscles: parts.tendons.iter().enumerate().map(muscle).collect(),
            encoders: joints.into_iter().map(encoder).collect(),
            task: robot
                .site("endpoint")
                .map_or(Task::Joints, |site| Task::EndPoint { site, axes: [true; 3] }),
            redundancy: Redundancy::near(&start),
            start,
            paths: Vec::new(),
            payload: 0.0,
            tolerances: Tolerances::default(),
            rules: ControlRules::default(),
            period: DEFAULT_PERIOD,
            safety: SafetyLimits::default(),
            robot: robot.clone(),
        };
        machine.devices = Device::defaults(robot, &machine.muscles, &machine.encoders);
        machine.validate()?;
        Ok(machine)
    }

    /// The same with its payload as part of its body, at its end point.
    ///
    /// # Errors
    /// As [`Robot::with_payload`]; [`Error::OutOfDomain`] for a payload without an end point.
    pub fn loaded(&self) -> Result<Self, Error> {
        let mut machine = Self { payload: 0.0, ..self.clone() };
        if self.payload > 0.0 {
            let Some(site) = self.payload_site() else {
                return within("payload", NO_END_POINT, self.payload, false).map(|_| machine);
            };
            let site = &self.robot.parts().sites[site];
            machine.robot = self.robot.with_payload(site.body, site.position, self.payload)?;
        }
        Ok(machine)
    }

    /// Period of its control cycle, ns.
    #[must_use]
    pub fn period_ns(&self) -> u64 {
        libm::round(1e9 * self.period) as u64
    }

    /// Time without commands after which its drives stop by themselves, s: 20 ms, four periods, or a cycle
    /// that is as late as is [bridged](SafetyLimits::bridged_lateness), whichever is longest.
    #[must_use]
    pub fn watchdog(&self) -> f64 {
        WATCHDOG.max(WATCHDOG_PERIODS * self.period).max(self.period + self.safety.bridged_lateness)
    }

    /// The name of the first load cell or joint encoder that none of its devices measures.
    #[must_use]
    pub fn unmeasured(&self) -> Option<String> {
        let measured =
            |signal| self.devices.iter().flat_map(Device::channels).any(|channel| channel.signal == signal);
        let parts = self.robot.parts();
        let mut cells = self.muscles.iter().zip(&parts.tendons).enumerate();
        let cell = cells.find_map(|(k, (design, tendon))| {
            let missing = design.drive.has_load_cell && !measured(Signal::Tension(k));
            missing.then(|| format!("load cell of {}", tendon.name))
        });
        let joints = self.robot.independent_joints();
        let encoder = self.encoders.iter().zip(joints).enumerate().find_map(|(k, (encoder, joint))| {
            let missing = encoder.is_some() && !measured(Signal::Joint(k));
            missing.then(|| format!("joint encoder of {}", parts.joints[joint].name))
        });
        cell.or(encoder)
    }

    /// Where it is taken to stand before a motion, rad or m: `[joints]`. Joints without an encoder stand in
    /// the [`start`](Self::start); the others are measured, and those of a simulated machine are put where
    /// the motion begins.
    ///
    /// # Errors
    /// As [`Trajectory::first`].
    pub fn standing(&self, trajectory: &Trajectory) -> Result<Vec<f64>, Error> {
        let mut standing = trajectory.first()?;
        for ((standing, start), encoder) in standing.iter_mut().zip(&self.start).zip(&self.encoders) {
            *standing = if encoder.is_some() { *standing } else { *start };
        }
        Ok(standing)
    }

    /// Longest transport delay of the readings of its drives, s, beside their sampling: their own and that of
    /// their bus.
    #[must_use]
    pub fn transport_delay(&self) -> f64 {
        let own = self.muscles.iter().map(|design| 1e-3 * design.drive.delay_ms).fold(0.0, f64::max);
        own + self.reading_age
    }

    /// Time from a measurement to the middle of the command that answers it, s: see [`dead_time`].
    #[must_use]
    pub fn dead_time(&self) -> f64 {
        dead_time(self.period, self.transport_delay())
    }

    /// Index of the site that carries a payload: the end point of the task, or else the site `endpoint`.
    #[must_use]
    pub fn payload_site(&self) -> Option<usize> {
        self.task.site().or_else(|| self.robot.site("endpoint"))
    }

    /// Ranges of the independent joints in which coupled joints keep theirs, too; finite: an unlimited joint
    /// moves by an assumed 1 rad or 50 mm about the start. `[joints]`, rad or m.
    ///
    /// # Errors
    /// As [`finite_ranges`].
    pub fn ranges(&self) -> Result<Vec<[f64; 2]>, Error> {
        finite_ranges(&self.robot, &self.start)
    }

    /// The start, and poses spread evenly over the [`ranges`](Self::ranges): `[places][joints]`. Where cables
    /// leave joints to springs, the equilibria with the lengths that the cables have in these poses; fewer
    /// places where there are none.
    ///
    /// # Errors
    /// As [`ranges`](Self::ranges); [`Error::OutOfDomain`] where there is no equilibrium at all.
    pub fn poses(&self, places: usize) -> Result<Vec<Vec<f64>>, Error> {
        let ranges = self.ranges()?;
        let within = |point: Vec<f64>| {
            ranges.iter().zip(point).map(|([low, high], fraction)| low + fraction * (high - low)).collect()
        };
        let spread = EvenPoints::new(ranges.len()).map(within);
        let all: Vec<Vec<f64>> = core::iter::once(self.start.clone()).chain(spread).take(places).collect();
        let Some(mut equilibrium) = Equilibrium::new(&self.robot)? else { return Ok(all) };
        let mut found = Vec::new();
        for mut pose in all {
            if equilibrium.settle(&mut pose)?.is_none() {
                found.push(pose);
            }
        }
        if found.is_empty() {
            return Err(Error::OutOfDomain { name: "poses at rest", expected: SOME_EQUILIBRIUM, got: 0.0 });
        }
        Ok(found)
    }

    /// Bound of the error of every coordinate of a tendon's site, m: that of its tolerances, by default 1 mm,
    /// at most 0.4 % of the reach, the largest sum of the distances from body to body along a branch.
    #[must_use]
    pub fn attachment_tolerance(&self) -> f64 {
        let parts = self.robot.parts();
        let length = |x: &[f64; 3]| libm::sqrt(x.iter().map(|x| x * x).sum());
        let mut reaches: Vec<f64> = Vec::with_capacity(parts.bodies.len());
        for body in &parts.bodies {
            let before = reaches.get(body.parent).copied().unwrap_or(0.0);
            reaches.push(before + length(&body.position));
        }
        let reach = reaches.into_iter().fold(0.0, f64::max);
        let reach = parts.sites.iter().map(|site| length(&site.position)).fold(reach, f64::max);
        self.tolerances.attachment.unwrap_or((4e-3 * reach).min(1e-3))
    }

    /// Error of a moment arm by the tolerances of lengths, m, and by those of angles and winches as a
    /// fraction of it, beyond those of a machine that is built carefully and has no such tolerances.
    #[must_use]
    pub fn moment_arm_tolerance(&self) -> (f64, f64) {
        let Tolerances { wrap_radius, link, winch, axis, eccentricity, zero, .. } = self.tolerances;
        let aligned = Tolerances::default().zero;
        let length = self.attachment_tolerance() + wrap_radius + link;
        (length, winch + axis + eccentricity + (zero - aligned).max(0.0))
    }

    /// The same as a workshop builds it, lengths in proportion to its
    /// [`attachment_tolerance`](Self::attachment_tolerance) where that is below a millimetre.
    #[must_use]
    pub fn built_by(mut self, workshop: Workshop) -> Self {
        let default = Self { tolerances: Tolerances::default(), ..self.clone() }.attachment_tolerance();
        let size = self.attachment_tolerance().min(default) / 1e-3;
        self.tolerances = self.tolerances.of(workshop, size);
        self
    }

    /// Checks every number and every length.
    ///
    /// # Errors
    /// [`Error::WrongLength`] and [`Error::OutOfDomain`] name the field; [`Error::Part`] a joint that is
    /// neither hinge nor slide.
    pub fn validate(&self) -> Result<(), Error> {
        let parts = self.robot.parts();
        let (muscles, joints) = (parts.tendons.len(), self.robot.independent_joints().len());
        for (name, expected, got) in [
            ("muscles", muscles, self.muscles.len()),
            ("encoders", joints, self.encoders.len()),
            ("start", joints, self.start.len()),
        ] {
            if expected != got {
                return Err(Error::WrongLength { name, expected, got });
            }
        }
        within("muscles", SOME_MUSCLE, muscles as f64, muscles > 0)?;
        within("joints", SOME_JOINT, joints as f64, joints > 0)?;
        check_kinds(&self.robot)?;
        for (muscle, design) in self.muscles.iter().enumerate() {
            design.validate().map_err(|error| error.of_part("muscle", muscle))?;
        }
        self.ranges()?;
        self.check_bends()?;
        self.check_start()?;
        self.encoders.iter().flatten().try_for_each(JointEncoder::validate)?;
        if let Task::EndPoint { site, axes } = self.task {
            within("site", "an index of a site", site as f64, site < parts.sites.len())?;
            within("axes", "at least one", 0.0, axes.contains(&true))?;
        }
        self.redundancy.validate(&self.robot)?;
        self.paths.iter().try_for_each(|named| named.path.validate())?;
        non_negative("payload", self.payload)?;
        self.tolerances.validate()?;
        self.rules.validate()?;
        check_period(self.period)?;
        self.safety.validate()?;
        device::validate(&self.devices, muscles, joints)
    }
}

const SOME_MUSCLE: &str = "at least one: a tendon of an MJCF file, a muscle of an OpenSim file, a [[muscle]] \
    of a TOML file or, for NAME.urdf, of NAME.muscles.toml; `machine new --pulleys 8mm` adds some to joints alone";
const SOME_EQUILIBRIUM: &str = "at least one: there are fewer motors than joints, and in no pose do springs \
    and weight hold the others";
const NO_END_POINT: &str = "0 for a machine without an end point: name a site of the body as `endpoint` in \
    [task], or call one `endpoint`";
const SOME_JOINT: &str = "at least one hinge or slide that follows no other";

impl Machine {
    /// Refuses cables that have no law, and a joint that moves nothing: its acceleration would have no limit.
    fn check_start(&self) -> Result<(), Error> {
        let mut model = MuscleDynamics::new(&self.robot)?;
        model.evaluate(&self.start)?;
        self.check_laws(&model)?;
        let n = self.start.len();
        let mut mass = alloc::vec![0.0; n * n];
        model.mass_matrix(&mut mass)?;
        let still = (0..n).find(|&j| mass[j * n + j] <= 0.0);
        still.map_or(Ok(()), |j| {
            let (kind, field) = ("joint", "the inertia that it moves");
            let expected = "> 0: give a body behind it a mass, or the joint an armature";
            Err(Error::Part { kind, index: self.robot.independent_joints()[j], field, expected })
        })
    }

    /// Refuses a sheath that bends by more than two turns within the ranges of the joints.
    fn check_bends(&self) -> Result<(), Error> {
        let bends = self.sheath_bends()?;
        if bends.iter().all(SheathBend::is_constant) {
            return Ok(());
        }
        let ranges = self.ranges()?;
        for (muscle, bend) in bends.iter().enumerate().filter(|(_, bend)| !bend.is_constant()) {
            let largest = bend.largest(&ranges);
            let expected = "at most 4 pi over the ranges of the joints";
            let bent = within("bend_by_joint", expected, largest, largest <= SheathBend::LARGEST);
            bent.map_err(|error| error.of_part("muscle", muscle))?;
        }
        Ok(())
    }
}

/// Refuses joints that are neither hinge nor slide.
fn check_kinds(robot: &Robot) -> Result<(), Error> {
    for (index, joint) in robot.parts().joints.iter().enumerate() {
        if !matches!(joint.kind, JointKind::Hinge | JointKind::Slide) {
            let (kind, field) = ("joint", "its kind");
            let expected = "hinge or slide: a ball as three hinges, a floating base fixed to the world";
            return Err(Error::Part { kind, index, field, expected });
        }
    }
    Ok(())
}

/// Moves coordinates with which a joint that follows them is out of its range into the middle of the range
/// where it is not.
fn move_into(coordinates: &mut [f64], ranges: &[[f64; 2]]) {
    for (at, [low, high]) in coordinates.iter_mut().zip(ranges) {
        if !(*low..=*high).contains(at) {
            *at = (0.5 * (low + high)).clamp(*low, *high);
        }
    }
}

/// The reference pose, every coordinate within its range.
fn pose_within_ranges(robot: &Robot) -> Vec<f64> {
    let mut q = robot.reference_pose();
    for (index, joint) in robot.parts().joints.iter().enumerate() {
        let coordinates = robot.coordinates_of(index);
        if let (Some([low, high]), 1) = (joint.range, coordinates.len()) {
            let at = &mut q[coordinates.start];
            if !(low..=high).contains(at) {
                *at = 0.5 * (low + high);
            }
        }
    }
    q
}
