//! Frames as text on the serial line of mjbots' fdcanusb, the adapter of moteus.
//!
//! ```text
//! can send 8001 01000a BF\n  sends a frame of CAN FD with two rates    OK\n  taken
//! rcv 100 210000 BF\n        a frame that has come                     *5C at the end of a line: checksum
//! ```

use super::adapter::{Dialect, Host};
use sinew_segment::CanFrame as Frame;
use std::io;

/// The longest line: 64 octets, identifier, flags, checksum.
const LONGEST: usize = 192;
const DIGITS: &[u8; 16] = b"0123456789ABCDEF";

/// Appends a line about a frame, within the capacity of `out` without an allocation.
fn write(out: &mut Vec<u8>, verb: &[u8], frame: &Frame) {
    let digit = |number: u16| DIGITS[usize::from(number & 15)];
    let id = frame.id();
    out.extend(verb);
    out.extend([digit(id >> 12), digit(id >> 8), digit(id >> 4), digit(id), b' ']);
    for octet in frame.octets().iter().map(|octet| u16::from(*octet)) {
        out.extend([digit(octet >> 4), digit(octet)]);
    }
    out.extend(if frame.is_fd() { b" BF" } else { b" bf" });
}

/// Finds lines in a stream of octets.
#[derive(Debug, Clone)]
struct Lines {
    line: [u8; LONGEST],
    length: usize,
}

impl Default for Lines {
    fn default() -> Self {
        Self { line: [0; LONGEST], length: 0 }
    }
}

impl Lines {
    /// Takes an octet; the line that it ends without its checksum, and whether it had one. Empty lines,
    /// those that are too long and those with another checksum are left out.
    fn feed(&mut self, octet: u8) -> Option<(&[u8], bool)> {
        if !matches!(octet, b'\r' | b'\n') {
            if let Some(place) = self.line.get_mut(self.length) {
                *place = octet;
            }
            // A line that is too long stays so until it ends.
            self.length = (self.length + 1).min(LONGEST + 1);
            return None;
        }
        let length = core::mem::take(&mut self.length);
        let line = self.line.get(..length).filter(|line| !line.is_empty())?;
        let Some((content, [b'*', high, low])) = line.split_last_chunk() else { return Some((line, false)) };
        let given = number(&[*high, *low])?;
        (given == u16::from(checksum(content))).then_some((content, true))
    }
}

/// CRC-8 with polynomial 0x97.
fn checksum(octets: &[u8]) -> u8 {
    octets.iter().fold(0, |crc, octet| {
        (0..8).fold(crc ^ octet, |crc: u8, _| if crc & 0x80 == 0 { crc << 1 } else { crc << 1 ^ 0x97 })
    })
}

/// A number in up to four hexadecimal digits.
fn number(digits: &[u8]) -> Option<u16> {
    let digit = |number: u16, digit: &u8| Some(number << 4 | char::from(*digit).to_digit(16)? as u16);
    (1..=4).contains(&digits.len()).then(|| digits.iter().try_fold(0, digit))?
}

/// Identifier, octets, flags and whatever follows them.
fn frame(text: &[u8]) -> Option<Frame> {
    let mut fields = text.split(|octet| *octet == b' ');
    // The octets of a frame without any stand between two spaces, or nowhere.
    let (id, digits) = (number(fields.next()?)?, fields.next().unwrap_or_default());
    let (mut octets, length) = ([0; 64], digits.len() / 2);
    if length > octets.len() || digits.len() % 2 != 0 {
        return None;
    }
    for (octet, digits) in octets.iter_mut().zip(digits.chunks_exact(2)) {
        *octet = number(digits)? as u8;
    }
    Some(Frame::fd(id, &octets[..length]))
}

/// What the adapter says to its host.
#[derive(Debug, Clone, Default)]
pub struct Fdcanusb(Lines);

impl Dialect for Fdcanusb {
    const CARRIES_FD: bool = true;
    const CLOSE: &[u8] = b"";

    /// Its rates are set in its own configuration. What was begun before ends.
    fn open(_bitrate: u32) -> io::Result<String> {
        Ok("\n".to_owned())
    }

    fn encode(out: &mut Vec<u8>, frame: &Frame) {
        write(out, b"can send ", frame);
        out.push(b'\n');
    }

    fn feed(&mut self, octet: u8) -> Option<Frame> {
        let (line, _) = self.0.feed(octet)?;
        frame(line.strip_prefix(b"rcv ")?)
    }
}

/// An adapter with simulated nodes, as its host sees it.
#[derive(Debug, Default)]
pub(super) struct FdcanusbHost {
    lines: Lines,
    /// Whether its host sends checksums, and wants them.
    checked: bool,
}

impl FdcanusbHost {
    /// Ends the line that begins at a place.
    fn end(&self, start: usize, out: &mut Vec<u8>) {
        if self.checked {
            out.push(b' ');
            let sum = u16::from(checksum(&out[start..]));
            out.extend([b'*', DIGITS[usize::from(sum >> 4)], DIGITS[usize::from(sum & 15)]]);
        }
        out.extend(b"\r\n");
    }
}

impl Host for FdcanusbHost {
    fn take(&mut self, octet: u8, out: &mut Vec<u8>) -> Option<Frame> {
        let (line, checked) = self.lines.feed(octet)?;
        let frame = line.strip_prefix(b"can send ").map(frame);
        let start = out.len();
        self.checked = checked;
        out.extend(if frame == Some(None) { &b"ERR malformed"[..] } else { b"OK" });
        self.end(start, out);
        frame.flatten()
    }

    fn show(&self, frame: &Frame, out: &mut Vec<u8>) {
        let start = out.len();
        write(out, b"rcv ", frame);
        self.end(start, out);
    }
}
