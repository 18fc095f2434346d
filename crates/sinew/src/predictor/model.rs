//! The model of one transmission: inputs, limits, estimator, calibrated band, provenance.

use super::conditioner::{InputLimits, MAX_MAGNITUDE};
use super::ensemble::{Ensemble, PerNetwork};
use super::estimator::Estimator;
use super::memory::{Feature, MemoryLaw};
use super::model_file_error::{ModelFileError, require};
use super::specimen::SpecimenMonitor;
use crate::transmission::{BasisTerm, ClampCell};
use alloc::collections::BTreeMap;
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use serde::{Deserialize, Serialize};

/// Role of a column in the transmission.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// A tension or torque at the near side.
    Effort,
    /// A position or stroke at the near side.
    Motion,
    /// The displacement of the far end, where a joint sensor measures it.
    Anchor,
    /// A slow quantity, such as a joint angle or the bend of the sheath.
    Given,
}

/// One input of a model: a column with its role.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Input {
    /// Column name in the log, for example `tension_in_n`.
    pub column: String,
    /// Its role.
    pub role: Role,
}

/// Origin of a model, for its users.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Provenance {
    /// Name of the chosen candidate.
    pub member: String,
    /// Description in one sentence.
    pub description: String,
    /// Version of the program that fitted it.
    pub program: String,
    /// Seed of every random draw.
    pub seed: u64,
    /// The logs it was fitted to.
    pub logs: Vec<String>,
    /// Samples it was fitted to.
    pub samples: usize,
    /// RMSE on data that were not fitted, far unit.
    pub rmse_unseen: f64,
    /// Range of the far side in training, far unit.
    pub far_range: f64,
}

/// Errors of a model on recordings that were not fitted: what one reading of the far end says of all others.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OffsetVariance {
    /// Mean square of the mean error of a recording, far unit squared.
    pub between: f64,
    /// Mean variance of the error within a recording, far unit squared.
    pub within: f64,
}

/// The error to expect beyond one side of a condition of the training logs.
///
/// ```text
/// e(d) = e_1 max(1, (d / d_1)^1.5)
/// ```
///
/// `e_1` is the error on the outermost value where it was held out, `d_1` its distance from the others, `d`
/// that of a value from the outermost one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Beyond {
    /// The condition or given quantity.
    pub column: String,
    /// The outermost value in the logs.
    pub outermost: f64,
    /// `d_1`, with the sign of the side.
    pub step: f64,
    /// `e_1`, far unit.
    pub rmse: f64,
}

impl Beyond {
    /// Growth of the error with the distance from the logs: faster than linear, slower than quadratic.
    const POWER: f64 = 1.5;

    /// Whether a value lies beyond the outermost one on this side.
    #[must_use]
    pub fn includes(&self, value: f64) -> bool {
        (value - self.outermost) / self.step > 0.0
    }

    /// Root mean square error to expect at a value, far unit; inside the logs `e_1`.
    #[must_use]
    pub fn expected(&self, value: f64) -> f64 {
        let distance = (value - self.outermost) / self.step;
        self.rmse * libm::pow(distance.max(1.0), Self::POWER)
    }
}

/// What holds outside the ranges of the training logs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Outside {
    /// [`Model::band_factor`] there, by what the folds held out outside the ranges of the others.
    pub band_factor: f64,
    /// Either side of every condition that is a number.
    pub sides: Vec<Beyond>,
}

/// The complete model of one transmission.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Model {
    /// The column it predicts.
    pub far: String,
    /// The columns it reads, in the order of [`Sample::inputs`](super::Sample::inputs).
    pub inputs: Vec<Input>,
    /// Units of columns whose names do not state them.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub units: BTreeMap<String, String>,
    /// The time column of its logs.
    pub time: Option<String>,
    /// The trial column of its logs.
    pub trial: Option<String>,
    /// Limits of the inputs: `[inputs]`.
    pub guards: Vec<InputLimits>,
    /// Interval between samples after which all states are reset, s.
    pub gap_s: f64,
    /// Estimator of the far end.
    pub estimator: Estimator,
    /// Half width of the 95 % band over the standard deviation of
    /// [`Estimate::variance`](super::Estimate::variance): by conformal calibration over the folds of the
    /// cross-validation.
    pub band_factor: f64,
    /// What notices another specimen; none where the logs do not show what one looks like.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub specimen: Option<SpecimenMonitor>,
    /// What holds outside the ranges of the training logs; none where the folds do not show it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub outside: Option<Outside>,
    /// Weight of a reading of the far end; none where the folds do not show it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offset: Option<OffsetVariance>,
    /// Origin.
    pub provenance: Provenance,
}

impl Model {
    /// Checks every precondition of [`Predictor`](super::Predictor).
    ///
    /// # Errors
    /// [`ModelFileError`] names the field, what was expected of it and what it is.
    pub fn validate(&self) -> Result<(), ModelFileError> {
        let n = self.inputs.len();
        require("inputs", "at least one column", n > 0, n)?;
        require("guards", &format!("one per input ({n})"), self.guards.len() == n, self.guards.len())?;
        for limits in &self.guards {
            all_moderate("guards", &[limits.low, limits.high, limits.typical])?;
            let jump = limits.jump;
            require("guards.jump", "finite and > 0", jump > 0.0 && jump.is_finite(), jump)?;
        }
        positive("gap_s", self.gap_s)?;
        positive("band_factor", self.band_factor)?;
        if let Some(Outside { band_factor, sides }) = &self.outside {
            positive("outside.band_factor", *band_factor)?;
            for side in sides {
                all_moderate("outside.sides", &[side.outermost, side.step, side.rmse])?;
                require("outside.sides.step", "not zero", side.step != 0.0, side.step)?;
            }
        }
        let Provenance { rmse_unseen, far_range, .. } = self.provenance;
        require("provenance.rmse_unseen", "a finite number", rmse_unseen.is_finite(), rmse_unseen)?;
        require("provenance.far_range", "a finite number", far_range.is_finite(), far_range)?;
        self.specimen.iter().try_for_each(|monitor| monitor.validate(n))?;
        if let Some(OffsetVariance { between, within }) = self.offset {
            let sound = between >= 0.0 && within > 0.0 && between.max(within) <= MAX_MAGNITUDE;
            require("offset", "between >= 0 and within > 0, <= 1e30", sound, format!("{between}, {within}"))?;
        }
        self.estimator.validate(n, MAX_DEPTH)
    }
}

/// Estimators within estimators: the adaptation of an adapted mean.
const MAX_DEPTH: usize = 4;

impl Estimator {
    fn validate(&self, inputs: usize, depth: usize) -> Result<(), ModelFileError> {
        let Self { law, ensemble, gate_power, perceptron, sigma0, linear, members } = self;
        let sigma = (0.0..=MAX_MAGNITUDE).contains(sigma0);
        require("estimator.sigma0", ">= 0 and <= 1e30", sigma, sigma0)?;
        if let Some(power) = *gate_power {
            require("estimator.gate_power", "finite and >= 0", power >= 0.0 && power.is_finite(), power)?;
        }
        law.validate(inputs)?;
        let features = law.features.len();
        if let Some(ensemble) = ensemble {
            ensemble.validate(features)?;
        }
        if let Some(linear) = linear {
            linear.validate(features)?;
        }
        if let Some(perceptron) = perceptron {
            let (got, weights) = (perceptron.inputs(), perceptron.weights());
            require("perceptron.inputs", &format!("{features}"), got == features, got)?;
            require("perceptron", "no ensemble beside it", ensemble.is_none(), "both")?;
            for list in [&weights.input_weights, &weights.hidden_bias, &weights.output_weights, &weights.skip]
            {
                all_moderate("perceptron", list)?;
            }
            all_moderate("perceptron.output_bias", &[weights.output_bias])?;
        }
        for member in members {
            require("members", &format!("at most {MAX_DEPTH} deep"), depth > 1, "more")?;
            require("members.weight", "> 0 and <= 1e30", is_positive(member.weight), member.weight)?;
            require("members.law.cable", "no cable", member.estimator.law.cable.is_none(), "one")?;
            member.estimator.validate(inputs, depth - 1)?;
        }
        let learned = ensemble.is_some() || perceptron.is_some() || linear.is_some();
        let predicts = law.has_physics() || learned || !members.is_empty();
        require("estimator", "a cell, cable, axis, regression, networks or members", predicts, "none")
    }
}

impl MemoryLaw {
    fn validate(&self, inputs: usize) -> Result<(), ModelFileError> {
        for signal in &self.signals {
            let last = signal.last_input();
            require("law.signals", &format!("input below {inputs}"), last < inputs, last)?;
            require("law.signals", "an offset in 1e-30..1e30", signal.is_valid(), format!("{signal:?}"))?;
        }
        let signals = self.signals.len();
        if let Some(cell) = &self.cell {
            cell.validate(signals)?;
        }
        if let Some(cable) = &self.cable {
            require("law.cable", "no cell beside it", self.cell.is_none(), "both")?;
            cable.validate(inputs).map_err(|error| ModelFileError::in_field("law.cable", error))?;
        }
        if let Some(axis) = &self.axis {
            require(
                "law.axis",
                "no cell or cable beside it",
                self.cell.is_none() && self.cable.is_none(),
                "both",
            )?;
            axis.validate(signals)?;
        }
        let feature_before = |k: usize, feature: usize| {
            require("law.features", &format!("feature below {k}"), feature < k, feature)
        };
        for (k, feature) in self.features.iter().enumerate() {
            let (signal, constant) = match *feature {
                Feature::Signal(signal)
                | Feature::Rate(signal)
                | Feature::BelowMaximum(signal)
                | Feature::AboveMinimum(signal) => (Some(signal), 1.0),
                Feature::Clamped { signal, low, high } => {
                    all_moderate("law.features", &[low, high])?;
                    require("law.features", "low at most high", low <= high, low)?;
                    (Some(signal), 1.0)
                }
                Feature::Stop { signal, radius } => (Some(signal), radius),
                Feature::LowPassDifference { signal, tau_s } => (Some(signal), tau_s),
                Feature::Product { feature, signal } => {
                    feature_before(k, feature)?;
                    (Some(signal), 1.0)
                }
                Feature::Sign { feature, scale } => {
                    feature_before(k, feature)?;
                    let least = scale >= 1.0 / MAX_MAGNITUDE;
                    require("law.features", "scale at least 1e-30", least, scale)?;
                    (None, scale)
                }
                Feature::Previous(feature) => {
                    feature_before(k, feature)?;
                    (None, 1.0)
                }
                Feature::CellState | Feature::CellWidth | Feature::CellPosition | Feature::Innovation => {
                    continue;
                }
            };
            let missing = signal.filter(|signal| *signal >= signals);
            let expected = format!("signal below {signals}");
            require("law.features", &expected, missing.is_none(), missing.unwrap_or_default())?;
            let inside = constant > 0.0 && constant <= MAX_MAGNITUDE;
            require("law.features", "radius, scale and tau_s > 0 and <= 1e30", inside, constant)?;
        }
        Ok(())
    }
}

impl ClampCell {
    fn validate(&self, signals: usize) -> Result<(), ModelFileError> {
        let b = self.basis.len();
        for term in &self.basis {
            let last = match *term {
                BasisTerm::One => continue,
                BasisTerm::Signal(i) => i,
                BasisTerm::Product(i, j) => i.max(j),
            };
            require("cell.basis", &format!("signal below {signals}"), last < signals, last)?;
        }
        for (name, list) in [("cell.low", &self.low), ("cell.high", &self.high)] {
            require(name, &format!("{b} coefficients"), list.len() == b, list.len())?;
            all_moderate(name, list)?;
        }
        let e = self.elastic.len();
        require("cell.kappa", &format!("{e} coefficients"), self.kappa.len() == e, self.kappa.len())?;
        all_moderate("cell.kappa", &self.kappa)?;
        let branches = self.branches.len();
        require("cell.branches", "1 to 8", (1..=8).contains(&branches), branches)?;
        for branch in &self.branches {
            let width = branch.width;
            require("cell.branches.width", "in (0, 1]", width > 0.0 && width <= 1.0, width)?;
            all_moderate("cell.branches.fraction", &[branch.fraction])?;
        }
        require("cell.start", "in [0, 1]", (0.0..=1.0).contains(&self.start), self.start)?;
        for &signal in &self.elastic {
            require("cell.elastic", &format!("signal below {signals}"), signal < signals, signal)?;
        }
        Ok(())
    }
}

impl Ensemble {
    fn validate(&self, features: usize) -> Result<(), ModelFileError> {
        // A constant has neither features nor nodes.
        let (least, expected) = if self.hidden_bias.is_empty() {
            (0, "at most 1000 features")
        } else {
            (1, "1 to 1000 features")
        };
        require("ensemble", expected, (least..=MAX_NODES).contains(&features), features)?;
        let lists = [
            ("ensemble.clip_low", &self.clip_low),
            ("ensemble.clip_high", &self.clip_high),
            ("ensemble.mean", &self.mean),
            ("ensemble.inverse_scale", &self.inverse_scale),
        ];
        for (name, list) in lists {
            require(name, &format!("{features} entries"), list.len() == features, list.len())?;
            all_moderate(name, list)?;
        }
        let standard = self.mean.iter().zip(&self.inverse_scale);
        for ((low, high), (mean, inverse)) in self.clip_low.iter().zip(&self.clip_high).zip(standard) {
            require("ensemble.inverse_scale", "> 0", *inverse > 0.0, inverse)?;
            require("ensemble.clip_low", "at most clip_high", low <= high, format!("{low} and {high}"))?;
            let farthest = ((low - mean) * inverse).abs().max(((high - mean) * inverse).abs());
            let expected = "so small that the clip box is within 1e5 scales";
            require("ensemble.inverse_scale", expected, farthest <= MAX_STANDARDISED_INPUT, inverse)?;
        }
        let hidden = self.hidden_bias.len();
        require("ensemble.hidden_bias", "at most 1000 rows", hidden <= MAX_NODES, hidden)?;
        let shapes = [
            ("ensemble.hidden_weights", &self.hidden_weights, hidden * features),
            ("ensemble.hidden_bias", &self.hidden_bias, hidden),
            ("ensemble.output_weights", &self.output_weights, hidden),
            ("ensemble.skip", &self.skip, features),
        ];
        for (name, rows, expected) in shapes {
            require(name, &format!("{expected} rows"), rows.len() == expected, rows.len())?;
            rows.iter().try_for_each(|row| all_weights(name, row))?;
        }
        all_weights("ensemble.bias", &self.bias)
    }
}

/// Largest weight of a network, far unit.
const MAX_WEIGHT: f64 = 1e10;
/// Largest standardised input of a network, far above that of any training set.
const MAX_STANDARDISED_INPUT: f64 = 1e5;
/// Largest number of features or nodes. With the two limits above, the variance is finite in single
/// precision.
const MAX_NODES: usize = 1000;

fn positive(name: &str, value: f64) -> Result<(), ModelFileError> {
    require(name, "> 0 and <= 1e30", is_positive(value), value)
}

fn is_positive(value: f64) -> bool {
    value > 0.0 && value <= MAX_MAGNITUDE
}

fn all_moderate(name: &str, values: &[f64]) -> Result<(), ModelFileError> {
    all_within(name, "numbers within +-1e30", values, MAX_MAGNITUDE)
}

fn all_weights(name: &str, weights: &PerNetwork) -> Result<(), ModelFileError> {
    all_within(name, "numbers within +-1e10", &weights.map(f64::from), MAX_WEIGHT)
}

fn all_within(name: &str, expected: &str, values: &[f64], largest: f64) -> Result<(), ModelFileError> {
    match values.iter().find(|v| v.is_nan() || v.abs() > largest) {
        None => Ok(()),
        Some(bad) => require(name, expected, false, bad),
    }
}
