use crate::Error;
use crate::error::{non_negative, positive, within};

/// A sensor of the arm.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sensor {
    /// Load cell of a muscle.
    Tension(usize),
    /// Motor encoder of a muscle.
    Motor(usize),
    /// Encoder of a joint.
    Joint(usize),
}

/// Failure mode of a sensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SensorFailure {
    /// The reading stays at its last value.
    Stuck,
    /// The signal is lost, and the reading is 0.
    Lost,
    /// The reading is not a number.
    NotANumber,
}

/// Failure of one component.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Failure {
    /// The cable of a muscle breaks; a broken cable stays broken.
    Cable(usize),
    /// The amplifier of a muscle is off whatever the command; friction of its reducer still acts.
    Amplifier(usize),
    /// The winch of a muscle is jammed.
    Winch(usize),
    /// A sensor.
    Sensor(Sensor, SensorFailure),
}

/// A failure that the plant is subjected to over an interval of time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InjectedFault {
    /// Time since the start of the run, s, >= 0.
    pub start: f64,
    /// s, > 0; infinite for a permanent failure.
    pub duration: f64,
    /// The component and its failure.
    pub failure: Failure,
}

impl InjectedFault {
    /// Checks it for an arm.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] for a muscle or joint index out of range, a negative start or a duration that
    /// is not positive.
    pub fn validate(&self, muscles: usize, joints: usize) -> Result<(), Error> {
        non_negative("start of a fault", self.start)?;
        if self.duration < f64::INFINITY || self.duration.is_nan() {
            positive("duration of a fault", self.duration)?;
        }
        let (name, expected, index, count) = match self.failure {
            Failure::Sensor(Sensor::Joint(joint), _) => {
                ("joint of a fault", "below the number of joints", joint, joints)
            }
            Failure::Cable(muscle)
            | Failure::Amplifier(muscle)
            | Failure::Winch(muscle)
            | Failure::Sensor(Sensor::Tension(muscle) | Sensor::Motor(muscle), _) => {
                ("muscle of a fault", "below the number of muscles", muscle, muscles)
            }
        };
        within(name, expected, index as f64, index < count).map(drop)
    }

    /// Whether the failure is present at a time, s.
    #[must_use]
    pub fn is_active(&self, time: f64) -> bool {
        // Half a nanosecond of tolerance for times that are sums of milliseconds.
        let elapsed = time - self.start + 5e-10;
        elapsed >= 0.0 && elapsed < self.duration
    }
}
