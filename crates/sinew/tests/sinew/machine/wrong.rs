//! Every field of a machine file wrong in turn: one error each, with its line, key, value and the nearest
//! name.

use super::read;
use proptest::prelude::*;
use sinew::description::DescriptionError;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

pub(crate) const EVERY_KEY: &str = include_str!("every_key.toml");

/// A key of the file: its name, where name and value stand, and what the value is.
#[derive(Debug, Clone)]
pub(crate) struct Field {
    pub(crate) key: String,
    pub(crate) name: Range<usize>,
    pub(crate) value: Range<usize>,
    pub(crate) kind: Kind,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Number,
    Text,
    Flag,
    List,
    Table,
}

/// All fields, and the single entries of lists.
pub(crate) fn fields() -> Vec<Field> {
    let table = DeTable::parse(EVERY_KEY).unwrap();
    let mut fields = Vec::new();
    collect(table.get_ref(), &mut fields);
    assert!(fields.len() > 180, "{}", fields.len());
    fields
}

fn kind(value: &DeValue<'_>) -> Kind {
    match value {
        DeValue::Float(_) | DeValue::Integer(_) => Kind::Number,
        DeValue::String(_) => Kind::Text,
        DeValue::Boolean(_) => Kind::Flag,
        DeValue::Array(_) => Kind::List,
        _ => Kind::Table,
    }
}

fn collect(table: &DeTable<'_>, fields: &mut Vec<Field>) {
    for (key, value) in table {
        // A table under a header has no value of its own that could be replaced.
        let header = is_header(value);
        let field = |value: &Spanned<DeValue<'_>>| Field {
            key: key.get_ref().to_string(),
            name: key.span(),
            value: value.span(),
            kind: kind(value.get_ref()),
        };
        if !header {
            fields.push(field(value));
        }
        match value.get_ref() {
            DeValue::Table(inner) => collect(inner, fields),
            DeValue::Array(array) => {
                for part in array.iter() {
                    match part.get_ref() {
                        DeValue::Table(inner) => collect(inner, fields),
                        _ => fields.push(Field { name: 0..0, ..field(part) }),
                    }
                }
            }
            _ => {}
        }
    }
}

fn is_header(value: &Spanned<DeValue<'_>>) -> bool {
    let first = match value.get_ref() {
        DeValue::Array(array) => array.iter().next().map(Spanned::span),
        DeValue::Table(_) => Some(value.span()),
        _ => None,
    };
    let written = first.clone().and_then(|span| EVERY_KEY.get(span.start..)).unwrap_or("");
    matches!(value.get_ref(), DeValue::Array(_) | DeValue::Table(_)) && written.starts_with('[') && {
        let line = EVERY_KEY[..first.unwrap().start].rfind('\n').map_or(0, |end| end + 1);
        EVERY_KEY[line..].starts_with('[')
    }
}

pub(crate) fn replaced(at: &Range<usize>, by: &str) -> String {
    format!("{}{by}{}", &EVERY_KEY[..at.start], &EVERY_KEY[at.end..])
}

pub(crate) fn line_of(at: usize) -> usize {
    EVERY_KEY[..at].matches('\n').count() + 1
}

/// The error of the file with something replaced.
pub(crate) fn error(at: &Range<usize>, by: &str) -> DescriptionError {
    match read(&replaced(at, by)) {
        Err(error) => error,
        Ok(_) => panic!("line {}: `{}` may be {by}", line_of(at.start), &EVERY_KEY[at.clone()]),
    }
}

/// The error stands on the line of the value, and names key and value.
pub(crate) fn check(field: &Field, by: &str) {
    let error = error(&field.value, by);
    let told = error.to_string();
    assert_eq!(error.line, line_of(field.value.start), "{told}");
    for part in [field.key.as_str(), by.trim_matches('"')] {
        assert!(told.contains(part), "`{part}` is not in: {told}");
    }
    assert!(!told.contains('\n') && told.starts_with("machine.toml:"), "{told}");
}

#[test]
fn the_file_of_every_key_is_a_machine() {
    let read = read(EVERY_KEY).unwrap();
    assert!(read.warnings.is_empty(), "{:?}", read.warnings);
    let machine = read.machine;
    assert_eq!((machine.muscles.len(), machine.start.as_slice()), (3, &[0.2, 0.4, 0.01][..]));
    assert_eq!(machine.devices.len(), 5);
    assert!(machine.encoders[1].is_none() && machine.muscles[0].cable.weakening.is_some());
}

#[test]
fn a_value_of_another_type_is_refused_with_its_key_and_line() {
    for field in fields() {
        let wrong = match field.kind {
            Kind::Number | Kind::List | Kind::Flag => "\"much\"",
            Kind::Text | Kind::Table => "17.25",
        };
        check(&field, wrong);
        if field.kind != Kind::Flag {
            check(&field, "true");
        }
        check(&field, "1979-05-27");
    }
}

#[test]
fn numbers_that_are_not_finite_are_refused() {
    for field in fields().iter().filter(|field| field.kind == Kind::Number) {
        for wrong in ["nan", "-inf", "inf", "1e999"] {
            check(field, wrong);
        }
    }
}

/// Keys whose numbers may have any sign and size.
const ANY: [&str; 17] = [
    "gravity_m_per_s2",
    "center_of_mass_m",
    "position_m",
    "anchor_m",
    "axis",
    "orientation_wxyz",
    "reference_rad",
    "spring_reference_rad",
    "coefficient",
    "slack_lengths_m",
    // The lower limit; `range_rad` of a travel is held against the body's elsewhere.
    "range_rad",
    "range_m",
    "offset_n",
    "counts_per_turn",
    "offset_rad",
    "scale",
    "offset",
];

#[test]
fn numbers_out_of_their_domain_are_refused() {
    let free = |field: &Field| {
        let written = &EVERY_KEY[..field.value.start];
        let table = written.rfind("\n[").map_or("", |at| &written[at..]);
        ANY.contains(&field.key.as_str())
            || field.key == "center_m"
            || ["rest", "swing"]
                .iter()
                .any(|of| table.contains(&format!("\n{of} = ")) && field.value.len() < 4)
    };
    let mut checked = 0;
    for field in fields().iter().filter(|field| field.kind == Kind::Number && !free(field)) {
        check(field, "-123456.5");
        checked += 1;
    }
    assert!(checked > 100, "{checked}");
}

#[test]
fn a_misspelt_key_is_answered_with_the_right_one() {
    for field in fields().iter().filter(|field| !field.name.is_empty()) {
        let wrong = format!("{}x", &EVERY_KEY[field.name.clone()]);
        let error = error(&field.name, &wrong);
        let told = error.to_string();
        assert_eq!(error.line, line_of(field.name.start), "{told}");
        assert!(told.contains(&format!("`{wrong}`")), "{told}");
        assert!(told.contains(&format!("expected `{}`", field.key)), "{told}");
    }
}

#[test]
fn an_unknown_name_is_answered_with_the_nearest_one() {
    // Names that others refer to, and words of which nothing else is known.
    let mut checked = 0;
    for field in fields().iter().filter(|field| field.kind == Kind::Text && field.key != "name") {
        let name = EVERY_KEY[field.value.clone()].trim_matches('"');
        let wrong = format!("\"{name}x\"");
        let error = error(&field.value, &wrong);
        let told = error.to_string();
        assert_eq!(error.line, line_of(field.value.start), "{told}");
        assert!(told.contains(&format!("{name}x")) && told.contains(&format!("`{name}`")), "{told}");
        checked += 1;
    }
    assert!(checked > 25, "{checked}");
}

#[test]
fn what_is_missing_twice_or_contradictory_is_refused() {
    let wrong = |from: &str, to: &str, line: &str, parts: &[&str]| {
        assert!(EVERY_KEY.contains(from), "{from}");
        let text = EVERY_KEY.replacen(from, to, 1);
        let told = read(&text).unwrap_err();
        let written = text.lines().nth(told.line - 1).unwrap();
        assert_eq!(written, line, "{told}");
        parts.iter().for_each(|part| assert!(told.to_string().contains(part), "`{part}`: {told}"));
    };
    wrong("rise = 0.2\n", "", "[transmission.cable.weakening]", &["rise is missing"]);
    wrong(
        "muscle = \"flexor\"",
        "muscle = \"extensor2\"",
        "muscle = \"extensor2\"",
        &["muscle", "`extensor`"],
    );
    wrong("ratio = 66", "ratio = 65", "ratio = 65", &["65", "51, 66, 79", "maxon_gp32c_3"]);
    wrong("ratio = 66\n", "", "[[drive]]", &["ratio is missing", "by_name"]);
    wrong("resistance_ohm = 0.4\n", "", "[drive.motor]", &["resistance_ohm is missing"]);
    wrong(
        "peak_current_a = 12.0",
        "peak_current_a = 3.0",
        "peak_current_a = 3.0",
        &["3", ">= the continuous"],
    );
    wrong("range_rad = [0.1, 1.9]", "range_m = [0.1, 1.9]", "range_m = [0.1, 1.9]", &["unit", "range_rad"]);
    wrong("range_rad = [0.1, 1.9]", "range_rad = [0.1, 2.5]", "range_rad = [0.1, 2.5]", &["2.5", "0 to 2"]);
    wrong("none = true", "resolution_m = 1e-5", "resolution_m = 1e-5", &["unit", "resolution_rad"]);
    wrong(
        "tension_limits_n = [10.0, 200.0]",
        "tension_limits_n = [10.0, 10.0]",
        "tension_limits_n = [10.0, 10.0]",
        &["rise"],
    );
    wrong("space = \"endpoint\"", "space = \"joints\"", "endpoint = \"endpoint\"", &["expected none"]);
    wrong(
        "muscle = \"pusher\"\n",
        "muscle = \"extensor\"\n",
        "muscle = \"extensor\"",
        &["extensor", "`drive of the extensor` is its drive"],
    );
    wrong(
        "joint = \"shoulder\"\nscale",
        "joint = \"shoulder\"\nmuscle = \"flexor\"\nscale",
        "joint = \"shoulder\"",
        &["expected one of both"],
    );
    wrong("counts_per_turn = -131072", "counts_per_turn = 0", "counts_per_turn = 0", &["other than 0"]);
    wrong("muscle = \"flexor\"\nmode", "mode", "mode = \"torque\"", &["no drive", "`muscle`"]);
    wrong("name = \"by_numbers\"", "name = \"by_name\"", "name = \"by_name\"", &["its own"]);
    wrong("name = \"loop\"", "name = \"tour\"", "name = \"tour\"", &["tour"]);
    wrong(
        "start = { shoulder = 0.2",
        "start = { shoulder = 1.2",
        "start = { shoulder = 1.2, elbow = 0.4, slider = 0.01 }",
        &["shoulder", "1.2", "-1 to 1"],
    );
}

#[test]
fn a_key_is_read_under_its_former_name_but_not_under_both() {
    let [now, former] = [
        ["max_tension_n", "min_tension_n", "backlash_gain"],
        ["most_tension_n", "least_tension_n", "pre_travel_gain"],
    ];
    let text =
        now.iter().zip(former).fold(EVERY_KEY.to_owned(), |text, (now, former)| text.replace(now, former));
    assert_eq!(read(&text).unwrap().machine, read(EVERY_KEY).unwrap().machine);
    let both = EVERY_KEY.replace("max_tension_n = 500.0", "max_tension_n = 500.0\nmost_tension_n = 400.0");
    let error = read(&both).unwrap_err();
    assert!(error.problem.contains("`most_tension_n` is the former name of `max_tension_n`"), "{error}");
    let line = both.lines().position(|line| line.starts_with("most_tension_n")).unwrap() + 1;
    assert_eq!(error.line, line);
}

#[test]
fn a_drive_that_no_muscle_has_is_told() {
    let text = EVERY_KEY.replace("drive = \"by_numbers\"", "drive = \"by_name\"");
    let warnings = read(&text).unwrap().warnings;
    assert_eq!(warnings.len(), 1);
    assert!(warnings[0].to_string().contains("by_numbers"), "{}", warnings[0]);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_cut_or_damaged_file_is_read_or_refused_on_one_of_its_lines(
        at in 0..EVERY_KEY.len(), width in 0_usize..40, by in "[\\PC\n]{0,8}",
    ) {
        let end = (at + width).min(EVERY_KEY.len());
        if let Err(error) = read(&replaced(&(at..end), &by)) {
            prop_assert!(error.line >= 1 && error.line <= replaced(&(at..end), &by).lines().count() + 1, "{}", error);
        }
    }
}

#[test]
fn without_a_bus_its_keys_are_left_out_and_those_of_roles_are_not() {
    let read = |text: &str| {
        sinew::description::machine_from_toml("machine.toml", text, &mut |_| Err("no other file".into()))
    };
    let with_bus = EVERY_KEY.replacen("[[device]]", "[[device]]\nvendor = \"any\"", 1);
    assert_eq!(read(&with_bus).unwrap().machine, self::read(EVERY_KEY).unwrap().machine);
    assert!(self::read(&with_bus).is_err(), "a bus without such a key refuses it");
    assert!(read(&EVERY_KEY.replace("mode = \"torque\"", "mode = \"talk\"")).is_err());
}
