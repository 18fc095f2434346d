//! The role that a column name implies, and the nearest name to one that no column has.

use super::types::Role;
use super::units::{is_time, plain, split_unit};
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
/// | time   | `zeit`, `tid`, `elapsed`, `seconds`, `X_Value`, `..._time`, where none of the above | `Zeit [ms]` |
/// | trial  | `trial`, `trial_id`, `episode`                                            | `trial`           |
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Meaning {
    /// What to predict.
    Far,
    /// An input.
    Input(Role),
    /// Time.
    Time,
    /// Time, where no column is called by a name of [`Meaning::Time`].
    TimeLike,
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
/// Time in other languages and programs; words of a stopwatch.
const TIMES_LIKE: [&str; 29] = [
    "zeit",
    "zeitstempel",
    "uhrzeit",
    "tid",
    "tidsstempel",
    "tijd",
    "temps",
    "tiempo",
    "tempo",
    "cas",
    "czas",
    "aika",
    "ido",
    "zaman",
    "vreme",
    "время",
    "时间",
    "時間",
    "시간",
    "elapsed",
    "clock",
    "datetime",
    "date_time",
    "stamp",
    "ts",
    "tstamp",
    "timestamps",
    "x_value",
    "index_level_0",
];
const TRIALS: [&str; 3] = ["trial", "trial_id", "episode"];

/// What a column is by its name alone.
pub(super) fn meaning(column: &str) -> Option<Meaning> {
    let plain = plain(column);
    let (base, unit) = split_unit(&plain);
    let time_unit = unit.is_none_or(is_time);
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
    sided_meaning(base).or_else(|| time_like(&plain, column).then_some(Meaning::TimeLike))
}

/// Whether a name is one of [`TIMES_LIKE`], a unit of time alone, or speaks of time at its start or end.
fn time_like(plain: &str, column: &str) -> bool {
    let (base, unit) = split_unit(plain);
    let speaks = |base: &str| {
        TIMES_LIKE.contains(&base)
            || ["time", "elapsed", "timestamp"].iter().any(|word| {
                base.strip_prefix(word).is_some_and(|rest| rest.starts_with('_'))
                    || base.strip_suffix(word).is_some_and(|rest| rest.ends_with('_'))
            })
    };
    // One letter is a quantity, `MS` no unit, and `min` as often a minimum.
    let unit_alone = plain.len() > 1 && plain != "min" && is_time(plain) && column != column.to_uppercase();
    unit_alone || unit.is_none_or(is_time) && speaks(base)
}

/// The meaning of a quantity with its side.
fn sided_meaning(base: &str) -> Option<Meaning> {
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

/// The column nearest to `requested`, if one is near enough to have been meant.
pub(super) fn nearest<'a>(requested: &str, columns: &'a [String]) -> Option<&'a str> {
    let target = plain(requested);
    let allowed = (target.chars().count() / 3).max(2);
    let scored = columns.iter().map(|column| (levenshtein(&target, &plain(column)), column));
    let near = scored.filter(|&(d, column)| {
        d <= allowed && (d < target.chars().count().max(1) || column.eq_ignore_ascii_case(requested))
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
            ("Zeit [s]", Some(Meaning::TimeLike)),
            ("tid", Some(Meaning::TimeLike)),
            ("elapsed_ms", Some(Meaning::TimeLike)),
            ("elapsed time (s)", Some(Meaning::TimeLike)),
            ("sim_time", Some(Meaning::TimeLike)),
            ("Seconds", Some(Meaning::TimeLike)),
            ("X_Value", Some(Meaning::TimeLike)),
            ("timer_n", None),
            ("lifetime", None),
            ("min", None),
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
}
