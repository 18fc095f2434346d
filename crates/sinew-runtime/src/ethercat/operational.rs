//! The bus in operation: one exchange of process data a cycle.

use super::bring_up::{self, Mappings, OP, OpGroup, PreOpGroup};
use super::cia402::DriveState;
use super::drive::DriveSlot;
use super::error::EthercatError;
use super::image::Field;
use super::link::Link;
use super::master::Master;
use super::pump::Pump;
use super::recovery;
use crate::bus::{Bus, BusFault, Exchange, Feedback};
use ethercrab::{MainDevice, SubDeviceState};
use sinew::drive::DriveCommand;
use sinew::machine::{DeviceRole, Machine, SensorChannel, Signal};

/// Devices in OP that matched the machine, their drives enabled.
pub struct EthercatBus<'a, L> {
    main: MainDevice<'a>,
    pump: Pump<'a, L>,
    group: OpGroup,
    slots: Vec<Slot>,
    /// Working counter of an exchange in which every device takes part.
    expected_counter: u16,
    /// ns.
    period: u64,
    /// Muscles and independent joints of the machine.
    dimensions: [usize; 2],
    /// Of the devices on the wire.
    names: Vec<String>,
    /// Cycles until the next step that brings a device back.
    until_recovery: u32,
}

/// A device of the machine and what it does in a cycle.
struct Slot {
    /// On the wire.
    position: usize,
    role: SlotRole,
}

enum SlotRole {
    Drive(Box<DriveSlot>),
    Sensors(Vec<SensorSlot>),
}

struct SensorSlot {
    channel: SensorChannel,
    value: Field,
    /// Status word and the bits that mark a reading as invalid.
    status: Option<(Field, u16)>,
}

/// Time without outputs after which drives stop by themselves, ns.
const WATCHDOG: u64 = 20_000_000;
/// Time for an answer within a cycle, as a share of its period: 1/2.
const ANSWER_SHARE: u64 = 2;
/// Cycles until all devices are in OP and their drives enabled, at most: seconds.
const MAX_START_CYCLES: u64 = 8000;

impl<'a, L: Link> EthercatBus<'a, L> {
    /// As [`Matched::operate`](super::Matched::operate).
    pub(super) fn start(
        master: Master<'a, L>,
        group: PreOpGroup,
        positions: &[usize],
        machine: &Machine,
        period: u64,
    ) -> Result<Self, EthercatError> {
        let Master { main, mut pump } = master;
        let places = (&machine.devices[..], positions);
        let mappings = pump.complete(bring_up::configure(&main, &group, places, period, WATCHDOG))?;
        let slots = slots(machine, positions, &mappings)?;
        let mut names = vec![String::new(); positions.len()];
        positions.iter().zip(&machine.devices).for_each(|(at, device)| names[*at].clone_from(&device.name));
        let group = pump.complete(bring_up::request_op(&main, group, &names))?;
        // A device adds 1 for inputs that are read and 2 for outputs that are written.
        let counts = |[outputs, inputs]: &Mappings| {
            u16::from(inputs.length() > 0) + 2 * u16::from(outputs.length() > 0)
        };
        let expected_counter = mappings.iter().map(counts).sum();
        let dimensions = [machine.muscles.len(), machine.encoders.len()];
        let mut bus =
            Self { main, pump, group, slots, expected_counter, period, dimensions, names, until_recovery: 0 };
        bus.enable(machine)?;
        Ok(bus)
    }

    /// Exchanges process data until every device is in OP and every drive enabled and standing.
    fn enable(&mut self, machine: &Machine) -> Result<(), EthercatError> {
        let [muscles, joints] = self.dimensions;
        let hold = vec![DriveCommand::Velocity(0.0); muscles];
        let mut feedback = Feedback::new(muscles, joints);
        for _ in 0..MAX_START_CYCLES {
            let exchange = self.paced_exchange(&hold, &mut feedback);
            if exchange.fault.is_none() && self.disabled_drive().is_none() {
                return Ok(());
            }
        }
        let Self { main, pump, names, .. } = self;
        if let Some(device) = pump.complete(bring_up::not_in_state(main, names, OP)) {
            return Err(device);
        }
        let (device, state, code) = self.disabled_drive().unwrap_or((0, DriveState::NotReadyToSwitchOn, 0));
        Err(EthercatError::NotEnabled { device: machine.devices[device].name.clone(), state, code })
    }

    /// The first drive that is not enabled: its device, state and error code.
    fn disabled_drive(&self) -> Option<(usize, DriveState, u16)> {
        self.slots.iter().enumerate().find_map(|(k, slot)| match &slot.role {
            SlotRole::Drive(drive) if drive.state() != DriveState::OperationEnabled => {
                let subdevice = self.group.subdevice(&self.main, slot.position).ok()?;
                let code = drive.error_code(&subdevice.inputs_raw());
                Some((k, drive.state(), code))
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

    /// The master alone, to start the bus anew: devices that were switched off or exchanged are looked for, compared with the
    /// machine and configured again.
    #[must_use]
    pub fn into_master(self) -> Master<'a, L> {
        Master { main: self.main, pump: self.pump }
    }

    /// One step that brings the first device back that is not operational, where it is due and still has an address.
    fn recover(&mut self, states: &[SubDeviceState], deadline: u64) {
        let Some(position) = states.iter().position(|state| *state == SubDeviceState::SafeOp) else {
            self.until_recovery = 0;
            return;
        };
        if self.until_recovery > 0 {
            self.until_recovery -= 1;
            return;
        }
        self.until_recovery = RECOVERY_CYCLES;
        // Without an answer the next step tries again.
        let _ = self.pump.complete_by(deadline, recovery::step(&self.main, position));
    }

    /// Brakes all drives and closes their brakes; the devices stay in OP.
    pub fn stop(&mut self) {
        let [muscles, joints] = self.dimensions;
        let mut feedback = Feedback::new(muscles, joints);
        let brake = vec![DriveCommand::Brake; muscles];
        for _ in 0..STOP_CYCLES {
            self.paced_exchange(&brake, &mut feedback);
        }
    }

    /// An exchange outside of a control cycle: it takes a whole period.
    fn paced_exchange(&mut self, commands: &[DriveCommand], feedback: &mut Feedback) -> Exchange {
        let begin = self.pump.link_mut().now();
        let exchange = self.exchange(commands, feedback);
        self.pump.link_mut().rest_until(begin + self.period);
        exchange
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

    /// Reads all devices that are in OP; the fault of a drive before that of a sensor.
    fn read_inputs(&mut self, states: &[SubDeviceState], feedback: &mut Feedback) -> Option<BusFault> {
        let mut fault = None;
        for (k, slot) in self.slots.iter_mut().enumerate() {
            let state = states.get(slot.position).copied().unwrap_or(SubDeviceState::None);
            let device = (state == SubDeviceState::Op)
                .then(|| self.group.subdevice(&self.main, slot.position).ok())
                .flatten();
            let found = match (&mut slot.role, device) {
                (SlotRole::Drive(drive), Some(device)) => {
                    let muscle = drive.device.muscle;
                    let (position, code) = drive.read(&device.inputs_raw());
                    feedback.motor[muscle] = position;
                    code.map(|code| BusFault::Drive { muscle, code })
                }
                (SlotRole::Sensors(sensors), Some(device)) => {
                    sensors.iter().for_each(|sensor| sensor.read(&device.inputs_raw(), feedback));
                    None
                }
                (SlotRole::Drive(drive), None) => {
                    let muscle = drive.device.muscle;
                    feedback.motor[muscle] = f64::NAN;
                    drive.forget_state();
                    Some(BusFault::NotOperational { device: k, state: number(state), muscle: Some(muscle) })
                }
                (SlotRole::Sensors(sensors), None) => {
                    sensors.iter().for_each(|sensor| sensor.write(f64::NAN, feedback));
                    Some(BusFault::NotOperational { device: k, state: number(state), muscle: None })
                }
            };
            fault = if fault.is_some_and(|fault| concerns_drive(&fault)) { fault } else { found.or(fault) };
        }
        fault
    }

    /// The measured tensions limit the speeds of the drives.
    fn feed_tensions(&mut self, feedback: &Feedback) {
        for slot in &mut self.slots {
            if let SlotRole::Drive(drive) = &mut slot.role {
                drive.set_tension(feedback.tension[drive.device.muscle]);
            }
        }
    }
}

/// Cycles between two steps that bring a device back.
const RECOVERY_CYCLES: u32 = 10;

/// Cycles in which drives brake before the program ends.
const STOP_CYCLES: u32 = 200;

fn concerns_drive(fault: &BusFault) -> bool {
    matches!(fault, BusFault::Drive { .. } | BusFault::NotOperational { muscle: Some(_), .. })
}

/// A state as in the register AL status.
fn number(state: SubDeviceState) -> u8 {
    match state {
        SubDeviceState::None => 0,
        SubDeviceState::Init => 1,
        SubDeviceState::PreOp => 2,
        SubDeviceState::Bootstrap => 3,
        SubDeviceState::SafeOp => 4,
        SubDeviceState::Op => 8,
        SubDeviceState::Other(number) => number,
    }
}

impl<L: Link> Bus for EthercatBus<'_, L> {
    fn exchange(&mut self, commands: &[DriveCommand], feedback: &mut Feedback) -> Exchange {
        self.pump.link_mut().begin_cycle(self.period);
        self.write_outputs(commands);
        let deadline = self.pump.link_mut().now() + self.period / ANSWER_SHARE;
        let answer = self.pump.complete_by(deadline, self.group.tx_rx(&self.main));
        let Some(Ok(answer)) = answer else {
            feedback.clear();
            return Exchange { fault: Some(BusFault::Lost) };
        };
        let mut fault = self.read_inputs(&answer.subdevice_states, feedback);
        if fault.is_none() && answer.working_counter != self.expected_counter {
            // Some device did not take part, and the counter does not say which.
            feedback.clear();
            let (expected, got) = (self.expected_counter, answer.working_counter);
            fault = Some(BusFault::WorkingCounter { expected, got });
        }
        self.feed_tensions(feedback);
        self.recover(&answer.subdevice_states, deadline);
        Exchange { fault }
    }
}

fn slots(machine: &Machine, positions: &[usize], mappings: &[Mappings]) -> Result<Vec<Slot>, EthercatError> {
    let mut slots = Vec::new();
    for ((device, position), [outputs, inputs]) in machine.devices.iter().zip(positions).zip(mappings) {
        let role = match &device.role {
            DeviceRole::Drive(drive) => {
                let parameters = machine.muscles[drive.muscle].drive;
                SlotRole::Drive(Box::new(DriveSlot::new(
                    &device.name,
                    *drive,
                    parameters,
                    [outputs, inputs],
                )?))
            }
            DeviceRole::Sensors(channels) => {
                let sensor = |channel: &SensorChannel| {
                    let value = inputs.require(&device.name, channel.value, &[1, 2, 4])?;
                    let status = channel.status.map(|(object, mask)| {
                        inputs.require(&device.name, object, &[1, 2]).map(|field| (field, mask))
                    });
                    Ok(SensorSlot { channel: *channel, value, status: status.transpose()? })
                };
                SlotRole::Sensors(channels.iter().map(sensor).collect::<Result<_, EthercatError>>()?)
            }
        };
        slots.push(Slot { position: *position, role });
    }
    Ok(slots)
}

impl SensorSlot {
    fn read(&self, inputs: &[u8], feedback: &mut Feedback) {
        let invalid = self.status.is_some_and(|(field, mask)| field.word(inputs).unwrap_or(mask) & mask != 0);
        let count = self.value.signed(inputs).filter(|_| !invalid);
        let reading =
            count.map_or(f64::NAN, |count| self.channel.scale * f64::from(count) + self.channel.offset);
        self.write(reading, feedback);
    }

    fn write(&self, reading: f64, feedback: &mut Feedback) {
        match self.channel.signal {
            Signal::Tension(muscle) => feedback.tension[muscle] = reading,
            Signal::Joint(joint) => feedback.joint[joint] = reading,
        }
    }
}
