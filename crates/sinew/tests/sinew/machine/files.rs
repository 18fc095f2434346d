//! Reading.

use super::model;
use sinew::body::Robot;
use sinew::description::machine::{Value, ValueSource};
use sinew::description::{
    DescriptionError, MachineDescription, from_mjcf, machine_from_toml, machine_of, robot_from_toml, to_toml,
};
use sinew::machine::{Machine, NamedPath, Task};
use sinew::predictor::{
    CableColumns, CableModel, Estimator, Input, InputLimits, MemoryLaw, Model, ObservedCable, Provenance,
    Role,
};
use sinew::trajectory::{EndPointPath, Loop, Redundancy};
use sinew::transmission::cable::CableParameters;
use sinew::transmission::{BasisTerm, Branch, ClampCell};

#[test]
fn the_arm_is_its_body_with_a_preferred_pose_and_two_paths() {
    let read = model("lm_arm");
    let robot: Robot = read.machine.robot.clone();
    let named = |name: &str, shape| NamedPath {
        name: name.into(),
        path: EndPointPath::Loop { shape, center: [0.66, 0.10, -0.15], amplitude: 0.15 },
    };
    let expected = Machine {
        redundancy: Redundancy {
            rest: [15.0_f64, 20.0, 10.0, 85.0, 0.0, 0.0, 0.0].map(f64::to_radians).to_vec(),
            swing: [0.0_f64, 0.0, 0.0, 0.0, 25.0, 0.0, 0.0].map(f64::to_radians).to_vec(),
            weight: vec![1.0, 1.0, 0.8, 1.0, 1.0, 0.5, 3.0],
        },
        paths: vec![named("sine", Loop::Sine), named("saddle", Loop::Saddle)],
        ..Machine::from_robot(&robot).unwrap()
    };
    assert_eq!(read.machine, expected);
    assert!(matches!(read.machine.task, Task::EndPoint { axes: [true, true, true], .. }));
    let sheath = read.settings.iter().find(|s| s.table.contains("`triceps`") && s.key == "sheath_length_m");
    assert_eq!(sheath.map(|s| (&s.value, s.source)), Some((&Value::Number(0.91), ValueSource::Body)));
    assert!(read.settings.iter().any(|s| s.table == "[control]" && s.source == ValueSource::Default));
}

const LEG: &str = r#"<mujoco model="leg"><worldbody><body name="shank">
<joint name="knee" axis="0 1 0" range="0 90"/><inertial pos="0 0 -0.2" mass="1" diaginertia="0.01 0.01 0.001"/>
<site name="foot" pos="0 0 -0.4"/></body></worldbody><tendon>
<fixed name="extensor"><joint joint="knee" coef="0.03"/></fixed>
<fixed name="flexor"><joint joint="knee" coef="-0.03"/></fixed>
</tendon><keyframe><key name="bent" qpos="0.7"/></keyframe></mujoco>"#;

const URDF: &str = r#"<robot name="leg"><link name="world"/><link name="shank"><inertial><origin xyz="0 0 -0.2"/>
<mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="knee" type="revolute"><parent link="world"/><child link="shank"/><axis xyz="0 1 0"/>
<limit lower="0" upper="1.57" effort="1" velocity="1"/></joint></robot>"#;

const MUSCLES: &str = r#"
[[muscle]]
name = "extensor"
joints = [{ joint = "knee", coefficient = 0.03 }]
[[muscle]]
name = "flexor"
joints = [{ joint = "knee", coefficient = -0.03 }]
sheath = { length_m = 0.9, bend_rad = 2.0 }
"#;

/// A machine whose other files are these.
fn with_files(text: &str) -> Result<MachineDescription, DescriptionError> {
    machine_from_toml("machines/leg.toml", text, &mut |file| match (file.path, file.included_by) {
        ("leg.xml", None) => Ok(LEG.to_string()),
        ("parts/outer.xml", None) => {
            Ok("<mujoco model=\"leg\">\n<include file=\"inner.xml\"/>\n</mujoco>".to_string())
        }
        ("inner.xml", Some("parts/outer.xml")) => Ok(LEG.to_string()),
        ("leg.urdf", None) => Ok(URDF.to_string()),
        ("leg.muscles.toml", None) => Ok(MUSCLES.to_string()),
        ("leg.toml", None) => {
            Ok(to_toml(&from_mjcf("leg.xml", LEG, &mut |_| Err(String::new())).unwrap().parts))
        }
        ("cable.json", None) => Ok(cable_model().to_json().unwrap()),
        ("other.json", None) => {
            let mut model = cable_model();
            model.estimator.law.cable = None;
            model.estimator.law.cell = Some(ClampCell {
                basis: vec![BasisTerm::One],
                low: vec![0.0],
                high: vec![1.0],
                elastic: vec![],
                kappa: vec![],
                branches: vec![Branch { width: 1.0, fraction: 1.0 }],
                start: 0.5,
            });
            Ok(model.to_json().unwrap())
        }
        (path, _) => Err(format!("{path} is not here")),
    })
}

/// An identified model: a bench's cable with other friction.
fn cable_model() -> Model {
    let bench = CableModel::bench();
    let model = CableModel { parameters: CableParameters { friction: 0.2, ..bench.parameters }, ..bench };
    let columns = CableColumns {
        tension: 0,
        motor: 1,
        anchor: 2,
        tension_scale: 1.0,
        motor_scale: 1.0,
        anchor_scale: 1.0,
    };
    let inputs = [("tension_in_n", Role::Effort), ("motor_m", Role::Motion), ("anchor_m", Role::Anchor)];
    let limits = InputLimits { low: -1e3, high: 1e3, jump: 1e3, typical: 1.0 };
    let law = MemoryLaw {
        signals: vec![],
        cell: None,
        cable: Some(ObservedCable { columns, model }),
        axis: None,
        features: vec![],
    };
    Model {
        far: "tension_out_n".into(),
        inputs: inputs.map(|(column, role)| Input { column: column.into(), role }).to_vec(),
        time: None,
        trial: None,
        guards: vec![limits; 3],
        gap_s: 0.1,
        estimator: Estimator { sigma0: 1.0, ..Estimator::of(law) },
        band_factor: 1.0,
        specimen: None,
        offset: None,
        outside: None,
        units: std::collections::BTreeMap::new(),
        provenance: Provenance {
            member: "cable".into(),
            description: "a test".into(),
            program: "test".into(),
            seed: 1,
            logs: vec![],
            samples: 1,
            rmse_unseen: 1.0,
            far_range: 1.0,
        },
    }
}

#[test]
fn a_body_of_every_format_is_read_by_reference() {
    for text in [
        "body = \"leg.xml\"",
        "body = \"parts/outer.xml\"",
        "body = \"leg.urdf\"\nmuscles = \"leg.muscles.toml\"",
        "body = \"leg.toml\"\nname = \"other\"",
    ] {
        let machine = with_files(text).unwrap_or_else(|error| panic!("{text}: {error}")).machine;
        let parts = machine.robot.parts();
        assert_eq!((parts.tendons.len(), machine.encoders.len()), (2, 1), "{text}");
        assert_eq!(parts.name, if text.contains("other") { "other" } else { "leg" });
        assert_eq!(machine.task, Task::Joints);
    }
    let of_body = with_files("body = \"leg.urdf\"\nmuscles = \"leg.muscles.toml\"").unwrap().machine;
    assert!(
        (of_body.muscles[1].sheath - 0.9).abs() < 1e-12 && (of_body.muscles[0].sheath - 0.5).abs() < 1e-12
    );
}

#[test]
fn a_body_that_cannot_be_read_is_refused_with_the_line_of_its_name_or_its_own() {
    let refused = |text: &str, parts: &[&str]| {
        let told = with_files(text).unwrap_err().to_string();
        parts.iter().for_each(|part| assert!(told.contains(part), "`{part}` is not in: {told}"));
    };
    refused("\nbody = \"arm.xml\"", &["machines/leg.toml:2:", "body", "arm.xml", "is not here"]);
    refused("body = \"leg.step\"", &["leg.toml:1:", ".urdf"]);
    refused("body = \"leg.urdf\"", &["muscles must be at least one"]);
    refused("body = \"leg.xml\"\nmuscles = \"leg.muscles.toml\"", &["leg.toml:2:", "muscles", "URDF"]);
    refused("body = \"leg.xml\"\n[[joint]]\nname = \"hip\"", &["leg.toml:2:", "`joint`", "leg.xml"]);
    refused(
        "body = \"leg.xml\"\n[[transmission]]\nmuscle = \"flexer\"",
        &["leg.toml:3:", "flexer", "`flexor`"],
    );
    refused("", &["no body"]);
    let wrong =
        machine_from_toml("m.toml", "body = \"b.toml\"", &mut |_| Ok("[control]\nmargin = 0.5".into()));
    let told = wrong.unwrap_err().to_string();
    assert!(told.contains("b.toml:1") && told.contains("`control`"), "{told}");
}

#[test]
fn an_identified_model_gives_its_cable_and_a_table_changes_it() {
    let text = "body = \"leg.xml\"\n[[transmission]]\nmuscle = \"flexor\"\nmodel = \"cable.json\"\n\
                cable = { pretension_n = 12.0 }\n";
    let read = with_files(text).unwrap();
    let flexor = &read.machine.muscles[1];
    assert_eq!(flexor.model, cable_model().estimator.law.cable.map(|cable| cable.model));
    assert_eq!((flexor.cable.friction, flexor.cable.pretension), (0.2, 12.0));
    let source = |key: &str| {
        let of = |s: &&sinew::description::machine::Setting| s.table.contains("`flexor`") && s.key == key;
        read.settings.iter().find(of).unwrap().source
    };
    assert_eq!(source("cable.friction"), ValueSource::Model);
    assert_eq!(source("cable.pretension_n"), ValueSource::File { line: 5 });
    for (file, parts) in [
        ("gone.json", "is not here"),
        ("leg.xml", "model file"),
        ("other.json", "displacements of both ends"),
    ] {
        let told = with_files(&text.replace("cable.json", file)).unwrap_err();
        assert_eq!(told.line, 4, "{told}");
        assert!(told.to_string().contains(parts), "{told}");
    }
}

#[test]
fn a_muscles_own_table_precedes_its_body_which_precedes_the_table_for_all() {
    let text = "body = \"leg.urdf\"\nmuscles = \"leg.muscles.toml\"\n[every_transmission]\nsheath_length_m \
        = 0.3\n\
                sheath_bend_rad = 1.0\ncable = { friction = 0.1 }\n";
    let muscles = with_files(text).unwrap().machine.muscles;
    assert_eq!((muscles[0].sheath, muscles[1].sheath), (0.3, 0.9));
    assert_eq!((muscles[0].bend, muscles[1].bend), (1.0, 2.0));
    let own = format!(
        "{text}[[transmission]]\nmuscle = \"flexor\"\nsheath_length_m = 0.4\ncable = {{ efficiency = 0.9 }}\n"
    );
    let flexor = &with_files(&own).unwrap().machine.muscles[1];
    assert_eq!((flexor.sheath, flexor.bend), (0.4, 2.0));
    assert_eq!((flexor.cable.friction, flexor.cable.efficiency), (0.1, 0.9));
    // The drag of the default cable is that of its sheath.
    assert!((flexor.cable.drag - 95.0 * 0.4 / 0.806).abs() < 1e-12);
}

#[test]
fn poses_start_and_travel_belong_to_joints_by_name() {
    let text = "body = \"leg.xml\"\nstart = \"bent\"\n";
    assert_eq!(with_files(text).unwrap().machine.start, [0.7]);
    let text = "body = \"leg.xml\"\nstart = \"low\"\n[[pose]]\nname = \"low\"\njoints = { knee = 0.2 }\n\
                [[travel]]\njoint = \"knee\"\nrange_rad = [0.1, 1.0]\n";
    let machine = with_files(text).unwrap().machine;
    assert_eq!((machine.start.as_slice(), machine.robot.key("low")), (&[0.2][..], Some(&[0.2][..])));
    assert_eq!(machine.robot.parts().joints[0].range, Some([0.1, 1.0]));
    let robot = robot_from_toml("leg.toml", text, &mut |_| Ok(LEG.to_string())).unwrap().0;
    assert_eq!(&robot, &machine.robot);
    // A pose of the body may be out of the narrower range: then it is no start.
    let narrow = text.replace("start = \"low\"", "start = \"bent\"").replace("1.0]", "0.6]");
    let wrong = with_files(&narrow).unwrap_err().to_string();
    assert!(wrong.contains("leg.toml:2:") && wrong.contains("`knee`, 0.1 to 0.6"), "{wrong}");
    let wrong = with_files(&text.replace("knee = 0.2", "knee = 0.05")).unwrap_err().to_string();
    assert!(wrong.contains("leg.toml:5:") && wrong.contains("0.1 to 1"), "{wrong}");
}

#[test]
fn a_coupled_joint_follows_and_has_neither_start_nor_encoder() {
    let read = model("finger");
    let machine = &read.machine;
    assert_eq!((machine.start.len(), machine.encoders.len(), machine.robot.nq()), (3, 3, 4));
    let text = sinew_models::FINGER;
    let wrong = |more: &str| super::read(&format!("{text}\n{more}\n")).unwrap_err().to_string();
    let told = wrong("[[joint_encoder]]\njoint = \"end_flexion\"\nnone = true");
    assert!(told.contains("end_flexion") && told.contains("follows no other"), "{told}");
    let told = wrong("[redundancy]\nrest = { end_flexion = 0.1 }");
    assert!(told.contains("`end_flexion` is no key"), "{told}");
}

/// The error of a machine whose body is this MJCF.
fn refused_body(mjcf: &str) -> String {
    let described = from_mjcf("leg.xml", mjcf, &mut |_| Err(String::new())).unwrap();
    machine_of(described).unwrap_err().to_string()
}

#[test]
fn a_body_that_no_machine_can_have_is_refused_with_its_joint_and_the_remedy() {
    // A joint behind which nothing has a mass.
    let light = LEG.replace("mass=\"1\" diaginertia=\"0.01 0.01 0.001\"", "mass=\"0\" diaginertia=\"0 0 0\"");
    let told = refused_body(&light);
    let remedy = told.contains("mass") && told.contains("armature");
    assert!(told.starts_with("leg.xml:2:") && told.contains("`knee`") && remedy, "{told}");
    // A follower that is out of its range wherever its leader is.
    let follower = "<body name=\"foot\" pos=\"0 0 -0.4\">\n<joint name=\"ankle\" axis=\"0 1 0\" range=\"10 \
        20\"/>\
                    <inertial pos=\"0 0 -0.1\" mass=\"1\" diaginertia=\"0.01 0.01 \
                    0.001\"/></body></body></worldbody>\
                    <equality><joint joint1=\"ankle\" joint2=\"knee\" polycoef=\"0 -1 0 0 0\"/></equality>";
    let coupled = LEG.replace("</body></worldbody>", follower).replace("0.7\"", "0.7 -0.7\"");
    let told = refused_body(&coupled);
    assert!(
        told.starts_with("leg.xml:2:") && told.contains("`knee`") && told.contains("follow it"),
        "{told}"
    );
    // A joint that no machine has is named first.
    let ball = coupled.replace("range=\"0 90\"/>", "range=\"0 90\"/><joint name=\"hip\" type=\"ball\"/>");
    let told = refused_body(&ball.replace("0.7 -0.7", "0.7 1 0 0 0 -0.7"));
    assert!(told.contains("`hip`") && told.contains("hinge or slide"), "{told}");
    // Where some poses serve, one of them is the start.
    let serves = coupled.replace("polycoef=\"0 -1", "polycoef=\"0 1");
    let start = machine_of(from_mjcf("leg.xml", &serves, &mut |_| Err(String::new())).unwrap())
        .unwrap()
        .machine
        .start;
    assert!((10.0_f64.to_radians()..=20.0_f64.to_radians()).contains(&start[0]), "{start:?}");
    let told = refused_body("<mujoco><worldbody><body name=\"a\"/></worldbody></mujoco>");
    assert!(told.contains("NAME.muscles.toml") && told.contains("[[muscle]]"), "{told}");
}

#[test]
fn a_bend_by_joint_is_of_joints_that_follow_no_other_and_keeps_the_sheath_within_two_turns() {
    let bent = |table: &str| {
        let text =
            format!("body = \"leg.xml\"\n[[transmission]]\nmuscle = \"flexor\"\nbend_by_joint = {table}\n");
        with_files(&text)
    };
    let machine = bent("{ knee = 0.4 }").unwrap().machine;
    assert_eq!(
        (machine.muscles[1].bend_by_joint.as_slice(), machine.muscles[0].bend_by_joint.len()),
        (&[0.4][..], 0)
    );
    let bends = machine.sheath_bends().unwrap();
    assert!(bends[0].is_constant() && (bends[1].at(&[0.5]) - machine.muscles[1].bend - 0.2).abs() < 1e-12);
    for (table, parts) in [
        ("{ kne = 0.4 }", ["`kne`", "`knee`"]),
        ("{ knee = 40.0 }", ["knee is 40.0", "at most 4 pi"]),
        ("{ knee = nan }", ["knee is nan", "finite"]),
        ("0.4", ["bend_by_joint is 0.4", "a table"]),
    ] {
        let told = bent(table).unwrap_err();
        assert_eq!(told.line, 4, "{told}");
        parts.iter().for_each(|part| assert!(told.to_string().contains(part), "`{part}`: {told}"));
    }
}

#[test]
fn a_body_alone_is_a_machine_of_defaults() {
    let described = from_mjcf("leg.xml", LEG, &mut |_| Err(String::new())).unwrap();
    let robot = described.clone().robot().unwrap().0;
    let read = machine_of(described).unwrap();
    assert_eq!(read.machine, Machine::from_robot(&robot).unwrap());
    assert!(read.settings.iter().all(|s| s.source == ValueSource::Default), "{:?}", read.settings);
    let empty =
        from_mjcf("none.xml", "<mujoco><worldbody><body name=\"a\"/></worldbody></mujoco>", &mut |_| {
            Err(String::new())
        });
    let told = machine_of(empty.unwrap()).unwrap_err().to_string();
    assert!(told.starts_with("none.xml:1:") && told.contains("muscles"), "{told}");
    let thigh = "<worldbody><body name=\"thigh\">\n<joint name=\"hip\" type=\"ball\"/>\
                 <inertial pos=\"0 0 0\" mass=\"1\" diaginertia=\"1 1 1\"/>";
    let ball = LEG.replace("<worldbody>", thigh).replace("</worldbody>", "</body></worldbody>");
    let ball = ball.replace("qpos=\"0.7\"", "qpos=\"1 0 0 0 0.7\"");
    let told = machine_of(from_mjcf("ball.xml", &ball, &mut |_| Err(String::new())).unwrap())
        .unwrap_err()
        .to_string();
    assert!(
        told.starts_with("ball.xml:2:") && told.contains("`hip`") && told.contains("hinge or slide"),
        "{told}"
    );
}
