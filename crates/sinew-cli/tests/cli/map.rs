//! `sinew machine map`.

use crate::bench::Bench;

#[test]
fn a_map_has_a_table_a_report_and_every_pose_as_json() {
    let bench = Bench::new();
    let run = bench.run("machine map planar_leg --poses 40 --report map.html");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    for words in ["payload lifted", "knee: torque +", "limited by", "hamstrings", "Written: map.html"] {
        assert!(run.stdout.contains(words), "{words}: {}", run.stdout);
    }
    let page = bench.read("map.html");
    for words in ["computed from the design", "Forces of the end point at the start", "lowering", "exp(2A)"] {
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
    assert_eq!(run.stdout, bench.run("machine map planar_leg --poses 40 --json").stdout);
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
