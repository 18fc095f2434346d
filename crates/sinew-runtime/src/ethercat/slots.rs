//! The devices of the machine in the process data: what each of them reads and writes in a cycle.

use super::bring_up::Mappings;
use super::device::{ChannelObjects, EthercatDevice};
use super::error::EthercatError;
use crate::cia402::{DriveSlot, Field};
use ethercrab::SubDeviceState;
use sinew::machine::{DeviceRole, Machine, SensorChannel, Signal};
use sinew_session::{BusFault, Feedback};

/// A device of the machine and what it does in a cycle.
pub(super) struct Slot {
    /// On the wire.
    pub(super) position: usize,
    pub(super) role: SlotRole,
}

pub(super) enum SlotRole {
    Drive(Box<DriveSlot>),
    Sensors(Vec<SensorSlot>),
}

pub(super) struct SensorSlot {
    channel: SensorChannel,
    value: Field,
    /// Status word and the bits that mark a reading as invalid.
    status: Option<(Field, u16)>,
}

/// The devices of a machine, with their objects found in the process data that is mapped.
///
/// # Errors
/// [`EthercatError::NotMapped`] for the first object that is missing.
pub(super) fn slots(
    machine: &Machine,
    (devices, positions): (&[EthercatDevice], &[usize]),
    mappings: &[Mappings],
) -> Result<Vec<Slot>, EthercatError> {
    let mut slots = Vec::new();
    for ((device, position), [outputs, inputs]) in devices.iter().zip(positions).zip(mappings) {
        let name = device.name();
        let role = match &device.device.role {
            DeviceRole::Drive(drive) => {
                let parameters = machine.muscles[drive.muscle].drive;
                let mapped = [outputs, inputs];
                SlotRole::Drive(Box::new(DriveSlot::new(name, *drive, parameters, mapped)?))
            }
            DeviceRole::Sensors(_) => {
                let sensor = |(channel, objects): (&SensorChannel, &ChannelObjects)| {
                    let value = inputs.require(name, objects.value, &[1, 2, 4])?;
                    let status = objects.status.map(|(object, mask)| {
                        inputs.require(name, object, &[1, 2]).map(|field| (field, mask))
                    });
                    Ok(SensorSlot { channel: *channel, value, status: status.transpose()? })
                };
                SlotRole::Sensors(device.channels().map(sensor).collect::<Result<_, EthercatError>>()?)
            }
        };
        slots.push(Slot { position: *position, role });
    }
    Ok(slots)
}

impl Slot {
    /// Reads the inputs of the device, its `device`-th in the machine; without any, it is not operational and
    /// its readings are missing.
    pub(super) fn read(
        &mut self,
        device: usize,
        (state, inputs): (SubDeviceState, Option<&[u8]>),
        feedback: &mut Feedback,
    ) -> Option<BusFault> {
        let lost = |muscle| Some(BusFault::NotReady { device, code: number(state), muscle });
        match (&mut self.role, inputs) {
            (SlotRole::Drive(drive), Some(inputs)) => {
                let muscle = drive.device.muscle;
                let (position, code) = drive.read(inputs);
                feedback.motor[muscle] = position;
                feedback.current[muscle] = drive.current(inputs);
                code.map(|code| BusFault::Drive { muscle, code })
            }
            (SlotRole::Sensors(sensors), Some(inputs)) => {
                sensors.iter().for_each(|sensor| sensor.read(inputs, feedback));
                None
            }
            (SlotRole::Drive(drive), None) => {
                let muscle = drive.device.muscle;
                feedback.motor[muscle] = f64::NAN;
                feedback.current[muscle] = f64::NAN;
                drive.forget_state();
                lost(Some(muscle))
            }
            (SlotRole::Sensors(sensors), None) => {
                sensors.iter().for_each(|sensor| sensor.show(f64::NAN, feedback));
                lost(None)
            }
        }
    }
}

/// A state as in the register AL status.
fn number(state: SubDeviceState) -> u16 {
    match state {
        SubDeviceState::None => 0,
        SubDeviceState::Init => 1,
        SubDeviceState::PreOp => 2,
        SubDeviceState::Bootstrap => 3,
        SubDeviceState::SafeOp => 4,
        SubDeviceState::Op => 8,
        SubDeviceState::Other(number) => number.into(),
    }
}

impl SensorSlot {
    fn read(&self, inputs: &[u8], feedback: &mut Feedback) {
        let invalid = self.status.is_some_and(|(field, mask)| field.word(inputs).unwrap_or(mask) & mask != 0);
        let count = self.value.signed(inputs).filter(|_| !invalid);
        let reading =
            count.map_or(f64::NAN, |count| self.channel.scale * f64::from(count) + self.channel.offset);
        self.show(reading, feedback);
    }

    fn show(&self, reading: f64, feedback: &mut Feedback) {
        match self.channel.signal {
            Signal::Tension(muscle) => feedback.tension[muscle] = reading,
            Signal::Joint(joint) => feedback.joint[joint] = reading,
        }
    }
}
