//! Versions of the interface.

/// Version of the interface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Version {
    /// FMI 2.0.
    Two,
    /// FMI 3.0.
    Three,
}

impl Version {
    /// Stem of the source that implements it.
    pub(super) fn stem(self) -> &'static str {
        match self {
            Self::Two => "fmi2",
            Self::Three => "fmi3",
        }
    }

    pub(super) fn template(self) -> &'static str {
        match self {
            Self::Two => include_str!("templates/fmi2.c"),
            Self::Three => include_str!("templates/fmi3.c"),
        }
    }
}
