//! The forward model on a copy of the state.

use crate::predictor::{Prediction, Predictor, Sample};

/// What the model says of one sample for any value in one of its columns.
pub(super) struct Response<'a> {
    /// The state from which the sample is predicted.
    pub(super) from: &'a Predictor,
    /// Room for the copy.
    pub(super) trial: &'a mut Predictor,
    pub(super) time_s: f64,
    /// The inputs of the sample.
    pub(super) given: &'a [f64],
    /// Room for the inputs with the value.
    pub(super) row: &'a mut [f64],
    /// The column of the value.
    pub(super) column: usize,
    /// The column of a near tension that is what the model expects.
    pub(super) expected: Option<usize>,
    /// Evaluations so far.
    pub(super) count: u32,
}

impl Response<'_> {
    /// The prediction with `value` in the column. Afterwards `row` holds the inputs, an expected tension
    /// among them, and `trial` the state.
    pub(super) fn at(&mut self, value: f64) -> Prediction {
        self.count += 1;
        self.trial.copy_state(self.from);
        self.row.copy_from_slice(self.given);
        self.row[self.column] = value;
        match self.expected {
            None => self.trial.step(&Sample { time_s: self.time_s, inputs: self.row }),
            Some(tension) => {
                let prediction = self.trial.step_expecting(self.time_s, self.row, tension);
                // Other inputs that are missing stay so.
                let found = self.row[tension];
                self.row.copy_from_slice(self.given);
                self.row[self.column] = value;
                self.row[tension] = found;
                prediction
            }
        }
    }
}
