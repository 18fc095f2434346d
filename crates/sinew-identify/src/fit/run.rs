//! One sequence of a log as a fit reads it.

/// One sequence ready for fitting: finite, conditioned as the predictor conditions its samples.
#[derive(Debug, Clone)]
pub(crate) struct Run {
    /// Which log it is from.
    pub log: usize,
    /// Seconds since the sample before, 0 at the first: `[n]`.
    pub dt_s: Vec<f64>,
    /// `[n x width]` row-major.
    pub inputs: Vec<f64>,
    /// Far side to fit: `[n]`.
    pub far: Vec<f64>,
    /// 1 where a sample counts: `[n]`.
    pub weight: Vec<f64>,
    /// Inputs per row.
    pub width: usize,
}

impl Run {
    /// Number of samples.
    #[must_use]
    pub(crate) fn len(&self) -> usize {
        self.far.len()
    }

    /// Inputs of one sample.
    pub(crate) fn row(&self, i: usize) -> &[f64] {
        &self.inputs[i * self.width..][..self.width]
    }
}
