//! Where objects stand in the process data of a device.

/// Place of an entry in a device's object dictionary.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct ObjectAddress {
    /// Index.
    pub index: u16,
    /// Subindex.
    pub subindex: u8,
}

/// An object that the cycle needs is not in the process data of its device.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{device}: object {:#06x}:{:02x} is not in its process data at a whole octet", object.index, object.subindex)]
pub struct NotMapped {
    /// Name of the device.
    pub device: String,
    /// The object.
    pub object: ObjectAddress,
}

/// Entries of a device's inputs or outputs, in the order of their mapping.
#[derive(Debug, Clone, Default)]
pub(crate) struct Mapping {
    /// Object and length, bits; a gap has index 0.
    entries: Vec<(ObjectAddress, u8)>,
}

/// An object in the process data: its first octet and its length in octets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Field {
    start: usize,
    length: usize,
}

impl Mapping {
    /// Adds an entry as in a PDO mapping object: index, subindex, length in bits.
    pub(crate) fn push(&mut self, entry: u32) {
        let address = ObjectAddress { index: (entry >> 16) as u16, subindex: (entry >> 8) as u8 };
        self.entries.push((address, entry as u8));
    }

    /// Octets of all entries.
    pub(crate) fn length(&self) -> usize {
        let bits: usize = self.entries.iter().map(|(_, bits)| usize::from(*bits)).sum();
        bits.div_ceil(8)
    }

    /// The place of an object, where it is mapped with one of these lengths, octets, at a whole octet.
    pub(crate) fn find(&self, desired: ObjectAddress, lengths: &[usize]) -> Option<Field> {
        let mut start = 0;
        for (address, bits) in &self.entries {
            let (bits, whole) = (usize::from(*bits), start % 8 == 0);
            if *address == desired && whole && lengths.iter().any(|length| 8 * length == bits) {
                return Some(Field { start: start / 8, length: bits / 8 });
            }
            start += bits;
        }
        None
    }

    /// As [`find`](Self::find).
    ///
    /// # Errors
    /// [`NotMapped`] names device and object.
    pub(crate) fn require(
        &self,
        device: &str,
        desired: ObjectAddress,
        lengths: &[usize],
    ) -> Result<Field, NotMapped> {
        let missing = || NotMapped { device: device.to_owned(), object: desired };
        self.find(desired, lengths).ok_or_else(missing)
    }
}

impl Field {
    /// The signed number at this place; none beyond the data.
    pub(crate) fn signed(self, data: &[u8]) -> Option<i32> {
        let bytes = data.get(self.start..self.start + self.length)?;
        Some(match *bytes {
            [a] => i32::from(a.cast_signed()),
            [a, b] => i32::from(i16::from_le_bytes([a, b])),
            [a, b, c, d] => i32::from_le_bytes([a, b, c, d]),
            _ => return None,
        })
    }

    /// The 16 lower bits at this place; none beyond the data.
    pub(crate) fn word(self, data: &[u8]) -> Option<u16> {
        self.signed(data).map(|number| number as u16)
    }

    /// Writes a number, limited to the field.
    pub(crate) fn write(self, data: &mut [u8], number: i32) {
        let Some(bytes) = data.get_mut(self.start..self.start + self.length) else { return };
        let bits = 8 * self.length.min(4);
        let most = i32::MAX >> (32 - bits);
        let limited = number.clamp(-most - 1, most).to_le_bytes();
        bytes.iter_mut().zip(limited).for_each(|(byte, new)| *byte = new);
    }

    /// Writes bits.
    pub(crate) fn write_word(self, data: &mut [u8], word: u16) {
        let Some(bytes) = data.get_mut(self.start..self.start + self.length) else { return };
        bytes.iter_mut().zip(word.to_le_bytes()).for_each(|(byte, new)| *byte = new);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn object(index: u16, subindex: u8) -> ObjectAddress {
        ObjectAddress { index, subindex }
    }

    #[test]
    fn objects_are_found_behind_those_mapped_before_and_not_between_octets() {
        let mut mapping = Mapping::default();
        for entry in
            [0x6041_0010, 0x6064_0020, 0x6000_0101, 0x0000_0007, 0x6061_0008, 0x6000_0204, 0x6077_0010]
        {
            mapping.push(entry);
        }
        assert_eq!(mapping.length(), 11);
        assert_eq!(mapping.find(object(0x6064, 0), &[4]), Some(Field { start: 2, length: 4 }));
        assert_eq!(mapping.find(object(0x6061, 0), &[1, 2]), Some(Field { start: 7, length: 1 }));
        assert_eq!(mapping.find(object(0x6064, 0), &[2]), None, "of another length");
        assert_eq!(mapping.find(object(0x6077, 0), &[2]), None, "not at a whole octet");
        assert!(mapping.require("drive", object(0x606c, 0), &[4]).is_err());
    }

    #[test]
    fn numbers_are_written_within_their_field_and_read_back() {
        let mut data = [0_u8; 8];
        let field = |start, length| Field { start, length };
        field(0, 2).write(&mut data, 70_000);
        field(2, 4).write(&mut data, i32::MIN);
        field(6, 1).write(&mut data, -300);
        assert_eq!(field(0, 2).signed(&data), Some(i32::from(i16::MAX)));
        assert_eq!(field(2, 4).signed(&data), Some(i32::MIN));
        assert_eq!(field(6, 1).signed(&data), Some(-128));
        field(6, 2).write_word(&mut data, 0xbeef);
        assert_eq!(field(6, 2).word(&data), Some(0xbeef));
        assert_eq!(field(6, 4).signed(&data), None, "beyond the data");
    }
}
