//! The controller of a recording, and others in its place.

use crate::error::Error;
use crate::verbs::machine_source;
use crate::verbs::recording::{LinkSetup, RunSetup};
use crate::verbs::run::Follower;
use crate::verbs::track::setup::read_gains;
use sinew::control::arm::ArmController;
use sinew::control::supervisor::{Limits, Supervisor};
use sinew::machine::Machine;
use sinew::trajectory::{Schedule, Trajectory};
use sinew_lab::CompensationVariant;
use sinew_lab::arm::{CalibratedArm, IdentifiedMachine, PreparedRun, TrackingTask, with_gears};
use sinew_record::{Recording, Replay};
use sinew_runtime::link::LinkedMotion;
use sinew_session::Scheduled;
use std::path::Path;

/// Machine and motion as recorded.
pub(super) struct Motion {
    pub(super) machine: Machine,
    pub(super) trajectory: Trajectory,
    link: Option<LinkSetup>,
    repeats: u32,
    rests: [f64; 2],
    variant: CompensationVariant,
}

impl Motion {
    pub(super) fn new(file: &Path, recording: &Recording<'_>, setup: &RunSetup) -> Result<Self, Error> {
        let machine = setup.machine(file, recording)?;
        let trajectory = setup.trajectory(file, recording, &machine)?;
        let variant = setup.compensation.parse().map_err(|_| {
            let reason = format!("unknown compensation `{}`", setup.compensation);
            Error::recording(file)(sinew_record::Error::Attachment { name: "setup.json".to_owned(), reason })
        })?;
        let rests = [setup.initial_rest_s, setup.final_rest_s];
        let link = setup.link;
        Ok(Self { machine, trajectory, link, repeats: setup.repeats, rests, variant })
    }

    /// A controller over the recording, along the motion or with what a client sent.
    pub(super) fn replay<'a>(
        &'a self,
        file: &Path,
        recording: &'a Recording<'_>,
        supervisor: Supervisor,
    ) -> Result<Replay<'a>, Error> {
        let replay = match self.link {
            Some(link) => {
                let Follower { limits, pose } = Follower::new(&self.machine, &self.trajectory)?;
                let motion = LinkedMotion::replayed(
                    link.settings(recording.head.period_ns),
                    &self.machine,
                    limits,
                    &pose,
                )?;
                Replay::linked(recording, supervisor, motion)
            }
            None => {
                let [before, after] = self.rests;
                let schedule = Schedule::new(&self.trajectory, self.repeats, before, after)?;
                let standing = self.machine.standing(&self.trajectory)?;
                let scheduled = Scheduled::new(schedule, &self.machine.robot, &standing)?;
                Replay::new(recording, supervisor, scheduled)
            }
        };
        replay.map_err(Error::recording(file))
    }
}

/// The controller that commanded the recorded run.
pub(super) fn recorded_controller(setup: &RunSetup, motion: &Motion) -> Result<Supervisor, Error> {
    let machine = with_gears(motion.machine.loaded()?, &setup.gears);
    let (models, gains) = (setup.models.clone(), setup.gains.clone());
    let identified = IdentifiedMachine { machine, models, gains };
    if let Some(controller) = identified.controller(motion.variant)? {
        return supervised(learning(controller, setup, motion)?, &identified.machine);
    }
    // What the variant was calibrated by follows from the seed.
    let arm = CalibratedArm::new(&motion.machine, setup.seed)?;
    let task = TrackingTask {
        trajectory: &motion.trajectory,
        repeats: setup.repeats,
        learning: setup.learning,
        final_rest: setup.final_rest_s,
        faults: &[],
        gains: Some(&setup.gains),
        trace_interval: 1.0,
    };
    Ok(PreparedRun::new(&arm, motion.variant, &task)?.supervisor()?)
}

/// A controller with another machine's design or other gains, and the cables as they were identified. Where
/// another machine is given without gains, they follow from its design.
pub(super) fn other_controller(
    setup: &RunSetup,
    motion: &Motion,
    (machine, root): (Option<&Path>, Option<&Path>),
    gains: Option<&Path>,
) -> Result<Supervisor, Error> {
    let given = gains.map(read_gains).transpose()?;
    let design = match machine {
        Some(path) => {
            let design = machine_source::load(path, root)?.described.machine;
            Machine { payload: motion.machine.payload, ..design }.loaded()?
        }
        None => with_gears(motion.machine.loaded()?, &setup.gears),
    };
    let joints = design.robot.independent_joints().len();
    if let Some(gains) = &given {
        gains.validate(design.muscles.len(), joints)?;
    }
    if [design.muscles.len(), joints] != [motion.machine.muscles.len(), motion.machine.encoders.len()] {
        return Err(Error::Argument {
            flag: "--machine",
            value: machine.map_or_else(String::new, |path| path.display().to_string()),
            expected: "a machine with as many muscles and joints as the recorded one",
        });
    }
    let identified = design.muscles.iter().zip(&setup.models);
    let models = identified.map(|(muscle, recorded)| match (machine, &muscle.model) {
        (Some(_), Some(model)) => model.clone(),
        _ => recorded.clone(),
    });
    let models = models.collect();
    let parts = IdentifiedMachine::new(design, models, &motion.trajectory, given.as_ref())?;
    let controller = parts.controller(motion.variant)?.ok_or_else(|| Error::Argument {
        flag: "--machine",
        value: motion.variant.to_string(),
        expected: "a recording with a compensation that is not calibrated on the simulated bench",
    })?;
    supervised(learning(controller, setup, motion)?, &parts.machine)
}

fn supervised(controller: ArmController, machine: &Machine) -> Result<Supervisor, Error> {
    let limits = Limits::from_machine(machine, controller.gains())?;
    Ok(Supervisor::new(controller, limits)?)
}

fn learning(controller: ArmController, setup: &RunSetup, motion: &Motion) -> Result<ArmController, Error> {
    if setup.learning && setup.repeats > 1 {
        return Ok(controller.with_iterative_learning(motion.trajectory.duration())?);
    }
    Ok(controller)
}
