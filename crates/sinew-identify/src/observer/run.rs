//! Sequences for the observer, and the observer run along them.

use crate::Error;
use sinew::predictor::{CableEstimate, CableModel, CableObserver, CableSample};

/// One uninterrupted sequence of a bench or an arm.
#[derive(Debug, Clone, Default)]
pub struct CableLog {
    /// Seconds since the sample before; not above zero, or beyond 0.02 s, starts afresh: `[n]`.
    pub interval_s: Vec<f64>,
    /// What the observer sees: `[n]`.
    pub samples: Vec<CableSample>,
    /// What the far sensor read, N: `[n]`.
    pub far: Vec<f64>,
    /// 1 where the far sensor counts, 0 where it does not: `[n]`.
    pub weight: Vec<f64>,
}

impl CableLog {
    /// Number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.samples.len()
    }

    /// Whether there is no sample.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.samples.is_empty()
    }

    /// Appends a sample.
    pub fn push(&mut self, interval_s: f64, sample: CableSample, far: f64) {
        self.interval_s.push(interval_s);
        self.samples.push(sample);
        self.far.push(if far.is_finite() { far } else { 0.0 });
        self.weight.push(f64::from(u8::from(far.is_finite())));
    }

    /// Refuses lists of different lengths.
    pub(super) fn check(&self, place: usize) -> Result<(), Error> {
        let n = self.samples.len();
        for (name, got) in
            [("interval_s", self.interval_s.len()), ("far", self.far.len()), ("weight", self.weight.len())]
        {
            if got != n {
                return Err(Error::samples(format!("log {place}, {name}"), format!("{n} entries"), &got));
            }
        }
        let bad = self.far.iter().zip(&self.weight).position(|(y, w)| *w > 0.0 && !y.is_finite());
        match bad {
            Some(row) => Err(Error::samples(
                format!("log {place}, far, sample {row}"),
                "a finite number where the weight is above zero",
                &self.far[row],
            )),
            None => Ok(()),
        }
    }
}

/// The observer's estimates along a log, started anew at its first sample.
///
/// # Errors
/// [`Error::Physics`] where the model is none.
pub fn run_cable(model: &CableModel, log: &CableLog) -> Result<Vec<CableEstimate>, Error> {
    let mut observer = CableObserver::new(model)?;
    Ok(log
        .interval_s
        .iter()
        .zip(&log.samples)
        .map(|(interval, sample)| observer.step(*interval, sample))
        .collect())
}
