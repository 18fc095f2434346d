//! What answers on a line.

use super::bring_up::Exchange;
use super::line::Lines;
use super::model::Model;
use super::protocol::instruction::{PING, STATUS};
use super::protocol::{BROADCAST, encode};
use std::io;

/// A servo that answers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FoundServo {
    /// Its identifier.
    pub id: u8,
    /// Its model number.
    pub number: u16,
    /// Version of its firmware.
    pub firmware: u8,
    /// Whether it reports a hardware error.
    pub alert: bool,
}

impl FoundServo {
    /// Name of its model, where it is known.
    #[must_use]
    pub fn model(&self) -> Option<String> {
        Model::all().find(|model| model.number == Some(self.number)).map(|model| model.name)
    }
}

/// Time in which every identifier has had its turn to answer, beside what octets take: ns.
const PATIENCE: u64 = 3_000_000;

/// The servos that answer on a line of a rate, bit/s, by their identifiers; nothing moves.
///
/// # Errors
/// Of the operating system.
pub fn scan<L: Lines>(lines: &mut L, line: usize, baud: u32) -> io::Result<Vec<FoundServo>> {
    let mut exchange = Exchange::new(lines);
    encode(&mut exchange.out, BROADCAST, PING, &[]);
    let mut deadline = exchange.send(line)?;
    // Every servo waits for those before it: longest where octets are slow and return delays as they come.
    let each = PATIENCE + 14 * 10_000_000_000 / u64::from(baud.max(1));
    let (mut found, mut buffer) = (Vec::<FoundServo>::new(), [0; 256]);
    loop {
        while let Some(packet) = exchange.decoder.next(None) {
            if let (STATUS, [low, high, firmware]) = (packet.instruction, packet.data) {
                let (number, alert) = (u16::from_le_bytes([*low, *high]), packet.error & 0x80 != 0);
                found.push(FoundServo { id: packet.id, number, firmware: *firmware, alert });
            }
        }
        let count = exchange.lines.receive(line, &mut buffer, deadline)?;
        if count == 0 {
            break;
        }
        exchange.decoder.feed(&buffer[..count]);
        deadline = deadline.max(exchange.lines.now() + 20 * each);
    }
    found.sort_by_key(|servo| servo.id);
    Ok(found)
}
