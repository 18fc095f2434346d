//! The role that a column name implies, and the nearest name to one that no column has.

use super::types::Role;
use strsim::levenshtein;

/// Names with a canonical form, without their unit suffix and in lower case with underscores.
///
/// | role   | names                                                                     | example           |
/// |--------|---------------------------------------------------------------------------|-------------------|
/// | far    | tension, force, torque, t, f, tau + `_out`, `_far` or `_distal`           | `tension_out_n`   |
/// | effort | the same + `_in`, `_near`, `_proximal`, `_motor`                          | `T_in_Nm`         |
/// | motion | position, pos, angle, displacement, stroke, p, q, x, theta + `_in`, ...   | `angle_motor_rad` |
/// | motion | `stroke`                                                                  | `stroke_mm`       |
/// | anchor | `anchor`, `angle_joint`, `joint_angle`, `position_joint`, `joint_position`| `anchor_m`        |
/// | given  | `sheath`, `bend`, `sheath_bend`, `sheath_angle`, `bend_angle`             | `sheath_deg`      |
/// | time   | `time`, `timestamp`, `t` (with a unit of time or none)                    | `t_s`             |
/// | trial  | `trial`, `trial_id`, `episode`                                            | `trial`           |
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Meaning {
    /// What to predict.
    Far,
    /// An input.
    Input(Role),
    /// Time.
    Time,
    /// Trial label.
    Trial,
}

const EFFORTS: [&str; 6] = ["tension", "force", "torque", "t", "f", "tau"];
const MOTIONS: [&str; 9] = ["position", "pos", "angle", "displacement", "stroke", "p", "q", "x", "theta"];
const NEAR: [&str; 4] = ["in", "near", "proximal", "motor"];
const FAR: [&str; 3] = ["out", "far", "distal"];
const ANCHORS: [&str; 5] = ["anchor", "angle_joint", "joint_angle", "position_joint", "joint_position"];
const GIVENS: [&str; 5] = ["sheath", "bend", "sheath_bend", "sheath_angle", "bend_angle"];
const TIMES: [&str; 4] = ["time", "timestamp", "time_stamp", "t"];
const TRIALS: [&str; 3] = ["trial", "trial_id", "episode"];

/// Units of time with their length in seconds.
const TIME_UNITS: [(&str, f64); 14] = [
    ("s", 1.0),
    ("sec", 1.0),
    ("secs", 1.0),
    ("second", 1.0),
    ("seconds", 1.0),
    ("ms", 1e-3),
    ("msec", 1e-3),
    ("millis", 1e-3),
    ("us", 1e-6),
    ("usec", 1e-6),
    ("micros", 1e-6),
    ("ns", 1e-9),
    ("nsec", 1e-9),
    ("min", 60.0),
];
const OTHER_UNITS: [&str; 26] = [
    "n", "kn", "mn", "nm", "mnm", "nmm", "ncm", "kg", "g", "m", "mm", "cm", "um", "rad", "mrad", "deg",
    "degree", "degrees", "rev", "turns", "counts", "ticks", "v", "a", "ma", "percent",
];

/// Units with capital letters.
const CAPITAL_UNITS: [&str; 9] = ["N", "kN", "mN", "Nm", "mNm", "Nmm", "Ncm", "V", "A"];

/// What a column is by its name alone.
pub(super) fn meaning(column: &str) -> Option<Meaning> {
    let plain = plain(column);
    let (base, unit) = split_unit(&plain);
    let time_unit = unit.is_none_or(|u| TIME_UNITS.iter().any(|(name, _)| *name == u));
    // A capital T alone is as likely a tension or a temperature.
    if TIMES.contains(&base) && time_unit && column != "T" {
        return Some(Meaning::Time);
    }
    if TRIALS.contains(&plain.as_str()) {
        return Some(Meaning::Trial);
    }
    if ANCHORS.contains(&base) {
        return Some(Meaning::Input(Role::Anchor));
    }
    if GIVENS.contains(&base) {
        return Some(Meaning::Input(Role::Given));
    }
    if base == "stroke" {
        return Some(Meaning::Input(Role::Motion));
    }
    let (quantity, side) = sided(base)?;
    match (EFFORTS.contains(&quantity), MOTIONS.contains(&quantity)) {
        (true, _) if FAR.contains(&side) => Some(Meaning::Far),
        (true, _) if NEAR.contains(&side) => Some(Meaning::Input(Role::Effort)),
        (_, true) if NEAR.contains(&side) => Some(Meaning::Input(Role::Motion)),
        _ => None,
    }
}

/// `tension_in` or `motor_tension` as quantity and side.
fn sided(base: &str) -> Option<(&str, &str)> {
    let (first, last) = base.split_once('_')?;
    let is_side = |word: &str| NEAR.contains(&word) || FAR.contains(&word);
    if is_side(last) { Some((first, last)) } else { is_side(first).then_some((last, first)) }
}

/// Lower case, with one underscore for whatever is neither letter nor digit: `T in (N)` is `t_in_n`.
fn plain(column: &str) -> String {
    let mut plain = String::with_capacity(column.len());
    for c in column.trim().chars() {
        if c.is_alphanumeric() {
            plain.extend(c.to_lowercase());
        } else if !plain.ends_with('_') {
            plain.push('_');
        }
    }
    plain.trim_matches('_').to_owned()
}

fn split_unit(plain: &str) -> (&str, Option<&str>) {
    match plain.rsplit_once('_') {
        Some((base, unit)) if is_plain_unit(unit) => (base, Some(unit)),
        _ => (plain, None),
    }
}

fn is_plain_unit(word: &str) -> bool {
    OTHER_UNITS.contains(&word) || TIME_UNITS.iter().any(|(name, _)| *name == word)
}

/// The unit in a name, as it is written in text, or an empty string: that of its last word which is a unit, so that
/// `tension_n_filtered` has one. The first word is the quantity.
#[must_use]
pub fn unit_of(column: &str) -> String {
    let plain = plain(column);
    let unit = plain.split('_').skip(1).filter(|word| is_plain_unit(word)).last().unwrap_or_default();
    let written = CAPITAL_UNITS.iter().find(|name| name.eq_ignore_ascii_case(unit));
    written.map_or_else(|| unit.to_owned(), |name| (*name).to_owned())
}

/// Whether a cell of a units row could be a unit: short, or empty, or in brackets.
pub(super) fn is_unit(cell: &str) -> bool {
    let plain = plain(cell);
    plain.is_empty() || is_plain_unit(&plain) || cell.starts_with(['[', '('])
}

/// Seconds per unit of a time column, from its name or from its cell in a units row.
pub(super) fn time_scale(column: &str, unit: &str) -> f64 {
    let plain_name = plain(column);
    let plain_unit = plain(unit);
    let of = |word: &str| TIME_UNITS.iter().find(|(name, _)| *name == word).map(|&(_, scale)| scale);
    let by_name = plain_name.rsplit_once('_').and_then(|(_, word)| of(word));
    by_name.or_else(|| of(&plain_unit)).unwrap_or(1.0)
}

/// The column nearest to `wanted`, if one is near enough to have been meant.
pub(super) fn nearest<'a>(wanted: &str, columns: &'a [String]) -> Option<&'a str> {
    let target = plain(wanted);
    let allowed = (target.chars().count() / 3).max(2);
    let scored = columns.iter().map(|column| (levenshtein(&target, &plain(column)), column));
    let near = scored.filter(|&(d, column)| {
        d <= allowed && (d < target.chars().count().max(1) || column.eq_ignore_ascii_case(wanted))
    });
    near.min_by(|a, b| a.0.cmp(&b.0).then_with(|| a.1.cmp(b.1))).map(|(_, column)| column.as_str())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_with_unit_suffixes_are_found_and_others_are_not() {
        for (name, expected) in [
            ("tension_in_n", Some(Meaning::Input(Role::Effort))),
            ("T_in_N", Some(Meaning::Input(Role::Effort))),
            ("t_in_nm", Some(Meaning::Input(Role::Effort))),
            ("Tension in (N)", Some(Meaning::Input(Role::Effort))),
            ("motor_torque_nm", Some(Meaning::Input(Role::Effort))),
            ("position_in_m", Some(Meaning::Input(Role::Motion))),
            ("angle_motor_rad", Some(Meaning::Input(Role::Motion))),
            ("p_in_rad", Some(Meaning::Input(Role::Motion))),
            ("stroke_mm", Some(Meaning::Input(Role::Motion))),
            ("tension_out_n", Some(Meaning::Far)),
            ("T_out_N", Some(Meaning::Far)),
            ("angle_joint_rad", Some(Meaning::Input(Role::Anchor))),
            ("anchor_m", Some(Meaning::Input(Role::Anchor))),
            ("sheath_deg", Some(Meaning::Input(Role::Given))),
            ("bend", Some(Meaning::Input(Role::Given))),
            ("t_s", Some(Meaning::Time)),
            ("time_ms", Some(Meaning::Time)),
            ("Time [s]", Some(Meaning::Time)),
            ("t", Some(Meaning::Time)),
            ("trial", Some(Meaning::Trial)),
            ("T", None),
            ("t_n", None),
            ("T_in_N_med5", None),
            ("stroke_ref_mm", None),
            ("p_out_rad", None),
            ("freq_hz", None),
        ] {
            assert_eq!(meaning(name), expected, "{name}");
        }
    }

    #[test]
    fn the_nearest_name_ignores_case_and_forgives_slips_but_does_not_guess() {
        let columns: Vec<String> = ["t_s", "T_in_N", "T_out_N"].iter().map(|s| (*s).to_owned()).collect();
        assert_eq!(nearest("t_OUT_n", &columns), Some("T_out_N"));
        assert_eq!(nearest("T_ouf_N", &columns), Some("T_out_N"));
        assert_eq!(nearest("Tin_N", &columns), Some("T_in_N"));
        assert_eq!(nearest("temperature", &columns), None);
    }

    #[test]
    fn time_is_scaled_by_its_suffix_or_its_unit() {
        assert!((time_scale("t_ms", "") - 1e-3).abs() < 1e-18);
        assert!((time_scale("time (us)", "") - 1e-6).abs() < 1e-18);
        assert!((time_scale("time", "[ms]") - 1e-3).abs() < 1e-18);
        assert!((time_scale("time", "") - 1.0).abs() < 1e-18);
    }
}
