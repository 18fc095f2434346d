//! Motors in MIT mode whose program is killed or stopped: the watchdog beside it.

use crate::bench::Bench;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::Duration;

fn signal(child: &Child, signal: &str) {
    let status = Command::new("kill").args([&format!("-{signal}"), &child.id().to_string()]).status();
    assert!(status.unwrap().success());
}

/// Whether a watchdog for a port is there.
fn is_guarded(port: &str) -> bool {
    let guards = |path: &Path| {
        let line = std::fs::read(path.join("cmdline")).unwrap_or_default();
        let words: Vec<_> = line.split(|octet| *octet == 0).collect();
        words.contains(&port.as_bytes()) && words.contains(&b"SINEW_CAN_WATCHDOG".as_slice())
    };
    std::fs::read_dir("/proc").unwrap().flatten().any(|entry| guards(&entry.path()))
}

/// What simulated motors say at their end, a moment after their master in mid-motion got this signal; none
/// where that was stopped before, since a busy computer stood for longer than its watchdog waits.
fn ends(bench: &Bench, with: Option<&str>) -> Option<String> {
    let mut motors = bench.command("can simulate joint.toml --pty").stdout(Stdio::piped()).spawn().unwrap();
    let mut said = BufReader::new(motors.stdout.take().unwrap());
    let mut port = String::new();
    said.read_line(&mut port).unwrap();
    let run = format!("run joint.toml --bus can --interface {} --duration 30 --unverified", port.trim());
    let mut run = bench.command(&run).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    sleep(Duration::from_secs(4));
    let runs = run.try_wait().unwrap().is_none() && is_guarded(port.trim());
    if let Some(with) = with.filter(|_| runs) {
        signal(&run, with);
        sleep(Duration::from_millis(300));
        assert!(!is_guarded(port.trim()), "{with}: its watchdog has ended");
    }
    signal(&motors, "INT");
    let mut text = String::new();
    said.read_to_string(&mut text).unwrap();
    motors.wait().unwrap();
    run.kill().unwrap();
    run.wait().unwrap();
    runs.then_some(text)
}

#[test]
fn a_program_that_is_killed_or_stopped_in_mid_motion_leaves_no_motor_with_power() {
    let bench = Bench::new();
    let source = sinew_models::BENCH_JOINT;
    let bare = source.replace("[every_transmission]\n", "[every_transmission]\nload_cell = \"none\"\n");
    let device = |(k, muscle): (usize, &str)| {
        format!(
            "[[device]]\nname = \"{muscle}\"\nmuscle = \"{muscle}\"\nprotocol = \"mit\"\nnode = {}\nmodel = \"AK10-9\"\n",
            k + 1
        )
    };
    let devices: Vec<_> = ["front", "back"].into_iter().enumerate().map(device).collect();
    let text = format!("period_s = 0.02\n{bare}\n[every_joint_encoder]\nnone = true\n{}", devices.concat());
    bench.write("joint.toml", text);
    for (with, left) in [(None, 2), (Some("KILL"), 0), (Some("STOP"), 0)] {
        let said = (0..8).find_map(|_| ends(&bench, with)).expect("a run that goes on");
        assert!(said.contains(&format!("at the end {left} drives with power")), "{with:?}: {said}");
    }
}
