//! The drives of a bus are stopped whatever ends its run: brought to rest on a ramp, then disabled.

use crate::common::{PERIOD, STEP, Setup, machine, with_mode};
use sinew::control::supervisor::Mode;
use sinew::machine::{DeviceRole, DriveDevice, DriveMode, Machine};
use sinew_runtime::Error;
use sinew_runtime::cycle::{Cycle, CycleRecord, Timing, VirtualClock, run};
use sinew_runtime::ethercat::{EthercatBus, FrameStorage, Link, Master, SegmentLink};
use sinew_segment::AxisCommand;
use sinew_session::BusFault;
use std::cell::RefCell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A segment that is there after its master is gone, and the commands of its axes in every cycle.
#[derive(Clone)]
struct Watched(Rc<RefCell<(SegmentLink, Vec<Vec<AxisCommand>>)>>);

impl Watched {
    fn new(setup: &Setup) -> Self {
        Self(Rc::new(RefCell::new((setup.link(), Vec::new()))))
    }

    /// Drives whose brake is released.
    fn released(&self) -> usize {
        let inner = self.0.borrow();
        let drives = inner.0.segment().devices().iter().filter_map(|device| device.drive());
        drives.filter(|drive| drive.brake_released()).count()
    }

    fn cycles(&self) -> usize {
        self.0.borrow().1.len()
    }
}

impl Link for Watched {
    fn now(&mut self) -> u64 {
        self.0.borrow_mut().0.now()
    }

    fn send(&mut self, frame: &[u8]) -> std::io::Result<()> {
        self.0.borrow_mut().0.send(frame)
    }

    fn receive(&mut self, buffer: &mut [u8]) -> std::io::Result<Option<usize>> {
        self.0.borrow_mut().0.receive(buffer)
    }

    fn idle(&mut self) {
        self.0.borrow_mut().0.idle();
    }

    fn rest_until(&mut self, time: u64) {
        self.0.borrow_mut().0.rest_until(time);
    }

    fn begin_cycle(&mut self, period: u64) {
        let (link, commands) = &mut *self.0.borrow_mut();
        link.begin_cycle(period);
        let drives = link.segment().devices().iter().filter_map(|device| device.drive());
        commands.push(drives.map(|drive| drive.command()).collect());
    }

    fn injected(&self) -> Option<BusFault> {
        self.0.borrow().0.injected()
    }
}

/// What ends a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum End {
    ErrorInACycle,
    Panic,
    AtOnce,
    SafeStop,
    OfTheMotion,
    BusAlone,
}

/// Ends a run by what is asked for while the winches move; the cycle from which on the bus was left to
/// itself.
fn ended(setup: &Setup, watched: &Watched, end: End) -> usize {
    let storage = FrameStorage::new();
    let master = Master::new(&storage, watched.clone()).unwrap();
    let bus = master.match_devices(&setup.devices).unwrap().operate(&setup.machine).unwrap();
    assert_eq!(watched.released(), setup.machine.muscles.len(), "in operation");
    if end == End::BusAlone {
        let left = watched.cycles();
        drop(bus);
        return left;
    }
    let (at_once, stop) = (AtomicBool::new(false), Arc::new(AtomicBool::new(false)));
    let cycle = Cycle::new(bus, setup.supervisor(), setup.schedule(), STEP);
    let mut cycle = cycle.with_stop(Arc::clone(&stop));
    let (mut timing, mut cycles, mut last) = (Timing::new(), 0, Mode::Off);
    let see = |record: &CycleRecord<'_, EthercatBus<'_, Watched>>| {
        (cycles, last) = (cycles + 1, record.command.mode);
        // The fastest of the motion.
        match end {
            _ if cycles != 1300 => {}
            End::ErrorInACycle => return Err(Error::Clock(std::io::Error::other("for the test"))),
            End::Panic => panic!("for the test"),
            End::AtOnce => at_once.store(true, Ordering::Relaxed),
            End::SafeStop => stop.store(true, Ordering::Relaxed),
            End::OfTheMotion | End::BusAlone => {}
        }
        Ok(())
    };
    let mut clock = VirtualClock::default();
    let ran =
        catch_unwind(AssertUnwindSafe(|| run(&mut cycle, &mut clock, PERIOD, &at_once, &mut timing, see)));
    assert_eq!(ran.is_err(), end == End::Panic);
    assert_eq!(ran.is_ok_and(|ran| ran.is_err()), end == End::ErrorInACycle);
    if end == End::SafeStop {
        assert!(last == Mode::Ready && cycles > 2000, "released after {cycles} cycles: {last:?}");
    }
    let left = watched.cycles();
    drop(cycle);
    left
}

/// The largest change of a speed from one cycle to the next, of the one that is allowed, over all drives.
fn steepest(machine: &Machine, commands: &[Vec<AxisCommand>]) -> f64 {
    let roles = machine.devices.iter().map(|device| &device.role);
    let drives: Vec<&DriveDevice> = roles
        .filter_map(|role| if let DeviceRole::Drive(drive) = role { Some(drive) } else { None })
        .collect();
    let mut steepest: f64 = 0.0;
    for (k, drive) in drives.iter().enumerate() {
        let parameters = &machine.muscles[drive.muscle].drive;
        let [_, per_radian] = DriveDevice::cable(&parameters.winch, parameters.reducer.ratio, 0.0);
        let per_count = per_radian * core::f64::consts::TAU / drive.counts_per_turn;
        let speed = |command: &AxisCommand| match command {
            AxisCommand::Velocity(counts) => f64::from(*counts) * per_count,
            _ => 0.0,
        };
        for pair in commands.windows(2) {
            let change = (speed(&pair[1][k]) - speed(&pair[0][k])).abs();
            steepest = steepest.max((change - per_count.abs()) / (0.4 * parameters.acceleration * STEP));
        }
    }
    steepest
}

#[test]
fn whatever_ends_a_run_its_drives_come_to_rest_on_a_ramp_and_are_disabled_then() {
    for name in ["planar_leg", "lm_arm"] {
        let setup = Setup::new(machine(name), 3, &[]);
        for end in
            [End::ErrorInACycle, End::Panic, End::AtOnce, End::SafeStop, End::OfTheMotion, End::BusAlone]
        {
            let watched = Watched::new(&setup);
            let left = ended(&setup, &watched, end);
            assert_eq!(watched.released(), 0, "{name} {end:?}: every drive is disabled");
            // The first of them is what the last cycle of the run has commanded.
            let commands = watched.0.borrow().1[left..].to_vec();
            let steepest = steepest(&setup.machine, &commands);
            assert!(steepest < 1.1, "{name} {end:?}: a step of {steepest} of the one that is allowed");
            let powered = commands.iter().rposition(|axes| axes.iter().any(|axis| *axis != AxisCommand::Off));
            let standing =
                |axis: &AxisCommand| matches!(axis, AxisCommand::Velocity(0) | AxisCommand::QuickStop);
            let stood = commands[..=powered.unwrap_or(0)]
                .iter()
                .rev()
                .take_while(|axes| axes.iter().all(|axis| standing(axis) || *axis == AxisCommand::Off));
            let stood = stood.count();
            assert!(end == End::BusAlone || stood >= 20, "{name} {end:?}: stood for {stood} cycles before");
        }
    }
}

#[test]
fn drives_in_torque_mode_are_disabled_too() {
    for end in [End::ErrorInACycle, End::AtOnce] {
        let setup = Setup::new(with_mode(machine("planar_leg"), DriveMode::Torque), 3, &[]);
        let watched = Watched::new(&setup);
        ended(&setup, &watched, end);
        assert_eq!(watched.released(), 0, "{end:?}");
    }
}

#[test]
fn a_bus_that_does_not_come_into_operation_leaves_no_drive_enabled() {
    let setup = Setup::new(machine("planar_leg"), 3, &[]);
    let watched = Watched::new(&setup);
    let drives: Vec<usize> = (0..setup.machine.devices.len())
        .filter(|k| matches!(setup.machine.devices[*k].role, DeviceRole::Drive(_)))
        .collect();
    // The last drive reports a fault again and again, so that the others are enabled and it is not.
    let last = *drives.last().unwrap();
    let storage = FrameStorage::new();
    struct Failing(Watched, usize);
    impl Link for Failing {
        fn now(&mut self) -> u64 {
            self.0.now()
        }
        fn send(&mut self, frame: &[u8]) -> std::io::Result<()> {
            self.0.send(frame)
        }
        fn receive(&mut self, buffer: &mut [u8]) -> std::io::Result<Option<usize>> {
            self.0.receive(buffer)
        }
        fn idle(&mut self) {
            self.0.idle();
        }
        fn rest_until(&mut self, time: u64) {
            self.0.rest_until(time);
        }
        fn begin_cycle(&mut self, period: u64) {
            self.0.begin_cycle(period);
            let mut inner = self.0.0.borrow_mut();
            if let Some(drive) =
                inner.0.segment_mut().device_mut(self.1).and_then(|device| device.drive_mut())
            {
                drive.raise_fault(0x1234);
            }
        }
    }
    let master = Master::new(&storage, Failing(watched.clone(), last)).unwrap();
    let matched = master.match_devices(&setup.devices).unwrap();
    let refused = matched.operate(&setup.machine).err().unwrap().to_string();
    assert!(refused.contains(&setup.machine.devices[last].name), "{refused}");
    assert!(watched.cycles() > 1000 && watched.released() == 0, "{}", watched.released());
}
