//! Losses of gears that the currents of a calibration have told.

use crate::table::{number, table};
use sinew::machine::Machine;
use sinew_identify::gear::{GearFit, Interval};
use sinew_report::tracking::Gear;

/// Those of a machine that were calibrated, with the names of their muscles.
pub(super) fn named(machine: &Machine, gears: &[Option<GearFit>]) -> Vec<Gear> {
    let muscles = machine.robot.parts().tendons.iter().zip(gears);
    let gears =
        muscles.filter_map(|(muscle, losses)| Some(Gear { muscle: muscle.name.clone(), losses: (*losses)? }));
    gears.collect()
}

/// A table, or nothing.
pub(super) fn text(gears: &[Gear]) -> String {
    if gears.is_empty() {
        return String::new();
    }
    let within = |of: Interval, factor: f64| {
        let [value, low, high] = [of.value, of.low, of.high].map(|x| number(Some(factor * x)));
        format!("{value} ({low} to {high})")
    };
    let row = |gear: &Gear| {
        let GearFit { efficiency, friction } = gear.losses;
        vec![gear.muscle.clone(), within(efficiency, 1.0), within(friction, 1e3)]
    };
    let rows: Vec<_> = gears.iter().map(row).collect();
    table(&["gear, by its currents (95 %)", "efficiency", "friction, mNm"], &rows, 1)
}
