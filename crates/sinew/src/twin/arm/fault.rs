use crate::Error;
use crate::error::{non_negative, positive, within};

/// Which sensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sensor {
    /// Load cell of a muscle.
    Tension(usize),
    /// Motor's encoder of a muscle.
    Motor(usize),
    /// Encoder of a joint.
    Joint(usize),
}

/// What is wrong with its reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SensorFailure {
    /// It stays what it was.
    Stuck,
    /// Nothing comes, and nothing is read as 0.
    Lost,
    /// Not a number.
    NotANumber,
}

/// What fails.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Failure {
    /// The cable of a muscle breaks, and stays broken.
    Cable(usize),
    /// The amplifier of a muscle is off, whatever it is told; its reducer still brakes.
    Amplifier(usize),
    /// The winch of a muscle is jammed.
    Winch(usize),
    /// A sensor.
    Sensor(Sensor, SensorFailure),
}

/// Something that fails for a while.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fault {
    /// Since the start of the run, s, >= 0.
    pub from: f64,
    /// s, > 0; infinite for good.
    pub lasting: f64,
    /// What.
    pub what: Failure,
}

impl Fault {
    /// Checks it for an arm.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] for a muscle or a joint that is not there, and for times that make no sense.
    pub fn validate(&self, muscles: usize, joints: usize) -> Result<(), Error> {
        non_negative("from", self.from)?;
        if self.lasting < f64::INFINITY || self.lasting.is_nan() {
            positive("lasting", self.lasting)?;
        }
        let (name, expected, index, count) = match self.what {
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

    /// Whether it is there at a time, s.
    #[must_use]
    pub fn present(&self, time: f64) -> bool {
        // Half a nanosecond for times that are sums of milliseconds.
        let since = time - self.from + 5e-10;
        since >= 0.0 && since < self.lasting
    }
}
