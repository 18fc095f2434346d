//! Linear regression on the features of a law.

use super::conditioner::MAX_MAGNITUDE;
use super::model_file_error::{ModelFileError, require};
use alloc::format;
use alloc::vec::Vec;
use serde::{Deserialize, Serialize};

/// A linear regression, which goes on beyond the training data.
///
/// ```text
/// y = b + sum_i a_i x_i
/// ```
///
/// | symbol | field               | meaning      | unit          |
/// |--------|---------------------|--------------|---------------|
/// | x      | `law.features`      | features     | \[x\]         |
/// | a, b   | `weights`, `offset` | coefficients | far/\[x\], far |
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LinearLaw {
    /// `b`.
    pub offset: f64,
    /// `a`: `[features]`.
    pub weights: Vec<f64>,
}

impl LinearLaw {
    /// The far end, far unit; `features: [features]`.
    #[inline]
    #[must_use]
    pub fn value(&self, features: &[f64]) -> f64 {
        let mut sum = self.offset;
        for (weight, x) in self.weights.iter().zip(features) {
            sum += weight * x;
        }
        sum
    }

    pub(super) fn validate(&self, features: usize) -> Result<(), ModelFileError> {
        let count = self.weights.len();
        require("linear.weights", &format!("{features} numbers"), count == features, count)?;
        for value in self.weights.iter().chain([&self.offset]) {
            require("linear", "numbers within +-1e30", value.abs() <= MAX_MAGNITUDE, value)?;
        }
        Ok(())
    }
}
