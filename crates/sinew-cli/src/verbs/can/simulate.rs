//! `sinew can simulate`.

use crate::answer::{Answer, Content};
use crate::arguments::{CanSimulateArguments, General};
use crate::error::Error;
use crate::interrupt;
use crate::output::{print, refuse_overwrite};
use crate::verbs::machine_source::load_machine;
use crate::verbs::simulated_arm::{end_after, serve_with_truth, simulated_arm, step_ns};
use sinew_runtime::can::{
    CanDevice, CanError, HostedAdapter, Link, Protocol, SimulatedMachine, connect, serve,
};

pub(super) fn run(arguments: &CanSimulateArguments, general: &General) -> Result<Answer, Error> {
    refuse_overwrite(
        [&arguments.simulated.machine],
        arguments.simulated.truth.as_slice(),
        general.no_clobber,
    )?;
    let (described, devices) =
        load_machine(&arguments.simulated.machine, None, arguments.simulated.root.dir.as_deref())?;
    let (machine, nodes) = (described.machine, devices.of::<CanDevice>());
    let Some(first) = nodes.first() else { return Err(CanError::OtherBus.into()) };
    let arm = simulated_arm(&machine, arguments.simulated.seed)?;
    let mut simulated = SimulatedMachine::new(arm, &machine, nodes, false);
    let place = arguments.interface.as_deref().unwrap_or("a pseudo-terminal");
    let refused = |source| CanError::Port { port: place.to_owned(), source };
    let (path, mut bus): (_, Box<dyn Link>) = if let Some(port) = &arguments.interface {
        let fd = first.protocol == Protocol::Moteus;
        (port.clone(), connect(port, first.bitrate, fd).map_err(refused)?)
    } else {
        let adapter = HostedAdapter::open(first).map_err(refused)?;
        (adapter.path().to_owned(), Box::new(adapter))
    };
    if general.json {
        // Standard output is the one document at the end.
        tell!("{path}");
    } else {
        let name = &machine.robot.parts().name;
        print(&format!("{path}\nSIMULATED {name}: {} nodes answer; Ctrl-C ends\n", nodes.len()))?;
    }
    let stop = interrupt::answer();
    end_after(arguments.simulated.duration, stop);
    let (frames, written) = serve_with_truth(arguments.simulated.truth.as_deref(), &machine, |seen| {
        serve(&mut *bus, &mut simulated, step_ns(&machine), stop, seen).map_err(|e| refused(e).into())
    })?;
    let powered = simulated.nodes().filter(|node| node.has_power()).count();
    let content = if general.json {
        Content::json(&serde_json::json!({
            "simulated": true, "frames_received": frames, "drives_with_power": powered,
        }))?
    } else {
        Content::Text(format!("{frames} frames received; at the end {powered} drives with power\n"))
    };
    Ok(Answer::done(content, written))
}
