//! The EEPROM behind its registers: read, write, reload, and what is refused.
//!
//! Source: ETG.1000.4, 6.4 and table 49 to 53.

use crate::bytes::u32_at;

/// Command in the high octet of the control register.
const COMMAND: u16 = 0x0700;
const READ: u16 = 0x0100;
const WRITE: u16 = 0x0200;
const RELOAD: u16 = 0x0400;
/// Write enable, valid for the write command of the same datagram.
const WRITE_ENABLE: u16 = 0x0001;
/// Eight octets are read at once; addresses have two octets.
const WIDE: u16 = 0x00c0;
const CHECKSUM_ERROR: u16 = 0x0800;
const COMMAND_ERROR: u16 = 0x2000;
const WRITE_ERROR: u16 = 0x4000;
const BUSY: u16 = 0x8000;

/// The memory and the state of its interface.
#[derive(Debug, Clone)]
pub(crate) struct Eeprom {
    image: Vec<u8>,
    errors: u16,
    busy_until: u64,
    access_ns: u64,
}

/// What a command leaves in the data register, or asks of the controller.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Outcome {
    Nothing,
    Data([u8; 8]),
    Reload,
}

impl Eeprom {
    pub(crate) fn new(image: Vec<u8>, access_ns: u64) -> Self {
        Self { image, errors: 0, busy_until: 0, access_ns }
    }

    pub(crate) fn image(&self) -> &[u8] {
        &self.image
    }

    pub(crate) fn image_mut(&mut self) -> &mut [u8] {
        &mut self.image
    }

    pub(crate) fn is_busy(&self, now: u64) -> bool {
        now < self.busy_until
    }

    /// Control register as read.
    pub(crate) fn status(&self, now: u64) -> u16 {
        WIDE | self.errors | if self.is_busy(now) { BUSY } else { 0 }
    }

    /// The checksum of the configuration area is wrong.
    pub(crate) fn set_checksum_error(&mut self, wrong: bool) {
        self.errors = if wrong { self.errors | CHECKSUM_ERROR } else { self.errors & !CHECKSUM_ERROR };
    }

    /// The control register was written.
    pub(crate) fn command(&mut self, control: u16, address: &[u8], data: &[u8], now: u64) -> Outcome {
        self.errors &= CHECKSUM_ERROR;
        let place = 2 * u64::from(u32_at(address, 0));
        match control & COMMAND {
            0 => return Outcome::Nothing,
            READ => {
                self.busy_until = now + self.access_ns;
                if let Some(found) = self.octets(place, 8) {
                    return Outcome::Data(found);
                }
            }
            WRITE => {
                if control & WRITE_ENABLE == 0 {
                    self.errors |= WRITE_ERROR;
                    return Outcome::Nothing;
                }
                self.busy_until = now + self.access_ns;
                let start = usize::try_from(place).unwrap_or(usize::MAX);
                let end = start.saturating_add(2);
                if let (Some(word), Some(new)) = (self.image.get_mut(start..end), data.get(..2)) {
                    word.copy_from_slice(new);
                    return Outcome::Nothing;
                }
            }
            RELOAD => {
                self.busy_until = now + self.access_ns;
                return Outcome::Reload;
            }
            _ => {}
        }
        self.errors |= COMMAND_ERROR;
        Outcome::Nothing
    }

    /// Octets at a place; behind the end there are ones.
    fn octets(&self, place: u64, count: usize) -> Option<[u8; 8]> {
        let start = usize::try_from(place).ok().filter(|start| *start < self.image.len())?;
        let mut found = [0xff; 8];
        let available = count.min(self.image.len() - start);
        found[..available].copy_from_slice(&self.image[start..start + available]);
        Some(found)
    }
}
