//! What a training may be told.

use crate::Error;

/// Options of [`train`](super::train).
#[derive(Debug, Clone, PartialEq)]
pub struct TrainOptions {
    /// Hidden nodes, 1 to 512.
    pub hidden: usize,
    /// Most steps, each with one evaluation of the normal equations.
    pub steps: usize,
    /// Seed of the initial weights.
    pub seed: u64,
    /// Stop once five steps together lower the loss by less than this fraction of it; 0 never stops.
    pub tolerance: f64,
    /// Fraction of the samples, at the end, that are held back: training stops after six steps that did not
    /// lower the loss on them and returns the weights that were best on them. 0 holds nothing back; below 1.
    pub held_back: f64,
}

impl Default for TrainOptions {
    /// 30 nodes, 200 steps, nothing held back.
    fn default() -> Self {
        Self { hidden: 30, steps: 200, seed: 0, tolerance: 1e-6, held_back: 0.0 }
    }
}

impl TrainOptions {
    pub(super) fn check(&self) -> Result<(), Error> {
        if !(1..=512).contains(&self.hidden) {
            return Err(Error::samples("hidden", "1 to 512 nodes", &self.hidden));
        }
        if !(self.tolerance >= 0.0 && self.tolerance < 1.0) {
            return Err(Error::samples("tolerance", "at least 0 and below 1", &self.tolerance));
        }
        if !(self.held_back >= 0.0 && self.held_back < 1.0) {
            return Err(Error::samples("held_back", "at least 0 and below 1", &self.held_back));
        }
        Ok(())
    }
}
