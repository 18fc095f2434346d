//! Sessions: beginning, end, restart, and what does not fit in one datagram.

use proptest::prelude::*;
use sinew_link::client::{Arrived, ClientSession, Greeting};
use sinew_link::host::{Domain, Outcome, SessionSettings, Sessions, WATCHERS};
use sinew_link::wire::{Datagram, MAX_DATAGRAM, Nonce};
use sinew_link::{Command, Key, RefusedBecause, Rejection, Request, Snapshot};
use std::net::SocketAddr;

const MS: u64 = 1_000_000;

fn address(port: u16) -> SocketAddr {
    SocketAddr::from(([127, 0, 0, 1], port))
}

fn host(seed: u8, joints: usize, muscles: usize) -> Sessions {
    let domain =
        Domain { joint: vec![[-1.0, 1.0]; joints], tension: vec![[0.0, 9.0]; muscles], ..Domain::default() };
    let mut count = u64::from(seed) << 32;
    let random = Box::new(move |random: &mut Nonce| {
        count += 1;
        *random = nonce(count);
        true
    });
    Sessions::new(&Key::none(), domain, SessionSettings::default(), random).unwrap()
}

fn send(host: &mut Sessions, bytes: &[u8], now: u64) -> Outcome {
    host.receive(bytes, address(1), now, &mut Datagram::default(), |_, _| true)
}

fn begin(host: &mut Sessions, nonce: u8, now: u64) -> ClientSession {
    let [mut datagram, mut reply] = [Datagram::default(), Datagram::default()];
    let greeting = Greeting::new(&Key::none(), [nonce; 16]);
    let outcome = host.receive(greeting.hello(now, &mut datagram), address(1), now, &mut reply, |_, _| true);
    assert_eq!(outcome, Outcome::Offered);
    greeting.answer(reply.bytes()).unwrap().unwrap()
}

fn command(session: &mut ClientSession, now: u64) -> Vec<u8> {
    session.command(&Command::from_request(Request::None), now, &mut Datagram::default()).to_vec()
}

#[test]
fn a_recording_of_a_session_is_refused_by_a_host_that_was_restarted() {
    let mut first = host(0, 1, 2);
    let mut session = begin(&mut first, 1, 0);
    let recorded: Vec<_> = (1..20).map(|k| command(&mut session, k * MS)).collect();
    assert!(recorded.iter().all(|bytes| send(&mut first, bytes, 0) == Outcome::Commanded));
    let mut restarted = host(100, 1, 2);
    let hello = Greeting::new(&Key::none(), [1; 16]).hello(0, &mut Datagram::default()).to_vec();
    assert_eq!(send(&mut restarted, &hello, 0), Outcome::Offered, "a Hello can be repeated by anyone");
    for bytes in &recorded {
        assert_eq!(send(&mut restarted, bytes, 0), Outcome::Rejected(Rejection::Session));
    }
    assert_eq!(restarted.generation(), 0, "no session has begun");
}

#[test]
fn a_client_that_was_killed_comes_back_after_its_session_expired_and_not_before() {
    let mut host = host(0, 1, 2);
    let mut killed = begin(&mut host, 1, 0);
    assert_eq!(send(&mut host, &command(&mut killed, 0), 10 * MS), Outcome::Commanded);
    let hello = Greeting::new(&Key::none(), [2; 16]).hello(0, &mut Datagram::default()).to_vec();
    assert_eq!(send(&mut host, &hello, 500 * MS), Outcome::Rejected(Rejection::SecondClient));
    assert_eq!(host.generation(), 1);
    let mut again = begin(&mut host, 2, 520 * MS);
    assert_eq!(host.generation(), 0, "a session begins with its first command");
    assert_eq!(send(&mut host, &command(&mut again, 0), 530 * MS), Outcome::Commanded);
    assert_eq!(host.generation(), 2);
    let old = command(&mut killed, 600 * MS);
    assert_eq!(send(&mut host, &old, 600 * MS), Outcome::Rejected(Rejection::Session));
}

#[test]
fn a_goodbye_frees_the_session_at_once() {
    let mut host = host(0, 1, 2);
    let mut session = begin(&mut host, 1, 0);
    send(&mut host, &command(&mut session, 0), 0);
    let goodbye = session.goodbye(MS, &mut Datagram::default()).to_vec();
    assert_eq!(send(&mut host, &goodbye, MS), Outcome::Ended);
    assert_eq!(host.generation(), 0);
    begin(&mut host, 2, 2 * MS);
}

#[test]
fn several_clients_watch_beside_the_one_that_commands() {
    let mut host = host(0, 1, 2);
    let [mut datagram, mut reply] = [Datagram::default(), Datagram::default()];
    let mut commanding = begin(&mut host, 1, 0);
    assert_eq!(send(&mut host, &command(&mut commanding, 0), 0), Outcome::Commanded);
    let mut watchers = Vec::new();
    for k in 0..=WATCHERS as u8 {
        let greeting = Greeting::new(&Key::none(), [10 + k; 16]).watching();
        let hello = greeting.hello(0, &mut datagram).to_vec();
        let outcome = host.receive(&hello, address(1), 0, &mut reply, |_, _| true);
        if k == WATCHERS as u8 {
            assert_eq!(outcome, Outcome::Rejected(Rejection::TooManyWatchers));
            assert_eq!(greeting.answer(reply.bytes()).unwrap().err(), Some(RefusedBecause::TooManyWatchers));
            break;
        }
        let mut watcher = greeting.answer(reply.bytes()).unwrap().unwrap();
        if k == 0 {
            let forbidden = command(&mut watcher, 0);
            assert_eq!(send(&mut host, &forbidden, 0), Outcome::Rejected(Rejection::Role));
        }
        let watch = watcher.watch(0, &mut datagram).to_vec();
        assert_eq!(send(&mut host, &watch, 0), Outcome::Watched);
        watchers.push(watcher);
    }
    assert_eq!((host.watchers(), host.generation()), (WATCHERS, 1));
    let mut snapshot = Snapshot::new(1, 2);
    snapshot.cycle = 7;
    for (k, watcher) in watchers.iter_mut().enumerate() {
        host.state_for_watcher(k, &snapshot, &mut Some([0, 0]), 0, &mut datagram).unwrap();
        assert_eq!(watcher.receive(datagram.bytes(), 0), Ok(Arrived::Complete));
        assert_eq!(watcher.state().cycle, 7);
    }
    let watch = watchers[0].watch(400 * MS, &mut datagram).to_vec();
    assert_eq!(send(&mut host, &watch, 400 * MS), Outcome::Watched);
    host.expire(501 * MS);
    assert_eq!((host.watchers(), host.generation()), (1, 0), "silent sessions end");
    let goodbye = watchers[0].goodbye(502 * MS, &mut datagram).to_vec();
    assert_eq!(send(&mut host, &goodbye, 502 * MS), Outcome::Ended);
    assert_eq!(host.watchers(), 0);
}

#[test]
fn more_commands_than_allowed_are_rejected_and_counted() {
    let mut host = host(0, 1, 2);
    let mut session = begin(&mut host, 1, 0);
    let outcomes: Vec<_> = (0..1000).map(|_| send(&mut host, &command(&mut session, 0), MS)).collect();
    let taken = outcomes.iter().filter(|outcome| **outcome == Outcome::Commanded).count();
    assert_eq!(taken, 400, "a tenth of a second's worth");
    assert_eq!(host.counters().rejected(Rejection::Rate), 600);
}

fn hello(nonce: Nonce) -> Vec<u8> {
    Greeting::new(&Key::none(), nonce).hello(0, &mut Datagram::default()).to_vec()
}

/// A random number of a client.
fn nonce(number: u64) -> Nonce {
    std::array::from_fn(|k| (number >> (8 * (k % 8))) as u8 ^ k as u8)
}

#[test]
fn one_hello_is_answered_fifty_times_a_second_and_to_its_sender_whoever_repeats_it() {
    let mut host = host(0, 1, 2);
    let mut ask = |port: u16, now: u64| {
        host.receive(&hello([1; 16]), address(port), now, &mut Datagram::default(), |_, _| true)
    };
    assert_eq!(ask(1, 0), Outcome::Offered);
    let mut answered = |ports: std::ops::Range<u16>| {
        ports.map(|port| ask(port, MS)).filter(|outcome| *outcome == Outcome::Offered).count()
    };
    assert_eq!(answered(2..1000), 50, "all others together");
    let own = (0..1000).map(|_| answered(1..2)).sum::<usize>();
    assert!((48..=50).contains(&own), "{own} to the first");
    assert!(host.counters().rejected(Rejection::Rate) > 1800);
}

#[test]
fn a_flood_of_replayed_hellos_keeps_no_new_client_out() {
    let mut host = host(0, 1, 2);
    // A thousand were recorded, among them those of two sessions of this host.
    let recorded: Vec<_> = (0..1000).map(|k| hello(nonce(k))).collect();
    for k in 0..2_u64 {
        let greeting = Greeting::new(&Key::none(), nonce(k));
        let mut reply = Datagram::default();
        host.receive(&recorded[k as usize], address(1), k, &mut reply, |_, _| true);
        let mut session = greeting.answer(reply.bytes()).unwrap().unwrap();
        assert_eq!(send(&mut host, &command(&mut session, 0), k), Outcome::Commanded);
        let goodbye = session.goodbye(MS, &mut Datagram::default()).to_vec();
        assert_eq!(send(&mut host, &goodbye, MS), Outcome::Ended);
    }
    let mut draws = 7_u64;
    let mut flood = |host: &mut Sessions, now: u64| {
        for _ in 0..500 {
            draws = draws.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let hello = &recorded[(draws >> 33) as usize % recorded.len()];
            let from = address((draws >> 48) as u16);
            host.receive(hello, from, now, &mut Datagram::default(), |_, _| true);
        }
    };
    // A million a second: every new client begins its session in the 5 ms that an answer may take.
    for client in 0..40_u64 {
        let start = 20 * MS * (client + 1);
        let greeting = Greeting::new(&Key::none(), nonce(1_000_000 + client));
        let bytes = greeting.hello(start, &mut Datagram::default()).to_vec();
        let mut reply = Datagram::default();
        flood(&mut host, start);
        assert_eq!(host.receive(&bytes, address(1), start, &mut reply, |_, _| true), Outcome::Offered);
        let mut session = greeting.answer(reply.bytes()).unwrap().unwrap();
        (0..10).for_each(|k| flood(&mut host, start + k * MS / 2));
        assert_eq!(send(&mut host, &command(&mut session, start), start + 5 * MS), Outcome::Commanded);
        let goodbye = session.goodbye(start + 6 * MS, &mut Datagram::default()).to_vec();
        assert_eq!(send(&mut host, &goodbye, start + 6 * MS), Outcome::Ended);
    }
    let begun = hello(nonce(0));
    assert_eq!(send(&mut host, &begun, 0), Outcome::Rejected(Rejection::Replayed), "of a session that began");
}

#[test]
fn both_ends_know_loss_and_round_trip() {
    let mut host = host(0, 1, 2);
    let mut session = begin(&mut host, 1, 0);
    let (mut snapshot, mut datagram) = (Snapshot::new(1, 2), Datagram::default());
    for k in 1..=100_u64 {
        // 3 ms there, 2 ms in the host, 4 ms back, clocks 1 s apart; every tenth command and every fifth
        // state is lost.
        let now = 10 * MS * k;
        let bytes = command(&mut session, now);
        if k % 10 != 0 {
            send(&mut host, &bytes, now + 1_003 * MS);
        }
        snapshot.cycle = k;
        host.state(&snapshot, &mut Some([0, 0]), now + 1_005 * MS, &mut datagram).unwrap();
        if k % 5 != 0 {
            assert_eq!(session.receive(datagram.bytes(), now + 9 * MS), Ok(Arrived::Complete));
        }
    }
    assert_eq!(session.peer().lost(), 19, "20 of 100 states, of which the last is not yet missed");
    assert_eq!(session.counts().lost, 9, "10 of 100 commands, of which the last is not yet missed");
    let round_trip = session.peer().round_trip();
    assert_eq!(
        [round_trip.min_ns, round_trip.max_ns],
        [7 * MS, 7 * MS],
        "the time in the host does not count"
    );
}

proptest! {
    #[test]
    fn a_state_of_any_machine_arrives_whole_in_datagrams_that_nobody_fragments(
        joints in 0_usize..=64, muscles in 0_usize..=128, seed in any::<u32>(),
    ) {
        let mut host = host(0, joints, muscles);
        let mut session = begin(&mut host, 1, 0);
        send(&mut host, &command(&mut session, 0), 0);
        let mut snapshot = Snapshot::new(joints, muscles);
        snapshot.cycle = 5;
        let mut number = f64::from(seed);
        let mut next = || { number += 0.5; number };
        for joint in snapshot.joints_mut() {
            joint.numbers_mut().into_iter().for_each(|number| *number = next());
        }
        for muscle in snapshot.muscles_mut() {
            muscle.numbers_mut().into_iter().for_each(|number| *number = next());
        }
        let (mut part, mut datagram, mut count) = (Some([0, 0]), Datagram::default(), 0);
        while part.is_some() {
            host.state(&snapshot, &mut part, 0, &mut datagram).unwrap();
            prop_assert!(!datagram.bytes().is_empty() && datagram.bytes().len() <= MAX_DATAGRAM);
            count += 1;
            let expected = if part.is_some() { Arrived::Part } else { Arrived::Complete };
            prop_assert_eq!(session.receive(datagram.bytes(), 0), Ok(expected));
        }
        prop_assert_eq!(count, snapshot.parts());
        // Places beyond the machine's are not a number, which equals nothing.
        prop_assert_eq!(session.state().cycle, snapshot.cycle);
        prop_assert_eq!(session.state().joints(), snapshot.joints());
        prop_assert_eq!(session.state().muscles(), snapshot.muscles());
    }
}

#[test]
fn a_machine_that_does_not_fit_is_refused_by_name() {
    for (joints, muscles, name) in [(65, 1, "joints"), (1, 129, "muscles")] {
        let domain =
            Domain { joint: vec![[0.0; 2]; joints], tension: vec![[0.0; 2]; muscles], ..Domain::default() };
        let error =
            Sessions::new(&Key::none(), domain, SessionSettings::default(), Box::new(|_| true)).unwrap_err();
        assert!(error.to_string().starts_with(name), "{error}");
    }
}
