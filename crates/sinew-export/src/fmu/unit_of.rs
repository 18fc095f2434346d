//! Units by the names of columns.

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

/// A unit and its base units.
pub(super) type BaseUnit = (&'static str, &'static str);

/// The unit that the name of a column states, and its base units.
pub(super) fn unit(column: &str) -> Option<BaseUnit> {
    let lower = column.to_lowercase();
    let fits = UNITS.iter().filter(|(suffix, ..)| lower.ends_with(suffix));
    fits.max_by_key(|(suffix, ..)| suffix.len()).map(|(_, name, base)| (*name, *base))
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
