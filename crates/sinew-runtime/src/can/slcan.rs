//! Frames as text on a serial line, as Lawicel's adapters and their many followers have it.
//!
//! ```text
//! t1232aabb\r  frame with identifier 0x123 and the octets aa bb    r1238\r  asks for 8 octets of 0x123
//! S8\r  1 Mbit/s   O\r  open   C\r  closed
//! ```

use super::adapter::{Dialect, Host};
use sinew_segment::CanFrame as Frame;
use std::io;

/// Bit rates by the digit of their command, bit/s.
pub const RATES: [u32; 9] = [10_000, 20_000, 50_000, 100_000, 125_000, 250_000, 500_000, 800_000, 1_000_000];
/// The longest line: an extended frame of 8 octets with a time stamp.
const LONGEST: usize = 32;
const DIGITS: &[u8; 16] = b"0123456789ABCDEF";

/// Appends a frame, within the capacity of `out` without an allocation.
pub fn encode(out: &mut Vec<u8>, frame: &Frame) {
    let digit = |number: u16| DIGITS[usize::from(number & 15)];
    let (id, kind) = (frame.id(), if frame.is_remote() { b'r' } else { b't' });
    out.extend([kind, digit(id >> 8), digit(id >> 4), digit(id), digit(frame.length() as u16)]);
    for octet in frame.octets().iter().map(|octet| u16::from(*octet)) {
        out.extend([digit(octet >> 4), digit(octet)]);
    }
    out.push(b'\r');
}

/// A line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Line {
    /// A frame.
    Frame(Frame),
    /// A command with its first argument, 0 for none.
    Command(u8, u8),
}

/// Finds lines in a stream of octets; what is none is left out, as are frames with 29 bits of identifier.
#[derive(Debug, Clone, Default)]
pub struct Decoder {
    line: [u8; LONGEST],
    length: usize,
}

impl Decoder {
    /// Takes an octet; the line that it ends.
    pub fn feed(&mut self, octet: u8) -> Option<Line> {
        if !matches!(octet, b'\r' | 0x07) {
            if let Some(place) = self.line.get_mut(self.length) {
                *place = octet;
            }
            // A line that is too long stays so until it ends.
            self.length = (self.length + 1).min(LONGEST + 1);
            return None;
        }
        let length = core::mem::take(&mut self.length);
        // The bell says that a command has failed: what stands before it is none.
        let line = self.line.get(..length).filter(|_| octet == b'\r')?;
        match *line {
            [kind @ (b't' | b'r'), ref rest @ ..] => frame(rest, kind == b'r').map(Line::Frame),
            [b'T' | b'R', ..] | [] => None,
            [command, ref rest @ ..] => Some(Line::Command(command, rest.first().copied().unwrap_or(0))),
        }
    }
}

/// Identifier, length, octets, and perhaps a time stamp of two octets.
fn frame(digits: &[u8], remote: bool) -> Option<Frame> {
    let number = |digits: &[u8]| {
        digits
            .iter()
            .try_fold(0_u16, |number, digit| Some(number << 4 | char::from(*digit).to_digit(16)? as u16))
    };
    let (head, octets) = digits.split_at_checked(4)?;
    let (id, length) = (number(&head[..3])?, usize::from(number(&head[3..])?));
    let carried = if remote { 0 } else { 2 * length };
    let fits = id <= 0x7ff && length <= 8 && [carried, carried + 4].contains(&octets.len());
    let mut data = [0; 8];
    for (octet, digits) in data.iter_mut().zip(octets[..carried.min(octets.len())].chunks_exact(2)) {
        *octet = number(digits)? as u8;
    }
    fits.then(|| if remote { Frame::remote(id, length) } else { Frame::new(id, &data[..length.min(8)]) })
}

/// What the adapter says to its host.
#[derive(Debug, Clone, Default)]
pub struct Slcan(Decoder);

impl Dialect for Slcan {
    const CARRIES_FD: bool = false;
    const CLOSE: &[u8] = b"C\r";

    fn open(bitrate: u32) -> io::Result<String> {
        let rate = RATES.iter().position(|rate| *rate == bitrate);
        let rate = rate.ok_or_else(|| io::Error::other(format!("slcan has no rate of {bitrate} bit/s")))?;
        // What was begun before ends; a bus that was open is closed.
        Ok(format!("\r\r\rC\rS{rate}\rO\r"))
    }

    fn encode(out: &mut Vec<u8>, frame: &Frame) {
        encode(out, frame);
    }

    fn feed(&mut self, octet: u8) -> Option<Frame> {
        match self.0.feed(octet)? {
            Line::Frame(frame) => Some(frame),
            Line::Command(..) => None,
        }
    }
}

/// An adapter with simulated nodes on a bus of a rate, as its host sees it.
#[derive(Debug)]
pub(super) struct SlcanHost {
    decoder: Decoder,
    bitrate: u32,
    rate: u32,
    open: bool,
}

impl SlcanHost {
    pub(super) fn new(bitrate: u32) -> Self {
        Self { decoder: Decoder::default(), bitrate, rate: 0, open: false }
    }

    /// Nodes hear nothing at another rate than theirs, and are not heard.
    fn hears(&self) -> bool {
        self.open && self.rate == self.bitrate
    }
}

impl Host for SlcanHost {
    fn take(&mut self, octet: u8, out: &mut Vec<u8>) -> Option<Frame> {
        match self.decoder.feed(octet)? {
            Line::Frame(frame) => return Some(frame).filter(|_| self.hears()),
            Line::Command(b'S', digit) => {
                self.rate = RATES.get(usize::from(digit.wrapping_sub(b'0'))).copied().unwrap_or(0);
                out.push(b'\r');
            }
            Line::Command(command @ (b'O' | b'C'), _) => {
                self.open = command == b'O';
                out.push(b'\r');
            }
            Line::Command(b'V', _) => out.extend(b"V0000\r"),
            Line::Command(b'N', _) => out.extend(b"N0000\r"),
            Line::Command(..) => {}
        }
        None
    }

    fn show(&self, frame: &Frame, out: &mut Vec<u8>) {
        if self.hears() {
            encode(out, frame);
        }
    }
}
