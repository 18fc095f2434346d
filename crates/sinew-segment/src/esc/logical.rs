//! Datagrams with logical addresses: through the memory management units to the device's own addresses.
//!
//! Source: ETG.1000.4, 6.6.

use super::controller::Controller;
use super::fmmu::{Fmmu, Window};

impl Controller {
    /// A datagram with a logical address: reads before it writes, each where `read` and `write` ask for it.
    /// Returns whether anything was read and written.
    pub(crate) fn logical(&mut self, address: u32, data: &mut [u8], read: bool, write: bool) -> (bool, bool) {
        let (mut any_read, mut any_write) = (false, false);
        if write && read {
            for at in 0..self.used_fmmus {
                if let Some((_, window)) = self.mapped(at, address, data.len(), |fmmu| fmmu.writes) {
                    let range = window.start..window.end;
                    if let (Some(kept), Some(data)) = (self.scratch.get_mut(range.clone()), data.get(range)) {
                        kept.copy_from_slice(data);
                    }
                }
            }
        }
        if read {
            for at in 0..self.used_fmmus {
                if let Some((fmmu, window)) = self.mapped(at, address, data.len(), |fmmu| fmmu.reads) {
                    any_read |= self.read_mapped(fmmu, window, data);
                }
            }
        }
        if write {
            let scratch = core::mem::take(&mut self.scratch);
            for at in 0..self.used_fmmus {
                if let Some((fmmu, window)) = self.mapped(at, address, data.len(), |fmmu| fmmu.writes) {
                    let source = if read { &scratch } else { &*data };
                    any_write |= self.write_mapped(fmmu, window, source);
                }
            }
            self.scratch = scratch;
        }
        (any_read, any_write)
    }

    fn mapped(
        &self,
        at: usize,
        address: u32,
        length: usize,
        desired: fn(&Fmmu) -> bool,
    ) -> Option<(Fmmu, Window)> {
        let fmmu = self.fmmus[at].filter(desired)?;
        let window = fmmu.window(address, length)?;
        Some((fmmu, window))
    }

    fn read_mapped(&mut self, fmmu: Fmmu, window: Window, data: &mut [u8]) -> bool {
        if fmmu.is_bytewise() {
            let Some(address) = physical(fmmu, window) else { return false };
            return self.read(address, &mut data[window.start..window.end]);
        }
        let mut any = false;
        let (mut octet, mut loaded) = ([0], None);
        for bit in fmmu.bits(window) {
            let Ok(address) = u16::try_from(bit.physical) else { continue };
            if loaded.is_none_or(|(known, _)| known != address) {
                loaded = Some((address, self.read(address, &mut octet)));
            }
            if loaded.is_some_and(|(_, success)| success) {
                let mask = 1 << bit.bit;
                let set = octet[0] >> bit.physical_bit & 1 == 1;
                data[bit.octet] = if set { data[bit.octet] | mask } else { data[bit.octet] & !mask };
                any = true;
            }
        }
        any
    }

    fn write_mapped(&mut self, fmmu: Fmmu, window: Window, source: &[u8]) -> bool {
        if fmmu.is_bytewise() {
            let Some(address) = physical(fmmu, window) else { return false };
            return self.write(address, source.get(window.start..window.end).unwrap_or_default());
        }
        let mut any = false;
        let mut pending: Option<(u16, u8)> = None;
        for bit in fmmu.bits(window) {
            let Ok(address) = u16::try_from(bit.physical) else { continue };
            if let Some((known, octet)) = pending.filter(|(known, _)| *known != address) {
                any |= self.write(known, &[octet]);
                pending = None;
            }
            let (_, octet) = pending.unwrap_or((address, self.present(address)));
            let mask = 1 << bit.physical_bit;
            let set = source.get(bit.octet).is_some_and(|octet| octet >> bit.bit & 1 == 1);
            pending = Some((address, if set { octet | mask } else { octet & !mask }));
        }
        if let Some((address, octet)) = pending {
            any |= self.write(address, &[octet]);
        }
        any
    }

    /// What an octet holds, so that bits beside those written stay.
    fn present(&self, address: u16) -> u8 {
        let covered = self.managers.iter().find_map(|manager| {
            let offset = manager.covers(u32::from(address))?;
            manager.peek().get(offset).copied()
        });
        covered.or_else(|| self.memory.get(usize::from(address)).copied()).unwrap_or(0)
    }
}

fn physical(fmmu: Fmmu, window: Window) -> Option<u16> {
    u16::try_from(usize::from(fmmu.physical) + window.offset).ok()
}
