//! What identifies a machine's servos.

use super::error::ServoError;
use super::model::Model;
use super::registers::BAUD;
use sinew::machine::{Device, DeviceRole, DriveDevice, DriveMode, Machine};

/// A drive of the machine that is a serial servo.
#[derive(Debug, Clone, PartialEq)]
pub struct ServoDevice {
    /// Index in the machine's list of devices.
    pub device: usize,
    /// As messages name it.
    pub name: String,
    /// What it does for the machine, with the counts of its horn in a turn of the motor.
    pub drive: DriveDevice,
    /// Its identifier on its line.
    pub id: u8,
    /// Its model.
    pub model: Model,
    /// Serial port; none: the one that the program is given.
    pub port: Option<String>,
    /// Rate of the port, bit/s.
    pub baud: u32,
    /// What it is commanded.
    pub mode: OperatingMode,
    /// Time by which it follows goals of the position late, s: they are ahead by it.
    pub position_lag: f64,
}

/// What a servo is commanded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OperatingMode {
    /// Current of the motor: the control cycle closes the loops.
    Current,
    /// Velocity.
    Velocity,
    /// The integral of the velocity as a position over any number of turns.
    ExtendedPosition,
}

impl OperatingMode {
    /// Its number in the control table.
    #[must_use]
    pub fn number(self) -> u8 {
        match self {
            Self::Current => 0,
            Self::Velocity => 1,
            Self::ExtendedPosition => 4,
        }
    }

    /// That of a drive without a mode of its own.
    #[must_use]
    pub fn of(mode: DriveMode) -> Self {
        match mode {
            DriveMode::Velocity => Self::Velocity,
            DriveMode::Torque => Self::Current,
        }
    }
}

impl ServoDevice {
    /// Lag that is taken for one that nobody has measured, s. None costs accuracy, twice that of the servo
    /// excites the machine.
    pub const POSITION_LAG: f64 = 6e-3;

    /// The servos of a machine whose file names no devices: servo n drives muscle n and has identifier n,
    /// from 1, on the port that the program is given, at 1 Mbit/s.
    #[must_use]
    pub fn simulated(machine: &Machine) -> Vec<Self> {
        let servo = |(device, of): (usize, &Device)| {
            let DeviceRole::Drive(drive) = of.role else { return None };
            let servo = Self {
                device,
                name: of.name.clone(),
                drive,
                id: drive.muscle as u8 + 1,
                model: Model::any(),
                port: None,
                baud: BAUD[3],
                mode: OperatingMode::of(drive.mode),
                position_lag: Self::POSITION_LAG,
            };
            Some(servo.with_counts(machine))
        };
        machine.devices.iter().enumerate().filter_map(servo).collect()
    }

    /// With the counts of its horn in a turn of the motor, in the direction that the drive has.
    pub(super) fn with_counts(mut self, machine: &Machine) -> Self {
        let ratio = machine.muscles[self.drive.muscle].drive.reducer.ratio;
        self.drive.counts_per_turn = (self.model.counts / ratio).copysign(self.drive.counts_per_turn);
        self
    }

    /// That nothing answers in its place.
    pub(super) fn silent(&self) -> ServoError {
        ServoError::Silent { device: self.name.clone(), id: self.id, baud: self.baud }
    }

    /// The ports of servos, each once, in their order.
    #[must_use]
    pub fn ports(devices: &[Self]) -> Vec<Option<String>> {
        let mut ports = Vec::new();
        for device in devices {
            if !ports.contains(&device.port) {
                ports.push(device.port.clone());
            }
        }
        ports
    }
}
