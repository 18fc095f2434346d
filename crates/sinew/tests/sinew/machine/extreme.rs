//! Every field of a machine file huge, empty, of another length or another unit: refused with its line, key
//! and value.

use super::wrong::{EVERY_KEY, Kind, check, error, fields, line_of};

#[test]
fn huge_numbers_are_refused() {
    let mut checked = 0;
    for field in fields().iter().filter(|field| field.kind == Kind::Number) {
        for wrong in ["1e300", "-1e300"] {
            check(field, wrong);
        }
        checked += 1;
    }
    assert!(checked > 150, "{checked}");
}

#[test]
fn empty_texts_and_lists_are_refused() {
    let mut checked = 0;
    for field in fields() {
        match field.kind {
            // A machine without a name is one.
            Kind::Text if line_of(field.value.start) == 2 => continue,
            Kind::Text => check(&field, "\"\""),
            Kind::List => check(&field, "[]"),
            _ => continue,
        }
        checked += 1;
    }
    assert!(checked > 60, "{checked}");
}

#[test]
fn lists_of_numbers_of_another_length_are_refused() {
    let mut checked = 0;
    for field in fields().iter().filter(|field| field.kind == Kind::List) {
        let written = &EVERY_KEY[field.value.clone()];
        let numbers = !written.contains(['"', '{']);
        if numbers {
            let inner = written.trim_matches(['[', ']']);
            check(field, &format!("[{inner}, 0.25]"));
            check(field, "[0.25]");
            checked += 1;
        }
    }
    assert!(checked > 20, "{checked}");
}

#[test]
fn another_unit_in_a_key_is_answered_with_the_right_one() {
    let units = [
        ("_m", "_mm"),
        ("_rad", "_deg"),
        ("_n", "_kn"),
        ("_kg", "_g"),
        ("_s", "_ms"),
        ("_nm", "_nmm"),
        ("_v", "_mv"),
        ("_a", "_ma"),
        ("_ohm", "_mohm"),
        ("_h", "_mh"),
        ("_c", "_k"),
        ("_kg_m2", "_g_cm2"),
        ("_per_s", "_per_min"),
        ("_rad_per_s", "_rpm"),
        ("_m_per_s", "_mm_per_s"),
    ];
    let mut checked = 0;
    for field in fields().iter().filter(|field| !field.name.is_empty()) {
        for (unit, other) in units {
            let Some(stem) = field.key.strip_suffix(unit) else { continue };
            let wrong = format!("{stem}{other}");
            let told = error(&field.name, &wrong);
            assert_eq!(told.line, line_of(field.name.start), "{told}");
            let told = told.to_string();
            assert!(
                told.contains(&format!("`{wrong}`")) && told.contains(&format!("`{}`", field.key)),
                "{told}"
            );
            checked += 1;
        }
    }
    assert!(checked > 80, "{checked}");
}
