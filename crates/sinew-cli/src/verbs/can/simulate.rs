//! `sinew can simulate`.

use crate::answer::{Answer, Content};
use crate::arguments::{CanSimulateArguments, General};
use crate::error::Error;
use crate::interrupt;
use crate::output::print;
use crate::verbs::machine_source::load_machine;
use crate::verbs::simulated_arm::{end_after, simulated_arm, step_ns};
use sinew_runtime::PseudoTerminal;
use sinew_runtime::can::{CanDevice, CanError, SimulatedMachine, serve};

pub(super) fn run(arguments: &CanSimulateArguments, general: &General) -> Result<Answer, Error> {
    let (described, devices) =
        load_machine(&arguments.simulated.machine, None, arguments.simulated.root.dir.as_deref())?;
    let (machine, nodes) = (described.machine, devices.of::<CanDevice>());
    let Some(first) = nodes.first() else { return Err(CanError::OtherBus.into()) };
    let arm = simulated_arm(&machine, arguments.simulated.seed)?;
    let mut simulated = SimulatedMachine::new(arm, &machine, nodes, false);
    let refused = |source| CanError::Port { port: "a pseudo-terminal".to_owned(), source };
    let mut terminal = PseudoTerminal::open().map_err(refused)?;
    if general.json {
        // Standard output is the one document at the end.
        eprintln!("{}", terminal.path());
    } else {
        let (path, name) = (terminal.path(), &machine.robot.parts().name);
        print(&format!("{path}\nSIMULATED {name}: {} nodes answer; Ctrl-C ends\n", nodes.len()))?;
    }
    let stop = interrupt::answer();
    end_after(arguments.simulated.duration, stop);
    let of = (first, step_ns(&machine));
    let frames = serve(&mut terminal, &mut simulated, of, stop).map_err(refused)?;
    let powered = simulated.nodes().filter(|node| node.has_power()).count();
    let content = if general.json {
        Content::json(&serde_json::json!({
            "simulated": true, "frames_received": frames, "drives_with_power": powered,
        }))?
    } else {
        Content::Text(format!("{frames} frames received; at the end {powered} drives with power\n"))
    };
    Ok(Answer::done(content, Vec::new()))
}
