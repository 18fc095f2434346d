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
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SensorFailure {
    /// The reading stays at its last value.
    Stuck,
    /// The signal is lost, and the reading is 0.
    Lost,
    /// The reading is not a number.
    NotANumber,
    /// The reading is off by this much, in the sensor's unit: lost counts, a slipped coupling.
    Offset(f64),
    /// The reading is multiplied by this factor.
    Gain(f64),
    /// The error of the reading grows at this rate, in the sensor's unit per second.
    Drift(f64),
    /// The magnitude of the reading ends at this value, in the sensor's unit.
    Saturation(f64),
    /// Gaussian noise of this standard deviation, in the sensor's unit, is added to the reading.
    Noise(f64),
}

impl SensorFailure {
    /// What a sensor reads in place of `measured`, `elapsed` s after its failure began; `previous` is its
    /// last reading, `noise` a number of unit variance.
    pub(super) fn reading(
        self,
        measured: f64,
        previous: f64,
        elapsed: f64,
        noise: impl FnOnce() -> f64,
    ) -> f64 {
        match self {
            Self::Stuck => previous,
            Self::Lost => 0.0,
            Self::NotANumber => f64::NAN,
            Self::Offset(offset) => measured + offset,
            Self::Gain(gain) => gain * measured,
            Self::Drift(rate) => measured + rate * elapsed,
            Self::Saturation(limit) => measured.clamp(-limit.abs(), limit.abs()),
            Self::Noise(deviation) => measured + deviation * noise(),
        }
    }
}

/// What is worn of a cable in its sheath.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Worn {
    /// The part `mu phi` of the friction angle grows by a fraction.
    Friction,
    /// The pretension `T_0` falls by a fraction.
    Pretension,
    /// The compliance grows by a fraction, along the whole cable: strands that have broken.
    Stiffness,
}

/// What is wrong with the exchange between the plant and its controller.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ExchangeFailure {
    /// Readings and commands are lost.
    Lost,
    /// Cycles begin half a millisecond after their deadlines.
    Late,
    /// No command comes: the last one ages.
    Stale,
}

/// Failure of one component.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Failure {
    /// The cable of a muscle breaks; a broken cable stays broken.
    Cable(usize),
    /// The amplifier of a muscle is off whatever the command; friction of its reducer still acts.
    Amplifier(usize),
    /// The winch of a muscle is jammed.
    Winch(usize),
    /// A sensor.
    Sensor(Sensor, SensorFailure),
    /// Something outside pushes a joint with this torque, Nm, or force, N.
    Push {
        /// Its index.
        joint: usize,
        /// In the direction of the coordinate.
        torque: f64,
    },
    /// A cable wears: over the duration, evenly; then it stays worn.
    Wear {
        /// Its muscle.
        muscle: usize,
        /// What of it.
        what: Worn,
        /// By which fraction at the end, 1, >= 0.
        fraction: f64,
    },
    /// The exchange with the controller.
    Exchange(ExchangeFailure),
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
            Failure::Exchange(_) => return Ok(()),
            Failure::Push { joint, torque } => {
                crate::error::finite("torque of a push", torque)?;
                ("joint of a fault", "below the number of joints", joint, joints)
            }
            Failure::Wear { muscle, what, fraction } => {
                non_negative("fraction of wear", fraction)?;
                let most = if what == Worn::Pretension { 1.0 } else { 10.0 };
                within("fraction of wear", "at most 1 of a pretension, else 10", fraction, fraction <= most)?;
                ("muscle of a fault", "below the number of muscles", muscle, muscles)
            }
            Failure::Sensor(sensor, how) => {
                if let SensorFailure::Offset(x)
                | SensorFailure::Gain(x)
                | SensorFailure::Drift(x)
                | SensorFailure::Saturation(x)
                | SensorFailure::Noise(x) = how
                {
                    crate::error::finite("size of a sensor's failure", x)?;
                }
                match sensor {
                    Sensor::Joint(joint) => ("joint of a fault", "below the number of joints", joint, joints),
                    Sensor::Tension(muscle) | Sensor::Motor(muscle) => {
                        ("muscle of a fault", "below the number of muscles", muscle, muscles)
                    }
                }
            }
            Failure::Cable(muscle) | Failure::Amplifier(muscle) | Failure::Winch(muscle) => {
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

    /// Fraction of the wear of a muscle's part at a time, s; 0 for other failures.
    pub(super) fn wear(&self, of: usize, part: Worn, time: f64) -> f64 {
        match self.failure {
            Failure::Wear { muscle, what, fraction } if (muscle, what) == (of, part) => {
                let elapsed = time - self.start;
                if elapsed < 0.0 {
                    0.0
                } else if self.duration.is_finite() {
                    fraction * (elapsed / self.duration).min(1.0)
                } else {
                    fraction
                }
            }
            _ => 0.0,
        }
    }
}
