/// What the control cycle says to a watchdog beside it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sign {
    /// It runs: the next sign has to come within the time. Where none does the watchdog acts, and ends.
    Alive,
    /// As `Alive`, but the watchdog waits for more after it has acted.
    Trial,
    /// Nothing has power: no sign has to follow.
    Rest,
}

impl Sign {
    /// As octets that carry it.
    #[cfg(target_os = "linux")]
    pub(super) const ALL: [(Self, u8); 3] = [(Self::Alive, b'a'), (Self::Trial, b't'), (Self::Rest, b'r')];
}
