//! Operating state of an arm and the faults that change it.

use alloc::borrow::ToOwned;
use alloc::format;
use alloc::string::String;

/// A detected fault, with the index of the joint or muscle concerned.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// The encoder of a joint: its measurement was rejected.
    JointSensor(usize),
    /// The motor encoder of a muscle: its measurement was rejected.
    MotorSensor(usize),
    /// The load cell of a muscle: its measurement was rejected, and the cable's observer runs without it.
    TensionSensor(usize),
    /// Load cell and motor encoder of a muscle contradict each other: it is not known which of them is wrong.
    TensionOrMotorSensor(usize),
    /// The motor encoder of a muscle and the encoders of its joints contradict each other.
    MotorOrJointSensor(usize),
    /// The drive of a muscle does not follow its command.
    Drive(usize),
    /// The cable of a muscle lacks the estimated tension: it is broken or off its winch.
    Cable(usize),
    /// The error of a joint is beyond its threshold.
    TrackingError(usize),
    /// The bus: no reading came for longer than a loss is bridged.
    Bus,
    /// The cable of a muscle is slack, or its slack is not wound in.
    Slack(usize),
    /// The tension of a muscle at its drive is above its limit.
    Overload(usize),
    /// The tension of a muscle changes faster than its limit.
    TensionRate(usize),
    /// The winch of a muscle turns faster than its limit.
    Overspeed(usize),
    /// The winch of a muscle has left its travel.
    Travel(usize),
    /// The motor of a muscle is, by its thermal model, hotter than its limit.
    Overheating(usize),
    /// A joint is outside of its range.
    JointRange(usize),
    /// Control cycles began too late for too long.
    LateCycles,
    /// The last command is older than its limit.
    StaleCommand,
}

impl Fault {
    /// In words, with the names that `muscle` and `joint` give to indices.
    #[must_use]
    pub fn name<'a>(self, muscle: impl Fn(usize) -> &'a str, joint: impl Fn(usize) -> &'a str) -> String {
        match self {
            Self::JointSensor(k) => format!("joint encoder of {}", joint(k)),
            Self::MotorSensor(k) => format!("motor encoder of {}", muscle(k)),
            Self::TensionSensor(k) => format!("load cell of {}", muscle(k)),
            Self::TensionOrMotorSensor(k) => format!("load cell or motor encoder of {}", muscle(k)),
            Self::MotorOrJointSensor(k) => {
                format!("motor encoder of {} or encoder of a joint that it moves", muscle(k))
            }
            Self::Drive(k) => format!("drive of {}", muscle(k)),
            Self::Cable(k) => format!("cable of {}", muscle(k)),
            Self::TrackingError(k) => format!("tracking error of {}", joint(k)),
            Self::Bus => "no answer from the bus".to_owned(),
            Self::Slack(k) => format!("slack cable of {}", muscle(k)),
            Self::Overload(k) => format!("tension of {} above its limit", muscle(k)),
            Self::TensionRate(k) => format!("tension of {} changes too fast", muscle(k)),
            Self::Overspeed(k) => format!("winch of {} too fast", muscle(k)),
            Self::Travel(k) => format!("winch of {} out of its travel", muscle(k)),
            Self::Overheating(k) => format!("motor of {} too hot", muscle(k)),
            Self::JointRange(k) => format!("{} out of its range", joint(k)),
            Self::LateCycles => "late control cycles".to_owned(),
            Self::StaleCommand => "no new command".to_owned(),
        }
    }
}

/// How the part of a fault behaves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Symptom {
    /// Nothing more is known.
    #[default]
    Unknown,
    /// The reading is missing, or zero.
    Lost,
    /// The reading does not change where it should.
    Stuck,
    /// The reading is elsewhere than it can be.
    Jumped,
    /// The reading deviates from what the other sensors imply.
    Deviating,
    /// The noise of the reading has grown.
    Noisy,
    /// The winch stands while it is commanded to move.
    Standing,
    /// The drive reports a fault.
    Reported,
}

impl Symptom {
    /// Of a rejected sensor, by its last reading and whether it was rejected for an unchanged output.
    pub(super) fn of_reading(reading: f64, stood: bool) -> Self {
        if !reading.is_finite() || (reading == 0.0 && !stood) {
            Self::Lost
        } else if stood {
            Self::Stuck
        } else {
            Self::Jumped
        }
    }
}

/// Operating state of an arm under control.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ArmStatus {
    /// It tracks its reference.
    #[default]
    Following,
    /// The reference is at rest, all errors are within their tolerances, and the winches stand.
    Holding,
    /// A fault is present for less than its persistence time: the controller continues on estimates.
    Degraded(Fault),
    /// A fault persisted: the winches were braked to rest and stay there.
    Stopped(Fault),
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec::Vec;

    #[test]
    fn every_fault_has_a_name_of_its_own_that_tells_the_part() {
        let of_joints = [Fault::JointSensor(1), Fault::TrackingError(1), Fault::JointRange(1)];
        let of_muscles = [
            Fault::MotorSensor(1),
            Fault::TensionSensor(1),
            Fault::TensionOrMotorSensor(1),
            Fault::MotorOrJointSensor(1),
            Fault::Drive(1),
            Fault::Cable(1),
            Fault::Slack(1),
            Fault::Overload(1),
            Fault::TensionRate(1),
            Fault::Overspeed(1),
            Fault::Travel(1),
            Fault::Overheating(1),
        ];
        let of_none = [Fault::Bus, Fault::LateCycles, Fault::StaleCommand];
        let name = |fault: &Fault| fault.name(|k| ["biceps", "triceps"][k], |k| ["shoulder", "elbow"][k]);
        let [joints, muscles, none] = [&of_joints[..], &of_muscles, &of_none]
            .map(|faults| faults.iter().map(name).collect::<Vec<String>>());
        assert!(joints.iter().all(|name| name.contains("elbow")), "{joints:?}");
        assert!(muscles.iter().all(|name| name.contains("triceps")), "{muscles:?}");
        let all: Vec<String> = [joints, muscles, none].concat();
        for (k, name) in all.iter().enumerate() {
            assert!(!name.is_empty() && !all[..k].contains(name), "{name}");
        }
    }

    #[test]
    fn a_reading_that_is_missing_or_zero_is_lost_one_that_stood_stuck_and_any_other_has_jumped() {
        for (reading, stood, symptom) in [
            (f64::NAN, false, Symptom::Lost),
            (f64::NAN, true, Symptom::Lost),
            (f64::INFINITY, false, Symptom::Lost),
            (0.0, false, Symptom::Lost),
            // An encoder may stand at zero as anywhere else.
            (0.0, true, Symptom::Stuck),
            (0.7, true, Symptom::Stuck),
            (0.7, false, Symptom::Jumped),
        ] {
            assert_eq!(Symptom::of_reading(reading, stood), symptom, "{reading} {stood}");
        }
    }
}
