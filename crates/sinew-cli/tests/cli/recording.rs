//! `sinew run --record`, `sinew log` and `sinew log replay`.

use crate::bench::Bench;
use serde_json::Value;
use std::process::Command;

const RUN: &str = "run planar_leg --path to-joints:hip=0.4,knee=1.0 --duration 3 --hold 1 --virtual-time";

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

#[test]
fn a_recorded_run_is_shown_exported_drawn_and_replayed() {
    let bench = Bench::new();
    let plain = json(&bench.succeeds(&format!("{RUN} --json")).stdout);
    let run = json(&bench.succeeds(&format!("{RUN} --json --record run.mcap")).stdout);
    assert_eq!(plain["tracking"], run["tracking"], "recording changes nothing");
    assert_eq!(run["recording"]["cycles"], 7000);
    assert_eq!(run["recording"]["dropped"], 0);
    assert_eq!(run["written"][0]["file"], "run.mcap");

    let info = json(&bench.succeeds("log info run.mcap --json").stdout);
    assert_eq!((&info["cycles"], &info["complete"]), (&Value::from(7000), &Value::from(true)));
    assert_eq!(info["attachments"][0]["name"], "machine/0-planar_leg");

    let replay = json(&bench.succeeds("log replay run.mcap --json").stdout);
    assert_eq!((&replay["reproduced"], &replay["cycles"]), (&Value::from(true), &Value::from(7000)));

    bench.succeeds("log export run.mcap --out all.csv");
    let table = bench.read("all.csv");
    assert_eq!(table.lines().count(), 7001);
    assert!(table.starts_with("time_s,deadline_us,"), "{table:.80}");
    let export = "log export run.mcap --out cable.csv --muscle hamstrings --json";
    assert_eq!(json(&bench.succeeds(export).stdout)["empty_columns"], serde_json::json!([]));
    let identified = bench.succeeds("identify cable.csv --far tension_out_n --dry-run");
    assert!(identified.stdout.contains("tension_in_n"), "{}", identified.stdout);

    bench.succeeds("log plot run.mcap --report run.html");
    bench.succeeds("log plot run.mcap --report again.html");
    assert_eq!(bench.read("run.html"), bench.read("again.html"));
    assert!(bench.read("run.html").contains("Tensions at the anchors"));
    assert!(
        bench.read("run.html").contains("Modes and faults")
            && bench.read("run.html").contains("<td>run</td>")
    );
    bench.succeeds("log layout run.mcap --out layout.json");
    let layout = json(&bench.read("layout.json"));
    assert_eq!(layout["layout"]["first"], "3D!machine");

    // A program of the container's makers, where it is installed.
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/../sinew-record/tests/read_with_python.py");
    let folder = bench.path("run.mcap");
    let folder = folder.parent().unwrap();
    let python = std::env::var("SINEW_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let installed = Command::new(&python).args(["-c", "import mcap, mcap_protobuf"]).output();
    if installed.is_ok_and(|output| output.status.success()) {
        let read = Command::new(&python).args([script, "run.mcap", "all.csv"]).current_dir(folder).output();
        let read = read.unwrap();
        assert!(read.status.success(), "{}", String::from_utf8_lossy(&read.stderr));
    } else {
        eprintln!("skipped: {python} has no packages mcap and mcap-protobuf-support");
    }
}

#[test]
fn other_gains_show_what_they_would_have_commanded() {
    let bench = Bench::new();
    bench.succeeds(&format!("{RUN} --record run.mcap"));
    bench.succeeds("machine tune planar_leg --out gains.json");
    let replay =
        json(&bench.succeeds("log replay run.mcap --gains gains.json --report r.html --json").stdout);
    assert_eq!(replay["reproduced"], true);
    let muscles = replay["other_controller"].as_array().unwrap();
    assert!(muscles.iter().all(|muscle| muscle["max"].as_f64().unwrap() > 0.0), "{replay}");
    assert!(bench.read("r.html").contains("other controller"));
    let same = json(&bench.succeeds("log replay run.mcap --machine planar_leg --json").stdout);
    assert!(same["other_controller"].is_array());
    let refused = bench.run("log replay run.mcap --machine finger");
    assert_eq!(refused.code, Some(2));
    assert!(refused.stderr.contains("as many muscles"), "{}", refused.stderr);
}

#[test]
fn a_bag_is_whole_or_not_there_and_replaces_nothing() {
    let bench = Bench::new();
    bench.succeeds(&format!("{RUN} --record run.mcap"));
    let said = json(&bench.succeeds("log export run.mcap --to ros2 --out bag --json").stdout);
    assert_eq!((&said["topics"]["/tf"], &said["topics"]["/sinew/muscles"]), (&350.into(), &350.into()));
    bench.succeeds("log export run.mcap --to ros2 --out again --every 20");
    let bytes = |file: &str| std::fs::read(bench.path(file)).unwrap();
    assert_eq!(bytes("bag/bag_0.mcap"), bytes("again/again_0.mcap"));
    let metadata = bench.read("bag/metadata.yaml");
    assert_eq!(bench.read("again/metadata.yaml"), metadata.replace("bag_0.mcap", "again_0.mcap"));

    let refused = bench.run("log export run.mcap --to ros2 --out bag");
    assert_eq!(refused.code, Some(2), "{}", refused.stderr);
    assert!(refused.stderr.contains("bag: exists already"), "{}", refused.stderr);
    assert_eq!(bench.read("bag/metadata.yaml"), metadata);
    let refused = bench.run("log export run.mcap --to ros2 --out other --muscle hamstrings");
    assert_eq!(refused.code, Some(2), "{}", refused.stderr);

    let mut bytes = bytes("run.mcap");
    let middle = bytes.len() / 2;
    bytes[middle] ^= 0x55;
    std::fs::write(bench.path("damaged.mcap"), &bytes).unwrap();
    std::fs::write(bench.path("short.mcap"), &bytes[..200]).unwrap();
    for file in ["damaged.mcap", "short.mcap"] {
        let refused = bench.run(&format!("log export {file} --to ros2 --out other"));
        assert_eq!(refused.code, Some(2), "{}", refused.stderr);
        assert!(refused.stderr.contains(&format!("{file}: byte ")), "{}", refused.stderr);
    }
    assert!(!bench.path("other").exists());
}

#[test]
fn files_that_are_no_recordings_are_refused_with_their_name() {
    let bench = Bench::new();
    bench.write("text.mcap", "time_s,far_n\n0,1\n");
    for verb in [
        "log info",
        "log plot --report r.html",
        "log export --out t.csv",
        "log export --to ros2 --out bag",
        "log layout --out l.json",
        "log replay",
    ] {
        let outcome = bench.run(&format!("{verb} text.mcap"));
        assert_eq!(outcome.code, Some(2), "{verb}: {}", outcome.stderr);
        assert!(
            outcome.stderr.starts_with("error: text.mcap: byte 0: expected an MCAP file"),
            "{}",
            outcome.stderr
        );
    }
    let outcome = bench.run("log info missing.mcap");
    assert_eq!(outcome.code, Some(2), "{}", outcome.stderr);
}

#[test]
fn a_recording_replaces_nothing_that_is_read_or_to_be_kept() {
    let bench = Bench::new();
    bench.write("kept.mcap", "x");
    let outcome = bench.run(&format!("{RUN} --record kept.mcap --no-clobber"));
    assert_eq!(outcome.code, Some(2), "{}", outcome.stderr);
    assert_eq!(bench.read("kept.mcap"), "x");
    let outcome = bench.run(&format!("{RUN} --record nowhere/run.mcap"));
    assert_eq!(outcome.code, Some(1), "{}", outcome.stderr);
}

#[cfg(target_os = "linux")]
#[test]
fn where_the_disk_is_full_the_run_goes_on_and_what_was_written_is_whole() {
    let bench = Bench::new();
    // Blocks of 512 bytes; the signal of the limit is ignored, as a full disk sends none.
    let script = format!(
        "trap '' XFSZ; ulimit -f 200; exec {} {RUN} --json --record run.mcap",
        env!("CARGO_BIN_EXE_sinew")
    );
    let folder = bench.path("run.mcap");
    let output =
        Command::new("sh").args(["-c", &script]).current_dir(folder.parent().unwrap()).output().unwrap();
    let (text, told) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert_eq!(output.status.code(), Some(3), "{told}");
    assert_eq!(told.matches("the run goes on without it").count(), 1, "{told}");
    assert_eq!(json(&text)["tracking"]["observer"]["ended"], "as_planned");
    let info = json(&bench.succeeds("log info run.mcap --json").stdout);
    assert_eq!(info["complete"], true);
    let cycles = info["cycles"].as_u64().unwrap();
    assert!((500..7000).contains(&cycles) && cycles.is_multiple_of(500), "{cycles}");
}

#[test]
fn the_format_of_a_record_is_not_mistaken() {
    let bench = Bench::new();
    for verb in ["track", "run"] {
        bench.refuses(
            &format!("{verb} bench_joint --record run.txt"),
            &["--record", "run.txt", ".mcap", ".csv"],
        );
        let linked = format!("{verb} bench_joint --link 127.0.0.1:0");
        for output in ["--record run.csv", "--report run.html"] {
            bench.refuses(
                &format!("{linked} {output}"),
                &[output.split(' ').next().unwrap(), "a planned motion"],
            );
        }
    }
    let real = "run bench_joint --bus ethercat --interface none0";
    bench.refuses(&format!("{real} --record run.csv"), &["--record", "run.csv", "true state", ".mcap"]);
    bench.refuses(&format!("{real} --report run.html"), &["--report", "run.html", "true state"]);
}

/// A motion of five seconds.
const SHORT: &str = "bench_joint --path tour --duration 4 --repeats 1 --hold 0.5 --json";

#[test]
fn a_machine_is_tracked_and_run_with_the_same_files_and_to_the_same_bit() {
    let bench = Bench::new();
    let mut answers = Vec::new();
    for (name, verb) in [("track", "track"), ("run", "run --virtual-time")] {
        for record in ["mcap", "csv"] {
            let outputs = format!("--record {name}.{record} --report {name}-{record}.html");
            let mut answer = json(&bench.succeeds(&format!("{verb} {SHORT} {outputs}")).stdout);
            assert_eq!(answer["written"].as_array().unwrap().len(), 2, "{answer}");
            assert_eq!(answer["recording"].is_object(), record == "mcap", "{answer}");
            answers.push(answer["tracking"].take());
        }
        assert_eq!(
            json(&bench.succeeds(&format!("log replay {name}.mcap --json")).stdout)["reproduced"],
            true
        );
    }
    assert!(answers.iter().all(|answer| answer.is_object() && *answer == answers[0]), "{answers:?}");
    assert_eq!(bench.read("track.csv"), bench.read("run.csv"));
    assert_eq!(bench.read("track-csv.html"), bench.read("run-csv.html"));
}

#[test]
fn a_client_commands_a_machine_that_is_tracked() {
    let bench = Bench::new();
    let outcome =
        bench.run("track bench_joint --link 127.0.0.1:0 --until 0.2 --page --bind 127.0.0.1:0 --json");
    assert!(outcome.stderr.contains("link: bench_joint listens on"), "{}", outcome.stderr);
    let answer = json(&outcome.stdout);
    assert_eq!((&answer["run"]["ended"], &answer["run"]["cycles"]), (&"as_planned".into(), &200.into()));
    assert!(answer["link"].is_object() && answer["timing_us"].is_null(), "{answer}");
}

#[test]
fn a_device_or_a_pipe_is_no_recording_and_is_not_read() {
    let bench = Bench::new();
    // Not in the folder whose files are compared.
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe.mcap");
    let made = Command::new("mkfifo").arg(&pipe).status().is_ok_and(|status| status.success());
    let pipe = Some(pipe.display().to_string()).filter(|_| made);
    for verb in [
        "log info",
        "log replay",
        "log plot --report r.html",
        "log export --out t.csv",
        "log export --to ros2 --out bag",
        "log layout --out l.json",
    ] {
        for file in ["/dev/zero", "/dev/random"].into_iter().chain(pipe.as_deref()) {
            let (verb, rest) = verb.split_once(" --").unwrap_or((verb, ""));
            let rest = if rest.is_empty() { String::new() } else { format!(" --{rest}") };
            bench.refuses(&format!("{verb} {file}{rest}"), &[file, "a file on disk", "a device or a pipe"]);
        }
    }
    if let Some(pipe) = &pipe {
        bench.refuses(&format!("live {pipe} --bind 127.0.0.1:0 --until 1"), &[pipe, "a device or a pipe"]);
    }
    bench.write("zeros.mcap", vec![0; 1 << 20]);
    bench.refuses("log info zeros.mcap", &["zeros.mcap"]);
}
