//! What a command may do.

use crate::Error;
use crate::error::{finite, non_negative, positive, within};
use crate::predictor::{Model, Role};

/// What a command may do; what is left out follows from the model.
///
/// | field       | unit        | domain      | where it is left out                                          |
/// |-------------|-------------|-------------|---------------------------------------------------------------|
/// | `near`      | index       | an effort or motion | the motor of a cable's observer; else the first effort, else the first motion |
/// | `min`, `max` | near        | min < max   | training range widened by itself at either side, a tension not below 0; none for a cable's motor |
/// | `rate`      | near per s  | > 0         | of a cable's motor: its range in training in a second; else none but the largest change that the model accepts from one sample to the next |
/// | `tolerance` | far         | >= 0        | 2e-7 of the range of the far side in training                    |
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CompensatorSettings {
    /// Index of the input that is commanded.
    pub near: Option<usize>,
    /// Smallest command.
    pub min: Option<f64>,
    /// Largest command.
    pub max: Option<f64>,
    /// Largest rate of the command: what the drive can follow, also across the dead band.
    pub rate: Option<f64>,
    /// Error of the far end that is no reason to move. Above the noise of the desired far end, it keeps the
    /// command from crossing the dead band to and fro.
    pub tolerance: Option<f64>,
}

/// Settings with every default filled in.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limits {
    pub(super) near: usize,
    pub(super) min: f64,
    pub(super) max: f64,
    pub(super) rate: f64,
    pub(super) tolerance: f64,
}

impl Limits {
    /// Smallest and largest command.
    pub(super) fn range(&self) -> [f64; 2] {
        [self.min, self.max]
    }
}

/// Fraction of the far side's range in training that counts as attained.
const TOLERANCE: f64 = 2e-7;

/// Largest command of a cable's motor in any unit: a position has no range.
const UNLIMITED: f64 = 1e12;

impl CompensatorSettings {
    /// The input that is commanded, as set or where it is left out, if the model has one.
    #[must_use]
    pub fn near_of(&self, model: &Model) -> Option<usize> {
        let first = |role: Role| model.inputs.iter().position(|input| input.role == role);
        self.near.or_else(|| match &model.estimator.law.cable {
            Some(cable) => Some(cable.columns.motor),
            None => first(Role::Effort).or_else(|| first(Role::Motion)),
        })
    }

    /// # Errors
    /// [`Error::OutOfDomain`] names the setting.
    pub(super) fn limits(&self, model: &Model, near: usize) -> Result<Limits, Error> {
        let [low, high] = range(model, near);
        let min = finite("min", self.min.unwrap_or(low))?;
        let max = finite("max", self.max.unwrap_or(high))?;
        within("max", "a number above min", max, max > min)?;
        let rate = self.rate.map_or(Ok(usual_rate(model, near)), |rate| positive("rate", rate))?;
        let tolerance = self.tolerance.unwrap_or(TOLERANCE * model.provenance.far_range.abs());
        Ok(Limits { near, min, max, rate, tolerance: non_negative("tolerance", tolerance)? })
    }
}

/// Largest rate where none is set: a cable's motor passes its range in training in a second.
fn usual_rate(model: &Model, near: usize) -> f64 {
    let guard = &model.guards[near];
    let is_motor = model.estimator.law.cable.as_ref().is_some_and(|cable| cable.columns.motor == near);
    if is_motor && guard.high > guard.low { guard.high - guard.low } else { f64::INFINITY }
}

/// Smallest and largest value of an input where none is set.
pub(super) fn range(model: &Model, near: usize) -> [f64; 2] {
    if model.estimator.law.cable.as_ref().is_some_and(|cable| cable.columns.motor == near) {
        return [-UNLIMITED, UNLIMITED];
    }
    let (low, high) = (model.guards[near].low, model.guards[near].high);
    let width = (high - low).abs().max(f64::MIN_POSITIVE);
    let tension = model.inputs[near].role == Role::Effort && low > -0.02 * width;
    [if tension { low.min(0.0) } else { low - width }, high + width]
}
