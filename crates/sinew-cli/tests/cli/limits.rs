//! Tension limits of a body's actuators, and sheaths that survive conversion.

use crate::bench::Bench;
use serde_json::Value;

/// The bench's joint as a robot file whose motors allow at most `most` N.
fn robot(bench: &Bench, most: f64) {
    bench.succeeds("machine convert bench_joint body.toml");
    let text = bench.read("body.toml");
    let names: Vec<String> = {
        let document: Value =
            serde_json::from_str(&bench.succeeds("machine body body.toml --json").stdout).unwrap();
        let muscles = document["muscles"].as_array().unwrap();
        muscles.iter().map(|muscle| muscle["name"].as_str().unwrap().to_owned()).collect()
    };
    let actuator = |name: &String| {
        format!(
            "\n[[actuator]]\nname = \"motor_{name}\"\nmuscle = \"{name}\"\nkind = \"motor\"\ngear = \
                -1.0\ncontrol_range = [0.0, {most:?}]\n"
        )
    };
    bench.write("limited.toml", text + &names.iter().map(actuator).collect::<String>());
}

#[test]
fn tensions_stay_within_the_control_ranges_of_the_motors() {
    let bench = Bench::new();
    robot(&bench, 60.0);
    let shown: Value = serde_json::from_str(&bench.run("machine show limited.toml --json").stdout).unwrap();
    for muscle in shown["muscles"].as_array().unwrap() {
        assert!((muscle["tension_limits_n"][1].as_f64().unwrap() - 60.0).abs() < 1e-9, "{muscle}");
    }
    let setting =
        shown["settings"].as_array().unwrap().iter().find(|row| row["key"] == "tension_limits_n").unwrap();
    assert_eq!((&setting["source"], &setting["value"][1]), (&"body".into(), &60.0.into()), "{setting}");
}

#[test]
fn a_motor_that_cannot_keep_its_cable_taut_is_refused_before_the_motion() {
    let bench = Bench::new();
    robot(&bench, 1.0);
    let run = bench.run("track limited.toml --path tour --repeats 1");
    assert_eq!(run.code, Some(3), "{}{}", run.stdout, run.stderr);
    assert!(run.stderr.contains("may pull at most 1") && run.stderr.contains("taut"), "{}", run.stderr);
}

#[test]
fn sheaths_go_to_mjcf_and_come_back() {
    let bench = Bench::new();
    bench.succeeds("machine convert lm_arm one.toml");
    bench.succeeds("machine convert one.toml two.xml");
    assert!(bench.read("two.xml").contains("<numeric name=\"sheath:"));
    bench.succeeds("machine convert two.xml three.toml");
    let sheaths = |file: &str| -> Vec<String> {
        bench.read(file).lines().filter(|line| line.starts_with("sheath = ")).map(str::to_owned).collect()
    };
    assert_eq!(sheaths("one.toml"), sheaths("three.toml"));
    assert_eq!(sheaths("one.toml").len(), 15);
    bench.write("bad.xml", bench.read("two.xml").replace("sheath:brachialis", "sheath:nobody"));
    bench.refuses("machine body bad.xml", &["bad.xml", "sheath", "`nobody`", "tendon"]);
}
