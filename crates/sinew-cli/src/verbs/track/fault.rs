//! Faults of the command line, resolved to the muscles and joints of a robot.

use crate::arguments::{Component, FaultArgument};
use crate::error::Error;
use sinew::machine::Machine;
use sinew::twin::arm::{Failure, InjectedFault, Sensor};

pub(crate) fn resolve(faults: &[FaultArgument], machine: &Machine) -> Result<Vec<InjectedFault>, Error> {
    faults.iter().map(|fault| resolve_one(fault, machine)).collect()
}

fn resolve_one(fault: &FaultArgument, machine: &Machine) -> Result<InjectedFault, Error> {
    let robot = &machine.robot;
    let muscles = || robot.parts().tendons.iter().map(|tendon| tendon.name.clone()).collect();
    let joints = || {
        let name = |velocity| {
            robot.joint_of_velocity(velocity).map_or(String::new(), |k| robot.parts().joints[k].name.clone())
        };
        (0..robot.nv()).map(name).collect()
    };
    let muscle = || place(fault, "muscle", muscles(), |_| true);
    let joint = || place(fault, "joint", joints(), |_| true);
    let failure = match fault.component {
        Component::Cable => Failure::Cable(muscle()?),
        Component::Drive => Failure::Amplifier(muscle()?),
        Component::Winch => Failure::Winch(muscle()?),
        Component::MotorEncoder(mode) => Failure::Sensor(Sensor::Motor(muscle()?), mode),
        Component::LoadCell(mode) => {
            let has_cell = |k: usize| machine.muscles[k].drive.has_load_cell;
            let muscle = place(fault, "muscle with a load cell", muscles(), has_cell)?;
            Failure::Sensor(Sensor::Tension(muscle), mode)
        }
        Component::JointEncoder(mode) => {
            let has_encoder = |k: usize| machine.encoders.get(k).is_some_and(Option::is_some);
            let joint = place(fault, "joint with an encoder", joints(), has_encoder)?;
            Failure::Sensor(Sensor::Joint(joint), mode)
        }
        Component::Push(torque) => Failure::Push { joint: joint()?, torque },
        Component::Wear(what, fraction) => Failure::Wear { muscle: muscle()?, what, fraction },
        Component::Exchange(failure) => Failure::Exchange(failure),
    };
    Ok(InjectedFault { start: fault.start_s, duration: fault.duration_s, failure })
}

/// Index of the fault's name among `names`, of which those that `fit` are known.
fn place(
    fault: &FaultArgument,
    kind: &'static str,
    names: Vec<String>,
    fits: impl Fn(usize) -> bool,
) -> Result<usize, Error> {
    let place = names.iter().position(|name| *name == fault.name).filter(|k| fits(*k));
    place.ok_or_else(|| Error::UnknownPart {
        flag: "--fault",
        value: fault.text.clone(),
        kind,
        known: names.into_iter().enumerate().filter(|(k, _)| fits(*k)).map(|(_, name)| name).collect(),
    })
}
