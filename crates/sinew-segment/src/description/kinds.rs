//! The closed choices of a description.

use serde::Deserialize;

/// What a sync manager carries.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SyncManagerKind {
    /// Mailbox from the master.
    MailboxOut,
    /// Mailbox to the master.
    MailboxIn,
    /// Process data from the master.
    Outputs,
    /// Process data to the master.
    Inputs,
}

/// What a fieldbus memory management unit is meant for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FmmuUse {
    /// Process data from the master.
    Outputs,
    /// Process data to the master.
    Inputs,
    /// Status of the mailbox's sync manager.
    MailboxStatus,
}

/// Direction of process data, as seen by the master.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Direction {
    /// From the master: RxPDO of the device.
    Outputs,
    /// To the master: TxPDO of the device.
    Inputs,
}

/// What the device does with its objects.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Profile {
    /// Values go through unchanged: terminals.
    #[default]
    Plain,
    /// A drive after CiA 402.
    Drive,
}

/// Object code of CiA 301.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ObjectCode {
    /// One value at subindex 0.
    #[default]
    Variable,
    /// Entries of one type.
    Array,
    /// Entries of several types.
    Record,
}

impl ObjectCode {
    /// The number on the wire.
    #[must_use]
    pub fn number(self) -> u8 {
        match self {
            Self::Variable => 7,
            Self::Array => 8,
            Self::Record => 9,
        }
    }
}

/// Who may do what with an entry.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
pub enum Access {
    /// The master reads.
    #[default]
    #[serde(rename = "ro")]
    Read,
    /// The master writes.
    #[serde(rename = "wo")]
    Write,
    /// The master reads, and writes in every state.
    #[serde(rename = "rw")]
    ReadWrite,
    /// The master reads, and writes in PRE-OP only.
    #[serde(rename = "rw-preop")]
    WriteInPreOp,
}

impl Access {
    /// Access rights of SDO information: read in bits 0 to 2, write in bits 3 to 5, each PRE-OP, SAFE-OP, OP.
    #[must_use]
    pub fn rights(self) -> u16 {
        match self {
            Self::Read => 0x07,
            Self::Write => 0x38,
            Self::ReadWrite => 0x3f,
            Self::WriteInPreOp => 0x0f,
        }
    }
}

/// Whether an entry may be process data.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PdoMappable {
    /// Not at all.
    #[default]
    No,
    /// From the master.
    Outputs,
    /// To the master.
    Inputs,
    /// Both ways.
    Both,
}

impl PdoMappable {
    /// Whether the entry may be mapped in this direction.
    #[must_use]
    pub fn allows(self, direction: Direction) -> bool {
        match direction {
            Direction::Outputs => matches!(self, Self::Outputs | Self::Both),
            Direction::Inputs => matches!(self, Self::Inputs | Self::Both),
        }
    }
}

/// Data type of an entry, CiA 301 and ETG.1000.6, table 63.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum DataType {
    /// One bit.
    Bool,
    /// Signed, 8 bits.
    I8,
    /// Signed, 16 bits.
    I16,
    /// Signed, 32 bits.
    I32,
    /// Signed, 64 bits.
    I64,
    /// Unsigned, 8 bits.
    U8,
    /// Unsigned, 16 bits.
    U16,
    /// Unsigned, 24 bits.
    U24,
    /// Unsigned, 32 bits.
    U32,
    /// Unsigned, 64 bits.
    U64,
    /// Floating point, 32 bits.
    F32,
    /// Floating point, 64 bits.
    F64,
    /// Text.
    Text,
    /// Octets.
    Octets,
    /// Bits, one to eight of them.
    #[serde(rename = "bits")]
    Bits,
}

impl DataType {
    /// The number of the type on the wire, for an entry of `bits` bits.
    #[must_use]
    pub fn number(self, bits: u16) -> u16 {
        match self {
            Self::Bool => 0x0001,
            Self::I8 => 0x0002,
            Self::I16 => 0x0003,
            Self::I32 => 0x0004,
            Self::U8 => 0x0005,
            Self::U16 => 0x0006,
            Self::U32 => 0x0007,
            Self::F32 => 0x0008,
            Self::Text => 0x0009,
            Self::Octets => 0x000a,
            Self::F64 => 0x0011,
            Self::I64 => 0x0015,
            Self::U24 => 0x0016,
            Self::U64 => 0x001b,
            Self::Bits => 0x0030 + bits.clamp(1, 8) - 1,
        }
    }

    /// Number of bits, where the type determines it.
    #[must_use]
    pub fn bits(self) -> Option<u16> {
        Some(match self {
            Self::Bool => 1,
            Self::I8 | Self::U8 => 8,
            Self::I16 | Self::U16 => 16,
            Self::U24 => 24,
            Self::I32 | Self::U32 | Self::F32 => 32,
            Self::I64 | Self::U64 | Self::F64 => 64,
            Self::Text | Self::Octets | Self::Bits => return None,
        })
    }

    /// Whether values have a sign.
    #[must_use]
    pub fn is_signed(self) -> bool {
        matches!(self, Self::I8 | Self::I16 | Self::I32 | Self::I64)
    }

    /// Whether values are whole numbers, which may have limits.
    #[must_use]
    pub fn is_whole(self) -> bool {
        !matches!(self, Self::F32 | Self::F64 | Self::Text | Self::Octets)
    }
}
