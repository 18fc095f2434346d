//! Linear regression on the features of a law.

use super::conditioner::MAX_MAGNITUDE;
use super::model_file_error::{ModelFileError, require};
use crate::transmission::saturate;
use alloc::format;
use alloc::vec::Vec;
use serde::{Deserialize, Serialize};

/// A linear regression.
///
/// ```text
/// y = b + sum_i a_i clamp(x_i, low_i, high_i)
/// ```
///
/// | symbol    | field                 | meaning                                            | unit        |
/// |-----------|-----------------------|----------------------------------------------------|-------------|
/// | x         | `law.features`        | features                                           | \[x\]       |
/// | a, b      | `weights`, `offset`   | coefficients                                       | far/\[x\], far |
/// | low, high | `clip_low`, `clip_high` | where a feature stops to count; -1e30 and 1e30: never | \[x\]       |
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LinearLaw {
    /// `b`.
    pub offset: f64,
    /// `a`: `[features]`.
    pub weights: Vec<f64>,
    /// Lower edges: `[features]`.
    pub clip_low: Vec<f64>,
    /// Upper edges: `[features]`.
    pub clip_high: Vec<f64>,
}

impl LinearLaw {
    /// The far end, far unit; `features: [features]`.
    #[inline]
    #[must_use]
    pub fn value(&self, features: &[f64]) -> f64 {
        let edges = self.clip_low.iter().zip(&self.clip_high);
        let mut sum = self.offset;
        for ((weight, x), (low, high)) in self.weights.iter().zip(features).zip(edges) {
            sum += weight * saturate(*x, *low, *high);
        }
        sum
    }

    pub(super) fn validate(&self, features: usize) -> Result<(), ModelFileError> {
        let Self { offset, weights, clip_low, clip_high } = self;
        for (name, list) in
            [("linear.weights", weights), ("linear.clip_low", clip_low), ("linear.clip_high", clip_high)]
        {
            require(name, &format!("{features} numbers"), list.len() == features, list.len())?;
        }
        for value in weights.iter().chain(clip_low).chain(clip_high).chain([offset]) {
            require("linear", "numbers within +-1e30", value.abs() <= MAX_MAGNITUDE, value)?;
        }
        let ordered = clip_low.iter().zip(clip_high).all(|(low, high)| low <= high);
        require("linear.clip_low", "at most clip_high", ordered, "above it")
    }
}
