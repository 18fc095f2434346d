/// Mean, standard deviation and largest value of a magnitude over a run.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Statistics {
    /// Mean.
    pub mean: f64,
    /// Standard deviation, with the number of samples as divisor.
    pub std: f64,
    /// Largest.
    pub max: f64,
    count: f64,
    /// Sum of squared deviations from the mean.
    squares: f64,
}

impl Statistics {
    /// Whether there is no sample.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.count <= 0.0
    }

    /// Adds a sample, >= 0, by Welford's recurrence.
    pub fn record(&mut self, value: f64) {
        self.count += 1.0;
        let deviation = value - self.mean;
        self.mean += deviation / self.count;
        self.squares += deviation * (value - self.mean);
        self.max = self.max.max(value);
        self.std = libm::sqrt(self.squares / self.count);
    }
}
