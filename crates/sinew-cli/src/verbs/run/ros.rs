//! A run as a node of ROS 2.

use super::door::Door;
use super::link;
use crate::error::Error;
use crate::verbs::run::Follower;
use crate::verbs::track::setup::Setup;
use serde_json::{Value, json};
use sinew::control::supervisor::Supervisor;
use sinew_link::host::Port;
use sinew_ros::{Counts, Node, NodeSettings, Tap};
use sinew_session::{CycleRecord, Plant};
use std::time::Duration;

/// The node, and the side of the control cycle.
pub(super) struct RunNode {
    node: Node,
    tap: Tap,
    port: Option<Port>,
}

impl RunNode {
    /// Before the first cycle and before a machine has power; none where none is asked for. Before the
    /// cycle's thread has its priority, which a thread that is started later would inherit.
    pub(super) fn start(
        door: &Door<'_>,
        setup: &Setup,
        supervisor: &Supervisor,
    ) -> Result<Option<Self>, Error> {
        let arguments = &door.arguments.ros;
        if !arguments.ros {
            return Ok(None);
        }
        let commands = if arguments.ros_commands {
            let limits = Follower::new(&setup.machine, &setup.trajectory)?.limits;
            let domain = link::domain_of(setup, &limits, supervisor)?;
            Some((domain, link::settings(door, &setup.machine)))
        } else {
            None
        };
        let (domain_id, address) = (door.ros_domain()?, arguments.ros_address);
        let commanded = commands.is_some();
        let (machine, simulated) = (&setup.machine, door.is_simulated());
        let settings = NodeSettings { domain_id, address, machine, simulated, commands };
        let (node, tap, port) = Node::start(settings)?;
        let name = &machine.robot.parts().name;
        let kind = if simulated { "SIMULATED machine" } else { "machine" };
        tell!("ROS 2: {kind} {name} on {address}, domain {domain_id}");
        if commanded && !address.is_loopback() {
            tell!("warning: ROS 2 does not ask who commands: everyone who reaches {address} may");
        }
        if let Some(seconds) = arguments.ros_wait {
            node.wait_for_reader(Duration::from_secs_f64(seconds))?;
        }
        Ok(Some(Self { node, tap, port }))
    }

    /// Where the commands of other nodes come from; once, and none where they may not command.
    pub(super) fn take_port(&mut self) -> Option<Port> {
        self.port.take()
    }

    /// Publishes a cycle.
    pub(super) fn show<P: Plant>(&mut self, record: &CycleRecord<'_, P>) {
        self.tap.show(record);
    }

    /// Ends the node.
    pub(super) fn end(self) -> Counts {
        self.node.end()
    }
}

pub(super) fn json(counts: &Counts) -> Value {
    let Counts { published, missed, taken, refused, failed } = counts;
    json!({"published": published, "missed": missed, "taken": taken, "refused": refused, "failed": failed})
}

pub(super) fn text(counts: &Counts) -> String {
    let Counts { published, missed, taken, refused, failed } = counts;
    if *failed {
        return "ROS 2: the node failed\n".to_owned();
    }
    format!(
        "ROS 2: {published} states published, {missed} missed; {taken} commands taken, {refused} refused\n"
    )
}
