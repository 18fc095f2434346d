//! How a run is started: what `sinew track` and `sinew run` differ in, and what cannot be asked for together.

use crate::arguments::{BusArgument, PathArgument, RunArguments, SessionArguments, TrackArguments};
use crate::error::Error;
use crate::output::refuse_overwrite;
use crate::verbs::track::setup::Setup;
use sinew_lab::CompensationVariant;
use std::path::PathBuf;

/// A run as it was asked for.
pub(crate) struct Door<'a> {
    pub(crate) arguments: &'a SessionArguments,
    pub(crate) bus: BusArgument,
    /// Of a real machine; empty where its file names it.
    pub(crate) interface: &'a str,
    /// Files that describe simulated devices.
    pub(crate) devices: &'a [PathBuf],
    pub(crate) pace: Pace,
}

/// What time the cycles keep.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Pace {
    /// None: they follow each other at once.
    Virtual,
    /// That of those who look at a simulated machine.
    Watched,
    /// Deadlines.
    RealTime,
}

impl<'a> Door<'a> {
    /// Of `sinew run`.
    pub(super) fn run(arguments: &'a RunArguments) -> Self {
        let RunArguments { session, bus, interface, devices, virtual_time } = arguments;
        Self {
            arguments: session,
            bus: *bus,
            interface: interface.as_deref().unwrap_or(""),
            devices: &devices.files,
            pace: if *virtual_time { Pace::Virtual } else { Pace::RealTime },
        }
    }

    /// Of `sinew track`: the twin, without deadlines.
    pub(super) fn track(TrackArguments { session }: &'a TrackArguments) -> Self {
        let pace = if session.page.page || session.ros.ros { Pace::Watched } else { Pace::Virtual };
        Self { arguments: session, bus: BusArgument::Twin, interface: "", devices: &[], pace }
    }

    pub(crate) fn is_simulated(&self) -> bool {
        self.bus.is_simulated()
    }

    /// Whether others command the machine, over a link or from ROS 2, along no motion of its own.
    pub(crate) fn is_linked(&self) -> bool {
        self.arguments.link.link.is_some() || self.arguments.ros.ros_commands
    }

    /// Refuses what cannot be, and outputs that would replace what is read or to be kept.
    pub(super) fn check(&self, no_clobber: bool) -> Result<(), Error> {
        let SessionArguments { motion, record, report, ros, link, .. } = self.arguments;
        let refuse = |flag, value: String, expected| Err(Error::Argument { flag, value, expected });
        let shown = |file: &PathBuf| file.display().to_string();
        if !self.is_simulated() {
            if self.pace == Pace::Virtual {
                return refuse("--virtual-time", self.bus.name().to_owned(), "it with a simulated bus only");
            }
            if let Some(fault) = motion.fault.first() {
                return refuse("--fault", fault.text().to_owned(), "it with a simulated bus only");
            }
            if motion.compensation != CompensationVariant::Observer {
                let value = motion.compensation.to_string();
                return refuse("--compensation", value, "it with a simulated bus only");
            }
        }
        if ros.ros && !sinew_ros::IS_BUILT {
            return Err(sinew_ros::Error::NotBuilt.into());
        }
        if ros.ros {
            self.ros_domain()?;
            if self.pace == Pace::Virtual {
                let expected = "real time; else --record FILE.mcap and `sinew log export --to ros2`";
                return refuse("--ros", "--virtual-time".to_owned(), expected);
            }
        }
        if let Some(until) = link.until.filter(|_| !self.is_linked()) {
            return refuse("--until", until.to_string(), "it with --link or --ros-commands");
        }
        if let Some(file) = self.devices.first().filter(|_| !matches!(self.bus, BusArgument::Segment)) {
            return refuse("--device", shown(file), "it with --bus segment");
        }
        if let Some(file) = record.as_ref().filter(|_| self.recording().is_none() && self.table().is_none()) {
            return refuse(
                "--record",
                shown(file),
                "a recording that ends in .mcap or a table that ends in .csv",
            );
        }
        let judged =
            self.table().map(|file| ("--record", file)).or(report.as_ref().map(|file| ("--report", file)));
        if let Some((flag, file)) = judged {
            if !self.is_simulated() {
                let expected = "a simulated machine, whose true state it compares with; else --record \
                    FILE.mcap and `sinew log`";
                return refuse(flag, shown(file), expected);
            }
            if self.is_linked() {
                let expected =
                    "a planned motion, which it compares with; else --record FILE.mcap and `sinew log`";
                return refuse(flag, shown(file), expected);
            }
        }
        let outputs: Vec<_> = [report, record].into_iter().flatten().cloned().collect();
        let waypoints = motion.path.as_ref().and_then(PathArgument::file);
        let inputs = [&motion.model].into_iter().chain(waypoints).chain(&motion.gains).chain(self.devices);
        refuse_overwrite(inputs, &outputs, no_clobber)
    }

    /// The domain of ROS 2 that is asked for, else that of the environment.
    pub(super) fn ros_domain(&self) -> Result<u16, Error> {
        const VARIABLE: &str = "ROS_DOMAIN_ID";
        let asked = self.arguments.ros.ros_domain;
        let Some(value) = std::env::var_os(VARIABLE).filter(|value| asked.is_none() && !value.is_empty())
        else {
            return Ok(asked.unwrap_or(0));
        };
        let number = value.to_str().and_then(|text| text.parse().ok()).filter(|id| *id <= 232);
        number.ok_or_else(|| Error::Argument {
            flag: VARIABLE,
            value: value.to_string_lossy().into_owned(),
            expected: "the number of a domain, 0 to 232",
        })
    }

    /// The recording, if one is asked for.
    pub(crate) fn recording(&self) -> Option<&PathBuf> {
        self.arguments.record.as_ref().filter(|file| file.extension().is_some_and(|e| e == "mcap"))
    }

    /// The table, if one is asked for.
    pub(crate) fn table(&self) -> Option<&PathBuf> {
        self.arguments.record.as_ref().filter(|file| file.extension().is_some_and(|e| e == "csv"))
    }

    /// The motion, planned and verified; of a run that a client commands, the one whose speeds are the
    /// limits.
    pub(super) fn setup(&self) -> Result<Setup, Error> {
        let motion = &self.arguments.motion;
        if self.is_linked() {
            Setup::with_default_path(motion, self.bus, |_| PathArgument::Tour)
        } else {
            Setup::new(motion, self.bus)
        }
    }

    /// Says how long a run lasts that others have to wait for.
    pub(super) fn tell_duration(&self, setup: &Setup) {
        if self.pace == Pace::Virtual || self.is_linked() {
            return;
        }
        let repeats = if setup.repeats > 1 { format!(", {} times", setup.repeats) } else { String::new() };
        let name = &setup.machine.robot.parts().name;
        let (all, once) = (setup.run_s(), setup.trajectory.duration());
        tell!(
            "{name} along {}: {all:.0} s in real time; {once:.1} s of motion{repeats}, and rests",
            setup.path
        );
    }

    /// Says of a real machine where joints that nothing measures have to stand.
    pub(super) fn tell_start(&self, setup: &Setup) {
        let machine = &setup.machine;
        let joints = machine.robot.independent_joints().into_iter().map(|k| &machine.robot.parts().joints[k]);
        let unmeasured: Vec<String> = joints
            .zip(&machine.encoders)
            .zip(&machine.start)
            .filter(|((_, encoder), _)| encoder.is_none() && !self.is_simulated())
            .map(|((joint, _), start)| format!("{} at {start:.3} {}", joint.name, joint.kind.unit()))
            .collect();
        if !unmeasured.is_empty() {
            tell!(
                "joints without an encoder are taken to stand in the machine's pose `start`: {}",
                unmeasured.join(", ")
            );
        }
    }
}
