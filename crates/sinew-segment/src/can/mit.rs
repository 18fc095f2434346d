//! A motor in MIT mode: position, velocity, stiffness, damping and torque in one frame, readings in the
//! answer.
//!
//! ```text
//! command: position 16, velocity 12, stiffness 12, damping 12, torque 12 bits    answered at once
//! torque = kp (p* - p) + kd (v* - v) + t*
//! ```
//!
//! Source: the firmware of the MIT mini cheetah's motors (bgkatz/motorcontrol); CubeMars' manual of the AK
//! series, 1.0.15; DAMIAO's manual. What they leave open is said where it is filled in here.

use super::CanFrame;

/// Whose firmware a motor in MIT mode has: it decides what is answered, and under which identifier.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MitFamily {
    /// MIT mini cheetah: 6 octets, without a state, to the master with identifier 0.
    MiniCheetah,
    /// CubeMars AK: 8 octets with temperature and error, under the motor's own identifier.
    Cubemars,
    /// DAMIAO: 8 octets with the state beside the identifier, to a master of its own; registers.
    Damiao,
}

/// Ranges of the numbers in the frames of a motor in MIT mode, all at the shaft that it shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MitRanges {
    /// Whose firmware it has.
    pub family: MitFamily,
    /// Position from minus this to this, rad.
    pub position: f64,
    /// The same of the velocity, rad/s.
    pub velocity: f64,
    /// The same of the torque, N m.
    pub torque: f64,
    /// Stiffness from 0 to this, N m/rad.
    pub stiffness: f64,
    /// Damping from 0 to this, N m s/rad.
    pub damping: f64,
    /// Where the answer carries a current in place of a torque, that from minus this to this, A.
    pub current: Option<f64>,
}

/// What a motor is told.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MitCommand {
    /// Position, rad.
    pub position: f64,
    /// Velocity, rad/s.
    pub velocity: f64,
    /// Torque per position error, N m/rad.
    pub stiffness: f64,
    /// Torque per velocity error, N m s/rad.
    pub damping: f64,
    /// Torque beside, N m.
    pub torque: f64,
}

/// What the octets of an answer carry beside identifier, state and temperatures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MitReadings {
    /// Position, rad.
    pub position: f64,
    /// Velocity, rad/s.
    pub velocity: f64,
    /// Torque, N m, or current, A.
    pub torque: f64,
}

/// The number of so many bits for a value between two ends, which is rounded and held between them.
fn coded(value: f64, [low, high]: [f64; 2], bits: u32) -> u64 {
    let most = f64::from((1_u32 << bits) - 1);
    ((value - low) / (high - low) * most).round().max(0.0).min(most) as u64
}

fn decoded(number: u64, [low, high]: [f64; 2], bits: u32) -> f64 {
    low + number as f64 * (high - low) / f64::from((1_u32 << bits) - 1)
}

impl MitRanges {
    /// The octets of a command.
    #[must_use]
    pub fn command(&self, command: &MitCommand) -> [u8; 8] {
        let MitCommand { position, velocity, stiffness, damping, torque } = *command;
        let word = coded(position, [-self.position, self.position], 16) << 48
            | coded(velocity, [-self.velocity, self.velocity], 12) << 36
            | coded(stiffness, [0.0, self.stiffness], 12) << 24
            | coded(damping, [0.0, self.damping], 12) << 12
            | coded(torque, [-self.torque, self.torque], 12);
        word.to_be_bytes()
    }

    /// What the octets of a command say.
    #[must_use]
    pub fn commanded(&self, octets: [u8; 8]) -> MitCommand {
        let word = u64::from_be_bytes(octets);
        let number = |shift: u32| word >> shift & 0xfff;
        MitCommand {
            position: decoded(word >> 48, [-self.position, self.position], 16),
            velocity: decoded(number(36), [-self.velocity, self.velocity], 12),
            stiffness: decoded(number(24), [0.0, self.stiffness], 12),
            damping: decoded(number(12), [0.0, self.damping], 12),
            torque: decoded(number(0), [-self.torque, self.torque], 12),
        }
    }

    /// The five octets of an answer that carry readings. A position beyond its range wraps round, as the
    /// firmware of the mini cheetah lets it.
    #[must_use]
    pub fn answer(&self, readings: &MitReadings) -> [u8; 5] {
        let turn = 2.0 * self.position * 65_536.0 / 65_535.0;
        let position = (readings.position + self.position).rem_euclid(turn) - self.position;
        let word = coded(position, [-self.position, self.position], 16) << 24
            | coded(readings.velocity, [-self.velocity, self.velocity], 12) << 12
            | coded(readings.torque, self.shown(), 12);
        let [_, _, _, octets @ ..] = word.to_be_bytes();
        octets
    }

    /// What the five octets of an answer say.
    #[must_use]
    pub fn readings(&self, octets: [u8; 5]) -> MitReadings {
        let [a, b, c, d, e] = octets;
        let word = u64::from_be_bytes([0, 0, 0, a, b, c, d, e]);
        MitReadings {
            position: decoded(word >> 24, [-self.position, self.position], 16),
            velocity: decoded(word >> 12 & 0xfff, [-self.velocity, self.velocity], 12),
            torque: decoded(word & 0xfff, self.shown(), 12),
        }
    }

    fn shown(&self) -> [f64; 2] {
        let most = self.current.unwrap_or(self.torque);
        [-most, most]
    }
}

/// The last octet of frames of seven times 0xff: the motor follows commands, or loses its power; faults of a
/// DAMIAO are cleared.
const ENTER: u8 = 0xfc;
const LEAVE: u8 = 0xfd;
const CLEAR: u8 = 0xfb;
/// Error of a DAMIAO: no command within its own time.
const LOST: u8 = 13;
/// Registers of a DAMIAO: identifiers of its answers and of itself, time without commands in 50 us, mode,
/// ranges.
const MASTER: u8 = 7;
const OWN: u8 = 8;
const TIMEOUT: u8 = 9;
const MODE: u8 = 10;
const RANGES: [u8; 3] = [21, 22, 23];
/// What sensors show that are not simulated, degrees Celsius.
const TEMPERATURE: u8 = 30;

/// A motor in MIT mode.
#[derive(Debug, Clone)]
pub struct Mit {
    id: u8,
    ranges: MitRanges,
    on: bool,
    /// As a CubeMars or a DAMIAO shows it, 0 for none.
    error: u8,
    command: MitCommand,
    /// When a frame came last, ns, and the time without one after which a DAMIAO loses its power, 50 us.
    fed: u64,
    timeout: u32,
    mode: u32,
    leaves: bool,
    readings: MitReadings,
}

impl Mit {
    pub(super) fn new(id: u8, ranges: MitRanges) -> Self {
        Self {
            id,
            ranges,
            on: false,
            error: 0,
            command: MitCommand::default(),
            fed: 0,
            timeout: 0,
            mode: 1,
            leaves: true,
            readings: MitReadings { position: 0.0, velocity: 0.0, torque: 0.0 },
        }
    }

    /// The torque of its shaft by its last command, N m, as its firmware computes it many times in a control
    /// period; none without power.
    #[must_use]
    pub fn torque(&self, position: f64, velocity: f64) -> Option<f64> {
        let MitCommand { position: p, velocity: v, stiffness, damping, torque } = self.command;
        let torque = stiffness * (p - position) + damping * (v - velocity) + torque;
        let most = self.ranges.torque;
        self.has_power().then_some(if torque.is_finite() { torque.clamp(-most, most) } else { 0.0 })
    }

    /// What it was told last.
    #[must_use]
    pub fn command(&self) -> MitCommand {
        self.command
    }

    /// Whose firmware it has.
    #[must_use]
    pub fn family(&self) -> MitFamily {
        self.ranges.family
    }

    /// Whether its answers carry a current in place of a torque.
    #[must_use]
    pub fn shows_current(&self) -> bool {
        self.ranges.current.is_some()
    }

    /// What it measures, at its shaft.
    pub fn set_actual(&mut self, readings: MitReadings) {
        self.readings = readings;
    }

    /// Says whether it loses its power when it is told to leave, and, of a DAMIAO, its mode, 1 for MIT, and
    /// ranges.
    pub fn configure(&mut self, leaves: bool, mode: u32, ranges: MitRanges) {
        (self.leaves, self.mode, self.ranges) = (leaves, mode, ranges);
    }

    /// It detects an error, and loses its power.
    pub fn raise_fault(&mut self, error: u8) {
        (self.on, self.error) = (false, error);
    }

    pub(super) fn has_power(&self) -> bool {
        self.on
    }

    /// Its error, 0 for none.
    pub(super) fn error(&self) -> u32 {
        u32::from(self.error)
    }

    pub(super) fn restart(&mut self) {
        let Self { id, ranges, mode, readings, .. } = *self;
        *self = Self { mode, readings, ..Self::new(id, ranges) };
    }

    pub(super) fn process(&mut self, frame: &CanFrame, now: u64, out: &mut Vec<CanFrame>) {
        let Some(octets) = frame.octets().first_chunk::<8>().filter(|_| !frame.is_fd()) else { return };
        if self.ranges.family == MitFamily::Damiao && frame.id() == 0x7ff {
            return self.register(*octets, out);
        }
        if frame.id() != u16::from(self.id) {
            return;
        }
        self.fed = now;
        match octets {
            [0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, last] => match *last {
                // What it is told before it has power counts from then on.
                ENTER if self.error == 0 => self.on = true,
                LEAVE if self.leaves => {
                    self.on = false;
                    // How a CubeMars is told that its error is known is not said: here so.
                    self.error = if self.ranges.family == MitFamily::Damiao { self.error } else { 0 };
                }
                CLEAR if self.ranges.family == MitFamily::Damiao => self.error = 0,
                _ => {}
            },
            _ => self.command = self.ranges.commanded(*octets),
        }
        out.push(self.answer());
    }

    fn answer(&self) -> CanFrame {
        let [a, b, c, d, e] = self.ranges.answer(&self.readings);
        match self.ranges.family {
            MitFamily::MiniCheetah => CanFrame::new(0, &[self.id, a, b, c, d, e]),
            MitFamily::Cubemars => {
                CanFrame::new(u16::from(self.id), &[self.id, a, b, c, d, e, TEMPERATURE, self.error])
            }
            MitFamily::Damiao => {
                let state = self.error.max(u8::from(self.on));
                let octets = [self.id & 15 | state << 4, a, b, c, d, e, TEMPERATURE, TEMPERATURE];
                CanFrame::new(self.master(), &octets)
            }
        }
    }

    /// The identifier of a DAMIAO's answers: the usual one.
    fn master(&self) -> u16 {
        0x10 + u16::from(self.id)
    }

    /// Reads or writes a register of a DAMIAO: identifier, 0x33 or 0x55, number, value.
    fn register(&mut self, octets: [u8; 8], out: &mut Vec<CanFrame>) {
        let [low, high, kind, number, value @ ..] = octets;
        if [low, high] != [self.id, 0] || !matches!(kind, 0x33 | 0x55) {
            return;
        }
        if kind == 0x55 && number == TIMEOUT {
            self.timeout = u32::from_le_bytes(value);
        }
        let MitRanges { position, velocity, torque, .. } = self.ranges;
        let value = match number {
            MASTER => u32::from(self.master()),
            OWN => u32::from(self.id),
            TIMEOUT => self.timeout,
            MODE => self.mode,
            _ => match RANGES.iter().zip([position, velocity, torque]).find(|(of, _)| **of == number) {
                Some((_, range)) => (range as f32).to_bits(),
                None => return,
            },
        };
        let [a, b, c, d] = value.to_le_bytes();
        out.push(CanFrame::new(self.master(), &[low, high, kind, number, a, b, c, d]));
    }

    pub(super) fn advance(&mut self, now: u64) {
        let silent = now.saturating_sub(self.fed) / 50_000;
        if self.has_power() && self.timeout > 0 && silent > u64::from(self.timeout) {
            self.raise_fault(LOST);
        }
    }
}
