//! The server of SDO transfers: expedited, normal and segmented, up and down.
//!
//! Source: ETG.1000.6, 5.6.2.

use super::access::{read, read_all, write, write_all};
use super::{Abort, SDO_REQUEST, SDO_RESPONSE};
use crate::al::AlState;
use crate::bytes::{u16_at, u32_at};
use crate::dictionary::Dictionary;

/// Command specifiers of requests, in the three highest bits.
const DOWNLOAD_SEGMENT: u8 = 0;
const DOWNLOAD: u8 = 1;
const UPLOAD: u8 = 2;
const UPLOAD_SEGMENT: u8 = 3;
const ABORT: u8 = 4;
/// Flags of an initiating request.
const SIZE_INDICATED: u8 = 0x01;
const EXPEDITED: u8 = 0x02;
const COMPLETE: u8 = 0x10;
/// Flags of a segment.
const LAST: u8 = 0x01;
const TOGGLE: u8 = 0x10;

/// CoE header, command, index, subindex, four octets of data or size.
const INITIATE_LENGTH: usize = 10;
/// CoE header and command.
const SEGMENT_HEADER: usize = 3;
/// The longest value that is taken in segments.
const MAX_OCTETS: u32 = 1 << 16;

#[derive(Debug, Clone)]
struct Target {
    index: u16,
    subindex: u8,
    complete: bool,
}

#[derive(Debug, Clone)]
enum Transfer {
    Upload { data: Vec<u8>, sent: usize, toggle: bool },
    Download { target: Target, data: Vec<u8>, expected: usize, toggle: bool },
}

/// One transfer at a time.
#[derive(Debug, Clone, Default)]
pub(crate) struct SdoServer {
    transfer: Option<Transfer>,
}

impl SdoServer {
    /// The answer to a request, both with CoE header; none to an abort of the master. `room` is the largest
    /// answer.
    pub(crate) fn answer(
        &mut self,
        dictionary: &mut Dictionary,
        state: AlState,
        complete_access: bool,
        request: &[u8],
        room: usize,
    ) -> Option<Vec<u8>> {
        let command = request.get(2).copied().unwrap_or(0);
        let target = Target {
            index: u16_at(request, 3),
            subindex: request.get(5).copied().unwrap_or(0),
            complete: command & COMPLETE != 0,
        };
        let initiates = matches!(command >> 5, DOWNLOAD | UPLOAD);
        let result = if initiates && target.complete && !complete_access {
            Err(Abort::UnsupportedAccess)
        } else {
            match command >> 5 {
                DOWNLOAD => self.download(dictionary, state, command, &target, request),
                DOWNLOAD_SEGMENT => self.download_segment(dictionary, state, command, request),
                UPLOAD => self.upload(dictionary, &target, room),
                UPLOAD_SEGMENT => self.upload_segment(command, room),
                ABORT => {
                    self.transfer = None;
                    return None;
                }
                _ => Err(Abort::Command),
            }
        };
        Some(result.unwrap_or_else(|abort| {
            self.transfer = None;
            aborted(&target, abort)
        }))
    }

    fn upload(&mut self, dictionary: &Dictionary, target: &Target, room: usize) -> Result<Vec<u8>, Abort> {
        self.transfer = None;
        let data = if target.complete {
            read_all(dictionary, target.index, target.subindex)?
        } else {
            read(dictionary, target.index, target.subindex)?
        };
        let complete = if target.complete { COMPLETE } else { 0 };
        if (1..=4).contains(&data.len()) {
            let unused = (4 - data.len() as u8) << 2;
            let mut answer = initiated(UPLOAD << 5 | complete | unused | EXPEDITED | SIZE_INDICATED, target);
            answer[6..6 + data.len()].copy_from_slice(&data);
            return Ok(answer);
        }
        let mut answer = initiated(UPLOAD << 5 | complete | SIZE_INDICATED, target);
        answer[6..10].copy_from_slice(&(data.len() as u32).to_le_bytes());
        let sent = data.len().min(room.saturating_sub(INITIATE_LENGTH));
        answer.extend(&data[..sent]);
        if sent < data.len() {
            self.transfer = Some(Transfer::Upload { data, sent, toggle: false });
        }
        Ok(answer)
    }

    fn upload_segment(&mut self, command: u8, room: usize) -> Result<Vec<u8>, Abort> {
        let Some(Transfer::Upload { data, sent, toggle }) = &mut self.transfer else {
            return Err(Abort::Command);
        };
        if (command & TOGGLE != 0) != *toggle {
            return Err(Abort::Toggle);
        }
        let rest = &data[*sent..];
        let now = rest.len().min(room.saturating_sub(SEGMENT_HEADER).max(7));
        let last = now == rest.len();
        // Fewer than seven octets are filled up to seven, with the number of unused ones.
        let unused = 7_usize.saturating_sub(now);
        let flags = u8::from(*toggle) << 4 | (unused as u8) << 1 | u8::from(last);
        let mut answer = coe_header(SDO_RESPONSE);
        answer.push(flags);
        answer.extend(&rest[..now]);
        answer.resize(answer.len() + unused, 0);
        (*sent, *toggle) = (*sent + now, !*toggle);
        if last {
            self.transfer = None;
        }
        Ok(answer)
    }

    fn download(
        &mut self,
        dictionary: &mut Dictionary,
        state: AlState,
        command: u8,
        target: &Target,
        request: &[u8],
    ) -> Result<Vec<u8>, Abort> {
        self.transfer = None;
        let rest = request.get(6..).unwrap_or_default();
        if command & EXPEDITED != 0 {
            let unused = if command & SIZE_INDICATED != 0 { usize::from(command >> 2 & 3) } else { 0 };
            let data = rest.get(..4 - unused).ok_or(Abort::Length)?;
            store(dictionary, state, target, data, command & SIZE_INDICATED == 0)?;
            return Ok(initiated(3 << 5, target));
        }
        let expected = u32_at(rest, 0);
        if expected > MAX_OCTETS {
            return Err(Abort::Memory);
        }
        let (expected, data) = (expected as usize, rest.get(4..).unwrap_or_default());
        if data.len() >= expected {
            store(dictionary, state, target, &data[..expected], false)?;
        } else {
            let (target, data) = (target.clone(), data.to_vec());
            self.transfer = Some(Transfer::Download { target, data, expected, toggle: false });
        }
        Ok(initiated(3 << 5, target))
    }

    fn download_segment(
        &mut self,
        dictionary: &mut Dictionary,
        state: AlState,
        command: u8,
        request: &[u8],
    ) -> Result<Vec<u8>, Abort> {
        let Some(Transfer::Download { target, data, expected, toggle }) = &mut self.transfer else {
            return Err(Abort::Command);
        };
        if (command & TOGGLE != 0) != *toggle {
            return Err(Abort::Toggle);
        }
        let segment = request.get(SEGMENT_HEADER..).unwrap_or_default();
        let unused = if segment.len() == 7 { usize::from(command >> 1 & 7) } else { 0 };
        data.extend(&segment[..segment.len() - unused]);
        if data.len() > *expected {
            return Err(Abort::Length);
        }
        let mut answer = coe_header(SDO_RESPONSE);
        answer.push(1 << 5 | u8::from(*toggle) << 4);
        answer.resize(INITIATE_LENGTH, 0);
        *toggle = !*toggle;
        if command & LAST != 0 {
            if data.len() != *expected {
                return Err(Abort::Length);
            }
            let (target, data) = (target.clone(), core::mem::take(data));
            self.transfer = None;
            store(dictionary, state, &target, &data, false)?;
        }
        Ok(answer)
    }
}

/// `cut`: the request does not say its size; the type does.
fn store(
    dictionary: &mut Dictionary,
    state: AlState,
    target: &Target,
    data: &[u8],
    cut: bool,
) -> Result<(), Abort> {
    if target.complete {
        return write_all(dictionary, state, target.index, target.subindex, data);
    }
    let capacity =
        dictionary.entry(target.index, target.subindex).map_or(data.len(), |entry| entry.capacity());
    let data = if cut { &data[..data.len().min(capacity)] } else { data };
    write(dictionary, state, target.index, target.subindex, data)
}

/// A CoE header with its service.
pub(super) fn coe_header(service: u8) -> Vec<u8> {
    vec![0, service << 4]
}

fn initiated(command: u8, target: &Target) -> Vec<u8> {
    let mut answer = coe_header(SDO_RESPONSE);
    answer.push(command);
    answer.extend(target.index.to_le_bytes());
    answer.push(target.subindex);
    answer.extend([0; 4]);
    answer
}

/// An abort is a request in both directions.
fn aborted(target: &Target, abort: Abort) -> Vec<u8> {
    let mut answer = initiated(ABORT << 5, target);
    answer[1] = SDO_REQUEST << 4;
    answer[6..10].copy_from_slice(&abort.number().to_le_bytes());
    answer
}
