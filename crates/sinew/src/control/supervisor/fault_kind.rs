//! Names of the faults, with what is done about each and within which time.

use crate::control::arm::{Fault, Symptom};

/// Kind of a fault; with its part it is named.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum FaultKind {
    /// A cable is slack, or its slack is not wound in.
    Slack = 1,
    /// A tension at a drive is above its limit.
    Overload = 2,
    /// A cable lacks the tension that it should have: it is broken or off its winch.
    CableBreak = 3,
    /// A winch stands while it is commanded to move: it is jammed, or its drive has no power.
    Jam = 4,
    /// The friction of a cable has drifted away from that at the beginning; a report, not a stop.
    FrictionDrift = 5,
    /// A sensor's reading does not change where it should.
    SensorStuck = 6,
    /// A sensor's reading is missing.
    SensorLost = 7,
    /// A sensor's reading is elsewhere than it can be.
    EncoderJump = 8,
    /// A drive does not follow its command, or reports a fault.
    DriveFault = 9,
    /// No readings came for longer than a loss is bridged.
    LostCycles = 10,
    /// Control cycles began too late.
    LateCycles = 11,
    /// The last command is older than its limit.
    StaleCommand = 12,
    /// The error of a joint is beyond its threshold.
    TrackingError = 13,
    /// A joint is outside of its range.
    JointRange = 14,
    /// A winch turns faster than its limit.
    Overspeed = 15,
    /// A winch has left its travel.
    Travel = 16,
    /// A motor is, by its thermal model, hotter than its limit.
    Overheating = 17,
    /// A tension changes faster than its limit.
    TensionRate = 18,
    /// The pretension of a cable has changed; a report, not a stop.
    PretensionDrift = 19,
    /// The stiffness of a cable has changed; a report, not a stop.
    StiffnessDrift = 20,
    /// A sensor's reading deviates from what the other sensors imply, or its noise has grown.
    SensorDeviation = 21,
}

impl FaultKind {
    /// All kinds, by their numbers, which begin with 1.
    pub const ALL: [Self; 21] = [
        Self::Slack,
        Self::Overload,
        Self::CableBreak,
        Self::Jam,
        Self::FrictionDrift,
        Self::SensorStuck,
        Self::SensorLost,
        Self::EncoderJump,
        Self::DriveFault,
        Self::LostCycles,
        Self::LateCycles,
        Self::StaleCommand,
        Self::TrackingError,
        Self::JointRange,
        Self::Overspeed,
        Self::Travel,
        Self::Overheating,
        Self::TensionRate,
        Self::PretensionDrift,
        Self::StiffnessDrift,
        Self::SensorDeviation,
    ];

    /// The kind of a number.
    #[must_use]
    pub fn from_number(number: u8) -> Option<Self> {
        Self::ALL.get(usize::from(number).checked_sub(1)?).copied()
    }

    /// Of a fault whose part behaves like this.
    #[must_use]
    pub fn from_fault(fault: Fault, symptom: Symptom) -> Self {
        match fault {
            Fault::TensionOrMotorSensor(_) | Fault::MotorOrJointSensor(_) => Self::SensorDeviation,
            Fault::JointSensor(_) | Fault::MotorSensor(_) | Fault::TensionSensor(_) => match symptom {
                Symptom::Stuck => Self::SensorStuck,
                Symptom::Jumped => Self::EncoderJump,
                Symptom::Deviating | Symptom::Noisy => Self::SensorDeviation,
                _ => Self::SensorLost,
            },
            Fault::Drive(_) if symptom == Symptom::Standing => Self::Jam,
            Fault::Drive(_) => Self::DriveFault,
            Fault::Cable(_) => Self::CableBreak,
            Fault::TrackingError(_) => Self::TrackingError,
            Fault::Bus => Self::LostCycles,
            Fault::Slack(_) => Self::Slack,
            Fault::Overload(_) => Self::Overload,
            Fault::TensionRate(_) => Self::TensionRate,
            Fault::Overspeed(_) => Self::Overspeed,
            Fault::Travel(_) => Self::Travel,
            Fault::Overheating(_) => Self::Overheating,
            Fault::JointRange(_) => Self::JointRange,
            Fault::LateCycles => Self::LateCycles,
            Fault::StaleCommand => Self::StaleCommand,
        }
    }

    /// In words of documents and files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Slack => "slack",
            Self::Overload => "overload",
            Self::CableBreak => "cable_break",
            Self::Jam => "jam",
            Self::FrictionDrift => "friction_drift",
            Self::SensorStuck => "sensor_stuck",
            Self::SensorLost => "sensor_lost",
            Self::EncoderJump => "encoder_jump",
            Self::DriveFault => "drive_fault",
            Self::LostCycles => "lost_cycles",
            Self::LateCycles => "late_cycles",
            Self::StaleCommand => "stale_command",
            Self::TrackingError => "tracking_error",
            Self::JointRange => "joint_range",
            Self::Overspeed => "overspeed",
            Self::Travel => "travel",
            Self::Overheating => "overheating",
            Self::TensionRate => "tension_rate",
            Self::PretensionDrift => "pretension_drift",
            Self::StiffnessDrift => "stiffness_drift",
            Self::SensorDeviation => "sensor_deviation",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_the_places_in_the_list_and_names_differ() {
        for (place, kind) in FaultKind::ALL.into_iter().enumerate() {
            assert_eq!(kind as usize, place + 1);
            assert_eq!(FaultKind::from_number(kind as u8), Some(kind));
            assert!(FaultKind::ALL[..place].iter().all(|other| other.name() != kind.name()));
        }
        assert_eq!((FaultKind::from_number(0), FaultKind::from_number(22)), (None, None));
    }

    #[test]
    fn a_sensor_is_named_by_its_symptom_whichever_it_is() {
        for sensor in [Fault::JointSensor(1), Fault::MotorSensor(1), Fault::TensionSensor(1)] {
            for (symptom, kind) in [
                (Symptom::Stuck, FaultKind::SensorStuck),
                (Symptom::Jumped, FaultKind::EncoderJump),
                (Symptom::Deviating, FaultKind::SensorDeviation),
                (Symptom::Noisy, FaultKind::SensorDeviation),
                (Symptom::Lost, FaultKind::SensorLost),
                (Symptom::Unknown, FaultKind::SensorLost),
                (Symptom::Reported, FaultKind::SensorLost),
            ] {
                assert_eq!(FaultKind::from_fault(sensor, symptom), kind);
            }
        }
    }

    #[test]
    fn a_drive_whose_winch_stands_is_jammed_and_any_other_is_at_fault() {
        assert_eq!(FaultKind::from_fault(Fault::Drive(0), Symptom::Standing), FaultKind::Jam);
        for symptom in [Symptom::Reported, Symptom::Unknown, Symptom::Stuck] {
            assert_eq!(FaultKind::from_fault(Fault::Drive(0), symptom), FaultKind::DriveFault);
        }
    }
}
