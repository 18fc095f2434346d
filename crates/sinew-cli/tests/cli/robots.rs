//! Robots: looked at, evaluated, converted, and refused.

use crate::bench::Bench;

#[test]
fn the_embedded_arm_converts_and_evaluates_the_same_in_every_format() {
    let bench = Bench::new();
    bench.write("poses.csv", "elbow_flexion,shoulder_flexion\n0.5,0.2\n1.5,-0.3\n");
    let mut results = Vec::new();
    for (model, file) in [("lm_arm", "arm.xml"), ("arm.xml", "arm.toml"), ("arm.toml", "again.xml")] {
        assert_eq!(bench.run(&format!("arm convert {model} {file}")).code, Some(0));
        let run = bench.run(&format!("arm evaluate {file} --poses poses.csv"));
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
    let run = bench.run("arm inspect lm_arm --report arm.html");
    assert!(run.stdout.contains("deltoid_anterior") && run.stdout.contains("7 joints"), "{}", run.stdout);
    assert!(bench.read("arm.html").contains("moment arms") || bench.read("arm.html").contains("Moment arms"));
}

#[test]
fn bad_robots_and_poses_are_refused_with_their_place() {
    let bench = Bench::new();
    bench.write("out.xml", "<mujoco>\n<include file=\"../secret.xml\"/></mujoco>");
    bench.write("circle.xml", "<mujoco>\n<include file=\"circle.xml\"/></mujoco>");
    bench.write("unit.toml", "[[body]]\nname = \"b\"\nmass_g = 1\n");
    bench.write("poses.csv", "elbow_flexion\nfar\n");
    bench.write("names.csv", "elbow\n1\n");
    for (arguments, words) in [
        ("arm inspect out.xml", ["out.xml:2", "outside"]),
        ("arm inspect circle.xml", ["circle.xml", "included already"]),
        ("arm inspect unit.toml", ["unit.toml:3", "mass_g"]),
        ("arm inspect robot.step", ["robot.step", ".toml"]),
        ("arm evaluate lm_arm --poses poses.csv", ["line 2", "`far`"]),
        ("arm evaluate lm_arm --poses names.csv", ["line 1", "`elbow`"]),
    ] {
        bench.refuses(arguments, &words);
    }
}
