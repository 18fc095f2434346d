//! Machine files: shown, written, and refused.

use crate::bench::Bench;
use serde_json::Value;
use sinew_models::MACHINES;

fn json(bench: &Bench, arguments: &str) -> Value {
    let run = bench.run(arguments);
    assert!(matches!(run.code, Some(0 | 3)), "{arguments}: {}", run.stderr);
    serde_json::from_str(&run.stdout).unwrap()
}

/// The value and the origin of a setting.
fn setting<'a>(shown: &'a Value, table: &str, key: &str) -> (&'a Value, &'a str) {
    let settings = shown["settings"].as_array().unwrap();
    let found = settings.iter().find(|row| row["table"] == table && row["key"] == key);
    let row = found.unwrap_or_else(|| panic!("{table} {key}"));
    (&row["value"], row["source"].as_str().unwrap())
}

#[test]
fn every_built_in_machine_is_shown_with_units_and_origins() {
    let bench = Bench::new();
    for (name, _) in MACHINES {
        let run = bench.succeeds(&format!("machine show {name}"));
        for part in [name, "dead band", "default", "body", "[control]", "rad/s", "kg at cable"] {
            assert!(run.stdout.contains(part), "{name}: {part}");
        }
    }
    let shown = json(&bench, "machine show finger --json");
    assert_eq!(
        (shown["joints"].as_array().unwrap().len(), shown["muscles"].as_array().unwrap().len()),
        (3, 5)
    );
    assert_eq!(
        setting(&shown, "[[transmission]] `extensor`", "sheath_length_m"),
        (&Value::from(0.4), "body")
    );
    assert_eq!(setting(&shown, "[[transmission]] `extensor`", "cable.friction"), (&Value::from(0.1), "file"));
    assert_eq!(setting(&shown, "[control]", "margin"), (&Value::from(0.8), "default"));
    let count =
        |unit: &str| shown["settings"].as_array().unwrap().iter().filter(|row| row["unit"] == unit).count();
    assert!(count("1/N") > 0 && count("rad") > 0 && count("N") > 0);
}

#[test]
fn a_pose_that_a_machine_leaves_by_itself_and_a_wrap_that_it_may_lose_are_named() {
    let bench = Bench::new();
    let held = json(&bench, "machine show bench_joint --json");
    assert!(
        held["locked_winches"][0]["unstable_rate_per_s"] == 0.0
            && held["warnings"] == Value::from(Vec::<Value>::new())
    );
    // The arm leaves a pose under gravity, too slowly for a warning.
    let arm = bench.succeeds("machine show lm_arm");
    assert!(
        arm.stdout.contains("leaves the pose") && arm.stdout.contains("gravity outweighs"),
        "{}",
        arm.stdout
    );
    assert!(arm.stderr.is_empty(), "{}", arm.stderr);

    let text = sinew_models::BENCH_JOINT;
    let near = text.replace("[-0.000119, 0.0, -0.0319998]", "[0.005201, 0.0, -0.0301548]");
    assert_ne!(near, text);
    std::fs::write(bench.path("near.toml"), near).unwrap();
    let near = bench.run("machine show near.toml");
    assert_eq!(near.code, Some(0), "{}", near.stderr);
    for part in [
        "warning: muscle `front`",
        "`front_i`",
        "0.6000 mm clear",
        "`lever_drum`",
        "1.414 mm",
        "lose the wrap",
    ] {
        assert!(near.stderr.contains(part), "{part}: {}", near.stderr);
    }
    let inside = text.replace("[-0.000119, 0.0, -0.0319998]", "[0.005, 0.0, -0.028]");
    std::fs::write(bench.path("inside.toml"), inside).unwrap();
    let shown = json(&bench, "machine show inside.toml --json");
    assert!(shown["warnings"][0].as_str().unwrap().contains("mm within the surface `lever_drum`"), "{shown}");
}

#[test]
fn muscles_too_weak_for_the_weight_are_named_with_pose_and_joint() {
    let bench = Bench::new();
    let text = sinew_models::PLANAR_LEG;
    let heavy = text.replacen("[task]", "[payload]\nmass_kg = 40.0\n\n[task]", 1);
    assert_ne!(heavy, text);
    bench.write("heavy.toml", heavy);
    for verb in ["show", "tune"] {
        let run = bench.run(&format!("machine {verb} heavy.toml"));
        for part in
            ["warning: muscles too weak to hold", "sampled poses", "`hip` lacks", "N m", "control_range"]
        {
            assert!(run.stderr.contains(part), "{verb}, {part}: {}", run.stderr);
        }
        assert!(run.stdout.contains("do not hold") || run.stdout.contains("hold none"), "{}", run.stdout);
    }
}

#[test]
fn a_new_machine_file_runs_at_once_and_an_existing_one_is_kept() {
    let bench = Bench::new();
    bench.succeeds("machine convert planar_leg leg.xml");
    let answer = json(&bench, "machine new leg.xml --out leg.toml --json");
    let muscles = answer["muscles"].as_array().unwrap();
    assert!(muscles.len() == 4 && muscles.iter().all(|muscle| muscle["used"].as_f64().unwrap() <= 1.0));
    let text = bench.read("leg.toml");
    assert!(
        text.contains("body = \"leg.xml\"") && text.contains("# ") && text.contains("axes = [\"x\", \"z\"]"),
        "{text}"
    );
    let shown = json(&bench, "machine show leg.toml --json");
    assert_eq!(shown["warnings"], Value::from(Vec::<Value>::new()));
    let drive = muscles[0]["drive"].as_str().unwrap();
    assert_eq!(setting(&shown, "[[transmission]] `hip_flexor`", "drive"), (&Value::from(drive), "file"));
    bench.succeeds("machine body leg.toml");

    bench.refuses("machine new leg.xml --out leg.toml", &["leg.toml", "exists already", "--force"]);
    bench.succeeds("machine new leg.xml --out leg.toml --force --period 1");
    assert_ne!(bench.read("leg.toml"), text);
    bench.refuses("machine new leg.xml --out leg.xml --force", &["leg.xml", "read by this run"]);
    bench.refuses("machine new leg.xml --out other.xml", &["other.xml", ".toml"]);
    bench.refuses("machine new foot.xml --out foot.toml", &["foot.xml"]);
    bench.refuses_usage("machine new leg.xml --out a.toml --fraction 0", &["--fraction", "(0, 1]"]);
}

#[test]
fn a_machine_file_in_another_folder_finds_its_body() {
    let bench = Bench::new();
    std::fs::create_dir_all(bench.path("bodies")).unwrap();
    std::fs::create_dir_all(bench.path("machines")).unwrap();
    bench.succeeds("machine convert bench_joint bodies/lever.toml");
    bench.succeeds("machine new bodies/lever.toml --out machines/lever.toml");
    assert!(bench.read("machines/lever.toml").contains("body = \"../bodies/lever.toml\""));
    for verb in ["machine show", "machine body"] {
        assert!(bench.succeeds(&format!("{verb} machines/lever.toml")).stdout.contains("lever"));
    }
    bench.write("bodies/lever.toml", "[[body]]\nmass = 1");
    bench.refuses(
        "machine show machines/lever.toml",
        &["machines/../bodies/lever.toml:2:", "`mass`", "`mass_kg`"],
    );
}

#[test]
fn a_urdf_robot_with_its_muscles_becomes_a_machine() {
    let bench = Bench::new();
    bench.write(
        "leg.urdf",
        r#"<robot name="leg"><link name="world"/><link name="shank"><inertial><origin xyz="0 0 -0.2"/>
<mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="knee" type="revolute"><parent link="world"/><child link="shank"/><axis xyz="0 1 0"/>
<limit lower="0" upper="1.57" effort="1" velocity="1"/></joint></robot>"#,
    );
    let muscle = |name: &str, arm: f64| {
        format!("[[muscle]]\nname = \"{name}\"\njoints = [{{ joint = \"knee\", coefficient = {arm:?} }}]\n")
    };
    bench.write("leg.muscles.toml", muscle("extensor", 0.03) + &muscle("flexor", -0.03));
    bench.succeeds("machine new leg.urdf --out machine.toml");
    assert!(bench.read("machine.toml").contains("muscles = \"leg.muscles.toml\""));
    let shown = json(&bench, "machine show machine.toml --json");
    assert_eq!(setting(&shown, "[task]", "space").0, "joints");
    // The cable that pulls as gravity does cannot hold the joint: said, and ended with a code of its own.
    bench.write("leg.muscles.toml", muscle("extensor", 0.03));
    let run = bench.run("machine new leg.urdf --out weak.toml");
    assert_eq!(run.code, Some(3), "{}", run.stderr);
    assert!(
        run.stdout.contains("no tensions give the torque") && run.stdout.contains("knee"),
        "{}",
        run.stdout
    );
}

#[test]
fn a_body_that_cannot_run_is_refused_before_a_machine_file_is_written() {
    let bench = Bench::new();
    let body = |joint: &str, mass: &str, coefficient: &str| {
        format!(
            "<mujoco><worldbody><body name=\"tip\">\n{joint}<inertial pos=\"0 0 -0.02\" \
                {mass}/></body></worldbody><tendon><fixed name=\"up\"><joint joint=\"tip\" \
                coef=\"{coefficient}\"/></fixed></tendon></mujoco>"
        )
    };
    let hinge = "<joint name=\"tip\" axis=\"0 1 0\" range=\"0 60\"/>";
    let light = "mass=\"0.01\" diaginertia=\"1e-6 1e-6 1e-7\"";
    for (text, parts) in [
        // A moment arm of half a metre on a fingertip.
        (body(hinge, light, "0.5"), ["body.xml:2: joint `tip`", "armature"]),
        (body("<joint name=\"tip\" type=\"ball\"/>", light, "0.5"), ["body.xml:2:", "a slide"]),
        (body(hinge, "mass=\"0\" diaginertia=\"0 0 0\"", "0.01"), ["body.xml:2:", "`tip`"]),
    ] {
        bench.write("body.xml", &text);
        bench.refuses("machine new body.xml --out m.toml", &parts);
        assert!(!bench.path("m.toml").exists());
    }
    // Names that no TOML key can be without quotes.
    let text = body(hinge, light, "0.01").replace("\"tip\"", "\"Spitze &quot;α&quot; 1.2\"");
    bench.write("body.xml", &text);
    let run = bench.run("machine new body.xml --out m.toml");
    assert!(matches!(run.code, Some(0 | 3)), "{}", run.stderr);
    let machine = bench
        .read("m.toml")
        .replace("muscle = \"up\"", "muscle = \"up\"\nbend_by_joint = { 'Spitze \"α\" 1.2' = 0.4 }");
    bench.write("m.toml", &machine);
    let shown = json(&bench, "machine show m.toml --json");
    let key = "bend_by_joint.Spitze \"α\" 1.2";
    assert_eq!(setting(&shown, "[[transmission]] `up`", key), (&Value::from(0.4), "file"));
    let row = shown["settings"].as_array().unwrap().iter().find(|row| row["key"] == key).unwrap();
    assert_eq!(row["unit"], "rad/rad");
}

#[test]
fn a_body_gets_cord_limits_and_drums_of_its_size_and_a_machine_is_copied_with_its_body() {
    let bench = Bench::new();
    bench.succeeds("machine convert finger finger.toml");
    let answer = json(&bench, "machine new finger.toml --out thin.toml --json");
    let light = answer["working_tension_n"].as_f64().unwrap();
    assert!(answer["cord"].as_str().unwrap().contains("mm") && light < 20.0, "{answer}");
    let shown = json(&bench, "machine show thin.toml --json");
    let bands = shown["joints"].as_array().unwrap().iter().map(|joint| joint["dead_band"].as_f64().unwrap());
    assert!(bands.clone().all(|band| band > 0.0 && band < 0.05), "{:?}", bands.collect::<Vec<_>>());
    // A force at its tip asks for more.
    let strong = json(&bench, "machine new finger.toml --out strong.toml --tip-force 3 --json");
    assert!(strong["working_tension_n"].as_f64().unwrap() > 2.0 * light, "{strong}");
    bench.refuses_usage("machine new finger.toml --out a.toml --tip-force -1", &["--tip-force", "100000"]);
    bench.succeeds("machine new exosuit_elbow --out suit.toml");
    let text = bench.read("suit.toml");
    assert!(text.contains("[[body]]") && !text.contains("body = \"exo"), "{text}");
    bench.succeeds("machine show suit.toml");
}

/// A knuckle of 10 g on tendons of at most `newtons`, 6 mm beside its joint.
fn knuckle(newtons: u32) -> String {
    let site = |name: &str, x: f64, side: f64| format!("<site name=\"{name}\" pos=\"{x} 0 {side}\"/>");
    let tendon = |name: &str, from: &str, to: &str| {
        format!("<spatial name=\"{name}\"><site site=\"{from}\"/><site site=\"{to}\"/></spatial>")
    };
    let motor = |tendon: &str| {
        format!("<motor tendon=\"{tendon}\" gear=\"{newtons}\" ctrllimited=\"true\" ctrlrange=\"-1 0\"/>")
    };
    format!(
        "<mujoco><compiler angle=\"radian\"/><worldbody>{}{}<body name=\"tip\" pos=\"0.01 0 0\"><joint \
            name=\"knuckle\" axis=\"0 1 0\" range=\"-0.7 0.7\"/><geom type=\"capsule\" fromto=\"0 0 0 0.03 0 \
            0\" size=\"0.005\" \
            mass=\"0.01\"/>{}{}</body></worldbody><tendon>{}{}</tendon><actuator>{}{}</actuator></mujoco>",
        site("a", 0.0, 0.006),
        site("b", 0.0, -0.006),
        site("c", 0.01, 0.006),
        site("d", 0.01, -0.006),
        tendon("extensor", "a", "c"),
        tendon("flexor", "b", "d"),
        motor("extensor"),
        motor("flexor"),
    )
}

#[test]
fn a_small_hand_moves_with_tendons_as_strong_as_its_file_says_and_no_stronger() {
    let bench = Bench::new();
    for newtons in [2, 20] {
        bench.write("hand.xml", knuckle(newtons));
        bench.succeeds("machine new hand.xml --out hand.toml --force");
        let shown = json(&bench, "machine show hand.toml --json");
        for muscle in shown["muscles"].as_array().unwrap() {
            let limits = muscle["tension_limits_n"].as_array().unwrap();
            let [taut, most] = [0, 1].map(|k| limits[k].as_f64().unwrap());
            assert!(taut < 1.0 && taut < 0.5 * most && most <= f64::from(newtons), "{muscle}");
        }
        bench.succeeds("track hand.toml --path tour --repeats 1 --seed 3");
    }
    let text = bench.read("hand.toml");
    assert!(text.contains("# endpoint = \"c\"") || text.contains("# endpoint = \"d\""), "{text}");
    let run = bench.run("track hand.toml --path tour --repeats 1 --payload 0.01");
    assert!(run.stderr.contains("name a site of the body as `endpoint` in [task]"), "{}", run.stderr);
    bench.succeeds("machine new hand.xml --out hand.toml --force");
    assert!(bench.succeeds("machine map hand.toml --poses 10").stdout.contains("`endpoint = \"SITE\"`"));
}

/// A palm with two fingers of two joints and one, described by their joints alone.
fn hand_of_joints() -> String {
    let link = |name: &str, mass: f64| {
        let inertia = mass * 2e-4;
        format!(
            "<link name=\"{name}\"><inertial><origin xyz=\"0.02 0 0\"/><mass value=\"{mass}\"/><inertia \
                ixx=\"{inertia}\" iyy=\"{inertia}\" izz=\"{inertia}\" ixy=\"0\" ixz=\"0\" \
                iyz=\"0\"/></inertial></link>"
        )
    };
    let joint = |name: &str, parent: &str, child: &str, y: f64| {
        format!(
            "<joint name=\"{name}\" type=\"revolute\"><parent link=\"{parent}\"/><child \
                link=\"{child}\"/><origin xyz=\"0.04 {y} 0\"/>\
             <axis xyz=\"0 1 0\"/><limit lower=\"0\" upper=\"1.4\" effort=\"1\" velocity=\"5\"/></joint>"
        )
    };
    format!(
        "<robot name=\"hand\">{}{}{}{}{}{}{}</robot>",
        "<link name=\"palm\"/>",
        link("base", 0.02),
        link("tip", 0.012),
        link("thumb", 0.015),
        joint("index_base", "palm", "base", 0.02),
        joint("index_tip", "base", "tip", 0.0),
        joint("thumb_base", "palm", "thumb", -0.02),
    )
}

/// A finger that spreads and bends in three joints; mass of its first link, kg, damping of its joints,
/// Nms/rad.
fn finger_of_joints(mass: f64, damping: f64) -> String {
    let link = |name: &str, mass: f64, length: f64| {
        let (half, inertia) = (0.5 * length, mass * length * length / 12.0 + mass * 2e-5);
        format!(
            "<link name=\"{name}\"><inertial><origin xyz=\"0 0 {half}\"/><mass value=\"{mass}\"/><inertia \
                ixx=\"{inertia}\" iyy=\"{inertia}\" izz=\"{}\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link>",
            4e-5 * mass
        )
    };
    let joint = |[name, parent, child]: [&str; 3], height: f64, axis: &str, [low, high]: [f64; 2]| {
        format!(
            "<joint name=\"{name}\" type=\"revolute\"><parent link=\"{parent}\"/><child link=\"{child}\"/>\
             <origin xyz=\"0 0 {height}\"/><axis xyz=\"{axis}\"/><dynamics damping=\"{damping}\"/>\
             <limit lower=\"{low}\" upper=\"{high}\" effort=\"1\" velocity=\"8\"/></joint>"
        )
    };
    [
        "<robot name=\"finger\"><link name=\"palm\"/>".to_owned(),
        link("side", 0.6 * mass, 0.01) + &link("first", mass, 0.0435),
        link("second", 0.6 * mass, 0.033) + &link("third", 0.36 * mass, 0.025),
        joint(["spread", "palm", "side"], 0.05, "1 0 0", [-0.5, 0.5]),
        joint(["near", "side", "first"], 0.01, "0 1 0", [-0.3, 1.3]),
        joint(["middle", "first", "second"], 0.0435, "0 1 0", [-0.3, 1.2]),
        joint(["far", "second", "third"], 0.033, "0 1 0", [-0.3, 1.1]),
        "</robot>".to_owned(),
    ]
    .concat()
}

#[test]
fn light_and_undamped_fingers_move_and_no_sensor_of_theirs_is_accused() {
    let bench = Bench::new();
    // Links that their dampers stop within a cycle; links that only their cables damp, on short stiff ones.
    for (mass, damping, pulleys) in [(0.009, 0.01, "6mm"), (0.06, 5e-4, "5mm"), (0.03, 0.0, "8mm")] {
        bench.write("finger.urdf", finger_of_joints(mass, damping));
        let new = format!("machine new finger.urdf --pulleys {pulleys} --out finger.toml --force");
        bench.succeeds(&new);
        let answer = json(&bench, "track finger.toml --repeats 1 --json");
        let numbers = &answer["tracking"]["observer"];
        assert_eq!(numbers["ended"], "as_planned", "{mass} kg, {damping} Nms/rad: {numbers}");
        assert_eq!(numbers["incidents"].as_array().map(Vec::len), Some(0), "{numbers}");
    }
}

#[test]
fn a_hand_of_joints_alone_gets_tendons_on_pulleys_and_moves() {
    let bench = Bench::new();
    bench.write("hand.urdf", hand_of_joints());
    bench.refuses("machine new hand.urdf --out hand.toml", &["muscles"]);
    for (routing, names) in [
        ("", vec!["index_base_f", "index_tip_f", "index_tip_e", "thumb_base_f", "thumb_base_e"]),
        (
            " --routing 2n",
            vec![
                "index_base_f",
                "index_base_e",
                "index_tip_f",
                "index_tip_e",
                "thumb_base_f",
                "thumb_base_e",
            ],
        ),
    ] {
        let answer = json(
            &bench,
            &format!("machine new hand.urdf --pulleys 8mm{routing} --out hand.toml --force --json"),
        );
        let muscles = answer["muscles"].as_array().unwrap();
        assert_eq!(
            muscles.iter().map(|muscle| muscle["muscle"].as_str().unwrap()).collect::<Vec<_>>(),
            names
        );
        bench.succeeds("track hand.toml --path tour --repeats 1 --seed 2");
    }
    bench.refuses("machine new hand.toml --pulleys 8mm --out again.toml", &["joints alone"]);
    bench.refuses_usage("machine new hand.urdf --pulleys 8cm --out a.toml", &["--pulleys", "8mm"]);
    bench.refuses_usage("machine new hand.urdf --routing 2n --out a.toml", &["--pulleys"]);
}

#[test]
fn a_tendon_that_nothing_pulls_is_a_spring_without_a_drive_and_turns_the_finger_back() {
    let bench = Bench::new();
    let hand = knuckle(20);
    let start = hand.find("<motor tendon=\"extensor\"").unwrap();
    let end = start + hand[start..].find("/>").unwrap() + 2;
    let cord = format!("{}{}", &hand[..start], &hand[end..]);
    let spring = "<spatial name=\"extensor\" stiffness=\"350\" springlength=\"0 0.002\">";
    bench.write("hand.xml", cord.replace("<spatial name=\"extensor\">", spring));
    let new = json(&bench, "machine new hand.xml --out hand.toml --json");
    assert_eq!(
        (&new["springs"], new["muscles"].as_array().unwrap().len()),
        (&serde_json::json!(["extensor"]), 1)
    );
    let shown = json(&bench, "machine show hand.toml --json");
    let settings = shown["settings"].as_array().unwrap();
    assert!(settings.iter().any(|row| row["table"] == "[[spring]] `extensor`" && row["value"] == 350.0));
    bench.succeeds("track hand.toml --path tour --repeats 1 --seed 3");
    // Without stiffness it exerts nothing, which is told.
    bench.write("cord.xml", &cord);
    let run = bench.run("machine show cord.xml");
    assert!(run.stderr.contains("no actuator pulls `extensor`"), "{}", run.stderr);
    // What changes forces and is not read makes no machine.
    let tied = "</tendon><equality><weld body1=\"tip\"/></equality>";
    bench.write("tied.xml", hand.replace("</tendon>", tied));
    let body = bench.run("machine body tied.xml");
    assert!(body.code == Some(0) && body.stderr.contains("<weld> is not read"), "{}", body.stderr);
    bench.refuses("machine new tied.xml --out tied.toml", &["tied.xml:1", "<weld>", "forces"]);
}

#[test]
fn a_wrong_machine_file_is_refused_with_file_line_field_and_the_nearest_name() {
    let bench = Bench::new();
    bench.succeeds("machine convert bench_joint lever.xml");
    for (text, parts) in [
        ("body = \"leaver.xml\"\n", ["m.toml:1:", "leaver.xml", "cannot be read"]),
        ("body = \"lever.xml\"\n[payload]\nmass_kg = -1\n", ["m.toml:3:", "mass_kg is -1", ">= 0"]),
        ("body = \"lever.xml\"\n[[transmission]]\nmuscle = \"frond\"\n", ["m.toml:3:", "frond", "`front`"]),
        ("body = \"lever.xml\"\n[controls]\nmargin = 1\n", ["m.toml:2:", "`controls`", "`control`"]),
        ("body = \"lever.xml\"\nstart = { lever = nan }\n", ["m.toml:2:", "lever is nan", "finite"]),
    ] {
        bench.write("m.toml", text);
        bench.refuses("machine show m.toml", &parts);
    }
    // A verb about robots reads of a machine file what concerns the robot.
    bench.write("m.toml", "body = \"lever.xml\"\n[[travel]]\njoint = \"lever\"\nrange_rad = [-9.0, 1.0]\n");
    bench.refuses("machine body m.toml", &["m.toml:4:", "range_rad is [-9.0, 1.0]", "-1.2 to 1.2"]);
    bench.refuses("machine show fingr", &["fingr", "finger"]);
    bench.refuses("machine show finger --muscles lever.xml", &["finger", "--muscles"]);
}

#[test]
fn gains_follow_for_every_built_in_machine_and_for_one_with_chosen_drives_and_are_read_again() {
    let bench = Bench::new();
    for (name, _) in MACHINES {
        bench.run(&format!("machine new {name} --out chosen.toml --force"));
        for machine in [name, "chosen.toml"] {
            let tuned = json(&bench, &format!("machine tune {machine} --specimens 2 --json"));
            for muscle in tuned["muscles"].as_array().unwrap() {
                assert!(muscle["max_winch_speed_m_per_s"].as_f64().unwrap() > 0.0, "{machine}");
                assert!(muscle["phase_margin_deg"].as_f64().unwrap() > 10.0, "{machine}: {muscle}");
            }
            assert!(tuned["joints"].as_array().unwrap().iter().all(|joint| joint["limited_by"].is_string()));
        }
    }
    bench.succeeds("machine tune finger --out gains.json");
    let motion = "--path to-joints:base_flexion=0.5 --duration 3 --hold 0";
    bench.succeeds(&format!("track finger {motion} --gains gains.json"));
    bench.refuses(&format!("track shoulder {motion} --gains gains.json"), &["base_flexion"]);
    bench.refuses("track shoulder --gains gains.json", &["gains of muscles", "8", "5"]);
    bench.write("gains.json", "{\"damping\": 1, \"dampings\": 2}");
    bench.refuses("track finger --gains gains.json", &["gains.json", "line 1", "dampings"]);
}

#[test]
fn a_tuning_report_shows_picture_margins_limits_and_rules_and_leaves_the_json_as_it_is() {
    let bench = Bench::new();
    let plain = bench.run("machine tune finger --specimens 2 --json");
    let run = bench.run("machine tune finger --specimens 2 --report tuned.html --json");
    let written = r#""written":[{"file":"tuned.html","replaced":false}]"#;
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert_eq!(run.stdout.replace(written, r#""written":[]"#), plain.stdout);
    let page = bench.read("tuned.html");
    for words in [
        "in its start pose",
        "What limits each joint",
        "A finer encoder (1.0",
        "Margins of the damping",
        "t_d,k = min(0.15 s, c/Om_k^2)",
        "rest_tolerance_m",
    ] {
        assert!(page.contains(words), "{words}");
    }
    assert!(
        !page.contains("http://")
            || page.matches("http://").count() == page.matches("http://www.w3.org/").count()
    );
    bench.refuses("machine tune finger --report a.html --out a.html", &["a.html"]);
    bench.write("leg.toml", "body = \"x.xml\"\n");
    bench.refuses("machine tune leg.toml --report leg.toml", &["leg.toml", "it is read by this run"]);
    let json: Value = serde_json::from_str(&plain.stdout).unwrap();
    let joint = &json["joints"][0];
    let changes = joint["changes"].as_array().unwrap();
    let helps: Vec<&str> = changes
        .iter()
        .filter(|change| change["helps"] == true)
        .map(|change| change["change"].as_str().unwrap())
        .collect();
    assert_eq!(helps, ["finer encoder"], "{joint}");
}

#[test]
fn every_built_in_machine_is_drawn_with_its_cables() {
    let bench = Bench::new();
    for (name, _) in MACHINES {
        bench.succeeds(&format!("machine show {name} --picture machine.svg"));
        let svg = bench.read("machine.svg");
        let ends = svg.matches("stroke-width=\"3\"").count();
        assert!(svg.contains(&format!(">{name}</text>")) && ends == 1 && svg.ends_with("</svg>\n"), "{name}");
        assert!(!svg.contains("NaN") && !svg.contains("inf") && svg.len() < 20_000, "{name}");
    }
    bench.write("leg.toml", "body = \"x.xml\"\n");
    bench.refuses("machine show leg.toml --picture leg.toml", &["leg.toml", "it is read by this run"]);
    let refused = bench.run("machine show lm_arm --picture arm.pdf");
    assert_eq!(refused.code, Some(2));
    assert!(refused.stderr.contains("a name that ends in .svg"), "{}", refused.stderr);
}

#[test]
fn a_motion_that_simulated_machines_of_the_design_do_not_track_is_refused_unless_asked_for() {
    let bench = Bench::new();
    // Anchors nearer to the drum than the tolerance of the attachments: sampled machines lose a wrap, and the
    // lever.
    let text = sinew_models::BENCH_JOINT;
    let near = text
        .replace("[-0.000119, 0.0, -0.0319998]", "[0.005201, 0.0, -0.0301548]")
        .replace("[0.000119, 0.0, -0.0319998]", "[-0.005201, 0.0, -0.0301548]");
    std::fs::write(bench.path("near.toml"), near).unwrap();
    let refused = bench.run("track near.toml --path tour --duration 12 --json --report out.html");
    assert_eq!(refused.code, Some(3), "{}", refused.stderr);
    let json: Value = serde_json::from_str(&refused.stdout).unwrap();
    assert_eq!(json["outcome"], "not_as_asked");
    let reason = json["error"]["message"].as_str().unwrap();
    assert!(reason.contains("--path tour") && reason.contains("--unverified"), "{reason}");
    assert!(reason.contains("lever") || reason.contains("slack"), "what a lost wrap leads to: {reason}");
    assert!(!bench.path("out.html").exists());
    let started = bench.run("track near.toml --path tour --duration 12 --unverified --json --seed 500");
    assert!(started.stderr.contains("warning: simulated machines"), "{}", started.stderr);
    let json: Value = serde_json::from_str(&started.stdout).unwrap();
    assert!(json["tracking"]["observer"]["ended"].is_string(), "{json}");
}
