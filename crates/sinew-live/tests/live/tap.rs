//! A run on the page: its results do not depend on who looks, its cycle allocates nothing for them, the page
//! can stop it.

use crate::common::{PERIOD, Setup};
use allocation_counter::measure;
use sinew::control::supervisor::Mode;
use sinew_live::{RunParts, Server, ServerSettings, Source, Tap, tap};
use sinew_runtime::cycle::{Cycle, CycleRecord, Timing, VirtualClock, run};
use sinew_session::TwinPlant;
use std::net::TcpStream;
use std::sync::atomic::{AtomicBool, Ordering};
use tungstenite::client::IntoClientRequest;

fn tapped(setup: &Setup) -> (Tap, Server) {
    let (tap, run) = tap(RunParts {
        machine: setup.machine.clone(),
        trajectory: Some(setup.trajectory.clone()),
        path: "there".to_owned(),
        bus: "twin",
        simulated: true,
        timed: false,
        tension_limits: vec![[1.0, 100.0]; setup.machine.muscles.len()],
    })
    .unwrap();
    let mut run = run;
    assert_eq!(run.scene().unwrap()["fault_kinds"], serde_json::json!([]), "a run is not made to fail");
    let address = "127.0.0.1:0".parse().unwrap();
    (tap, Server::start(ServerSettings { address, source: Box::new(run), foxglove: None }).unwrap())
}

/// Bits of all estimates and commands of a run on virtual time, and its allocations.
fn run_through(setup: &Setup, mut tap: Option<&mut Tap>) -> (Vec<u64>, u64) {
    let (mut bits, stop, mut timing) = (Vec::with_capacity(1 << 20), AtomicBool::new(false), Timing::new());
    let mut cycle = setup.cycle();
    let see = |record: &CycleRecord<'_, TwinPlant>| {
        let command = &record.command.arm;
        bits.extend(command.q.iter().chain(command.estimated_tension).map(|x| x.to_bits()));
        if let Some(tap) = &mut tap {
            tap.show(record);
        }
        Ok(())
    };
    let counted = measure(|| {
        run(&mut cycle, &mut VirtualClock::default(), PERIOD, &stop, &mut timing, see).unwrap();
    });
    (bits, counted.count_total)
}

/// Looks at a page until it is gone; how many states came.
fn look(address: std::net::SocketAddr) -> usize {
    let stream = TcpStream::connect(address).unwrap();
    let mut request = format!("ws://{address}/stream").into_client_request().unwrap();
    request.headers_mut().insert("Sec-WebSocket-Protocol", "sinew.live.1".parse().unwrap());
    let (mut socket, _) = tungstenite::client::client(request, stream).unwrap();
    let mut count = 0;
    while socket.read().is_ok() {
        count += 1;
    }
    count
}

#[test]
fn a_run_is_the_same_to_the_bit_with_eight_viewers_and_its_cycle_allocates_nothing_for_them() {
    let setup = Setup::new("planar_leg", 1);
    let (alone, allocations) = run_through(&setup, None);
    let (mut tap, server) = tapped(&setup);
    let viewers: Vec<_> = (0..8)
        .map(|_| {
            let address = server.address();
            std::thread::spawn(move || look(address))
        })
        .collect();
    let (watched, with_tap) = run_through(&setup, Some(&mut tap));
    assert!(alone.len() > 10_000 && alone == watched, "{} {}", alone.len(), watched.len());
    assert_eq!(allocations, with_tap);
    drop(server);
    for viewer in viewers {
        assert!(viewer.join().unwrap() > 0);
    }
}

#[test]
fn the_page_stops_a_run_through_its_supervisor() {
    let setup = Setup::new("planar_leg", 1);
    let (mut tap, server) = tapped(&setup);
    let mut cycle: Cycle<'_, TwinPlant> = setup.cycle().with_stop(tap.stop().clone());
    let mut clock = VirtualClock::default();
    for _ in 0..400 {
        tap.show(&cycle.step(&mut clock, 0).unwrap());
    }
    assert_eq!(cycle.supervisor().mode(), Mode::Run);
    let stream = TcpStream::connect(server.address()).unwrap();
    let mut request = format!("ws://{}/stream", server.address()).into_client_request().unwrap();
    request.headers_mut().insert("Sec-WebSocket-Protocol", "sinew.live.1".parse().unwrap());
    let (mut socket, _) = tungstenite::client::client(request, stream).unwrap();
    let mut ask = |text: &str| {
        socket.send(tungstenite::Message::Text(text.into())).unwrap();
        loop {
            let message = socket.read().unwrap().into_data();
            if message.len() > 16 && message[6] == 4 {
                return String::from_utf8_lossy(&message[16..]).into_owned();
            }
        }
    };
    for refused in [
        r#"{"id":1,"command":"mode","request":"run"}"#,
        r#"{"id":2,"command":"fault","fault":"cable:0"}"#,
        r#"{"id":3,"command":"seek","time_s":1}"#,
    ] {
        let answer = ask(refused);
        assert!(answer.contains("\"ok\":false") && answer.contains("a run of its own"), "{answer}");
    }
    assert!(!tap.stop().load(Ordering::Relaxed));
    let answer = ask(r#"{"id":4,"command":"mode","request":"safe_stop"}"#);
    assert!(answer.contains("\"ok\":true"), "{answer}");
    tap.show(&cycle.step(&mut clock, 0).unwrap());
    assert_eq!(cycle.supervisor().mode(), Mode::SafeStop);
    // The page that asked for it is closed: the stop goes on, beyond the end of the motion, until its
    // cables are slack.
    drop(socket);
    drop(server);
    let mut cycles = 401;
    while !cycle.is_finished() {
        tap.show(&cycle.step(&mut clock, 0).unwrap());
        cycles += 1;
        assert!(cycles < 40_000, "{:?}", cycle.supervisor().mode());
    }
    assert_eq!(cycle.supervisor().mode(), Mode::Ready);
    assert!(cycles > 1401, "stood for a second at least: {cycles}");
}
