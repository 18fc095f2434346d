//! A moteus controller: registers in frames of CAN FD, position mode with a velocity.
//!
//! Source: mjbots' protocol and register reference (2026-06). What it leaves open is said where it is filled
//! in here.

use super::CanFrame;

const STOPPED: u8 = 0;
const FAULT: u8 = 1;
const ENABLING: u8 = 2;
const POSITION: u8 = 10;
const TIMEOUT: u8 = 11;
/// Time from its first command until it has power, ns; not said in the reference.
const ENABLE_TIME: u64 = 10_000_000;
/// Time without commands after which it times out where none is commanded, s: as from the factory.
const DEFAULT_TIMEOUT: f32 = 0.1;
/// Speed with which it makes up for a position error, 1/s: that of its gains depends on the motor.
const GAIN: f32 = 20.0;
/// Model 0x0204 (r4.11 is of family 0), firmware and register map as the present ones.
const IDENTITY: [i32; 3] = [0x0204, 0x0100, 5];
/// What sensors show that are not simulated: V of the supply, degrees Celsius of the board.
const SUPPLY: f64 = 24.0;
const TEMPERATURE: f64 = 30.0;
/// Codes of a subframe that was refused, and its reason: no such register.
const WRITE_ERROR: u8 = 0x30;
const READ_ERROR: u8 = 0x31;
const UNKNOWN_REGISTER: u8 = 1;
const NOP: u8 = 0x50;
/// Units of numbers in 8, 16 and 32 bits.
const WHOLE: [f64; 3] = [1.0, 1.0, 1.0];
const TURNS: [f64; 3] = [1e-2, 1e-4, 1e-5];
const TURNS_PER_SECOND: [f64; 3] = [0.1, 0.00025, 1e-5];
const NEWTON_METRES: [f64; 3] = [0.5, 0.01, 1e-3];
const SECONDS: [f64; 3] = [0.01, 1e-3, 1e-6];
const VOLTS: [f64; 3] = [0.5, 0.1, 1e-3];
const DEGREES: [f64; 3] = [1.0, 0.1, 1e-3];

/// A moteus controller with its motor.
#[derive(Debug, Clone)]
pub struct Moteus {
    id: u8,
    mode: u8,
    fault: u8,
    /// When it has power, ns.
    enabled_at: u64,
    /// Position, turns, none for the present one, and velocity, turns/s, that were commanded last; when, ns.
    position: Option<f32>,
    velocity: f32,
    fed: u64,
    /// Time without commands after which it times out, s: 0 for that of its configuration, NaN for never.
    timeout: f32,
    /// Whether it times out at all.
    watches: bool,
    /// Position that it shall have, turns; none without power.
    control: Option<f32>,
    /// Position and velocity of the motor, turns and turns/s, and its torque, N m.
    actual: [f32; 2],
    torque: f32,
}

impl Moteus {
    pub(super) fn new(id: u8) -> Self {
        Self {
            id,
            mode: STOPPED,
            fault: 0,
            enabled_at: 0,
            position: None,
            velocity: 0.0,
            fed: 0,
            timeout: 0.0,
            watches: true,
            control: None,
            actual: [0.0; 2],
            torque: 0.0,
        }
    }

    /// The velocity that the motor shall follow, turns/s; none without power. After a time without commands
    /// it is held at 0, with power, as its configuration from the factory has it.
    #[must_use]
    pub fn command(&self) -> Option<f32> {
        match (self.mode, self.control) {
            (POSITION, Some(control)) => {
                let velocity = self.velocity + GAIN * (control - self.actual[0]);
                Some(if velocity.is_finite() { velocity } else { 0.0 })
            }
            (TIMEOUT, _) => Some(0.0),
            _ => None,
        }
    }

    /// Position of the motor, turns, its velocity, turns/s, and its torque, N m, as measured.
    pub fn set_actual(&mut self, position: f32, velocity: f32, torque: f32) {
        (self.actual, self.torque) = ([position, velocity], torque);
    }

    /// Says whether it times out without commands.
    pub fn set_watching(&mut self, watches: bool) {
        self.watches = watches;
    }

    /// It detects a fault of a code, and its motor loses power.
    pub fn raise_fault(&mut self, code: u8) {
        (self.mode, self.fault, self.control) = (FAULT, code, None);
    }

    pub(super) fn has_power(&self) -> bool {
        !matches!(self.mode, STOPPED | FAULT | ENABLING)
    }

    /// Its fault, or the mode in which it is when commands have not come.
    pub(super) fn error(&self) -> u32 {
        u32::from(if self.mode == TIMEOUT { TIMEOUT } else { self.fault })
    }

    pub(super) fn restart(&mut self) {
        let Self { watches, actual, .. } = *self;
        *self = Self { watches, actual, ..Self::new(self.id) };
    }

    pub(super) fn process(&mut self, frame: &CanFrame, now: u64, out: &mut Vec<CanFrame>) {
        let [source, destination] = frame.id().to_be_bytes();
        if frame.is_remote() || destination != self.id {
            return;
        }
        let mut answer = Answer { octets: [NOP; 64], length: 0 };
        let mut rest = frame.octets();
        while let Some(left) = self.subframe(rest, now, &mut answer) {
            rest = left;
        }
        if source & 0x80 != 0 {
            let id = u16::from(self.id) << 8 | u16::from(source & 0x7f);
            out.push(CanFrame::fd(id, &answer.octets[..CanFrame::fd_length(answer.length)]));
        }
    }

    /// Takes one subframe; what follows it, none where that is nothing.
    fn subframe<'a>(&mut self, octets: &'a [u8], now: u64, answer: &mut Answer) -> Option<&'a [u8]> {
        let (code, mut rest) = octets.split_first()?;
        if *code == NOP {
            return Some(rest);
        }
        let (kind, reads) = (usize::from(code >> 2 & 3), code & 0xf0 == 0x10);
        if !reads && code & 0xf0 != 0 {
            return None;
        }
        let mut count = u32::from(code & 3);
        if count == 0 {
            (count, rest) = varuint(rest)?;
        }
        let (start, mut rest) = varuint(rest)?;
        if reads {
            self.read(start, count.min(64), kind, answer);
            return Some(rest);
        }
        for register in start..start.saturating_add(count.min(64)) {
            let (value, left) = rest.split_at_checked([1, 2, 4, 4][kind])?;
            rest = left;
            if !self.write(register, kind, value, now) {
                answer.push(&[WRITE_ERROR]);
                answer.varuint(register);
                answer.push(&[UNKNOWN_REGISTER]);
            }
        }
        Some(rest)
    }

    fn read(&self, start: u32, count: u32, kind: usize, answer: &mut Answer) {
        let registers = start..start.saturating_add(count);
        let unknown = registers.clone().find(|register| self.shown(*register).is_none());
        if let Some(register) = unknown {
            answer.push(&[READ_ERROR]);
            answer.varuint(register);
            return answer.push(&[UNKNOWN_REGISTER]);
        }
        let code = 0x20 | (kind as u8) << 2;
        if count < 4 {
            answer.push(&[code | count as u8]);
        } else {
            answer.push(&[code]);
            answer.varuint(count);
        }
        answer.varuint(start);
        for (value, units) in registers.filter_map(|register| self.shown(register)) {
            let Some(unit) = units.get(kind) else {
                answer.push(&(value as f32).to_le_bytes());
                continue;
            };
            // The lowest number of each width says that there is none.
            let most = [127.0, 32_767.0, 2_147_483_647.0][kind];
            let number = if value.is_nan() { -most - 1.0 } else { (value / unit).clamp(-most, most) };
            answer.push(&(number as i32).to_le_bytes()[..[1, 2, 4][kind]]);
        }
    }

    /// What a register shows, and its units.
    fn shown(&self, register: u32) -> Option<(f64, [f64; 3])> {
        let [position, velocity] = self.actual.map(f64::from);
        Some(match register {
            0x000 => (f64::from(self.mode), WHOLE),
            0x001 => (position, TURNS),
            0x002 => (velocity, TURNS_PER_SECOND),
            0x003 => (f64::from(self.torque), NEWTON_METRES),
            0x00d => (SUPPLY, VOLTS),
            0x00e => (TEMPERATURE, DEGREES),
            0x00f => (f64::from(self.fault), WHOLE),
            0x027 => (f64::from(self.timeout), SECONDS),
            0x100..=0x102 => (f64::from(IDENTITY[register as usize - 0x100]), WHOLE),
            _ => return None,
        })
    }

    /// Whether there is such a register, which takes over the value.
    fn write(&mut self, register: u32, kind: usize, octets: &[u8], now: u64) -> bool {
        let mut wide = [0; 4];
        wide[..octets.len()].copy_from_slice(octets);
        let number = i32::from_le_bytes(wide) << (32 - 8 * octets.len()) >> (32 - 8 * octets.len());
        let value = |units: [f64; 3]| match units.get(kind) {
            None => f32::from_bits(number.cast_unsigned()),
            Some(_) if number == i32::MIN >> (32 - 8 * octets.len()) => f32::NAN,
            Some(unit) => (f64::from(number) * unit) as f32,
        };
        match register {
            0x000 => self.take_mode(value(WHOLE) as u8, now),
            0x020 => self.position = Some(value(TURNS)).filter(|position| !position.is_nan()),
            0x021 => self.velocity = value(TURNS_PER_SECOND),
            0x027 => self.timeout = value(SECONDS),
            // Torques, gains and limits: the motor has its own here.
            0x022..=0x026 | 0x028..=0x02d => {}
            _ => return false,
        }
        true
    }

    /// A mode is commanded: with it the values of all that is not said beside it.
    fn take_mode(&mut self, mode: u8, now: u64) {
        (self.position, self.velocity, self.timeout, self.fed) = (Some(0.0), 0.0, 0.0, now);
        match (mode, self.mode) {
            (STOPPED, _) => (self.mode, self.fault, self.control) = (STOPPED, 0, None),
            (POSITION, STOPPED) => (self.mode, self.enabled_at) = (ENABLING, now + ENABLE_TIME),
            _ => {}
        }
    }

    pub(super) fn advance(&mut self, now: u64, elapsed: u64) {
        if self.mode == ENABLING && now >= self.enabled_at {
            self.mode = POSITION;
        }
        if self.mode == POSITION {
            // A position that is commanded is taken over once; from there on the velocity goes on.
            let from = self.position.take().or(self.control).unwrap_or(self.actual[0]);
            let velocity = if self.velocity.is_finite() { self.velocity } else { 0.0 };
            self.control = Some(from + velocity * (1e-9 * elapsed as f32));
        }
        let timeout = if self.timeout == 0.0 { DEFAULT_TIMEOUT } else { self.timeout };
        let silent = 1e-9 * now.saturating_sub(self.fed) as f32;
        if self.watches && matches!(self.mode, ENABLING | POSITION) && silent > timeout {
            (self.mode, self.control) = (TIMEOUT, None);
        }
    }
}

/// The octets of an answer; what does not fit is left out.
struct Answer {
    octets: [u8; 64],
    length: usize,
}

impl Answer {
    fn push(&mut self, octets: &[u8]) {
        if let Some(place) = self.octets.get_mut(self.length..self.length + octets.len()) {
            place.copy_from_slice(octets);
            self.length += octets.len();
        }
    }

    fn varuint(&mut self, mut number: u32) {
        while number > 0x7f {
            self.push(&[number as u8 & 0x7f | 0x80]);
            number >>= 7;
        }
        self.push(&[number as u8]);
    }
}

/// A number in groups of 7 bits, the lowest first, and what follows it.
fn varuint(octets: &[u8]) -> Option<(u32, &[u8])> {
    let mut number = 0_u32;
    for (k, octet) in octets.iter().take(5).enumerate() {
        number |= u32::from(octet & 0x7f) << (7 * k as u32);
        if octet & 0x80 == 0 {
            return octets.get(k + 1..).map(|rest| (number, rest));
        }
    }
    None
}
