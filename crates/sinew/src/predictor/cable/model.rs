//! Parameters and inputs of a cable's observer.

use crate::Error;
use crate::error::{finite, positive, within};
use crate::transmission::Warming;
use crate::transmission::cable::{CableLaw, CableParameters, CablePath};
use serde::{Deserialize, Serialize};

/// Parameters of a cable's observer, identified from logs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CableModel {
    /// Sheaths and pulleys along the cable.
    pub path: CablePath,
    /// Friction and elasticity.
    pub parameters: CableParameters,
    /// Number of cells; 8 suffice.
    pub cells: usize,
    /// Gain of the far sensor, 1.
    pub far_gain: f64,
    /// Mobilised fraction of friction at the start of a sequence, -1 to 1: 1 as after sliding toward the
    /// motor. Not observable at rest, but often the same for all logs of one rig.
    #[serde(default)]
    pub start: f64,
    /// Gain of the correction, m/s per N of the innovation.
    #[serde(rename = "correction_m_per_n_s")]
    pub correction: f64,
    /// Gain of the drag's adaptation while the cable slides, 1/(N m): grease warms and ages. 0 for none; 1
    /// suffices. Needs the anchor's measured travel: from a body's geometry, its errors would be adapted as
    /// drag.
    #[serde(rename = "learning_per_n_m", default)]
    pub learning: f64,
    /// How drag falls as friction warms the grease, from the first sample of a sequence on; none where it
    /// does not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub warming: Option<Warming>,
    /// Stretch, m, at zero positions of motor and anchor, where their zeros are fixed: it replaces
    /// [`start`](Self::start). None for incremental encoders.
    #[serde(rename = "zero_stretch_m", default, skip_serializing_if = "Option::is_none")]
    pub zero_stretch: Option<f64>,
}

impl CableModel {
    /// The calibrated bench in 8 cells: initial values of an identification.
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
            warming: None,
            zero_stretch: None,
        }
    }

    /// The law with these parameters.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] names the number outside its domain.
    pub fn law(&self) -> Result<CableLaw, Error> {
        positive("far_gain", self.far_gain)?;
        within("start", "a number in [-1, 1]", self.start, (-1.0..=1.0).contains(&self.start))?;
        let valid = (0.0..=1.0).contains(&self.correction);
        within("correction", "a number in [0, 1] m/(N s)", self.correction, valid)?;
        let valid = (0.0..=100.0).contains(&self.learning);
        within("learning", "a number in [0, 100] 1/(N m)", self.learning, valid)?;
        if let Some(warming) = self.warming {
            warming.check()?;
        }
        if let Some(stretch) = self.zero_stretch {
            finite("zero_stretch", stretch)?;
        }
        CableLaw::new(&self.path, &self.parameters, self.cells)
    }
}

/// Columns of a model's inputs that a cable's observer takes, and their scales.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CableColumns {
    /// Index of the near tension among the inputs.
    pub tension: usize,
    /// Index of the motor's position.
    pub motor: usize,
    /// Index of the anchor's displacement.
    pub anchor: usize,
    /// Newtons per unit of the near tension's column.
    #[serde(rename = "tension_n_per_unit", default = "one", skip_serializing_if = "is_one")]
    pub tension_scale: f64,
    /// Metres toward the motor per unit of the motor's column; negative where it counts the other way.
    #[serde(rename = "motor_m_per_unit")]
    pub motor_scale: f64,
    /// The same for the anchor.
    #[serde(rename = "anchor_m_per_unit")]
    pub anchor_scale: f64,
}

fn one() -> f64 {
    1.0
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes what it serialises by reference")]
fn is_one(scale: &f64) -> bool {
    scale.to_bits() == 1.0_f64.to_bits()
}

impl CableColumns {
    /// The sample in a row of inputs; a column that does not exist is missing.
    #[inline]
    #[must_use]
    pub fn sample(&self, inputs: &[f64]) -> CableSample {
        let of = |i: usize| inputs.get(i).copied().unwrap_or(f64::NAN);
        CableSample {
            motor: self.motor_scale * of(self.motor),
            anchor: self.anchor_scale * of(self.anchor),
            tension_in: self.tension_scale * of(self.tension),
        }
    }
}

/// A cable's observer in a model file: its parameters and its inputs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObservedCable {
    /// Columns of the inputs, and their scales.
    pub columns: CableColumns,
    /// Parameters.
    pub model: CableModel,
}

impl ObservedCable {
    /// Checks all parameters, and the columns against the number of inputs.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] names a column that does not exist, an invalid scale or a parameter outside its
    /// domain.
    pub fn validate(&self, inputs: usize) -> Result<(), Error> {
        let CableColumns { tension, motor, anchor, tension_scale, motor_scale, anchor_scale } = self.columns;
        for (name, column) in [("tension", tension), ("motor", motor), ("anchor", anchor)] {
            within(name, "an input of the model", column as f64, column < inputs)?;
        }
        for (name, scale) in [("motor_m_per_unit", motor_scale), ("anchor_m_per_unit", anchor_scale)] {
            let valid = (1e-9..=1e3).contains(&scale.abs());
            within(name, "a number of magnitude 1e-9 to 1e3", scale, valid)?;
        }
        let valid = (1e-6..=1e6).contains(&tension_scale);
        within("tension_n_per_unit", "a number from 1e-6 to 1e6", tension_scale, valid)?;
        self.model.law()?;
        Ok(())
    }
}

/// One sample of the measurements without a sensor at the anchor.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CableSample {
    /// Position of the winch's surface, m, + toward the motor; any origin.
    pub motor: f64,
    /// Position of the anchor along the cable, m, + toward the motor; from joint sensors, any origin.
    pub anchor: f64,
    /// Tension at the drive's outlet, N; NaN where it is missing.
    pub tension_in: f64,
}
