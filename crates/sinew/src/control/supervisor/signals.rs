//! Inputs and outputs of the supervisor.

use super::fault_kind::FaultKind;
use super::mode::Mode;
use crate::control::arm::{ArmCommand, Fault, Symptom};
use crate::trajectory::Reference;

/// How the exchange with drives and sensors of one cycle went, and when the cycle began.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExchangeStatus {
    /// Whether readings came.
    pub received: bool,
    /// The muscle whose drive reports a fault or is not operational.
    pub drive: Option<usize>,
    /// Time between the cycle's deadline and its beginning, s, >= 0.
    pub lateness: f64,
    /// Age of the last command, s; none where the reference is not commanded from elsewhere.
    pub command_age: Option<f64>,
}

impl Default for ExchangeStatus {
    /// Complete and in time.
    fn default() -> Self {
        Self { received: true, drive: None, lateness: 0.0, command_age: None }
    }
}

/// A fault with the way in which it showed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NamedFault {
    /// The part.
    pub fault: Fault,
    /// How it behaves.
    pub symptom: Symptom,
}

impl NamedFault {
    pub(super) fn new(fault: Fault, symptom: Symptom) -> Self {
        Self { fault, symptom }
    }

    /// Its kind.
    #[must_use]
    pub fn kind(self) -> FaultKind {
        FaultKind::from_fault(self.fault, self.symptom)
    }

    /// Index of the muscle or joint that it concerns; none for the machine as a whole.
    #[must_use]
    pub fn index(self) -> Option<usize> {
        match self.fault {
            Fault::JointSensor(k)
            | Fault::MotorSensor(k)
            | Fault::TensionSensor(k)
            | Fault::TensionOrMotorSensor(k)
            | Fault::MotorOrJointSensor(k)
            | Fault::Drive(k)
            | Fault::Cable(k)
            | Fault::TrackingError(k)
            | Fault::Slack(k)
            | Fault::Overload(k)
            | Fault::TensionRate(k)
            | Fault::Overspeed(k)
            | Fault::Travel(k)
            | Fault::Overheating(k)
            | Fault::JointRange(k) => Some(k),
            Fault::Bus | Fault::LateCycles | Fault::StaleCommand => None,
        }
    }

    /// The muscle that it concerns.
    #[must_use]
    pub fn muscle(self) -> Option<usize> {
        let of_joint =
            matches!(self.fault, Fault::JointSensor(_) | Fault::TrackingError(_) | Fault::JointRange(_));
        self.index().filter(|_| !of_joint)
    }
}

/// State of one muscle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u8)]
pub enum MuscleState {
    /// Without tension.
    #[default]
    Relaxed = 0,
    /// Its slack is wound in.
    TakingUp = 1,
    /// Under tension.
    Tense = 2,
    /// Under tension, one of its sensors being replaced by estimates.
    Estimated = 3,
    /// Its cable is released.
    LettingDown = 4,
    /// Its winch is held by its brake: its drive or its encoder cannot be trusted.
    Braked = 5,
    /// Its fault has stopped the machine.
    Faulty = 6,
}

impl MuscleState {
    /// In words of documents and files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Relaxed => "relaxed",
            Self::TakingUp => "taking_up",
            Self::Tense => "tense",
            Self::Estimated => "estimated",
            Self::LettingDown => "letting_down",
            Self::Braked => "braked",
            Self::Faulty => "faulty",
        }
    }
}

/// What is commanded in one control cycle, with the state that led to it; valid until the next one.
#[derive(Debug, Clone, Copy)]
pub struct SupervisorCommand<'a> {
    /// The mode.
    pub mode: Mode,
    /// The fault: in [`Mode::SafeStop`] and [`Mode::Fault`] the one that led there, else the one that is
    /// bridged, or the reason for which [`Mode::Hold`] was entered last.
    pub fault: Option<NamedFault>,
    /// State of every muscle: `[muscles]`.
    pub muscles: &'a [MuscleState],
    /// Reference that is followed: in [`Mode::Run`] the one that was given, in [`Mode::Hold`] the held pose,
    /// else the measured pose.
    pub reference: &'a Reference,
    /// Commands of the drives with estimates. Where the mode is neither [`Mode::Hold`] nor [`Mode::Run`], far
    /// tensions are not estimated (NaN).
    pub arm: ArmCommand<'a>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fault_concerns_the_muscle_or_joint_of_its_index_or_the_whole_machine() {
        let of = |fault| NamedFault::new(fault, Symptom::Unknown);
        for k in [0, 1, 5] {
            for fault in [
                Fault::MotorSensor(k),
                Fault::TensionSensor(k),
                Fault::Drive(k),
                Fault::Cable(k),
                Fault::Slack(k),
                Fault::Overload(k),
                Fault::TensionRate(k),
                Fault::Overspeed(k),
                Fault::Travel(k),
                Fault::Overheating(k),
            ] {
                assert_eq!((of(fault).index(), of(fault).muscle()), (Some(k), Some(k)), "{fault:?}");
            }
            for fault in [Fault::JointSensor(k), Fault::TrackingError(k), Fault::JointRange(k)] {
                assert_eq!((of(fault).index(), of(fault).muscle()), (Some(k), None), "{fault:?}");
            }
        }
        for fault in [Fault::Bus, Fault::LateCycles, Fault::StaleCommand] {
            assert_eq!((of(fault).index(), of(fault).muscle()), (None, None), "{fault:?}");
        }
    }
}
