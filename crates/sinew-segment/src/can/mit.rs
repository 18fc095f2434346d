//! A motor in MIT mode: position, velocity, stiffness, damping and torque in one frame, readings in the
//! answer, which comes at once.
//!
//! ```text
//! torque = kp (p* - p) + kd (v* - v) + t*
//! ```
//!
//! Source: the firmware of the MIT mini cheetah's motors (bgkatz/motorcontrol); CubeMars' manual of the AK
//! series, 1.0.8; DAMIAO's registers, as its Python packages have them. What they leave open is said where it
//! is filled in here.

use super::CanFrame;
use super::mit_frame::{MitCommand, MitFamily, MitRanges, MitReadings};

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
