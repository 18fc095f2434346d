//! Machines behind simulated drives on CAN, in virtual time; decoders on whatever comes.

use crate::common::{Setup, bare_machine, machine, tracked};
use proptest::prelude::*;
use sinew::control::arm::ArmStatus;
use sinew::drive::DriveCommand;
use sinew::machine::Machine;
use sinew_runtime::can::fdcanusb::Fdcanusb;
use sinew_runtime::can::slcan::{Decoder, Line, encode};
use sinew_runtime::can::{
    CanBus, CanDevice, CanFault, CanNode, Dialect, FoundNode, Frame, Link, MitFamily, MitMotor, Protocol,
    SdoClient, SdoError, Sign, SimulatedLink, SimulatedMachine, scan, scan_fd, scan_mit, words,
};
use sinew_segment::{CanDrive, MitCommand, MitRanges, MitReadings};
use sinew_session::{BusFault, Exchange, Feedback, Plant};
use std::cell::RefCell;
use std::io;
use std::rc::Rc;

/// s.
const PERIOD: f64 = 4e-3;
/// A cycle in the middle of the motion.
const MIDDLE: u64 = 1000;
const PROTOCOLS: [Protocol; 4] = [Protocol::Canopen, Protocol::Cansimple, Protocol::Moteus, Protocol::Mit];
const NAMES: [&str; 3] = ["bench_joint", "planar_leg", "finger"];

/// What happens in the middle of a motion, to the node of this index.
#[derive(Debug, Clone, Copy)]
enum Act {
    Fault(usize, CanFault),
    Restart(usize),
    Raise(usize, u32),
    Cut,
    Unplug,
    /// The program stands for so many periods.
    Stall(u64),
}

/// The watchdog that a link has beside the program.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Guard {
    Real,
    /// There is none.
    Missing,
    /// It does nothing.
    Idle,
}

/// A link that is there after its bus is gone, what is done before a cycle, and what has been.
#[derive(Clone)]
struct Watched(Rc<RefCell<Inner>>);

struct Inner {
    link: SimulatedLink,
    acts: Vec<(u64, Act)>,
    cycle: u64,
    unplugged: bool,
    /// Every frame that comes is changed by this.
    damage: Option<fn(&Frame) -> Frame>,
    /// Whether it has frames of CAN FD.
    fd: bool,
    guard: Guard,
}

impl Watched {
    fn new(setup: &Setup, nodes: &[CanDevice]) -> Self {
        let machine = SimulatedMachine::new(setup.plant.clone(), &setup.machine, nodes, true);
        let link = SimulatedLink::new(machine);
        Self(Rc::new(RefCell::new(Inner {
            link,
            acts: Vec::new(),
            cycle: 0,
            unplugged: false,
            damage: None,
            fd: true,
            guard: Guard::Real,
        })))
    }

    fn with(self, cycle: u64, act: Act) -> Self {
        self.0.borrow_mut().acts.push((cycle, act));
        self
    }

    /// Whether a node has power; one that is not on CANopen, which has no brake, may stand with it.
    fn moves(&self, k: usize) -> bool {
        let mut inner = self.0.borrow_mut();
        let node = inner.link.machine_mut().nodes_mut().nth(k).unwrap();
        match node.drive_mut() {
            CanDrive::Canopen(drive) => drive.brake_released(),
            CanDrive::Cansimple(axis) => axis.command().is_some_and(|velocity| velocity != 0.0),
            // A position that is held is not reached to the last bit.
            CanDrive::Moteus(node) => node.command().is_some_and(|velocity| velocity.abs() > 1e-3),
            // There is no 0 in its bits.
            CanDrive::Mit(motor) => {
                let velocity = motor.command().velocity;
                motor.torque(0.0, 0.0).is_some() && velocity.abs() > 0.02
            }
        }
    }

    fn nodes<T>(&self, see: impl Fn(&CanNode) -> T) -> Vec<T> {
        self.0.borrow_mut().link.machine_mut().nodes().map(see).collect()
    }
}

impl Link for Watched {
    fn carries_fd(&self) -> bool {
        self.0.borrow().fd
    }
    fn now(&mut self) -> u64 {
        self.0.borrow_mut().link.now()
    }
    fn send(&mut self, frames: &[Frame]) -> io::Result<()> {
        let mut inner = self.0.borrow_mut();
        if inner.unplugged { Err(io::ErrorKind::UnexpectedEof.into()) } else { inner.link.send(frames) }
    }
    fn receive(&mut self, deadline: u64) -> io::Result<Option<Frame>> {
        let mut inner = self.0.borrow_mut();
        if inner.unplugged {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        let frame = inner.link.receive(deadline)?;
        Ok(frame.map(|frame| inner.damage.map_or(frame, |damage| damage(&frame))))
    }
    fn rest_until(&mut self, time: u64) {
        self.0.borrow_mut().link.rest_until(time);
    }
    fn begin_cycle(&mut self, period: u64) {
        let Inner { link, acts, cycle, unplugged, .. } = &mut *self.0.borrow_mut();
        for (_, act) in acts.iter().filter(|(at, _)| at == cycle) {
            let mut nodes = link.machine_mut().nodes_mut();
            match *act {
                Act::Fault(k, fault) => nodes.nth(k).unwrap().set_fault(Some(fault)),
                Act::Restart(k) => nodes.nth(k).unwrap().restart(),
                Act::Raise(k, code) => nodes.nth(k).unwrap().raise_fault(code),
                Act::Cut => {
                    drop(nodes);
                    link.cut();
                }
                Act::Unplug => *unplugged = true,
                Act::Stall(periods) => {
                    drop(nodes);
                    (0..periods).for_each(|_| link.begin_cycle(4_000_000));
                }
            }
        }
        *cycle += 1;
        link.begin_cycle(period);
    }
    fn guard(&mut self, leave: &[Frame], time: u64) -> io::Result<()> {
        let mut inner = self.0.borrow_mut();
        match inner.guard {
            Guard::Real => inner.link.guard(leave, time),
            Guard::Missing => Err(io::ErrorKind::NotFound.into()),
            Guard::Idle => Ok(()),
        }
    }
    fn sign(&mut self, sign: Sign) -> io::Result<()> {
        self.0.borrow_mut().link.sign(sign)
    }
}

/// What a node on CANSimple that heard nothing for the time of its watchdog shows.
const WATCHDOG_EXPIRED: u32 = 1 << 24;
/// What a moteus shows then.
const TIMED_OUT: u32 = 11;

fn setup_on(name: &str, protocol: Protocol) -> (Setup, Vec<CanDevice>) {
    let (setup, nodes) = setup(name);
    let nodes = nodes.into_iter().map(|node| node.on(protocol, &setup.machine)).collect();
    (setup, nodes)
}

fn setup(name: &str) -> (Setup, Vec<CanDevice>) {
    // The motion begins when the cables have their tensions.
    let setup = Setup { before: 3.0, ..Setup::new(bare_machine(name), 3, &[]) };
    let nodes = CanDevice::simulated(&setup.machine);
    (setup, nodes)
}

fn bus(setup: &Setup, nodes: &[CanDevice]) -> CanBus<SimulatedLink> {
    let machine = SimulatedMachine::new(setup.plant.clone(), &setup.machine, nodes, true);
    CanBus::start(SimulatedLink::new(machine), &setup.machine, nodes).unwrap()
}

#[test]
fn a_machine_tracks_behind_drives_on_can_as_without_wires() {
    for protocol in PROTOCOLS {
        for name in NAMES {
            let (setup, nodes) = setup_on(name, protocol);
            let (direct, _) = tracked(&setup, setup.twin_bus());
            let (wired, digest) = tracked(&setup, bus(&setup, &nodes));
            println!("{name}: twin {direct:?}, {protocol:?} {wired:?}");
            assert!(wired.mean < 1.5 * direct.mean && wired.max < 1.6 * direct.max, "{name} {protocol:?}");
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

/// The cycle in which a machine is stopped, the fault of the bus in it, and the fault as its supervisor names
/// it; none for a run to its end.
fn stopped(setup: &Setup, watched: &Watched, nodes: &[CanDevice]) -> Option<(u64, Exchange, String)> {
    let bus = CanBus::start(watched.clone(), &setup.machine, nodes).unwrap();
    // Cycles of the start are none of the run.
    watched.0.borrow_mut().cycle = 0;
    let (mut found, mut cycles, mut moving) = (None, 0, 0);
    setup.run(bus, |record| {
        cycles += 1;
        if let (None, ArmStatus::Stopped(fault)) = (&found, record.command.arm.status) {
            found = Some((cycles, record.exchange, format!("{fault:?}")));
        }
        if found.as_ref().is_some_and(|(at, ..)| cycles > at + 400) {
            moving += usize::from(watched.moves(1));
        }
    });
    if found.is_some() {
        assert_eq!(moving, 0, "the second drive does not move again by itself");
    }
    // What hears no heartbeat is stopped by its own watchdog; a moteus then holds still, with power.
    let left = watched.nodes(|node| node.has_power() && node.error() != TIMED_OUT);
    assert!(left.iter().all(|powered| !powered), "no power at the end");
    found
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

/// The same motors of another model.
fn of_model(nodes: &[CanDevice], model: &str) -> Vec<CanDevice> {
    let (_, ranges) = MitMotor::models().find(|(name, _)| *name == model).unwrap();
    let of = |node: &CanDevice| {
        let motor = MitMotor { model: model.to_owned(), ranges, ..node.mit.clone().unwrap() };
        CanDevice { mit: Some(motor), ..node.clone() }
    };
    nodes.iter().map(of).collect()
}

/// Angle of the motor of a muscle at the start, rad.
fn centre(setup: &Setup, muscle: usize) -> f64 {
    let drive = setup.machine.muscles[muscle].drive;
    drive.winch.angle(setup.plant.reading().motor[muscle]) * drive.reducer.ratio
}

/// Octets of commands by somebody else: PyPI's mini-cheetah-motor-driver-socketcan 0.4.3 and damiao-motor
/// 1.0.6; those with numbers in the middle of a step would be another one, since they round down.
#[test]
fn commands_and_answers_in_mit_mode_have_the_octets_of_other_peoples_programs() {
    let ranges = |model: &str| MitMotor::models().find(|(name, _)| *name == model).unwrap().1;
    let commands = [
        ("AK10-9", [10.18, -42.4, 423.0, 0.9, 28.4], 0xe83d_137d_882e_1b7e_u64),
        ("AK10-9", [-8.71, 13.5, 265.0, 2.6, 15.9], 0x26cf_a288_7a85_19f4),
        ("AK10-9", [11.49, -38.0, 12.0, 0.9, -23.5], 0xf5a7_1eb0_622e_151b),
        ("DM-J8009", [4.98, -10.4, 38.0, 3.9, -30.2], 0xb2fe_6261_37c7_a386),
        ("DM-J8009", [-10.61, 44.1, 91.0, 2.9, -18.6], 0x135a_fd62_e994_753e),
        ("DM-J8009", [-10.29, 21.2, 302.0, 3.8, 50.0], 0x16a1_bc49_a9c2_8f67),
    ];
    for (model, [position, velocity, stiffness, damping, torque], octets) in commands {
        let command = MitCommand { position, velocity, stiffness, damping, torque };
        assert_eq!(ranges(model).command(&command), octets.to_be_bytes(), "{model} {command:?}");
    }
    let answers = [
        (
            [0xa1, 0xb2, 0x7f, 0xf8, 0x40],
            [3.290_798_809_796_293, -0.010_989_010_989_014_503, 1.701_098_901_098_902],
        ),
        ([0x00, 0x0f, 0xff, 0xff, 0xff], [-12.494_277_866_788_739, 45.0, 54.0]),
        ([0xff, 0xff, 0x00, 0x00, 0x0a], [12.5, -45.0, -53.736_263_736_263_74]),
    ];
    for (octets, expected) in answers {
        let MitReadings { position, velocity, torque } = ranges("DM-J8009").readings(octets);
        for (got, expected) in [position, velocity, torque].into_iter().zip(expected) {
            assert!((got - expected).abs() < 1e-12, "{octets:x?}: {got} {expected}");
        }
    }
}

#[test]
fn motors_of_every_family_in_mit_mode_track_and_end_without_power() {
    let (setup, nodes) = setup_on("bench_joint", Protocol::Mit);
    let (direct, _) = tracked(&setup, setup.twin_bus());
    for model in ["mini-cheetah", "AK10-9", "DM-J10010"] {
        let nodes = of_model(&nodes, model);
        let (found, digest) = tracked(&setup, bus(&setup, &nodes));
        println!("{model}: {found:?}, twin {direct:?}");
        assert!(found.mean < 1.5 * direct.mean && found.max < 1.6 * direct.max, "{model}: {found:?}");
        assert_eq!(tracked(&setup, bus(&setup, &nodes)).1, digest, "{model}: bits of a second run");
        assert_eq!(stopped(&setup, &Watched::new(&setup, &nodes), &nodes), None, "{model}");
    }
}

#[test]
fn what_is_wrong_with_a_motor_in_mit_mode_is_refused_before_anything_moves() {
    let (setup, nodes) = setup_on("finger", Protocol::Mit);
    let name = nodes[2].name.as_str();
    let with = |nodes: &[CanDevice], change: &dyn Fn(&mut CanDevice)| {
        let mut changed = nodes.to_vec();
        change(&mut changed[2]);
        changed
    };
    let on_wire = |nodes: &[CanDevice], change: &dyn Fn(&mut CanNode)| {
        let watched = Watched::new(&setup, nodes);
        change(watched.0.borrow_mut().link.machine_mut().nodes_mut().nth(2).unwrap());
        watched
    };
    let fine = || Watched::new(&setup, &nodes);
    let configured = |nodes: &[CanDevice], leaves, mode, change: &dyn Fn(&mut MitRanges)| {
        let mut ranges = nodes[2].mit.as_ref().unwrap().ranges;
        change(&mut ranges);
        on_wire(nodes, &move |node| {
            let CanDrive::Mit(motor) = node.drive_mut() else { unreachable!() };
            motor.configure(leaves, mode, ranges);
        })
    };
    let guarded = |guard| {
        let watched = fine();
        watched.0.borrow_mut().guard = guard;
        watched
    };
    let damaged = |damage| {
        let watched = fine();
        watched.0.borrow_mut().damage = Some(damage);
        watched
    };
    let short = |frame: &Frame| Frame::new(frame.id(), &frame.octets()[..frame.octets().len().min(3)]);
    let gain = |change: &dyn Fn(&mut MitMotor)| with(&nodes, &|node| change(node.mit.as_mut().unwrap()));
    let far =
        with(&nodes, &|node| node.drive.offset = centre(&setup, 2) + 12.2 / node.drive.counts_per_turn.abs());
    let twice = Watched::new(&setup, &with(&nodes, &|node| node.node = 1));
    let slow: Vec<_> = nodes.iter().map(|node| CanDevice { bitrate: 250_000, ..node.clone() }).collect();
    // The first one answers as 0x11.
    let confused =
        with(&nodes, &|node| (node.node, node.mit) = (0x11, of_model(&nodes, "AK10-9")[2].mit.clone()));
    let (ak, cheetah) = (of_model(&nodes, "AK10-9"), of_model(&nodes, "mini-cheetah"));
    let none = |_: &mut MitRanges| {};
    let cases: [(Watched, Vec<CanDevice>, &[&str]); 18] = [
        (Watched::new(&setup, &confused), confused, &[&nodes[0].name, "under id 17"]),
        (fine(), with(&nodes, &|node| node.node = 9), &[name, "id 9", "no node answers"]),
        (fine(), with(&nodes, &|node| node.node = 1), &[name, "a node of its own"]),
        (fine(), with(&nodes, &|node| node.protocol = Protocol::Canopen), &[name, "the same protocol"]),
        (twice, nodes.clone(), &["id 1", "two nodes answer"]),
        (damaged(short), nodes.clone(), &["no node answers"]),
        (fine(), slow, &["250000 bit/s", "4.000 ms"]),
        // Another family answers in another form.
        (fine(), ak.clone(), &["no node answers"]),
        (fine(), cheetah.clone(), &["no node answers"]),
        (configured(&nodes, true, 3, &none), nodes.clone(), &[name, "control mode 3", "expected 1, MIT"]),
        (
            configured(&nodes, true, 1, &|of| of.velocity = 20.0),
            nodes.clone(),
            &[name, "VMAX 20", "DM-J4310"],
        ),
        (configured(&nodes, false, 1, &none), nodes.clone(), &[name, "keeps its power for 0.030 s"]),
        (guarded(Guard::Missing), nodes.clone(), &["the watchdog beside this program", "not found"]),
        (guarded(Guard::Idle), nodes.clone(), &["the watchdog", "not told it to leave 0.030 s after"]),
        (fine(), gain(&|motor| motor.damping = 5.1), &[name, "damping of 5.1", "4095"]),
        (fine(), gain(&|motor| motor.stiffness = 0.05), &[name, "stiffness of 0.050", "1 to 4095"]),
        (Watched::new(&setup, &far), far, &[name, "its position is", "12.00 rad"]),
        (
            on_wire(&nodes, &|node| node.set_fault(Some(CanFault::Silent))),
            nodes.clone(),
            &[name, "no node answers"],
        ),
    ];
    for (watched, nodes, parts) in cases {
        let before = watched.0.borrow_mut().link.machine_mut().arm().reading().motor.clone();
        let refused = CanBus::start(watched.clone(), &setup.machine, &nodes);
        let message = refused.err().map(|error| error.to_string()).unwrap_or_default();
        println!("{message}");
        assert!(parts.iter().all(|part| message.contains(part)), "{message}: {parts:?}");
        assert!((0..nodes.len()).all(|k| !watched.moves(k)), "{message}");
        let after = watched.0.borrow_mut().link.machine_mut().arm().reading().motor.clone();
        assert!(before.iter().zip(&after).all(|(before, after)| (before - after).abs() < 3e-4), "{message}");
    }
    for nodes in [nodes, ak, cheetah] {
        assert!(CanBus::start(Watched::new(&setup, &nodes), &setup.machine, &nodes).is_ok());
    }
}

#[test]
fn a_program_that_stands_for_longer_than_its_watchdog_waits_gives_nothing_power_again() {
    let (setup, nodes) = setup_on("planar_leg", Protocol::Mit);
    for (model, periods, acts) in [("DM-J8009", 4, false), ("DM-J8009", 7, true), ("AK10-9", 7, true)] {
        let nodes = of_model(&nodes, model);
        let watched = Watched::new(&setup, &nodes).with(MIDDLE, Act::Stall(periods));
        let found = stopped(&setup, &watched, &nodes);
        println!("{model} {periods}: {found:?}");
        assert_eq!(found.is_some(), acts, "{model} {periods}");
        if let Some((cycle, exchange, fault)) = found {
            assert!((MIDDLE..MIDDLE + 5).contains(&cycle) && fault.starts_with("Drive"), "{cycle} {fault}");
            let fault = exchange.fault.unwrap();
            let BusFault::NotReady { code, .. } = fault else { panic!("{fault:?}") };
            // A DAMIAO says by itself that it has no power.
            assert!(model == "DM-J8009" || code == 3 && words(fault).contains("watchdog"), "{fault:?}");
        }
    }
}

/// What has no state in its answers is found by what it does not do.
#[test]
fn a_motor_that_does_not_follow_or_is_at_the_end_of_its_range_is_named() {
    let (setup, nodes) = setup_on("planar_leg", Protocol::Mit);
    let cheetah = of_model(&nodes, "mini-cheetah");
    let watched = Watched::new(&setup, &cheetah).with(MIDDLE, Act::Restart(1));
    let (cycle, exchange, _) = stopped(&setup, &watched, &cheetah).unwrap();
    println!("{} cycles, {exchange:?}", cycle - MIDDLE);
    let mut narrow = nodes.clone();
    let ranges = &mut narrow[1].mit.as_mut().unwrap().ranges;
    // It begins in the middle of a range that ends soon.
    ranges.position = 0.3;
    narrow[1].drive.offset = centre(&setup, 1);
    let (_, exchange, fault) = stopped(&setup, &Watched::new(&setup, &narrow), &narrow).unwrap();
    println!("{exchange:?} {fault}");
    let expected = BusFault::Drive { muscle: 1, code: 0x220 };
    assert_eq!(exchange.fault, Some(expected));
    assert_eq!(words(expected), "reports a position at the end of its range");
}

#[test]
fn motors_in_mit_mode_are_listed_and_lose_their_power() {
    let (setup, mut nodes) = setup_on("planar_leg", Protocol::Mit);
    let motor = |model: &str| of_model(&nodes[..1], model)[0].mit.clone();
    let models = ["mini-cheetah", "AK80-9", "DM-J4310", "AK10-9"].map(motor);
    nodes.iter_mut().zip([9, 16, 15, 126]).for_each(|(node, id)| node.node = id);
    nodes.iter_mut().zip(models).for_each(|(node, motor)| node.mit = motor);
    let mut watched = Watched::new(&setup, &nodes);
    let enter =
        nodes.iter().map(|node| Frame::new(u16::from(node.node), &[255, 255, 255, 255, 255, 255, 255, 252]));
    watched.send(&enter.collect::<Vec<_>>()).unwrap();
    assert_eq!(watched.nodes(CanNode::has_power), [true; 4]);
    assert_eq!(std::iter::from_fn(|| watched.receive(u64::MAX).unwrap()).take(4).count(), 4);
    let found = scan_mit(&mut watched).unwrap();
    let of = |node, family, answers_as| FoundNode::Mit { node, family, answers_as };
    let expected = [
        of(9, MitFamily::MiniCheetah, 0),
        of(15, MitFamily::Damiao, 0x1f),
        of(16, MitFamily::Cubemars, 16),
        of(126, MitFamily::Cubemars, 126),
    ];
    assert_eq!(found, expected);
    assert_eq!(watched.nodes(CanNode::has_power), [false; 4]);
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
