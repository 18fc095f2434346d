//! CANSimple, the protocol of ODrive's firmware 0.6: messages of an axis in velocity mode.
//!
//! ```text
//! identifier = node << 5 | command    8 octets, little-endian; asked for by remote frames
//! ```
//!
//! Source: the messages of ODrive 0.6.10 (its manual and DBC file).

mod bring_up;
mod parameters;
mod slot;

pub(super) use bring_up::start;

use sinew_segment::CanFrame as Frame;

/// Commands.
const GET_VERSION: u16 = 0x00;
const HEARTBEAT: u16 = 0x01;
const GET_ERROR: u16 = 0x03;
const RX_SDO: u16 = 0x04;
const TX_SDO: u16 = 0x05;
const SET_AXIS_STATE: u16 = 0x07;
const GET_ENCODER_ESTIMATES: u16 = 0x09;
const SET_CONTROLLER_MODE: u16 = 0x0b;
const SET_INPUT_VEL: u16 = 0x0d;
const SET_LIMITS: u16 = 0x0f;
const GET_IQ: u16 = 0x14;
const CLEAR_ERRORS: u16 = 0x18;
/// Version of the protocol, as it says of itself.
const PROTOCOL: u8 = 2;
/// States of an axis.
const IDLE: u8 = 1;
const CLOSED_LOOP: u8 = 8;
/// The largest identifier of a node; 63 is all.
pub(super) const MAX_NODE: u8 = 62;
/// Time between two heartbeats, at most, ms: they alone say of an axis that it has power, and errors.
const HEARTBEAT_MS: u32 = 20;

/// Errors of an axis by their bits, as the manual has them; empty ones are unused.
const ERRORS: [&str; 31] = [
    "INITIALIZING",
    "SYSTEM_LEVEL",
    "TIMING_ERROR",
    "MISSING_ESTIMATE",
    "BAD_CONFIG",
    "DRV_FAULT",
    "MISSING_INPUT",
    "",
    "DC_BUS_OVER_VOLTAGE",
    "DC_BUS_UNDER_VOLTAGE",
    "DC_BUS_OVER_CURRENT",
    "DC_BUS_OVER_REGEN_CURRENT",
    "CURRENT_LIMIT_VIOLATION",
    "MOTOR_OVER_TEMP",
    "INVERTER_OVER_TEMP",
    "VELOCITY_LIMIT_VIOLATION",
    "POSITION_LIMIT_VIOLATION",
    "",
    "",
    "",
    "",
    "",
    "",
    "",
    "WATCHDOG_TIMER_EXPIRED",
    "ESTOP_REQUESTED",
    "SPINOUT_DETECTED",
    "BRAKE_RESISTOR_DISARMED",
    "THERMISTOR_DISCONNECTED",
    "",
    "CALIBRATION_ERROR",
];
const WATCHDOG_EXPIRED: u32 = 1 << 24;
/// Codes of [`BusFault::Drive`](sinew_session::BusFault::Drive): the lowest bit of an error, from 1. CiA 301
/// has no emergency of such a code.
pub(super) const ERROR_CODES: std::ops::RangeInclusive<u16> = 1..=32;

/// The error with a code of [`ERROR_CODES`].
pub(super) fn error_name(code: u16) -> String {
    let bit = code.wrapping_sub(1);
    match ERRORS.get(usize::from(bit)).filter(|name| !name.is_empty()) {
        Some(name) => format!("{name} (bit {bit})"),
        None => format!("error bit {bit}"),
    }
}

/// All errors of their bits.
fn error_names(bits: u32) -> String {
    if bits == 0 {
        return "no error".to_owned();
    }
    let set = (0..32).filter(|bit| bits >> bit & 1 == 1).map(|bit| error_name(bit + 1));
    set.collect::<Vec<_>>().join(", ")
}

/// A state of an axis.
fn state_name(state: u8) -> String {
    match state {
        IDLE => "IDLE".to_owned(),
        CLOSED_LOOP => "CLOSED_LOOP_CONTROL".to_owned(),
        _ => format!("state {state}"),
    }
}

/// A message to a node.
fn tell(node: u8, command: u16, octets: &[u8]) -> Frame {
    Frame::new(u16::from(node) << 5 | command, octets)
}

/// Asks a node for a message.
fn ask(node: u8, command: u16) -> Frame {
    Frame::remote(u16::from(node) << 5 | command, 8)
}

/// The message that a frame is of a node: parameters are shorter by the octets that their types lack.
fn command(node: u8, frame: &Frame) -> Option<(u16, [u8; 8])> {
    let (command, given) = (frame.id() & 0x1f, frame.octets());
    let least = if command == TX_SDO { 5 } else { 8 };
    let mut octets = [0; 8];
    octets.iter_mut().zip(given).for_each(|(octet, given)| *octet = *given);
    (frame.id() >> 5 == u16::from(node) && given.len() >= least).then_some((command, octets))
}

/// Asks a node for its versions.
pub(super) fn ask_version(node: u8) -> Frame {
    ask(node, GET_VERSION)
}

/// The node that a frame is of and its versions, of protocol, hardware, firmware; none of another frame.
pub(super) fn version(frame: &Frame) -> Option<(u8, [u8; 8])> {
    let octets = frame.octets().first_chunk::<8>().filter(|octets| octets[0] == PROTOCOL)?;
    (frame.id() & 0x1f == GET_VERSION).then_some(((frame.id() >> 5) as u8, *octets))
}

/// Whether a frame is the heartbeat of an axis to which requests of CANopen would be commands. On CANopen
/// none but a master sends such a frame.
pub(super) fn would_obey_canopen(frame: &Frame) -> bool {
    (48..52).contains(&(frame.id() >> 5)) && frame.id() & 0x1f == HEARTBEAT && frame.octets().len() == 8
}

fn set_axis_state(node: u8, state: u8) -> Frame {
    tell(node, SET_AXIS_STATE, &pair(u32::from(state), 0))
}

/// Velocity, turns/s, without a torque beside it.
fn set_input_vel(node: u8, velocity: f32) -> Frame {
    tell(node, SET_INPUT_VEL, &pair(velocity.to_bits(), 0))
}

fn pair(first: u32, second: u32) -> [u8; 8] {
    (u64::from(second) << 32 | u64::from(first)).to_le_bytes()
}

fn words(octets: [u8; 8]) -> [u32; 2] {
    let both = u64::from_le_bytes(octets);
    [both as u32, (both >> 32) as u32]
}

fn floats(octets: [u8; 8]) -> [f64; 2] {
    words(octets).map(|word| f64::from(f32::from_bits(word)))
}

/// Time of a cycle of so many nodes and a period, s, on a bus of a rate, bit/s, at most, s: a command, two
/// requests with their answers, and a share of the heartbeat.
pub(super) fn time(nodes: usize, period: f64, bitrate: u32) -> f64 {
    let share = (1e3 * period / f64::from(HEARTBEAT_MS)).min(1.0);
    let [data, remote] = [tell(0, 0, &[0; 8]), ask(0, 0)].map(|frame| 1e-9 * frame.time(bitrate) as f64);
    nodes as f64 * ((3.0 + share) * data + 2.0 * remote)
}
