//! CANopen, CiA 301: SDO, PDOs with SYNC, heartbeat both ways; drives after CiA 402.

mod bring_up;
mod sdo;
mod slot;

pub use sdo::{SdoClient, SdoError};

pub(super) use bring_up::start;

use super::device::MASTER;
use sinew_segment::CanFrame as Frame;

/// Functions in an identifier, beside that of the node.
const EMERGENCY: u16 = 0x80;
const TO_MASTER: u16 = 0x180;
const TO_NODE: u16 = 0x200;
const HEARTBEAT: u16 = 0x700;
/// Network management.
const START: u8 = 1;
const PRE_OPERATIONAL: u8 = 128;
/// State of an operational node in its heartbeat.
const OPERATIONAL: u8 = 5;
/// Time between two heartbeats of a node, ms.
const HEARTBEAT_MS: u32 = 50;

/// A command of network management to a node.
fn manage(command: u8, node: u8) -> Frame {
    Frame::new(0, &[command, node])
}

/// On which all nodes take their commands over and answer.
pub(super) fn sync() -> Frame {
    Frame::new(0x80, &[])
}

/// The heartbeat of the master.
pub(super) fn heartbeat() -> Frame {
    Frame::new(HEARTBEAT + u16::from(MASTER), &[OPERATIONAL])
}

/// Time of a cycle of so many nodes and a period, s, on a bus of a rate, bit/s, at most, s: SYNC and a
/// heartbeat of the master, PDOs both ways, and their share of the nodes' heartbeats.
pub(super) fn time(nodes: usize, period: f64, bitrate: u32) -> f64 {
    let of = |octets: usize| 1e-9 * Frame::new(0, &[0; 8][..octets]).time(bitrate) as f64;
    let share = (1e3 * period / f64::from(HEARTBEAT_MS)).min(1.0);
    of(0) + of(1) + nodes as f64 * (of(6) + of(8) + share * of(1))
}
