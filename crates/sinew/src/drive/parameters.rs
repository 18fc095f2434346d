//! The numbers of a drive, and what follows from them alone.

use super::motor::Motor;
use super::reducer::Reducer;
use super::sensors::{Encoder, LoadCell};
use super::winch::Winch;
use crate::Error;
use crate::error::{positive, within};

/// Parameters of a drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveParameters {
    /// The motor.
    pub motor: Motor,
    /// The reducer.
    pub reducer: Reducer,
    /// The winch.
    pub winch: Winch,
    /// Encoder on the motor's shaft.
    pub encoder: Encoder,
    /// Load cell at the outlet.
    pub load_cell: LoadCell,
    /// Delay of every reading, steps, >= 0.
    pub delay_steps: f64,
    /// Limit of the velocity reference at the cable, m/s^2, > 0.
    pub acceleration: f64,
    /// Tension above which the drive does not wind in, N, > 0.
    pub most_tension: f64,
    /// Tension below which the drive does not pay out, N, >= 0.
    pub least_tension: f64,
}

impl DriveParameters {
    /// The paper's drive: 35 mm motor of 120 W, 53 : 1, 15 mm winch; other values are assumed, as documented
    /// with each part.
    #[must_use]
    pub fn mc_am() -> Self {
        Self {
            motor: Motor::class_35_mm(),
            reducer: Reducer::ratio_53(),
            winch: Winch::fifteen_millimetres(),
            encoder: Encoder { counts: 2048.0, zero: 0.0 },
            load_cell: LoadCell::one_kilonewton(),
            delay_steps: 1.0,
            acceleration: 5.0,
            most_tension: 600.0,
            least_tension: 1.0,
        }
    }

    /// Checks every number.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] names the number outside its domain.
    pub fn validate(&self) -> Result<(), Error> {
        self.motor.validate()?;
        self.reducer.validate()?;
        self.winch.validate()?;
        self.encoder.validate()?;
        self.load_cell.validate()?;
        positive("acceleration", self.acceleration)?;
        positive("most_tension", self.most_tension)?;
        let least = self.least_tension;
        let below = least >= 0.0 && least < self.most_tension;
        within("least_tension", "a number in [0, most_tension)", least, below)?;
        Ok(())
    }

    /// Rotor inertia reflected to the cable, kg.
    #[must_use]
    pub fn mass_at_cable(&self) -> f64 {
        let turns = self.reducer.ratio / self.winch.arm(0);
        self.motor.inertia * turns * turns
    }

    /// Current that takes up cable at a tension, N, and speed, m/s, >= 0, against the losses of the reducer, A.
    #[must_use]
    pub fn pulling_current(&self, tension: f64, speed: f64) -> f64 {
        let Self { motor, reducer, winch, .. } = self;
        let turns = reducer.ratio / winch.arm(0);
        let torque =
            tension / (turns * reducer.efficiency) + reducer.friction + reducer.viscous * turns * speed;
        torque / motor.torque_constant
    }

    /// Current that pays out cable at a tension, N, and speed, m/s, >= 0, with the losses of the reducer on its
    /// side, A; negative where the motor has to push.
    #[must_use]
    pub fn yielding_current(&self, tension: f64, speed: f64) -> f64 {
        let Self { motor, reducer, winch, .. } = self;
        let turns = reducer.ratio / winch.arm(0);
        let torque =
            tension * reducer.efficiency / turns - reducer.friction - reducer.viscous * turns * speed;
        torque / motor.torque_constant
    }

    /// Tension that the drive may be asked for, N: 19 in 20 of the one above which it does not wind in, and what it
    /// takes up with its peak current, or with the current at which a hot winding leaves half of the no-load speed.
    /// Heat is not considered.
    #[must_use]
    pub fn working_tension(&self) -> f64 {
        let motor = &self.motor;
        let current = motor.peak_current.min(0.5 * motor.voltage / motor.resistance_at(motor.hottest));
        self.allowed_tension().min(self.tension_of(current))
    }

    /// Tension that the drive may be asked for whatever its motor gives, N.
    #[must_use]
    pub fn allowed_tension(&self) -> f64 {
        0.95 * self.most_tension
    }

    /// Tension at which a current takes up cable slowly, N: the inverse of
    /// [`pulling_current`](Self::pulling_current) at standstill, 0 where friction takes all of it.
    #[must_use]
    pub fn tension_of(&self, current: f64) -> f64 {
        let Self { motor, reducer, winch, .. } = self;
        let turns = reducer.ratio / winch.arm(0);
        let torque = motor.torque_constant * current - reducer.friction;
        (torque * reducer.efficiency * turns).max(0.0)
    }

    /// Speed at which the drive takes up cable at a tension, N, m/s: the limit of the voltage with a hot winding,
    /// or of the bearings.
    #[must_use]
    pub fn speed_at(&self, tension: f64) -> f64 {
        let Self { motor, reducer, winch, .. } = self;
        let current = self.pulling_current(tension, 0.0);
        let left = motor.voltage - motor.resistance_at(motor.hottest) * current;
        let shaft = (left / motor.torque_constant).clamp(0.0, motor.top_speed);
        shaft * winch.arm(0) / reducer.ratio
    }

    /// A cable speed, m/s, limited so that the tension at the outlet, N, stays between the drive's limits.
    #[must_use]
    pub fn limited_speed(&self, velocity: f64, tension: f64) -> f64 {
        if tension > self.most_tension {
            velocity.min(0.0)
        } else if tension < self.least_tension {
            velocity.max(0.0)
        } else {
            velocity
        }
    }
}
