//! One fieldbus memory management unit: where logical memory lies in the device.
//!
//! Source: ETG.1000.4, 6.6 and table 56.

use crate::bytes::{u16_at, u32_at};

/// A unit as its sixteen octets say.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Fmmu {
    logical: u32,
    length: u16,
    first_bit: u8,
    last_bit: u8,
    pub(crate) physical: u16,
    physical_bit: u8,
    pub(crate) reads: bool,
    pub(crate) writes: bool,
}

/// The part of a datagram that a unit maps: octets of the datagram, and the offset in the unit's own area.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Window {
    pub(crate) start: usize,
    pub(crate) end: usize,
    pub(crate) offset: usize,
}

/// One octet of the datagram in a bitwise mapping: which bits, and which bit of the device the first is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct BitRun {
    pub(crate) octet: usize,
    pub(crate) bit: u8,
    pub(crate) physical: u32,
    pub(crate) physical_bit: u8,
}

impl Fmmu {
    /// The unit where it is switched on.
    pub(crate) fn parse(octets: &[u8]) -> Option<Self> {
        let octet = |at: usize| octets.get(at).copied().unwrap_or(0);
        let fmmu = Self {
            logical: u32_at(octets, 0),
            length: u16_at(octets, 4),
            first_bit: octet(6) & 7,
            last_bit: octet(7) & 7,
            physical: u16_at(octets, 8),
            physical_bit: octet(10) & 7,
            reads: octet(11) & 1 != 0,
            writes: octet(11) & 2 != 0,
        };
        (octet(12) & 1 != 0 && fmmu.length > 0).then_some(fmmu)
    }

    /// Whole octets are mapped to whole octets.
    pub(crate) fn is_bytewise(&self) -> bool {
        self.first_bit == 0 && self.last_bit == 7 && self.physical_bit == 0
    }

    /// What a datagram of `length` octets at `logical` has in common with the unit.
    pub(crate) fn window(&self, logical: u32, length: usize) -> Option<Window> {
        let (first, own) = (u64::from(logical), u64::from(self.logical));
        let start = first.max(own);
        let end = (first + length as u64).min(own + u64::from(self.length));
        (start < end).then(|| Window {
            start: (start - first) as usize,
            end: (end - first) as usize,
            offset: (start - own) as usize,
        })
    }

    /// The mapped bits of a window, in the order in which they are stored.
    pub(crate) fn bits(self, window: Window) -> impl Iterator<Item = BitRun> {
        let last_octet = usize::from(self.length) - 1;
        (window.start..window.end).flat_map(move |octet| {
            let own = window.offset + (octet - window.start);
            let first = if own == 0 { self.first_bit } else { 0 };
            let last = if own == last_octet { self.last_bit } else { 7 };
            (first..=last.max(first)).filter(move |bit| *bit <= last).map(move |bit| {
                let index = 8 * own as u32 + u32::from(bit) - u32::from(self.first_bit)
                    + u32::from(self.physical_bit);
                BitRun {
                    octet,
                    bit,
                    physical: u32::from(self.physical) + index / 8,
                    physical_bit: (index % 8) as u8,
                }
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit(first_bit: u8, last_bit: u8, physical_bit: u8, length: u16) -> Fmmu {
        let mut octets = [0; 16];
        octets[..4].copy_from_slice(&0x1000_u32.to_le_bytes());
        octets[4..6].copy_from_slice(&length.to_le_bytes());
        octets[6..8].copy_from_slice(&[first_bit, last_bit]);
        octets[8..10].copy_from_slice(&0x1100_u16.to_le_bytes());
        octets[10..13].copy_from_slice(&[physical_bit, 3, 1]);
        Fmmu::parse(&octets).unwrap()
    }

    #[test]
    fn a_window_is_the_intersection_even_at_the_end_of_the_address_space() {
        let unit = unit(0, 7, 0, 4);
        assert_eq!(unit.window(0x0ffe, 4), Some(Window { start: 2, end: 4, offset: 0 }));
        assert_eq!(unit.window(0x1002, 9), Some(Window { start: 0, end: 2, offset: 2 }));
        assert_eq!(unit.window(0x1004, 9), None);
        assert_eq!(unit.window(u32::MAX, 9), None);
    }

    #[test]
    fn bits_cross_octets_of_both_sides() {
        // Bits 6 and 7 of one octet and 0 of the next, to bit 7 and on.
        let unit = unit(6, 0, 7, 2);
        let window = unit.window(0x1000, 2).unwrap();
        let found: Vec<_> =
            unit.bits(window).map(|run| (run.octet, run.bit, run.physical, run.physical_bit)).collect();
        assert_eq!(found, [(0, 6, 0x1100, 7), (0, 7, 0x1101, 0), (1, 0, 0x1101, 1)]);
    }
}
