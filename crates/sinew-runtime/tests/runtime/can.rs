//! Machines behind simulated drives on CAN, in virtual time; decoders on whatever comes.

use crate::can_common::{Act, MIDDLE, TIMED_OUT, Watched, bus, setup, setup_on, stopped};
use crate::common::{Setup, bare_machine, machine, tracked};
use proptest::prelude::*;
use sinew::drive::DriveCommand;
use sinew::machine::Machine;
use sinew_runtime::can::fdcanusb::Fdcanusb;
use sinew_runtime::can::slcan::{Decoder, Line, encode};
use sinew_runtime::can::{
    CanBus, CanDevice, CanFault, CanNode, Dialect, FoundNode, Frame, Link, MitMotor, Protocol, SdoClient,
    SdoError, scan, scan_fd, words,
};
use sinew_segment::CanDrive;
use sinew_session::{BusFault, Feedback, Plant};

/// s.
const PERIOD: f64 = 4e-3;
pub(crate) const PROTOCOLS: [Protocol; 4] =
    [Protocol::Canopen, Protocol::Cansimple, Protocol::Moteus, Protocol::Mit];
const NAMES: [&str; 3] = ["bench_joint", "planar_leg", "finger"];

/// What a node on CANSimple that heard nothing for the time of its watchdog shows.
const WATCHDOG_EXPIRED: u32 = 1 << 24;

#[test]
fn a_machine_tracks_behind_drives_on_can_as_without_wires() {
    for protocol in PROTOCOLS {
        for name in NAMES {
            let (setup, nodes) = setup_on(name, protocol);
            let (direct, _) = tracked(&setup, setup.twin_bus());
            let (wired, digest) = tracked(&setup, bus(&setup, &nodes));
            println!("{name}: twin {direct:?}, {protocol:?} {wired:?}");
            assert!(wired.as_good_as(&direct, name), "{name} {protocol:?}");
            assert_eq!(tracked(&setup, bus(&setup, &nodes)).1, digest, "{name}: bits of a second run");
        }
    }
}

/// In real time answers come late now and then; gains that knew nothing of the age of a bus's readings went
/// into a limit cycle from a millisecond more on.
#[test]
fn drives_on_can_are_still_tracked_with_a_period_of_delay_that_their_gains_do_not_know() {
    let late = |delay_ms| {
        let mut machine = bare_machine("bench_joint");
        machine.muscles.iter_mut().for_each(|muscle| muscle.drive.delay_ms = delay_ms);
        let (setup, nodes) = setup("bench_joint");
        let setup = Setup { plant: Setup::new(machine, 3, &[]).plant, ..setup };
        tracked(&setup, bus(&setup, &nodes)).0
    };
    let [usual, late] = [0.0, 1e3 * PERIOD].map(late);
    println!("{usual:?} {late:?}");
    assert!(late.mean < 2.0 * usual.mean && late.max < 2.0 * usual.max, "{usual:?} {late:?}");
}

#[test]
fn what_fails_in_the_middle_of_a_motion_is_found_named_and_leads_to_a_safe_stop() {
    let not_ready = |code| BusFault::NotReady { device: 1, code, muscle: Some(1) };
    let drive = |code| BusFault::Drive { muscle: 1, code };
    // The second node, in the middle of the motion; cycles until the stop, at most: a heartbeat is missed
    // after four of its intervals, and on CANSimple says what is wrong.
    let cases = [
        (Act::Fault(1, CanFault::Silent), not_ready(0), "Drive(1)", [5, 5, 5, 5]),
        (Act::Fault(1, CanFault::NoHeartbeat), not_ready(1), "Drive(1)", [65, 40, 0, 0]),
        (Act::Restart(1), not_ready(2), "Drive(1)", [5, 9, 5, 5]),
        (Act::Raise(1, 0x2310), drive(0x2310), "Drive(1)", [5, 0, 0, 0]),
        (Act::Raise(1, 1 << 13), drive(14), "Drive(1)", [0, 9, 0, 0]),
        (Act::Raise(1, 38), drive(0x126), "Drive(1)", [0, 0, 5, 0]),
        (Act::Raise(1, 12), drive(0x21c), "Drive(1)", [0, 0, 0, 5]),
        (Act::Cut, BusFault::Lost, "Bus", [5, 5, 5, 5]),
        (Act::Unplug, BusFault::Lost, "Bus", [5, 5, 5, 5]),
    ];
    for (k, protocol) in PROTOCOLS.into_iter().enumerate() {
        let (setup, nodes) = setup_on("planar_leg", protocol);
        for (act, expected, named, within) in cases {
            let within = within[k];
            if within == 0 {
                continue;
            }
            let watched = Watched::new(&setup, &nodes).with(MIDDLE, act);
            let (cycle, exchange, fault) = stopped(&setup, &watched, &nodes).unwrap();
            println!("{protocol:?} {act:?}: after {} cycles, {fault}, {exchange:?}", cycle - MIDDLE);
            assert!((MIDDLE..MIDDLE + within).contains(&cycle), "{protocol:?} {act:?}: {cycle}");
            assert!(fault.starts_with(named), "{protocol:?} {act:?}: {fault}");
            assert_eq!(exchange.fault, Some(expected), "{protocol:?} {act:?}");
            println!("    {}", words(expected));
        }
    }
    assert_eq!(words(drive(0x126)), "reports over temperature (fault 38)");
    assert_eq!(words(drive(0x10b)), "reports no command within its watchdog timeout (mode 11)");
    assert_eq!(words(drive(14)), "reports MOTOR_OVER_TEMP (bit 13)");
    assert_eq!(words(drive(0x21c)), "reports motor over temperature (error 12)");
}

#[test]
fn frames_that_are_lost_now_and_then_are_bridged() {
    for protocol in PROTOCOLS {
        let (setup, nodes) = setup_on("planar_leg", protocol);
        let watched = Watched::new(&setup, &nodes).with(10, Act::Fault(1, CanFault::Loses(50)));
        assert_eq!(stopped(&setup, &watched, &nodes), None, "{protocol:?}");
    }
}

#[test]
fn a_computer_that_falls_silent_leaves_no_drive_with_power() {
    for (protocol, error) in PROTOCOLS.into_iter().zip([0x8130, WATCHDOG_EXPIRED, TIMED_OUT, 0]) {
        let (setup, nodes) = setup_on("finger", protocol);
        let watched = Watched::new(&setup, &nodes);
        let mut bus = CanBus::start(watched.clone(), &setup.machine, &nodes).unwrap();
        let powered = |powered| watched.nodes(CanNode::has_power) == vec![powered; nodes.len()];
        let period = setup.machine.period_ns();
        // None waits for a master that takes its time before the first command.
        (0..200).for_each(|_| watched.0.borrow_mut().link.begin_cycle(period));
        assert!(powered(false), "{protocol:?}: no power before the first command");
        let mut feedback = Feedback::new(nodes.len(), 0);
        for _ in 0..40 {
            bus.read(&mut feedback);
            bus.write(&vec![DriveCommand::Velocity(0.0); nodes.len()]);
        }
        assert!(powered(true), "{protocol:?}");
        // As with a process that is killed: nobody brings the machine to rest.
        std::mem::forget(bus);
        let mut link = watched.0.borrow_mut();
        (0..30).for_each(|_| link.link.begin_cycle(period));
        drop(link);
        // A moteus holds still then, with power, as its configuration from the factory has it.
        let powered = protocol == Protocol::Moteus;
        let faults = watched.nodes(|node| (node.has_power(), node.error()));
        assert_eq!(faults, vec![(powered, error); nodes.len()]);
        assert!((0..nodes.len()).all(|k| !watched.moves(k)), "{protocol:?}");
    }
}

#[test]
fn the_readings_of_the_others_count_while_a_node_is_silent() {
    for (protocol, silent) in PROTOCOLS.iter().flat_map(|p| (0..5).map(move |k| (*p, k))) {
        let (setup, nodes) = setup_on("finger", protocol);
        let watched = Watched::new(&setup, &nodes);
        let mut bus = CanBus::start(watched.clone(), &setup.machine, &nodes).unwrap();
        let mut feedback = Feedback::new(nodes.len(), setup.machine.encoders.len());
        let begun = watched.0.borrow().cycle;
        let _ = watched.clone().with(begun + 2, Act::Fault(silent, CanFault::Silent));
        let mut missing = Vec::new();
        for _ in 0..8 {
            bus.read(&mut feedback);
            missing.push(feedback.motor.iter().filter(|position| position.is_nan()).count());
            bus.write(&vec![DriveCommand::Velocity(0.0); nodes.len()]);
        }
        assert_eq!((missing[0], missing[5], missing[7]), (0, 1, 1), "node {silent}: {missing:?}");
    }
}

#[test]
fn what_is_wrong_is_refused_before_anything_moves_with_device_and_value() {
    let (setup, nodes) = setup("finger");
    let start = |nodes: &[CanDevice], watched: &Watched| {
        let refused = CanBus::start(watched.clone(), &setup.machine, nodes);
        refused.err().map(|error| error.to_string()).unwrap_or_default()
    };
    let name = nodes[2].name.as_str();
    let with = |change: &dyn Fn(&mut CanDevice)| {
        let mut changed = nodes.clone();
        change(&mut changed[2]);
        changed
    };
    let fine = || Watched::new(&setup, &nodes);
    let slow: Vec<_> = nodes.iter().map(|node| CanDevice { bitrate: 125_000, ..node.clone() }).collect();
    // Two nodes of one id on the wire, of which the machine file knows one.
    let twice = Watched::new(&setup, &with(&|node| node.node = 1));
    let damaged = |damage| {
        let watched = fine();
        watched.0.borrow_mut().damage = Some(damage);
        watched
    };
    let other = |frame: &Frame| match frame.octets() {
        [0x43, 0x18, rest @ ..] => Frame::new(frame.id(), &[&[0x43, 0x19], rest].concat()),
        _ => *frame,
    };
    let short = |frame: &Frame| Frame::new(frame.id(), &frame.octets()[..frame.octets().len().min(3)]);
    let known = [Some(0x0005_1e37), Some(0x0001_0402)];
    let cases: [(Watched, Vec<CanDevice>, &[&str]); 8] = [
        (fine(), with(&|node| node.node = 77), &[name, "id 77", "1000000", "no node answers"]),
        (fine(), with(&|node| node.node = 1), &[name, "a node of its own"]),
        (fine(), with(&|node| node.bitrate = 500_000), &[name, "the same bitrate"]),
        (fine(), with(&|node| node.identity = [Some(0x1d), None]), &[name, "vendor 0x51e37", "0x1d"]),
        (twice, nodes.clone(), &["id 1", "two nodes answer"]),
        (damaged(short), nodes.clone(), &["no node answers"]),
        (damaged(other), with(&|node| node.identity = known), &[name, "no node answers"]),
        (fine(), slow, &["125000 bit/s", "4.000 ms"]),
    ];
    for (watched, nodes, parts) in cases {
        let message = start(&nodes, &watched);
        assert!(parts.iter().all(|part| message.contains(part)), "{message}: {parts:?}");
        assert!(watched.nodes(CanNode::has_power).iter().all(|powered| !powered));
    }
    assert_eq!(start(&with(&|node| node.identity = known), &fine()), "");
}

#[test]
fn what_is_wrong_with_an_axis_on_cansimple_is_refused_before_anything_moves() {
    let (setup, nodes) = setup_on("finger", Protocol::Cansimple);
    let name = nodes[2].name.as_str();
    let with = |change: &dyn Fn(&mut CanDevice)| {
        let mut changed = nodes.clone();
        change(&mut changed[2]);
        changed
    };
    let fine = || Watched::new(&setup, &nodes);
    let on_wire = |change: &dyn Fn(&mut CanNode)| {
        let watched = fine();
        change(watched.0.borrow_mut().link.machine_mut().nodes_mut().nth(2).unwrap());
        watched
    };
    let configured = |watchdog, heartbeat| {
        on_wire(&move |node| match node.drive_mut() {
            CanDrive::Cansimple(axis) => axis.configure(watchdog, heartbeat),
            CanDrive::Canopen(_) | CanDrive::Moteus(_) | CanDrive::Mit(_) => unreachable!(),
        })
    };
    let heartbeat = 20_000_000;
    let damaged = |damage| {
        let watched = fine();
        watched.0.borrow_mut().damage = Some(damage);
        watched
    };
    let old = |frame: &Frame| match (frame.id() & 0x1f, frame.octets()) {
        (0, [head @ .., _, _, _]) => Frame::new(frame.id(), &[head, &[5, 6, 0]].concat()),
        _ => *frame,
    };
    let short = |frame: &Frame| Frame::new(frame.id(), &frame.octets()[..frame.octets().len().min(3)]);
    let nowhere = |frame: &Frame| match frame.id() & 0x1f {
        9 => Frame::new(frame.id(), &[0, 0, 0xc0, 0x7f, 0, 0, 0, 0]),
        _ => *frame,
    };
    let mixed = with(&|node| node.protocol = Protocol::Canopen);
    let twice = Watched::new(&setup, &with(&|node| node.node = 1));
    let slow: Vec<_> = nodes.iter().map(|node| CanDevice { bitrate: 500_000, ..node.clone() }).collect();
    let mute = on_wire(&|node| node.set_fault(Some(CanFault::NoHeartbeat)));
    let cases: [(Watched, Vec<CanDevice>, &[&str]); 12] = [
        (fine(), with(&|node| node.node = 62), &[name, "id 62", "1000000", "no node answers"]),
        (fine(), with(&|node| node.node = 1), &[name, "a node of its own"]),
        (fine(), mixed, &[name, "the same protocol"]),
        (twice, nodes.clone(), &["id 1", "two nodes answer"]),
        (damaged(short), nodes.clone(), &["no node answers"]),
        (damaged(old), nodes.clone(), &["firmware 0.5.6", "0.6 or later"]),
        (damaged(nowhere), nodes.clone(), &["no position"]),
        (configured(0, heartbeat), nodes.clone(), &[name, "keeps its power for 0.030 s", "at most 0.02 s"]),
        (configured(40_000_000, heartbeat), nodes.clone(), &[name, "keeps its power", "watchdog_timeout"]),
        (configured(heartbeat, 5 * heartbeat), nodes.clone(), &[name, "heartbeats in 0.2 s", "at most 20"]),
        (mute, nodes.clone(), &[name, "0 heartbeats"]),
        (fine(), slow, &["500000 bit/s", "4.000 ms"]),
    ];
    for (watched, nodes, parts) in cases {
        let before = watched.0.borrow_mut().link.machine_mut().arm().reading().motor.clone();
        let refused = CanBus::start(watched.clone(), &setup.machine, &nodes);
        let message = refused.err().map(|error| error.to_string()).unwrap_or_default();
        println!("{message}");
        assert!(parts.iter().all(|part| message.contains(part)), "{message}: {parts:?}");
        assert!(watched.nodes(CanNode::has_power).iter().all(|powered| !powered), "{message}");
        let after = watched.0.borrow_mut().link.machine_mut().arm().reading().motor.clone();
        assert!(before.iter().zip(&after).all(|(before, after)| (before - after).abs() < 1e-4), "{message}");
    }
    assert!(CanBus::start(fine(), &setup.machine, &nodes).is_ok());
}

/// A file of parameters as ODrive offers it, with those of the simulated axes, of a firmware.
fn endpoints(name: &str, firmware: &str, change: impl Fn(&mut String)) -> String {
    let rows = sinew_segment::Cansimple::endpoints().map(|(name, id, kind)| {
        format!("\"{name}\": {{\"id\": {id}, \"type\": \"{kind}\", \"access\": \"rw\"}}")
    });
    let mut text = format!("{{\"fw_version\": \"{firmware}\", \"endpoints\": {{{}}}}}", rows.join(",\n"));
    change(&mut text);
    let path = std::env::temp_dir().join(format!("sinew-{}-{name}.json", std::process::id()));
    std::fs::write(&path, text).unwrap();
    path.display().to_string()
}

#[test]
fn parameters_of_an_axis_are_set_and_read_back_by_the_numbers_of_its_firmware() {
    let (setup, nodes) = setup_on("finger", Protocol::Cansimple);
    let start = |path: &str| {
        let nodes: Vec<_> =
            nodes.iter().map(|node| CanDevice { endpoints: Some(path.to_owned()), ..node.clone() }).collect();
        let watched = Watched::new(&setup, &nodes);
        for node in watched.0.borrow_mut().link.machine_mut().nodes_mut() {
            // As from the factory: no watchdog, rare heartbeats.
            let CanDrive::Cansimple(axis) = node.drive_mut() else { unreachable!() };
            axis.configure(0, 100_000_000);
        }
        let refused = CanBus::start(watched, &setup.machine, &nodes);
        std::fs::remove_file(path).unwrap_or_default();
        refused.err().map(|error| error.to_string()).unwrap_or_default()
    };
    assert_eq!(start(&endpoints("fine", "0.6.10", |_| {})), "");
    let without = |text: &mut String| *text = text.replace("enable_watchdog", "enable_dog");
    let strange = |text: &mut String| *text = text.replace("259", "2590");
    for (path, parts) in [
        ("/nowhere/flat_endpoints.json".to_owned(), ["/nowhere/flat_endpoints.json", "No such file"]),
        (endpoints("other", "0.6.11", |_| {}), ["firmware 0.6.10", "expected 0.6.11"]),
        (endpoints("without", "0.6.10", without), ["axis0.config.enable_watchdog", "is missing"]),
        (endpoints("strange", "0.6.10", strange), [&nodes[0].name, "parameter 0xa1e"]),
        (endpoints("cut", "0.6.10", |text| text.truncate(60)), ["cut.json", "EOF"]),
        (endpoints("list", "0.6.10", |text| *text = "[1]".to_owned()), ["list.json", "fw_version"]),
    ] {
        let message = start(&path);
        assert!(parts.iter().all(|part| message.contains(part)), "{message}: {parts:?}");
    }
}

#[test]
fn a_machine_with_other_sensors_than_its_drives_is_refused_by_name() {
    let setup = Setup::new(Machine { period: PERIOD, ..machine("finger") }, 3, &[]);
    let nodes = CanDevice::simulated(&setup.machine);
    let refused = CanBus::start(Watched::new(&setup, &nodes), &setup.machine, &nodes);
    let message = refused.err().unwrap().to_string();
    assert!(message.contains("load cell of flexor_profundus") && message.contains("none"), "{message}");
}

#[test]
fn nodes_are_listed_and_their_objects_read_written_and_refused() {
    let (setup, nodes) = setup("planar_leg");
    let mut watched = Watched::new(&setup, &nodes);
    let found = scan(&mut watched).unwrap();
    let drive = |node| {
        let (identity, name) = ([0x0005_1e37, 0x0001_0402], Some("SIM-DRV1".to_owned()));
        FoundNode::Canopen { node, profile: 402, identity, name }
    };
    assert_eq!(found, [1, 2, 3, 4].map(drive));
    let mut client = SdoClient::new(&mut watched);
    assert_eq!(client.read(2, (0x100a, 0)).unwrap(), env!("CARGO_PKG_VERSION").as_bytes(), "in segments");
    client.write(2, (0x6060, 0), &[9]).unwrap();
    assert_eq!(client.number(2, (0x6060, 0)).unwrap(), 9);
    let code = |result: Result<(), SdoError>| match result {
        Err(SdoError::Abort(code)) => code,
        other => panic!("{other:?}"),
    };
    assert_eq!(code(client.write(2, (0x6041, 0), &[0, 0])), 0x0601_0002);
    assert_eq!(code(client.write(2, (0x2000, 0), &[0, 0])), 0x0602_0000);
    assert_eq!(code(client.write(2, (0x6060, 0), &[9; 20])), 0x0607_0012, "in segments");
    assert!(matches!(client.number(9, (0x1000, 0)), Err(SdoError::Silent)));
}

#[test]
fn axes_on_cansimple_are_listed_and_are_not_asked_as_nodes_on_canopen() {
    let (setup, mut nodes) = setup_on("planar_leg", Protocol::Cansimple);
    // To these identifiers a request of CANopen would be a command.
    nodes.iter_mut().zip([0, 48, 51, 62]).for_each(|(node, id)| node.node = id);
    let mut watched = Watched::new(&setup, &nodes);
    let found = scan(&mut watched).unwrap();
    let axis = |node| FoundNode::Cansimple { node, hardware: [4, 4, 58], firmware: [0, 6, 10] };
    assert_eq!(found, [0, 48, 51, 62].map(axis));
    assert_eq!(watched.nodes(CanNode::error), [0; 4], "none was told to stop");
}

/// A frame of CAN FD with other octets at a place.
fn changed(frame: &Frame, at: usize, octets: &[u8]) -> Frame {
    let mut all = frame.octets().to_vec();
    all[at..at + octets.len()].copy_from_slice(octets);
    Frame::fd(frame.id(), &all)
}

#[test]
fn what_is_wrong_with_a_moteus_is_refused_before_anything_moves() {
    let (setup, nodes) = setup_on("finger", Protocol::Moteus);
    let name = nodes[2].name.as_str();
    let with = |change: &dyn Fn(&mut CanDevice)| {
        let mut changed = nodes.clone();
        change(&mut changed[2]);
        changed
    };
    let fine = || Watched::new(&setup, &nodes);
    let damaged = |damage| {
        let watched = fine();
        watched.0.borrow_mut().damage = Some(damage);
        watched
    };
    let deaf = fine();
    for node in deaf.0.borrow_mut().link.machine_mut().nodes_mut() {
        let CanDrive::Moteus(node) = node.drive_mut() else { unreachable!() };
        node.set_watching(false);
    }
    let classical = fine();
    classical.0.borrow_mut().fd = false;
    let twice = Watched::new(&setup, &with(&|node| node.node = 1));
    // Register map 4 in place of 5; a position that is none.
    let older = |frame: &Frame| match frame.octets() {
        [0x2b, 0x80, 2, ..] => changed(frame, 11, &[4]),
        _ => *frame,
    };
    let nowhere = |frame: &Frame| match frame.octets() {
        [0x21, 0, _, 0x2f, 1, ..] => changed(frame, 5, &f32::NAN.to_le_bytes()),
        _ => *frame,
    };
    let broken = |frame: &Frame| match frame.octets() {
        // Of motors with 5 nodes, all.
        [0x21, 0, _, 0x2f, 1, ..] => changed(&changed(frame, 2, &[1]), 21, &[36]),
        _ => *frame,
    };
    let short = |frame: &Frame| Frame::fd(frame.id(), &frame.octets()[..frame.octets().len().min(8)]);
    // Only mode 0 is known of one that has no power in any other.
    let never = |frame: &Frame| match frame.octets() {
        [0x21, 0, _, 0x2f, 1, ..] => changed(frame, 2, &[0]),
        _ => *frame,
    };
    let cases: [(Watched, Vec<CanDevice>, &[&str]); 10] = [
        (fine(), with(&|node| node.node = 77), &[name, "id 77", "no node answers"]),
        (fine(), with(&|node| node.node = 1), &[name, "a node of its own"]),
        (fine(), with(&|node| node.protocol = Protocol::Canopen), &[name, "the same protocol"]),
        (twice, nodes.clone(), &["id 1", "two nodes answer"]),
        (damaged(older), nodes.clone(), &["register map 4", "expected 5"]),
        (damaged(nowhere), nodes.clone(), &["no position"]),
        (damaged(broken), nodes.clone(), &["motor not configured (fault 36)", "mode 0 (stopped)"]),
        (damaged(short), nodes.clone(), &["no node answers"]),
        (damaged(never), nodes.clone(), &["mode 0 (stopped)", "mode 10 (position)"]),
        (classical, nodes.clone(), &["no CAN FD", "fdcanusb"]),
    ];
    let deaf = (deaf, nodes.clone(), &["mode 10 (position) 0.030 s after", "after 0.02 s"][..]);
    for (watched, nodes, parts) in cases.into_iter().chain([deaf]) {
        let before = watched.0.borrow_mut().link.machine_mut().arm().reading().motor.clone();
        let refused = CanBus::start(watched.clone(), &setup.machine, &nodes);
        let message = refused.err().map(|error| error.to_string()).unwrap_or_default();
        println!("{message}");
        assert!(parts.iter().all(|part| message.contains(part)), "{message}: {parts:?}");
        let moves = (0..nodes.len()).any(|k| watched.moves(k));
        assert!(!moves, "{message}");
        let after = watched.0.borrow_mut().link.machine_mut().arm().reading().motor.clone();
        assert!(before.iter().zip(&after).all(|(before, after)| (before - after).abs() < 1e-4), "{message}");
    }
    assert!(CanBus::start(fine(), &setup.machine, &nodes).is_ok());
}

#[test]
fn moteus_controllers_are_listed() {
    let (setup, mut nodes) = setup_on("planar_leg", Protocol::Moteus);
    nodes.iter_mut().zip([1, 16, 77, 126]).for_each(|(node, id)| node.node = id);
    let found = scan_fd(&mut Watched::new(&setup, &nodes)).unwrap();
    let of = |node| FoundNode::Moteus { node, model: 0x204, firmware: 0x100 };
    assert_eq!(found, [1, 16, 77, 126].map(of));
}

fn fd_frames() -> impl Strategy<Value = Frame> {
    (any::<u16>(), proptest::collection::vec(any::<u8>(), 0..=64))
        .prop_map(|(id, octets)| Frame::fd(id, &octets))
}

fn frames() -> impl Strategy<Value = Frame> {
    let id = prop_oneof![Just(0_u16), Just(0x80), 0x581_u16..0x585, 0x601_u16..0x605, 0_u16..0x800];
    (id, proptest::collection::vec(any::<u8>(), 0..=8), any::<bool>()).prop_map(|(id, octets, remote)| {
        if remote { Frame::remote(id, octets.len()) } else { Frame::new(id, &octets) }
    })
}

/// Octets in which lines of slcan are frequent.
fn text() -> impl Strategy<Value = u8> {
    prop_oneof![
        Just(b'\r'),
        Just(b't'),
        Just(b'r'),
        Just(b'T'),
        Just(7),
        proptest::char::range('0', '9').prop_map(|c| c as u8),
        any::<u8>()
    ]
}

proptest! {
    #[test]
    fn any_frames_come_back_from_their_text(frames in proptest::collection::vec(frames(), 0..20),
        noise in proptest::collection::vec(text(), 0..40)) {
        let mut octets = noise;
        // What was begun ends.
        octets.push(b'\r');
        let mut decoder = Decoder::default();
        octets.iter().for_each(|octet| { decoder.feed(*octet); });
        let mut text = Vec::new();
        frames.iter().for_each(|frame| encode(&mut text, frame));
        let found: Vec<_> = text.iter().filter_map(|octet| decoder.feed(*octet)).collect();
        prop_assert_eq!(found, frames.into_iter().map(Line::Frame).collect::<Vec<_>>());
    }

    #[test]
    fn any_frames_of_can_fd_come_back_from_their_text(frames in proptest::collection::vec(fd_frames(), 0..20),
        noise in proptest::collection::vec(text(), 0..400)) {
        let (mut octets, mut adapter) = (noise, Fdcanusb::default());
        octets.push(b'\n');
        octets.iter().for_each(|octet| { adapter.feed(*octet); });
        let mut text = Vec::new();
        frames.iter().for_each(|frame| Fdcanusb::encode(&mut text, frame));
        // An adapter tells a frame that has come in the words in which it is told to send one.
        let text = String::from_utf8(text).unwrap().replace("can send", "rcv");
        let found: Vec<_> = text.bytes().filter_map(|octet| adapter.feed(octet)).collect();
        prop_assert_eq!(found, frames);
    }

    #[test]
    fn no_text_is_more_than_frames_and_commands(text in proptest::collection::vec(text(), 0..400)) {
        let mut decoder = Decoder::default();
        for line in text.iter().filter_map(|octet| decoder.feed(*octet)) {
            if let Line::Frame(frame) = line {
                prop_assert!(frame.id() < 0x800 && frame.octets().len() <= 8);
            }
        }
    }
}

/// Frames of every kind to nodes and from them to a master, in operation and before it; how many.
fn play(count: u32, mut seed: u64) -> u32 {
    let mut number = move |most: u64| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 33) % most
    };
    let ids = [0, 0x80, 0x81, 0x101, 0x181, 0x201, 0x301, 0x581, 0x601, 0x602, 0x701, 0x77f];
    let mut node = CanNode::canopen(1, [None; 2]);
    let mut axis = CanNode::cansimple(1, 20_000_000);
    let (mut moteus, mut adapter) = (CanNode::moteus(1), Fdcanusb::default());
    let mut mit = CanNode::mit(1, MitMotor::models().last().unwrap().1);
    let subframes = [0x01, 0x00, 0x0a, 0x0d, 0x0e, 0x20, 0x11, 0x13, 0x1f, 0x1c, 0x14, 0x50, 0x27, 0x80];
    let (mut answers, mut decoder, mut played) = (Vec::new(), Decoder::default(), 0);
    for now in 0..u64::from(count) {
        let octets: [u8; 8] = std::array::from_fn(|_| number(256) as u8);
        let id = if number(8) == 0 { number(0x800) as u16 } else { ids[number(12) as usize] };
        let mut frame = Frame::new(id, &octets[..number(9) as usize]);
        if id == 0 {
            // A new start reads its description again, which takes long.
            let command = if number(500) == 0 { 130 } else { [1, 1, 1, 128][number(4) as usize] };
            frame = Frame::new(0, &[command, 1]);
        }
        node.process(&frame, now * 100_000, &mut answers);
        node.advance(now * 100_000, 100_000, &mut answers);
        let message = 0x20 | number(0x20) as u16;
        let frame = if number(4) == 0 {
            Frame::remote(message, number(9) as usize)
        } else {
            Frame::new(message, &octets[..number(9) as usize])
        };
        axis.process(&frame, now * 100_000, &mut answers);
        axis.advance(now * 100_000, 100_000, &mut answers);
        if let CanDrive::Cansimple(axis) = axis.drive_mut() {
            assert!(axis.command().is_none_or(f32::is_finite));
        }
        let octets: [u8; 64] = std::array::from_fn(|_| {
            if number(3) == 0 { number(256) as u8 } else { subframes[number(14) as usize] }
        });
        let frame =
            Frame::fd([0x8001, 0x8001, 0x0001, 0x8101][number(4) as usize], &octets[..number(65) as usize]);
        moteus.process(&frame, now * 100_000, &mut answers);
        moteus.advance(now * 100_000, 100_000, &mut answers);
        if let CanDrive::Moteus(moteus) = moteus.drive_mut() {
            assert!(moteus.command().is_none_or(f32::is_finite));
        }
        let octets =
            std::array::from_fn::<u8, 8, _>(|_| if number(3) == 0 { number(256) as u8 } else { 255 });
        let frame = Frame::new([1, 1, 1, 0x7ff][number(4) as usize], &octets[..number(9) as usize]);
        mit.process(&frame, now * 100_000, &mut answers);
        mit.advance(now * 100_000, 100_000, &mut answers);
        if let CanDrive::Mit(motor) = mit.drive_mut() {
            assert!(motor.torque(0.0, 0.0).is_none_or(f64::is_finite));
        }
        let _ = adapter.feed(octets[1]);
        answers.clear();
        let _ = decoder.feed(octets[0]);
        played += 1;
    }
    played
}

#[test]
fn nodes_take_any_frame() {
    assert_eq!(play(200_000, 5), 200_000);
}

#[test]
fn long_nodes_take_ten_million_frames() {
    if std::env::var_os("SINEW_LONG").is_some() {
        assert_eq!(play(10_000_000, 7), 10_000_000);
    }
}

#[test]
fn a_master_takes_any_frame() {
    PROTOCOLS.into_iter().for_each(|protocol| takes_any_frame(protocol, 20_000));
}

/// Of four nodes on CANopen, moteus or in MIT mode a cycle has four frames, of four axes on CANSimple eight.
#[test]
fn long_a_master_takes_a_million_frames() {
    if std::env::var_os("SINEW_LONG").is_some() {
        takes_any_frame(Protocol::Canopen, 250_000);
        takes_any_frame(Protocol::Cansimple, 125_000);
        takes_any_frame(Protocol::Moteus, 250_000);
        takes_any_frame(Protocol::Mit, 250_000);
    }
}

#[cfg(target_os = "linux")]
#[test]
fn what_is_no_can_interface_is_refused_with_what_to_do() {
    let refused = |port: &str, fd| match sinew_runtime::can::connect(port, 500_000, fd) {
        Err(error) => error.to_string(),
        Ok(_) => panic!("{port} was opened"),
    };
    let missing = refused("nocan0", false);
    assert!(missing.contains("no such network interface"), "{missing}");
    assert!(missing.contains("`ip link set nocan0 up txqueuelen 1000 type can bitrate 500000`"), "{missing}");
    assert!(refused("nocan0", true).contains("dbitrate 5000000"));
    // There, but of another kind: refused by the kernel, whether it has CAN or not.
    if std::path::Path::new("/sys/class/net/lo").exists() {
        let other = refused("lo", false);
        assert!(other.contains("expected a CAN interface") && !other.contains('\n'), "{other}");
    }
    // A slash makes it a serial port.
    assert!(refused("/dev/nowhere", true).contains("No such file"));
}

fn takes_any_frame(protocol: Protocol, cycles: u32) {
    let (setup, nodes) = setup_on("planar_leg", protocol);
    thread_local!(static SEED: std::cell::Cell<u64> = const { std::cell::Cell::new(1) });
    // One in fifty is another one.
    fn noise(frame: &Frame) -> Frame {
        let seed = SEED.get().wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        SEED.set(seed);
        let octets = (seed.wrapping_mul(0x9e37_79b9_7f4a_7c15)).to_le_bytes();
        let length = (seed >> 40) as usize % 9;
        match seed >> 57 {
            0 => Frame::new((seed >> 20) as u16, &octets[..length]),
            // One octet of it is.
            1 if frame.is_fd() => changed(frame, (seed >> 20) as usize % frame.length(), &octets[..1]),
            1 => Frame::new((seed >> 20) as u16, &octets[..length]),
            _ => *frame,
        }
    }
    let watched = Watched::new(&setup, &nodes);
    let mut bus = CanBus::start(watched.clone(), &setup.machine, &nodes).unwrap();
    watched.0.borrow_mut().damage = Some(noise);
    let (mut feedback, mut faults) = (Feedback::new(nodes.len(), 0), 0);
    for _ in 0..cycles {
        faults += usize::from(bus.read(&mut feedback).fault.is_some());
        bus.write(&vec![DriveCommand::Velocity(0.0); nodes.len()]);
    }
    assert!(faults > 100, "{faults}");
}
