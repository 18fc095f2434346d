//! A tracking run as valid: robot, feasible trajectory, payload and faults from the arguments.

use super::{fault, waypoints};
use crate::arguments::{PathArgument, TrackArguments};
use crate::error::Error;
use crate::verbs::arm::model::load_robot;
use sinew::body::Robot;
use sinew::trajectory::{EndPointPath, Trajectory};
use sinew::twin::arm::InjectedFault;
use sinew_lab::arm::{
    CalibratedArm, EndPointMotion, TrackingResult, TrackingTask, first_infeasibility, plan, track_arm,
};
use sinew_lab::{CompensationVariant, Error as LabError};

/// Default durations, s, and repeats.
const CLOSED_PATH_S: f64 = 115.0;
const POINT_TO_POINT_S: f64 = 5.0;
const REPEATS: u32 = 6;

/// A run that can be simulated.
pub(super) struct Setup {
    pub(super) robot: Robot,
    /// Index of the site that tracks the path.
    site: usize,
    /// Initial pose.
    pose: Vec<f64>,
    pub(super) trajectory: Trajectory,
    pub(super) repeats: u32,
    learning: bool,
    /// Rest after the motion, s.
    hold_s: f64,
    pub(super) variant: CompensationVariant,
    pub(super) payload_kg: f64,
    faults: Vec<InjectedFault>,
    pub(super) seed: u64,
}

impl Setup {
    /// Loads the robot, plans the trajectory and refuses what the robot cannot track.
    pub(super) fn new(arguments: &TrackArguments) -> Result<Self, Error> {
        let robot = load_robot(&arguments.model, None)?.robot;
        let missing = |part| Error::MissingPart { file: arguments.model.clone(), part };
        let pose = robot.key("start").ok_or_else(|| missing("key pose `start`"))?.to_vec();
        let site = robot.site("endpoint").ok_or_else(|| missing("site `endpoint`"))?;
        let faults = fault::resolve(&arguments.fault, &robot)?;
        let (motion, duration) = motion(&arguments.path, arguments.duration)?;
        let trajectory = plan(&robot, site, &motion, &pose, duration)?;
        let repeats = repeats(arguments.repeats, trajectory.is_closed())?;
        let setup = Self {
            robot,
            site,
            pose,
            trajectory,
            repeats,
            learning: !arguments.no_learning,
            hold_s: arguments.hold,
            variant: arguments.compensation,
            payload_kg: arguments.payload,
            faults,
            seed: arguments.seed,
        };
        setup.check_feasible(&arguments.path)?;
        Ok(setup)
    }

    /// The unloaded robot must be able to track the path, then the loaded one.
    fn check_feasible(&self, path: &PathArgument) -> Result<(), Error> {
        if let Some(infeasibility) = first_infeasibility(&self.robot, &self.trajectory)? {
            let infeasibility = Box::new(infeasibility);
            return Err(Error::Infeasible { path: path.to_string(), infeasibility });
        }
        let tip = &self.robot.parts().sites[self.site];
        let loaded = self.robot.with_payload(tip.body, tip.position, self.payload_kg)?;
        if let Some(infeasibility) = first_infeasibility(&loaded, &self.trajectory)? {
            let infeasibility = Box::new(infeasibility);
            return Err(Error::Overloaded { payload: self.payload_kg, infeasibility });
        }
        Ok(())
    }

    /// Duration of the motion with all repeats, s.
    pub(super) fn motion_s(&self) -> f64 {
        self.trajectory.duration() * f64::from(self.repeats)
    }

    /// The arm with its deviations from the model, every cable calibrated.
    pub(super) fn calibrate(&self) -> Result<CalibratedArm, LabError> {
        let arm = CalibratedArm::new(&self.robot, &self.pose, self.seed)?;
        if self.payload_kg > 0.0 {
            let tip = &self.robot.parts().sites[self.site];
            return arm.with_payload(tip.body, tip.position, self.payload_kg);
        }
        Ok(arm)
    }

    /// Simulates the run, with a row of its trace every `trace_interval` s.
    pub(super) fn track(&self, arm: &CalibratedArm, trace_interval: f64) -> Result<TrackingResult, LabError> {
        let task = TrackingTask {
            trajectory: &self.trajectory,
            site: self.site,
            repeats: self.repeats,
            learning: self.learning,
            final_rest: self.hold_s,
            faults: &self.faults,
            trace_interval,
        };
        track_arm(arm, self.variant, &task)
    }
}

/// The desired motion, and its duration in s where it has no times of its own.
fn motion(path: &PathArgument, duration: Option<f64>) -> Result<(EndPointMotion, f64), Error> {
    match path {
        PathArgument::Closed(shape) => {
            let path = EndPointPath::lm_arm(*shape);
            Ok((EndPointMotion::ClosedPath(path), duration.unwrap_or(CLOSED_PATH_S)))
        }
        PathArgument::Point(position) => {
            Ok((EndPointMotion::PointToPoint(*position), duration.unwrap_or(POINT_TO_POINT_S)))
        }
        PathArgument::Waypoints(file) => match duration {
            // The duration is not used with waypoints.
            None => Ok((EndPointMotion::Waypoints(waypoints::read(file)?), CLOSED_PATH_S)),
            Some(given) => {
                let expected = "none with waypoints, which have their own times";
                Err(Error::Argument { flag: "--duration", value: given.to_string(), expected })
            }
        },
    }
}

/// An open path is tracked once.
fn repeats(given: Option<u32>, closed: bool) -> Result<u32, Error> {
    match given {
        _ if closed => Ok(given.unwrap_or(REPEATS)),
        None | Some(1) => Ok(1),
        Some(many) => Err(Error::Argument {
            flag: "--repeats",
            value: many.to_string(),
            expected: "1 for a path that does not end where it begins",
        }),
    }
}
