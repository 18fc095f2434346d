//! Robots: inspected, evaluated, converted, and refused.

use crate::bench::Bench;

#[test]
fn the_embedded_arm_converts_and_evaluates_the_same_in_every_format() {
    let bench = Bench::new();
    bench.write("poses.csv", "elbow_flexion,shoulder_flexion\n0.5,0.2\n1.5,-0.3\n");
    let mut results = Vec::new();
    for (model, file) in [("lm_arm", "arm.xml"), ("arm.xml", "arm.toml"), ("arm.toml", "again.xml")] {
        assert_eq!(bench.run(&format!("machine convert {model} {file}")).code, Some(0));
        let run = bench.run(&format!("machine evaluate {file} --poses poses.csv"));
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        results.push(run.stdout);
    }
    assert!(results[0].contains("moment_arm_m:triceps:elbow_flexion"));
    assert_eq!(results[0], results[1]);
    assert_eq!(results[1], results[2]);
}

#[test]
fn inspect_prints_a_table_and_writes_a_page() {
    let bench = Bench::new();
    let run = bench.run("machine body lm_arm --report arm.html");
    assert!(run.stdout.contains("deltoid_anterior") && run.stdout.contains("7 joints"), "{}", run.stdout);
    assert!(bench.read("arm.html").contains("moment arms") || bench.read("arm.html").contains("Moment arms"));
}

/// One triangle as binary STL.
fn triangle() -> Vec<u8> {
    let corners = [[0.0_f32, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.0, -0.3]];
    let numbers = [0.0; 3].into_iter().chain(corners.into_iter().flatten());
    let mut bytes = vec![0; 80];
    bytes.extend(1_u32.to_le_bytes());
    bytes.extend(numbers.flat_map(f32::to_le_bytes));
    bytes.extend([0; 2]);
    bytes
}

#[test]
fn a_mesh_is_drawn_where_it_can_be_read_and_named_where_it_cannot() {
    let bench = Bench::new();
    std::fs::create_dir(bench.path("shapes")).unwrap();
    bench.write("shapes/thigh.stl", triangle());
    bench.write(
        "leg.xml",
        r#"<mujoco><compiler meshdir="shapes"/><asset><mesh file="thigh.stl"/><mesh file="shank.stl"/></asset><worldbody>
        <site name="a" pos="0.05 0 0.1"/><body name="thigh"><joint name="hip" axis="0 1 0" range="-40 40"/>
        <inertial pos="0 0 -0.1" mass="1" diaginertia="0.01 0.01 0.01"/><geom mesh="thigh"/><geom mesh="shank"/>
        <site name="b" pos="0.05 0 -0.1"/></body></worldbody>
        <tendon><spatial name="t"><site site="a"/><site site="b"/></spatial></tendon></mujoco>"#,
    );
    bench.write("machine.toml", "body = \"leg.xml\"\n");
    for file in ["leg.xml", "machine.toml"] {
        let run = bench.run(&format!("machine body {file} --report leg.html"));
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        assert!(run.stderr.contains("shapes/shank.stl cannot be read"), "{}", run.stderr);
        assert!(!run.stderr.contains("thigh.stl"), "{}", run.stderr);
        let page = bench.read("leg.html");
        assert_eq!(page.matches("\"kind\":\"mesh\"").count(), 1);
        assert!(!page.contains("\"kind\":\"bone\""));
    }
    // Without a drawing no mesh is read.
    assert_eq!(bench.run("machine body leg.xml").stderr, "");
    let run = bench.run("machine convert leg.xml leg.toml");
    assert!(run.stderr.contains("2 shapes of bodies in mesh files are left out"), "{}", run.stderr);
}

#[test]
fn a_model_includes_files_that_lie_beside_its_folder_but_no_link_leads_out_of_what_holds_both() {
    let bench = Bench::new();
    for folder in ["all/robot", "all/shared", "away"] {
        std::fs::create_dir_all(bench.path(folder)).unwrap();
    }
    let body = "<mujoco><worldbody><body name=\"tip\"><joint name=\"j\" range=\"0 1\"/><geom \
        size=\".1\"/></body></worldbody></mujoco>";
    bench.write("all/shared/tip.xml", body);
    bench.write("away/tip.xml", body);
    let model = |file: &str| format!("<mujoco>\n<include file=\"{file}\"/></mujoco>");
    bench.write("all/robot/leg.xml", model("../shared/tip.xml"));
    assert!(bench.succeeds("machine body all/robot/leg.xml").stdout.contains("1 joints"));
    bench.write("m.toml", "body = \"all/robot/leg.xml\"\n");
    assert!(bench.succeeds("machine body m.toml").stdout.contains("1 joints"));
    bench.write("all/robot/leg.xml", model("../shared/gone.xml"));
    bench.refuses("machine body all/robot/leg.xml", &["leg.xml:2", "gone.xml", "cannot be read"]);
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(bench.path("away/tip.xml"), bench.path("all/shared/link.xml")).unwrap();
        bench.write("all/robot/leg.xml", model("../shared/link.xml"));
        bench.refuses("machine body all/robot/leg.xml", &["leg.xml:2", "link.xml", "outside"]);
    }
}

#[test]
fn bad_robots_and_poses_are_refused_with_their_place() {
    let bench = Bench::new();
    bench.write("out.xml", "<mujoco>\n<include file=\"/secret.xml\"/></mujoco>");
    bench.write("up.xml", format!("<mujoco>\n<include file=\"{}etc/hosts\"/></mujoco>", "../".repeat(40)));
    bench.write("circle.xml", "<mujoco>\n<include file=\"circle.xml\"/></mujoco>");
    bench.write("unit.toml", "[[body]]\nname = \"b\"\nmass_g = 1\n");
    bench.write("poses.csv", "elbow_flexion\nfar\n");
    bench.write("names.csv", "elbow\n1\n");
    for (arguments, words) in [
        ("machine body out.xml", ["out.xml:2", "absolute"]),
        ("machine body up.xml", ["up.xml:2", "no folder in common"]),
        ("machine body circle.xml", ["circle.xml", "included already"]),
        ("machine body unit.toml", ["unit.toml:3", "mass_g"]),
        ("machine body robot.step", ["robot.step", ".toml"]),
        (
            "machine evaluate lm_arm --poses poses.csv",
            ["line 2, column `elbow_flexion`", "expected a finite number, got `far`"],
        ),
        ("machine evaluate lm_arm --poses names.csv", ["line 1, column `elbow`", "elbow_flexion"]),
    ] {
        bench.refuses(arguments, &words);
    }
}

#[test]
fn a_robot_without_a_body_and_a_tag_of_countless_attributes_are_refused() {
    let bench = Bench::new();
    bench.write("none.toml", "");
    bench.write("named.toml", "name = \"a\"\n");
    bench.write("none.xml", "<mujoco><worldbody/></mujoco>");
    for file in ["none.toml", "named.toml", "none.xml"] {
        bench.refuses(&format!("machine body {file}"), &[file, ":1:", "no body"]);
    }
    let attributes: String = (0..60_000).map(|i| format!(" a{i}='>'")).collect();
    bench.write("wide.xml", format!("<mujoco>\n<worldbody{attributes}/></mujoco>"));
    bench.refuses("machine body wide.xml", &["wide.xml:2:", "1000 attributes"]);
    bench.refuses("machine body lm_arm --muscles none.toml", &["lm_arm", "--muscles"]);
    let namespaces: String = (0..60_000).map(|i| format!("<b xmlns:a{i}='u'/>")).collect();
    bench.write("spaces.xml", format!("<mujoco>{namespaces}</mujoco>"));
    bench.refuses("machine body spaces.xml", &["spaces.xml:1:", "60000 namespace"]);
}

#[test]
fn poses_are_read_in_every_dialect_of_tables() {
    let bench = Bench::new();
    let degrees = |x: f64| x.to_degrees();
    let tables = [
        ("comma.csv", "elbow_flexion,shoulder_flexion\n0.5,0.25\n\n1.5,-0.25\n".to_owned()),
        ("semicolon.csv", "elbow_flexion;\"shoulder_flexion [rad]\"\r\n0.5;0.25\r\n1.5;-0.25\r\n".to_owned()),
        ("tab.csv", "shoulder_flexion\telbow_flexion [rad]\n0.25\t 0.5\n-0.25\t1.5\n".to_owned()),
        (
            "written.csv",
            "\u{feff}# by hand\r\n\r\n\"elbow_flexion\" , shoulder_flexion\r\n  # first\r\n \"0.5\" \
                ,\t+2.5e-1 \r\n1.5,-.25"
                .to_owned(),
        ),
        (
            "degrees.csv",
            format!(
                "elbow_flexion [deg], shoulder_flexion[deg]\n{},{}\n{},{}\n",
                degrees(0.5),
                degrees(0.25),
                degrees(1.5),
                degrees(-0.25)
            ),
        ),
    ];
    let mut results: Vec<Vec<f64>> = Vec::new();
    for (file, text) in &tables {
        bench.write(file, text);
        let run = bench.run(&format!("machine evaluate lm_arm --poses {file}"));
        assert_eq!(run.code, Some(0), "{file}: {}", run.stderr);
        let cells = run.stdout.lines().skip(1).flat_map(|line| line.split(','));
        results.push(cells.map(|cell| cell.parse().unwrap()).collect());
    }
    for (result, (file, _)) in results.iter().zip(&tables) {
        assert_eq!(result.len(), results[0].len(), "{file}");
        assert!(result.iter().zip(&results[0]).all(|(a, b)| (a - b).abs() < 1e-12), "{file}");
    }
}

#[test]
fn a_bad_cell_of_the_poses_is_named_by_line_and_column() {
    let bench = Bench::new();
    for (text, words) in [
        ("elbow_flexion,shoulder_flexion\n0,0\n0,1e999\n", ["line 3", "`shoulder_flexion`"]),
        ("elbow_flexion;shoulder_flexion\n0;0,5\n", ["line 2", "`0,5`"]),
        ("elbow_flexion\tshoulder_flexion\n\n0\n", ["line 3", "expected 2 cells, one per column, got 1"]),
        ("elbow_flexion [inch]\n0\n", ["line 1", "`inch`"]),
        ("elbow_flexion,elbow_flexion\n0,0\n", ["line 1", "`elbow_flexion`"]),
        ("elbow_flexion\nNaN\n", ["line 2", "`NaN`"]),
        (
            "# note\nelbow_flexion,shoulder_flexion\n0,\n",
            ["line 3, column `shoulder_flexion`", "got an empty cell"],
        ),
        ("elbow_flexion\n0\n\"0\n", ["line 3", "quote"]),
        ("elbow_flexion,\n0,0\n", ["line 1", "column ``"]),
        ("elbow_flexion\n0x1\n", ["line 2", "expected a finite number, got `0x1`"]),
        ("", ["line 1", "expected a row of joint names, got an empty table"]),
        ("\n# only a comment\n", ["line 1", "an empty table"]),
    ] {
        bench.write("poses.csv", text);
        bench.refuses("machine evaluate lm_arm --poses poses.csv", &words);
    }
}

#[test]
fn names_with_commas_quotes_and_brackets_come_back_as_they_went_out() {
    let bench = Bench::new();
    let joint = |name: &str| format!("<body><joint name='{name}'/><geom size='1' pos='1 0 0'/>");
    let bodies = joint("a,b") + &joint("c &quot;d&quot;") + &joint("e[0]") + "</body></body></body>";
    bench.write("robot.xml", format!("<mujoco><worldbody>{bodies}</worldbody></mujoco>"));
    bench.write("poses.csv", "\"a,b\",\"c \"\"d\"\"\",e[0]\n0.1,0.2,0.3\n");
    let run = bench.run("machine evaluate robot.xml --poses poses.csv");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let head = "\"gravity_torque_nm:a,b\",\"gravity_torque_nm:c \"\"d\"\"\",gravity_torque_nm:e[0]";
    assert_eq!(run.stdout.lines().next(), Some(head));
}

/// A cable that slips off a sphere where its branches change sides.
const JUMPER: &str = r#"<mujoco model="jumper"><compiler angle="radian"/><worldbody><site name="a" pos="0.2 0 0.3"/>
<body name="arm"><joint name="j" type="hinge" axis="0 1 0" range="-1.5 1.5"/>
<geom type="capsule" fromto="0 0 0 0 0 0.4" size="0.02" mass="1"/><geom name="w" type="sphere" size="0.06" pos="0 0 0.2" mass="0"/>
<site name="b" pos="-0.15 0 0.35"/></body></worldbody>
<tendon><spatial name="t"><site site="a"/><geom geom="w"/><site site="b"/></spatial></tendon></mujoco>"#;

#[test]
fn the_page_marks_a_jump_of_a_moment_arm_and_draws_the_shapes_of_the_file() {
    let bench = Bench::new();
    bench.write("jumper.xml", JUMPER);
    bench.succeeds("machine body jumper.xml --report jumper.html");
    let page = bench.read("jumper.html");
    assert!(page.contains("t: from 116.0 to 182.3\u{202f}mm at j = \u{2212}1.365\u{202f}rad"));
    assert!(page.contains("class=\"dots jump\" data-name=\"jump\""));
    // The radius of the capsule.
    assert!(page.contains("\"kind\":\"capsule\"") && page.contains("\"size\":[0.02,"));
    bench.succeeds("machine body finger --report finger.html");
    assert!(!bench.read("finger.html").contains("class=\"dots jump\""), "guard: none where there is none");
}

#[test]
fn the_page_draws_cables_along_arcs_and_holds_every_joint() {
    let bench = Bench::new();
    assert_eq!(bench.run("machine body lm_arm --report arm.html").code, Some(0));
    let page = bench.read("arm.html");
    let data =
        page.split_once("<script type=\"application/json\">").unwrap().1.split_once("</script>").unwrap().0;
    let data: serde_json::Value = serde_json::from_str(data).unwrap();
    let (poses, sweeps) = (&data["poses"], data["sweeps"].as_array().unwrap());
    assert_eq!((poses[0]["name"].as_str(), sweeps.len()), (Some("reference"), 7));
    let triceps =
        data["fixed"]["muscles"].as_array().unwrap().iter().position(|m| m["name"] == "triceps").unwrap();
    let line = poses[0]["scene"]["cables"][triceps][0].as_array().unwrap();
    assert!(line.len() > 2, "wraps about the elbow");
    // The drawn line is as long as the muscle, but for the chords of its arcs.
    let points: Vec<Vec<f64>> = line.iter().map(|p| serde_json::from_value(p.clone()).unwrap()).collect();
    let piece = |pair: &[Vec<f64>]| (0..3).map(|i| (pair[1][i] - pair[0][i]).powi(2)).sum::<f64>().sqrt();
    let drawn: f64 = points.windows(2).map(piece).sum();
    let inspected: serde_json::Value =
        serde_json::from_str(&bench.run("machine body lm_arm --json").stdout).unwrap();
    let length = inspected["muscles"][triceps]["length_m"].as_f64().unwrap();
    assert!((drawn - length).abs() < 2e-4, "{drawn} {length}");
    // The elbow bends the triceps and leaves the deltoid alone.
    let frames = &sweeps.iter().find(|s| s["joint"] == "elbow_flexion").unwrap()["frames"];
    assert!(frames[20]["cables"][triceps].is_array() && frames[20]["cables"][0].is_null());
}

#[test]
fn a_fault_after_the_end_of_the_run_is_refused_before_the_start() {
    let bench = Bench::new();
    let run = "bench_joint --path to-joints:lever=0.3 --duration 2 --hold 1";
    // 3 s at rest, 2 s of motion, 1 s at rest.
    for verb in ["track", "run --virtual-time"] {
        let late = bench.run(&format!("{verb} {run} --fault load-cell:front:lost@6"));
        assert_eq!(late.code, Some(2), "{}", late.stderr);
        for words in ["load-cell:front:lost@6", "6.000 s"] {
            assert!(late.stderr.contains(words), "{}", late.stderr);
        }
        let told = bench.run(&format!("{verb} {run} --fault load-cell:front:lost@5.9 --json"));
        assert!(told.stdout.contains("load cell of front"), "{} {}", told.stdout, told.stderr);
    }
    let json = bench.run(&format!("track {run} --fault cable:front@40 --json"));
    assert!(json.stdout.contains("cable:front@40"), "the error stands in the JSON as well: {}", json.stdout);
}

#[test]
fn a_reason_names_the_fault_first_and_then_what_it_led_to() {
    let bench = Bench::new();
    let run = "track bench_joint --path to-joints:lever=0.6 --duration 3 --json";
    let ended = bench.run(&format!("{run} --fault cable:front@4.5"));
    assert_eq!(ended.code, Some(3), "{}", ended.stderr);
    let value: serde_json::Value = serde_json::from_str(&ended.stdout).unwrap();
    let numbers = &value["tracking"]["observer"];
    let (reason, incidents) = (numbers["reason"].as_str().unwrap(), numbers["incidents"].as_array().unwrap());
    let first = incidents[0]["what"].as_str().unwrap();
    assert!(reason.starts_with(first), "{reason}: {incidents:?}");
    for incident in incidents {
        assert!(["kind", "what", "answer"].iter().all(|key| !incident[key].as_str().unwrap().is_empty()));
    }
    let whole = bench.run(&format!("{run} --fault push:lever:9@4+0.15"));
    let value: serde_json::Value = serde_json::from_str(&whole.stdout).unwrap();
    let numbers = &value["tracking"]["observer"];
    let joint = &numbers["joints"][0];
    let [error, limit] = ["largest_error_rad", "limit_rad"].map(|key| joint[key].as_f64().unwrap());
    assert_eq!(error > limit || numbers["ended"] != "as_planned", numbers["reason"].is_string(), "{numbers}");
}

#[test]
fn a_bridged_loss_accuses_no_sensor_and_a_lack_of_commands_is_an_incident() {
    let bench = Bench::new();
    let incidents = |fault: &str| {
        let run =
            bench.run(&format!("track bench_joint --duration 6 --repeats 1 --seed 2 --fault {fault} --json"));
        let value: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
        let list = value["tracking"]["observer"]["incidents"].as_array().unwrap().clone();
        list.into_iter()
            .map(|one| ["what", "answer"].map(|key| one[key].as_str().unwrap().to_owned()))
            .collect()
    };
    let lost: Vec<[String; 2]> = incidents("cycles:lost@4+0.003");
    assert_eq!(lost, [["no answer from the bus", "bridged"]]);
    let stale: Vec<[String; 2]> = incidents("cycles:stale@4+1");
    assert_eq!(stale, [["no new command", "held"]]);
}

#[test]
fn a_fault_is_injected_by_name_and_reported_with_its_time() {
    let bench = Bench::new();
    let short = "track --duration 6 --repeats 1";
    let run = bench.run(&format!(
        "{short} --fault joint-encoder:elbow_flexion:nan@4+0.005 --fault cable:triceps@6 --report run.html \
            --record run.csv --json"
    ));
    assert_eq!(run.code, Some(3), "the arm was stopped: {}", run.stderr);
    for words in [
        "joint encoder of elbow_flexion",
        "bridged",
        "\"stopped_by\":\"cable of triceps\"",
        "\"stopped_s\":6.0",
    ] {
        assert!(run.stdout.contains(words), "{words}: {}", run.stdout);
    }
    assert!(bench.read("run.html").contains("cable of triceps, arm stopped"));
    assert_eq!(bench.read("run.csv").lines().count(), 3 + 1200, "recorded to the end");
    for (fault, words) in [
        ("cable:biceps@5", "name of a muscle: "),
        ("joint-encoder:triceps:nan@5", "name of a joint with an encoder: "),
    ] {
        bench.refuses(&format!("{short} --fault {fault}"), &["--fault", fault, words]);
    }
    for (fault, words) in [
        ("cable:triceps", "COMPONENT:NAME@START"),
        ("cable:triceps@-1", "at least 0 s"),
        ("drive:triceps@5+0", "above 0 s"),
        ("cable:triceps:stuck@5", "only sensors"),
        ("load-cell:triceps@5", "stuck, lost, nan, jump=X"),
        ("load-cell:triceps:nan:nan@5", "before @"),
    ] {
        bench.refuses_usage(&format!("{short} --fault {fault}"), &["--fault", fault, words]);
    }
}

#[test]
fn a_payload_beyond_the_tension_limits_is_refused_before_the_simulation() {
    Bench::new()
        .declines("track --duration 11.5 --repeats 1 --payload 2", &["--payload 2 kg", "elbow_flexion"]);
}
