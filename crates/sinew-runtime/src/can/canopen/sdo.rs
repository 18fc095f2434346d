//! Objects of a node, read and written one at a time: the client of SDO transfers, expedited and segmented.
//!
//! Source: CiA 301.

use crate::can::Link;
use sinew_segment::CanFrame as Frame;
use std::io;

/// Time for an answer, ns: an adapter's latency, a loaded computer.
const PATIENCE: u64 = 100_000_000;
/// Times that a transfer is tried.
const TRIES: usize = 3;
/// The longest value that is read.
const LONGEST: usize = 1024;
/// Abort codes: the client gives up; no such object; no such subindex.
const GENERAL: u32 = 0x0800_0000;
const NO_OBJECT: u32 = 0x0602_0000;
const NO_SUBINDEX: u32 = 0x0609_0011;

/// Why an object is not read or written.
#[derive(Debug, thiserror::Error)]
pub enum SdoError {
    /// The adapter is gone.
    #[error(transparent)]
    Port(#[from] io::Error),
    /// The node does not answer.
    #[error("does not answer")]
    Silent,
    /// The node refuses.
    #[error("{}", abort(*.0))]
    Abort(u32),
    /// The answer is none to the question.
    #[error("answers with something else")]
    Damaged,
}

impl SdoError {
    /// Whether the node has no such object.
    #[must_use]
    pub fn is_missing(&self) -> bool {
        matches!(self, Self::Abort(NO_OBJECT | NO_SUBINDEX))
    }
}

/// An abort code in words.
fn abort(code: u32) -> String {
    let words = match code {
        0x0503_0000 | 0x0504_0001 => "the transfer does not follow the protocol",
        0x0601_0000..=0x0601_0002 => "no such access to the object",
        NO_OBJECT => "no such object",
        0x0604_0041 => "the object cannot be mapped into the PDO",
        0x0604_0042 => "the PDO would be too long",
        0x0607_0010..=0x0607_0013 => "another length is expected",
        NO_SUBINDEX => "no such subindex",
        0x0609_0030..=0x0609_0032 => "outside of the object's range",
        0x0800_0020..=0x0800_0022 => "not in the present state of the node",
        _ => "refused",
    };
    format!("{words} (abort code {code:#010x})")
}

/// Asks nodes on a link.
#[derive(Debug)]
pub struct SdoClient<'a, L> {
    pub(super) link: &'a mut L,
}

impl<'a, L: Link> SdoClient<'a, L> {
    /// A client; what has come on the link before is left out.
    pub fn new(link: &'a mut L) -> Self {
        Self { link }
    }

    /// The octets of an object.
    ///
    /// # Errors
    /// [`SdoError`]
    pub fn read(&mut self, node: u8, (index, subindex): (u16, u8)) -> Result<Vec<u8>, SdoError> {
        self.repeated(|client| client.upload(node, (index, subindex)))
    }

    /// An object of up to 4 octets as an unsigned number.
    ///
    /// # Errors
    /// [`SdoError`]
    pub fn number(&mut self, node: u8, object: (u16, u8)) -> Result<u32, SdoError> {
        let octets = self.read(node, object)?;
        let mut number = [0; 4];
        number.get_mut(..octets.len()).ok_or(SdoError::Damaged)?.copy_from_slice(&octets);
        Ok(u32::from_le_bytes(number))
    }

    /// Writes an object.
    ///
    /// # Errors
    /// [`SdoError`]
    pub fn write(&mut self, node: u8, object: (u16, u8), octets: &[u8]) -> Result<(), SdoError> {
        self.repeated(|client| client.download(node, object, octets))
    }

    fn repeated<T>(&mut self, mut f: impl FnMut(&mut Self) -> Result<T, SdoError>) -> Result<T, SdoError> {
        let mut result = f(self);
        for _ in 1..TRIES {
            if !matches!(result, Err(SdoError::Silent | SdoError::Damaged)) {
                break;
            }
            result = f(self);
        }
        result
    }

    fn upload(&mut self, node: u8, object: (u16, u8)) -> Result<Vec<u8>, SdoError> {
        let answer = self.ask(node, initiate(0x40, object, &[]), Some(object))?;
        let (command, data) = (answer[0], &answer[4..]);
        match (command >> 5, command >> 1 & 1) {
            (2, 1) => {
                Ok(data[..4 - usize::from(if command & 1 == 1 { command >> 2 & 3 } else { 0 })].to_vec())
            }
            (2, _) => self.segments(node),
            _ => Err(SdoError::Damaged),
        }
    }

    fn segments(&mut self, node: u8) -> Result<Vec<u8>, SdoError> {
        let (mut octets, mut toggle) = (Vec::new(), 0);
        while octets.len() < LONGEST {
            let answer = self.ask(node, [0x60 | toggle, 0, 0, 0, 0, 0, 0, 0], None)?;
            if answer[0] & 0xf0 != toggle {
                break;
            }
            octets.extend(&answer[1..8 - usize::from(answer[0] >> 1 & 7)]);
            if answer[0] & 1 == 1 {
                return Ok(octets);
            }
            toggle ^= 0x10;
        }
        self.give_up(node)
    }

    fn download(&mut self, node: u8, object: (u16, u8), octets: &[u8]) -> Result<(), SdoError> {
        if (1..=4).contains(&octets.len()) {
            let command = 0x23 | (4 - octets.len() as u8) << 2;
            let answer = self.ask(node, initiate(command, object, octets), Some(object))?;
            return if answer[0] == 0x60 { Ok(()) } else { Err(SdoError::Damaged) };
        }
        let length = (octets.len() as u32).to_le_bytes();
        let answer = self.ask(node, initiate(0x21, object, &length), Some(object))?;
        if answer[0] != 0x60 {
            return Err(SdoError::Damaged);
        }
        let (count, mut toggle) = (octets.len().div_ceil(7).max(1), 0);
        for k in 0..count {
            let part = &octets[7 * k..octets.len().min(7 * k + 7)];
            let mut request = [0; 8];
            request[0] = toggle | (7 - part.len() as u8) << 1 | u8::from(k + 1 == count);
            request[1..=part.len()].copy_from_slice(part);
            if self.ask(node, request, None)?[0] != 0x20 | toggle {
                return self.give_up(node);
            }
            toggle ^= 0x10;
        }
        Ok(())
    }

    fn give_up<T>(&mut self, node: u8) -> Result<T, SdoError> {
        let abort = initiate(0x80, (0, 0), &GENERAL.to_le_bytes());
        self.link.send(&[Frame::new(0x600 + u16::from(node), &abort)])?;
        Err(SdoError::Damaged)
    }

    /// Sends a request; the node's answer, which concerns `object` where one is said.
    fn ask(&mut self, node: u8, request: [u8; 8], object: Option<(u16, u8)>) -> Result<[u8; 8], SdoError> {
        let now = self.link.now();
        while self.link.receive(now)?.is_some() {}
        self.link.send(&[Frame::new(0x600 + u16::from(node), &request)])?;
        let deadline = self.link.now() + PATIENCE;
        while let Some(frame) = self.link.receive(deadline)? {
            let Some(answer) =
                frame.octets().first_chunk::<8>().filter(|_| frame.id() == 0x580 + u16::from(node))
            else {
                continue;
            };
            let [command, low, high, subindex, data @ ..] = *answer;
            let of = (u16::from_le_bytes([low, high]), subindex);
            if command == 0x80 {
                return Err(SdoError::Abort(u32::from_le_bytes(data)));
            }
            // One to an earlier request that was repeated may come late.
            if object.is_none_or(|object| object == of) {
                return Ok(*answer);
            }
        }
        Err(SdoError::Silent)
    }

    /// Whether another node of this identifier answers what was asked last: two frames in place of one.
    ///
    /// # Errors
    /// Of the operating system.
    pub(super) fn answers_twice(&mut self, node: u8, patience: u64) -> io::Result<bool> {
        let deadline = self.link.now() + patience;
        while let Some(frame) = self.link.receive(deadline)? {
            if frame.id() == 0x580 + u16::from(node) {
                return Ok(true);
            }
        }
        Ok(false)
    }
}

fn initiate(command: u8, (index, subindex): (u16, u8), data: &[u8]) -> [u8; 8] {
    let [low, high] = index.to_le_bytes();
    let mut request = [command, low, high, subindex, 0, 0, 0, 0];
    request[4..4 + data.len()].copy_from_slice(data);
    request
}
