//! An Ethernet frame as EtherCAT sees it: the place of its datagrams, and one datagram with its fields.
//!
//! Source: ETG.1000.4, 5.3 (frame coding) and 5.4 (datagrams).

use crate::bytes::{u16_at, u32_at};
use core::ops::Range;

/// EtherType of EtherCAT.
pub(crate) const ETHERTYPE: u16 = 0x88a4;
const ETHERTYPE_VLAN: u16 = 0x8100;
const ETHERNET_HEADER: usize = 14;
const VLAN_TAG: usize = 4;
/// Command, index, address, length and flags, event request.
const DATAGRAM_HEADER: usize = 10;
const WORKING_COUNTER: usize = 2;

/// Where a frame's datagrams are.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Payload {
    /// They fill this range.
    Datagrams(Range<usize>),
    /// The header announces more octets than the frame has.
    Short,
    /// Not an EtherCAT frame with datagrams (protocol type 1).
    Other,
}

/// Finds the datagrams of a frame, behind a VLAN tag where there is one.
pub(crate) fn payload(frame: &[u8]) -> Payload {
    let big_endian = |at: usize| u16_at(frame, at).swap_bytes();
    let (ethertype, mut at) = match big_endian(12) {
        ETHERTYPE_VLAN => (big_endian(12 + VLAN_TAG), ETHERNET_HEADER + VLAN_TAG),
        other => (other, ETHERNET_HEADER),
    };
    if ethertype != ETHERTYPE || frame.len() < at + 2 {
        return Payload::Other;
    }
    let header = u16_at(frame, at);
    at += 2;
    let length = usize::from(header & 0x07ff);
    if header >> 12 != 1 {
        return Payload::Other;
    }
    if at + length > frame.len() { Payload::Short } else { Payload::Datagrams(at..at + length) }
}

/// The fifteen commands of ETG.1000.4, table 16 and following.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Command {
    Nop,
    /// One device by its position on the line.
    Position(Transfer),
    /// One device by its station address or alias.
    Station(Transfer),
    /// Every device.
    Broadcast(Transfer),
    /// Every device that maps the logical address.
    Logical(Transfer),
    /// The device at the position reads, all others write.
    PositionMultiple,
    /// The device with the station address reads, all others write.
    StationMultiple,
}

/// What is done with the addressed memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Transfer {
    Read,
    Write,
    Exchange,
}

impl Command {
    /// `None` for a number that the standard does not define: devices pass such a datagram on.
    pub(crate) fn from_number(number: u8) -> Option<Self> {
        use Transfer::{Exchange, Read, Write};
        Some(match number {
            0 => Self::Nop,
            1 => Self::Position(Read),
            2 => Self::Position(Write),
            3 => Self::Position(Exchange),
            4 => Self::Station(Read),
            5 => Self::Station(Write),
            6 => Self::Station(Exchange),
            7 => Self::Broadcast(Read),
            8 => Self::Broadcast(Write),
            9 => Self::Broadcast(Exchange),
            10 => Self::Logical(Read),
            11 => Self::Logical(Write),
            12 => Self::Logical(Exchange),
            13 => Self::PositionMultiple,
            14 => Self::StationMultiple,
            _ => return None,
        })
    }
}

/// One datagram on its way down the line.
#[derive(Debug)]
pub(crate) struct Datagram<'a> {
    /// What is to be done.
    pub(crate) command: Option<Command>,
    /// Position or station address; the low half of a logical address.
    pub(crate) device: u16,
    /// Offset in the device; the high half of a logical address.
    pub(crate) offset: u16,
    /// The data.
    pub(crate) data: &'a mut [u8],
    /// Event requests of all devices so far.
    pub(crate) events: u16,
    /// Working counter.
    pub(crate) counter: u16,
    head: &'a mut [u8],
    tail: &'a mut [u8],
}

impl<'a> Datagram<'a> {
    /// The datagram at the beginning of `payload`, the rest, and whether the rest holds another one; `None`
    /// where the lengths do not fit.
    pub(crate) fn split(payload: &'a mut [u8]) -> Option<(Self, &'a mut [u8], bool)> {
        let (head, rest) = payload.split_at_mut_checked(DATAGRAM_HEADER)?;
        let flags = u16_at(head, 6);
        let (data, rest) = rest.split_at_mut_checked(usize::from(flags & 0x07ff))?;
        let (tail, rest) = rest.split_at_mut_checked(WORKING_COUNTER)?;
        let datagram = Self {
            command: Command::from_number(head[0]),
            device: u16_at(head, 2),
            offset: u16_at(head, 4),
            events: u16_at(head, 8),
            counter: u16_at(tail, 0),
            data,
            head,
            tail,
        };
        Some((datagram, rest, flags & 0x8000 != 0))
    }

    /// The logical address.
    pub(crate) fn logical(&self) -> u32 {
        u32_at(self.head, 2)
    }

    /// Counts a success of one device.
    pub(crate) fn count(&mut self, by: u16) {
        self.counter = self.counter.wrapping_add(by);
    }

    /// Writes address, event requests and working counter back into the frame.
    pub(crate) fn finish(self) {
        self.head[2..4].copy_from_slice(&self.device.to_le_bytes());
        self.head[8..10].copy_from_slice(&self.events.to_le_bytes());
        self.tail.copy_from_slice(&self.counter.to_le_bytes());
    }
}
