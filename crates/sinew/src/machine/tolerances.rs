use crate::Error;
use crate::error::{non_negative, within};
use serde::{Deserialize, Serialize};

/// Manufacturing tolerances: bounds of the difference between a machine as built and its design.
///
/// Every number is uniform within its bounds. Cables scatter by their own statistics, those of the bench.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Tolerances {
    /// Relative, of every mass and, independently, of every inertia.
    pub mass: f64,
    /// Of every coordinate of every site of a tendon, m; none: as
    /// [`Machine::attachment_tolerance`](super::Machine::attachment_tolerance).
    #[serde(rename = "attachment_m")]
    pub attachment: Option<f64>,
    /// Relative, of the load cells' gain.
    pub gain: f64,
    /// Relative, of the changes of sheaths' bends with the joints.
    #[serde(rename = "bend_by_joint")]
    pub bend: f64,
    /// Of the joint encoders' zero, rad.
    #[serde(rename = "zero_rad")]
    pub zero: f64,
    /// The same of slides, m.
    #[serde(rename = "zero_m")]
    pub zero_slide: f64,
}

impl Default for Tolerances {
    /// 10 %, 1 mm, 0.5 %, 20 % of the bends, 1 mrad, 0.1 mm: assumed for careful manufacturing.
    fn default() -> Self {
        Self { mass: 0.1, attachment: None, gain: 5e-3, bend: 0.2, zero: 1e-3, zero_slide: 1e-4 }
    }
}

impl Tolerances {
    /// Checks every number.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] names the number outside its domain.
    pub fn validate(&self) -> Result<(), Error> {
        let fraction = (0.0..1.0).contains(&self.mass);
        within("mass tolerance", "a number in [0, 1)", self.mass, fraction)?;
        let fraction = (0.0..1.0).contains(&self.gain);
        within("gain tolerance", "a number in [0, 1)", self.gain, fraction)?;
        let fraction = (0.0..1.0).contains(&self.bend);
        within("bend tolerance", "a number in [0, 1)", self.bend, fraction)?;
        self.attachment.map_or(Ok(0.0), |bound| non_negative("attachment tolerance", bound))?;
        non_negative("zero tolerance", self.zero)?;
        non_negative("zero tolerance of slides", self.zero_slide).map(drop)
    }
}
