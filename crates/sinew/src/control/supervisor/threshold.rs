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
    /// Of a fault under these limits and gains; none where it is judged by a prediction, or where there is no limit.
    #[must_use]
    pub fn of(fault: Fault, limits: &Limits, gains: &ArmGains) -> Option<Self> {
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
