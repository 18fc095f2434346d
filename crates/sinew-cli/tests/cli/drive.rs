//! Drives for a cable: selected, listed, and refused.

use crate::bench::Bench;

const REQUIRED: &str = "design drive --tension 250 --speed 0.14 --acceleration 3 --stroke 0.3";
const OURS: &str = sinew_models::MOTORS;

#[test]
fn the_papers_drive_is_among_those_that_can_and_the_lightest_comes_first() {
    let run = Bench::new().run(&format!("{REQUIRED} --json"));
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let result: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
    let choices = result["choices"].as_array().unwrap();
    let able: Vec<_> = choices.iter().take_while(|choice| choice["meets"] == true).collect();
    let mass = |choice: &serde_json::Value| choice["mass_kg"].as_f64().unwrap();
    assert!(able.windows(2).all(|pair| mass(pair[0]) <= mass(pair[1])));
    let ours = able.iter().find(|c| c["motor"] == "class_35mm_120w" && c["reducer"] == "class_53").unwrap();
    assert_eq!(ours["winch"], "drum_15mm");
    assert!(ours["max_acceleration_m_per_s2"].as_f64().unwrap() > 3.0);
    let envelope = ours["envelope"].as_array().unwrap();
    let pulls = |point: &serde_json::Value, which: &str| point[which].as_f64().unwrap();
    assert!(envelope.iter().all(|point| pulls(point, "continuous_n") <= pulls(point, "peak_n")));
}

#[test]
fn the_terminal_shows_a_table_and_the_envelope_of_the_first() {
    let bench = Bench::new();
    bench.write("parts.toml", OURS);
    let run = bench.run(&format!("{REQUIRED} --catalogue parts.toml"));
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    for part in ["pairs of motor and reducer meet the requirement", "nearest limit", "Envelope of", "heat"] {
        assert!(run.stdout.contains(part), "{part}: {}", run.stdout);
    }
}

#[test]
fn a_wrong_number_is_named_with_its_file_line_or_flag() {
    let bench = Bench::new();
    bench.write("parts.toml", OURS.replace("efficiency = 0.81", "efficiency = 1.81"));
    let line = 1 + OURS.lines().position(|line| line.starts_with("efficiency = 0.81")).unwrap();
    let run = bench.run(&format!("{REQUIRED} --catalogue parts.toml"));
    assert_eq!(run.code, Some(2));
    for part in [&*format!("parts.toml:{line}:"), "maxon_gp42c_2", "efficiency", "(0, 1]", "1.81"] {
        assert!(run.stderr.contains(part), "{part}: {}", run.stderr);
    }
    bench.refuses_usage(&REQUIRED.replace("--tension 250", "--tension nan"), &["'nan' for '--tension"]);
}

#[test]
fn a_requirement_that_no_drive_meets_is_answered_and_ends_with_a_code_of_its_own() {
    let run = Bench::new().run("design drive --tension 100000 --speed 1 --acceleration 1 --stroke 0.1");
    assert_eq!(run.code, Some(3), "{}", run.stderr);
    assert!(run.stdout.starts_with("0 of "), "{}", run.stdout);
}
