//! `sinew live`, and `--page` of runs.

use crate::bench::Bench;
use serde_json::Value;

const MOTION: &str = "planar_leg --path to-joints:hip=0.4,knee=1.0 --duration 2 --hold 0.3 --unverified";
/// A page on a free port.
const PAGE: &str = "--page --bind 127.0.0.1:0";

#[test]
fn a_recording_is_shown_with_another_one_over_it() {
    let bench = Bench::new();
    bench.succeeds(&format!("run {MOTION} --virtual-time --record a.mcap"));
    bench.succeeds(&format!("run {MOTION} --virtual-time --seed 2 --record b.mcap"));
    let bytes = std::fs::read(bench.path("a.mcap")).unwrap();
    // By its contents, whatever it is called.
    bench.write("renamed", &bytes);
    for arguments in ["a.mcap --overlay b.mcap", "renamed"] {
        let shown = bench.run(&format!("live {arguments} --bind 127.0.0.1:0 --until 0.3 --json"));
        assert_eq!(shown.code, Some(0), "{}", shown.stderr);
        assert!(
            shown.stderr.contains("recording of a SIMULATED machine on http://127.0.0.1:"),
            "{}",
            shown.stderr
        );
        let document: Value = serde_json::from_str(&shown.stdout).unwrap();
        assert_eq!((&document["simulated"], &document["ended"]), (&true.into(), &"as_planned".into()));
    }
    bench.write("cut.mcap", &bytes[..bytes.len() * 2 / 3]);
    let cut = bench.run("live cut.mcap --bind 127.0.0.1:0 --until 0.1");
    assert_eq!(cut.code, Some(0), "{}", cut.stderr);
    assert!(cut.stderr.contains("cut.mcap: The recording was cut short"), "{}", cut.stderr);
}

#[test]
fn what_is_no_recording_or_of_another_machine_is_refused() {
    let bench = Bench::new();
    bench.write("empty.mcap", "");
    bench.write("text.mcap", "time_s,tension_n\n0,1\n");
    bench.refuses("live empty.mcap", &["empty.mcap", "byte 0: expected an MCAP file"]);
    bench.refuses("live text.mcap", &["text.mcap", "byte 0: expected an MCAP file"]);
    bench.refuses("live nowhere.mcap", &["nowhere.mcap", "cannot be read"]);
    bench.refuses("live planar_leg --overlay text.mcap", &["--overlay text.mcap", "beside a recording"]);
    bench.succeeds(&format!("run {MOTION} --virtual-time --record leg.mcap"));
    let joint = bench
        .succeeds("run bench_joint --path tour --repeats 1 --duration 4 --virtual-time --record joint.mcap");
    // A machine without an end point is judged by its joints.
    assert!(joint.stdout.contains("mean joint error, mrad"), "{}", joint.stdout);
    assert!(!joint.stdout.contains("- mm"), "{}", joint.stdout);
    bench.refuses(
        "live leg.mcap --overlay joint.mcap",
        &["--overlay joint.mcap", "with the same muscles and joints", "bench_joint"],
    );
    let outcome = bench.run(&format!("run {MOTION} --open"));
    assert_eq!(outcome.code, Some(2), "{}", outcome.stderr);
    assert!(outcome.stderr.contains("--page"), "{}", outcome.stderr);
}

#[test]
fn results_are_the_same_with_and_without_a_page() {
    let bench = Bench::new();
    let motion = "bench_joint --path to-joints:lever=0.4 --duration 2 --hold 0.3 --unverified --json";
    let alone = bench.succeeds(&format!("track {motion}")).stdout;
    let shown = bench.run(&format!("track {motion} {PAGE}"));
    assert_eq!(shown.code, Some(0), "{}", shown.stderr);
    assert!(shown.stderr.contains("SIMULATED machine on http://127.0.0.1:"), "{}", shown.stderr);
    assert_eq!(alone, shown.stdout);
    let run = format!("run {motion} --virtual-time");
    for bus in ["twin", "segment"] {
        let alone = bench.succeeds(&format!("{run} --bus {bus}")).stdout;
        let shown = bench.run(&format!("{run} --bus {bus} {PAGE}"));
        assert_eq!((shown.code, alone), (Some(0), shown.stdout), "{bus}: {}", shown.stderr);
    }
}
