//! Machines whose control cycle is not a millisecond long, through every door.

use crate::bench::Bench;
use crate::link::{Running, advance};
use serde_json::Value;
use sinew_link::{Command, Mode, Request, Setpoints};

/// A built-in machine with a period in its file.
fn machine(bench: &Bench, name: &str, period: &str) {
    let path = format!("{}/../../models/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).unwrap();
    let (before, after) = text.split_once("gravity_m_per_s2").unwrap();
    bench.write("machine.toml", format!("{before}period_s = {period}\ngravity_m_per_s2{after}"));
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

#[test]
fn a_machine_at_two_and_four_milliseconds_tracks_and_its_errors_stay_near_those_at_one() {
    let bench = Bench::new();
    let mut at_one = f64::NAN;
    for (period, most) in [("0.001", 1.0), ("0.002", 1.5), ("0.004", 2.5), ("0.0005", 1.2)] {
        machine(&bench, "bench_joint", period);
        let run = json(&bench.succeeds("track machine.toml --unverified --json").stdout);
        let tracking = &run["tracking"]["observer"];
        assert_eq!(tracking["ended"], "as_planned", "{period}");
        let mean = tracking["joint_error_rad"]["mean"].as_f64().unwrap();
        at_one = if at_one.is_nan() { mean } else { at_one };
        assert!(mean <= most * at_one, "{period}: {mean} {at_one}");
    }
}

#[test]
fn healthy_load_cells_of_light_machines_are_not_reported_in_long_cycles() {
    let bench = Bench::new();
    for (name, period) in [("spring_finger", "0.004"), ("finger", "0.004"), ("surgical_wrist", "0.01")] {
        machine(&bench, name, period);
        let run = bench.succeeds("track machine.toml --unverified --duration 25 --repeats 1 --seed 1 --json");
        let tracking = &json(&run.stdout)["tracking"]["observer"];
        assert_eq!(tracking["ended"], "as_planned", "{name}");
        assert_eq!(tracking["incidents"].as_array().map(Vec::len), Some(0), "{name}: {tracking}");
    }
}

#[test]
fn a_period_outside_of_its_range_is_refused_with_file_line_key_and_value() {
    let bench = Bench::new();
    for wrong in ["0.0004", "0.021", "0.0", "-0.001", "\"1 ms\"", "nan"] {
        machine(&bench, "bench_joint", wrong);
        let refused = bench.run("machine show machine.toml");
        assert_eq!(refused.code, Some(2), "{wrong}: {}", refused.stderr);
        let line =
            bench.read("machine.toml").lines().position(|line| line.starts_with("period_s")).unwrap() + 1;
        for part in [&format!("machine.toml:{line}"), "period_s", wrong, "a number in [0.0005, 0.02]"] {
            assert!(refused.stderr.contains(part), "{wrong}: {part}: {}", refused.stderr);
        }
    }
}

#[test]
fn a_recording_at_two_milliseconds_says_its_period_and_is_replayed_to_the_bit_on_twin_and_segment() {
    let bench = Bench::new();
    machine(&bench, "bench_joint", "0.002");
    for bus in ["twin", "segment"] {
        let run =
            format!("run machine.toml --unverified --virtual-time --bus {bus} --record {bus}.mcap --json");
        let run = json(&bench.succeeds(&run).stdout);
        assert_eq!(run["tracking"]["observer"]["ended"], "as_planned", "{bus}");
        let replayed = json(&bench.succeeds(&format!("log replay {bus}.mcap --json")).stdout);
        assert_eq!(replayed["reproduced"], true, "{bus}: {replayed}");
        let shown = json(&bench.succeeds(&format!("log info {bus}.mcap --json")).stdout);
        let [cycles, duration] = ["cycles", "duration_s"].map(|key| shown[key].as_f64().unwrap());
        assert!((duration - 0.002 * cycles).abs() < 1e-6, "{bus}: {shown}");
    }
}

#[test]
fn a_client_drives_a_machine_at_four_milliseconds_in_lock_step() {
    let bench = Bench::new();
    machine(&bench, "planar_leg", "0.004");
    let file = bench.path("machine.toml");
    let running = Running::new(file.to_str().unwrap(), "--virtual-time --until 0.6");
    let mut client = running.connect();
    let (mode, joints) = advance(&mut client, Request::Run, Setpoints::none(), 400_000_000);
    assert_eq!((mode, joints.len()), (Mode::Run, 2));
    assert_eq!(client.session().welcome().period_ns, 4_000_000);
    assert!(client.session().welcome().state_period_ns.is_multiple_of(4_000_000));
    let to_the_end =
        Command { request: Request::Run, advance_to_ns: 1_000_000_000, setpoints: Setpoints::none() };
    client.send(&to_the_end).unwrap();
    assert_eq!(running.end()["outcome"], "done");
}
