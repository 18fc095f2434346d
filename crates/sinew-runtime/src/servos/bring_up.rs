//! Servos before they take commands: found, compared, configured, and everything read back.

use super::device::{OperatingMode, ServoDevice};
use super::error::{ServoError, status};
use super::line::Lines;
use super::protocol::instruction::{PING, READ, STATUS, WRITE};
use super::protocol::{Decoder, Protocol};
use super::registers::{Registers, eeprom, sts};
use super::series::Series;
use sinew::machine::Machine;
use std::io;

/// Time for an answer, ns: an adapter's latency, a return delay, a loaded computer.
const PATIENCE: u64 = 40_000_000;
/// Times that an answer is asked for.
const TRIES: usize = 3;
/// Unit of the bus watchdog, s.
const WATCHDOG_UNIT: f64 = 0.02;

/// The addresses that a reading of a Dynamixel is made of, by way of indirect addresses: torque enable, bus
/// watchdog, hardware error, temperature, current, velocity, position.
fn shown(of: Registers) -> impl Iterator<Item = u16> {
    [of.torque_enable, of.bus_watchdog, of.hardware_error, of.temperature()]
        .into_iter()
        .chain(of.present..of.present + 10)
}

/// A question to one servo, and its answer.
pub(super) struct Exchange<'a, L> {
    pub(super) lines: &'a mut L,
    pub(super) decoder: Decoder,
    pub(super) out: Vec<u8>,
}

impl<'a, L: Lines> Exchange<'a, L> {
    pub(super) fn new(lines: &'a mut L) -> Self {
        Self { lines, decoder: Decoder::default(), out: Vec::new() }
    }

    /// Speaks to servos of a protocol from now on.
    pub(super) fn speak(&mut self, protocol: Protocol) {
        if self.decoder.protocol() != protocol {
            self.decoder = Decoder::new(protocol, true);
        }
    }

    /// Sends an instruction: error and data of the answer, none where nothing answers.
    ///
    /// # Errors
    /// Of the operating system.
    pub(super) fn ask(
        &mut self,
        (line, id): (usize, u8),
        instruction: u8,
        parts: &[&[u8]],
    ) -> io::Result<Option<(u8, Vec<u8>)>> {
        self.out.clear();
        self.decoder.protocol().instruct(&mut self.out, id, instruction, parts);
        for _ in 0..TRIES {
            let deadline = self.send(line)?;
            let mut buffer = [0; 256];
            loop {
                while let Some(packet) = self.decoder.next(None) {
                    if packet.instruction == STATUS && packet.id == id {
                        return Ok(Some((packet.error, packet.data.to_vec())));
                    }
                }
                let count = self.lines.receive(line, &mut buffer, deadline)?;
                if count == 0 {
                    break;
                }
                self.decoder.feed(&buffer[..count]);
            }
        }
        Ok(None)
    }

    /// Sends what is to be sent, after leaving out what came before; when answers are waited for no longer.
    pub(super) fn send(&mut self, line: usize) -> io::Result<u64> {
        let (mut buffer, now) = ([0; 256], self.lines.now());
        while self.lines.receive(line, &mut buffer, now)? > 0 {}
        self.decoder.clear();
        self.lines.send(line, &self.out)?;
        Ok(self.lines.now() + PATIENCE)
    }

    /// Model number of a servo; none where none answers.
    pub(super) fn ping(&mut self, line: usize, id: u8) -> io::Result<Option<u16>> {
        let answer = self.ask((line, id), PING, &[])?;
        let answer = match self.decoder.protocol() {
            Protocol::Feetech if answer.is_some() => self.read((line, id), sts::NUMBER, 2)?,
            _ => answer,
        };
        Ok(answer.and_then(|(_, data)| data.first_chunk().map(|number| u16::from_le_bytes(*number))))
    }

    /// Error and octets at an address of a servo.
    pub(super) fn read(
        &mut self,
        to: (usize, u8),
        address: u16,
        octets: u16,
    ) -> io::Result<Option<(u8, Vec<u8>)>> {
        let mut place = Vec::new();
        self.decoder.protocol().places(&mut place, &[address, octets]);
        self.ask(to, READ, &[&place])
    }
}

/// A servo that is being configured.
pub(super) struct Configuring<'a, 'b, L> {
    pub(super) exchange: &'b mut Exchange<'a, L>,
    pub(super) device: &'b ServoDevice,
    pub(super) line: usize,
}

impl<L: Lines> Configuring<'_, '_, L> {
    /// Finds the servo, takes its torque away and sets it up for a machine. Nothing moves.
    pub(super) fn configure(&mut self, machine: &Machine) -> Result<(), ServoError> {
        let Self { device, .. } = *self;
        let series = device.model.series;
        let name = || device.name.clone();
        self.exchange.speak(series.protocol());
        let number = self.exchange.ping(self.line, device.id).map_err(|source| self.port(source))?;
        let number = number.ok_or_else(|| self.device.silent())?;
        if device.model.number.is_some_and(|expected| expected != number) {
            return Err(ServoError::Model {
                device: name(),
                got: number,
                expected: device.model.name.clone(),
            });
        }
        let error = series.errors(self.read(series.places().hardware_error, 1)? as u8);
        if error != 0 {
            return Err(ServoError::Hardware { device: name(), error });
        }
        let drive = &machine.muscles[device.drive.muscle].drive;
        let speed = drive.motor.top_speed / drive.reducer.ratio / device.model.velocity_unit();
        let speed = speed.ceil() as i64;
        if series == Series::Sts {
            self.configure_sts(speed)
        } else {
            self.configure_dynamixel(machine, speed)
        }
    }

    fn configure_dynamixel(&mut self, machine: &Machine, speed: i64) -> Result<(), ServoError> {
        let Self { device, .. } = *self;
        let registers = device.model.series.registers();
        let drive = &machine.muscles[device.drive.muscle].drive;
        // The watchdog holds goals until it is cleared; torque comes with the first command.
        self.write("bus watchdog", registers.bus_watchdog, 1, 0)?;
        self.write("torque enable", registers.torque_enable, 1, 0)?;
        self.set("return delay time", eeprom::RETURN_DELAY, 1, 0)?;
        self.set("operating mode", eeprom::OPERATING_MODE, 1, i64::from(device.mode.number()))?;
        self.set("homing offset", eeprom::HOMING_OFFSET, 4, 0)?;
        self.set("velocity limit", eeprom::VELOCITY_LIMIT, 4, speed)?;
        if device.mode == OperatingMode::Current {
            let current = drive.motor.peak_current / device.model.current_a;
            self.set("current limit", eeprom::CURRENT_LIMIT, 2, current.floor() as i64)?;
        }
        for (k, address) in shown(registers).enumerate() {
            self.set("indirect address", registers.indirect[0] + 2 * k as u16, 2, i64::from(address))?;
        }
        let watchdog = (machine.watchdog() / WATCHDOG_UNIT).ceil();
        self.set("bus watchdog", registers.bus_watchdog, 1, watchdog as i64)
    }

    fn configure_sts(&mut self, speed: i64) -> Result<(), ServoError> {
        self.write("torque enable", sts::TORQUE_ENABLE, 1, 0)?;
        let largest = i64::from(self.device.model.max_velocity);
        if speed > largest {
            let reason = format!("the model's largest speed is {largest} counts/s");
            return Err(self.refused("velocity limit", speed, reason));
        }
        let by_position = self.device.mode == OperatingMode::ExtendedPosition;
        let phase = self.read(sts::PHASE, 1)?;
        if phase as u8 & sts::FINE_SPEED == 0 {
            let reason = "speeds are in units of 50 counts/s: expected bit 2 set".to_owned();
            return Err(self.refused("phase", phase, reason));
        }
        if by_position && phase as u8 & sts::MANY_TURNS == 0 {
            let reason = "positions end within a turn: expected bit 4 set".to_owned();
            return Err(self.refused("phase", phase, reason));
        }
        self.set("lock", sts::LOCK, 1, 0)?;
        self.set("response level", sts::RESPONSE_LEVEL, 1, 1)?;
        self.set("return delay time", sts::RETURN_DELAY, 1, 0)?;
        self.set("operating mode", sts::OPERATING_MODE, 1, i64::from(!by_position))?;
        self.set("acceleration", sts::ACCELERATION, 1, 0)?;
        // Torque would set the winch going: to whatever goal is left, at the largest speed after power-on.
        if by_position {
            self.set("angle limits", sts::ANGLE_LIMITS, 4, 0)?;
            self.set("goal speed", sts::GOAL_SPEED, 2, speed)?;
            let present = self.read(sts::PRESENT, 2)?;
            self.set("goal position", sts::GOAL_POSITION, 2, present)?;
        } else {
            self.set("goal speed", sts::GOAL_SPEED, 2, 0)?;
        }
        self.set("lock", sts::LOCK, 1, 1)
    }

    /// Writes a value where another one stands, and reads it back.
    fn set(
        &mut self,
        register: &'static str,
        address: u16,
        octets: u16,
        value: i64,
    ) -> Result<(), ServoError> {
        if self.read(address, octets)? == value {
            return Ok(());
        }
        self.write(register, address, octets, value)?;
        let got = self.read(address, octets)?;
        if got == value { Ok(()) } else { Err(self.refused(register, value, format!("reads back as {got}"))) }
    }

    fn write(
        &mut self,
        register: &'static str,
        address: u16,
        octets: u16,
        value: i64,
    ) -> Result<(), ServoError> {
        let (data, protocol) = (value.to_le_bytes(), self.device.model.series.protocol());
        let mut place = Vec::new();
        protocol.places(&mut place, &[address]);
        let parts = [&place[..], &data[..usize::from(octets)]];
        let answer = self.exchange.ask((self.line, self.device.id), WRITE, &parts);
        let answer = answer.map_err(|source| self.port(source))?;
        match (protocol, answer) {
            // One that answers only what it is asked: reading back decides.
            (Protocol::Feetech, _) => Ok(()),
            (_, None) => Err(self.device.silent()),
            (_, Some((error, _))) if error & 0x7f == 0 => Ok(()),
            (_, Some((error, _))) => Err(self.refused(register, value, status(error))),
        }
    }

    fn read(&mut self, address: u16, octets: u16) -> Result<i64, ServoError> {
        let answer = self.exchange.read((self.line, self.device.id), address, octets);
        let (error, data) =
            answer.map_err(|source| self.port(source))?.ok_or_else(|| self.device.silent())?;
        if data.len() != usize::from(octets) {
            return Err(self.refused("reading of address", i64::from(address), status(error)));
        }
        let mut number = [0; 8];
        number[..data.len()].copy_from_slice(&data);
        Ok(i64::from_le_bytes(number))
    }

    fn refused(&self, register: &'static str, value: i64, reason: String) -> ServoError {
        ServoError::Refused { device: self.device.name.clone(), register, value, reason }
    }

    fn port(&self, source: io::Error) -> ServoError {
        let port = self.device.port.clone().unwrap_or_else(|| self.device.name.clone());
        ServoError::Port { port, source }
    }
}
