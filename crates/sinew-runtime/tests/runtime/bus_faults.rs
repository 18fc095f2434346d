//! Faults of wire and devices while a machine is tracked: named, bridged or stopped.

use crate::common::{PERIOD, Setup, machine};
use sinew::control::arm::{ArmStatus, Fault};
use sinew::control::supervisor::{FaultKind, Mode, NamedFault};
use sinew::drive::DriveCommand;
use sinew::twin::arm::{ExchangeFailure, Failure, InjectedFault};
use sinew_runtime::ethercat::{EthercatBus, EthercatError, FrameStorage, Link, Master, SegmentLink};
use sinew_segment::{AlStatusCode, Device, DeviceSettings, FaultKind as DeviceFault, builtin};
use sinew_session::{BusFault, BusStatistics, Feedback, Plant};

/// Position of a load cell, of a drive and of the joint encoders of the planar leg.
const DRIVE: usize = 2;
const LOAD_CELL: usize = 3;
const ENCODERS: usize = 8;
/// Start of the faults after the start of the run, ns: the machine moves.
const START: u64 = 1_000_000_000;

/// What became of a run with one fault.
#[derive(Debug)]
struct Outcome {
    statistics: BusStatistics,
    stopped: Option<Fault>,
    degraded: bool,
    /// Largest true error of a joint, rad.
    error: f64,
    /// Whether a drive had torque while a device that drives it was not in OP.
    unchecked_torque: bool,
}

fn run(device: usize, kind: DeviceFault, duration: Option<u64>) -> Outcome {
    let setup = Setup::new(machine("planar_leg"), 3, &[]);
    let storage = FrameStorage::new();
    let mut bus = setup.segment_bus(&storage);
    let start_ns = bus.link_mut().now() + START;
    let fault = sinew_segment::Fault { device, kind, start_ns, duration_ns: duration };
    bus.link_mut().segment_mut().inject(fault).unwrap();
    let mut outcome = Outcome {
        statistics: BusStatistics::default(),
        stopped: None,
        degraded: false,
        error: 0.0,
        unchecked_torque: false,
    };
    let cycle = setup.run(bus, |record| {
        match record.command.arm.status {
            ArmStatus::Stopped(fault) => outcome.stopped = outcome.stopped.or(Some(fault)),
            ArmStatus::Degraded(_) => outcome.degraded = true,
            ArmStatus::Following | ArmStatus::Holding => {}
        }
        if outcome.stopped.is_none() {
            for (reference, truth) in
                record.reference.q.iter().zip(record.plant.simulated().unwrap().truth().q)
            {
                outcome.error = outcome.error.max((reference - truth).abs());
            }
        }
        for device in record.plant.link().segment().devices() {
            let powered = device.drive().is_some_and(|drive| drive.brake_released());
            let operational = device.state() == sinew_segment::AlState::Op;
            // A drive that left OP brakes with its own power.
            let braking = device
                .drive()
                .is_some_and(|drive| matches!(drive.command(), sinew_segment::AxisCommand::QuickStop));
            outcome.unchecked_torque |= powered && !operational && !braking;
        }
    });
    outcome.statistics = cycle.statistics();
    assert!(!outcome.unchecked_torque, "{outcome:?}");
    outcome
}

/// Stop, modes and the first report of a run with an injected failure of the exchange.
fn exchange<B: Plant>(setup: &Setup, bus: B) -> (Option<Fault>, Vec<Mode>, Option<FaultKind>) {
    let (mut stopped, mut modes, mut reported) = (None, Vec::new(), None);
    setup.run(bus, |record| {
        let command = &record.command;
        if let ArmStatus::Stopped(fault) = command.arm.status {
            stopped = stopped.or(Some(fault));
        }
        if modes.last() != Some(&command.mode) {
            modes.push(command.mode);
        }
        reported = reported.or(command.fault.map(NamedFault::kind));
    });
    (stopped, modes, reported)
}

#[test]
fn injected_failures_of_the_exchange_have_their_effects_on_every_simulated_bus() {
    let cases = [
        (ExchangeFailure::Lost, Some(Fault::Bus), Mode::SafeStop, FaultKind::LostCycles),
        (ExchangeFailure::Late, Some(Fault::LateCycles), Mode::SafeStop, FaultKind::LateCycles),
        (ExchangeFailure::Stale, None, Mode::Hold, FaultKind::StaleCommand),
    ];
    for (failure, stop, mode, kind) in cases {
        let fault = InjectedFault { start: 1.0, duration: 0.5, failure: Failure::Exchange(failure) };
        let setup = Setup::new(machine("planar_leg"), 3, &[fault]);
        let storage = FrameStorage::new();
        for (stopped, modes, reported) in
            [exchange(&setup, setup.twin_bus()), exchange(&setup, setup.segment_bus(&storage))]
        {
            assert_eq!((stopped, reported), (stop, Some(kind)), "{failure:?}");
            assert_eq!(modes.get(1), Some(&mode), "{failure:?}: {modes:?}");
        }
    }
}

#[test]
fn lost_frames_are_bridged_for_four_cycles_and_stop_the_machine_when_they_last() {
    for (milliseconds, stops) in [(1, false), (4, false), (10, true), (100, true)] {
        let outcome = run(0, DeviceFault::Lost, Some(milliseconds * PERIOD));
        assert!(
            outcome.statistics.lost >= milliseconds && outcome.statistics.lost <= milliseconds + 2,
            "{outcome:?}"
        );
        assert_eq!(outcome.stopped, stops.then_some(Fault::Bus), "{milliseconds} ms: {outcome:?}");
        assert!(outcome.error < 0.05, "{milliseconds} ms: {outcome:?}");
    }
    let outcome = run(0, DeviceFault::Lost, None);
    assert_eq!(outcome.stopped, Some(Fault::Bus), "{outcome:?}");
    assert!(outcome.statistics.lost > 1000, "{outcome:?}");
}

#[test]
fn a_drive_that_leaves_op_stops_the_machine_under_its_name_and_comes_back() {
    let outcome = run(DRIVE, DeviceFault::DropToSafeOp(AlStatusCode::Watchdog), None);
    assert_eq!(outcome.stopped, Some(Fault::Drive(1)), "{outcome:?}");
    let cycles = outcome.statistics.not_ready;
    assert!(cycles > 0 && cycles < 200, "acknowledged and back in OP: {outcome:?}");
}

#[test]
fn a_fault_of_a_drive_stops_the_machine_with_its_code() {
    let outcome = run(DRIVE, DeviceFault::DriveFault(0x2310), None);
    assert_eq!(outcome.stopped, Some(Fault::Drive(1)), "{outcome:?}");
    let first = outcome.statistics.first.map(|(_, fault)| fault);
    assert_eq!(first, Some(BusFault::Drive { muscle: 1, code: 0x2310 }));
}

#[test]
fn a_load_cell_that_leaves_op_is_bridged_by_the_observers_until_it_is_back() {
    let outcome = run(LOAD_CELL, DeviceFault::DropToSafeOp(AlStatusCode::Watchdog), None);
    assert!(outcome.stopped.is_none() && outcome.statistics.not_ready > 0, "{outcome:?}");
    assert!(outcome.error < 0.05, "{outcome:?}");
}

#[test]
fn an_emergency_in_operation_changes_nothing() {
    let outcome = run(DRIVE, DeviceFault::Emergency(0x3210, 4, [1, 2, 3, 4, 5]), None);
    assert!(outcome.stopped.is_none() && outcome.statistics.first.is_none(), "{outcome:?}");
}

#[test]
fn emergencies_while_objects_are_read_and_written_do_not_keep_the_bus_from_operation() {
    let setup = Setup::new(machine("bench_joint"), 3, &[]);
    // When the drives are configured, by a start without them.
    let storage = FrameStorage::new();
    let mut bus = setup.segment_bus(&storage);
    let operational = bus.link_mut().now();
    for k in 1..40 {
        let mut link = setup.link();
        let kind = DeviceFault::Emergency(0x3210, 4, [1, 2, 3, 4, 5]);
        let start_ns = operational * k / 40;
        for device in 0..link.segment().devices().len() {
            // Devices without a mailbox send none.
            let _ = link.segment_mut().inject(sinew_segment::Fault {
                device,
                kind: kind.clone(),
                start_ns,
                duration_ns: None,
            });
        }
        let storage = FrameStorage::new();
        let matched = Master::new(&storage, link).unwrap().match_devices(&setup.devices).unwrap();
        matched.operate(&setup.machine).unwrap();
    }
}

#[test]
fn a_wrong_working_counter_late_and_damaged_frames_are_counted_and_bridged() {
    for kind in [DeviceFault::WorkingCounter(-1), DeviceFault::Late(700_000), DeviceFault::Corrupted] {
        let name = format!("{kind:?}");
        let outcome = run(0, kind, Some(2 * PERIOD));
        let BusStatistics { lost, missing, .. } = outcome.statistics;
        assert!((2..=4).contains(&(lost + missing)), "{name}: {outcome:?}");
        assert!(outcome.stopped.is_none() && outcome.error < 0.05, "{name}: {outcome:?}");
    }
}

#[test]
fn a_machine_with_few_sensors_is_stopped_without_a_panic() {
    let mut machine = machine("lm_arm");
    // Only the last joint is measured: its index is above the number of sensors.
    let last = machine.encoders.len() - 1;
    for device in &mut machine.devices {
        if let sinew::machine::DeviceRole::Sensors(channels) = &mut device.role {
            channels.retain(|channel| channel.signal == sinew::machine::Signal::Joint(last));
        }
    }
    let setup = Setup::new(machine, 1, &[]);
    let storage = FrameStorage::new();
    let mut bus = setup.segment_bus(&storage);
    bus.stop();
    let released = bus.link().segment().devices().iter().filter_map(|device| device.drive());
    assert_eq!(released.filter(|drive| drive.brake_released()).count(), 0);
}

#[test]
fn a_device_without_power_stops_the_machine_and_a_new_start_finds_it_again() {
    for device in [0, DRIVE, ENCODERS] {
        let setup = Setup::new(machine("planar_leg"), 3, &[]);
        let storage = FrameStorage::new();
        let mut bus = setup.segment_bus(&storage);
        let start_ns = bus.link_mut().now() + START;
        let fault = |kind| sinew_segment::Fault { device, kind, start_ns, duration_ns: Some(300 * PERIOD) };
        bus.link_mut().segment_mut().inject(fault(DeviceFault::PowerLoss)).unwrap();
        let mut stopped = false;
        let cycle = setup.run(bus, |record| {
            stopped |= matches!(record.command.arm.status, ArmStatus::Stopped(_));
        });
        assert!(stopped && cycle.statistics().first.is_some(), "{device}: {:?}", cycle.statistics());
        let mut bus = cycle.end();
        bus.restart(&setup.machine).unwrap();
        assert_in_operation(bus, &setup);
    }
}

fn assert_in_operation(mut bus: EthercatBus<'_, SegmentLink>, setup: &Setup) {
    let mut feedback = Feedback::new(setup.machine.muscles.len(), setup.machine.encoders.len());
    let hold = vec![DriveCommand::Velocity(0.0); setup.machine.muscles.len()];
    for _ in 0..10 {
        assert_eq!(bus.read(&mut feedback).fault, None);
        bus.write(&hold);
    }
    assert!(feedback.motor.iter().chain(&feedback.tension).chain(&feedback.joint).all(|x| x.is_finite()));
}

#[test]
fn another_device_in_the_place_of_one_is_named_and_gets_no_set_point() {
    let setup = Setup::new(machine("planar_leg"), 3, &[]);
    let storage = FrameStorage::new();
    let mut bus = setup.segment_bus(&storage);
    let start_ns = bus.link_mut().now() + START;
    let other = Device::new(&builtin::load_cell(), DeviceSettings::default()).unwrap();
    let kind = DeviceFault::Swapped(Box::new(other));
    bus.link_mut()
        .segment_mut()
        .inject(sinew_segment::Fault { device: DRIVE, kind, start_ns, duration_ns: None })
        .unwrap();
    let mut stopped = None;
    let cycle = setup.run(bus, |record| {
        if let ArmStatus::Stopped(fault) = record.command.arm.status {
            stopped = stopped.or(Some(fault));
        }
    });
    assert_eq!(stopped, Some(Fault::Drive(1)));
    let text = cycle.end().restart(&setup.machine).unwrap_err().to_string();
    assert!(
        text.contains("position 2") && text.contains("drive of hip_extensor") && text.contains("SIM-LC1"),
        "{text}"
    );
}

/// An interface that gives no frame back, or each frame as it was sent.
struct Unplugged {
    time: u64,
    echoes: bool,
    echo: Option<Vec<u8>>,
}

impl Link for Unplugged {
    fn now(&mut self) -> u64 {
        self.time
    }

    fn send(&mut self, frame: &[u8]) -> std::io::Result<()> {
        self.echo = self.echoes.then(|| frame.to_vec());
        Ok(())
    }

    fn receive(&mut self, buffer: &mut [u8]) -> std::io::Result<Option<usize>> {
        Ok(self.echo.take().map(|frame| {
            buffer[..frame.len()].copy_from_slice(&frame);
            frame.len()
        }))
    }

    fn idle(&mut self) {
        self.time += 100_000;
    }

    fn rest_until(&mut self, time: u64) {
        self.time = time;
    }

    fn begin_cycle(&mut self, period: u64) {
        self.time += period;
    }
}

#[test]
fn an_interface_without_devices_is_named() {
    for echoes in [false, true] {
        let storage = FrameStorage::new();
        let refused = Master::new(&storage, Unplugged { time: 0, echoes, echo: None }).unwrap().scan();
        assert!(matches!(refused, Err(EthercatError::NoAnswer)), "{refused:?}");
    }
}

#[test]
fn missing_wrong_and_surplus_devices_are_named_before_anything_moves() {
    let setup = Setup::new(machine("planar_leg"), 3, &[]);
    let mut devices = setup.devices.clone();
    devices.swap(0, 1);
    let storage = FrameStorage::new();
    let refused = Master::new(&storage, setup.link()).unwrap().match_devices(&devices).err().unwrap();
    assert!(matches!(refused.error, EthercatError::Mismatch(_)), "{refused:?}");
    let mut devices = setup.devices.clone();
    devices.pop();
    let mut refused = refused.master.match_devices(&devices).err().unwrap();
    assert!(refused.error.to_string().contains("expected no device"), "{refused:?}");
    let before = refused.master.link_mut().machine().arm().truth().time;
    assert!(before == 0.0, "nothing moved");
    assert!(refused.master.match_devices(&setup.devices).is_ok(), "the master tries again");
}
