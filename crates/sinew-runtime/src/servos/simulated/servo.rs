//! One simulated servo: its control table, and what it does with it.

use crate::servos::model::Model;
use crate::servos::protocol::{ALERT, MAX_ID};
use crate::servos::registers::{Registers, eeprom, sts};
use crate::servos::series::{Places, Series, WATCHDOG_ERROR, magnitude, signed};

/// Errors of a status.
pub(super) const RESULT_FAIL: u8 = 1;
pub(super) const INSTRUCTION_ERROR: u8 = 2;
const DATA_RANGE: u8 = 4;
pub(super) const DATA_LENGTH: u8 = 5;
const DATA_LIMIT: u8 = 6;
const ACCESS: u8 = 7;

/// Bits of the hardware error status.
pub const OVERLOAD: u8 = 0x20;
/// See [`OVERLOAD`].
pub const OVERHEATING: u8 = 0x04;
/// See [`OVERLOAD`].
pub const ENCODER: u8 = 0x08;

/// Unit of the bus watchdog, ns.
const WATCHDOG_UNIT: u64 = 20_000_000;
/// Octets of the control table.
const TABLE: usize = 1024;
/// Version of the firmware.
const FIRMWARE: u8 = 45;

/// How a simulated servo fails.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ServoFault {
    /// It answers nothing and follows nothing, as with its plug pulled.
    Silent,
    /// Of this many of its answers one is damaged.
    Corrupted(u32),
    /// It answers under this identifier.
    Id(u8),
}

/// What a simulated servo is to do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ServoGoal {
    /// No torque.
    Off,
    /// Speed of the horn, rad/s.
    Velocity(f64),
    /// Position, counts.
    Position(i32),
    /// Current of the motor, A.
    Current(f64),
}

/// A simulated servo.
#[derive(Debug, Clone)]
pub struct SimulatedServo {
    model: Model,
    table: Vec<u8>,
    pub(super) fault: Option<ServoFault>,
    answers: u32,
    /// When it last heard anything, ns.
    heard: u64,
    /// Of the STS series: what its EEPROM keeps, and its position over all turns, counts.
    kept: [u8; STS_EEPROM],
    turned: i32,
}

/// Octets of the EEPROM of the STS series.
const STS_EEPROM: usize = sts::TORQUE_ENABLE as usize;

impl SimulatedServo {
    /// As it comes from the factory, with this identifier and rate of the line.
    #[must_use]
    pub fn new(model: Model, id: u8, baud: u8) -> Self {
        let (table, kept) = (vec![0; TABLE], [0; STS_EEPROM]);
        let mut servo = Self { model, table, fault: None, answers: 0, heard: 0, kept, turned: 0 };
        if servo.model.series == Series::Sts {
            let [low, high] = servo.model.number.unwrap_or(777).to_le_bytes();
            servo.set(0, &[3, 10, 0, low, high, id, baud, 250, 1, 0, 0, 0xff, 0x0f, 70, 140, 40]);
            servo.set(16, &[0xe8, 0x03, 0x08 | sts::FINE_SPEED | sts::MANY_TURNS]);
            servo.keep();
            servo.start();
            return servo;
        }
        servo.set(0, &servo.model.number.unwrap_or(1020).to_le_bytes());
        servo.set(6, &[FIRMWARE, id, baud, 250, 0, 3, 255, 2]);
        servo.set(eeprom::TEMPERATURE_LIMIT, &[80, 160, 0, 95, 0]);
        servo.set(36, &885_u16.to_le_bytes());
        servo.set(eeprom::CURRENT_LIMIT, &1193_u16.to_le_bytes());
        servo.set(eeprom::VELOCITY_LIMIT, &200_u32.to_le_bytes());
        servo.set(48, &4095_u32.to_le_bytes());
        servo.start();
        servo
    }

    /// Keeps the EEPROM of the STS series.
    fn keep(&mut self) {
        self.kept.copy_from_slice(&self.table[..STS_EEPROM]);
    }

    /// Fills the part of the table that is lost without power.
    fn start(&mut self) {
        if self.model.series == Series::Sts {
            self.table[..STS_EEPROM].copy_from_slice(&self.kept);
            self.table[STS_EEPROM..].fill(0);
            let fastest = magnitude(i32::try_from(self.model.max_velocity).unwrap_or(i32::MAX));
            self.set(sts::GOAL_SPEED, &fastest);
            self.set(sts::LOCK, &[1]);
            self.set(sts::PRESENT + 6, &[120, 35]);
            return;
        }
        let Registers { torque_enable, voltage, indirect, .. } = self.model.series.registers();
        self.table[usize::from(torque_enable)..].fill(0);
        // Status return level: everything is answered.
        self.set(torque_enable + 4, &[2]);
        self.set(voltage, &[120, 0, 35]);
        for k in 0..self.indirect_octets() {
            self.set(indirect[0] + 2 * k, &(indirect[1] + k).to_le_bytes());
        }
    }

    /// Octets that can be shown elsewhere.
    fn indirect_octets(&self) -> u16 {
        let [address, data] = self.model.series.registers().indirect;
        ((data - address) / 2).min(28)
    }

    /// Starts anew, as when its power was gone for a moment: no torque, the position within a turn.
    pub fn reset(&mut self) {
        let position = self.position().rem_euclid(self.model.counts as i32);
        self.start();
        self.show_position(position);
    }

    fn show_position(&mut self, position: i32) {
        match self.model.series {
            Series::X | Series::P => {
                self.set(self.model.series.registers().present + 6, &position.to_le_bytes());
            }
            Series::Sts => {
                let many = self.octet(sts::PHASE) & sts::MANY_TURNS != 0;
                let shown = if many {
                    i32::from(position as i16)
                } else {
                    position.rem_euclid(self.model.counts as i32)
                };
                self.turned = position;
                self.set(sts::PRESENT, &magnitude(shown));
            }
        }
    }

    /// Lets it fail, or ends that.
    pub fn set_fault(&mut self, fault: Option<ServoFault>) {
        self.fault = fault;
    }

    /// Reports a hardware error and takes its torque away, until it is started anew.
    pub fn raise(&mut self, error: u8) {
        let Places { torque_enable, hardware_error, .. } = self.model.series.places();
        let raised = self.octet(hardware_error) | self.model.series.status(error);
        self.set(hardware_error, &[raised]);
        self.set(torque_enable, &[0]);
    }

    /// Identifier that it listens to.
    #[must_use]
    pub fn id(&self) -> u8 {
        self.octet(self.model.series.places().id)
    }

    /// Rate of its line, by its number in the control table.
    #[must_use]
    pub fn baud(&self) -> u8 {
        self.octet(self.model.series.places().baud)
    }

    /// Identifier that it answers with.
    pub(super) fn answers_as(&self) -> u8 {
        if let Some(ServoFault::Id(id)) = self.fault { id } else { self.id() }
    }

    /// Time until it answers, ns.
    pub(super) fn return_delay(&self) -> u64 {
        2000 * u64::from(self.octet(self.model.series.places().return_delay))
    }

    /// Whether the motor has torque.
    #[must_use]
    pub fn has_torque(&self) -> bool {
        self.octet(self.model.series.places().torque_enable) == 1
    }

    /// Present position, counts.
    #[must_use]
    pub fn position(&self) -> i32 {
        match self.model.series {
            Series::X | Series::P => self.number(self.model.series.registers().present + 6),
            Series::Sts => self.turned,
        }
    }

    /// Its model.
    #[must_use]
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// What it is to do.
    #[must_use]
    pub fn goal(&self) -> ServoGoal {
        let Registers { bus_watchdog, goal_current, goal_position, .. } = self.model.series.registers();
        if !self.has_torque() || self.fault == Some(ServoFault::Silent) {
            return ServoGoal::Off;
        }
        if self.model.series == Series::Sts {
            let goal = |place| signed([self.octet(place), self.octet(place + 1)]);
            return match self.octet(sts::OPERATING_MODE) {
                1 => ServoGoal::Velocity(f64::from(goal(sts::GOAL_SPEED)) * self.model.velocity_unit()),
                _ => ServoGoal::Position(goal(sts::GOAL_POSITION)),
            };
        }
        if self.octet(bus_watchdog) == WATCHDOG_ERROR {
            return ServoGoal::Velocity(0.0);
        }
        match self.octet(eeprom::OPERATING_MODE) {
            0 => {
                let [low, high] = [self.octet(goal_current), self.octet(goal_current + 1)];
                ServoGoal::Current(f64::from(i16::from_le_bytes([low, high])) * self.model.current_a)
            }
            1 => {
                let velocity = f64::from(self.number(self.model.series.registers().goal_velocity()));
                ServoGoal::Velocity(velocity * self.model.velocity_unit())
            }
            _ => ServoGoal::Position(self.number(goal_position)),
        }
    }

    /// Shows what it measures: current, A, speed of the horn, rad/s, position, counts, temperature, degC.
    pub fn show(&mut self, current: f64, speed: f64, position: i32, temperature: f64) {
        let Registers { present, .. } = self.model.series.registers();
        let unit = self.model.current_a;
        let current = if unit > 0.0 { (current / unit).round() as i16 } else { 0 };
        let velocity = (speed / self.model.velocity_unit()).round() as i32;
        if self.model.series == Series::Sts {
            self.show_position(position);
            self.set(sts::PRESENT + 2, &magnitude(velocity));
            self.set(sts::PRESENT + 7, &[temperature.clamp(0.0, 255.0) as u8]);
            self.set(sts::CURRENT, &magnitude(i32::from(current)));
            return;
        }
        self.set(present, &current.to_le_bytes());
        self.set(present + 2, &velocity.to_le_bytes());
        self.set(present + 6, &position.to_le_bytes());
        self.set(self.model.series.registers().temperature(), &[temperature.clamp(0.0, 255.0) as u8]);
    }

    /// Whether it takes part in what comes at this time, ns, over a line of this rate.
    pub(super) fn hears(&mut self, now: u64, baud: Option<u32>) -> bool {
        let own = self.model.series.baud().get(usize::from(self.baud())).copied();
        let hears = self.fault != Some(ServoFault::Silent) && (baud.is_none() || baud == own);
        if hears {
            self.heard = now;
        }
        hears
    }

    /// Time passes: the bus watchdog stops a servo that hears nothing.
    pub(super) fn watch(&mut self, now: u64) {
        if self.model.series == Series::Sts {
            return;
        }
        let address = self.model.series.registers().bus_watchdog;
        let units = self.octet(address);
        let counts = self.has_torque() && (1..=127).contains(&units);
        if counts && now.saturating_sub(self.heard) > u64::from(units) * WATCHDOG_UNIT {
            self.set(address, &[WATCHDOG_ERROR]);
        }
    }

    /// Whether the next answer is damaged.
    pub(super) fn damages(&mut self) -> bool {
        self.answers = self.answers.wrapping_add(1);
        matches!(self.fault, Some(ServoFault::Corrupted(of)) if self.answers.is_multiple_of(of.max(1)))
    }

    /// Error of a status: its number, and whether there is a hardware error; of the STS series all of those.
    pub(super) fn error(&self, number: u8) -> u8 {
        if self.model.series == Series::Sts {
            return self.octet(sts::STATUS);
        }
        let alert = self.octet(self.model.series.places().hardware_error) != 0;
        number | if alert { ALERT } else { 0 }
    }

    /// Appends the octets at an address; the number of the error that it answers with.
    pub(super) fn read(&self, address: u16, length: u16, out: &mut Vec<u8>) -> u8 {
        if usize::from(address) + usize::from(length) > TABLE {
            return DATA_RANGE;
        }
        if self.model.series == Series::Sts {
            out.extend((address..address + length).map(|address| self.octet(address)));
            return 0;
        }
        let [from, shown] = self.model.series.registers().indirect;
        out.extend((address..address + length).map(|address| {
            let place = address.checked_sub(shown).filter(|place| *place < self.indirect_octets());
            let address = place.map_or(address, |place| {
                u16::from_le_bytes([self.octet(from + 2 * place), self.octet(from + 2 * place + 1)])
            });
            self.octet(address)
        }));
        0
    }

    /// Writes octets at an address; the number of the error that it answers with.
    pub(super) fn write(&mut self, address: u16, octets: &[u8]) -> u8 {
        if self.model.series == Series::Sts {
            // What cannot be written is left as it is, without a word.
            let end = address + octets.len() as u16;
            if address >= sts::ID && (end <= sts::PRESENT || address > sts::CURRENT + 1) {
                self.set(address, octets);
            }
            if self.octet(sts::LOCK) == 0 {
                self.keep();
            }
            return 0;
        }
        let Registers { torque_enable, bus_watchdog, goal_current, present, voltage, indirect, .. } =
            self.model.series.registers();
        let end = usize::from(address) + octets.len();
        if end > TABLE || octets.is_empty() {
            return DATA_RANGE;
        }
        let is_indirect = address >= indirect[0] && address < indirect[1];
        let read_only = address < eeprom::ID || (present..=voltage + 2).contains(&address);
        let locked = address < torque_enable && !is_indirect && self.has_torque();
        if read_only || locked {
            return ACCESS;
        }
        let stopped = self.octet(bus_watchdog) == WATCHDOG_ERROR;
        if stopped && (goal_current - 2..present - 10).contains(&address) {
            return DATA_RANGE;
        }
        let number = octets.first_chunk().map_or(0, |octets| i32::from_le_bytes(*octets));
        let largest = self.number(eeprom::VELOCITY_LIMIT).unsigned_abs();
        let refused = match (address, octets) {
            (eeprom::ID, [id, ..]) => (*id > MAX_ID).then_some(DATA_RANGE),
            (eeprom::BAUD, [baud, ..]) => (*baud > 7).then_some(DATA_RANGE),
            (eeprom::RETURN_DELAY, [delay, ..]) => (*delay > 254).then_some(DATA_RANGE),
            (eeprom::OPERATING_MODE, [mode, ..]) => {
                let known = [0, 1, 3, 4, 5, 16].contains(mode) && (*mode != 0 || self.model.current_a > 0.0);
                (!known).then_some(DATA_RANGE)
            }
            (eeprom::VELOCITY_LIMIT, [_, _, _, _, ..]) => {
                (number.cast_unsigned() > self.model.max_velocity).then_some(DATA_RANGE)
            }
            (at, [_, _, _, _, ..]) if at == self.model.series.registers().goal_velocity() => {
                (number.unsigned_abs() > largest).then_some(DATA_LIMIT)
            }
            (at, [on, ..]) if at == torque_enable => {
                let failed = *on == 1 && self.octet(self.model.series.registers().hardware_error) != 0;
                if *on > 1 { Some(DATA_RANGE) } else { failed.then_some(RESULT_FAIL) }
            }
            _ => None,
        };
        if let Some(error) = refused {
            return error;
        }
        self.set(address, octets);
        if address == torque_enable || address == eeprom::OPERATING_MODE {
            // The goals begin where the servo stands.
            let position = self.position();
            self.set(goal_current, &[0; 6]);
            self.set(self.model.series.registers().goal_position, &position.to_le_bytes());
        }
        0
    }

    fn octet(&self, address: u16) -> u8 {
        self.table.get(usize::from(address)).copied().unwrap_or(0)
    }

    fn number(&self, address: u16) -> i32 {
        let from = usize::from(address);
        self.table.get(from..).and_then(|octets| octets.first_chunk()).map_or(0, |x| i32::from_le_bytes(*x))
    }

    fn set(&mut self, address: u16, octets: &[u8]) {
        let from = usize::from(address);
        if let Some(place) = self.table.get_mut(from..from + octets.len()) {
            place.copy_from_slice(octets);
        }
    }
}
