//! Faults of servos, drives on CAN and their lines at random moments of a motion, on every bus but EtherCAT,
//! whose are in `bus_faults`.

#![allow(clippy::print_stdout, reason = "a campaign prints its table")]

use crate::can::PROTOCOLS;
use crate::common::{Setup, bare_machine};
use crate::{can_common as can, servos};
use sinew::control::arm::{ArmStatus, Fault};
use sinew::control::supervisor::Mode;
use sinew::machine::SafetyLimits;
use sinew_runtime::can::{CanBus, CanFault, CanNode, Protocol};
use sinew_runtime::servos::{OVERLOAD, ServoBus, ServoFault};
use sinew_session::{BusFault, Plant};
use std::collections::BTreeMap;

/// Names of the buses.
const BUSES: [&str; 6] = ["Dynamixel", "Feetech", "CANopen", "CANSimple", "moteus", "MIT mode"];
const MACHINES: [&str; 4] = ["bench_joint", "planar_leg", "finger", "two_finger_hand"];

/// What is done to a drive or to the line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Kind {
    Silent,
    Restarted,
    ReportsFault,
    NoHeartbeat,
    LineCut,
    AdapterUnplugged,
    /// One answer in a thousand.
    Damaged,
    /// One or two periods.
    LateBriefly,
    /// Longer than the drives wait.
    LateLong,
}

impl Kind {
    const ALL: [Self; 9] = [
        Self::Silent,
        Self::Restarted,
        Self::ReportsFault,
        Self::NoHeartbeat,
        Self::LineCut,
        Self::AdapterUnplugged,
        Self::Damaged,
        Self::LateBriefly,
        Self::LateLong,
    ];

    /// Whether it is bridged to the end of the motion.
    fn is_bridged(self) -> bool {
        matches!(self, Self::Damaged | Self::LateBriefly)
    }

    /// Whether a bus has it: servos, moteus and motors in MIT mode send no heartbeat, Feetech's servos wait
    /// indefinitely.
    fn is_of(self, bus: usize) -> bool {
        match self {
            Self::NoHeartbeat => matches!(bus, 2 | 3),
            Self::LateLong => bus != 1,
            _ => true,
        }
    }
}

/// One run with a fault.
#[derive(Debug, Clone, Copy)]
struct Case {
    bus: usize,
    machine: usize,
    kind: Kind,
    /// Index of the drive, and the cycle.
    drive: usize,
    cycle: u64,
    periods: u64,
}

impl Case {
    fn draw(random: &mut impl FnMut(u64) -> u64, drives: [usize; 4]) -> Self {
        loop {
            let [bus, machine, kind] =
                [BUSES.len(), MACHINES.len(), Kind::ALL.len()].map(|of| random(of as u64));
            let (bus, machine, kind) = (bus as usize, machine as usize, Kind::ALL[kind as usize]);
            // Ten axes on CANSimple need 5.4 ms.
            if !kind.is_of(bus) || (bus, machine) == (3, 3) {
                continue;
            }
            let periods = if kind == Kind::LateLong { 12 + random(50) } else { 1 + random(2) };
            let drive = random(drives[machine] as u64) as usize;
            return Self { bus, machine, kind, drive, cycle: 20 + random(CYCLES - 20), periods };
        }
    }
}

/// Cycles of 4 ms of a run, at least: 3 s of rest, a motion of 2 s and the beginning of the next rest.
const CYCLES: u64 = 1300;

/// What became of it.
#[derive(Debug, Default)]
struct Outcome {
    /// The cycle in which the machine is stopped, and what for.
    stop: Option<(u64, Fault)>,
    /// The first fault of the bus from then on.
    fault: Option<BusFault>,
    /// Whether a mode followed in which it moves by itself.
    moved_again: bool,
    /// Largest tension of a cable over its limit.
    tension: f64,
    /// Drives that have torque and move after the bus is gone.
    left: usize,
}

fn outcome<B: Plant>(setup: &Setup, bus: B, tensions: impl Fn() -> Vec<f64>) -> Outcome {
    let (mut outcome, mut cycle) = (Outcome::default(), 0);
    let limits = setup.controller.gains().tension_limits();
    setup.run(bus, |record| {
        if let (None, ArmStatus::Stopped(fault)) = (outcome.stop, record.command.arm.status) {
            outcome.stop = Some((cycle, fault));
        }
        if outcome.stop.is_some() {
            outcome.fault = outcome.fault.or(record.exchange.fault);
            outcome.moved_again |=
                matches!(record.command.mode, Mode::Ready | Mode::Pretension | Mode::Hold | Mode::Run);
        }
        for (tension, [_, most]) in tensions().into_iter().zip(&limits) {
            outcome.tension = outcome.tension.max(tension / most);
        }
        cycle += 1;
    });
    outcome
}

fn on_servos(case: &Case, setup: &Setup, dynamixel: bool) -> Outcome {
    let devices = sinew_runtime::servos::ServoDevice::simulated(&setup.machine);
    let devices = if dynamixel { devices } else { servos::feetech(&devices) };
    let (k, late) = (case.drive, case.periods);
    let act = match case.kind {
        Kind::Silent | Kind::NoHeartbeat => servos::Act::Fault(k, Some(ServoFault::Silent)),
        Kind::Restarted => servos::Act::Reset(k),
        Kind::ReportsFault => servos::Act::Raise(k, OVERLOAD),
        Kind::LineCut => servos::Act::Cut,
        Kind::AdapterUnplugged => servos::Act::Unplug,
        Kind::Damaged => servos::Act::Fault(k, Some(ServoFault::Corrupted(1000))),
        Kind::LateBriefly | Kind::LateLong => servos::Act::Stall(late),
    };
    let watched = servos::Watched::new(setup, &devices);
    let bus = ServoBus::start(watched.clone(), &setup.machine, &devices).unwrap();
    watched.begin();
    let watched = watched.with(case.cycle, act);
    let outcome = outcome(setup, bus, || watched.tensions());
    // What hears nothing is stopped by its own watchdog; a Feetech, which has none, stands at its goal.
    let moving = watched.servos(servos::moves);
    Outcome { left: moving.iter().filter(|moving| **moving).count(), ..outcome }
}

fn on_can(case: &Case, setup: &Setup, protocol: Protocol) -> Outcome {
    let devices = sinew_runtime::can::CanDevice::simulated(&setup.machine);
    let devices: Vec<_> = devices.into_iter().map(|node| node.on(protocol, &setup.machine)).collect();
    let k = case.drive;
    let code = match protocol {
        Protocol::Canopen => 0x2310,
        Protocol::Cansimple => 1 << 13,
        Protocol::Moteus => 38,
        Protocol::Mit => 10,
    };
    let act = match case.kind {
        Kind::Silent => can::Act::Fault(k, CanFault::Silent),
        Kind::Restarted => can::Act::Restart(k),
        Kind::ReportsFault => can::Act::Raise(k, code),
        Kind::NoHeartbeat => can::Act::Fault(k, CanFault::NoHeartbeat),
        Kind::LineCut => can::Act::Cut,
        Kind::AdapterUnplugged => can::Act::Unplug,
        Kind::Damaged => can::Act::Fault(k, CanFault::Loses(1000)),
        Kind::LateBriefly | Kind::LateLong => can::Act::Stall(case.periods),
    };
    let watched = can::Watched::new(setup, &devices);
    let bus = CanBus::start(watched.clone(), &setup.machine, &devices).unwrap();
    watched.begin();
    let watched = watched.with(case.cycle, act);
    let outcome = outcome(setup, bus, || watched.tensions());
    // A moteus that is cut off holds still, with power.
    let left = watched.nodes(|node: &CanNode| node.has_power() && node.error() != can::TIMED_OUT);
    Outcome { left: left.iter().filter(|powered| **powered).count(), ..outcome }
}

/// Whether what is reported is what was done.
fn is_named(case: &Case, outcome: &Outcome) -> bool {
    let of_drive = outcome.stop.is_some_and(|(_, fault)| fault == Fault::Drive(case.drive));
    let muscle = match outcome.fault {
        Some(BusFault::NotReady { muscle, .. }) => muscle,
        Some(BusFault::Drive { muscle, .. }) => Some(muscle),
        _ => None,
    };
    match case.kind {
        Kind::LineCut | Kind::AdapterUnplugged => {
            outcome.stop.is_some_and(|(_, fault)| fault == Fault::Bus)
                && outcome.fault == Some(BusFault::Lost)
        }
        // All drives have waited too long: one of them is named.
        Kind::LateLong => {
            matches!(outcome.stop, Some((_, Fault::Drive(_) | Fault::Bus))) && outcome.fault.is_some()
        }
        kind if kind.is_bridged() => outcome.stop.is_none(),
        _ => of_drive && muscle == Some(case.drive),
    }
}

/// Runs so many faults and prints what was found; those that were not, not named, or left something moving.
fn campaign(count: usize, seed: u64) -> Vec<(Case, Outcome)> {
    let mut state = seed;
    let mut random = |most: u64| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) % most
    };
    let setups = MACHINES.map(|name| {
        let seed = 3 + random(1000);
        Setup { before: 3.0, after: 2.0, ..Setup::new(bare_machine(name), seed, &[]) }
    });
    let drives = [0, 1, 2, 3].map(|k: usize| setups[k].machine.muscles.len());
    let (mut wrong, mut table) = (Vec::new(), BTreeMap::<_, Vec<_>>::new());
    for _ in 0..count {
        let case = Case::draw(&mut random, drives);
        let setup = &setups[case.machine];
        let outcome = match case.bus {
            bus @ 0..=1 => on_servos(&case, setup, bus == 0),
            bus => on_can(&case, setup, PROTOCOLS[bus - 2]),
        };
        let after = outcome.stop.map(|(cycle, _)| cycle.saturating_sub(case.cycle));
        let good =
            is_named(&case, &outcome) && !outcome.moved_again && outcome.left == 0 && outcome.tension < 1.0;
        table.entry((case.kind, case.bus)).or_default().push((good, after, outcome.tension));
        if !good {
            println!("{} {}: {case:?} {outcome:?}", BUSES[case.bus], MACHINES[case.machine]);
            wrong.push((case, outcome));
        }
    }
    println!(
        "| fault | bus | runs | as expected | cycles to the stop, median | most | tension over its limit, most |"
    );
    for ((kind, bus), rows) in table {
        let mut after: Vec<u64> = rows.iter().filter_map(|(_, after, _)| *after).collect();
        after.sort_unstable();
        let [median, most] =
            [after.get(after.len() / 2), after.last()].map(|n| n.map_or("-".into(), u64::to_string));
        let tension = rows.iter().map(|(_, _, tension)| *tension).fold(0.0, f64::max);
        let good = rows.iter().filter(|(good, ..)| *good).count();
        println!(
            "| {kind:?} | {} | {} | {good} | {median} | {most} | {tension:.2} |",
            BUSES[bus],
            rows.len()
        );
    }
    wrong
}

#[test]
fn faults_on_every_bus_are_found_named_and_stop_the_machine_for_good() {
    let wrong = campaign(24, 1);
    assert!(wrong.is_empty(), "{} of 24", wrong.len());
}

#[test]
fn a_line_that_is_cut_is_the_fault_of_the_bus_at_any_period() {
    for period in [2e-3, 8e-3, 0.012, 0.016, 0.02] {
        let mut machine = bare_machine("planar_leg");
        (machine.period, machine.reading_age) = (period, period);
        machine.safety = SafetyLimits::at_period(period);
        let setup = Setup { before: 3.0, ..Setup::new(machine, 3, &[]) };
        let cycle = (4.0 / period) as u64;
        let case = Case { bus: 2, machine: 1, kind: Kind::LineCut, drive: 0, cycle, periods: 0 };
        let outcome = on_can(&case, &setup, Protocol::Canopen);
        assert!(is_named(&case, &outcome), "{period}: {outcome:?}");
    }
}

#[test]
fn drives_wait_as_long_as_their_machine_bridges_a_late_cycle() {
    let [usual, longer] = [None, Some(0.06)].map(|lateness| {
        let mut machine = bare_machine("planar_leg");
        machine.safety.bridged_lateness = lateness.unwrap_or(machine.safety.bridged_lateness);
        Setup { before: 3.0, ..Setup::new(machine, 3, &[]) }
    });
    for bus in (0..BUSES.len()).filter(|bus| Kind::LateLong.is_of(*bus)) {
        let case = Case { bus, machine: 1, kind: Kind::LateLong, drive: 0, cycle: 1000, periods: 12 };
        let run = |setup: &Setup| match bus {
            0 | 1 => on_servos(&case, setup, bus == 0),
            _ => on_can(&case, setup, PROTOCOLS[bus - 2]),
        };
        assert!(run(&usual).stop.is_some(), "{}", BUSES[bus]);
        assert_eq!(run(&longer).stop, None, "{}", BUSES[bus]);
    }
}

/// `SINEW_LONG=1 cargo nextest run -E 'test(long_four_hundred_faults)' --no-capture`
#[test]
fn long_four_hundred_faults_on_every_bus() {
    if std::env::var_os("SINEW_LONG").is_some() {
        let wrong = campaign(400, 20_261_129);
        assert!(wrong.is_empty(), "{} of 400", wrong.len());
    }
}
