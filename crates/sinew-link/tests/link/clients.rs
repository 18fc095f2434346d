//! Clients in other languages, against the server.

use crate::network::{LARGE, StopOnDrop, cycle_of, start_of};
use sinew_link::{Key, Rejection};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::atomic::AtomicBool;

fn clients() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../clients")
}

/// Whether a program is there; says so where it is not.
fn is_there(program: &str) -> bool {
    let there = Command::new(program).arg("--version").output().is_ok_and(|output| output.status.success());
    if !there {
        eprintln!("skipped: no {program}");
    }
    there
}

fn drive(client: impl Fn() -> Command) {
    drive_with(&[Rejection::QueueFull], client);
}

/// Runs a client, given by the command without address and key, against a server with and without a key;
/// packets are rejected for these reasons alone.
fn drive_with(allowed: &[Rejection], client: impl Fn() -> Command) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("key");
    for key in [None, Some(Key::create(&file).unwrap())] {
        let (server, mut port) = start_of(LARGE, key.clone());
        let stop = AtomicBool::new(false);
        let mut output: Option<Output> = None;
        let commands = std::thread::scope(|scope| {
            let stopping = StopOnDrop(&stop);
            let cycle = scope.spawn(|| cycle_of(LARGE, &mut port, &stop));
            let mut command = client();
            command.args(["127.0.0.1", &server.address().port().to_string(), "0.6"]);
            if key.is_some() {
                command.arg(&file);
            }
            output = Some(command.output().unwrap());
            drop(stopping);
            cycle.join().unwrap()
        });
        let output = output.unwrap();
        let text = String::from_utf8_lossy(&output.stdout);
        assert!(output.status.success(), "{text} {}", String::from_utf8_lossy(&output.stderr));
        assert!(text.contains("\"mode\": 4"), "{text}");
        eprintln!("{text}");
        let counters = server.stop();
        for (reason, count) in counters.by_reason() {
            assert!(count == 0 || allowed.contains(&reason), "{reason:?} {count}");
        }
        assert!(commands > 20 && counters.accepted >= commands, "{commands} commands");
    }
}

#[test]
fn the_python_client_has_at_most_52_lines_and_drives_the_server() {
    let text = std::fs::read_to_string(clients().join("python/sinew_link.py")).unwrap();
    assert!(text.lines().count() <= 52, "{} lines", text.lines().count());
    if is_there("python3") {
        drive(|| {
            let mut command = Command::new("python3");
            command.arg("-B").arg(clients().join("python/example.py"));
            command
        });
    }
}

#[test]
fn a_client_written_from_the_page_alone_drives_the_server() {
    if is_there("python3") {
        drive_with(&[Rejection::QueueFull, Rejection::SecondClient], || {
            let mut command = Command::new("python3");
            let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/link/from_the_page.py");
            command.arg("-B").arg(file);
            command
        });
    }
}

#[test]
fn the_c_client_compiles_without_warnings_and_drives_the_server() {
    if !is_there("cc") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let program = folder.path().join("example");
    let output = Command::new("cc")
        .args([
            "-std=c99",
            "-O2",
            "-Wall",
            "-Wextra",
            "-Werror",
            "-pedantic",
            "-D_POSIX_C_SOURCE=200809L",
            "-o",
        ])
        .arg(&program)
        .arg(clients().join("c/example.c"))
        .arg("-lm")
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    drive(|| Command::new(&program));
}
