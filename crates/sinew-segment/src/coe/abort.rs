//! Why an SDO transfer was aborted. Source: ETG.1000.6, table 41; CiA 301.

/// SDO abort code.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
#[repr(u32)]
pub enum Abort {
    /// The toggle bit did not change.
    Toggle = 0x0503_0000,
    /// The command specifier is unknown or does not fit the transfer.
    Command = 0x0504_0001,
    /// More than the device can hold.
    Memory = 0x0504_0005,
    /// The object does not support this access.
    UnsupportedAccess = 0x0601_0000,
    /// Write-only.
    WriteOnly = 0x0601_0001,
    /// Read-only.
    ReadOnly = 0x0601_0002,
    /// Subindex 0 has to be 0 before the others are written.
    SubindexZero = 0x0601_0003,
    /// No such object.
    NoObject = 0x0602_0000,
    /// The object cannot be mapped into the PDO.
    NotMappable = 0x0604_0041,
    /// Number and length of the mapped objects exceed the PDO.
    PdoLength = 0x0604_0042,
    /// The length does not fit the type.
    Length = 0x0607_0010,
    /// Too long for the type.
    TooLong = 0x0607_0012,
    /// Too short for the type.
    TooShort = 0x0607_0013,
    /// No such subindex.
    NoSubindex = 0x0609_0011,
    /// Not a value of the range.
    Range = 0x0609_0030,
    /// Too high.
    TooHigh = 0x0609_0031,
    /// Too low.
    TooLow = 0x0609_0032,
    /// General error.
    General = 0x0800_0000,
    /// Not in this state.
    State = 0x0800_0022,
}

impl Abort {
    /// The number on the wire.
    #[must_use]
    pub fn number(self) -> u32 {
        self as u32
    }
}
