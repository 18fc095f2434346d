//! What only the laws of cables and bodies can refuse: named by muscle or body, with file, line and key.

use super::read;
use sinew::description::{DescriptionError, from_mjcf, machine_from_toml, machine_of};

const LEG: &str = r#"<mujoco><worldbody>
<body name="shank"><joint name="knee" axis="0 1 0" range="0 90"/>
<inertial pos="0 0 -0.2" mass="1" diaginertia="0.01 0.01 0.001"/></body>
</worldbody><tendon>
<fixed name="extensor"><joint joint="knee" coef="0.03"/></fixed>
<fixed name="flexor"><joint joint="knee" coef="-0.03"/></fixed>
</tendon></mujoco>"#;

fn refused(tables: &str) -> DescriptionError {
    let text = format!("body = \"leg.xml\"\n{tables}");
    machine_from_toml("leg.toml", &text, &mut |_| Ok(LEG.to_owned())).expect_err("no law")
}

#[test]
fn a_cable_with_more_friction_than_its_law_can_describe_is_named_with_its_key() {
    for (tables, line, key, muscle) in [
        ("[every_transmission]\nsheath_bend_rad = 25.6\n", 3, "sheath_bend_rad", "extensor"),
        (
            "[every_transmission]\nsheath_bend_rad = 1.0\n[[transmission]]\nmuscle = \"flexor\"\nsheath_bend_rad = 30.0\n",
            6,
            "sheath_bend_rad",
            "flexor",
        ),
        ("[[transmission]]\nmuscle = \"flexor\"\n\ncable = { friction = 3.0 }\n", 5, "cable", "flexor"),
        (
            "[[transmission]]\nmuscle = \"extensor\"\ncable.friction = 3.0\n[task]\nspace = \"joints\"\n",
            4,
            "cable.friction",
            "extensor",
        ),
        (
            "[[transmission]]\nmuscle = \"flexor\"\nsheath_bend_rad = 12.0\nbend_by_joint = { knee = 7.0 }\n",
            5,
            "knee",
            "flexor",
        ),
    ] {
        let error = refused(tables);
        let text = error.to_string();
        assert_eq!((error.file.as_str(), error.line), ("leg.toml", line), "{tables}: {text}");
        assert!(text.contains(&format!("`{muscle}`")) && text.contains(key), "{tables}: {text}");
        assert!(!text.contains("use more cells") && !text.contains("muscle number"), "{text}");
    }
}

#[test]
fn every_friction_that_is_read_has_a_law_for_all_that_looks_at_it() {
    for step in 0..60 {
        let bend = 0.5 * f64::from(step);
        let text = format!("body = \"leg.xml\"\n[every_transmission]\nsheath_bend_rad = {bend}\n");
        let Ok(read) = machine_from_toml("leg.toml", &text, &mut |_| Ok(LEG.to_owned())) else {
            assert!(bend > 15.0, "{bend} rad");
            continue;
        };
        for cells in [8, 12, 24] {
            assert_eq!(read.machine.laws(cells).unwrap().len(), 2, "{bend} rad, {cells} cells");
        }
    }
}

#[test]
fn a_body_that_is_too_far_away_for_any_length_is_named() {
    for far in ["1e308", "-1e308", "1e200", "3e12"] {
        let text = LEG.replace("<body name=\"shank\">", &format!("<body name=\"shank\" pos=\"0 0 {far}\">"));
        let read = from_mjcf("leg.xml", &text, &mut |_| Err("none".to_owned())).and_then(machine_of);
        let error = read.expect_err("no machine");
        assert_eq!((error.file.as_str(), error.line), ("leg.xml", 2), "{error}");
        let text = error.to_string();
        assert!(
            text.contains("body `shank`") && text.contains("position") && !text.contains("NaN"),
            "{text}"
        );
    }
}

#[test]
fn a_machine_knows_where_its_parts_are_written_after_it_was_read() {
    let described = read(super::wrong::EVERY_KEY).unwrap();
    let name = described.machine.robot.parts().tendons[1].name.clone();
    let refused = sinew::Error::PartOutOfDomain {
        kind: "muscle",
        index: 1,
        field: "sheath_length",
        expected: "shorter",
        got: 7.0,
    };
    let error = described.places.error(refused);
    let line = super::wrong::EVERY_KEY.lines().nth(error.line - 1).unwrap();
    assert!(error.to_string().contains(&name) && error.line > 1, "{error}");
    assert!(line.contains("sheath") || line.starts_with("[["), "{line}");
}
