//! Units of columns: as written in names and rows of units, and the factors between them.

/// What a unit measures, as far as numbers are converted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Time,
    Length,
    Angle,
    Force,
    Torque,
    /// Known by name and never converted.
    Other,
}

/// Units in lower case with their kind and their size in SI; a mass is the force of its weight, as on the
/// display of a load cell.
const UNITS: [(&str, Kind, f64); 52] = [
    ("s", Kind::Time, 1.0),
    ("sec", Kind::Time, 1.0),
    ("secs", Kind::Time, 1.0),
    ("second", Kind::Time, 1.0),
    ("seconds", Kind::Time, 1.0),
    ("ms", Kind::Time, 1e-3),
    ("msec", Kind::Time, 1e-3),
    ("millis", Kind::Time, 1e-3),
    ("milliseconds", Kind::Time, 1e-3),
    ("us", Kind::Time, 1e-6),
    ("usec", Kind::Time, 1e-6),
    ("micros", Kind::Time, 1e-6),
    ("microseconds", Kind::Time, 1e-6),
    ("ns", Kind::Time, 1e-9),
    ("nsec", Kind::Time, 1e-9),
    ("min", Kind::Time, 60.0),
    ("n", Kind::Force, 1.0),
    ("kn", Kind::Force, 1e3),
    ("mn", Kind::Force, 1e-3),
    ("kg", Kind::Force, 9.80665),
    ("kgf", Kind::Force, 9.80665),
    ("g", Kind::Force, 9.80665e-3),
    ("lbf", Kind::Force, 4.448_221_615_260_5),
    ("lb", Kind::Force, 4.448_221_615_260_5),
    ("nm", Kind::Torque, 1.0),
    ("mnm", Kind::Torque, 1e-3),
    ("nmm", Kind::Torque, 1e-3),
    ("ncm", Kind::Torque, 1e-2),
    ("m", Kind::Length, 1.0),
    ("mm", Kind::Length, 1e-3),
    ("cm", Kind::Length, 1e-2),
    ("um", Kind::Length, 1e-6),
    ("in", Kind::Length, 0.0254),
    ("inch", Kind::Length, 0.0254),
    ("rad", Kind::Angle, 1.0),
    ("mrad", Kind::Angle, 1e-3),
    ("deg", Kind::Angle, core::f64::consts::PI / 180.0),
    ("degree", Kind::Angle, core::f64::consts::PI / 180.0),
    ("degrees", Kind::Angle, core::f64::consts::PI / 180.0),
    ("rev", Kind::Angle, core::f64::consts::TAU),
    ("turns", Kind::Angle, core::f64::consts::TAU),
    ("counts", Kind::Other, 1.0),
    ("ticks", Kind::Other, 1.0),
    ("v", Kind::Other, 1.0),
    ("a", Kind::Other, 1.0),
    ("ma", Kind::Other, 1e-3),
    ("percent", Kind::Other, 1.0),
    ("hz", Kind::Other, 1.0),
    ("c", Kind::Other, 1.0),
    ("degc", Kind::Other, 1.0),
    ("celsius", Kind::Other, 1.0),
    ("k", Kind::Other, 1.0),
];

/// Units that are words of names too: `T_in` is no inch, `joint_c` no temperature, and `freq_hz` no quantity
/// of a transmission.
const NOT_IN_NAMES: [&str; 6] = ["in", "inch", "hz", "lb", "c", "k"];

/// Units with capital letters.
const CAPITAL_UNITS: [&str; 12] = ["N", "kN", "mN", "Nm", "mNm", "Nmm", "Ncm", "V", "A", "Hz", "C", "K"];

fn known(word: &str) -> Option<(Kind, f64)> {
    UNITS.iter().find(|(name, ..)| *name == word).map(|&(_, kind, size)| (kind, size))
}

/// The letters of a sign that stands for some.
fn letters(sign: char) -> Option<&'static str> {
    Some(match sign {
        'µ' | 'μ' => "u",
        '°' | 'º' => "deg",
        '%' => "percent",
        _ => return None,
    })
}

/// Lower case, with one underscore for whatever is neither letter nor digit: `T in (N)` is `t_in_n`.
pub(super) fn plain(column: &str) -> String {
    let mut plain = String::with_capacity(column.len());
    for c in column.trim().chars() {
        if let Some(letters) = letters(c) {
            plain.push_str(letters);
        } else if c.is_alphanumeric() {
            plain.extend(c.to_lowercase());
        } else if !plain.ends_with('_') {
            plain.push('_');
        }
    }
    plain.trim_matches('_').to_owned()
}

/// The unit as a word of [`UNITS`]: `[Nm]`, `N m` and `N·m` are `nm`. Other signs stay: `m/s` is no
/// millisecond, and what an encoding has made of a sign is no unit.
fn word(unit: &str) -> String {
    let unsaid = |c: char| c.is_whitespace() || "[](){}_-.·⋅*".contains(c);
    let mut word = String::with_capacity(unit.len());
    for c in unit.chars().filter(|c| !unsaid(*c)) {
        match letters(c) {
            Some(letters) => word.push_str(letters),
            None => word.extend(c.to_lowercase()),
        }
    }
    word
}

/// A plain name as its base and its unit.
pub(super) fn split_unit(plain: &str) -> (&str, Option<&str>) {
    match plain.rsplit_once('_') {
        Some((base, unit)) if is_unit_in_name(unit) => (base, Some(unit)),
        _ => (plain, None),
    }
}

/// A name that ends in a known unit in brackets, and that unit: whatever stands in brackets is no word of the
/// name.
pub(super) fn bracketed(column: &str) -> Option<(&str, &str)> {
    let inner = column.trim_end().strip_suffix([']', ')'])?;
    let (before, unit) = inner.rsplit_once(['[', '('])?;
    is_known(unit).then_some((before, unit))
}

fn is_unit_in_name(word: &str) -> bool {
    known(word).is_some() && !NOT_IN_NAMES.contains(&word)
}

/// Whether a text is a unit that is known.
pub(super) fn is_known(unit: &str) -> bool {
    known(&word(unit)).is_some()
}

/// Whether a text is a unit of time.
pub(super) fn is_time(unit: &str) -> bool {
    known(&word(unit)).is_some_and(|(kind, _)| kind == Kind::Time)
}

/// Seconds per unit of a time column; `None` where it is no unit of time.
pub(super) fn seconds(unit: &str) -> Option<f64> {
    known(&word(unit)).filter(|(kind, _)| *kind == Kind::Time).map(|(_, size)| size)
}

/// The factor from numbers in one unit to numbers in another; `None` where they measure different things.
pub(crate) fn factor(from: &str, to: &str) -> Option<f64> {
    let (from, to) = (word(from), word(to));
    // Without a unit a number is taken as it is.
    if from == to || from.is_empty() || to.is_empty() {
        return Some(1.0);
    }
    let ((one, a), (other, b)) = (known(&from)?, known(&to)?);
    (one == other && one != Kind::Other).then_some(a / b)
}

/// Whether two units are known to measure different things. A letter such as the `A` of `LC-A` may be no
/// unit.
pub(super) fn contradict(one: &str, other: &str) -> bool {
    let kind = |unit: &str| known(&word(unit)).map(|(kind, _)| kind).filter(|kind| *kind != Kind::Other);
    kind(one).zip(kind(other)).is_some_and(|(one, other)| one != other)
}

/// Units known by name, for messages.
pub(super) fn names() -> Vec<String> {
    UNITS.iter().map(|(name, ..)| written(name)).collect()
}

/// A unit as it is written in text.
fn written(unit: &str) -> String {
    let capital = CAPITAL_UNITS.iter().find(|name| name.eq_ignore_ascii_case(unit));
    capital.map_or_else(|| unit.to_owned(), |name| (*name).to_owned())
}

/// The unit in a name, as it is written in text, or an empty string: that of its last word which is a unit,
/// so that `tension_n_filtered` has one. The first word is the quantity.
#[must_use]
pub fn unit_of(column: &str) -> String {
    if let Some((_, unit)) = bracketed(column) {
        return written(&word(unit));
    }
    // A quotient of units is none of them.
    if column.trim_end().ends_with([']', ')']) && column.contains('/') {
        return String::new();
    }
    let plain = plain(column);
    written(plain.split('_').skip(1).filter(|word| is_unit_in_name(word)).last().unwrap_or_default())
}

/// Whether a cell of a units row could be a unit: short, or empty, or in brackets.
pub(super) fn is_unit_cell(cell: &str) -> bool {
    word(cell).is_empty() || is_known(cell) || cell.starts_with(['[', '('])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_convert_within_their_kind_and_not_beyond() {
        for (from, to, expected) in [
            ("kN", "N", Some(1e3)),
            ("[mm]", "m", Some(1e-3)),
            ("N m", "Nm", Some(1.0)),
            ("", "N", Some(1.0)),
            ("mm", "", Some(1.0)),
            ("N", "Nm", None),
            ("counts", "rad", None),
            ("bogus", "N", None),
            ("ms", "s", Some(1e-3)),
            ("m/s", "s", None),
            ("N/m", "Nm", None),
            ("\u{fffd}m", "m", None),
            ("[µm]", "mm", Some(1e-3)),
            ("°", "deg", Some(1.0)),
        ] {
            assert_eq!(factor(from, to), expected, "{from} to {to}");
        }
        assert!((factor("deg", "rad").unwrap_or(f64::NAN) * 180.0 - core::f64::consts::PI).abs() < 1e-12);
    }

    #[test]
    fn temperatures_are_units_and_no_words_of_names() {
        assert!(["[°C]", "(K)", "degC"].map(is_known) == [true; 3]);
        assert_eq!((unit_of("joint_c"), unit_of("temperature_degc")), (String::new(), "degc".to_owned()));
    }

    #[test]
    fn a_unit_of_time_has_a_length_and_another_has_none() {
        assert_eq!(seconds("[ms]"), Some(1e-3));
        assert_eq!(seconds("(µs)"), Some(1e-6));
        assert_eq!(seconds("s"), Some(1.0));
        assert_eq!(seconds("N"), None);
    }

    #[test]
    fn the_unit_of_a_name_is_its_last_word_that_is_one() {
        for (name, unit) in [
            ("tension_n_filtered", "N"),
            ("T [lbf]", "lbf"),
            ("gap (in)", "in"),
            ("LC_tip_lbf", "lbf"),
            ("T in (mNm)", "mNm"),
            ("T_in", ""),
            ("t_s", "s"),
            ("n", ""),
            ("Winkel [°]", "deg"),
            ("speed [m/s]", ""),
        ] {
            assert_eq!(unit_of(name), unit, "{name}");
        }
    }
}
