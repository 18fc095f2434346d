//! The bus in operation: process data read at the beginning of a cycle and written at its end.

use super::bring_up::{self, OP, OpGroup, PreOpGroup};
use super::clocks::{self, Clocks};
use super::device::EthercatDevice;
use super::error::EthercatError;
use super::link::Link;
use super::master::{Master, matching};
use super::process_data::ProcessData;
use super::pump::Pump;
use super::recovery;
use super::simulated_machine::SimulatedMachine;
use super::slots::{Slot, SlotRole, slots};
use crate::cia402::{DriveSlot, DriveState};
use crate::rest::{Drives, bring_to_rest};
use ethercrab::error::Error;
use ethercrab::{MainDevice, SubDeviceState};
use sinew::drive::DriveCommand;
use sinew::machine::Machine;
use sinew::twin::arm::ArmTwin;
use sinew_session::{BusFault, ClockReport, Exchange, Feedback, Plant};

/// Devices in OP that matched the machine, their drives enabled. It owns the drives: dropped it
/// [stops](Self::stop) them, whatever has happened.
pub struct EthercatBus<'a, L: Link> {
    main: MainDevice<'a>,
    pump: Pump<'a, L>,
    group: OpGroup,
    slots: Vec<Slot>,
    data: ProcessData,
    clocks: Option<Clocks>,
    /// Whether drives may have torque.
    in_operation: bool,
    /// Control period, ns.
    period: u64,
    /// When the cycle began, ns.
    begin: u64,
    /// When commands were last written in time, ns.
    commanded: Option<u64>,
    /// Muscles and independent joints of the machine.
    dimensions: [usize; 2],
    /// Those of the machine.
    devices: Vec<EthercatDevice>,
    /// Of the devices on the wire.
    names: Vec<String>,
    /// Of the devices on the wire, after the last writing that was answered.
    states: Vec<SubDeviceState>,
    /// What was wrong with the last writing.
    written: Option<BusFault>,
    /// Cycles until the next step that brings a device back, and until the next look at a clock.
    until_recovery: u64,
    until_clock: u64,
}

/// Since the beginning of a cycle, when inputs and the answer to outputs are waited for no longer: fractions
/// of the period.
const READ_FRACTION: f64 = 0.5;
const WRITE_FRACTION: f64 = 0.9;
/// Time until all devices are in OP and their drives enabled, at most, ns.
const START_TIME: u64 = 8_000_000_000;
/// Time between two steps that bring a device back, ns.
const RECOVERY_TIME: u64 = 10_000_000;
/// Time between two looks at a device's clock, ns.
const CLOCK_TIME: u64 = 50_000_000;
/// Cycles of any such time, at least: a drive takes one state after the other.
const MIN_CYCLES: u64 = 5;

impl<'a, L: Link> EthercatBus<'a, L> {
    /// As [`Matched::operate`](super::Matched::operate).
    pub(super) fn start(
        master: Master<'a, L>,
        group: PreOpGroup,
        (devices, positions): (Vec<EthercatDevice>, &[usize]),
        machine: &Machine,
    ) -> Result<Self, EthercatError> {
        let Master { main, mut pump } = master;
        let places = (&devices[..], positions);
        let configured = configure(&main, &mut pump, group, places, machine)?;
        let mut bus = Self {
            dimensions: [machine.muscles.len(), machine.encoders.len()],
            written: None,
            begin: 0,
            commanded: None,
            until_recovery: 0,
            until_clock: 0,
            in_operation: true,
            main,
            pump,
            period: machine.period_ns(),
            states: Vec::with_capacity(positions.len()),
            group: configured.group,
            slots: configured.slots,
            data: configured.data,
            clocks: configured.clocks,
            names: configured.names,
            devices,
        };
        bus.enable()?;
        Ok(bus)
    }

    /// Starts the bus anew: devices that were switched off or exchanged are looked for, compared with those
    /// of the machine, configured and enabled again.
    ///
    /// # Errors
    /// As [`Master::match_devices`] and [`Matched::operate`](super::Matched::operate). No drive has torque
    /// then; the bus can be started anew again.
    pub fn restart(&mut self, machine: &Machine) -> Result<(), EthercatError> {
        self.stop();
        let Self { main, pump, devices, .. } = self;
        let (group, positions) = matching(main, pump, devices)?;
        let configured = configure(main, pump, group, (devices, &positions), machine)?;
        (self.group, self.slots, self.data) = (configured.group, configured.slots, configured.data);
        (self.clocks, self.names) = (configured.clocks, configured.names);
        self.dimensions = [machine.muscles.len(), machine.encoders.len()];
        self.period = machine.period_ns();
        (self.written, self.until_recovery, self.until_clock) = (None, 0, 0);
        self.states.clear();
        self.in_operation = true;
        self.enable()
    }

    /// Exchanges process data until every device is in OP and every drive enabled and standing.
    fn enable(&mut self) -> Result<(), EthercatError> {
        let [muscles, joints] = self.dimensions;
        let hold = vec![DriveCommand::Velocity(0.0); muscles];
        let mut feedback = Feedback::new(muscles, joints);
        self.align_with_clocks();
        for _ in 0..self.cycles_of(START_TIME) {
            let exchange = self.read(&mut feedback);
            if exchange.fault.is_none() && self.disabled_drive().is_none() {
                self.write_and_wait(&hold);
                self.clocks.iter_mut().for_each(Clocks::forget_differences);
                return Ok(());
            }
            self.write_and_wait(&hold);
        }
        let Self { main, pump, names, .. } = self;
        if let Some(device) = pump.complete(bring_up::not_in_state(main, names, OP)) {
            return Err(device);
        }
        let (device, state, code) = self.disabled_drive().unwrap_or((0, DriveState::NotReadyToSwitchOn, 0));
        let device = self.devices.get(device).map_or("a drive", EthercatDevice::name).to_owned();
        Err(EthercatError::NotEnabled { device, state, code })
    }

    /// The first drive that is not enabled: its device, state and error code.
    fn disabled_drive(&self) -> Option<(usize, DriveState, u16)> {
        self.slots.iter().enumerate().find_map(|(k, slot)| match &slot.role {
            SlotRole::Drive(drive) if drive.state() != DriveState::OperationEnabled => {
                Some((k, drive.state(), drive.error_code(self.data.inputs(slot.position))))
            }
            _ => None,
        })
    }

    /// The link.
    #[must_use]
    pub fn link(&self) -> &L {
        self.pump.link()
    }

    /// The link.
    pub fn link_mut(&mut self) -> &mut L {
        self.pump.link_mut()
    }

    /// Brings all drives to rest on a ramp, then takes their power, so that their brakes close; the devices
    /// stay in OP.
    pub fn stop(&mut self) {
        if std::mem::take(&mut self.in_operation) {
            bring_to_rest(self);
        }
    }

    fn drives(&self) -> impl Iterator<Item = &DriveSlot> {
        self.slots.iter().filter_map(|slot| match &slot.role {
            SlotRole::Drive(drive) => Some(&**drive),
            SlotRole::Sensors(_) => None,
        })
    }

    fn corrected_period(&self) -> u64 {
        self.period.saturating_add_signed(self.period_correction())
    }

    /// Since the beginning of the cycle, ns, the deadline of an answer.
    fn deadline(&self, fraction: f64) -> u64 {
        self.begin + (self.period as f64 * fraction) as u64
    }

    fn write_outputs(&mut self, commands: &[DriveCommand]) {
        let h = self.period as f64 * 1e-9;
        for slot in &mut self.slots {
            let SlotRole::Drive(drive) = &mut slot.role else { continue };
            let command = commands.get(drive.device.muscle).copied().unwrap_or(DriveCommand::Brake);
            if let Ok(device) = self.group.subdevice(&self.main, slot.position) {
                drive.write(&mut device.outputs_raw_mut(), command, h);
            }
        }
    }

    /// Takes over the readings of all devices that are in OP; the fault of a drive before that of a sensor.
    fn take_over(&mut self, feedback: &mut Feedback) -> Option<BusFault> {
        let mut fault = None;
        let age = self.commanded.map_or(f64::NAN, |at| self.begin.saturating_sub(at) as f64 * 1e-3);
        feedback.setpoint_age.fill(age);
        for (k, slot) in self.slots.iter_mut().enumerate() {
            let state = self.states.get(slot.position).copied().unwrap_or(SubDeviceState::None);
            let inputs = (state == SubDeviceState::Op).then(|| self.data.inputs(slot.position));
            let found = slot.read(k, (state, inputs), feedback);
            fault = if fault.is_some_and(|fault| concerns_drive(&fault)) { fault } else { found.or(fault) };
        }
        for slot in &mut self.slots {
            // The measured tensions limit the speeds of the drives.
            if let SlotRole::Drive(drive) = &mut slot.role {
                drive.set_tension(feedback.tension[drive.device.muscle]);
            }
        }
        fault
    }

    /// One step that brings the first device back that is not operational, where it is due and still has an
    /// address.
    fn recover(&mut self, deadline: u64) {
        let Some(position) = self.states.iter().position(|state| *state == SubDeviceState::SafeOp) else {
            self.until_recovery = 0;
            return;
        };
        if self.until_recovery > 0 {
            self.until_recovery -= 1;
            return;
        }
        self.until_recovery = self.cycles_of(RECOVERY_TIME);
        // Without an answer the next step tries again.
        let _ = self.pump.complete_by(deadline, recovery::step(&self.main, position));
    }

    /// The next cycle begins in phase with the clocks, before any drive is enabled.
    fn align_with_clocks(&mut self) {
        let sent = self.pump.link_mut().now();
        let answer = self.pump.complete(self.group.tx_rx_sync_system_time(&self.main));
        if let (Some(clocks), Ok(Some(time))) = (&mut self.clocks, answer.map(|answer| answer.extra)) {
            self.pump.link_mut().rest_until(sent + clocks.until_begin(time));
        }
    }

    /// Compares a device's clock with the reference, one device after the other.
    fn compare_clocks(&mut self, deadline: u64) {
        let every = self.cycles_of(CLOCK_TIME);
        let Some(clocks) = &mut self.clocks else { return };
        self.until_clock = if self.until_clock == 0 { every } else { self.until_clock - 1 };
        if self.until_clock > 0 {
            return;
        }
        if let Some(position) = clocks.next_device()
            && let Some(Ok(difference)) =
                self.pump.complete_by(deadline, clocks::read_difference(&self.main, position))
        {
            clocks.record_difference(difference);
        }
    }
}

impl<L: Link> Drives for EthercatBus<'_, L> {
    fn dimensions(&self) -> [usize; 2] {
        self.dimensions
    }

    fn are_without_power(&self, last: Exchange) -> bool {
        last.fault != Some(BusFault::Lost) && !self.drives().any(|drive| drive.state().has_torque())
    }

    fn slow_down(&self, commands: &mut [DriveCommand]) -> bool {
        let h = self.period as f64 * 1e-9;
        let mut standing = true;
        for drive in self.drives() {
            let speed = drive.braked_speed(h);
            standing &= speed == 0.0;
            if let Some(command) = commands.get_mut(drive.device.muscle) {
                *command = DriveCommand::Velocity(speed);
            }
        }
        standing
    }

    fn write_and_wait(&mut self, commands: &[DriveCommand]) {
        self.write(commands);
        let next = self.begin.saturating_add(self.corrected_period());
        self.pump.link_mut().rest_until(next);
    }

    fn cycles_of(&self, time: u64) -> u64 {
        (time / self.period.max(1)).max(MIN_CYCLES)
    }
}

impl<L: Link> Drop for EthercatBus<'_, L> {
    fn drop(&mut self) {
        self.stop();
    }
}

/// Devices that are configured and in OP.
struct Configured {
    group: OpGroup,
    slots: Vec<Slot>,
    data: ProcessData,
    clocks: Option<Clocks>,
    names: Vec<String>,
}

/// Configures the devices at these positions for a machine and its period, and brings them to OP.
fn configure<L: Link>(
    main: &MainDevice<'_>,
    pump: &mut Pump<'_, L>,
    group: PreOpGroup,
    (devices, positions): (&[EthercatDevice], &[usize]),
    machine: &Machine,
) -> Result<Configured, EthercatError> {
    let period = machine.period_ns();
    let watchdog = (1e9 * machine.watchdog()) as u64;
    let places = (devices, positions);
    let mappings = pump.complete(bring_up::configure(main, &group, places, period, watchdog))?;
    let slots = slots(machine, places, &mappings)?;
    let mut names = vec![String::new(); positions.len()];
    positions.iter().zip(devices).for_each(|(at, device)| device.name().clone_into(&mut names[*at]));
    let group = pump.complete(bring_up::map_addresses(main, group))?;
    let synchronized = slots.iter().zip(devices).filter_map(|(slot, device)| {
        let is_drive = matches!(slot.role, SlotRole::Drive(_));
        (is_drive && device.sync0).then(|| (slot.position, names[slot.position].as_str()))
    });
    let synchronized: Vec<_> = synchronized.collect();
    let clocks = pump.complete(clocks::start(main, &group, &synchronized, period))?;
    let group = pump.complete(bring_up::request_op(main, group, &names))?;
    let data = ProcessData::new(main, &group, positions.len(), clocks.is_some());
    Ok(Configured { group, slots, data, clocks, names })
}

fn concerns_drive(fault: &BusFault) -> bool {
    matches!(fault, BusFault::Drive { .. } | BusFault::NotReady { muscle: Some(_), .. })
}

impl<L: Link> Plant for EthercatBus<'_, L> {
    fn read(&mut self, feedback: &mut Feedback) -> Exchange {
        let period = self.corrected_period();
        self.pump.link_mut().begin_cycle(period);
        self.begin = self.pump.link_mut().now();
        let deadline = self.deadline(READ_FRACTION);
        let fault = match self.pump.complete_by(deadline, self.data.read(&self.main)) {
            Some(Ok(())) => self.take_over(feedback).or(self.written).or(self.pump.link().injected()),
            Some(Err(Error::WorkingCounter { expected, received })) => {
                // Some device did not take part, and the counter does not say which.
                feedback.clear();
                Some(BusFault::Missing { expected, got: received })
            }
            _ => {
                feedback.clear();
                Some(BusFault::Lost)
            }
        };
        Exchange { fault }
    }

    fn write(&mut self, commands: &[DriveCommand]) {
        self.write_outputs(commands);
        let deadline = self.deadline(WRITE_FRACTION);
        let sent = self.pump.link_mut().now().saturating_sub(self.begin);
        let answer = self.pump.complete_by(deadline, self.group.tx_rx_sync_system_time(&self.main));
        let Some(Ok(answer)) = answer else {
            self.written = Some(BusFault::Lost);
            return;
        };
        self.states.clear();
        self.states.extend_from_slice(&answer.subdevice_states);
        self.data.expect(&self.states);
        let (expected, got) = (self.data.written(), answer.working_counter);
        self.written = (got != expected).then_some(BusFault::Missing { expected, got });
        if self.written.is_none() {
            self.commanded = Some(self.begin + sent);
        }
        if let (Some(clocks), Some(time)) = (&mut self.clocks, answer.extra) {
            clocks.follow(time, sent);
        }
        self.compare_clocks(deadline);
        self.recover(deadline);
    }

    fn stop(&mut self) {
        EthercatBus::stop(self);
    }

    fn period_correction(&self) -> i64 {
        self.clocks.as_ref().map_or(0, Clocks::correction)
    }

    fn clocks(&self) -> Option<ClockReport> {
        self.clocks.as_ref().map(Clocks::report)
    }

    fn simulated(&self) -> Option<&ArmTwin> {
        self.link().simulated().map(SimulatedMachine::arm)
    }

    fn has_failed(&self) -> bool {
        self.link().simulated().is_some_and(SimulatedMachine::failed)
    }
}
