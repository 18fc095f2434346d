//! The state of a model along a sequence: clamp cell, cable observer or axis, stop operators, low-pass
//! filters.

use super::axis::{Axis, AxisOutput, AxisState};
use super::cable::{CableEstimate, CablePlace, ObservedCable, SequenceObserver};
use super::conditioner::MAX_MAGNITUDE;
use super::signal::Signal;
use crate::transmission::{ClampCell, ClampStep, saturate};
use alloc::vec;
use alloc::vec::Vec;
use serde::{Deserialize, Serialize};

/// One input of the networks.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Feature {
    /// A signal.
    Signal(usize),
    /// The normalised stop operator of a signal `u`, in [-1, 1]: `(u - p)/r` with the play `p <- clamp(p, u -
    /// r, u + r)`.
    Stop {
        /// Which signal.
        signal: usize,
        /// `r`, half width of the play, signal unit.
        radius: f64,
    },
    /// A signal minus its first-order low-pass: its change within the last `tau_s` seconds.
    LowPassDifference {
        /// Which signal.
        signal: usize,
        /// Time constant, s.
        tau_s: f64,
    },
    /// State of the cell, far unit.
    CellState,
    /// Width of the cell's band, far unit.
    CellWidth,
    /// Position of the state in the band, 0 at the lower bound, 1 at the upper.
    #[serde(rename = "cell_place")]
    CellPosition,
    /// Innovation of the cable's observer: measured minus estimated near tension, N.
    Innovation,
    /// A signal, kept between two bounds.
    Clamped {
        /// Which signal.
        signal: usize,
        /// Lower bound, signal unit.
        low: f64,
        /// Upper bound, signal unit.
        high: f64,
    },
    /// Change of a signal since the sample before, per second.
    Rate(usize),
    /// An earlier feature one sample before; 0 at the first.
    Previous(usize),
    /// The smooth sign of an earlier feature: `x / sqrt(x^2 + scale^2)`.
    Sign {
        /// Index of the feature.
        feature: usize,
        /// Where it is 0.7, in the unit of that feature.
        scale: f64,
    },
    /// A signal minus its maximum since the sequence began: where in its loop it is.
    BelowMaximum(usize),
    /// A signal minus its minimum since the sequence began.
    AboveMinimum(usize),
    /// An earlier feature times a signal.
    Product {
        /// Index of the feature.
        feature: usize,
        /// Which signal.
        signal: usize,
    },
}

/// Signals, physics and features of a model: everything before its networks.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MemoryLaw {
    /// The signals.
    pub signals: Vec<Signal>,
    /// The clamp cell; none in a pure network.
    pub cell: Option<ClampCell>,
    /// The cable observer in place of the cell, where the displacements of both ends are measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cable: Option<ObservedCable>,
    /// A moving mass in place of the cell.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axis: Option<Axis>,
    /// Inputs of the networks.
    pub features: Vec<Feature>,
}

impl MemoryLaw {
    /// Whether there is a cell, a cable or an axis.
    #[must_use]
    pub fn has_physics(&self) -> bool {
        self.cell.is_some() || self.cable.is_some() || self.axis.is_some()
    }
}

/// The cell, or the cable or axis in its place, after a sample.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CellOutput {
    /// Its state: the physical prediction of the far end.
    pub state: f64,
    /// Lower bound.
    pub low: f64,
    /// Upper bound.
    pub high: f64,
    /// Whether a bound was active since the last reset; before, the state depends on its start.
    pub known: bool,
    /// Width of the interval in which the state may be before, far unit; 0 where it is known.
    pub unknown: f64,
}

impl CellOutput {
    /// Until the observer's initial profile has no effect any more, the far end is bounded by sliding in
    /// either direction; then it is known.
    #[inline]
    fn from_cable(estimate: &CableEstimate) -> Self {
        let CableEstimate { far: state, determined: known, .. } = *estimate;
        let (low, high) = if known { (state, state) } else { (estimate.low, estimate.high) };
        Self { state, low: low.min(high), high: high.max(low), known, unknown: (high - low).abs() }
    }

    /// Until its friction has slipped once, the force of an axis is known up to that friction.
    #[inline]
    fn from_axis(output: &AxisOutput) -> Self {
        let AxisOutput { value: state, half_width, known } = *output;
        let half_width = if known { 0.0 } else { half_width };
        let (low, high) = (state - half_width, state + half_width);
        Self { state, low, high, known, unknown: high - low }
    }
}

/// The state of a [`MemoryLaw`] along one sequence.
#[derive(Debug, Clone)]
pub struct Memory {
    signals: Vec<f64>,
    previous: Vec<f64>,
    states: Vec<f64>,
    features: Vec<f64>,
    cell: CellOutput,
    branches: Vec<f64>,
    /// Relative width up to which branches have been at a bound.
    slid: f64,
    observer: Option<SequenceObserver>,
    axis: AxisState,
    started: bool,
}

impl Memory {
    /// The memory before the first sample.
    #[must_use]
    pub fn new(law: &MemoryLaw) -> Self {
        Self {
            signals: vec![0.0; law.signals.len()],
            previous: vec![0.0; law.signals.len()],
            states: vec![0.0; law.features.len()],
            features: vec![0.0; law.features.len()],
            cell: CellOutput::default(),
            branches: vec![0.0; law.cell.as_ref().map_or(0, |c| c.branches.len())],
            slid: 0.0,
            observer: law.cable.as_ref().and_then(SequenceObserver::new),
            axis: AxisState::default(),
            started: false,
        }
    }

    /// Clears the state: the next sample starts a new sequence.
    pub fn reset(&mut self) {
        self.started = false;
    }

    /// Advances by one sample, `dt_s` after the one before. The first sample of a sequence starts the cell at
    /// `far`, projected onto its band, where the far end is measured (training), else at [`ClampCell::start`]
    /// (prediction). `inputs: [inputs of the model]`.
    pub fn step_from(&mut self, law: &MemoryLaw, dt_s: f64, inputs: &[f64], far: Option<f64>) {
        self.read_signals(law, inputs);
        if let Some(cell) = &law.cell {
            self.step_cell(cell, far);
        } else if let Some(observer) = &mut self.observer {
            self.cell = CellOutput::from_cable(&observer.step(self.started, dt_s, inputs));
        } else if let Some(axis) = &law.axis {
            self.cell = CellOutput::from_axis(&self.axis.step(axis, self.started, dt_s, &self.signals, far));
        }
        self.finish(law, dt_s);
    }

    /// Advances by one sample after the first whose near tension of the observed cable is not known: it is
    /// what the observer expects, and is written to `inputs`. Without an observer as [`step`](Self::step).
    pub(super) fn step_expecting(&mut self, law: &MemoryLaw, dt_s: f64, inputs: &mut [f64], tension: usize) {
        let Some(observer) = &mut self.observer else { return self.step(law, dt_s, inputs) };
        // A tension that is missing corrects nothing, as one that is expected does.
        inputs[tension] = f64::NAN;
        let estimate = observer.step(self.started, dt_s, inputs);
        inputs[tension] = estimate.tension_in / observer.tension_scale();
        self.cell = CellOutput::from_cable(&estimate);
        self.read_signals(law, inputs);
        self.finish(law, dt_s);
    }

    /// Where the observed cable is; none without one, and before the first sample.
    pub(super) fn cable_place(&self) -> Option<CablePlace> {
        self.observer.as_ref()?.place()
    }

    /// Takes over the state of a memory of the same law; nothing is allocated.
    pub(super) fn copy_state(&mut self, from: &Self) {
        self.signals.copy_from_slice(&from.signals);
        self.previous.copy_from_slice(&from.previous);
        self.states.copy_from_slice(&from.states);
        self.features.copy_from_slice(&from.features);
        self.branches.copy_from_slice(&from.branches);
        if let (Some(observer), Some(from)) = (&mut self.observer, &from.observer) {
            observer.copy_state(from);
        }
        self.axis.clone_from(&from.axis);
        (self.cell, self.slid, self.started) = (from.cell, from.slid, from.started);
    }

    #[inline]
    fn read_signals(&mut self, law: &MemoryLaw, inputs: &[f64]) {
        for (value, signal) in self.signals.iter_mut().zip(&law.signals) {
            *value = signal.value(inputs);
        }
    }

    #[inline]
    fn finish(&mut self, law: &MemoryLaw, dt_s: f64) {
        self.step_features(law, dt_s);
        self.previous.copy_from_slice(&self.signals);
        self.started = true;
    }

    /// Advances by one sample, `dt_s` after the one before; the far end is not measured.
    #[inline]
    pub fn step(&mut self, law: &MemoryLaw, dt_s: f64, inputs: &[f64]) {
        self.step_from(law, dt_s, inputs, None);
    }

    /// The features after the last sample: `[law.features]`.
    #[inline]
    #[must_use]
    pub fn features(&self) -> &[f64] {
        &self.features
    }

    /// The signals of the last sample: `[law.signals]`.
    #[inline]
    #[must_use]
    pub fn signals(&self) -> &[f64] {
        &self.signals
    }

    /// The cell after the last sample; zeros where the law has none.
    #[inline]
    #[must_use]
    pub fn cell(&self) -> CellOutput {
        self.cell
    }

    #[inline]
    fn step_cell(&mut self, cell: &ClampCell, far: Option<f64>) {
        let step = if self.started {
            cell.step(&mut self.branches, &self.signals, &self.previous)
        } else {
            cell.start(&mut self.branches, &self.signals, far)
        };
        let before = if self.started { self.slid } else { f64::from(u8::from(far.is_some())) };
        let ClampStep { state, low, high, slid } = step;
        self.slid = if slid > before { slid } else { before };
        let unknown = cell.unknown_width(self.slid, low, high);
        self.cell = CellOutput { state, low, high, known: self.slid >= 1.0, unknown };
    }

    #[inline]
    fn step_features(&mut self, law: &MemoryLaw, dt_s: f64) {
        let width = self.cell.high - self.cell.low;
        for (k, (state, feature)) in self.states.iter_mut().zip(&law.features).enumerate() {
            self.features[k] = match *feature {
                Feature::Signal(i) => self.signals[i],
                Feature::Clamped { signal, low, high } => saturate(self.signals[signal], low, high),
                Feature::Stop { signal, radius } => {
                    let u = self.signals[signal];
                    let play = if self.started { *state } else { u };
                    *state = saturate(play, u - radius, u + radius);
                    (u - *state) / radius
                }
                Feature::LowPassDifference { signal, tau_s } => {
                    let u = self.signals[signal];
                    let low_pass = if self.started { *state } else { u };
                    *state = low_pass + (u - low_pass) * dt_s / (dt_s + tau_s);
                    u - *state
                }
                Feature::CellState => self.cell.state,
                Feature::CellWidth => width,
                Feature::Innovation => self.observer.as_ref().map_or(0.0, |observer| observer.innovation),
                Feature::CellPosition => (self.cell.state - self.cell.low) / width.max(1e-12),
                Feature::Rate(i) if self.started && dt_s > 0.0 => {
                    let rate = (self.signals[i] - self.previous[i]) / dt_s;
                    saturate(rate, -MAX_MAGNITUDE, MAX_MAGNITUDE)
                }
                Feature::Rate(_) => 0.0,
                Feature::Previous(i) => {
                    let before = if self.started { *state } else { 0.0 };
                    *state = self.features[i];
                    before
                }
                Feature::Sign { feature, scale } => {
                    let x = self.features[feature] / scale;
                    x / libm::sqrt(1.0 + x * x)
                }
                Feature::BelowMaximum(i) => {
                    let u = self.signals[i];
                    *state = if self.started { state.max(u) } else { u };
                    u - *state
                }
                Feature::AboveMinimum(i) => {
                    let u = self.signals[i];
                    *state = if self.started { state.min(u) } else { u };
                    u - *state
                }
                Feature::Product { feature, signal } => self.features[feature] * self.signals[signal],
            };
        }
    }
}
