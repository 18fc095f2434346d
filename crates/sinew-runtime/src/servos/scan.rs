//! What answers on a line.

use super::bring_up::Exchange;
use super::line::Lines;
use super::model::Model;
use super::protocol::instruction::{PING, STATUS};
use super::protocol::{BROADCAST, MAX_ID, Protocol};
use super::registers::sts;
use std::io;

/// A servo that answers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FoundServo {
    /// What it speaks.
    pub protocol: Protocol,
    /// Its identifier.
    pub id: u8,
    /// Its model number.
    pub number: u16,
    /// Version of its firmware, of a Feetech the first part of it.
    pub firmware: u8,
    /// Whether it reports a hardware error.
    pub alert: bool,
}

impl FoundServo {
    /// Name of its model, where it is known.
    #[must_use]
    pub fn model(&self) -> Option<String> {
        let same =
            |model: &Model| model.series.protocol() == self.protocol && model.number == Some(self.number);
        Model::all().find(same).map(|model| model.name)
    }
}

/// Time in which every identifier has had its turn to answer, beside what octets take: ns.
const PATIENCE: u64 = 3_000_000;
/// Time in which one that is asked alone answers, ns.
const ALONE: u64 = 10_000_000;

/// The servos of a protocol that answer on a line of a rate, bit/s, by their identifiers; nothing moves.
///
/// # Errors
/// Of the operating system.
pub fn scan<L: Lines>(
    lines: &mut L,
    protocol: Protocol,
    (line, baud): (usize, u32),
) -> io::Result<Vec<FoundServo>> {
    let mut exchange = Exchange::new(lines);
    exchange.speak(protocol);
    match protocol {
        Protocol::Dynamixel => all_at_once(&mut exchange, line, baud),
        Protocol::Feetech => one_by_one(&mut exchange, line),
    }
}

/// Asked together, Dynamixels answer one after the other.
fn all_at_once<L: Lines>(
    exchange: &mut Exchange<'_, L>,
    line: usize,
    baud: u32,
) -> io::Result<Vec<FoundServo>> {
    let protocol = Protocol::Dynamixel;
    protocol.instruct(&mut exchange.out, BROADCAST, PING, &[]);
    let mut deadline = exchange.send(line)?;
    // Every servo waits for those before it: longest where octets are slow and return delays as they come.
    let each = PATIENCE + 14 * 10_000_000_000 / u64::from(baud.max(1));
    let (mut found, mut buffer) = (Vec::<FoundServo>::new(), [0; 256]);
    loop {
        while let Some(packet) = exchange.decoder.next(None) {
            if let (STATUS, [low, high, firmware]) = (packet.instruction, packet.data) {
                let (number, alert) = (u16::from_le_bytes([*low, *high]), packet.error & 0x80 != 0);
                found.push(FoundServo { protocol, id: packet.id, number, firmware: *firmware, alert });
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

/// Asked together, Feetechs would answer at the same time.
fn one_by_one<L: Lines>(exchange: &mut Exchange<'_, L>, line: usize) -> io::Result<Vec<FoundServo>> {
    let (protocol, mut found, mut buffer) = (Protocol::Feetech, Vec::new(), [0; 256]);
    for id in 0..=MAX_ID {
        exchange.out.clear();
        protocol.instruct(&mut exchange.out, id, PING, &[]);
        exchange.send(line)?;
        let deadline = exchange.lines.now() + ALONE;
        let mut alert = None;
        while let (None, count @ 1..) = (alert, exchange.lines.receive(line, &mut buffer, deadline)?) {
            exchange.decoder.feed(&buffer[..count]);
            let answer = exchange.decoder.next(None).filter(|packet| packet.id == id);
            alert = answer.map(|packet| packet.error != 0);
        }
        let Some(alert) = alert else { continue };
        let (Some(number), Some((_, version))) =
            (exchange.ping(line, id)?, exchange.read((line, id), sts::FIRMWARE, 1)?)
        else {
            continue;
        };
        let firmware = version.first().copied().unwrap_or(0);
        found.push(FoundServo { protocol, id, number, firmware, alert });
    }
    Ok(found)
}
