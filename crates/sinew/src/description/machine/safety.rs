//! Limits of the supervisor, and those that hold for every muscle.

use super::fields::{SAFETY, keys, overlay};
use super::listing::{Listing, ValueSource};
use crate::body::Robot;
use crate::description::document::Table;
use crate::description::error::DescriptionError;
use crate::machine::{Machine, SafetyLimits};
use alloc::format;
use alloc::vec::Vec;

/// Reads the table `[safety]`. Its limits are listed, and for every muscle those that the table leaves to the
/// drive.
pub(super) fn safety(
    root: &Table<'_>,
    machine: &Machine,
    listing: &mut Listing,
) -> Result<SafetyLimits, DescriptionError> {
    let table = root.table("safety")?;
    table.iter().try_for_each(|table| table.check_keys(&keys(SAFETY, &[])))?;
    listing.begin("[safety]");
    let layers: Vec<Table<'_>> = table.into_iter().collect();
    let (named, usual) = (("", ValueSource::Default), SafetyLimits::at_period(machine.period));
    let safety = overlay(&layers, SAFETY, usual, SafetyLimits::validate, listing, named)?;
    list_resolved(&machine.robot, machine, &safety, listing);
    Ok(safety)
}

/// Lists the limits of every muscle that follow from its drive.
fn list_resolved(robot: &Robot, machine: &Machine, safety: &SafetyLimits, listing: &mut Listing) {
    for (tendon, design) in robot.parts().tendons.iter().zip(&machine.muscles) {
        listing.begin(&format!("[safety] of `{}`", tendon.name));
        let resolved = safety.of_drive(&design.drive);
        for (key, value, given) in [
            ("tension_n", resolved.tension, safety.tension),
            ("tension_rate_n_per_s", resolved.tension_rate, safety.tension_rate),
            ("cable_speed_m_per_s", resolved.cable_speed, safety.cable_speed),
            ("winding_c", resolved.winding, safety.winding),
        ] {
            if given.is_none() {
                listing.number(key, value, ValueSource::Default);
            }
        }
        listing.number("travel_m", design.drive.winch.capacity(), ValueSource::Default);
    }
}
