//! The variables of a unit: names, value references, units, start values.

use crate::ExportError;
use crate::c::{checksum, double};
use sinew::predictor::Model;
use std::collections::BTreeSet;

/// Outputs after the inputs: three numbers, then the flags.
pub(super) const NUMBERS: [(&str, &str); 3] = [
    ("prediction", "the far end"),
    ("standard_deviation", "prediction +- 1.96 of it is the calibrated 95 % band"),
    ("gate", "weight of the learned correction, 0 to 1"),
];
pub(super) const FLAGS: [(&str, &str); 4] = [
    ("state_unknown", "the state in the dead band depends on its start"),
    ("out_of_range", "an input is outside the range of the training logs"),
    ("input_held", "an input was missing or jumped: its last value stood in"),
    ("reset", "all states started at this sample"),
];

/// Suffixes of column names with the unit of FMI: name, exponents of kg, m, s, A and rad, factor to SI.
const UNITS: [(&str, &str, &str); 9] = [
    ("_n", "N", "kg=\"1\" m=\"1\" s=\"-2\""),
    ("_nm", "N.m", "kg=\"1\" m=\"2\" s=\"-2\""),
    ("_mm", "mm", "m=\"1\" factor=\"0.001\""),
    ("_m", "m", "m=\"1\""),
    ("_rad", "rad", "rad=\"1\""),
    ("_deg", "deg", "rad=\"1\" factor=\"0.017453292519943295\""),
    ("_a", "A", "A=\"1\""),
    ("_m_s", "m/s", "m=\"1\" s=\"-1\""),
    ("_rad_s", "rad/s", "rad=\"1\" s=\"-1\""),
];

/// The unit that the name of a column states, and its base units.
pub(super) fn unit(column: &str) -> Option<(&'static str, &'static str)> {
    let lower = column.to_lowercase();
    let fits = UNITS.iter().filter(|(suffix, ..)| lower.ends_with(suffix));
    fits.max_by_key(|(suffix, ..)| suffix.len()).map(|(_, name, base)| (*name, *base))
}

/// Names of the inputs: their columns; one that is taken already has its number behind it.
pub(super) fn input_names(model: &Model) -> Vec<String> {
    let outputs = NUMBERS.iter().chain(&FLAGS).map(|(name, _)| (*name).to_owned());
    let mut taken: BTreeSet<String> = outputs.chain(["time".to_owned()]).collect();
    let mut names = Vec::new();
    for (k, input) in model.inputs.iter().enumerate() {
        let mut name = input.column.clone();
        while name.is_empty() || !taken.insert(name.clone()) {
            name += &format!("_{}", k + 1);
        }
        names.push(name);
    }
    names
}

/// Start values of the inputs, as literals of C.
pub(super) fn starts(model: &Model) -> Vec<String> {
    model.guards.iter().map(|limits| double(limits.typical)).collect()
}

/// The token that tells units of different models apart.
pub(super) fn token(model: &Model) -> Result<String, ExportError> {
    Ok(format!("{{sinew-{}}}", checksum(model)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_those_that_names_state() {
        let named = |column| unit(column).map(|(name, _)| name);
        assert_eq!(named("tension_in_n"), Some("N"));
        assert_eq!(named("Torque_Nm"), Some("N.m"));
        assert_eq!(named("stroke_mm"), Some("mm"));
        assert_eq!(named("speed_m_s"), Some("m/s"));
        assert_eq!(named("bend"), None);
    }
}
