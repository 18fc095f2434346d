//! `sinew run --link` and `sinew link`.

use crate::bench::Bench;
use serde_json::Value;
use sinew_link::client::Client;
use sinew_link::wire::features;
use sinew_link::{Command as LinkCommand, Key, Mode, Request, SetpointKind, Setpoints};
use std::io::{BufRead, BufReader};
use std::net::{SocketAddr, UdpSocket};
use std::os::unix::fs::PermissionsExt;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

const PATIENCE: Duration = Duration::from_secs(120);
const MS: u64 = 1_000_000;

/// A run with a link, and where it listens.
pub(crate) struct Running {
    pub(crate) child: Child,
    pub(crate) address: SocketAddr,
}

impl Running {
    pub(crate) fn start(more: &str) -> Self {
        Self::new("planar_leg", more)
    }

    /// Of a leg's file.
    pub(crate) fn new(machine: &str, more: &str) -> Self {
        let motion = "--path to-joints:hip=0.8,knee=1.6 --duration 3 --unverified --json";
        let mut child = Command::new(env!("CARGO_BIN_EXE_sinew"))
            .args(["run", machine])
            .args(motion.split(' '))
            .args(["--link", "127.0.0.1:0"])
            .args(more.split_whitespace())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
        let address = lines.find_map(|line| line.unwrap().rsplit_once("listens on ")?.1.parse().ok());
        std::thread::spawn(move || lines.for_each(drop));
        Self { address: address.expect("the run says where its link listens"), child }
    }

    pub(crate) fn connect(&self) -> Client {
        Client::connect(self.address, None, PATIENCE).unwrap()
    }

    pub(crate) fn end(self) -> Value {
        let output = self.child.wait_with_output().unwrap();
        let text = String::from_utf8(output.stdout).unwrap();
        serde_json::from_str(&text).unwrap_or_else(|error| panic!("{error}: {text}"))
    }
}

/// Lets the machine's time go on to a goal, with a command; the state then.
pub(crate) fn advance(
    client: &mut Client,
    request: Request,
    setpoints: Setpoints,
    goal: u64,
) -> (Mode, Vec<f64>) {
    let begin = Instant::now();
    loop {
        client.send(&LinkCommand { request, advance_to_ns: goal, setpoints }).unwrap();
        // A session ends after half a second without a command: a full queue would have to drop a hundred in
        // a row.
        while let Ok(state) = client.receive(Duration::from_millis(5)) {
            if state.machine_time_ns >= goal {
                return (state.mode, state.joints().iter().map(|joint| joint.joint_estimated).collect());
            }
        }
        assert!(begin.elapsed() < PATIENCE, "the machine's time does not reach {goal}");
    }
}

/// Both joints from where they are to a point `by` further on, point by point, in lock-step.
fn drive(client: &mut Client, from: u64, milliseconds: u64, by: f64) -> (Mode, Vec<f64>) {
    let (mode, held) = advance(client, Request::Run, Setpoints::none(), from + 20 * MS);
    assert_eq!(mode, Mode::Run);
    let mut last = (mode, held.clone());
    for step in (20..milliseconds).step_by(20) {
        let mut setpoints = Setpoints::new(SetpointKind::Joint, held.len());
        for ahead in [10, 20, 30] {
            let fraction = ((step + ahead) as f64 / milliseconds as f64).min(1.0);
            let joints: Vec<f64> =
                held.iter().map(|q| q + by * fraction * fraction * (3.0 - 2.0 * fraction)).collect();
            assert!(setpoints.push(from + (step + ahead) * MS, &joints));
        }
        last = advance(client, Request::Run, setpoints, from + (step + 20) * MS);
    }
    last
}

/// Everything that is not a command, as fast as the socket takes it.
fn flood(address: SocketAddr, stop: &AtomicBool) -> u64 {
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    let packets: [&[u8]; 4] = [&[0x55; 200], b"SNWL\x01\x04", &[0; 1400], &[]];
    let mut sent = 0;
    while !stop.load(Ordering::Relaxed) {
        for packet in packets.iter().cycle().take(64) {
            sent += u64::from(socket.send_to(packet, address).is_ok());
        }
        // The socket's queue is shared with the client: not so fast that every command is pushed out.
        std::thread::sleep(Duration::from_micros(200));
    }
    sent
}

/// Sets a flag where its scope ends, by a panic as well.
struct StopOnDrop<'a>(&'a AtomicBool);

impl Drop for StopOnDrop<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

#[test]
fn a_flood_changes_no_bit_of_a_run_and_a_client_moves_the_machine() {
    let run = |flooded: bool| {
        let running = Running::start("--virtual-time --until 3.5");
        let (address, stop) = (running.address, AtomicBool::new(false));
        std::thread::scope(|scope| {
            let flood = flooded.then(|| scope.spawn(|| flood(address, &stop)));
            // Where an assertion fails, too, or the scope would wait for the flood.
            let stopping = StopOnDrop(&stop);
            let mut client = running.connect();
            assert_ne!(client.session().welcome().features & features::LOCK_STEP, 0);
            let (_, start) = advance(&mut client, Request::Run, Setpoints::none(), 1000 * MS);
            let (mode, end) = drive(&mut client, 1000 * MS, 2000, 0.1);
            assert_eq!(mode, Mode::Run);
            // The reference follows a preview horizon later.
            let (_, end) = if end[0] > start[0] {
                advance(&mut client, Request::Run, Setpoints::none(), 3400 * MS)
            } else {
                (mode, end)
            };
            for (start, end) in start.iter().zip(&end) {
                assert!((end - start - 0.1).abs() < 0.012, "{start} {end}");
            }
            client
                .send(&LinkCommand {
                    request: Request::Run,
                    advance_to_ns: 4000 * MS,
                    setpoints: Setpoints::none(),
                })
                .unwrap();
            drop(stopping);
            if let Some(flood) = flood {
                assert!(flood.join().unwrap() > 1000);
            }
        });
        running.end()
    };
    let (quiet, flooded) = (run(false), run(true));
    assert_eq!(quiet["run"], flooded["run"], "bit for bit, by the digest of all readings and estimates");
    assert_eq!(quiet["run"]["cycles"], 3500);
    let rejected = |document: &Value, reason: &str| document["link"]["rejected"][reason].as_u64().unwrap();
    for reason in ["too_short", "too_long", "wrong_magic"] {
        assert_eq!(rejected(&quiet, reason), 0);
        assert!(rejected(&flooded, reason) > 50, "{reason} {}", flooded["link"]);
    }
}

#[test]
fn a_client_that_is_killed_and_restarted_resumes_from_hold() {
    let running = Running::start("--virtual-time --until 5");
    let mut killed = running.connect();
    advance(&mut killed, Request::Run, Setpoints::none(), 1000 * MS);
    drive(&mut killed, 1000 * MS, 1000, 0.1);
    drop(killed); // without a word
    let mut client = running.connect();
    let state = |client: &mut Client| {
        client.send(&LinkCommand::from_request(Request::None)).unwrap();
        *client.receive(PATIENCE).unwrap()
    };
    let before = state(&mut client).machine_time_ns;
    assert_eq!(before, 2000 * MS, "time has stood still");
    let (mode, _) = advance(&mut client, Request::None, Setpoints::none(), before + 2 * MS);
    assert_eq!(mode, Mode::Hold, "the new client finds the machine in hold");
    let (mode, _) = advance(&mut client, Request::None, Setpoints::none(), 2500 * MS);
    assert_eq!(mode, Mode::Hold);
    let (_, start) = advance(&mut client, Request::Run, Setpoints::none(), 2600 * MS);
    let (mode, _) = drive(&mut client, 2600 * MS, 1000, -0.05);
    assert_eq!(mode, Mode::Run);
    let (_, end) = advance(&mut client, Request::Run, Setpoints::none(), 4000 * MS);
    assert!(
        start.iter().zip(&end).all(|(start, end)| (end - start + 0.05).abs() < 0.02),
        "{start:?} {end:?}"
    );
    client
        .send(&LinkCommand { request: Request::Hold, advance_to_ns: 9000 * MS, setpoints: Setpoints::none() })
        .unwrap();
    let document = running.end();
    let modes: Vec<&str> = document["run"]["modes"]
        .as_array()
        .unwrap()
        .iter()
        .filter_map(|mode| mode["mode"].as_str())
        .collect();
    assert!(modes.windows(3).any(|modes| modes == ["run", "hold", "run"]), "{modes:?}");
}

#[test]
fn a_linked_run_is_recorded_and_replays_to_the_bit_while_another_client_watches() {
    let bench = Bench::new();
    for (more, virtual_time) in
        [("--virtual-time --bus segment", true), ("--virtual-time", true), ("", false)]
    {
        let file = bench.path("linked.mcap");
        let running = Running::start(&format!("{more} --until 1.8 --record {}", file.display()));
        let mut watcher = Client::connect_to_watch(running.address, None, PATIENCE).unwrap();
        watcher.watch().unwrap();
        let mut client = running.connect();
        if virtual_time {
            advance(&mut client, Request::Run, Setpoints::none(), 600 * MS);
            drive(&mut client, 600 * MS, 1000, 0.1);
            watcher.watch().unwrap();
            let seen = loop {
                let seen = watcher.receive(PATIENCE).unwrap();
                if seen.machine_time_ns >= 500 * MS {
                    break seen.mode;
                }
            };
            assert_eq!(seen, Mode::Run);
            let last = LinkCommand { advance_to_ns: 4000 * MS, ..LinkCommand::from_request(Request::Run) };
            client.send(&last).unwrap();
        } else {
            // Whatever arrives when: what was taken is what is replayed.
            let begin = Instant::now();
            while begin.elapsed() < Duration::from_millis(1500) {
                let position = client.session().state().joints()[0].joint_estimated;
                let mut setpoints = Setpoints::new(SetpointKind::Joint, 2);
                let knee = client.session().state().joints()[1].joint_estimated;
                setpoints.push(0, &[position + 0.01, knee]);
                let command = LinkCommand { setpoints, ..LinkCommand::from_request(Request::Run) };
                client.send(&command).unwrap();
                let _ = client.receive(Duration::from_millis(10));
            }
        }
        let document = running.end();
        assert_eq!(document["recording"]["cycles"], document["run"]["cycles"], "{more}");
        let replayed = bench.run("log replay linked.mcap --json");
        assert_eq!(replayed.code, Some(0), "{more}: {} {}", replayed.stdout, replayed.stderr);
        assert!(bench.succeeds("log info linked.mcap").stdout.contains("commanded by a client"));
        std::fs::remove_file(file).unwrap();
    }
}

#[test]
fn a_key_is_written_once_for_its_owner_alone_and_never_shown() {
    let bench = Bench::new();
    let made = bench.succeeds("link key robot.key --json");
    let key = bench.read("robot.key");
    let path = bench.path("robot.key");
    assert_eq!(std::fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o600);
    assert!(Key::read(&path).is_ok());
    let again = bench.run("link key robot.key");
    assert_eq!((again.code, bench.read("robot.key")), (Some(2), key.clone()));
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o644)).unwrap();
    let open = bench.run("link watch 127.0.0.1:9 --key robot.key");
    assert_eq!(open.code, Some(2));
    assert!(open.stderr.contains("0600") && open.stderr.contains("0644"), "{}", open.stderr);
    bench.write("wrong.key", &key[..40]);
    std::fs::set_permissions(bench.path("wrong.key"), std::fs::Permissions::from_mode(0o600)).unwrap();
    let wrong = bench.run("link watch 127.0.0.1:9 --key wrong.key");
    assert_eq!(wrong.code, Some(2));
    for shown in [made.stdout, made.stderr, again.stderr, open.stderr, wrong.stderr, wrong.stdout] {
        assert!(!shown.contains(&key[..12]), "{shown}");
    }
}

#[test]
fn an_address_that_others_reach_is_refused_without_a_key() {
    let bench = Bench::new();
    let motion = "run planar_leg --path to-joints:hip=0.8,knee=1.6 --duration 3 --unverified --virtual-time";
    let outcome = bench.run(&format!("{motion} --link 0.0.0.0:0"));
    assert_eq!(outcome.code, Some(2), "{}", outcome.stderr);
    assert!(outcome.stderr.contains("or a key"), "{}", outcome.stderr);
}
