//! A tracking run as valid: machine, feasible trajectory, payload and faults from the arguments.

use super::motion;
use crate::arguments::{BusArgument, MotionArguments, PathArgument};
use crate::error::Error;
use crate::verbs::calibrate::calibrated;
use crate::verbs::machine_source::{self, Loaded, MachineSource};
use crate::verbs::{read_text, verification};
use sinew::control::arm::ArmGains;
use sinew::description::machine::Places;
use sinew::machine::Machine;
use sinew::trajectory::{Approach, Trajectory};
use sinew::twin::arm::InjectedFault;
use sinew_lab::CompensationVariant;
use sinew_lab::arm::{
    CalibratedArm, INITIAL_REST_S, InfeasibleMotion, TrackingTask, Verified, WrittenFault, infeasible_motion,
    verify, verify_poses, verify_tour,
};
use sinew_runtime::Devices;
use std::path::Path;

/// A run that can be simulated.
pub(crate) struct Setup {
    /// With its payload, as the controller knows it.
    pub(crate) machine: Machine,
    /// As designed, around which a simulated machine is drawn.
    design: Machine,
    /// Text of the calibration.
    pub(crate) calibration: Option<String>,
    /// What identifies its devices.
    pub(crate) devices: Devices,
    /// Where its parts are written.
    places: Places,
    /// The texts that it was read from.
    pub(crate) source: MachineSource,
    /// As given, or the machine's default.
    pub(crate) path: PathArgument,
    pub(crate) trajectory: Trajectory,
    pub(crate) repeats: u32,
    pub(crate) learning: bool,
    /// Rest after the motion, s.
    pub(crate) hold_s: f64,
    /// Duration of the way to its beginning, s.
    approach_s: f64,
    pub(crate) variant: CompensationVariant,
    faults: Vec<InjectedFault>,
    /// Of a file, in place of those derived for the motion.
    gains: Option<ArmGains>,
    /// Largest errors of the joints in the verification, rad or m: `[joints]`; empty without one.
    normal_errors: Vec<f64>,
    pub(crate) seed: u64,
}

impl Setup {
    /// Loads the machine, plans the trajectory and refuses what the machine cannot track.
    pub(crate) fn new(arguments: &MotionArguments, bus: BusArgument) -> Result<Self, Error> {
        let mut setup = Self::with_default_path(arguments, bus, motion::default_path)?;
        setup.approach(!bus.is_simulated()).map_err(|error| error.at(&setup.places))?;
        setup.check_faults(&arguments.fault)?;
        Ok(setup)
    }

    /// Refuses a motion to whose beginning the machine cannot go: a real one from its `start`, a simulated
    /// one from where it is put.
    fn approach(&mut self, from_start: bool) -> Result<(), Error> {
        let Self { machine, trajectory, .. } = self;
        let standing = if from_start { machine.start.clone() } else { machine.standing(trajectory)? };
        let approach = Approach::new(&machine.robot, trajectory, &standing)?;
        self.approach_s = approach.duration();
        let infeasible = approach.motion().map(|motion| infeasible_motion(machine, &motion, 1));
        match infeasible.transpose()?.flatten() {
            None => Ok(()),
            Some(InfeasibleMotion { infeasibility, .. }) => Err(Error::Infeasible {
                path: format!("{}, on the way from the pose `start` to its beginning", self.path),
                infeasibility: Box::new(infeasibility),
                long_enough: None,
            }),
        }
    }

    fn check_faults(&self, faults: &[WrittenFault]) -> Result<(), Error> {
        let end_s = self.run_s();
        faults.iter().try_for_each(|fault| Ok(fault.begins_before(end_s)?))
    }

    /// The same with another path where none is given.
    pub(crate) fn with_default_path(
        arguments: &MotionArguments,
        bus: BusArgument,
        default_path: impl FnOnce(&Machine) -> PathArgument,
    ) -> Result<Self, Error> {
        let Loaded { described, devices, source } =
            machine_source::load(&arguments.model, arguments.root.dir.as_deref())?;
        let (machine, places) = (described.machine, described.places);
        let payload = arguments.payload.unwrap_or(machine.payload);
        let reading_age = bus.real().map_or(machine.reading_age, |bus| bus.reading_age(machine.period));
        let machine = Machine { payload, reading_age, ..machine };
        let machine = match arguments.tolerances {
            Some(workshop) => machine.built_by(workshop),
            None => machine,
        };
        let design = machine.clone();
        let calibration = arguments.calibration.as_deref().map(read_text).transpose()?;
        let machine = match (&arguments.calibration, &calibration) {
            (Some(file), Some(text)) => calibrated(&machine, &source.hash(), text, file)?,
            _ => machine,
        };
        let fault =
            |fault: &WrittenFault| fault.of(&machine).map_err(|part| Error::UnknownPart("--fault", part));
        let faults = arguments.fault.iter().map(fault).collect::<Result<_, _>>()?;
        let path = arguments.path.clone().unwrap_or_else(|| default_path(&machine));
        let trajectory = motion::trajectory(&machine, &path, arguments.duration);
        let trajectory = trajectory.map_err(|error| error.of_part(&places))?;
        let repeats = repeats(arguments.repeats, trajectory.is_closed())?;
        let mut setup = Self {
            machine,
            design,
            calibration,
            devices,
            places,
            source,
            path,
            trajectory,
            repeats,
            learning: !arguments.no_learning,
            hold_s: arguments.hold,
            approach_s: 0.0,
            variant: arguments.compensation,
            faults,
            gains: arguments.gains.as_deref().map(read_gains).transpose()?,
            normal_errors: Vec::new(),
            seed: arguments.seed,
        };
        if let Some(gains) = &setup.gains {
            let joints = setup.machine.robot.independent_joints().len();
            gains.validate(setup.machine.muscles.len(), joints)?;
        }
        setup.check_feasible().map_err(|error| error.at(&setup.places))?;
        if setup.gains.is_none() && setup.variant == CompensationVariant::Observer {
            // Whoever gives a duration asks for that one.
            let may_slow = setup.path == PathArgument::Tour && arguments.duration.is_none();
            setup.verify(may_slow, arguments.unverified).map_err(|error| error.at(&setup.places))?;
        }
        Ok(setup)
    }

    fn check_feasible(&self) -> Result<(), Error> {
        match infeasible_motion(&self.machine, &self.trajectory, self.repeats)? {
            None => Ok(()),
            Some(InfeasibleMotion { payload, infeasibility }) => {
                let infeasibility = Box::new(infeasibility);
                Err(if payload > 0.0 {
                    Error::Overloaded { payload, infeasibility }
                } else {
                    let planned = (&self.trajectory, self.repeats);
                    let long_enough =
                        motion::long_enough(&self.machine, &self.path, planned, &infeasibility)?;
                    Error::Infeasible { path: self.path.to_string(), infeasibility, long_enough }
                })
            }
        }
    }

    /// Lowers the gains until simulated machines of the design track the motion, then the speed if it
    /// `may_slow`; refuses the motion where none do, or warns.
    fn verify(&mut self, may_slow: bool, start_nevertheless: bool) -> Result<(), Error> {
        let verified = if may_slow {
            let given = self.trajectory.duration();
            let tour = verify_tour(&self.machine, self.trajectory.clone(), self.repeats)?;
            verification::tell_slowed(&tour, given);
            self.trajectory = tour.trajectory;
            self.normal_errors = tour.joint_errors;
            tour.verified
        } else {
            let verify = if self.path.is_of_joints() { verify_poses } else { verify };
            let motion = verify(&self.machine, &self.trajectory, self.repeats)?;
            self.normal_errors = motion.joint_errors;
            motion.verified
        };
        match verified {
            Verified::Fails(reason) if !start_nevertheless => {
                let payload = self.machine.payload;
                let motion = if payload > 0.0 {
                    format!("--payload {payload} kg")
                } else {
                    format!("--path {}", self.path)
                };
                return Err(Error::Untracked { motion, reason, slowed: may_slow });
            }
            verified => {
                verification::warn(&verified);
                if let Verified::Tracks(rules) | Verified::Inaccurate(rules, _) = verified {
                    self.machine.rules = rules;
                }
            }
        }
        Ok(())
    }

    /// Duration of the motion with all repeats, s.
    pub(crate) fn motion_s(&self) -> f64 {
        self.trajectory.duration() * f64::from(self.repeats)
    }

    /// The same with the way to its beginning and the rests before and after it, s.
    pub(crate) fn run_s(&self) -> f64 {
        self.approach_s + INITIAL_REST_S + self.motion_s() + self.hold_s
    }

    /// The arm with its deviations from the model, every cable calibrated.
    pub(crate) fn calibrate(&self) -> Result<CalibratedArm, Error> {
        let design = Machine { rules: self.machine.rules, ..self.design.clone() };
        let arm = CalibratedArm::new(&design, self.seed);
        let mut arm = arm.map_err(|error| Error::from(error).at(&self.places))?;
        if self.calibration.is_some() {
            arm = arm.known_as(&self.machine)?;
        }
        Ok(arm.with_normal_errors(self.normal_errors.clone()))
    }

    /// The motion with its conditions.
    pub(crate) fn task(&self) -> TrackingTask<'_> {
        TrackingTask {
            trajectory: &self.trajectory,
            repeats: self.repeats,
            learning: self.learning,
            final_rest: self.hold_s,
            faults: &self.faults,
            gains: self.gains.as_ref(),
            trace_interval: 1.0,
        }
    }
}

/// Gains as `sinew machine tune` writes them.
pub(crate) fn read_gains(path: &Path) -> Result<ArmGains, Error> {
    let text = read_text(path)?;
    let mut json = serde_json::Deserializer::from_str(&text);
    serde_path_to_error::deserialize(&mut json).map_err(|error| {
        let place = format!("line {}, {}", error.inner().line(), error.path());
        Error::GainsFile { file: path.to_owned(), place, source: error.into_inner() }
    })
}

/// An open path is tracked once.
fn repeats(given: Option<u32>, closed: bool) -> Result<u32, Error> {
    match given {
        _ if closed => Ok(given.unwrap_or(1)),
        None | Some(1) => Ok(1),
        Some(many) => Err(Error::Argument {
            flag: "--repeats",
            value: many.to_string(),
            expected: "1 for a path that does not end where it begins",
        }),
    }
}
