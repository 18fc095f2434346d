//! Server and client over loopback.

use sinew_link::client::Client;
use sinew_link::host::{Domain, Input, Port, Server, ServerSettings, SessionSettings};
use sinew_link::{Command, Error, Key, Mode, Rejection, Request, SetpointKind, Setpoints, Snapshot};
use std::net::UdpSocket;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

const SOON: Duration = Duration::from_secs(20);

/// Joints and muscles of a machine whose states fit in one datagram, and of one whose do not.
const SMALL: [usize; 2] = [2, 4];
pub(crate) const LARGE: [usize; 2] = [12, 26];

fn domain([joints, muscles]: [usize; 2]) -> Domain {
    Domain { joint: vec![[-1.0, 1.0]; joints], tension: vec![[0.0, 100.0]; muscles], ..Domain::default() }
}

fn start(key: Option<Key>) -> (Server, Port) {
    start_of(SMALL, key)
}

/// A server for a machine of this size.
pub(crate) fn start_of(sizes: [usize; 2], key: Option<Key>) -> (Server, Port) {
    let (address, sessions) = ("127.0.0.1:0".parse().unwrap(), SessionSettings::default());
    Server::start(ServerSettings { address, key, domain: domain(sizes), sessions }).unwrap()
}

/// Sets a flag where its scope ends, by a panic as well: a thread that waits for the flag ends, and the test
/// fails instead of hanging.
pub(crate) struct StopOnDrop<'a>(pub(crate) &'a AtomicBool);

impl Drop for StopOnDrop<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// A control cycle of 1 ms that follows the newest joint set-point at once, until it is told to stop.
fn cycle(port: &mut Port, stop: &AtomicBool) -> u64 {
    cycle_of(SMALL, port, stop)
}

/// The same of a machine of this size.
pub(crate) fn cycle_of([joints, muscles]: [usize; 2], port: &mut Port, stop: &AtomicBool) -> u64 {
    let (mut snapshot, mut commands) = (Snapshot::new(joints, muscles), 0);
    snapshot.joints_mut().iter_mut().for_each(|joint| joint.joint_reference = 0.0);
    while !stop.load(Ordering::Relaxed) {
        while let Some(command) = port.next_command() {
            commands += 1;
            if let Some((_, numbers)) = command.setpoints.iter().last() {
                for (joint, number) in snapshot.joints_mut().iter_mut().zip(numbers) {
                    joint.joint_reference = *number;
                }
                snapshot.setpoint = command.setpoints.kind();
            }
            if command.request == Request::Run {
                snapshot.mode = Mode::Run;
            }
            if command.request != Request::None {
                snapshot.request = command.request;
            }
        }
        snapshot.cycle += 1;
        snapshot.machine_time_ns += 1_000_000;
        port.publish(&snapshot);
        std::thread::sleep(Duration::from_millis(1));
    }
    commands
}

#[test]
fn commands_and_states_cross_with_and_without_a_key() {
    for key in [None, Some(Key::new([9; 32]))] {
        let (server, mut port) = start(key.clone());
        let stop = AtomicBool::new(false);
        std::thread::scope(|scope| {
            let _stopping = StopOnDrop(&stop);
            scope.spawn(|| cycle(&mut port, &stop));
            let mut client = Client::connect(server.address(), key.as_ref(), SOON).unwrap();
            let mut setpoints = Setpoints::new(SetpointKind::Joint, 2);
            assert!(setpoints.push(0, &[0.5, -0.5]));
            let begin = Instant::now();
            loop {
                client.send(&Command { request: Request::Run, advance_to_ns: 0, setpoints }).unwrap();
                let state = client.receive(SOON).unwrap();
                let [first, second] = [0, 1].map(|k| state.joints()[k].joint_reference);
                if state.mode == Mode::Run && (first - 0.5).abs() < 1e-15 && (second + 0.5).abs() < 1e-15 {
                    break;
                }
                assert!(begin.elapsed() < SOON, "the set-point did not arrive");
            }
            for _ in 0..50 {
                client.send(&Command::from_request(Request::None)).unwrap();
                client.receive(SOON).unwrap();
            }
            let round_trip = *client.session().peer().round_trip();
            assert!(round_trip.count > 40);
            eprintln!("round trip on loopback: {round_trip:?}, mean {:?} ns", round_trip.mean_ns());
            client.close().unwrap();
        });
        assert_eq!(server.stop().all_rejected(), 0);
    }
}

#[test]
fn a_client_with_another_key_gets_no_answer() {
    let (server, _port) = start(Some(Key::new([1; 32])));
    let most = Duration::from_millis(300);
    let wrong = Key::new([2; 32]);
    for key in [None, Some(&wrong)] {
        let error = Client::connect(server.address(), key, most).unwrap_err();
        assert!(matches!(error, Error::NoAnswer { .. }), "{error}");
    }
    assert!(server.stop().rejected(Rejection::Tag) >= 2);
}

#[test]
fn an_address_that_others_reach_needs_a_key() {
    for address in ["0.0.0.0:0", "[::]:0"] {
        let address = address.parse().unwrap();
        let settings = ServerSettings {
            address,
            key: None,
            domain: domain(SMALL),
            sessions: SessionSettings::default(),
        };
        assert!(matches!(Server::start(settings), Err(Error::KeyNeeded(_))));
    }
    let settings = ServerSettings {
        address: "0.0.0.0:0".parse().unwrap(),
        key: Some(Key::new([1; 32])),
        domain: domain(SMALL),
        sessions: SessionSettings::default(),
    };
    assert!(Server::start(settings).is_ok());
}

#[test]
fn a_second_client_is_refused_and_the_first_one_is_not_disturbed_by_a_flood() {
    let (server, mut port) = start(None);
    let (stop, address) = (AtomicBool::new(false), server.address());
    let mut flooded = 0_u64;
    std::thread::scope(|scope| {
        let stopping = StopOnDrop(&stop);
        scope.spawn(|| cycle(&mut port, &stop));
        let mut client = Client::connect(address, None, SOON).unwrap();
        client.send(&Command::from_request(Request::Run)).unwrap();
        client.receive(SOON).unwrap();
        let flood = scope.spawn(|| {
            let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
            let (mut sent, junk) = (0_u64, [0x55; 300]);
            while !stop.load(Ordering::Relaxed) {
                sent += u64::from(socket.send_to(&junk, address).is_ok());
            }
            sent
        });
        let refused = Client::connect(address, None, Duration::from_millis(300));
        for _ in 0..100 {
            client.send(&Command::from_request(Request::None)).unwrap();
            client.receive(SOON).unwrap();
        }
        // Under a flood the answer may be lost in the socket's queue, like any other packet.
        assert!(matches!(refused, Err(Error::Refused { .. } | Error::NoAnswer { .. })));
        drop(stopping);
        flooded = flood.join().unwrap();
    });
    let counters = server.stop();
    eprintln!("{flooded} sent, {} rejected", counters.all_rejected());
    assert!(counters.rejected(Rejection::Magic) > 0 && counters.rejected(Rejection::Magic) <= flooded);
}

/// The next input, which comes soon.
fn next(port: &mut Port) -> Input {
    let begin = Instant::now();
    loop {
        if let Some(input) = port.next_input() {
            return input;
        }
        assert!(begin.elapsed() < SOON, "no input");
        std::thread::sleep(Duration::from_millis(1));
    }
}

#[test]
fn commands_come_before_the_end_of_their_session_however_late_the_cycle_looks() {
    let (server, mut port) = start(None);
    for request in [Request::SafeStop, Request::TurnOff] {
        let mut client = Client::connect(server.address(), None, SOON).unwrap();
        client.send(&Command::from_request(Request::Run)).unwrap();
        client.send(&Command::from_request(request)).unwrap();
        client.close_at_once().unwrap();
        // The next client's session has begun, too, before the cycle looks.
        let mut other = Client::connect(server.address(), None, SOON).unwrap();
        other.send(&Command::from_request(Request::None)).unwrap();
        other.close_at_once().unwrap();
        std::thread::sleep(Duration::from_millis(100));
        let [run, stop, none] =
            [Request::Run, request, Request::None].map(Command::from_request).map(Input::Command);
        for expected in [Input::Begins, run, stop, Input::Ends, Input::Begins, none, Input::Ends] {
            assert_eq!(next(&mut port), expected, "{request:?}");
        }
        assert_eq!(port.next_input(), None);
    }
}

#[test]
fn closing_waits_for_the_acknowledgement_of_a_stop_and_of_nothing_else() {
    let (server, mut port) = start(None);
    let answer = |port: &mut Port, request| {
        let mut snapshot = Snapshot::new(2, 4);
        snapshot.request = request;
        port.publish(&snapshot);
    };
    // Nobody takes what is sent: a stop is not acknowledged by a state that shows another request.
    let mut client = Client::connect(server.address(), None, SOON).unwrap();
    client.send(&Command::from_request(Request::SafeStop)).unwrap();
    answer(&mut port, Request::Run);
    let error = client.close().unwrap_err();
    assert!(matches!(error, Error::StopNotAcknowledged { request: "SafeStop", .. }), "{error}");
    // What was asked for after the stop, and what is no stop, is not waited for.
    for requests in [&[Request::Run][..], &[Request::SafeStop, Request::Hold], &[Request::None]] {
        let mut client = Client::connect(server.address(), None, SOON).unwrap();
        requests.iter().for_each(|request| client.send(&Command::from_request(*request)).unwrap());
        let begin = Instant::now();
        client.close().unwrap();
        assert!(begin.elapsed() < Duration::from_millis(500), "{requests:?}");
    }
    // A machine that takes the stop late: it is asked again meanwhile.
    while port.next_input().is_some() {}
    let mut client = Client::connect(server.address(), None, SOON).unwrap();
    client.send(&Command::from_request(Request::TurnOff)).unwrap();
    client.send(&Command::from_request(Request::None)).unwrap();
    std::thread::scope(|scope| {
        let closing = scope.spawn(|| client.close());
        std::thread::sleep(Duration::from_millis(200));
        let mut asked = 0;
        while let Some(input) = port.next_input() {
            asked += usize::from(input == Input::Command(Command::from_request(Request::TurnOff)));
        }
        assert!(asked > 1, "{asked}");
        answer(&mut port, Request::TurnOff);
        closing.join().unwrap().unwrap();
    });
}
