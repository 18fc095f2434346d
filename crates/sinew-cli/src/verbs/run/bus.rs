//! Exchanges of a run: JSON, and a line for people where something was wrong.

use sinew::machine::Machine;
use sinew_runtime::bus::{BusFault, BusStatistics};

pub(super) fn json(statistics: &BusStatistics) -> serde_json::Value {
    serde_json::json!({
        "exchanges": statistics.exchanges,
        "lost": statistics.lost,
        "working_counter_errors": statistics.working_counter,
        "device_not_operational": statistics.not_operational,
        "drive_faults": statistics.drive,
    })
}

pub(super) fn text(statistics: &BusStatistics, machine: &Machine) -> String {
    let BusStatistics { exchanges, lost, working_counter, not_operational, drive, first } = statistics;
    let Some((cycle, fault)) = first else { return String::new() };
    format!(
        "Bus: of {exchanges} exchanges {lost} lost, {working_counter} with a wrong working counter, {not_operational} with a \
         device out of operation, {drive} with a drive in fault; the first in cycle {cycle}: {}\n",
        described(*fault, machine)
    )
}

/// A fault with the name of its device.
pub(super) fn described(fault: BusFault, machine: &Machine) -> String {
    let device = |k: usize| machine.devices.get(k).map_or("?", |device| device.name.as_str());
    match fault {
        BusFault::Lost => "no answer".to_owned(),
        BusFault::WorkingCounter { expected, got } => format!("working counter {got} instead of {expected}"),
        BusFault::NotOperational { device: k, state, .. } => {
            format!("{} is in state {state:#x} instead of OP (0x8)", device(k))
        }
        BusFault::Drive { muscle, code } => {
            let place = machine.devices.iter().position(|device| device.driven_muscle() == Some(muscle));
            format!("{} reports error code {code:#06x}", place.map_or("a drive", device))
        }
    }
}
