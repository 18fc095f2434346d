//! Machines behind chains of simulated serial servos, in virtual time.

use crate::common::{Setup, bare_machine, machine, tracked};
use sinew::control::arm::ArmStatus;
use sinew::machine::Machine;
use sinew_runtime::servos::protocol::{BROADCAST, Protocol, instruction::WRITE};
use sinew_runtime::servos::{
    BAUD, Lines, Model, OVERLOAD, OperatingMode, ServoBus, ServoDevice, ServoFault, ServoGoal,
    SimulatedLines, SimulatedMachine, SimulatedServo, eeprom, sts, words,
};
use sinew_session::{BusFault, Exchange, Feedback, Plant};
use std::cell::RefCell;
use std::io;
use std::rc::Rc;

/// s.
const PERIOD: f64 = 4e-3;
/// A cycle in the middle of the motion.
const MIDDLE: u64 = 1000;
const NAMES: [&str; 3] = ["bench_joint", "planar_leg", "finger"];

/// Lines that are there after their bus is gone, what is done before a cycle, and what has been.
#[derive(Clone)]
pub(crate) struct Watched(Rc<RefCell<Inner>>);

pub(crate) struct Inner {
    lines: SimulatedLines,
    acts: Vec<(u64, Act)>,
    cycle: u64,
    unplugged: bool,
}

/// What happens, to the servo of this index where there is one.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Act {
    Fault(usize, Option<ServoFault>),
    Reset(usize),
    Raise(usize, u8),
    /// The line is cut behind the adapter.
    Cut,
    Unplug,
    /// The program stands for so many periods.
    Stall(u64),
}

impl Watched {
    pub(crate) fn new(setup: &Setup, servos: &[ServoDevice]) -> Self {
        let ports = ServoDevice::ports(servos);
        let plant = setup.plant.clone();
        let machine = SimulatedMachine::new(plant, &setup.machine, servos, &ports, false);
        let lines = SimulatedLines::new(machine);
        Self(Rc::new(RefCell::new(Inner { lines, acts: Vec::new(), cycle: 0, unplugged: false })))
    }

    pub(crate) fn with(self, cycle: u64, act: Act) -> Self {
        self.0.borrow_mut().acts.push((cycle, act));
        self
    }

    /// True tensions of the cables at their drives, N.
    pub(crate) fn tensions(&self) -> Vec<f64> {
        let inner = self.0.borrow();
        let machine = inner.lines.simulated().unwrap();
        machine.arm().truth().cables.iter().map(|cable| cable.tension_in).collect()
    }

    /// Cycles of the start are none of the run.
    pub(crate) fn begin(&self) {
        self.0.borrow_mut().cycle = 0;
    }

    pub(crate) fn servos<T>(&self, see: impl Fn(&SimulatedServo) -> T) -> Vec<T> {
        let mut inner = self.0.borrow_mut();
        inner.lines.machine_mut().chains().iter().flat_map(|chain| chain.servos()).map(see).collect()
    }
}

impl Lines for Watched {
    fn count(&self) -> usize {
        self.0.borrow().lines.count()
    }
    fn now(&mut self) -> u64 {
        self.0.borrow_mut().lines.now()
    }
    fn send(&mut self, line: usize, octets: &[u8]) -> io::Result<()> {
        let mut inner = self.0.borrow_mut();
        if inner.unplugged {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        inner.lines.send(line, octets)
    }
    fn receive(&mut self, line: usize, buffer: &mut [u8], deadline: u64) -> io::Result<usize> {
        let mut inner = self.0.borrow_mut();
        if inner.unplugged {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        inner.lines.receive(line, buffer, deadline)
    }
    fn rest_until(&mut self, time: u64) {
        self.0.borrow_mut().lines.rest_until(time);
    }
    fn begin_cycle(&mut self, period: u64) {
        let Inner { lines, acts, cycle, unplugged } = &mut *self.0.borrow_mut();
        for (_, act) in acts.iter().filter(|(at, _)| at == cycle) {
            let chains = lines.machine_mut().chains_mut();
            let mut servos = chains.iter_mut().flat_map(|chain| chain.servos_mut());
            match *act {
                Act::Fault(k, fault) => servos.nth(k).unwrap().set_fault(fault),
                Act::Reset(k) => servos.nth(k).unwrap().reset(),
                Act::Raise(k, error) => servos.nth(k).unwrap().raise(error),
                Act::Cut => servos.for_each(|servo| servo.set_fault(Some(ServoFault::Silent))),
                Act::Unplug => *unplugged = true,
                Act::Stall(periods) => (0..periods).for_each(|_| lines.begin_cycle(period)),
            }
        }
        *cycle += 1;
        lines.begin_cycle(period);
    }
}

pub(crate) fn setup(name: &str) -> (Setup, Vec<ServoDevice>) {
    // The motion begins when the cables have their tensions.
    let setup = Setup { before: 3.0, ..Setup::new(bare_machine(name), 3, &[]) };
    let servos = ServoDevice::simulated(&setup.machine);
    (setup, servos)
}

/// The same servos as those of Feetech's STS series, commanded positions, as by default.
pub(crate) fn feetech(servos: &[ServoDevice]) -> Vec<ServoDevice> {
    let model = Model::all().find(|model| model.name == "STS3215").unwrap();
    let model = Model { max_velocity: 32_767, ..model };
    let mode = OperatingMode::ExtendedPosition;
    servos.iter().map(|servo| ServoDevice { model: model.clone(), mode, ..servo.clone() }).collect()
}

/// In velocity mode.
fn turning(servos: &[ServoDevice]) -> Vec<ServoDevice> {
    let mode = OperatingMode::Velocity;
    servos.iter().map(|servo| ServoDevice { mode, ..servo.clone() }).collect()
}

/// Whether a servo has torque and is on its way.
pub(crate) fn moves(servo: &SimulatedServo) -> bool {
    match servo.goal() {
        ServoGoal::Off => false,
        ServoGoal::Position(goal) => (goal - servo.position()).abs() > 1,
        ServoGoal::Velocity(speed) => speed != 0.0,
        ServoGoal::Current(_) => true,
    }
}

fn bus(setup: &Setup, servos: &[ServoDevice]) -> ServoBus<SimulatedLines> {
    let ports = ServoDevice::ports(servos);
    let machine = SimulatedMachine::new(setup.plant.clone(), &setup.machine, servos, &ports, false);
    ServoBus::start(SimulatedLines::new(machine), &setup.machine, servos).unwrap()
}

#[test]
fn a_machine_without_sensors_of_its_own_tracks_behind_servos_as_without_wires() {
    for name in NAMES {
        let (setup, servos) = setup(name);
        let (direct, _) = tracked(&setup, setup.twin_bus());
        let (wired, digest) = tracked(&setup, bus(&setup, &servos));
        println!("{name}: twin {direct:?}, chain {wired:?}");
        assert!(wired.as_good_as(&direct, name), "{name}");
        assert_eq!(tracked(&setup, bus(&setup, &servos)).1, digest, "{name}: bits of a second run");
        for servos in [feetech(&servos), turning(&feetech(&servos))] {
            let (sts, digest) = tracked(&setup, bus(&setup, &servos));
            println!("{name}: chain of STS, {:?}, {sts:?}", servos[0].mode);
            assert!(sts.as_good_as(&direct, name), "{name}");
            assert_eq!(tracked(&setup, bus(&setup, &servos)).1, digest, "{name}: bits of a second run");
        }
    }
}

#[test]
fn positions_within_a_turn_are_followed_over_all_turns() {
    let (setup, servos) = setup("planar_leg");
    let mut servos = turning(&feetech(&servos));
    // At the start every count is within a turn, in which its offset is said; here it is just above 0.
    let counts = Watched::new(&setup, &servos).servos(SimulatedServo::position);
    for (servo, count) in servos.iter_mut().zip(counts) {
        let drive = &mut servo.drive;
        drive.offset += f64::from(count - 5) * std::f64::consts::TAU / drive.counts_per_turn;
    }
    let mut octets = Vec::new();
    for (address, value) in [(sts::LOCK, 0), (sts::PHASE, sts::FINE_SPEED)] {
        Protocol::Feetech.instruct(&mut octets, BROADCAST, WRITE, &[&[address as u8, value]]);
    }
    let ports = ServoDevice::ports(&servos);
    let lines = || {
        let plant = setup.plant.clone();
        SimulatedLines::new(SimulatedMachine::new(plant, &setup.machine, &servos, &ports, false))
    };
    let mut within = lines();
    within.send(0, &octets).unwrap();
    let [within, over] = [within, lines()]
        .map(|lines| tracked(&setup, ServoBus::start(lines, &setup.machine, &servos).unwrap()).1);
    assert_eq!(within, over, "bits of servos that show all turns");
    let watched = Watched::new(&setup, &servos);
    setup.run(ServoBus::start(watched.clone(), &setup.machine, &servos).unwrap(), |_| ());
    let turned = watched.servos(SimulatedServo::position);
    assert!(turned.iter().any(|count| !(0..4096).contains(count)), "{turned:?}");
}

#[test]
fn a_servo_without_a_watchdog_turns_on_when_its_master_is_gone_or_stands_at_its_goal() {
    let (setup, servos) = setup("planar_leg");
    let servos = [feetech(&servos), turning(&feetech(&servos))];
    for (servos, ends) in [(&servos[0], true), (&servos[1], true), (&servos[0], false), (&servos[1], false)] {
        let turns_on = servos[0].mode == OperatingMode::Velocity && !ends;
        let watched = Watched::new(&setup, servos);
        let mut bus = ServoBus::start(watched.clone(), &setup.machine, servos).unwrap();
        let off = watched.servos(SimulatedServo::goal);
        assert!(off.iter().all(|goal| *goal == ServoGoal::Off));
        let mut feedback = Feedback::new(servos.len(), setup.machine.encoders.len());
        for _ in 0..5 {
            bus.read(&mut feedback);
            bus.write(&vec![sinew::drive::DriveCommand::Velocity(0.01); servos.len()]);
        }
        if ends {
            drop(bus);
        } else {
            std::mem::forget(bus);
        }
        (0..250).for_each(|_| watched.0.borrow_mut().lines.begin_cycle(4_000_000));
        let state = watched.servos(|servo| (servo.has_torque(), moves(servo)));
        assert!(state.iter().all(|state| *state == (!ends, turns_on)), "{ends}: {state:?}");
    }
}

#[test]
fn cables_keep_their_tensions_when_the_adapter_of_servos_without_a_watchdog_is_pulled_out() {
    for (name, moment) in [("finger", 300), ("two_finger_hand", 300), ("finger", 900), ("bench_joint", 1000)]
    {
        let (setup, servos) = setup(name);
        let servos = feetech(&servos);
        let watched = Watched::new(&setup, &servos);
        let bus = ServoBus::start(watched.clone(), &setup.machine, &servos).unwrap();
        watched.begin();
        let watched = watched.with(moment, Act::Unplug);
        setup.run(bus, |_| ());
        let limits = setup.controller.gains().tension_limits();
        for _ in 0..5000 {
            watched.0.borrow_mut().lines.begin_cycle(4_000_000);
            let within = watched.tensions().iter().zip(&limits).all(|(tension, [_, most])| tension < most);
            assert!(within, "{name} {moment}: {:?} of {limits:?}", watched.tensions());
        }
        assert!(watched.servos(moves).iter().all(|moves| !moves), "{name} {moment}");
    }
}

#[test]
fn servos_on_two_ports_and_in_extended_position_track_as_well() {
    let (setup, servos) = setup("planar_leg");
    let (plain, _) = tracked(&setup, bus(&setup, &servos));
    let on_two = |k: usize| {
        let port = Some(["a", "b"][k % 2].to_owned());
        ServoDevice { port, id: 1 + (k / 2) as u8, baud: BAUD[4], ..servos[k].clone() }
    };
    let (two, _) = tracked(&setup, bus(&setup, &(0..4).map(on_two).collect::<Vec<_>>()));
    // A maker on each port.
    let mixed = |k: usize| match k % 2 {
        0 => on_two(k),
        _ => ServoDevice { baud: BAUD[3], model: feetech(&servos)[k].model.clone(), ..on_two(k) },
    };
    let (mixed, _) = tracked(&setup, bus(&setup, &(0..4).map(mixed).collect::<Vec<_>>()));
    assert!(mixed.mean < 1.5 * plain.mean && mixed.max < 1.6 * plain.max, "{plain:?} {mixed:?}");
    let extended =
        |servo: &ServoDevice| ServoDevice { mode: OperatingMode::ExtendedPosition, ..servo.clone() };
    let (extended, _) = tracked(&setup, bus(&setup, &servos.iter().map(extended).collect::<Vec<_>>()));
    assert!(two.mean < 1.5 * plain.mean && two.max < 1.6 * plain.max, "{plain:?} {two:?}");
    assert!(extended.mean < 1.5 * plain.mean && extended.max < 1.6 * plain.max, "{plain:?} {extended:?}");
}

#[test]
fn a_lag_of_the_position_that_is_not_known_well_costs_little() {
    for name in NAMES {
        let (setup, servos) = setup(name);
        let (plain, _) = tracked(&setup, bus(&setup, &servos));
        // That of the simulated servos is 12.5 ms.
        for position_lag in [0.0, 3e-3, 6e-3, 9e-3, 12.5e-3, 16e-3] {
            let of = |servo| ServoDevice { position_lag, ..servo };
            let servos: Vec<_> = feetech(&servos).into_iter().map(of).collect();
            let (lagging, _) = tracked(&setup, bus(&setup, &servos));
            println!("{name}: {position_lag} s: {lagging:?}, in velocity mode {plain:?}");
            assert!(lagging.mean < 1.5 * plain.mean, "{name} {position_lag}: {plain:?} {lagging:?}");
        }
    }
}

/// The cycle in which a machine is stopped, the fault of the bus in it, and the fault as its supervisor names
/// it; none for a run to its end.
fn stopped(setup: &Setup, watched: &Watched, servos: &[ServoDevice]) -> Option<(u64, Exchange, String)> {
    let bus = ServoBus::start(watched.clone(), &setup.machine, servos).unwrap();
    watched.begin();
    let (mut found, mut cycles, mut still) = (None, 0, Vec::new());
    setup.run(bus, |record| {
        cycles += 1;
        if let (None, ArmStatus::Stopped(fault)) = (&found, record.command.arm.status) {
            found = Some((cycles, record.exchange, format!("{fault:?}")));
        }
        if found.is_some() && cycles > found.as_ref().unwrap().0 + 400 {
            still.push(watched.servos(SimulatedServo::position));
        }
    });
    let moved = still
        .first()
        .zip(still.last())
        .is_some_and(|(first, last)| first.iter().zip(last).any(|(first, last)| (first - last).abs() > 2000));
    assert!(!moved, "it does not move again by itself");
    // What hears nothing is stopped by its own watchdog.
    let left = watched.servos(|servo| servo.goal() != ServoGoal::Off);
    assert!(left.iter().all(|moving| !moving), "no torque at the end");
    found
}

#[test]
fn a_servo_that_fails_in_the_middle_of_a_motion_is_found_named_and_leads_to_a_safe_stop() {
    let (setup, dynamixel) = setup("planar_leg");
    // The second servo, in the middle of the motion.
    let acts = [Act::Fault(1, Some(ServoFault::Silent)), Act::Reset(1), Act::Raise(1, OVERLOAD)];
    for (servos, act) in
        [&dynamixel, &feetech(&dynamixel)].iter().flat_map(|servos| acts.map(|act| (*servos, act)))
    {
        let watched = Watched::new(&setup, servos).with(MIDDLE, act);
        let (cycle, exchange, fault) = stopped(&setup, &watched, servos).unwrap();
        assert!((MIDDLE..MIDDLE + 10).contains(&cycle), "{act:?}: {cycle}");
        assert_eq!(fault, "Drive(1)", "{act:?}");
        let expected = match act {
            Act::Fault(..) => BusFault::NotReady { device: 1, code: 0, muscle: Some(1) },
            Act::Reset(_) => BusFault::NotReady { device: 1, code: 1, muscle: Some(1) },
            _ => BusFault::Drive { muscle: 1, code: u16::from(OVERLOAD) },
        };
        assert_eq!(exchange.fault, Some(expected), "{act:?}");
        assert!(!words(expected).is_empty());
    }
}

#[test]
fn answers_that_are_damaged_now_and_then_are_bridged() {
    let (setup, servos) = setup("planar_leg");
    let damaged = Act::Fault(1, Some(ServoFault::Corrupted(50)));
    for servos in [&servos, &feetech(&servos)] {
        let watched = Watched::new(&setup, servos).with(10, damaged);
        assert_eq!(stopped(&setup, &watched, servos), None);
    }
}

#[test]
fn the_readings_of_the_others_count_while_a_servo_is_silent() {
    let (setup, servos) = setup("finger");
    for silent in 0..servos.len() {
        let watched = Watched::new(&setup, &servos);
        let mut bus = ServoBus::start(watched.clone(), &setup.machine, &servos).unwrap();
        let mut feedback = Feedback::new(servos.len(), setup.machine.encoders.len());
        let begun = watched.0.borrow().cycle;
        let watched = watched.with(begun + 2, Act::Fault(silent, Some(ServoFault::Silent)));
        let mut missing = Vec::new();
        for _ in 0..8 {
            bus.read(&mut feedback);
            missing.push(feedback.motor.iter().filter(|position| position.is_nan()).count());
            bus.write(&vec![sinew::drive::DriveCommand::Velocity(0.0); servos.len()]);
        }
        assert_eq!((missing[0], missing[5], missing[7]), (0, 1, 1), "servo {silent}: {missing:?}");
        drop(bus);
        let left = watched.servos(SimulatedServo::has_torque);
        assert_eq!(left.iter().filter(|torque| **torque).count(), 1, "the silent one's is its watchdog's");
    }
}

#[test]
fn what_is_wrong_is_refused_before_anything_moves_with_device_and_value() {
    let (setup, servos) = setup("finger");
    let start = |servos: &[ServoDevice], watched: &Watched| {
        let refused = ServoBus::start(watched.clone(), &setup.machine, servos);
        refused.err().map(|error| error.to_string()).unwrap_or_default()
    };
    let fine = || Watched::new(&setup, &servos);
    let name = servos[2].name.as_str();
    let with = |change: &dyn Fn(&mut ServoDevice)| {
        let mut changed = servos.clone();
        change(&mut changed[2]);
        changed
    };
    let model = |wanted: &str| Model::all().find(|model| model.name == wanted).unwrap();
    // As simulated, what the machine file says, and parts of the message.
    let of_feetech = feetech(&servos);
    let slow = |max_velocity| {
        let mut slow = of_feetech.clone();
        slow[2].model.max_velocity = max_velocity;
        slow
    };
    let cases: [(Watched, Vec<ServoDevice>, &[&str]); 9] = [
        (fine(), with(&|servo| servo.id = 77), &[name, "id 77", "no servo answers"]),
        (fine(), with(&|servo| servo.model = model("XM540-W270")), &[name, "1020", "XM540-W270"]),
        (fine(), with(&|servo| servo.id = 1), &[name, "id"]),
        (fine(), with(&|servo| servo.baud = BAUD[1]), &[name, "baud"]),
        (fine(), with(&|servo| servo.model = model("PH54-200")), &[name, "series"]),
        (
            Watched::new(&setup, &with(&|servo| servo.model = model("XM430-W350"))),
            servos.clone(),
            &[name, "velocity limit", "outside"],
        ),
        // One series does not hear the other; a winch that turns faster than the servo can.
        (Watched::new(&setup, &of_feetech), servos.clone(), &[servos[0].name.as_str(), "no servo answers"]),
        (fine(), of_feetech.clone(), &[servos[0].name.as_str(), "no servo answers"]),
        (Watched::new(&setup, &of_feetech), slow(9), &[name, "velocity limit", "9 counts/s"]),
    ];
    for (watched, servos, parts) in cases {
        let message = start(&servos, &watched);
        assert!(parts.iter().all(|part| message.contains(part)), "{message}: {parts:?}");
        assert!(watched.servos(SimulatedServo::has_torque).iter().all(|torque| !torque));
    }
    let late: Vec<_> = servos.iter().map(|servo| ServoDevice { baud: BAUD[2], ..servo.clone() }).collect();
    let message = start(&late, &Watched::new(&setup, &late));
    assert!(message.contains("115200") && message.contains("4.000 ms"), "{message}");
    for servos in [&servos, &of_feetech] {
        let watched = Watched::new(&setup, servos);
        watched.0.borrow_mut().lines.machine_mut().chains_mut()[0].servos_mut()[2].raise(OVERLOAD);
        let message = start(servos, &watched);
        assert!(message.contains(name) && message.contains("overload"), "{message}");
        // Two servos of one identifier; and a line at another rate.
        let mut twice = servos.clone();
        twice[2].id = twice[1].id;
        let message = start(servos, &Watched::new(&setup, &twice));
        assert!(message.contains(&servos[1].name) && message.contains("no servo answers"), "{message}");
        let (watched, mut octets, mut rate) = (Watched::new(&setup, servos), Vec::new(), Vec::new());
        let protocol = servos[2].model.series.protocol();
        let place = if protocol == Protocol::Feetech { sts::BAUD_RATE } else { eeprom::BAUD };
        protocol.places(&mut rate, &[place]);
        protocol.instruct(&mut octets, servos[2].id, WRITE, &[&rate, &[4]]);
        watched.0.borrow_mut().lines.send(0, &octets).unwrap();
        let message = start(servos, &watched);
        assert!(
            message.contains(name) && message.contains("no servo answers to id 3 at 1000000"),
            "{message}"
        );
    }
}

#[test]
fn a_machine_with_other_sensors_than_its_servos_is_refused_by_name() {
    let setup = Setup::new(Machine { period: PERIOD, ..machine("finger") }, 3, &[]);
    let servos = ServoDevice::simulated(&setup.machine);
    let refused = ServoBus::start(Watched::new(&setup, &servos), &setup.machine, &servos);
    let message = refused.err().unwrap().to_string();
    assert!(message.contains("load cell of flexor_profundus") && message.contains("none"), "{message}");
}
