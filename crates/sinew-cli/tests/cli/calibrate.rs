//! `sinew calibrate` and what uses its calibration.

use crate::bench::Bench;
use serde_json::Value;

const FLIGHT: &str = "calibrate planar_leg --tolerances rough --poses 8 --check 3 --out out";

#[test]
fn a_rough_leg_is_better_after_a_flight_and_its_tables_are_fitted_again() {
    let bench = Bench::new();
    let run = bench.run(&format!("{FLIGHT} --json"));
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let flown: Value = serde_json::from_str(&run.stdout).unwrap();
    let mean = |document: &Value, when: &str| document["held_out_error_m"][when]["mean"].as_f64().unwrap();
    assert!(mean(&flown, "after") < 0.5 * mean(&flown, "before"), "{}", flown["held_out_error_m"]);
    let keys: Vec<&String> = flown["parameters"][0].as_object().unwrap().keys().collect();
    assert_eq!(keys, ["name", "value", "sd", "tolerance", "determined"]);
    let held: Vec<&String> = flown["held_out_error_m"].as_object().unwrap().keys().collect();
    assert_eq!(held, ["before", "after", "reported"]);

    let fit =
        "calibrate fit planar_leg out/readings.csv --observations out/observations.csv --tolerances rough";
    let run = bench.run(&format!("{fit} --out fitted --json"));
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let fitted: Value = serde_json::from_str(&run.stdout).unwrap();
    assert!(mean(&fitted, "after") < 0.5 * mean(&fitted, "before") && fitted["simulated"] == true);

    let track = "track planar_leg --tolerances rough --unverified --calibration out/calibration.toml";
    let run = bench.run(&format!("{track} --record run.mcap"));
    assert!(matches!(run.code, Some(0 | 3)), "{}", run.stderr);
    let run = bench.run("log replay run.mcap --json");
    assert_eq!(run.code, Some(0), "{} {}", run.stdout, run.stderr);

    let other = bench.run("track finger --calibration out/calibration.toml");
    assert_eq!(other.code, Some(2));
    assert!(other.stderr.contains("machine_hash"), "{}", other.stderr);
}

#[test]
fn what_cannot_be_calibrated_is_refused_by_its_reason() {
    let bench = Bench::new();
    let fit = "calibrate fit planar_leg readings.csv --observations seen.csv --tolerances rough --out out";
    bench.write("readings.csv", "time_s,hip,knee\n0,0.1,0.2\n1,0.1,0.2\n");
    bench.write("seen.csv", "time_s,marker,x_m,y_m,z_m\n0,nose,1,2,3\n");
    let run = bench.run(fit);
    assert_eq!(run.code, Some(2));
    assert!(run.stderr.contains("seen.csv") && run.stderr.contains("nose"), "{}", run.stderr);
    let run = bench.run("calibrate planar_leg --camera-fault fog=1 --tolerances rough --out out");
    assert!(run.code == Some(2) && run.stderr.contains("noise_m"), "{}", run.stderr);
    let run = bench.run("calibrate planar_leg --marker nose=face:0,0,0 --tolerances rough --out out");
    assert!(run.code == Some(2) && run.stderr.contains("body of the machine"), "{}", run.stderr);
}
