//! `sinew servos simulate`.

use crate::answer::{Answer, Content};
use crate::arguments::{General, ServosSimulateArguments};
use crate::error::Error;
use crate::interrupt;
use crate::output::{print, refuse_overwrite};
use crate::verbs::machine_source::load_machine;
use crate::verbs::simulated_arm::{end_after, serve_with_truth, simulated_arm, step_ns};
use sinew_runtime::PseudoTerminal;
use sinew_runtime::servos::{ServoDevice, ServoError, SimulatedMachine, serve};

pub(super) fn run(arguments: &ServosSimulateArguments, general: &General) -> Result<Answer, Error> {
    refuse_overwrite(
        [&arguments.simulated.machine],
        arguments.simulated.truth.as_slice(),
        general.no_clobber,
    )?;
    let (described, devices) =
        load_machine(&arguments.simulated.machine, None, arguments.simulated.root.dir.as_deref())?;
    let (machine, servos) = (described.machine, devices.of::<ServoDevice>());
    if servos.is_empty() {
        return Err(ServoError::OtherBus.into());
    }
    let arm = simulated_arm(&machine, arguments.simulated.seed)?;
    let ports = ServoDevice::ports(servos);
    let mut simulated = SimulatedMachine::new(arm, &machine, servos, &ports, true);
    let refused = |source| ServoError::Port { port: "a pseudo-terminal".to_owned(), source };
    let terminals = ports.iter().map(|_| PseudoTerminal::open()).collect::<Result<Vec<_>, _>>();
    let mut terminals = terminals.map_err(refused)?;
    let paths: String = terminals.iter().map(|terminal| format!("{}\n", terminal.path())).collect();
    if general.json {
        // Standard output is the one document at the end.
        tell!("{}", paths.trim_end());
    } else {
        let name = &machine.robot.parts().name;
        print(&format!("{paths}SIMULATED {name}: {} servos answer; Ctrl-C ends\n", servos.len()))?;
    }
    let stop = interrupt::answer();
    end_after(arguments.simulated.duration, stop);
    let (octets, written) = serve_with_truth(arguments.simulated.truth.as_deref(), &machine, |seen| {
        serve(&mut terminals, &mut simulated, step_ns(&machine), stop, seen).map_err(|e| refused(e).into())
    })?;
    let all = || simulated.chains().iter().flat_map(|chain| chain.servos());
    let powered = all().filter(|servo| servo.has_torque()).count();
    let content = if general.json {
        Content::json(&serde_json::json!({
            "simulated": true, "octets_received": octets, "servos_with_torque": powered,
        }))?
    } else {
        Content::Text(format!("{octets} octets received; at the end {powered} servos with torque\n"))
    };
    Ok(Answer::done(content, written))
}
