//! Robot files: what is read is what was written, and what cannot be is refused with its place.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

mod pinocchio;

use sinew::body::{Parts, Robot};
use sinew::description::{Description, DescriptionError, from_mjcf, from_toml, from_urdf, to_mjcf, to_toml};

const ZOO: &str = include_str!("zoo.xml");
const ARM: &str = include_str!("../../../../models/lm_arm.toml");

fn mjcf(text: &str) -> Result<Description, DescriptionError> {
    from_mjcf("robot.xml", text, &mut |name| match name {
        "inner.xml" => Ok("<mujoco><worldbody><body name=\"inner\"/></worldbody></mujoco>".into()),
        "circle.xml" => Ok("<mujoco><include file=\"circle.xml\"/></mujoco>".into()),
        _ => Err("not here".into()),
    })
}

fn parts(text: &str) -> Parts {
    mjcf(text).unwrap().parts
}

/// The file is refused on this line, for a reason that has these words in it.
#[track_caller]
fn refused(text: &str, line: usize, words: &[&str]) {
    let error = mjcf(text).unwrap_err();
    assert_eq!((error.file.as_str(), error.line), ("robot.xml", line), "{error}");
    let told = error.to_string();
    words.iter().for_each(|word| assert!(told.contains(word), "`{word}` is not in: {told}"));
}

fn world(text: &str) -> String {
    format!("<mujoco>\n<worldbody>\n{text}\n</worldbody>\n</mujoco>")
}

#[test]
fn mjcf_written_and_read_again_is_the_same_to_the_bit() {
    let mut first = Robot::new(parts(ZOO)).unwrap().parts().clone();
    let again = parts(&to_mjcf(&first));
    // Surfaces are listed as cables meet them; names are kept, places in the list need not be.
    first.wraps.sort_by(|a, b| a.name.cmp(&b.name));
    let mut wraps = again.wraps.clone();
    wraps.sort_by(|a, b| a.name.cmp(&b.name));
    assert_eq!(first.wraps, wraps);
    assert_eq!((first.bodies, first.joints, first.sites), (again.bodies, again.joints, again.sites));
    assert_eq!(
        (first.tendons, first.couplings, first.actuators, first.keys),
        (again.tendons, again.couplings, again.actuators, again.keys)
    );
}

#[test]
fn toml_written_and_read_again_is_the_same_to_the_bit() {
    let first = from_toml("arm.toml", ARM).unwrap().parts;
    assert_eq!(from_toml("arm.toml", &to_toml(&first)).unwrap().parts, first);
    let zoo = parts(ZOO);
    assert_eq!(from_toml("zoo.toml", &to_toml(&zoo)).unwrap().parts, zoo);
}

#[test]
fn the_arm_has_seven_joints_and_fifteen_muscles_with_sheaths() {
    let robot = Robot::new(from_toml("arm.toml", ARM).unwrap().parts).unwrap();
    assert_eq!((robot.nv(), robot.parts().tendons.len(), robot.parts().keys.len()), (7, 15, 2));
    assert!(robot.parts().tendons.iter().all(|muscle| muscle.sheath.is_some()));
    assert!((robot.moving_mass() - 2.2).abs() < 1e-12);
}

#[test]
fn an_own_orientation_replaces_another_form_of_its_class() {
    let text = "<mujoco><default><site euler=\"90 0 0\"/></default><worldbody><site quat=\"1 0 0 0\"/></worldbody></mujoco>";
    assert_eq!(
        parts(text).sites[0].orientation.map(f64::to_bits),
        [1.0_f64, 0.0, 0.0, 0.0].map(f64::to_bits)
    );
}

#[test]
fn an_include_stands_for_what_is_in_the_file() {
    let robot = parts("<mujoco><include file=\"inner.xml\"/></mujoco>");
    assert_eq!(robot.bodies[1].name, "inner");
}

#[test]
fn what_is_passed_over_is_said_once_with_its_line() {
    let text = world(
        "<body><inertial pos=\"0 0 0\" mass=\"1\" diaginertia=\"1 1 1\"/>\n<geom type=\"mesh\" mesh=\"a\"/>\n<geom type=\"mesh\" mesh=\"b\"/></body>",
    );
    let warnings = mjcf(&text).unwrap().warnings;
    assert_eq!(warnings.len(), 1);
    assert_eq!(warnings[0].line, 4);
}

#[test]
fn bad_mjcf_is_refused_with_its_line_and_element() {
    refused("<mujoco>\n<worldbody>", 2, &["well-formed"]);
    refused(&world("<geom class=\"none\" size=\"1\"/>"), 3, &["<geom>", "`class`", "none"]);
    refused("<mujoco>\n<include file=\"gone.xml\"/></mujoco>", 2, &["gone.xml", "not here"]);
    refused(&world("<body>\n<joint axis=\"0 0 0\"/></body>"), 4, &["<joint>", "`axis`"]);
    refused(
        &world("<body>\n<inertial pos=\"0 0 0\" mass=\"-1\"/></body>"),
        4,
        &["<inertial>", "`mass`", "-1"],
    );
    refused(
        &world("<body>\n<inertial pos=\"0 0 0\" mass=\"1\" diaginertia=\"1 1 3\"/></body>"),
        4,
        &["sum of the others"],
    );
    refused(&world("<body>\n<joint range=\"2 1\"/></body>"), 4, &["`range`", "2 1"]);
    refused(&world("<site name=\"a\"/>\n<site name=\"a\"/>"), 4, &["taken already"]);
    refused(&world("<body pos=\"0 nan 0\"/>"), 3, &["`pos`", "nan"]);
    refused(&world("<body>\n<geom type=\"mesh\" mesh=\"a\"/></body>"), 4, &["mesh", "<inertial>"]);
    refused("\n<!DOCTYPE a [<!ENTITY b \"c\">]><mujoco model=\"&b;\"/>", 2, &["document type"]);
    refused(&world(&("<body>".repeat(10_000) + &"</body>".repeat(10_000))), 3, &["1000"]);
    refused(
        "<mujoco><worldbody/>\n<tendon><spatial>\n<site site=\"x\"/></spatial></tendon></mujoco>",
        3,
        &["`site`", "`x`"],
    );
    let circle = mjcf("<mujoco><include file=\"circle.xml\"/></mujoco>").unwrap_err();
    assert_eq!(circle.file, "circle.xml");
}

#[test]
fn bad_toml_is_refused_with_its_line() {
    for (text, line, word) in [
        ("a = [", 1, "array"),
        ("[[body]]\nname = \"b\"\nmass_g = 3", 3, "mass_g"),
        ("[[body]]\nname = \"b\"\nmass_kg = nan", 3, "finite"),
        ("\n[[joint]]\nname = \"j\"\nbody = \"b\"\nkind = \"hinge\"", 2, "`b`"),
        (
            "\n[[body]]\nname = \"b\"\n[[joint]]\nname = \"j\"\nbody = \"b\"\nkind = \"hinge\"\naxis = [1, 0, 0]\nrange_m = [0, 1]",
            4,
            "unit",
        ),
    ] {
        let error = from_toml("robot.toml", text).unwrap_err();
        assert_eq!(error.line, line, "{error}");
        assert!(error.to_string().contains(word), "{error}");
    }
}

const URDF: &str = r#"<robot name="two"><link name="base"/><link name="a"><inertial><origin xyz="0 0 1" rpy="0.1 0.2 0.3"/>
<mass value="2"/><inertia ixx="1" iyy="2" izz="2.5" ixy="0" ixz="0" iyz="0"/></inertial></link><link name="b"/>
<joint name="j" type="revolute"><parent link="base"/><child link="a"/><axis xyz="0 0 2"/><limit lower="-1" upper="1"/></joint>
<joint name="k" type="continuous"><parent link="a"/><child link="b"/><mimic joint="j" multiplier="-2" offset="0.5"/></joint></robot>"#;

#[test]
fn urdf_brings_joints_and_couplings_and_a_toml_its_muscles() {
    let muscles = "[[site]]\nname = \"o\"\nbody = \"base\"\n[[site]]\nname = \"i\"\nbody = \"a\"\nposition_m = [0.1, 0, 0]\n\
                   [[muscle]]\nname = \"m\"\npath = [{ site = \"o\" }, { site = \"i\" }]\n";
    let parts = from_urdf("two.urdf", URDF, Some(("two.toml", muscles))).unwrap().parts;
    assert_eq!(parts.joints[0].axis.map(f64::to_bits), [0.0, 0.0, 1.0].map(f64::to_bits));
    assert_eq!(parts.couplings[0].coefficients[..2], [0.5, -2.0]);
    let trace: f64 = parts.bodies[2].inertia[..3].iter().sum();
    assert!((trace - 5.5).abs() < 1e-12);
    Robot::new(parts).unwrap();
}

#[test]
fn bad_urdf_is_refused_with_its_line() {
    for (from, to, word) in [
        ("<limit lower=\"-1\" upper=\"1\"/>", "", "<limit>"),
        ("name=\"b\"/>", "name=\"a\"/>", "taken"),
        ("lower=\"-1\"", "lower=\"3\"", "lower"),
        ("ixx=\"1\"", "ixx=\"9\"", "sum of the others"),
        ("joint=\"j\"", "joint=\"gone\"", "gone"),
        ("type=\"continuous\"", "type=\"planar\"", "planar"),
    ] {
        let error = from_urdf("two.urdf", &URDF.replace(from, to), None).unwrap_err();
        assert!(error.to_string().contains(word), "{error}");
    }
}

#[test]
fn what_mujoco_does_not_know_is_refused_where_it_stands() {
    let refused = |text: &str| {
        from_mjcf("arm.xml", text, &mut |_| Err("none".to_string())).expect_err("misspelt").to_string()
    };
    assert_eq!(
        refused(
            "<mujoco>\n<worldbody>\n<body>\n<joint name=\"j\" stifness=\"1\"/></body></worldbody></mujoco>"
        ),
        "arm.xml:4: <joint name=\"j\"> `stifness`: is no attribute of it: expected `stiffness`?"
    );
    assert_eq!(
        refused("<mujoco>\n<worldbody>\n<body>\n<jiont name=\"j\"/></body></worldbody></mujoco>"),
        "arm.xml:4: <jiont name=\"j\">: is no element of <body>: expected `joint`?"
    );
    assert_eq!(
        refused("<mujoco>\n<tendons/></mujoco>"),
        "arm.xml:2: <tendons>: is no element of <mujoco>: expected `tendon`?"
    );
    // Known there, but not to this import.
    assert!(
        refused("<mujoco><worldbody><replicate count=\"2\"/></worldbody></mujoco>").contains("written out")
    );
}

#[test]
fn names_that_are_made_up_are_free() {
    let text = "<mujoco><worldbody><body name=\"body_2\"><body/></body></worldbody></mujoco>";
    let read = from_mjcf("a.xml", text, &mut |_| Err("none".to_string())).unwrap();
    let again = from_toml("a.toml", &to_toml(&read.parts)).unwrap();
    assert_eq!(again.parts.bodies.len(), 3);
    let again = from_mjcf("b.xml", &to_mjcf(&read.parts), &mut |_| Err("none".to_string())).unwrap();
    assert_eq!(again.parts.bodies.len(), 3);
}

#[test]
fn a_name_that_not_every_file_can_hold_is_refused() {
    let read = from_toml("a.toml", "name = \"a\\uFFFF\"").unwrap();
    assert!(Robot::new(read.parts).is_err());
}

#[test]
fn what_is_no_robot_is_refused_with_file_and_line() {
    let error = |read: Result<Description, DescriptionError>| read.unwrap().robot().unwrap_err().to_string();
    let toml = "name = \"a\"\n\n[[body]]\nname = \"b\"\n[[joint]]\nname = \"j\"\nbody = \"b\"\nkind = \"hinge\"\n\
                axis = [0, 0, 1]\nrange_rad = [1.0, -1.0]\n";
    assert!(error(from_toml("a.toml", toml)).starts_with("a.toml:5: joint `j`: "));
    let mjcf = "<mujoco><worldbody>\n<body>\n<joint name=\"a&#10;b\"/></body></worldbody></mujoco>";
    assert!(error(from_mjcf("a.xml", mjcf, &mut |_| Err(String::new()))).starts_with("a.xml:3: joint `a"));
}

#[test]
fn a_misspelt_attribute_of_a_urdf_is_refused() {
    let text = "<robot name=\"r\">\n<link name=\"a\"/>\n<link name=\"b\"/>\n<joint name=\"j\" type=\"revolute\">\n\
                <parent link=\"a\"/><child link=\"b\"/>\n<limit lowr=\"-1\" upper=\"1\"/></joint></robot>";
    let error = from_urdf("a.urdf", text, None).unwrap_err().to_string();
    assert!(error.starts_with("a.urdf:6: <limit> `lowr`: is no attribute of it"), "{error}");
}
