//! moteus: registers in frames of CAN FD; position mode that follows a velocity.
//!
//! ```text
//! identifier = reply << 15 | source << 8 | destination    1 Mbit/s, octets at 5 Mbit/s, little-endian
//! octets     = subframes: code | kind << 2 | count, first register, values    50 fills the rest
//! ```
//!
//! Source: mjbots' protocol and register reference (2026-06).

mod bring_up;
mod slot;

pub(super) use bring_up::start;

use sinew_segment::CanFrame as Frame;

/// Modes.
const STOPPED: u8 = 0;
const FAULT: u8 = 1;
const POSITION: u8 = 10;
const TIMEOUT: u8 = 11;
/// The version of the registers that is known.
const REGISTER_MAP: i32 = 5;
/// The largest identifier of a controller; 127 is all.
pub(super) const MAX_NODE: u8 = 126;

/// Subframes.
const WRITE: u8 = 0x00;
const READ: u8 = 0x10;
const REPLY: u8 = 0x20;
const NOP: u8 = 0x50;
/// Kinds of numbers.
const INT8: u8 = 0;
const INT32: u8 = 2;
const FLOAT: u8 = 3;
/// First registers of what is written and read.
const MODE: u32 = 0x000;
const MEASURED: u32 = 0x001;
const SUPPLY: u32 = 0x00d;
const FAULT_CODE: u32 = 0x00f;
const COMMAND: u8 = 0x20;
const MAX_TORQUE: u8 = 0x25;
const WATCHDOG: u8 = 0x27;
const IDENTITY: u32 = 0x100;

/// Codes of [`BusFault::Drive`](sinew_session::BusFault::Drive) from which on the fault of a controller
/// counts, or the mode in which it has timed out. CiA 301 has no emergency of such a code.
const CODES: u16 = 0x100;
pub(super) const FAULT_CODES: std::ops::RangeInclusive<u16> = CODES..=CODES + 0xff;

/// The fault with a code of [`FAULT_CODES`].
pub(super) fn fault_name(code: u16) -> String {
    let fault = code.wrapping_sub(CODES) as u8;
    let name = match fault {
        TIMEOUT => return "no command within its watchdog timeout (mode 11)".to_owned(),
        32 => "calibration fault",
        33 => "motor driver fault",
        34 => "over voltage",
        35 => "encoder fault",
        36 => "motor not configured",
        37 => "pwm cycle overrun",
        38 => "over temperature",
        39 => "outside limit",
        40 => "under voltage",
        41 => "config changed",
        42 => "theta invalid",
        43 => "position invalid",
        44 => "driver enable fault",
        45 => "stop position deprecated",
        46 => "timing violation",
        47 => "bemf feedforward no accel",
        48 => "invalid limits",
        49 => "position control error",
        50 => "velocity control error",
        _ => return format!("fault {fault}"),
    };
    format!("{name} (fault {fault})")
}

/// A mode.
fn mode_name(mode: u8) -> String {
    match mode {
        STOPPED => "mode 0 (stopped)".to_owned(),
        FAULT => "mode 1 (fault)".to_owned(),
        POSITION => "mode 10 (position)".to_owned(),
        TIMEOUT => "mode 11 (timeout)".to_owned(),
        _ => format!("mode {mode}"),
    }
}

/// What every command asks for: mode; position, velocity, torque; voltage, temperature, fault.
const QUERY: [u8; 6] = [
    READ | INT8 << 2 | 1,
    MODE as u8,
    READ | FLOAT << 2 | 3,
    MEASURED as u8,
    READ | INT8 << 2 | 3,
    SUPPLY as u8,
];

/// Subframes to a controller, which answers.
fn tell(node: u8, parts: &[&[u8]]) -> Frame {
    let (mut octets, mut length) = ([NOP; 64], 0);
    for octet in parts.iter().copied().flatten().take(octets.len()) {
        octets[length] = *octet;
        length += 1;
    }
    Frame::fd(0x8000 | u16::from(node), &octets[..Frame::fd_length(length)])
}

/// Takes the power and clears a fault.
fn stop(node: u8) -> Frame {
    tell(node, &[&[WRITE | INT8 << 2 | 1, MODE as u8, STOPPED], &QUERY])
}

/// Asks for readings alone.
fn query(node: u8) -> Frame {
    tell(node, &[&QUERY])
}

/// Follows a velocity, turns/s, from where it is, with a torque, N m, at most and for as long, s.
fn follow(node: u8, velocity: f32, torque: f32, timeout: f32) -> Frame {
    let float = WRITE | FLOAT << 2;
    tell(
        node,
        &[
            &[WRITE | INT8 << 2 | 1, MODE as u8, POSITION],
            &[float | 2, COMMAND],
            &f32::NAN.to_le_bytes(),
            &velocity.to_le_bytes(),
            &[float | 1, MAX_TORQUE],
            &torque.to_le_bytes(),
            &[float | 1, WATCHDOG],
            &timeout.to_le_bytes(),
            &QUERY,
        ],
    )
}

/// Asks for model, firmware and version of the registers.
pub(super) fn ask_identity(node: u8) -> Frame {
    tell(node, &[&[READ | INT32 << 2 | 3, IDENTITY as u8 | 0x80, (IDENTITY >> 7) as u8]])
}

/// The controller that a frame is of and its model, firmware and version of the registers; none of another
/// frame.
pub(super) fn identity(frame: &Frame) -> Option<(u8, [i32; 3])> {
    let (mut identity, mut known) = ([0; 3], 0);
    each(frame.octets(), |register, number| {
        if let (Some(place), Number::Whole(number)) =
            (identity.get_mut(register.wrapping_sub(IDENTITY) as usize), number)
        {
            *place = number;
            known += 1;
        }
    });
    let node = (frame.id() >> 8) as u8;
    (known == 3 && frame.id() & 0xff == 0 && (1..=MAX_NODE).contains(&node)).then_some((node, identity))
}

/// Readings of a controller.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Readings {
    mode: u8,
    fault: u8,
    /// Turns.
    position: f64,
    /// N m.
    torque: f64,
}

/// The readings that a frame of a controller carries, where it has all of them.
fn readings(node: u8, frame: &Frame) -> Option<Readings> {
    let (mut wholes, mut floats) = ([None; 2], [None; 2]);
    each(frame.octets(), |register, number| match (register, number) {
        (MODE, Number::Whole(mode)) => wholes[0] = Some(mode as u8),
        (FAULT_CODE, Number::Whole(fault)) => wholes[1] = Some(fault as u8),
        (MEASURED, Number::Float(position)) => floats[0] = Some(f64::from(position)),
        (0x003, Number::Float(torque)) => floats[1] = Some(f64::from(torque)),
        _ => {}
    });
    let ([Some(mode), Some(fault)], [Some(position), Some(torque)]) = (wholes, floats) else { return None };
    (frame.id() == u16::from(node) << 8).then_some(Readings { mode, fault, position, torque })
}

/// A value as it is sent.
#[derive(Debug, Clone, Copy)]
enum Number {
    Whole(i32),
    Float(f32),
}

/// Shows every register that is replied with its value; the first subframe of another sort ends it.
fn each(octets: &[u8], mut see: impl FnMut(u32, Number)) -> Option<()> {
    let mut rest = octets;
    loop {
        let (code, after) = rest.split_first()?;
        rest = after;
        if *code == NOP {
            continue;
        }
        if code & 0xf0 != REPLY {
            return None;
        }
        let (kind, mut count) = (code >> 2 & 3, u32::from(code & 3));
        if count == 0 {
            (count, rest) = varuint(rest)?;
        }
        let first;
        (first, rest) = varuint(rest)?;
        // More than fit are not there.
        for register in first..first.saturating_add(count.min(64)) {
            let number;
            (number, rest) = value(kind, rest)?;
            see(register, number);
        }
    }
}

/// A value of a kind, and what follows it.
fn value(kind: u8, octets: &[u8]) -> Option<(Number, &[u8])> {
    let wide = |rest: [u8; 4]| i32::from_le_bytes(rest);
    Some(match kind {
        INT8 => {
            let (octet, rest) = octets.split_first()?;
            (Number::Whole(i32::from(octet.cast_signed())), rest)
        }
        1 => {
            let (octets, rest) = octets.split_first_chunk()?;
            (Number::Whole(i32::from(i16::from_le_bytes(*octets))), rest)
        }
        INT32 => octets.split_first_chunk().map(|(octets, rest)| (Number::Whole(wide(*octets)), rest))?,
        _ => {
            let (octets, rest) = octets.split_first_chunk()?;
            (Number::Float(f32::from_le_bytes(*octets)), rest)
        }
    })
}

/// A number in groups of 7 bits, the lowest first, and what follows it.
fn varuint(octets: &[u8]) -> Option<(u32, &[u8])> {
    let (mut number, mut rest) = (0_u32, octets);
    for shift in [0, 7, 14, 21, 28] {
        let (octet, after) = rest.split_first()?;
        (number, rest) = (number | u32::from(octet & 0x7f) << shift, after);
        if octet & 0x80 == 0 {
            return Some((number, rest));
        }
    }
    None
}

/// Time of a cycle of so many controllers on a bus of a rate, bit/s, at most, s: a command with its answer
/// each.
pub(super) fn time(nodes: usize, bitrate: u32) -> f64 {
    let answer = Frame::fd(u16::from(MAX_NODE) << 8, &[0; 22]);
    1e-9 * nodes as f64 * (follow(0, 0.0, 0.0, 0.0).time(bitrate) + answer.time(bitrate)) as f64
}
