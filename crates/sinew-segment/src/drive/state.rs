//! The power drive system's state machine. Source: IEC 61800-7-201, 6.2; CiA 402-2.

/// State of the drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum DriveState {
    /// Just started; the drive leaves it by itself.
    NotReadyToSwitchOn,
    /// No torque, parameters may be set.
    SwitchOnDisabled,
    /// No torque.
    ReadyToSwitchOn,
    /// Powered, no torque.
    SwitchedOn,
    /// The motor follows the commands.
    OperationEnabled,
    /// The motor is brought to rest.
    QuickStopActive,
    /// A fault has occurred and the motor is brought to rest.
    FaultReactionActive,
    /// A fault has occurred, no torque.
    Fault,
}

/// Bits of the controlword.
const SWITCH_ON: u16 = 1;
const ENABLE_VOLTAGE: u16 = 1 << 1;
/// Active low.
const QUICK_STOP: u16 = 1 << 2;
const ENABLE_OPERATION: u16 = 1 << 3;
pub(super) const FAULT_RESET: u16 = 1 << 7;

/// Command in a controlword; the reset of a fault is an edge and not among them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Command {
    DisableVoltage,
    QuickStop,
    Shutdown,
    SwitchOn,
    EnableOperation,
}

impl Command {
    pub(super) fn from_controlword(controlword: u16) -> Self {
        let set = |bits: u16| controlword & bits == bits;
        match () {
            () if !set(ENABLE_VOLTAGE) => Self::DisableVoltage,
            () if !set(QUICK_STOP) => Self::QuickStop,
            () if !set(SWITCH_ON) => Self::Shutdown,
            () if !set(ENABLE_OPERATION) => Self::SwitchOn,
            () => Self::EnableOperation,
        }
    }
}

impl DriveState {
    /// The next state on a command. `stays`: a quick stop ends in its own state, from which the drive may be
    /// enabled.
    pub(super) fn next(self, command: Command, stays: bool) -> Self {
        use Command as C;
        match (self, command) {
            (Self::NotReadyToSwitchOn, _) => Self::SwitchOnDisabled,
            (Self::SwitchOnDisabled, C::Shutdown) => Self::ReadyToSwitchOn,
            (Self::ReadyToSwitchOn, C::SwitchOn | C::EnableOperation) => Self::SwitchedOn,
            (Self::SwitchedOn, C::EnableOperation) => Self::OperationEnabled,
            (Self::OperationEnabled, C::SwitchOn) => Self::SwitchedOn,
            (Self::SwitchedOn | Self::OperationEnabled, C::Shutdown) => Self::ReadyToSwitchOn,
            (Self::OperationEnabled, C::QuickStop) => Self::QuickStopActive,
            (Self::QuickStopActive, C::EnableOperation) if stays => Self::OperationEnabled,
            (Self::ReadyToSwitchOn | Self::SwitchedOn, C::QuickStop | C::DisableVoltage)
            | (Self::OperationEnabled | Self::QuickStopActive, C::DisableVoltage) => Self::SwitchOnDisabled,
            (state, _) => state,
        }
    }

    /// Bits 0 to 3, 5 and 6 of the statusword.
    #[must_use]
    pub fn statusword(self) -> u16 {
        match self {
            Self::NotReadyToSwitchOn => 0x00,
            Self::SwitchOnDisabled => 0x40,
            Self::ReadyToSwitchOn => 0x21,
            Self::SwitchedOn => 0x23,
            Self::OperationEnabled => 0x27,
            Self::QuickStopActive => 0x07,
            Self::FaultReactionActive => 0x0f,
            Self::Fault => 0x08,
        }
    }

    /// The motor has torque.
    #[must_use]
    pub fn has_power(self) -> bool {
        matches!(self, Self::OperationEnabled | Self::QuickStopActive | Self::FaultReactionActive)
    }
}
