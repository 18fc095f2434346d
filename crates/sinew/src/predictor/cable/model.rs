//! What an observer is told about a cable.

use crate::Error;
use crate::error::{finite, positive, within};
use crate::transmission::cable::{CableLaw, CableParameters, CablePath};
use serde::{Deserialize, Serialize};

/// What an observer believes of a cable; identified from a log, never taken from a plant.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CableModel {
    /// The way of the cable.
    pub path: CablePath,
    /// Friction and elasticity.
    pub parameters: CableParameters,
    /// Cells; 8 serve.
    pub cells: usize,
    /// What the far sensor reads of a newton, 1; other than 1 where a log says so.
    pub far_gain: f64,
    /// Where in its dead band the cable of a new sequence is, -1 to 1: 1 as after sliding toward the motor. Nobody
    /// knows, but logs of one rig often start from the same rest.
    #[serde(default)]
    pub start: f64,
    /// Speed of the correction, m/s per N of the near tension's error.
    #[serde(rename = "correction_m_per_n_s")]
    pub correction: f64,
    /// How fast the drag is learned while the cable slides, 1/(N m): grease warms and ages. 0 for never; 1 serves.
    #[serde(rename = "learning_per_n_m", default)]
    pub learning: f64,
    /// Stretch, m, while motor and anchor both read zero, where their zeros never move: then the first sample
    /// tells more than the near tension. None for encoders that start anywhere.
    #[serde(rename = "zero_stretch_m", default, skip_serializing_if = "Option::is_none")]
    pub zero_stretch: Option<f64>,
}

impl CableModel {
    /// The calibrated bench in 8 cells: a start for identification.
    #[must_use]
    pub fn bench() -> Self {
        Self {
            path: CablePath::bench(),
            parameters: CableParameters::bench(),
            cells: 8,
            far_gain: 1.0,
            start: 0.0,
            correction: 2e-3,
            learning: 0.0,
            zero_stretch: None,
        }
    }

    /// The law of these numbers.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] names the number outside its domain.
    pub fn law(&self) -> Result<CableLaw, Error> {
        positive("far_gain", self.far_gain)?;
        within("start", "a number in [-1, 1]", self.start, (-1.0..=1.0).contains(&self.start))?;
        let sane = (0.0..=1.0).contains(&self.correction);
        within("correction", "a number in [0, 1] m/(N s)", self.correction, sane)?;
        let sane = (0.0..=100.0).contains(&self.learning);
        within("learning", "a number in [0, 100] 1/(N m)", self.learning, sane)?;
        if let Some(stretch) = self.zero_stretch {
            finite("zero_stretch", stretch)?;
        }
        CableLaw::new(&self.path, &self.parameters, self.cells)
    }
}

/// Which inputs of a model a cable is observed through, and what makes metres toward the motor of their numbers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
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

/// A cable with the inputs it is observed through: what a model file holds of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObservedCable {
    /// Which inputs, and their scales.
    pub columns: CableColumns,
    /// What is believed of the cable.
    pub model: CableModel,
}

impl ObservedCable {
    /// Checks it against the number of inputs of its model.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] names an input that is not there, a scale that is none, or a number of no cable.
    pub fn validate(&self, inputs: usize) -> Result<(), Error> {
        let CableColumns { tension, motor, anchor, motor_scale, anchor_scale } = self.columns;
        for (name, column) in [("tension", tension), ("motor", motor), ("anchor", anchor)] {
            within(name, "an input of the model", column as f64, column < inputs)?;
        }
        for (name, scale) in [("motor_m_per_unit", motor_scale), ("anchor_m_per_unit", anchor_scale)] {
            let sane = (1e-9..=1e3).contains(&scale.abs());
            within(name, "a number of magnitude 1e-9 to 1e3", scale, sane)?;
        }
        self.model.law()?;
        Ok(())
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
