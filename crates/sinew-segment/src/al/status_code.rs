//! Why a device refused or left a state. Source: ETG.1000.6, table 11; ETG.1020.

/// AL status code.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
#[repr(u16)]
pub enum AlStatusCode {
    /// No error.
    NoError = 0x0000,
    /// Unspecified error.
    Unspecified = 0x0001,
    /// The request skips a state or leads nowhere.
    InvalidStateChange = 0x0011,
    /// The requested number is no state.
    UnknownState = 0x0012,
    /// The device has no bootstrap.
    NoBootstrap = 0x0013,
    /// Sync managers of the mailbox do not fit the device.
    InvalidMailbox = 0x0016,
    /// Sync managers of process data do not fit.
    InvalidSyncManager = 0x0017,
    /// The device has no valid inputs.
    NoValidInputs = 0x0018,
    /// No outputs came.
    NoValidOutputs = 0x0019,
    /// Synchronisation error.
    Synchronization = 0x001a,
    /// Outputs did not come in time.
    Watchdog = 0x001b,
    /// Sync managers of the wrong kind.
    InvalidSyncManagerTypes = 0x001c,
    /// Outputs are not configured as mapped.
    InvalidOutputs = 0x001d,
    /// Inputs are not configured as mapped.
    InvalidInputs = 0x001e,
    /// Watchdog settings out of range.
    InvalidWatchdog = 0x001f,
    /// The mapping of inputs and outputs is invalid.
    InvalidMapping = 0x0024,
    /// Settings are inconsistent.
    InconsistentSettings = 0x0025,
    /// The device has no such synchronisation type.
    SyncModeNotSupported = 0x0027,
    /// SYNC0 has stopped.
    FatalSync = 0x002c,
    /// SYNC0 does not come.
    NoSync = 0x002d,
    /// SYNC settings are invalid.
    InvalidSyncConfiguration = 0x0030,
    /// The clock does not follow its reference.
    PhaseError = 0x0032,
    /// The cycle time is not supported.
    InvalidCycleTime = 0x0035,
    /// The cycle time of SYNC0 is not supported.
    InvalidSync0CycleTime = 0x0036,
}

impl AlStatusCode {
    /// The number on the wire.
    #[must_use]
    pub fn number(self) -> u16 {
        self as u16
    }
}
