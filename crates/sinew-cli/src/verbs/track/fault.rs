//! Faults of the command line, resolved to the muscles and joints of a robot.

use crate::arguments::{Component, FaultArgument};
use crate::error::Error;
use sinew::body::Robot;
use sinew::twin::arm::{Failure, InjectedFault, Sensor};

pub(crate) fn resolve(faults: &[FaultArgument], robot: &Robot) -> Result<Vec<InjectedFault>, Error> {
    faults.iter().map(|fault| resolve_one(fault, robot)).collect()
}

fn resolve_one(fault: &FaultArgument, robot: &Robot) -> Result<InjectedFault, Error> {
    let muscle = || {
        let names = robot.parts().tendons.iter().map(|tendon| tendon.name.clone()).collect();
        place(fault, "muscle", names)
    };
    let joint = || {
        let name = |velocity| {
            robot.joint_of_velocity(velocity).map_or(String::new(), |k| robot.parts().joints[k].name.clone())
        };
        place(fault, "joint", (0..robot.nv()).map(name).collect())
    };
    let failure = match fault.component {
        Component::Cable => Failure::Cable(muscle()?),
        Component::Drive => Failure::Amplifier(muscle()?),
        Component::Winch => Failure::Winch(muscle()?),
        Component::MotorEncoder(mode) => Failure::Sensor(Sensor::Motor(muscle()?), mode),
        Component::LoadCell(mode) => Failure::Sensor(Sensor::Tension(muscle()?), mode),
        Component::JointEncoder(mode) => Failure::Sensor(Sensor::Joint(joint()?), mode),
        Component::Push(torque) => Failure::Push { joint: joint()?, torque },
        Component::Wear(what, fraction) => Failure::Wear { muscle: muscle()?, what, fraction },
        Component::Exchange(failure) => Failure::Exchange(failure),
    };
    Ok(InjectedFault { start: fault.start_s, duration: fault.duration_s, failure })
}

/// Index of the fault's name among `names`.
fn place(fault: &FaultArgument, kind: &'static str, names: Vec<String>) -> Result<usize, Error> {
    names.iter().position(|name| *name == fault.name).ok_or_else(|| Error::UnknownPart {
        flag: "--fault",
        value: fault.text.clone(),
        kind,
        known: names,
    })
}
