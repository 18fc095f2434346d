//! The states of the application layer. Source: ETG.1000.6, 6.4.1.

/// State of a device.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum AlState {
    /// No communication but registers.
    Init,
    /// Mailbox.
    PreOp,
    /// Mailbox and inputs.
    SafeOp,
    /// Mailbox, inputs and outputs.
    Op,
}

impl AlState {
    /// The number on the wire.
    #[must_use]
    pub fn number(self) -> u8 {
        match self {
            Self::Init => 1,
            Self::PreOp => 2,
            Self::SafeOp => 4,
            Self::Op => 8,
        }
    }

    /// The state of a number on the wire; BOOT (3) and unknown numbers are none.
    #[must_use]
    pub fn from_number(number: u8) -> Option<Self> {
        [Self::Init, Self::PreOp, Self::SafeOp, Self::Op].into_iter().find(|state| state.number() == number)
    }
}
