//! Formatting of numbers and units.

/// Placeholder of a missing number.
pub(super) const NONE: &str = "–";

/// `value` with `digits` significant digits; scientific outside 1e-4 to 1e6; `–` where it is not finite.
pub(super) fn significant(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return NONE.to_owned();
    }
    if value.abs() < f64::MIN_POSITIVE {
        return "0".to_owned();
    }
    // The exponent after rounding: 0.9996 with three digits is 1.00.
    let scientific = format!("{value:.*e}", digits.saturating_sub(1));
    let exponent = scientific.split_once('e').and_then(|(_, e)| e.parse::<i32>().ok()).unwrap_or(0);
    if (-4..6).contains(&exponent) {
        let decimals = i32::try_from(digits).unwrap_or(3) - 1 - exponent;
        minus(&format!("{value:.*}", usize::try_from(decimals).unwrap_or(0)))
    } else {
        minus(&scientific)
    }
}

/// A quantity of a machine in the units of physics; what is below a billionth is the rounding of a sum that
/// is zero.
pub(super) fn physical(value: f64, digits: usize) -> String {
    significant(if value.abs() < 1e-9 { 0.0 } else { value }, digits)
}

/// `value` with a fixed number of decimals; `–` where it is not finite.
pub(super) fn fixed(value: f64, decimals: usize) -> String {
    if !value.is_finite() {
        return NONE.to_owned();
    }
    if value.abs() >= 1e9 {
        return significant(value, 3);
    }
    let text = format!("{value:.decimals$}");
    // Negative zero is shown as zero.
    if text.starts_with('-') && text.bytes().all(|b| matches!(b, b'-' | b'0' | b'.')) {
        return text.trim_start_matches('-').to_owned();
    }
    minus(&text)
}

/// A fraction as a percentage with its sign, for example `96.1 %`.
pub(super) fn percent(fraction: f64) -> String {
    match fraction.is_finite() {
        true => format!("{}\u{202f}%", fixed(100.0 * fraction, usize::from(fraction < 0.9995))),
        false => NONE.to_owned(),
    }
}

/// A value that is a percentage already, with two or three significant digits.
pub(super) fn percent_of_range(value: f64) -> String {
    match value.is_finite() {
        true => format!("{}\u{202f}%", percent_number(value)),
        false => NONE.to_owned(),
    }
}

/// The same without its sign.
pub(super) fn percent_number(value: f64) -> String {
    fixed(value, if value.abs() < 1.0 { 2 } else { 1 + usize::from(value.abs() < 9.995) })
}

/// A number of things, grouped by thin spaces.
pub(super) fn count(n: usize) -> String {
    let digits = n.to_string();
    let mut text = String::with_capacity(digits.len() * 2);
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push('\u{202f}');
        }
        text.push(digit);
    }
    text
}

/// A duration in s, min or h.
pub(super) fn duration(seconds: f64) -> String {
    if !seconds.is_finite() {
        NONE.to_owned()
    } else if seconds < 600.0 {
        format!("{}\u{202f}s", significant(seconds, 3))
    } else if seconds < 7200.0 {
        format!("{}\u{202f}min", significant(seconds / 60.0, 3))
    } else {
        format!("{}\u{202f}h", significant(seconds / 3600.0, 3))
    }
}

/// A number followed by its unit.
pub(super) fn with_unit(number: &str, unit: &str) -> String {
    match unit {
        "" | "1" => number.to_owned(),
        _ if number == NONE => number.to_owned(),
        "°" => format!("{number}°"),
        _ => format!("{number}\u{202f}{unit}"),
    }
}

/// `count` with the word that fits it.
pub(super) fn plural(n: usize, one: &str, many: &str) -> String {
    format!("{}\u{00a0}{}", count(n), if n == 1 { one } else { many })
}

/// The unit a column's name ends with, or an empty string: `tension_in_n` is in N.
pub(super) fn unit_of(column: &str) -> &'static str {
    if let Some((_, inner)) = bracketed(column) {
        return unit(inner);
    }
    let mut parts = column.rsplit('_');
    let last = parts.next().unwrap_or_default();
    // Without an underscore the word is a name; `T_in_N_med5` has its unit in the last but one place.
    match parts.next() {
        None => "",
        Some(before) => match unit(last) {
            "" if before.len() < column.len() - last.len() - 1 => unit(before),
            found => found,
        },
    }
}

/// A name with a known unit in brackets behind it, and that unit.
fn bracketed(column: &str) -> Option<(&str, &str)> {
    let (name, inner) = column.strip_suffix([']', ')'])?.rsplit_once(['[', '('])?;
    (!unit(inner).is_empty()).then_some((name.trim_end(), inner))
}

/// A unit as reports write it; empty for one that they do not know.
pub(super) fn unit(suffix: &str) -> &'static str {
    match suffix {
        "kN" | "kn" => "kN",
        "mN" | "mn" => "mN",
        "lbf" | "lb" => "lbf",
        "kg" => "kg",
        "kgf" => "kgf",
        "cm" => "cm",
        "um" => "µm",
        "mNm" => "mN·m",
        "Ncm" => "N·cm",
        "mrad" => "mrad",
        "n" | "N" => "N",
        "nm" | "Nm" | "NM" => "N·m",
        "nmm" | "Nmm" => "N·mm",
        "deg" | "°" | "degree" | "degrees" => "°",
        "rad" => "rad",
        "mm" => "mm",
        "m" => "m",
        "s" => "s",
        "A" => "A",
        "V" => "V",
        "hz" | "Hz" => "Hz",
        "pct" => "%",
        _ => "",
    }
}

/// A unit of a signal as reports write it.
pub(super) fn shown_unit(unit: &str) -> &str {
    match unit {
        "degC" => "°C",
        "us" => "µs",
        other => other,
    }
}

/// A column's name without its unit.
pub(super) fn bare(column: &str) -> &str {
    if let Some((name, _)) = bracketed(column) {
        return name;
    }
    match column.rsplit_once('_') {
        Some((name, suffix)) if !name.is_empty() && !unit(suffix).is_empty() => name,
        _ => column,
    }
}

/// The label of an axis: name and unit.
pub(super) fn axis_label(column: &str, unit: &str) -> String {
    if unit.is_empty() { column.to_owned() } else { format!("{} ({unit})", bare(column)) }
}

fn minus(text: &str) -> String {
    text.replace('-', "\u{2212}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_the_requested_digits() {
        assert_eq!(significant(0.123_456, 3), "0.123");
        assert_eq!(significant(0.999_6, 3), "1.00");
        assert_eq!(significant(1234.6, 3), "1235");
        assert_eq!(significant(-2.0e-7, 2), "\u{2212}2.0e\u{2212}7");
        assert_eq!(significant(f64::NAN, 3), NONE);
        assert_eq!(significant(0.0, 3), "0");
        assert_eq!((physical(6.5e-13, 3), physical(0.02, 3)), ("0".to_owned(), "0.0200".to_owned()));
        assert_eq!(fixed(-0.001, 2), "0.00");
        assert_eq!(percent(0.9612), "96.1\u{202f}%");
        assert_eq!(percent_of_range(f64::INFINITY), NONE);
        assert_eq!(count(1_234_567), "1\u{202f}234\u{202f}567");
    }

    #[test]
    fn units_are_read_from_the_end_of_a_columns_name() {
        for (column, unit, label) in [
            ("tension_out_n", "N", "tension_out (N)"),
            ("T_out_Nm", "N·m", "T_out (N·m)"),
            ("q_act_deg", "°", "q_act (°)"),
            ("p_out_rad", "rad", "p_out (rad)"),
            ("stroke_mm", "mm", "stroke (mm)"),
            ("T_in_N_med5", "N", "T_in_N_med5 (N)"),
            ("N", "", "N"),
            ("n_out", "", "n_out"),
            ("force", "", "force"),
            ("", "", ""),
        ] {
            assert_eq!(unit_of(column), unit, "{column}");
            assert_eq!(axis_label(column, unit_of(column)), label, "{column}");
        }
    }
}
