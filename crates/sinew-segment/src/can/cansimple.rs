//! A drive on CANSimple, the protocol of ODrive's firmware 0.6: an axis in velocity mode.
//!
//! Source: its messages as in the DBC file of ODrive 0.6.10. Which of them feed the watchdog is not said
//! there: here those with data do.

use super::CanFrame;

const IDLE: u8 = 1;
const CLOSED_LOOP: u8 = 8;
/// Control mode and input mode: velocity, as it comes.
const VELOCITY: [u32; 2] = [2, 1];
/// Bit of the axis' errors: the watchdog has expired.
const WATCHDOG_EXPIRED: u32 = 1 << 24;
const ESTOP_REQUESTED: u32 = 1 << 25;
/// Time between two heartbeats, ns; from the factory it is 0.1 s.
const HEARTBEAT: u64 = 20_000_000;
/// Protocol 2, hardware 4.4.58, firmware 0.6.10, released.
const VERSION: [u8; 8] = [2, 4, 4, 58, 0, 6, 10, 0];
/// Parameters by their names, with the number and the type that they have here; every firmware has others.
const ENDPOINTS: [(&str, u16, &str); 7] = [
    ("axis0.config.can.heartbeat_msg_rate_ms", 0x101, "uint32"),
    ("axis0.config.watchdog_timeout", 0x102, "float"),
    ("axis0.config.enable_watchdog", 0x103, "bool"),
    ("axis0.controller.config.control_mode", 0x104, "uint8"),
    ("axis0.controller.config.input_mode", 0x105, "uint8"),
    ("axis0.controller.config.vel_limit", 0x106, "float"),
    ("axis0.config.motor.current_soft_max", 0x107, "float"),
];
/// What sensors show that are not simulated: degrees Celsius of amplifier and motor, V and A of the supply.
const TEMPERATURES: [f32; 2] = [30.0, 30.0];
const SUPPLY: [f32; 2] = [24.0, 0.0];

/// An axis on CANSimple.
#[derive(Debug, Clone)]
pub struct Cansimple {
    id: u8,
    watchdog: u64,
    watches: bool,
    heartbeat: u64,
    state: u8,
    /// Latched until they are cleared.
    errors: u32,
    modes: [u32; 2],
    /// Velocity, turns/s, and current, A.
    limits: [f32; 2],
    /// Velocity that was commanded last, turns/s, and when, ns.
    input: f32,
    fed: u64,
    /// Position and velocity of the motor, turns and turns/s; current, A.
    actual: [f32; 2],
    current: f32,
    next_heartbeat: u64,
}

impl Cansimple {
    pub(super) fn new(id: u8, watchdog: u64) -> Self {
        Self {
            id,
            watchdog,
            watches: watchdog > 0,
            heartbeat: HEARTBEAT,
            state: IDLE,
            errors: 0,
            modes: [3, 1],
            limits: [10.0; 2],
            input: 0.0,
            fed: 0,
            actual: [0.0; 2],
            current: 0.0,
            next_heartbeat: 0,
        }
    }

    /// The velocity that the motor shall follow, turns/s; none without power.
    #[must_use]
    pub fn command(&self) -> Option<f32> {
        let limit = self.limits[0].max(0.0);
        let velocity = if self.modes == VELOCITY { self.input.max(-limit).min(limit) } else { 0.0 };
        self.is_armed().then_some(if velocity.is_finite() { velocity } else { 0.0 })
    }

    /// Position of the motor, turns, its velocity, turns/s, and its current, A, as measured.
    pub fn set_actual(&mut self, position: f32, velocity: f32, current: f32) {
        (self.actual, self.current) = ([position, velocity], current);
    }

    /// Sets the time without commands after which it loses its power, ns, 0 for never, and that between two
    /// heartbeats, ns.
    pub fn configure(&mut self, watchdog: u64, heartbeat: u64) {
        (self.watchdog, self.watches, self.heartbeat) = (watchdog, watchdog > 0, heartbeat);
    }

    /// Its parameters: name, number, type.
    #[must_use]
    pub fn endpoints() -> [(&'static str, u16, &'static str); 7] {
        ENDPOINTS
    }

    /// The axis detects errors, by their bits, and its motor loses power.
    pub fn raise_fault(&mut self, bits: u32) {
        self.errors |= bits;
        self.state = IDLE;
    }

    pub(super) fn is_armed(&self) -> bool {
        self.state == CLOSED_LOOP
    }

    pub(super) fn errors(&self) -> u32 {
        self.errors
    }

    pub(super) fn restart(&mut self) {
        let Self { watches, heartbeat, actual, next_heartbeat, .. } = *self;
        *self = Self { watches, heartbeat, actual, next_heartbeat, ..Self::new(self.id, self.watchdog) };
    }

    pub(super) fn process(&mut self, frame: &CanFrame, now: u64, out: &mut Vec<CanFrame>) {
        if frame.id() >> 5 != u16::from(self.id) {
            return;
        }
        let command = frame.id() & 0x1f;
        if frame.is_remote() {
            if let Some(octets) = self.shown(command) {
                out.push(CanFrame::new(frame.id(), &octets));
            }
            return;
        }
        self.fed = now;
        let words: [u32; 2] = core::array::from_fn(|k| {
            let octets = frame.octets().get(4 * k..).and_then(|octets| octets.first_chunk());
            octets.map_or(0, |octets| u32::from_le_bytes(*octets))
        });
        let enough = |octets| frame.octets().len() >= octets;
        match command {
            0x02 => self.raise_fault(ESTOP_REQUESTED),
            0x04 if enough(4) => self.parameter(frame.octets(), out),
            0x07 if enough(4) => match words[0] as u8 {
                CLOSED_LOOP if self.errors == 0 => self.state = CLOSED_LOOP,
                IDLE => self.state = IDLE,
                _ => {}
            },
            0x0b if enough(8) => self.modes = words,
            0x0d if enough(4) => self.input = f32::from_bits(words[0]),
            0x0f if enough(8) => self.limits = words.map(f32::from_bits),
            0x16 if enough(1) && words[0] as u8 == 0 => self.restart(),
            0x18 => self.errors = 0,
            _ => {}
        }
    }

    /// Reads or writes a parameter: whether it is written, its number, its value from the fifth octet on.
    fn parameter(&mut self, octets: &[u8], out: &mut Vec<CanFrame>) {
        let [operation, low, high, _, value @ ..] = octets else { return };
        let number = u16::from_le_bytes([*low, *high]);
        let mut word = [0; 4];
        word.iter_mut().zip(value).for_each(|(octet, given)| *octet = *given);
        let (word, length) = (u32::from_le_bytes(word), if matches!(number, 0x103..=0x105) { 1 } else { 4 });
        if *operation == 1 && value.len() >= length {
            match number {
                0x101 => self.heartbeat = u64::from(word) * 1_000_000,
                0x102 => self.watchdog = (1e9 * f32::from_bits(word)) as u64,
                0x103 => self.watches = word & 0xff != 0,
                0x104 | 0x105 => self.modes[usize::from(number - 0x104)] = word & 0xff,
                0x106 | 0x107 => self.limits[usize::from(number - 0x106)] = f32::from_bits(word),
                _ => {}
            }
        }
        let word = match number {
            _ if *operation != 0 => return,
            0x101 => (self.heartbeat / 1_000_000) as u32,
            0x102 => (1e-9 * self.watchdog as f32).to_bits(),
            0x103 => u32::from(self.watches),
            0x104 | 0x105 => self.modes[usize::from(number - 0x104)],
            0x106 | 0x107 => self.limits[usize::from(number - 0x106)].to_bits(),
            _ => return,
        };
        let mut answer = [0, *low, *high, 0, 0, 0, 0, 0];
        answer[4..].copy_from_slice(&word.to_le_bytes());
        out.push(CanFrame::new(u16::from(self.id) << 5 | 5, &answer[..4 + length]));
    }

    /// What a message carries that is asked for.
    fn shown(&self, command: u16) -> Option<[u8; 8]> {
        let floats = |[first, second]: [f32; 2]| both(first.to_bits(), second.to_bits());
        Some(match command {
            0x00 => VERSION,
            0x03 => both(self.errors, self.errors),
            0x09 => floats(self.actual),
            0x14 => floats([self.current; 2]),
            0x15 => floats(TEMPERATURES),
            0x17 => floats(SUPPLY),
            _ => return None,
        })
    }

    pub(super) fn advance(&mut self, now: u64, beats: bool, out: &mut Vec<CanFrame>) {
        if self.is_armed() && self.watches && now.saturating_sub(self.fed) > self.watchdog {
            self.raise_fault(WATCHDOG_EXPIRED);
        }
        if now >= self.next_heartbeat {
            self.next_heartbeat = now + self.heartbeat;
            if beats {
                let octets = both(self.errors, u32::from(self.state));
                out.push(CanFrame::new(u16::from(self.id) << 5 | 1, &octets));
            }
        }
    }
}

fn both(first: u32, second: u32) -> [u8; 8] {
    (u64::from(second) << 32 | u64::from(first)).to_le_bytes()
}
