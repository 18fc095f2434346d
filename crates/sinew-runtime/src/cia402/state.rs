//! The state machine of a drive, CiA 402 (IEC 61800-7-201), as the master sees it.
//!
//! The simulated devices have their own: the standard decides, not what two sides of one project share.

/// State of a drive, from its statusword.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DriveState {
    /// It starts up.
    NotReadyToSwitchOn,
    /// Power is locked.
    SwitchOnDisabled,
    /// Power may be switched on.
    ReadyToSwitchOn,
    /// Power is on, the motor is not.
    SwitchedOn,
    /// The motor follows its set-points.
    OperationEnabled,
    /// It brakes.
    QuickStopActive,
    /// It brakes because of a fault.
    FaultReactionActive,
    /// A fault is latched.
    Fault,
}

impl DriveState {
    /// From bits 0 to 3, 5 and 6 of the statusword; other bits are not looked at.
    #[must_use]
    pub fn from_statusword(statusword: u16) -> Self {
        match statusword & 0x4f {
            0x40 => return Self::SwitchOnDisabled,
            0x08 => return Self::Fault,
            0x0f => return Self::FaultReactionActive,
            0x00 => return Self::NotReadyToSwitchOn,
            _ => {}
        }
        match statusword & 0x6f {
            0x21 => Self::ReadyToSwitchOn,
            0x23 => Self::SwitchedOn,
            0x27 => Self::OperationEnabled,
            0x07 => Self::QuickStopActive,
            _ => Self::NotReadyToSwitchOn,
        }
    }
}

impl DriveState {
    /// Whether the motor has torque.
    pub(crate) fn has_torque(self) -> bool {
        matches!(self, Self::OperationEnabled | Self::QuickStopActive | Self::FaultReactionActive)
    }
}

/// Desired state of a drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Goal {
    /// The motor follows its set-points; a latched fault is reset on the way.
    Enabled,
    /// It brakes and stays there.
    Stopped,
    /// It has no power; where it moves it brakes first.
    Disabled,
}

const DISABLE_VOLTAGE: u16 = 0x00;
const SHUTDOWN: u16 = 0x06;
const SWITCH_ON: u16 = 0x07;
const ENABLE_OPERATION: u16 = 0x0f;
const QUICK_STOP: u16 = 0x02;
const FAULT_RESET: u16 = 0x80;

/// The controlword that leads from a state towards a goal by one transition. A reset is an edge, so that the
/// word must have been without it in the cycle before.
pub(crate) fn controlword(state: DriveState, goal: Goal, last: u16) -> u16 {
    match (goal, state) {
        (_, DriveState::Fault) if last & FAULT_RESET == 0 => FAULT_RESET,
        (_, DriveState::Fault | DriveState::FaultReactionActive | DriveState::NotReadyToSwitchOn) => {
            DISABLE_VOLTAGE
        }
        (Goal::Stopped, DriveState::OperationEnabled | DriveState::QuickStopActive) => QUICK_STOP,
        (Goal::Disabled, DriveState::OperationEnabled) => QUICK_STOP,
        (Goal::Stopped | Goal::Disabled, _) => DISABLE_VOLTAGE,
        (Goal::Enabled, DriveState::SwitchOnDisabled) => SHUTDOWN,
        (Goal::Enabled, DriveState::ReadyToSwitchOn) => SWITCH_ON,
        (Goal::Enabled, DriveState::SwitchedOn | DriveState::OperationEnabled) => ENABLE_OPERATION,
        // Out of a quick stop only over switch on disabled.
        (Goal::Enabled, DriveState::QuickStopActive) => DISABLE_VOLTAGE,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_state_is_read_whatever_the_other_bits_of_the_statusword_are() {
        let states = [
            (0x0000, DriveState::NotReadyToSwitchOn),
            (0x0040, DriveState::SwitchOnDisabled),
            (0x0021, DriveState::ReadyToSwitchOn),
            (0x0023, DriveState::SwitchedOn),
            (0x0027, DriveState::OperationEnabled),
            (0x0007, DriveState::QuickStopActive),
            (0x000f, DriveState::FaultReactionActive),
            (0x0008, DriveState::Fault),
        ];
        for (word, state) in states {
            for other in 0..=u16::MAX {
                assert_eq!(
                    DriveState::from_statusword(word | (other & !0x6f)),
                    state,
                    "{word:#06x} {other:#06x}"
                );
            }
        }
        // Bit 5, quick stop, has no meaning in these states.
        for (word, state) in [states[0], states[1], states[6], states[7]] {
            assert_eq!(DriveState::from_statusword(word | 0x20), state);
        }
    }

    #[test]
    fn a_drive_that_follows_its_controlword_is_enabled_from_every_state_and_stopped_from_every_state() {
        // The transitions of the standard, as a drive makes them.
        let next = |state: DriveState, word: u16, last: u16| match (state, word & 0x8f) {
            (DriveState::NotReadyToSwitchOn, _) => DriveState::SwitchOnDisabled,
            (DriveState::FaultReactionActive, _) => DriveState::Fault,
            (DriveState::Fault, word) if word & 0x80 != 0 && last & 0x80 == 0 => DriveState::SwitchOnDisabled,
            (DriveState::Fault, _) => DriveState::Fault,
            (_, word) if word & 0x02 == 0 => DriveState::SwitchOnDisabled,
            (DriveState::OperationEnabled, word) if word & 0x04 == 0 => DriveState::QuickStopActive,
            (DriveState::SwitchOnDisabled, 0x06) => DriveState::ReadyToSwitchOn,
            (DriveState::ReadyToSwitchOn, 0x07) => DriveState::SwitchedOn,
            (DriveState::SwitchedOn, 0x0f) => DriveState::OperationEnabled,
            (state, _) => state,
        };
        let states = [
            DriveState::NotReadyToSwitchOn,
            DriveState::SwitchOnDisabled,
            DriveState::ReadyToSwitchOn,
            DriveState::SwitchedOn,
            DriveState::OperationEnabled,
            DriveState::QuickStopActive,
            DriveState::FaultReactionActive,
            DriveState::Fault,
        ];
        for start in states {
            for (goal, ends) in [
                (Goal::Enabled, [DriveState::OperationEnabled; 2]),
                (Goal::Stopped, [DriveState::SwitchOnDisabled, DriveState::QuickStopActive]),
                (Goal::Disabled, [DriveState::SwitchOnDisabled; 2]),
            ] {
                // The worst history: the reset bit was set.
                let (mut state, mut last) = (start, 0x80);
                for _ in 0..8 {
                    let word = controlword(state, goal, last);
                    state = next(state, word, last);
                    last = word;
                }
                assert!(ends.contains(&state), "{start:?} {goal:?}: {state:?}");
            }
        }
    }
}
