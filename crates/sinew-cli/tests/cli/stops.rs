//! What stops a run, and what remains of it: the table in docs/supervisor.md.

use crate::bench::Bench;
use crate::link::{Running, advance};
use serde_json::Value;
use sinew_link::client::Client;
use sinew_link::{Command as LinkCommand, Mode, Request, Setpoints};
use std::io::{BufRead, BufReader};
use std::net::{SocketAddr, TcpStream};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use tungstenite::Message;
use tungstenite::client::IntoClientRequest;

const PATIENCE: Duration = Duration::from_secs(120);
const MS: u64 = 1_000_000;

fn signal(child: &Child, signal: &str) {
    let status = Command::new("kill").args([&format!("-{signal}"), &child.id().to_string()]).status();
    assert!(status.unwrap().success());
}

/// Modes of a run in their order.
fn modes(document: &Value) -> Vec<String> {
    let modes = document["run"]["modes"].as_array().unwrap().iter();
    modes.filter_map(|mode| mode["mode"].as_str().map(str::to_owned)).collect()
}

/// The modes from the last motion on.
fn since_run(document: &Value) -> Vec<String> {
    let modes = modes(document);
    let last = modes.iter().rposition(|mode| mode == "run").unwrap_or(0);
    modes[last..].to_vec()
}

fn replays(bench: &Bench, file: &str) {
    let replayed = bench.run(&format!("log replay {file} --json"));
    assert_eq!(replayed.code, Some(0), "{} {}", replayed.stdout, replayed.stderr);
}

/// Without set-points.
fn go(client: &mut Client, request: Request, goal: u64) -> Mode {
    advance(client, request, Setpoints::none(), goal).0
}

/// A session with this request, kept until the machine is in a mode.
fn keep(client: &mut Client, request: Request, mode: Mode) {
    assert!(leads(client, request, mode), "{request:?} does not lead to {mode:?} but to a fault");
}

/// Whether a session with this request, which is kept until then, leads to a mode and not to a fault.
fn leads(client: &mut Client, request: Request, mode: Mode) -> bool {
    let begin = Instant::now();
    loop {
        client.send(&LinkCommand::from_request(request)).unwrap();
        let now = client.receive(Duration::from_millis(20)).map(|state| state.mode);
        match now {
            Ok(now) if now == mode => return true,
            Ok(Mode::Fault) => return false,
            _ => assert!(begin.elapsed() < PATIENCE, "{request:?} does not lead to {mode:?} but to {now:?}"),
        }
    }
}

/// A file of the leg that is lowered within a second, so that real time is short, with more limits.
fn leg(bench: &Bench, limits: &str) -> String {
    let model = concat!(env!("CARGO_MANIFEST_DIR"), "/../../models/planar_leg.toml");
    let quick = "pretension_time_s = 0.3\nholding_time_s = 0.2\nlowering_speed_rad_per_s = 2.0";
    let text = std::fs::read_to_string(model).unwrap();
    bench.write("leg.toml", format!("{text}\n[safety]\n{quick}\n{limits}\n"));
    bench.path("leg.toml").display().to_string()
}

#[test]
fn a_stop_over_the_link_holds_whoever_comes_and_goes_and_replays_to_the_bit() {
    let bench = Bench::new();
    let leg = leg(&bench, "");
    for more in ["--virtual-time", "--virtual-time --bus segment", ""] {
        let virtual_time = !more.is_empty();
        let file = bench.path("stopped.mcap");
        let running = Running::new(&leg, &format!("{more} --until 7 --record {}", file.display()));
        let mut client = running.connect();
        if virtual_time {
            assert_eq!(go(&mut client, Request::Run, 800 * MS), Mode::Run);
            let stop =
                LinkCommand { advance_to_ns: 1000 * MS, ..LinkCommand::from_request(Request::SafeStop) };
            client.send(&stop).unwrap();
        } else {
            keep(&mut client, Request::Run, Mode::Run);
            client.send(&LinkCommand::from_request(Request::SafeStop)).unwrap();
        }
        client.close().unwrap();
        // A watcher, and then a client that asks for nothing and leaves without a word.
        let mut watcher = Client::connect_to_watch(running.address, None, PATIENCE).unwrap();
        watcher.watch().unwrap();
        let mut other = running.connect();
        if virtual_time {
            assert!(matches!(go(&mut other, Request::None, 2000 * MS), Mode::SafeStop | Mode::Ready));
        } else {
            keep(&mut other, Request::None, Mode::SafeStop);
        }
        drop(other);
        let mut last = running.connect();
        if virtual_time {
            last.send(&LinkCommand { advance_to_ns: 8_000 * MS, ..LinkCommand::from_request(Request::None) })
                .unwrap();
        } else {
            keep(&mut last, Request::None, Mode::Ready);
        }
        let document = running.end();
        assert_eq!(since_run(&document), ["run", "safe_stop", "ready"], "{more}");
        assert_eq!(document["run"]["ended"], "as_planned", "{more}");
        replays(&bench, "stopped.mcap");
        std::fs::remove_file(file).unwrap();
    }
}

#[test]
fn a_client_that_turns_off_and_leaves_leaves_a_machine_that_is_off() {
    let bench = Bench::new();
    let leg = leg(&bench, "");
    for more in ["--virtual-time", ""] {
        let running = Running::new(&leg, more);
        let mut client = running.connect();
        if more.is_empty() {
            keep(&mut client, Request::Run, Mode::Run);
            client.send(&LinkCommand::from_request(Request::TurnOff)).unwrap();
        } else {
            go(&mut client, Request::Run, 800 * MS);
            let off =
                LinkCommand { advance_to_ns: 40_000 * MS, ..LinkCommand::from_request(Request::TurnOff) };
            client.send(&off).unwrap();
        }
        client.close_at_once().unwrap();
        let document = running.end();
        // Through ready in the cycle in which it is down.
        assert_eq!(since_run(&document), ["run", "safe_stop", "off"], "{more}");
        assert_eq!(document["run"]["ended"], "turned_off");
    }
}

#[test]
fn a_client_that_is_lost_while_it_runs_leaves_a_machine_that_is_held_and_then_let_down() {
    let bench = Bench::new();
    let file = bench.path("left.mcap");
    let leg = leg(&bench, "unattended_s = 2.0");
    let running = Running::new(&leg, &format!("--until 7 --record {}", file.display()));
    let mut client = running.connect();
    keep(&mut client, Request::Run, Mode::Run);
    drop(client);
    let document = running.end();
    assert_eq!(since_run(&document), ["run", "hold", "safe_stop", "ready"]);
    let time = |mode: &str| {
        let found =
            document["run"]["modes"].as_array().unwrap().iter().rfind(|change| change["mode"] == mode);
        found.unwrap()["from_s"].as_f64().unwrap()
    };
    let held = time("safe_stop") - time("hold");
    assert!((1.8..2.8).contains(&held), "{held} s");
    replays(&bench, "left.mcap");
}

#[test]
fn the_first_ctrl_c_is_a_safe_stop_that_waits_for_no_client_and_weakens_no_turning_off() {
    let bench = Bench::new();
    for (request, end, name) in
        [(Request::Run, "ready", "interrupted"), (Request::TurnOff, "off", "interrupted")]
    {
        let file = bench.path("interrupted.mcap");
        let running = Running::start(&format!("--virtual-time --record {}", file.display()));
        let mut client = running.connect();
        assert_eq!(go(&mut client, Request::Run, 800 * MS), Mode::Run);
        // Time stands: the stop goes on without the client.
        let asked = go(&mut client, request, 900 * MS);
        assert_eq!(asked, if request == Request::Run { Mode::Run } else { Mode::SafeStop });
        signal(&running.child, "INT");
        let document = running.end();
        assert_eq!(since_run(&document), ["run", "safe_stop", end]);
        assert_eq!(document["run"]["ended"], name);
        replays(&bench, "interrupted.mcap");
    }
}

/// A run of its own in real time that is recorded, once it moves.
fn moving(bench: &Bench, more: &str) -> Child {
    let leg = leg(bench, "");
    let motion = "--path to-joints:hip=0.4,knee=1.0 --duration 20 --hold 1 --unverified";
    let mut command = bench.command(&format!("run {leg} {motion} --record moving.mcap --json {more}"));
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    assert!(moves_for_seconds(&mut child, &bench.path("moving.mcap")));
    child
}

/// Whether a run records seconds before it ends by itself.
fn moves_for_seconds(run: &mut Child, recording: &Path) -> bool {
    let begin = Instant::now();
    let size = || std::fs::metadata(recording).map_or(0, |data| data.len());
    let mut head = 0;
    while head == 0 || size() <= head + 200_000 {
        assert!(begin.elapsed() < PATIENCE, "the run does not begin");
        if run.try_wait().unwrap().is_some() {
            return false;
        }
        head = if head == 0 { size() } else { head };
        std::thread::sleep(Duration::from_millis(20));
    }
    true
}

#[test]
fn ctrl_c_and_a_request_to_terminate_let_a_run_down_and_its_recording_replays() {
    for (name, bus) in [("INT", "--bus twin"), ("TERM", "--bus segment")] {
        let bench = Bench::new();
        let child = moving(&bench, bus);
        signal(&child, name);
        let output = child.wait_with_output().unwrap();
        let (text, told) =
            (String::from_utf8(output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap());
        assert_eq!(output.status.code(), Some(3), "{told}");
        let document: Value = serde_json::from_str(&text).unwrap();
        assert!(document["interrupted_s"].as_f64().unwrap() > 1.0, "{document}");
        let tracking = document["tracking"].as_object().unwrap().values().next().unwrap();
        assert_eq!((&tracking["ended"], &tracking["reason"]), (&"stopped".into(), &"by Ctrl-C".into()));
        for state in
            ["stopping; Ctrl-C again ends at once", "brake, stand, and release the tension", "released\n"]
        {
            assert!(told.contains(state), "{told}");
        }
        replays(&bench, "moving.mcap");
        let info = bench.succeeds("log info moving.mcap").stdout;
        assert!(info.contains("safe_stop") || info.contains("safe stop"), "{info}");
    }
}

#[test]
fn the_second_ctrl_c_ends_a_run_at_once_with_its_results() {
    let bench = Bench::new();
    let child = moving(&bench, "--bus segment");
    signal(&child, "INT");
    std::thread::sleep(Duration::from_millis(300));
    signal(&child, "INT");
    let begin = Instant::now();
    let output = child.wait_with_output().unwrap();
    let told = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(3), "{told}");
    assert!(told.contains("brake, stand") && !told.contains("released\n"), "{told}");
    assert!(begin.elapsed() < Duration::from_secs(5), "{:?}", begin.elapsed());
    replays(&bench, "moving.mcap");
}

/// Two virtual interfaces in a network of their own, in which this test runs again.
const NETWORK: &str = "ip link set lo up; ip link add sinew0 type veth peer name sinew1 && ip link set \
    sinew0 up && ip link set sinew1 up && exec \"$0\" --exact \
    stops::drives_of_another_process_are_disabled_whatever_ends_the_run --nocapture";
/// Set in that network.
const INSIDE: &str = "SINEW_STOPS_INSIDE";

#[cfg(target_os = "linux")]
#[test]
fn drives_of_another_process_are_disabled_whatever_ends_the_run() {
    if std::env::var_os(INSIDE).is_some() {
        for end in [End::Terminated, End::InterruptedTwice, End::StoppedByThePage, End::LostClient] {
            // On a computer with other work most runs end by themselves before, within seconds: a drive stops
            // where frames are late.
            assert!((0..40).any(|_| disabled_after(end)), "{end:?} is never reached");
        }
        return;
    }
    let permitted = Command::new("unshare")
        .args(["-Urn", "sh", "-c", "ip link add sinew0 type veth peer name sinew1"])
        .output();
    if !permitted.is_ok_and(|output| output.status.success()) {
        eprintln!("skipped: network namespaces or virtual interfaces are not permitted here");
        return;
    }
    let inside = Command::new("unshare")
        .args(["-Urn", "sh", "-c", NETWORK])
        .arg(std::env::current_exe().unwrap())
        .env(INSIDE, "1")
        .output()
        .unwrap();
    let told = String::from_utf8_lossy(&inside.stdout) + String::from_utf8_lossy(&inside.stderr);
    assert!(inside.status.success() && told.contains("1 passed"), "{told}");
}

/// What ends a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum End {
    Terminated,
    InterruptedTwice,
    StoppedByThePage,
    /// Its session ends without a word, and the run some seconds later.
    LostClient,
}

/// A run on devices of another process, until something ends it; whether it was that.
#[cfg(target_os = "linux")]
fn disabled_after(end: End) -> bool {
    let bench = Bench::new();
    // Times of a computer with other work.
    leg(&bench, "lateness_s = 1000.0\nbridged_lateness_s = 10.0\nbridged_loss_s = 5.0\nunattended_s = 2.0");
    let start = |arguments: &str| {
        Command::new(env!("CARGO_BIN_EXE_sinew"))
            .args(arguments.split_whitespace())
            .current_dir(bench.path("."))
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap()
    };
    let devices = start("ethercat simulate leg.toml --interface sinew1 --duration 240 --json");
    std::thread::sleep(Duration::from_secs(1));
    let more = match end {
        End::StoppedByThePage => "--page --bind 127.0.0.1:0",
        End::LostClient => "--link 127.0.0.1:0 --until 7",
        _ => "",
    };
    let mut run = start(&format!(
        "run leg.toml --bus ethercat --interface sinew0 --path to-joints:hip=0.4,knee=1.0 --duration 60 \
            --hold 1 --unverified --record run.mcap --json {more}"
    ));
    let mut lines = BufReader::new(run.stderr.take().unwrap()).lines().map_while(Result::ok);
    let reached = if end == End::LostClient {
        let address = address_in(&mut lines, "listens on ");
        let mut client = Client::connect(address, None, PATIENCE).unwrap();
        leads(&mut client, Request::Run, Mode::Run)
    } else {
        let page = (end == End::StoppedByThePage).then(|| address_in(&mut lines, "http://"));
        let moves = moves_for_seconds(&mut run, &bench.path("run.mcap"));
        match page {
            _ if !moves => {}
            Some(address) => stop_by_the_page(address),
            None if end == End::Terminated => signal(&run, "TERM"),
            None => {
                signal(&run, "INT");
                std::thread::sleep(Duration::from_millis(200));
                signal(&run, "INT");
            }
        }
        moves
    };
    let told = std::thread::spawn(move || lines.collect::<Vec<_>>().join("\n"));
    let ended = run.wait_with_output().unwrap();
    let told = told.join().unwrap();
    let said = String::from_utf8_lossy(&ended.stdout);
    // On a computer with other work frames are late, so that drives may stop by themselves, which ends a run
    // as well.
    let lost = serde_json::from_str::<Value>(&said).map_or(0, |run| run["bus"]["lost"].as_u64().unwrap_or(0));
    let code = if end == End::LostClient { 0 } else { 3 };
    assert!(
        ended.status.code() == Some(code) || (lost > 0 && ended.status.code() == Some(3)),
        "{end:?}: {told} {said}"
    );
    std::thread::sleep(Duration::from_millis(100));
    signal(&devices, "INT");
    let devices: Value = serde_json::from_slice(&devices.wait_with_output().unwrap().stdout).unwrap();
    assert!(devices["frames_answered"].as_u64().unwrap() > 500, "{devices}");
    assert_eq!(devices["drives_with_power"], 0, "{end:?}: {told} {said}");
    // A drive that stops by itself, because nothing comes any more, says so with a fault.
    assert!(devices["drives_with_a_fault"] == 0 || lost > 0, "{end:?}: {told} {said} {devices}");
    reached
}

/// The address that a run names after some words.
fn address_in(lines: &mut impl Iterator<Item = String>, before: &str) -> SocketAddr {
    let found = lines.find_map(|line| {
        let after = line.split_once(before)?.1;
        after.split(['/', ' ', ',']).next()?.parse().ok()
    });
    found.expect("the run says where it listens")
}

/// Asks for a safe stop as the page does.
fn stop_by_the_page(address: SocketAddr) {
    // Without a page the run ends in another way, and the test shows what it said.
    let Ok(stream) = TcpStream::connect(address) else { return };
    let mut request = format!("ws://{address}/stream").into_client_request().unwrap();
    request.headers_mut().insert("Sec-WebSocket-Protocol", "sinew.live.1".parse().unwrap());
    let Ok((mut socket, _)) = tungstenite::client::client(request, stream) else { return };
    let stop = r#"{"id":1,"command":"mode","request":"safe_stop"}"#;
    socket.send(Message::text(stop)).unwrap();
    while socket.read().is_ok() {}
}
