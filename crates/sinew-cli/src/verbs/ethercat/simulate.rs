//! `sinew ethercat simulate`.

use crate::answer::{Answer, Content};
use crate::arguments::{EthercatSimulateArguments, General};
use crate::error::Error;
use crate::interrupt;
use crate::output::{print, refuse_overwrite};
use crate::verbs::device_files;
use crate::verbs::machine_source::load_machine;
use crate::verbs::simulated_arm::{end_after, serve_with_truth, simulated_arm, step_ns};
use sinew_runtime::ethercat::{SimulatedMachine, serve};
use sinew_segment::RawSocket;

pub(super) fn run(arguments: &EthercatSimulateArguments, general: &General) -> Result<Answer, Error> {
    refuse_overwrite([&arguments.machine], arguments.truth.as_slice(), general.no_clobber)?;
    let (described, devices) = load_machine(&arguments.machine, None, arguments.root.dir.as_deref())?;
    let (machine, devices) = (described.machine, devices.of());
    let descriptions = device_files::read(&arguments.devices.files, devices)?;
    let socket = RawSocket::open(&arguments.interface)?;
    let arm = simulated_arm(&machine, arguments.seed)?;
    let mut simulated = SimulatedMachine::new(arm, &machine, devices.to_vec());
    let mut segment = simulated.segment(&descriptions)?;
    if !general.json {
        print(&format!(
            "SIMULATED {}: {} devices answer on {}; Ctrl-C ends\n",
            machine.robot.parts().name,
            segment.devices().len(),
            arguments.interface
        ))?;
    }
    let stop = interrupt::answer();
    end_after(arguments.duration, stop);
    let (answered, written) = serve_with_truth(arguments.truth.as_deref(), &machine, |seen| {
        Ok(serve(&socket, (&mut segment, &mut simulated), step_ns(&machine), stop, seen)?)
    })?;
    // What the master has left behind: drives that it did not disable, and those that stopped by themselves.
    let drives = || segment.devices().iter().filter_map(|device| device.drive());
    let powered = drives().filter(|drive| drive.brake_released()).count();
    let faults = drives().filter(|drive| drive.error_code() != 0).count();
    let content = if general.json {
        Content::json(&serde_json::json!({
            "simulated": true, "frames_answered": answered,
            "drives_with_power": powered, "drives_with_a_fault": faults,
        }))?
    } else {
        Content::Text(format!(
            "{answered} frames answered; at the end {powered} drives with power, {faults} with a fault\n"
        ))
    };
    Ok(Answer::done(content, written))
}
