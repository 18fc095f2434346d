//! MIT mode: position, velocity, stiffness, damping and torque in one frame to a motor.
//!
//! ```text
//! identifier = that of the motor    8 octets; answered with its identifier, position, velocity, torque
//! ff ff ff ff ff ff ff fc  from now on it follows    .. fd  it loses its power
//! ```
//!
//! Source: the firmware of the MIT mini cheetah's motors (bgkatz/motorcontrol); CubeMars' manual of the AK
//! series, 1.0.8; DAMIAO's manual, as its Python packages have it.

mod bring_up;
mod model;
mod slot;

pub(super) use bring_up::{prove_watchdog, start};
pub use model::MitMotor;

use sinew_segment::{CanFrame as Frame, MitFamily, MitRanges, MitReadings};

/// The largest identifier of a motor, and of a DAMIAO, which shows four bits of it.
pub(super) const MAX_NODE: u8 = 126;
pub(super) const MAX_DAMIAO: u8 = 15;
/// Part of its range in which a position has to be.
const TRAVEL: f64 = 0.96;

/// Codes of [`BusFault::Drive`](sinew_session::BusFault::Drive): those of a CubeMars, of a DAMIAO, and of
/// ours. CiA 301 has no emergency of such a code.
const CODES: u16 = 0x200;
const OF_DAMIAO: u16 = 0x10;
const BEYOND: u16 = CODES + 0x20;
const LAGS: u16 = CODES + 0x21;
pub(super) const FAULT_CODES: std::ops::RangeInclusive<u16> = CODES..=CODES + 0xff;

/// The fault with a code of [`FAULT_CODES`].
pub(super) fn fault_name(code: u16) -> String {
    let error = code & 0x0f;
    let name = match code - CODES {
        0x01 => "motor over temperature",
        0x02 => "over current",
        0x03 | 0x18 => "over voltage",
        0x04 | 0x19 => "under voltage",
        0x05 => "encoder fault",
        0x06 => "amplifier over temperature or phases unbalanced",
        0x07 => "motor stalled",
        0x1a => "over current",
        0x1b => "amplifier over temperature",
        0x1c => "motor over temperature",
        0x1d => "no command within its own time",
        0x1e => "overload",
        0x20 => return "a position at the end of its range".to_owned(),
        0x21 => return "a position that lags behind: held back, or without power".to_owned(),
        _ => return format!("error {error}"),
    };
    format!("{name} (error {error})")
}

/// The motor follows what it is told.
fn enter(node: u8) -> Frame {
    special(node, 0xfc)
}

/// The motor loses its power.
pub(super) fn leave(node: u8) -> Frame {
    special(node, 0xfd)
}

/// The errors of a DAMIAO are known.
fn clear(node: u8) -> Frame {
    special(node, 0xfb)
}

fn special(node: u8, last: u8) -> Frame {
    Frame::new(u16::from(node), &[0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, last])
}

/// What a motor answers.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Answer {
    readings: MitReadings,
    /// Whether it has power, where it says so.
    power: Option<bool>,
    /// Code of its error.
    fault: Option<u16>,
}

/// Whether a frame has the form of an answer of a motor. A DAMIAO never answers under an identifier that one
/// may have: it would be a command to that one.
pub(super) fn is_answer(frame: &Frame, node: u8, family: MitFamily) -> bool {
    let (id, octets) = (frame.id(), frame.octets());
    let Some(first) = octets.first().filter(|_| !frame.is_fd()) else { return false };
    match family {
        MitFamily::MiniCheetah => octets.len() == 6 && *first == node,
        MitFamily::Cubemars => octets.len() == 8 && *first == node && (id == 0 || id == u16::from(node)),
        MitFamily::Damiao => octets.len() == 8 && first & 15 == node && !(1..=15).contains(&id),
    }
}

/// What a frame says as an answer of a motor, where it is one.
fn answer(node: u8, ranges: &MitRanges, frame: &Frame) -> Option<Answer> {
    let [first, rest @ ..] = frame.octets() else { return None };
    if !is_answer(frame, node, ranges.family) {
        return None;
    }
    let readings = ranges.readings(*rest.first_chunk()?);
    let (state, error) = (first >> 4, rest.last().copied().unwrap_or(0));
    let (power, fault) = match ranges.family {
        MitFamily::MiniCheetah => (None, None),
        MitFamily::Cubemars => (None, (error != 0).then_some(CODES + u16::from(error & 15))),
        MitFamily::Damiao => (Some(state == 1), (state > 1).then_some(CODES + OF_DAMIAO + u16::from(state))),
    };
    Some(Answer { readings, power, fault })
}

/// The motor without power that a frame is an answer of: its identifier and family, which the form tells.
pub(super) fn sender(frame: &Frame) -> Option<(u8, MitFamily)> {
    let first = *frame.octets().first()?;
    let of = |(node, family)| is_answer(frame, node, family) && (1..=MAX_NODE).contains(&node);
    let families = [MitFamily::MiniCheetah, MitFamily::Cubemars, MitFamily::Damiao];
    families.map(|family| (first, family)).into_iter().find(|sender| of(*sender))
}

/// Time of a cycle of so many motors on a bus of a rate, bit/s, at most, s: a command with its answer each.
pub(super) fn time(nodes: usize, bitrate: u32) -> f64 {
    2e-9 * nodes as f64 * leave(0).time(bitrate) as f64
}
