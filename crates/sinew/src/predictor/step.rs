//! The predictor: one prediction per sample.

use super::cable::CablePlace;
use super::conditioner::{Conditioner, SampleKind};
use super::estimator::{Estimate, EstimatorState};
use super::model::Model;
use super::model_file_error::ModelFileError;
use super::specimen::{LoopState, SpecimenDeviation};

/// One sample of the near side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample<'a> {
    /// Time, s; any origin.
    pub time_s: f64,
    /// One value per [`Model::inputs`], in that order and in the units of the training logs; NaN for missing.
    pub inputs: &'a [f64],
}

/// Conditions under which a prediction was made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Flags {
    /// The state in the dead band depends on its start: no bound was active since the last reset.
    pub state_unknown: bool,
    /// An input lies outside the range of the training logs, or a network input outside its box.
    pub out_of_range: bool,
    /// An input was missing or jumped and was replaced by its last value.
    pub input_held: bool,
    /// All states were reset at this sample: the first one, after a gap, or where time runs backwards.
    pub reset: bool,
    /// The time stamp equals that of the sample before: the prediction is repeated.
    pub repeated: bool,
    /// The loops of this sequence are not those of the specimen in training
    /// ([`SpecimenMonitor`](super::SpecimenMonitor)): neither the expected error nor the band holds.
    pub other_specimen: bool,
}

/// Prediction of the far end at one sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prediction {
    /// The far end, in the unit of the training logs.
    pub mean: f64,
    /// Standard deviation: `mean +- 1.96 standard_deviation` is the calibrated 95 % band.
    pub standard_deviation: f64,
    /// Gate on the learned correction, 0 to 1.
    pub gate: f64,
    /// Conditions under which it was made.
    pub flags: Flags,
}

/// Half width of a 95 % band in standard deviations.
pub(super) const BAND_95: f64 = 1.96;

impl Prediction {
    /// Half width of the 95 % band.
    #[inline]
    #[must_use]
    pub fn half_width(&self) -> f64 {
        BAND_95 * self.standard_deviation
    }
}

/// Predicts the far end of one transmission from its near side, sample by sample.
///
/// [`step`](Self::step) does not allocate, lock or call the system, and cannot fail: missing and implausible
/// inputs are replaced by the last accepted value and flagged, so that a valid model gives finite
/// predictions.
///
/// # Example
/// ```
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # use sinew::predictor::{Estimator, InputLimits, Input, MemoryLaw, Provenance, Role, Signal};
/// # use sinew::transmission::{Branch, ClampCell, BasisTerm};
/// # let cell = ClampCell {
/// #     basis: vec![BasisTerm::Signal(0)], low: vec![0.8], high: vec![1.25], elastic: vec![], kappa: vec![],
/// #     start: 0.5,
/// #     branches: vec![Branch { width: 1.0, fraction: 1.0 }],
/// # };
/// # let law = MemoryLaw { signals: vec![Signal::Input(0)], cell: Some(cell), cable: None, axis: None, features: vec![] };
/// # let text = Model {
/// #     far: "tension_out_n".into(), time: None, trial: None, gap_s: 0.1, band_factor: 2.0, specimen: None, offset: None, outside: None, units: Default::default(),
/// #     inputs: vec![Input { column: "tension_in_n".into(), role: Role::Effort }],
/// #     guards: vec![InputLimits { jump: 1e3, low: 0.0, high: 300.0, typical: 100.0 }],
/// #     estimator: Estimator { sigma0: 1.0, ..Estimator::of(law) },
/// #     provenance: Provenance {
/// #         member: "cell".into(), description: "by hand".into(), program: "none".into(), seed: 1,
/// #         logs: vec![], samples: 0, rmse_unseen: 1.0, far_range: 200.0,
/// #     },
/// # }.to_json()?;
/// use sinew::predictor::{Model, Predictor, Sample};
///
/// let model = Model::from_json(&text)?; // the text of a model.json
/// let mut predictor = Predictor::new(model)?;
/// let pulled = predictor.step(&Sample { time_s: 0.0, inputs: &[100.0] });
/// assert!(pulled.flags.state_unknown); // no bound was active yet
/// let pulled = predictor.step(&Sample { time_s: 0.001, inputs: &[200.0] });
/// let eased = predictor.step(&Sample { time_s: 0.002, inputs: &[150.0] });
/// assert_eq!(pulled.mean, eased.mean); // inside the dead band the far end does not move
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone)]
pub struct Predictor {
    model: Model,
    conditioner: Conditioner,
    state: EstimatorState,
    loops: LoopState,
    specimen: Option<SpecimenDeviation>,
    readings: Readings,
    last: Prediction,
}

/// Readings of the far end since the last reset.
#[derive(Debug, Clone, Copy, Default)]
struct Readings {
    /// Whether there was a sample.
    sampled: bool,
    count: f64,
    /// Sum of far end minus prediction without offset.
    errors: f64,
    /// Added to every prediction.
    offset: f64,
}

impl Predictor {
    /// A predictor before its first sample.
    ///
    /// # Errors
    /// As [`Model::validate`].
    pub fn new(model: Model) -> Result<Self, ModelFileError> {
        model.validate()?;
        Ok(Self {
            conditioner: Conditioner::new(model.inputs.len()),
            state: EstimatorState::new(&model.estimator),
            loops: LoopState::default(),
            specimen: None,
            readings: Readings::default(),
            last: Prediction { mean: 0.0, standard_deviation: 0.0, gate: 0.0, flags: Flags::default() },
            model,
        })
    }

    /// The model.
    #[must_use]
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// Resets all states: the next sample starts a new sequence.
    pub fn reset(&mut self) {
        self.conditioner.reset();
        self.state.reset();
        self.loops.reset();
        self.specimen = None;
        self.readings = Readings::default();
    }

    /// Takes a reading of the far end at the last sample, as a homing or a stop gives it: later predictions
    /// are moved by its shrunken error.
    ///
    /// ```text
    /// b = t sum_k e_k / (n t + s)
    /// ```
    ///
    /// `e_k` are the errors at the `n` readings since the last [`reset`](Self::reset), `t` and `s` the
    /// variances of [`Model::offset`]: where errors of a recording are mostly its offset, a reading counts in
    /// full; where they change within it, hardly. Returns `b`, far unit; `None`, and nothing changes, without
    /// a sample before, for a number that is not finite, or where the model has no [`Model::offset`].
    pub fn read_far_end(&mut self, far: f64) -> Option<f64> {
        let variance = self.model.offset?;
        if !(far.is_finite() && self.readings.sampled) {
            return None;
        }
        let Readings { offset, count, errors, .. } = &mut self.readings;
        *count += 1.0;
        *errors += far - (self.last.mean - *offset);
        *offset = variance.between * *errors / (*count * variance.between + variance.within);
        Some(*offset)
    }

    /// How unlike the specimen in training this sequence is; `None` before its first loop, and where the
    /// model has no monitor.
    #[must_use]
    pub fn specimen(&self) -> Option<SpecimenDeviation> {
        self.specimen
    }

    /// Predicts the far end at one sample.
    #[inline]
    pub fn step(&mut self, sample: &Sample<'_>) -> Prediction {
        let model = &self.model;
        let kind = self.conditioner.update(&model.guards, model.gap_s, sample.time_s, sample.inputs);
        if kind == SampleKind::Repeated {
            self.last.flags.repeated = true;
            self.last.flags.reset = false;
            return self.last;
        }
        if kind == SampleKind::First {
            self.state.reset();
        }
        let (dt_s, inputs) = (self.conditioner.dt_s(), self.conditioner.values());
        let estimate = self.state.step(&model.estimator, dt_s, inputs);
        self.conclude(kind, &estimate)
    }

    /// Prediction at a sample without a near tension of the observed cable, which is input `tension` and is
    /// then what the model expects. `inputs`, one per input, become those that the model took.
    pub(crate) fn step_expecting(&mut self, time_s: f64, inputs: &mut [f64], tension: usize) -> Prediction {
        let model = &self.model;
        let kind = self.conditioner.update(&model.guards, model.gap_s, time_s, inputs);
        if kind != SampleKind::Next {
            // Nothing is expected at the first sample of a sequence.
            self.state.reset();
        }
        inputs.copy_from_slice(self.conditioner.values());
        let dt_s = self.conditioner.dt_s();
        let estimate = self.state.step_expecting(&model.estimator, dt_s, inputs, tension);
        self.conclude(kind, &estimate)
    }

    /// What a sample would be to this predictor: its kind, the seconds since the one before, and the inputs
    /// as it would take them.
    pub(crate) fn arrival(&mut self, time_s: f64, inputs: &[f64]) -> (SampleKind, f64, &[f64]) {
        let model = &self.model;
        let kind = self.conditioner.update(&model.guards, model.gap_s, time_s, inputs);
        (kind, self.conditioner.dt_s(), self.conditioner.values())
    }

    /// The mean of the last prediction.
    pub(crate) fn last_mean(&self) -> f64 {
        self.last.mean
    }

    /// Where the observed cable is; none without one, and before the first sample.
    pub(crate) fn cable_place(&self) -> Option<CablePlace> {
        self.state.cable_place()
    }

    /// Takes over the state of a predictor of the same model; nothing is allocated.
    pub(crate) fn copy_state(&mut self, from: &Self) {
        self.conditioner.copy_state(&from.conditioner);
        self.state.copy_state(&from.state);
        (self.loops, self.specimen, self.readings, self.last) =
            (from.loops, from.specimen, from.readings, from.last);
    }

    #[inline]
    fn conclude(&mut self, kind: SampleKind, estimate: &Estimate) -> Prediction {
        let (model, inputs) = (&self.model, self.conditioner.values());
        if kind == SampleKind::First {
            self.loops.reset();
            self.specimen = None;
        }
        if let Some(monitor) = &model.specimen {
            let (motion, effort) = (inputs[monitor.motion], inputs[monitor.effort]);
            if self.loops.step(monitor.reversal, self.conditioner.dt_s(), motion, effort) {
                self.specimen = monitor.deviation(self.loops.loops(), inputs);
            }
        }
        self.readings.sampled = true;
        let outside = inputs.iter().zip(&model.guards).any(|(v, limit)| *v < limit.low || *v > limit.high);
        let out_of_range = outside || estimate.clipped > 0;
        let beyond = model.outside.as_ref().filter(|_| out_of_range);
        let band_factor = beyond.map_or(model.band_factor, |outside| outside.band_factor);
        self.last = Prediction {
            mean: estimate.mean + self.readings.offset,
            standard_deviation: band_factor * libm::sqrt(estimate.variance) / BAND_95,
            gate: estimate.gate,
            flags: Flags {
                state_unknown: !estimate.known,
                out_of_range,
                input_held: self.conditioner.any_held(),
                reset: kind == SampleKind::First,
                repeated: false,
                other_specimen: self.specimen.is_some_and(|found| found.excess > 1.0),
            },
        };
        self.last
    }
}
