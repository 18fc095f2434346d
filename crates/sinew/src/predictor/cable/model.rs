//! What an observer is told about a cable.

use crate::Error;
use crate::error::{positive, within};
use crate::transmission::cable::{CableLaw, CableParameters, Path};
use serde::{Deserialize, Serialize};

/// What an observer believes of a cable; identified from a log, never taken from a plant.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CableModel {
    /// The way of the cable.
    pub path: Path,
    /// Friction and elasticity.
    pub parameters: CableParameters,
    /// Cells; 8 serve.
    pub cells: usize,
    /// What the far sensor reads of a newton, 1; other than 1 where a log says so.
    pub far_gain: f64,
    /// Speed of the correction, m/s per N of the near tension's error.
    #[serde(rename = "correction_m_per_n_s")]
    pub correction: f64,
}

impl CableModel {
    /// The calibrated bench in 8 cells: a start for identification.
    #[must_use]
    pub fn bench() -> Self {
        Self {
            path: Path::bench(),
            parameters: CableParameters::bench(),
            cells: 8,
            far_gain: 1.0,
            correction: 2e-3,
        }
    }

    /// The law of these numbers.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] names the number outside its domain.
    pub fn law(&self) -> Result<CableLaw, Error> {
        positive("far_gain", self.far_gain)?;
        let sane = (0.0..=1.0).contains(&self.correction);
        within("correction", "a number in [0, 1] m/(N s)", self.correction, sane)?;
        CableLaw::new(&self.path, &self.parameters, self.cells)
    }
}

/// Which inputs of a model a cable is observed through, and what makes metres toward the motor of their numbers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CableColumns {
    /// Index of the near tension among the inputs.
    pub tension: usize,
    /// Index of the motor's position.
    pub motor: usize,
    /// Index of the anchor's displacement.
    pub anchor: usize,
    /// Metres toward the motor per unit of the motor's column; negative where it counts the other way.
    #[serde(rename = "motor_m_per_unit")]
    pub motor_scale: f64,
    /// The same for the anchor.
    #[serde(rename = "anchor_m_per_unit")]
    pub anchor_scale: f64,
}

impl CableColumns {
    /// The sample in a row of inputs; what is not there is missing.
    #[inline]
    #[must_use]
    pub fn sample(&self, inputs: &[f64]) -> CableSample {
        let of = |i: usize| inputs.get(i).copied().unwrap_or(f64::NAN);
        CableSample {
            motor: self.motor_scale * of(self.motor),
            anchor: self.anchor_scale * of(self.anchor),
            tension_in: of(self.tension),
        }
    }
}

/// One sample of everything that can be measured without a sensor at the anchor.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CableSample {
    /// Position of the winch's surface, m, + toward the motor; any origin.
    pub motor: f64,
    /// Position of the anchor along the cable, m, + toward the motor; from joint sensors, any origin.
    pub anchor: f64,
    /// Tension at the drive's outlet, N; NaN where it is missing.
    pub tension_in: f64,
}
