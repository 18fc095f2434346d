//! Robot files: what is read is what was written, and what cannot be is refused with its place.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

mod attached;
mod geoms;
mod osim;
mod pinocchio;

use sinew::body::{Parts, PathElement, Robot, TendonPath};
use sinew::description::{Description, DescriptionError, from_mjcf, from_toml, from_urdf, to_mjcf, to_toml};

const MIXED_ROBOT: &str = include_str!("mixed_robot.xml");
const ARM: &str = sinew_models::LM_ARM;

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
    let mut first = Robot::new(parts(MIXED_ROBOT)).unwrap().parts().clone();
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
    let mixed = parts(MIXED_ROBOT);
    assert_eq!(from_toml("mixed_robot.toml", &to_toml(&mixed)).unwrap().parts, mixed);
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
    let text = "<mujoco><default><site euler=\"90 0 0\"/></default><worldbody><site quat=\"1 0 0 \
        0\"/></worldbody></mujoco>";
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
        "<body><inertial pos=\"0 0 0\" mass=\"1\" diaginertia=\"1 1 1\"/>\n<geom type=\"mesh\" \
            mesh=\"a\"/>\n<geom type=\"mesh\" mesh=\"b\"/></body>",
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
    refused(
        &world("<body><joint/>\n<geom type=\"mesh\" mesh=\"a\"/></body>"),
        4,
        &["`mesh`", "no mesh of that name"],
    );
    refused(&world("<body><joint/>\n<geom type=\"box\" mesh=\"a\"/></body>"), 4, &["mesh", "<inertial>"]);
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
        ("\n[[joint]]\nname = \"j\"\nbody = \"b\"\nkind = \"hinge\"", 4, "body is \"b\""),
        (
            "\n[[body]]\nname = \"b\"\n[[joint]]\nname = \"j\"\nbody = \"b\"\nkind = \"hinge\"\naxis = [1, \
                0, 0]\nrange_m = [0, 1]",
            9,
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
    // What only a whole robot has is not passed over.
    for (text, line) in [("name = \"x\"\n", 1), ("\n[[key]]\nname = \"k\"\nq = []\n", 2)] {
        let refused = from_urdf("two.urdf", URDF, Some(("two.toml", text))).unwrap_err();
        assert_eq!((refused.file.as_str(), refused.line), ("two.toml", line), "{refused}");
        assert!(refused.problem.contains("comes from the URDF"), "{refused}");
    }
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
    assert!(
        refused("<mujoco><worldbody><replicate count=\"2.5\"/></worldbody></mujoco>")
            .contains("whole number")
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
    assert!(error(from_toml("a.toml", toml)).starts_with("a.toml:10: joint `j`: range_rad must be"));
    let body = |mass: &str| format!("[[body]]\nname = \"b\"\ninertia_kg_m2 = [1, 1, 9]\nmass_kg = {mass}\n");
    assert!(error(from_toml("a.toml", &body("-1"))).starts_with("a.toml:4: body `b`: mass_kg must be"));
    assert!(error(from_toml("a.toml", &body("1"))).starts_with("a.toml:3: body `b`: inertia_kg_m2 must be"));
    let mut chain = String::from("[[body]]\nname = \"b0\"\n");
    (1..1000).for_each(|k| chain += &format!("[[body]]\nname = \"b{k}\"\nparent = \"b{}\"\n", k - 1));
    assert!(error(from_toml("a.toml", &chain)).starts_with("a.toml:2702: body `b900`: stands on 900 bodies"));
    let mjcf = "<mujoco><worldbody>\n<body>\n<joint name=\"a&#10;b\"/></body></worldbody></mujoco>";
    assert!(error(from_mjcf("a.xml", mjcf, &mut |_| Err(String::new()))).starts_with("a.xml:3: joint `a"));
}

#[test]
fn a_misspelt_attribute_of_a_urdf_is_refused() {
    let text = "<robot name=\"r\">\n<link name=\"a\"/>\n<link name=\"b\"/>\n<joint name=\"j\" \
        type=\"revolute\">\n\
                <parent link=\"a\"/><child link=\"b\"/>\n<limit lowr=\"-1\" upper=\"1\"/></joint></robot>";
    let error = from_urdf("a.urdf", text, None).unwrap_err().to_string();
    assert!(error.starts_with("a.urdf:6: <limit> `lowr`: is no attribute of it"), "{error}");
}

/// What an actuator's law of force says, in every way that MJCF has of saying it.
const LAWS: &str = "<mujoco>
<default><general dynprm=\"0.017\"/><default class=\"strong\"><muscle force=\"812.3\" \
scale=\"150\"/></default></default>
<worldbody><site name=\"a\"/><body><joint name=\"j\"/><geom size=\"1\"/><site name=\"b\" pos=\"1 0 \
0\"/></body></worldbody>
<tendon><spatial name=\"t\"><site site=\"a\"/><site site=\"b\"/></spatial></tendon>
<actuator>
<muscle tendon=\"t\" class=\"strong\" timeconst=\"0.0123 0.0456\" range=\"0.7 1.1\" lengthrange=\"0.1 \
0.9000000000000001\" lmax=\"1.7\"/>
<general tendon=\"t\" gear=\"-0.1 0 0 0 0 0\" gaintype=\"affine\" gainprm=\"0.1 -3e-300 7\" \
biastype=\"affine\" biasprm=\"0.30000000000000004\" dyntype=\"filter\"/>
<position tendon=\"t\" kp=\"31.4\" kv=\"0.7\" ctrlrange=\"-1 2\" forcerange=\"-7 0\"/>
<damper tendon=\"t\" kv=\"2\" ctrlrange=\"0 1\"/>
</actuator></mujoco>";

#[test]
fn laws_of_force_survive_every_format_to_the_letter() {
    let first = parts(LAWS);
    let law = |index: usize, name: &str| first.actuators[index].law.get(name).map(String::as_str);
    assert_eq!(law(0, "force"), Some("812.3"));
    assert_eq!(law(0, "lengthrange"), Some("0.1 0.9000000000000001"));
    assert_eq!(law(1, "gainprm"), Some("0.1 -3e-300 7"));
    assert_eq!(law(1, "dynprm"), Some("0.017"));
    assert_eq!(law(2, "kp"), Some("31.4"));
    let again = from_toml("laws.toml", &to_toml(&parts(&to_mjcf(&first)))).unwrap().parts;
    for (one, other) in first.actuators.iter().zip(&parts(&to_mjcf(&again)).actuators) {
        assert_eq!((one.kind, &one.law, one.gear.to_bits()), (other.kind, &other.law, other.gear.to_bits()));
        assert_eq!((one.control_range, one.force_range), (other.control_range, other.force_range));
    }
    let bad = |law: &str| from_toml("laws.toml", &to_toml(&first).replace("kp = \"31.4\"", law)).unwrap_err();
    assert!(bad("kp = \"nan\"").to_string().contains("`nan`"));
    assert!(bad("kq = \"1\"").to_string().contains("`kq`"));
    refused(&LAWS.replace("31.4", "inf"), 8, &["kp", "inf"]);
}

#[test]
fn copies_stand_where_mujoco_puts_them() {
    // MuJoCo 4.0: names and places of three bodies a twelfth of a turn from each other.
    let copies = "<replicate count=\"3\" sep=\"-\" offset=\".2 0 .1\" euler=\"0 0 30\"><body name=\"r\" \
        pos=\".1 0 0\">\
        <geom size=\"1\"/><replicate count=\"10\"><site name=\"s\"/></replicate></body></replicate>";
    let robot = parts(&world(copies));
    let names: Vec<&str> = robot.bodies.iter().map(|body| body.name.as_str()).collect();
    assert_eq!(names, ["world", "r-0", "r-1", "r-2"]);
    assert_eq!((robot.sites.len(), robot.sites[29].name.as_str()), (30, "s09-2"));
    let expected = [
        [0.1, 0.0, 0.0],
        [0.286_602_540_378_443_9, 0.05, 0.1],
        [0.423_205_080_756_887_8, 0.186_602_540_378_443_9, 0.2],
    ];
    for (body, place) in robot.bodies[1..].iter().zip(expected) {
        assert!(
            body.position.iter().zip(place).all(|(have, want)| (have - want).abs() < 1e-15),
            "{:?}",
            body.position
        );
    }
    let bomb = "<replicate count=\"99999\">".repeat(9) + "<site/>" + &"</replicate>".repeat(9);
    refused(&world(&bomb), 3, &["<replicate>", "`count`", "99999", "100000 elements"]);
}

#[test]
fn what_refers_to_a_copy_is_copied_with_it_in_mujocos_order() {
    let copies = "<site name=\"hub\"/><replicate count=\"3\" sep=\"-\" euler=\"0 0 120\"><body><joint \
        name=\"j\"/><geom name=\"g\" size=\".02\"/><site name=\"tip\" pos=\".1 0 \
        0\"/></body></replicate><body><joint name=\"own\"/><geom size=\".1\"/></body>";
    let text = format!(
        "<mujoco><worldbody>{copies}</worldbody><tendon><spatial name=\"spoke\"><site site=\"hub\"/><geom \
            geom=\"g\" sidesite=\"tip\"/><site site=\"tip\"/></spatial><fixed name=\"sum\"><joint \
            joint=\"j\" coef=\"1\"/></fixed><fixed name=\"own\"><joint joint=\"own\" \
            coef=\"2\"/></fixed></tendon><equality><joint joint1=\"j\" \
            joint2=\"own\"/></equality><actuator><motor name=\"m\" tendon=\"spoke\"/><motor name=\"o\" \
            tendon=\"own\"/></actuator></mujoco>"
    );
    let robot = parts(&text);
    // MuJoCo 4.0: the copies of one suffix stand together, behind what is no copy.
    let names: Vec<&str> = robot.tendons.iter().map(|tendon| tendon.name.as_str()).collect();
    assert_eq!(names, ["own", "spoke-0", "sum-0", "spoke-1", "sum-1", "spoke-2", "sum-2"]);
    let pulled: Vec<(&str, usize)> = robot.actuators.iter().map(|a| (a.name.as_str(), a.tendon)).collect();
    assert_eq!(pulled, [("o", 0), ("m-0", 1), ("m-1", 3), ("m-2", 5)]);
    let followers: Vec<usize> = robot.couplings.iter().map(|coupling| coupling.follower).collect();
    assert_eq!(followers, [0, 1, 2]);
    let robot = Robot::new(robot).unwrap();
    assert_eq!(robot.parts().tendons[3].path, {
        let site = |name: &str| robot.site(name).unwrap();
        let wrap = robot.parts().wraps.iter().position(|wrap| wrap.name == "g-1").unwrap();
        TendonPath::Spatial(vec![
            PathElement::Site(site("hub")),
            PathElement::Wrap { wrap, side: Some(site("tip-1")) },
            PathElement::Site(site("tip-1")),
        ])
    });
    // Tendons of copies count as elements, too.
    let many = "<replicate count=\"20000\"><site name=\"s\"/></replicate>";
    let legs = "<site site=\"s\"/>".repeat(9);
    let bomb =
        format!("<mujoco><worldbody>{many}</worldbody><tendon><spatial>{legs}</spatial></tendon></mujoco>");
    refused(&bomb, 1, &["<replicate>", "100000 elements"]);
}

#[test]
fn a_mesh_in_a_body_that_no_joint_moves_needs_no_mass_and_its_omission_is_told() {
    let palm = |joint: &str| {
        world(&format!(
            "<body>{joint}<geom type=\"mesh\" mesh=\"palm\"/><body><geom type=\"mesh\" \
                mesh=\"palm\"/><body><joint name=\"j\"/>\
             <geom size=\".01\"/></body></body></body>"
        ))
    };
    let read = mjcf(&palm("")).unwrap();
    assert!(read.parts.bodies[1..3].iter().all(|body| body.mass == 0.0) && read.parts.bodies[3].mass > 0.0);
    let told = read.warnings.iter().filter(|warning| warning.what.contains("does not move"));
    assert_eq!(told.count(), 1, "{:?}", read.warnings);
    assert!(mjcf(&palm("<joint name=\"k\"/>")).is_err(), "it moves");
    let scaled = palm("").replacen("<worldbody>", "<compiler settotalmass=\"1\"/><worldbody>", 1);
    assert!(mjcf(&scaled).is_err(), "its mass scales the others");
}

#[test]
fn gravity_that_is_turned_off_pulls_on_nothing() {
    let text =
        "<mujoco><option gravity=\"0 0 -1\"><flag gravity=\"disable\" spring=\"disable\"/></option></mujoco>";
    let read = mjcf(text).unwrap();
    assert_eq!(read.parts.gravity.map(f64::to_bits), [0; 3]);
    assert!(read.warnings[0].to_string().contains("`spring`"), "{:?}", read.warnings);
}

#[test]
fn a_short_list_leaves_the_rest_to_its_class() {
    let text = LAWS.replace("dynprm=\"0.017\"", "gainprm=\"1 2 3 4 5\" dynprm=\"0.017\"");
    let text = text.replace("class=\"strong\"><", "class=\"strong\"><general gainprm=\"9 8\"/><");
    let text = text.replace("<general tendon=\"t\"", "<general tendon=\"t\" class=\"strong\"");
    let read = mjcf(&text).unwrap();
    assert_eq!(read.parts.actuators[1].law["gainprm"], "0.1 -3e-300 7 4 5");
    // A muscle cannot say what a class says to all actuators.
    assert!(
        read.warnings.iter().any(|warning| warning.to_string().contains("dynprm")),
        "{:?}",
        read.warnings
    );
}

#[test]
fn of_a_polynomial_only_the_linear_term_is_read_and_that_is_said() {
    let text = "<mujoco><default><joint damping=\"1 2\"/></default><worldbody><body><joint damping=\"3\"/>\
        <geom size=\"1\"/></body></worldbody></mujoco>";
    let read = mjcf(text).unwrap();
    assert_eq!(read.parts.joints[0].damping.to_bits(), 3.0_f64.to_bits());
    assert!(read.warnings[0].to_string().contains("polynomial"), "{:?}", read.warnings);
    assert!(mjcf(&text.replace("1 2", "1 0")).unwrap().warnings.is_empty());
}

#[test]
fn shells_weigh_what_mujoco_says() {
    // MuJoCo 4.0: surface in m^2 and principal moments per mass.
    for (shape, surface, moments) in [
        ("sphere\" size=\"0.3", 1.130_973_355_292_325_6, [0.06, 0.06, 0.06]),
        ("capsule\" size=\"0.1 0.3", 0.502_654_824_574_366_9, [0.057_916_667, 0.057_916_667, 0.009_166_667]),
        ("cylinder\" size=\"0.1 0.3", 0.439_822_971_502_571, [0.043_214_286, 0.043_214_286, 0.009_285_714]),
        ("box\" size=\"0.1 0.2 0.3", 0.88, [0.061_515_152, 0.047_878_788, 0.027_575_758]),
        (
            "ellipsoid\" size=\"0.1 0.2 0.3",
            0.489_719_333_337_173_1,
            [0.036_909_253, 0.028_727_407, 0.016_545_561],
        ),
    ] {
        let geom = format!("<body><geom type=\"{shape}\" density=\"7\" shellinertia=\"true\"/></body>");
        let body = parts(&world(&geom)).bodies[1].clone();
        assert!((body.mass - 7.0 * surface).abs() < 1e-12, "{shape}: {}", body.mass);
        for (have, want) in body.inertia.iter().zip(moments) {
            assert!((have / body.mass - want).abs() < 1e-8, "{shape}: {:?}", body.inertia);
        }
    }
}

#[test]
fn a_body_that_weighs_only_its_bound_has_its_centre_where_mujoco_puts_it() {
    let text = "<mujoco><compiler boundmass=\"0.1\"/><worldbody><body pos=\"1 2 3\"/></worldbody></mujoco>";
    let center = |text: &str| parts(text).bodies[1].center_of_mass.map(f64::to_bits);
    let there = [1.0_f64, 2.0, 3.0].map(f64::to_bits);
    assert_eq!(center(text), there);
    // Geoms that weigh nothing, or nothing that counts, change nothing about it.
    let geom = "pos=\"1 2 3\"><geom size=\"1\" mass=\"1e-15\" pos=\"7 0 0\"/></body>";
    assert_eq!(center(&text.replace("pos=\"1 2 3\"/>", geom)), there);
    let geom = "pos=\"1 2 3\"><geom size=\"1\" pos=\"7 0 0\"/></body>";
    let inertials = text.replace("boundmass", "inertiafromgeom=\"false\" boundmass");
    assert_eq!(center(&inertials.replace("pos=\"1 2 3\"/>", geom)), there);
}

#[test]
fn what_changes_forces_and_is_not_read_is_said_and_makes_no_machine() {
    let joint = "<joint name=\"j\"/><geom size=\"1\"/>";
    let pull = "<tendon><fixed name=\"m\"><joint joint=\"j\" coef=\"1\"/></fixed></tendon>";
    let body = |attribute: &str| world(&format!("<body {attribute}>{joint}</body><body gravcomp=\"0\"/>"));
    let weld = |active: &str| format!("<equality><weld body1=\"b\" {active}/></equality></mujoco>");
    let whole = body("name=\"b\"").replace("</mujoco>", &format!("{pull}</mujoco>"));
    let machine = |text: &str| {
        let toml = "body = \"b.xml\"";
        let read = sinew::description::machine_from_toml("m.toml", toml, &mut |_| Ok(text.to_string()));
        read.map(|_| ()).map_err(|error| error.to_string())
    };
    machine(&whole).unwrap();
    for (text, word) in [
        (whole.replace("</mujoco>", &weld("")), "<weld>"),
        (whole.replace("<fixed name", "<fixed frictionloss=\"1\" name"), "frictionloss"),
        (whole.replace("<worldbody>", "<option viscosity=\"1\"/><worldbody>"), "viscosity"),
        (whole.replace("<geom size", "<plugin plugin=\"p\"/><geom size"), "<plugin>"),
    ] {
        let warnings = mjcf(&text).unwrap().warnings;
        assert!(warnings.len() == 1 && warnings[0].changes_forces, "{word}: {warnings:?}");
        let refused = machine(&text).unwrap_err();
        assert!(refused.contains(word) && refused.contains("b.xml:"), "{refused}");
    }
    for (text, told) in [
        (whole.replace("</mujoco>", &weld("active=\"false\"")), 0),
        (whole.replace("name=\"b\"", "name=\"b\" mocap=\"true\""), 1),
        (whole.replace("<worldbody>", "<contact/><worldbody>"), 1),
    ] {
        assert_eq!(mjcf(&text).unwrap().warnings.len(), told);
        machine(&text).unwrap();
    }
}

#[test]
fn springs_and_dampers_by_time_constant_and_ratio_are_those_of_mujocos_compiler() {
    let text = "<mujoco><worldbody><body><joint name=\"a\" axis=\"0 1 0\" springdamper=\"0.2 0.7\" \
        stiffness=\"9\"/><geom size=\"0.05\" fromto=\"0 0 0 0.3 0 0\" type=\"capsule\"/>\
        <body pos=\"0.3 0 0\"><joint name=\"b\" axis=\"0 1 0\" springdamper=\"0.1 1\" \
        armature=\"0.01\"/><joint name=\"c\" type=\"slide\" axis=\"0 1 0\" springdamper=\"0 0\" \
        damping=\"3\"/><geom size=\"0.04\" fromto=\"0 0 0 0.2 0.1 0\" type=\"capsule\"/></body></body>\
        </worldbody></mujoco>";
    // jnt_stiffness and dof_damping of MuJoCo 4.0.0.
    let theirs =
        [[10.343324727342246, 2.0272916465590805], [1.953570336773006, 0.39071406735460124], [0.0, 3.0]];
    for (joint, [stiffness, damping]) in parts(text).joints.iter().zip(theirs) {
        assert!((joint.stiffness - stiffness).abs() < 1e-12 * stiffness.max(1.0), "{joint:?}");
        assert!((joint.damping - damping).abs() < 1e-12 * damping.max(1.0), "{joint:?}");
    }
    let refused = mjcf(&text.replace("0.2 0.7", "0.2 0")).unwrap_err().to_string();
    assert!(refused.contains("springdamper") && refused.contains("> 0"), "{refused}");
}

#[test]
fn elements_that_urdf_does_not_know_are_warned_of_once() {
    let text = "<robot name=\"r\">\n<link name=\"a\"><inerta/></link>\n<link \
        name=\"b\"><inerta/><visual><x/></visual></link>\n\
        <joint name=\"j\" type=\"fixed\"><parent link=\"a\"/><child link=\"b\"/><dynamic/></joint></robot>";
    let told: Vec<String> =
        from_urdf("r.urdf", text, None).unwrap().warnings.iter().map(ToString::to_string).collect();
    assert_eq!(told.len(), 2, "{told:?}");
    assert!(told.iter().any(|t| t.contains(":2") && t.contains("<inerta>")), "{told:?}");
    assert!(told.iter().any(|t| t.contains(":4") && t.contains("<dynamic>")), "{told:?}");
}

#[test]
fn a_bad_field_of_a_toml_is_named_by_its_own_line() {
    let text = "[[body]]\nname = \"b\"\nmass_kg = 1\ninertia_kg_m2 = [1, 1]\n[[body]]\nname = \"c\"\n";
    assert_eq!(from_toml("r.toml", text).unwrap_err().line, 4);
    assert_eq!(from_toml("r.toml", "[[body]]\nname = \"b\"\n  parent = \"x\"\n").unwrap_err().line, 3);
    let joint =
        "[[body]]\nname = \"b\"\n[[joint]]\nname = \"j\"\nbody = \"b\"\nkind = \"slide\"\naxis = [1, 0, 0]\n";
    let error =
        from_toml("r.toml", &format!("{joint}armature_kg = 1\nstiffness_nm_per_rad = 1\n")).unwrap_err();
    assert_eq!(
        error.to_string(),
        "r.toml:9: [[joint]] `j`: stiffness_nm_per_rad: its unit does not fit a slide: expected \
            stiffness_n_per_m"
    );
    let coupling = "[[coupling]]\nfollower = \"j\"\nleader = \"k\"\ncoefficients = [0, 1, 0, 0, 0]\n";
    assert_eq!(from_toml("r.toml", &format!("{joint}{coupling}")).unwrap_err().line, 10);
}
