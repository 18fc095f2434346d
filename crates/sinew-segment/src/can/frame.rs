/// A frame of classical CAN with an identifier of 11 bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct CanFrame {
    id: u16,
    length: u8,
    remote: bool,
    data: [u8; 8],
}

impl CanFrame {
    /// A data frame; of the identifier 11 bits count, of the octets the first 8.
    #[must_use]
    pub fn new(id: u16, octets: &[u8]) -> Self {
        let (mut data, length) = ([0; 8], octets.len().min(8));
        data[..length].copy_from_slice(&octets[..length]);
        Self { id: id & 0x7ff, length: length as u8, remote: false, data }
    }

    /// A remote frame, which asks for the data frame of its identifier with so many octets, 0 to 8.
    #[must_use]
    pub fn remote(id: u16, length: usize) -> Self {
        Self { id: id & 0x7ff, length: length.min(8) as u8, remote: true, data: [0; 8] }
    }

    /// Whether it asks for data and carries none.
    #[must_use]
    pub fn is_remote(&self) -> bool {
        self.remote
    }

    /// Octets that it carries or asks for.
    #[must_use]
    pub fn length(&self) -> usize {
        usize::from(self.length)
    }

    /// Identifier.
    #[must_use]
    pub fn id(&self) -> u16 {
        self.id
    }

    /// The octets that it carries.
    #[must_use]
    pub fn octets(&self) -> &[u8] {
        if self.remote { &[] } else { &self.data[..usize::from(self.length)] }
    }

    /// Bits that it takes on the wire, at most: with stuffed bits and the pause behind it.
    #[must_use]
    pub fn bits(&self) -> u64 {
        let octets = self.octets().len() as u64;
        47 + 8 * octets + (33 + 8 * octets) / 4
    }
}
