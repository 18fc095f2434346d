//! What a drive is told, what it tells, and what it does.

use super::quadrant::Quadrant;
use crate::lanes::abreast;

/// Command of a drive for the next step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DriveCommand {
    /// Amplifier off; friction of the reducer still acts.
    Off,
    /// Amplifier off, the shaft held by its brake.
    Brake,
    /// Motor current, A.
    Current(f64),
    /// Cable speed, m/s, + toward the motor.
    Velocity(f64),
    /// Tension at the outlet, with feed-forward of the cable speed.
    Tension {
        /// Tension at the outlet, N.
        tension: f64,
        /// Speed of the cable, m/s.
        feed: f64,
    },
}

/// Latched fault of a drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DriveFault {
    /// Winding temperature above its limit, degrees Celsius; the motor is off.
    Hot {
        /// Its temperature.
        winding: f64,
    },
    /// The drum is full.
    DrumFull,
    /// The drum is empty.
    DrumEmpty,
}

/// Measurements of a drive, delayed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveReading {
    /// Position of the cable by the motor's encoder, m, + toward the motor.
    pub position: f64,
    /// Tension at the outlet, N.
    pub tension: f64,
    /// Current, A.
    pub current: f64,
}

abreast!(DriveReadingRows of DriveReading { f64: position tension current });

/// True motion and energies of a drive over a step.
///
/// Energy balance, to rounding, with the energies `stored` and `warmth` of [`Drive`](super::Drive):
/// `electrical = heat + lost + tension moved + d(stored)` and `heat = d(warmth) + to_air`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveStep {
    /// Displacement of the cable at the outlet, m, + toward the motor.
    pub moved: f64,
    /// Speed of the cable, m/s.
    pub speed: f64,
    /// Work from the amplifier, J.
    pub electrical: f64,
    /// Heat in the winding, J, >= 0.
    pub heat: f64,
    /// Heat from the housing to the air, J.
    pub to_air: f64,
    /// Losses of the reducer, impacts of its flanks included, J.
    pub lost: f64,
    /// Working quadrant.
    pub quadrant: Quadrant,
    /// Latched fault.
    pub fault: Option<DriveFault>,
}

impl DriveStep {
    /// A drive that stands without power.
    pub(crate) const STANDING: Self = Self {
        moved: 0.0,
        speed: 0.0,
        electrical: 0.0,
        heat: 0.0,
        to_air: 0.0,
        lost: 0.0,
        quadrant: Quadrant::First,
        fault: None,
    };

    /// This and the next step as one of `h` s.
    #[must_use]
    pub(crate) fn followed_by(self, next: Self, h: f64) -> Self {
        let moved = self.moved + next.moved;
        Self {
            moved,
            speed: moved / h,
            electrical: self.electrical + next.electrical,
            heat: self.heat + next.heat,
            to_air: self.to_air + next.to_air,
            lost: self.lost + next.lost,
            ..next
        }
    }
}
