/// A frame of classical CAN with an identifier of 11 bits, or of CAN FD with one of up to 16.
///
/// Frames of CAN FD switch to [`DATA_RATE`](Self::DATA_RATE) for their octets; their identifier is sent with
/// 29 bits where it does not fit into 11.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CanFrame {
    id: u16,
    length: u8,
    kind: Kind,
    data: [u8; 64],
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Data,
    Remote,
    Fd,
}

/// Numbers of octets that a frame of CAN FD can carry, by their code.
const LENGTHS: [usize; 16] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64];
/// The largest identifier of 11 bits.
const SHORT: u16 = 0x7ff;

impl CanFrame {
    /// Rate of the octets of CAN FD, bit/s.
    pub const DATA_RATE: u32 = 5_000_000;

    /// A data frame; of the identifier 11 bits count, of the octets the first 8.
    #[must_use]
    pub fn new(id: u16, octets: &[u8]) -> Self {
        Self::of(id & SHORT, Kind::Data, &octets[..octets.len().min(8)])
    }

    /// A remote frame, which asks for the data frame of its identifier with so many octets, 0 to 8.
    #[must_use]
    pub fn remote(id: u16, length: usize) -> Self {
        Self { length: length.min(8) as u8, ..Self::of(id & SHORT, Kind::Remote, &[]) }
    }

    /// A frame of CAN FD; of the octets the first 64 count, and zeros follow to the next length that there
    /// is.
    #[must_use]
    pub fn fd(id: u16, octets: &[u8]) -> Self {
        let octets = &octets[..octets.len().min(64)];
        let length = Self::fd_length(octets.len());
        Self { length: length as u8, ..Self::of(id, Kind::Fd, octets) }
    }

    /// The octets that a frame of CAN FD carries with at least so many, 0 to 64.
    #[must_use]
    pub fn fd_length(least: usize) -> usize {
        LENGTHS.into_iter().find(|length| *length >= least).unwrap_or(64)
    }

    fn of(id: u16, kind: Kind, octets: &[u8]) -> Self {
        let mut data = [0; 64];
        data[..octets.len()].copy_from_slice(octets);
        Self { id, length: octets.len() as u8, kind, data }
    }

    /// Whether it asks for data and carries none.
    #[must_use]
    pub fn is_remote(&self) -> bool {
        self.kind == Kind::Remote
    }

    /// Whether it is one of CAN FD.
    #[must_use]
    pub fn is_fd(&self) -> bool {
        self.kind == Kind::Fd
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
        if self.is_remote() { &[] } else { &self.data[..usize::from(self.length)] }
    }

    /// Time that it takes on a bus of a rate, bit/s, at most, ns: with stuffed bits and the pause behind it.
    #[must_use]
    pub fn time(&self, bitrate: u32) -> u64 {
        let octets = self.octets().len() as u64;
        let of = |bits: u64, rate: u32| bits * 1_000_000_000 / u64::from(rate.max(1));
        if !self.is_fd() {
            return of(47 + 8 * octets + (33 + 8 * octets) / 4, bitrate);
        }
        // ISO 11898-1: identifier and end at the rate of the bus; length, octets and checksum, which has
        // stuffed bits at fixed places, at that of the data.
        let head: u64 = if self.id > SHORT { 36 } else { 17 };
        let data = 5 + 8 * octets;
        let checksum = if octets > 16 { 32 } else { 27 };
        of(head + head / 4 + 12, bitrate) + of(data + data / 4 + checksum, Self::DATA_RATE)
    }
}
