//! The predictor: one sample in, one prediction out.

use super::conditioner::{Conditioner, SampleKind};
use super::memory::Memory;
use super::model::Model;
use super::model_file_error::ModelFileError;
use alloc::vec;
use alloc::vec::Vec;

/// One sample of the near side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample<'a> {
    /// Time, s; any origin.
    pub time_s: f64,
    /// One value per [`Model::inputs`], in that order and in the units of the training logs; NaN for missing.
    pub inputs: &'a [f64],
}

/// What should be known about a prediction before it is used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Flags {
    /// The state inside the dead band is a guess: no bound was touched since the last reset.
    pub state_unknown: bool,
    /// An input lies outside the range of the training logs, or a network input outside its box.
    pub out_of_range: bool,
    /// An input was missing or jumped and was held at its last value.
    pub input_held: bool,
    /// All states were forgotten at this sample: the first one, one after a gap, or time ran backwards.
    pub reset: bool,
    /// The time stamp of the sample before: the prediction is repeated.
    pub repeated: bool,
}

/// The far end as predicted after a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prediction {
    /// The far end, in the unit of the training logs.
    pub mean: f64,
    /// Standard deviation: `mean +- 1.96 standard_deviation` is the calibrated 95 % band.
    pub standard_deviation: f64,
    /// Trust in the learned correction, 0 to 1.
    pub gate: f64,
    /// What should be known before it is used.
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
/// No allocation, no lock, no system call in [`step`](Self::step). Any sample is answered: what is missing or
/// beyond belief is held and flagged, never passed on, so a finite model gives finite predictions.
///
/// # Example
/// ```
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # use sinew::predictor::{Estimator, InputLimits, Input, MemoryLaw, Provenance, Role, Signal};
/// # use sinew::transmission::{Branch, ClampCell, BasisTerm};
/// # let cell = ClampCell {
/// #     basis: vec![BasisTerm::Signal(0)], low: vec![0.8], high: vec![1.25], elastic: vec![], kappa: vec![],
/// #     start: 0.5,
/// #     branches: vec![Branch { width: 1.0, share: 1.0 }],
/// # };
/// # let law = MemoryLaw { signals: vec![Signal::Input(0)], cell: Some(cell), cable: None, features: vec![] };
/// # let text = Model {
/// #     far: "tension_out_n".into(), time: None, trial: None, gap_s: 0.1, band_factor: 2.0,
/// #     inputs: vec![Input { column: "tension_in_n".into(), role: Role::Effort }],
/// #     guards: vec![InputLimits { jump: 1e3, low: 0.0, high: 300.0, typical: 100.0 }],
/// #     estimator: Estimator { law, ensemble: None, gate_power: None, perceptron: None, sigma0: 1.0 },
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
/// assert!(pulled.flags.state_unknown); // nobody knows yet where in its dead band the cable sits
/// let pulled = predictor.step(&Sample { time_s: 0.001, inputs: &[200.0] });
/// let eased = predictor.step(&Sample { time_s: 0.002, inputs: &[150.0] });
/// assert_eq!(pulled.mean, eased.mean); // the far end has not noticed yet
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone)]
pub struct Predictor {
    model: Model,
    conditioner: Conditioner,
    memory: Memory,
    scratch: Vec<f32>,
    last: Prediction,
}

impl Predictor {
    /// A predictor that has seen nothing.
    ///
    /// # Errors
    /// As [`Model::validate`].
    pub fn new(model: Model) -> Result<Self, ModelFileError> {
        model.validate()?;
        Ok(Self {
            conditioner: Conditioner::new(model.inputs.len()),
            memory: Memory::new(&model.estimator.law),
            scratch: vec![0.0; model.estimator.law.features.len()],
            last: Prediction { mean: 0.0, standard_deviation: 0.0, gate: 0.0, flags: Flags::default() },
            model,
        })
    }

    /// The model it runs.
    #[must_use]
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// Forgets all states: the next sample starts a new trial.
    pub fn reset(&mut self) {
        self.conditioner.reset();
        self.memory.reset();
    }

    /// Takes a sample and predicts the far end.
    #[inline]
    pub fn step(&mut self, sample: &Sample<'_>) -> Prediction {
        let model = &self.model;
        let step = self.conditioner.update(&model.guards, model.gap_s, sample.time_s, sample.inputs);
        if step == SampleKind::Repeated {
            self.last.flags.repeated = true;
            self.last.flags.reset = false;
            return self.last;
        }
        if step == SampleKind::First {
            self.memory.reset();
        }
        let inputs = self.conditioner.values();
        self.memory.step(&model.estimator.law, self.conditioner.dt_s(), inputs);
        let estimate = model.estimator.estimate(&self.memory, &mut self.scratch);
        let outside = inputs.iter().zip(&model.guards).any(|(v, g)| *v < g.low || *v > g.high);
        self.last = Prediction {
            mean: estimate.mean,
            standard_deviation: model.band_factor * libm::sqrt(estimate.variance) / BAND_95,
            gate: estimate.gate,
            flags: Flags {
                state_unknown: !estimate.known,
                out_of_range: outside || estimate.clipped > 0,
                input_held: self.conditioner.any_held(),
                reset: step == SampleKind::First,
                repeated: false,
            },
        };
        self.last
    }
}
