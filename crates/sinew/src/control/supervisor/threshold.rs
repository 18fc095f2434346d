//! The number that a fault was judged by.

use super::limits::Limits;
use crate::control::arm::{ArmGains, Fault};

/// The number that a measurement had to exceed for a fault.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Threshold {
    /// Of the tension at the drive, N.
    Tension(f64),
    /// Of the tension's rate of change, N/s.
    TensionRate(f64),
    /// Of the speed of a cable at its winch, m/s.
    CableSpeed(f64),
    /// Cable on the drum, m.
    Travel([f64; 2]),
    /// Of the winding, degrees Celsius.
    Temperature(f64),
    /// Of a joint's error, rad or m.
    JointError(f64),
    /// Of a joint, with the margin beyond its range, rad or m.
    JointRange([f64; 2]),
    /// Age of a command, s.
    CommandAge(f64),
}

impl Threshold {
    /// Of a fault under these limits and gains; none where it is judged by a prediction, or where there is no
    /// limit.
    #[must_use]
    pub fn new(fault: Fault, limits: &Limits, gains: &ArmGains) -> Option<Self> {
        let muscle = |k: usize| limits.muscles.get(k);
        let found = match fault {
            Fault::Overload(k) => Self::Tension(muscle(k)?.tension),
            Fault::Slack(k) => Self::Tension(muscle(k)?.slack_tension),
            Fault::TensionRate(k) => Self::TensionRate(muscle(k)?.tension_rate),
            Fault::Overspeed(k) => Self::CableSpeed(muscle(k)?.speed),
            Fault::Travel(k) => Self::Travel(muscle(k)?.travel?),
            Fault::Overheating(k) => Self::Temperature(muscle(k)?.motor?.1),
            Fault::TrackingError(k) => Self::JointError(gains.joints.get(k)?.tracking_error),
            Fault::JointRange(k) => Self::JointRange((*limits.ranges.get(k)?)?),
            Fault::StaleCommand => Self::CommandAge(limits.safety.command_age),
            Fault::JointSensor(_)
            | Fault::MotorSensor(_)
            | Fault::TensionSensor(_)
            | Fault::TensionOrMotorSensor(_)
            | Fault::MotorOrJointSensor(_)
            | Fault::Drive(_)
            | Fault::Cable(_)
            | Fault::Bus
            | Fault::LateCycles => return None,
        };
        found.is_finite().then_some(found)
    }

    fn is_finite(self) -> bool {
        match self {
            Self::Tension(x)
            | Self::TensionRate(x)
            | Self::CableSpeed(x)
            | Self::Temperature(x)
            | Self::JointError(x)
            | Self::CommandAge(x) => x.is_finite(),
            Self::Travel(x) | Self::JointRange(x) => x.iter().all(|x| x.is_finite()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive::DriveParameters;

    #[test]
    fn the_threshold_of_a_fault_is_the_limit_of_its_part_and_none_where_there_is_no_limit() {
        let gains = ArmGains::for_tests(2, 1);
        let mut limits = Limits::of_gains(&gains);
        let of = |limits: &Limits, fault| Threshold::new(fault, limits, &gains);
        // Gains alone tell neither tension, rate, speed, travel, heat nor range.
        for fault in [
            Fault::Overload(1),
            Fault::TensionRate(1),
            Fault::Overspeed(1),
            Fault::Travel(1),
            Fault::Overheating(1),
            Fault::JointRange(0),
        ] {
            assert_eq!(of(&limits, fault), None, "{fault:?}");
        }
        let muscle = &mut limits.muscles[1];
        (muscle.tension, muscle.tension_rate, muscle.speed, muscle.slack_tension) = (400.0, 8e3, 0.3, 2.0);
        muscle.travel = Some([0.0, 0.4]);
        muscle.motor = Some((DriveParameters::mc_am(), 140.0));
        limits.ranges[0] = Some([-1.5, 1.25]);
        for (fault, expected) in [
            (Fault::Overload(1), Threshold::Tension(400.0)),
            (Fault::Slack(1), Threshold::Tension(2.0)),
            (Fault::TensionRate(1), Threshold::TensionRate(8e3)),
            (Fault::Overspeed(1), Threshold::CableSpeed(0.3)),
            (Fault::Travel(1), Threshold::Travel([0.0, 0.4])),
            (Fault::Overheating(1), Threshold::Temperature(140.0)),
            (Fault::JointRange(0), Threshold::JointRange([-1.5, 1.25])),
            (Fault::TrackingError(0), Threshold::JointError(0.5)),
            (Fault::StaleCommand, Threshold::CommandAge(0.1)),
        ] {
            assert_eq!(of(&limits, fault), Some(expected));
        }
        // A joint that only one end of its range stops.
        limits.ranges[0] = Some([f64::NEG_INFINITY, 1.0]);
        for fault in
            [Fault::JointRange(0), Fault::Overload(2), Fault::Bus, Fault::LateCycles, Fault::Cable(1)]
        {
            assert_eq!(of(&limits, fault), None, "{fault:?}");
        }
    }
}
