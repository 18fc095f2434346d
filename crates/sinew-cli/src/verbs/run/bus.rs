//! Exchanges of a run: JSON, and a line for people where something was wrong.

use crate::arguments::BusArgument;
use sinew::machine::Machine;
use sinew_session::{BusFault, BusStatistics, ClockReport};

pub(super) fn json(statistics: &BusStatistics, clocks: Option<ClockReport>) -> serde_json::Value {
    let clocks = clocks.map(|clocks| {
        serde_json::json!({
            "drives_with_sync0": clocks.synchronized,
            "drift_ppm": clocks.drift_ppm,
            "phase_rms_us": clocks.phase_rms_us,
            "phase_max_us": clocks.phase_max_us,
            "device_difference_max_ns": clocks.device_difference_ns,
        })
    });
    serde_json::json!({
        "clocks": clocks,
        "exchanges": statistics.exchanges,
        "lost": statistics.lost,
        "devices_missing": statistics.missing,
        "device_not_ready": statistics.not_ready,
        "drive_faults": statistics.drive,
        "late": statistics.late,
    })
}

pub(super) fn text(statistics: &BusStatistics, bus: BusArgument, machine: &Machine) -> String {
    let BusStatistics { exchanges, lost, missing, not_ready, drive, late, first } = statistics;
    let Some((cycle, fault)) = first else { return String::new() };
    format!(
        "Bus: of {exchanges} exchanges {lost} lost, {missing} without all devices, {not_ready} with a \
         device that was not ready, {drive} with a drive in fault, {late} late or without a new command by \
         injection; the first in cycle {cycle}: {}\n",
        described(*fault, bus, machine)
    )
}

/// What the clocks of the devices said.
pub(super) fn clocks_text(clocks: Option<ClockReport>) -> String {
    let Some(clocks) = clocks else { return String::new() };
    let ClockReport { synchronized, drift_ppm, phase_rms_us, phase_max_us, device_difference_ns } = clocks;
    format!(
        "Distributed clocks: {synchronized} drives with SYNC0; the devices' time runs {:.1} ppm {} than this \
            computer's; cycle in phase within {phase_rms_us:.1} us rms (max {phase_max_us:.1}); devices \
            among each other within {device_difference_ns} ns\n",
        drift_ppm.abs(),
        if drift_ppm < 0.0 { "slower" } else { "faster" },
    )
}

/// A fault with the name of its device, its code in the words of the bus.
fn described(fault: BusFault, bus: BusArgument, machine: &Machine) -> String {
    let name = |k: usize| machine.devices.get(k).map_or("a device", |device| device.name.as_str());
    let words = bus.words(fault);
    match fault {
        BusFault::Lost => "no answer".to_owned(),
        BusFault::Missing { .. } => words,
        BusFault::NotReady { device, .. } => format!("{} {words}", name(device)),
        BusFault::Drive { muscle, .. } => {
            let place = machine.devices.iter().position(|device| device.driven_muscle() == Some(muscle));
            format!("{} {words}", place.map_or("a drive", name))
        }
        BusFault::Late { by_ns } => format!("late by {:.3} ms", f64::from(by_ns) * 1e-6),
        BusFault::Stale { age_us } => format!("no command for {:.3} ms", f64::from(age_us) * 1e-3),
    }
}
