//! Keys of the tables of numbers: one entry per number, for reading and for listing.

use super::listing::{Listing, ValueSource};
use crate::Error;
use crate::description::document::{Entry, Table};
use crate::description::domain::{
    BELOW_ONE, Domain, FINITE, HOTTER_THAN_ROOM, LAG, LAYERS, NON_NEGATIVE, POSITIVE, UP_TO_ONE,
};
use crate::description::error::DescriptionError;
use crate::drive::{Cord, LoadCell, Motor, ReducerLosses, Winch};
use crate::machine::{ControlRules, SafetyLimits, Tolerances};
use crate::transmission::cable::{CableParameters, Weakening};
use alloc::format;
use alloc::vec::Vec;

/// A number of a structure: key with unit, domain, access.
#[derive(Debug)]
pub(super) struct Field<T> {
    pub(super) key: &'static str,
    pub(super) domain: Domain,
    /// None for an optional number that is not set.
    pub(super) get: fn(&T) -> Option<f64>,
    pub(super) set: fn(&mut T, f64),
}

/// One number: of a field, or, as `optional`, of a field that may be none.
macro_rules! field {
    ($key:literal, $domain:ident, optional $field:ident) => {
        Field { key: $key, domain: $domain, get: |x| x.$field, set: |x, value| x.$field = Some(value) }
    };
    ($key:literal, $domain:ident, $field:ident) => {
        Field { key: $key, domain: $domain, get: |x| Some(x.$field), set: |x, value| x.$field = value }
    };
}

macro_rules! fields {
    ($($key:literal: $domain:ident => $($field:ident)+),+ $(,)?) => {
        &[$(field!($key, $domain, $($field)+)),+]
    };
}

pub(super) const MOTOR: &[Field<Motor>] = fields![
    "torque_constant_nm_per_a": POSITIVE => torque_constant,
    "resistance_ohm": POSITIVE => resistance,
    "inductance_h": NON_NEGATIVE => inductance,
    "inertia_kg_m2": POSITIVE => inertia,
    "voltage_v": POSITIVE => voltage,
    "continuous_current_a": POSITIVE => continuous_current,
    "peak_current_a": POSITIVE => peak_current,
    "top_speed_rad_per_s": POSITIVE => top_speed,
    "winding_to_housing_k_per_w": NON_NEGATIVE => winding_to_housing,
    "housing_to_air_k_per_w": POSITIVE => housing_to_air,
    "winding_capacity_j_per_k": POSITIVE => winding_capacity,
    "housing_capacity_j_per_k": POSITIVE => housing_capacity,
    "hottest_c": HOTTER_THAN_ROOM => hottest,
];

pub(super) const REDUCER: &[Field<ReducerLosses>] = fields![
    "efficiency": UP_TO_ONE => efficiency,
    "friction_nm": NON_NEGATIVE => friction,
    "viscous_nm_s_per_rad": NON_NEGATIVE => viscous,
    "backlash_rad": NON_NEGATIVE => backlash,
    "ripple": BELOW_ONE => ripple,
    "ripple_per_turn": POSITIVE => ripple_per_turn,
];

pub(super) const WINCH: &[Field<Winch>] = &[
    field!("radius_m", POSITIVE, radius),
    field!("lead_m", NON_NEGATIVE, lead),
    field!("cable_diameter_m", POSITIVE, cable_diameter),
    field!("turns_per_layer", POSITIVE, turns_per_layer),
    // In 1..=8: the domain.
    Field {
        key: "layers",
        domain: LAYERS,
        get: |w| Some(f64::from(w.layers)),
        set: |w, x| w.layers = x as u8,
    },
];

pub(super) const CORD: &[Field<Cord>] = fields![
    "diameter_m": POSITIVE => diameter,
    "breaking_load_n": POSITIVE => breaking_load,
    "stiffness_n": POSITIVE => stiffness,
    "friction": NON_NEGATIVE => friction,
    "drag_n_s_per_m": NON_NEGATIVE => drag,
];

pub(super) const CABLE: &[Field<CableParameters>] = fields![
    "friction": NON_NEGATIVE => friction,
    "viscous_s_per_m": NON_NEGATIVE => viscous,
    "efficiency": UP_TO_ONE => efficiency,
    "drag_n_s_per_m": NON_NEGATIVE => drag,
    "drag_fade_n": POSITIVE => drag_fade,
    "pretension_n": NON_NEGATIVE => pretension,
    "compliance_per_n": POSITIVE => compliance,
    "sheath_compliance_per_n": NON_NEGATIVE => sheath_compliance,
];

pub(super) const WEAKENING: &[Field<Weakening>] = fields![
    "rise": NON_NEGATIVE => rise,
    "speed_m_per_s": POSITIVE => speed,
    "lag_s": LAG => lag,
];

pub(super) const LOAD_CELL: &[Field<LoadCell>] = fields![
    "gain": POSITIVE => gain,
    "offset_n": FINITE => offset,
    "noise_n": NON_NEGATIVE => noise,
    "resolution_n": NON_NEGATIVE => resolution,
    "range_n": POSITIVE => range,
];

pub(super) const SAFETY: &[Field<SafetyLimits>] = fields![
    "tension_n": POSITIVE => optional tension,
    "tension_rate_n_per_s": POSITIVE => optional tension_rate,
    "cable_speed_m_per_s": POSITIVE => optional cable_speed,
    "winding_c": HOTTER_THAN_ROOM => optional winding,
    "joint_margin": NON_NEGATIVE => joint_margin,
    "wind_in_speed_rad_per_s": POSITIVE => wind_in_speed,
    "pretension_time_s": POSITIVE => pretension_time,
    "largest_slack_rad": POSITIVE => largest_slack,
    "holding_time_s": NON_NEGATIVE => holding_time,
    "lowering_speed_rad_per_s": POSITIVE => lowering_speed,
    "lowering_time_s": POSITIVE => lowering_time,
    "bridged_loss_s": NON_NEGATIVE => bridged_loss,
    "bridged_lateness_s": NON_NEGATIVE => bridged_lateness,
    "lateness_s": POSITIVE => lateness,
    "command_age_s": POSITIVE => command_age,
    "unattended_s": NON_NEGATIVE => unattended,
];

pub(super) const TOLERANCES: &[Field<Tolerances>] = fields![
    "mass": BELOW_ONE => mass,
    "attachment_m": NON_NEGATIVE => optional attachment,
    "gain": BELOW_ONE => gain,
    "gear_losses": BELOW_ONE => gear_losses,
    "bend_by_joint": BELOW_ONE => bend,
    "zero_rad": NON_NEGATIVE => zero,
    "zero_m": NON_NEGATIVE => zero_slide,
    "link_m": NON_NEGATIVE => link,
    "axis_rad": NON_NEGATIVE => axis,
    "center_of_mass_m": NON_NEGATIVE => center_of_mass,
    "wrap_radius_m": NON_NEGATIVE => wrap_radius,
    "winch_radius": BELOW_ONE => winch,
    "eccentricity_rad": NON_NEGATIVE => eccentricity,
    "flex_rad_per_nm": NON_NEGATIVE => flex,
    "payload_kg": NON_NEGATIVE => payload,
];

pub(super) const CONTROL: &[Field<ControlRules>] = fields![
    "bandwidth_rad_per_s": POSITIVE => bandwidth,
    "observer_bandwidth_rad_per_s": POSITIVE => observer_bandwidth,
    "position_gain": POSITIVE => position_gain,
    "backlash_gain": POSITIVE => backlash_gain,
    "backlash_integral_per_s": POSITIVE => backlash_integral,
    "end_point_integral_per_s": NON_NEGATIVE => end_point_integral,
    "damping_crossover_rad_per_s": POSITIVE => damping_crossover,
    "shared_damping": POSITIVE => shared_damping,
    "margin": UP_TO_ONE => margin,
];

/// The keys of a table of numbers, and others.
pub(super) fn keys<T>(fields: &[Field<T>], others: &[&'static str]) -> Vec<&'static str> {
    fields.iter().map(|field| field.key).chain(others.iter().copied()).collect()
}

/// The first table, in order of precedence, that has a key.
pub(super) fn first<'d>(layers: &[Table<'d>], key: &str) -> Option<Entry<'d>> {
    layers.iter().find_map(|table| table.entry(key))
}

/// Numbers of a structure from tables in order of precedence; what none of them has stays as it is, and comes
/// from `other`. Keys are listed with the prefix.
pub(super) fn overlay<T>(
    layers: &[Table<'_>],
    fields: &[Field<T>],
    mut on: T,
    validate: fn(&T) -> Result<(), Error>,
    listing: &mut Listing,
    (prefix, other): (&str, ValueSource),
) -> Result<T, DescriptionError> {
    for field in fields {
        let entry = first(layers, field.key);
        if let Some(entry) = &entry {
            (field.set)(&mut on, entry.number(field.domain)?);
        }
        let source = entry.map_or(other, |entry| ValueSource::File { line: entry.line() });
        listing.optional(&format!("{prefix}{}", field.key), (field.get)(&on), source);
    }
    // Without a table these are defaults, which are valid.
    if let Some(table) = layers.first() {
        validate(&on).map_err(|error| table.out_of_domain(error))?;
    }
    Ok(on)
}

/// As [`overlay`], where every key is required.
pub(super) fn complete<T>(
    layers: &[Table<'_>],
    fields: &[Field<T>],
    on: T,
    validate: fn(&T) -> Result<(), Error>,
    listing: &mut Listing,
    named: (&str, ValueSource),
) -> Result<T, DescriptionError> {
    if let Some(table) = layers.first() {
        let missing = fields.iter().find(|field| first(layers, field.key).is_none());
        missing.map_or(Ok(()), |field| table.required(field.key).map(drop))?;
    }
    overlay(layers, fields, on, validate, listing, named)
}
