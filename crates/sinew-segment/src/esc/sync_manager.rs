//! One sync manager: consistent exchange between master and firmware, through three buffers or one mailbox.
//!
//! The second and third buffer are not part of the address space here; in a real device they follow the
//! first. Source: ETG.1000.4, 6.7 and table 58, 59.

use crate::bytes::u16_at;

/// Mode in the control octet.
const MODE: u8 = 0x03;
const MODE_MAILBOX: u8 = 0x02;
/// Direction in the control octet: the master writes.
const MASTER_WRITES: u8 = 0x04;
const WATCHDOG: u8 = 0x40;
/// Status octet.
const WRITTEN: u8 = 0x01;
const READ: u8 = 0x02;
const FULL: u8 = 0x08;
const NO_BUFFER: u8 = 0x30;

/// A sync manager that is switched on, or not.
#[derive(Debug, Clone, Default)]
pub(crate) struct SyncManager {
    /// First octet in memory.
    pub(crate) start: u16,
    /// Octets.
    pub(crate) length: u16,
    /// Control octet as written.
    pub(crate) control: u8,
    /// Switched on by the master.
    pub(crate) enabled: bool,
    buffers: [Vec<u8>; 3],
    /// Which buffer the writer fills, which is the newest complete one, which the reader has.
    filling: u8,
    newest: Option<u8>,
    reading: u8,
    write_open: bool,
    read_open: bool,
    full: bool,
    status: u8,
    /// The master has completed a write since the firmware looked.
    pub(crate) arrived: bool,
    /// The firmware has put new data that the master has not read.
    pub(crate) offered: bool,
}

impl SyncManager {
    /// Takes over its registers: start, length, control, status, activation.
    pub(crate) fn configure(&mut self, octets: &[u8]) {
        let enabled = octets.get(6).is_some_and(|activation| activation & 1 != 0);
        if enabled == self.enabled {
            return;
        }
        let buffers = core::mem::take(&mut self.buffers);
        *self = Self {
            start: u16_at(octets, 0),
            length: u16_at(octets, 2),
            control: octets.get(4).copied().unwrap_or(0),
            enabled,
            buffers,
            ..Self::default()
        };
        // 0, 1 and 2 in some order, always.
        (self.filling, self.reading, self.status) = (0, 1, NO_BUFFER);
        if enabled {
            for buffer in &mut self.buffers {
                buffer.clear();
                buffer.resize(usize::from(self.length), 0);
            }
        }
    }

    pub(crate) fn is_mailbox(&self) -> bool {
        self.control & MODE == MODE_MAILBOX
    }

    pub(crate) fn master_writes(&self) -> bool {
        self.control & MASTER_WRITES != 0
    }

    pub(crate) fn has_watchdog(&self) -> bool {
        self.control & WATCHDOG != 0
    }

    /// The offset in the manager's area of an address, where it covers it.
    pub(crate) fn covers(&self, address: u32) -> Option<usize> {
        let start = u32::from(self.start);
        (self.enabled && address >= start && address < start + u32::from(self.length))
            .then(|| (address - start) as usize)
    }

    pub(crate) fn is_full(&self) -> bool {
        self.full
    }

    /// Status octet.
    pub(crate) fn status(&self) -> u8 {
        let full = if self.full { FULL } else { 0 };
        self.status | full | u8::from(self.read_open) << 6 | u8::from(self.write_open) << 7
    }

    /// The master writes part of the area; false where the manager does not let it.
    pub(crate) fn master_write(&mut self, offset: usize, data: &[u8]) -> bool {
        if !self.master_writes() || (self.is_mailbox() && self.full) {
            return false;
        }
        self.write(offset, data)
    }

    /// The master reads part of the area; false where the manager does not let it.
    pub(crate) fn master_read(&mut self, offset: usize, data: &mut [u8]) -> bool {
        if self.master_writes() || (self.is_mailbox() && !self.full) {
            return false;
        }
        self.read(offset, data)
    }

    /// What a mailbox read once more contains, or the master's own outputs: no effect.
    pub(crate) fn peek(&self) -> &[u8] {
        &self.buffers[usize::from(self.newest.unwrap_or(0))]
    }

    fn write(&mut self, offset: usize, data: &[u8]) -> bool {
        if offset == 0 {
            self.write_open = true;
            self.status &= !READ;
        }
        let buffer = &mut self.buffers[usize::from(self.filling)];
        let Some(place) = buffer.get_mut(offset..offset + data.len()).filter(|_| self.write_open) else {
            return false;
        };
        place.copy_from_slice(data);
        if offset + data.len() == usize::from(self.length) {
            self.complete();
        }
        true
    }

    /// The last octet was written: the buffer becomes the newest.
    fn complete(&mut self) {
        self.write_open = false;
        let written = self.filling;
        self.newest = Some(written);
        self.status = self.status & !NO_BUFFER | written << 4 | WRITTEN;
        if self.is_mailbox() {
            self.full = true;
        } else {
            // The third buffer is the one that is neither the newest nor in the reader's hand.
            self.filling =
                3 - written - if self.reading == written { (written + 1) % 3 } else { self.reading };
        }
        if self.master_writes() {
            self.arrived = true;
        } else {
            self.offered = true;
        }
    }

    fn read(&mut self, offset: usize, data: &mut [u8]) -> bool {
        if offset == 0 {
            let Some(newest) = self.newest else { return false };
            self.reading = newest;
            if self.filling == newest && !self.is_mailbox() {
                self.filling = (newest + 1) % 3;
            }
            self.read_open = true;
            self.status &= !WRITTEN;
        }
        let buffer = &self.buffers[usize::from(self.reading)];
        let Some(place) = buffer.get(offset..offset + data.len()).filter(|_| self.read_open) else {
            return false;
        };
        data.copy_from_slice(place);
        if offset + data.len() == usize::from(self.length) {
            self.read_open = false;
            self.status |= READ;
            self.full = false;
            self.offered = false;
        }
        true
    }

    /// The firmware takes the newest data of the master.
    pub(crate) fn take(&mut self) -> &[u8] {
        self.arrived = false;
        self.status &= !WRITTEN;
        self.full = false;
        if let Some(newest) = self.newest {
            self.reading = newest;
        }
        &self.buffers[usize::from(self.reading)]
    }

    /// The firmware's buffer for the master, to be filled and then passed on with [`Self::offer`].
    pub(crate) fn buffer(&mut self) -> &mut [u8] {
        &mut self.buffers[usize::from(self.filling)]
    }

    /// Passes the filled buffer on to the master.
    pub(crate) fn offer(&mut self) {
        if self.enabled {
            self.complete();
        }
    }
}
