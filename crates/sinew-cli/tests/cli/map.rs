//! `sinew machine map`.

use crate::bench::Bench;

#[test]
fn a_map_has_a_table_a_report_and_every_pose_as_json() {
    let bench = Bench::new();
    let run = bench.run("machine map planar_leg --poses 40 --report map.html");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    for words in [
        "payload lifted",
        "knee: torque +",
        "limited by",
        "hamstrings",
        "heat of its motor",
        "more continuous torque",
        "Written: map.html",
    ] {
        assert!(run.stdout.contains(words), "{words}: {}", run.stdout);
    }
    let page = bench.read("map.html");
    for words in [
        "computed from the design",
        "Forces of the end point at the start",
        "lowering",
        "exp(2A)",
        "Payload by time",
    ] {
        assert!(page.contains(words), "{words}");
    }
    let run = bench.run("machine map planar_leg --poses 40 --json");
    let map: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
    let poses = map["poses"].as_array().unwrap();
    assert_eq!((poses.len(), map["joints"].as_array().unwrap().len()), (40, 2));
    for pose in poses {
        let payload = &pose["end_point"]["payload_kg"];
        let [lifted, held, lowered] =
            ["lifted", "held", "lowered"].map(|state| payload[state]["value"].as_f64().unwrap());
        let held = held * (1.0 - 1e-9);
        assert!(held <= lifted && held <= lowered, "{payload}");
        assert!(pose["end_point"]["stiffness_n_per_m"][0].as_f64().unwrap() > 0.0);
    }
    let held = map["payload"]["held"].as_array().unwrap();
    let median = |k: usize| held[k]["median_kg"].as_f64().unwrap();
    assert!(
        held.len() == 4 && held[3]["seconds"].is_null() && median(3) < median(2) && median(2) < median(0)
    );
    assert_eq!(held[3]["of_poses_kg"].as_array().unwrap().len(), 40);
    let raised = map["payload"]["raised"].as_array().unwrap();
    let cooler = raised.iter().find(|one| one["change"] == "more continuous torque").unwrap();
    assert!(cooler["continuous_kg"].as_f64().unwrap() > 1.3 * median(3), "{cooler}");
    assert_eq!(run.stdout, bench.run("machine map planar_leg --poses 40 --json").stdout);
}

/// A mass on a slide between two cables, without gravity where it is 0.
fn slide(gravity: f64) -> String {
    format!(
        "<mujoco model=\"slide\"><option gravity=\"0 0 {gravity}\"/><worldbody><site name=\"o1\" pos=\"0 0 \
            .3\"/><site name=\"o2\" pos=\"0 0 -.3\"/><body name=\"a\"><joint name=\"lift\" type=\"slide\" \
            axis=\"0 0 1\" range=\"-.05 .05\"/><geom type=\"sphere\" size=\".03\" mass=\".3\"/><site \
            name=\"endpoint\"/></body></worldbody><tendon><spatial name=\"up\"><site site=\"o1\"/><site \
            site=\"endpoint\"/></spatial><spatial name=\"down\"><site site=\"o2\"/><site \
            site=\"endpoint\"/></spatial></tendon></mujoco>"
    )
}

/// Two hinges, the second of which follows the first, with cables that are sums of joint angles.
const COUPLED: &str = "<mujoco model=\"coupled\"><worldbody><body name=\"a\"><joint name=\"base\" axis=\"0 1 \
    0\" range=\"-40 40\"/><geom type=\"capsule\" size=\".01\" fromto=\"0 0 0 .1 0 0\" mass=\".1\"/><body \
    name=\"b\" pos=\".1 0 0\"><joint name=\"tip\" axis=\"0 1 0\" range=\"-40 40\"/><geom type=\"capsule\" \
    size=\".01\" fromto=\"0 0 0 .1 0 0\" mass=\".1\"/></body></body></worldbody><equality><joint \
    joint1=\"tip\" joint2=\"base\" polycoef=\"0 .7 0 0 0\"/></equality><tendon><fixed name=\"up\"><joint \
    joint=\"base\" coef=\".02\"/></fixed><fixed name=\"down\"><joint joint=\"base\" \
    coef=\"-.02\"/></fixed></tendon></mujoco>";

#[test]
fn body_files_alone_with_a_slide_a_coupling_or_no_gravity_are_mapped_tuned_and_shown() {
    let bench = Bench::new();
    let no_payload = "No payload: ";
    for (name, text, payload) in [
        ("slide.xml", slide(-9.81), "Payload held from room temperature"),
        ("floating.xml", slide(0.0), no_payload),
        ("coupled.xml", COUPLED.to_owned(), no_payload),
    ] {
        bench.write(name, &text);
        let run = bench.run(&format!("machine map {name} --poses 20 --report map.html"));
        assert_eq!(run.code, Some(0), "{name}: {}", run.stderr);
        assert!(run.stdout.contains(payload) && !run.stdout.contains("NaN"), "{name}: {}", run.stdout);
        let run = bench.run(&format!("machine tune {name} --specimens 2 --report tune.html"));
        assert_eq!(run.code, Some(0), "{name}: {}", run.stderr);
        assert!(run.stdout.contains("would"), "{name}: {}", run.stdout);
        let run = bench.run(&format!("machine show {name} --picture machine.svg"));
        assert_eq!(run.code, Some(0), "{name}: {}", run.stderr);
        for file in ["map.html", "tune.html", "machine.svg"] {
            assert!(!bench.read(file).contains("NaN"), "{name}: {file}");
        }
    }
}

#[test]
fn machines_without_an_end_point_or_gravity_are_mapped_by_their_joints() {
    let bench = Bench::new();
    for (machine, words) in [("bench_joint", "lever: torque +"), ("surgical_wrist", "roll: stiffness")] {
        let run = bench.run(&format!("machine map {machine} --poses 20 --report {machine}.html"));
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        assert!(run.stdout.contains(words) && !run.stdout.contains("payload lifted"), "{}", run.stdout);
    }
    bench.refuses_usage("machine map finger --poses 3", &["'3' for '--poses", "10..=20000"]);
    bench.refuses("machine map nothing.toml", &["nothing.toml", "cannot be read"]);
    bench.write("body.toml", "name = \"x\"\n");
    bench.refuses("machine map body.toml --report body.toml", &["body.toml", "it is read by this run"]);
}
