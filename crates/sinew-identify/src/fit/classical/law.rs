//! Common part of all classical laws: transformed parameters, fit, intervals, remarks.

use super::result::{ClassicalFit, Parameter};
use super::samples::{Samples, Signals, sensor_noise};
use crate::fit::least_squares::{Covariance, LeastSquares, Options, Solution, solve_from_many};
use crate::fit::linear_algebra::{Cholesky, Matrix};
use sinew::metrics::Comparison;

/// Names of what several laws determine: one quantity has one name.
pub(crate) const FRICTION_ANGLE: &str = "friction angle (mu phi - ln eta)";
pub(crate) const PRETENSION: &str = "pretension (T_0)";
pub(crate) const STIFFNESS: &str = "stiffness in presliding (k)";

/// Transformation of a parameter for the search.
#[derive(Debug, Clone, Copy)]
pub(super) enum Scale {
    /// None; a parameter is identified if its interval is narrower than itself or `typical`.
    Linear { typical: f64 },
    /// Logarithm of the excess over a lower bound.
    Above(f64),
    /// Logit between two bounds.
    Between(f64, f64),
}

impl Scale {
    pub(super) const POSITIVE: Self = Self::Above(0.0);

    pub(super) fn to_search(self, value: f64) -> f64 {
        match self {
            Self::Linear { .. } => value,
            Self::Above(low) => (value - low).max(1e-12).ln(),
            Self::Between(low, high) => {
                let fraction = ((value - low) / (high - low)).clamp(0.02, 0.98);
                (fraction / (1.0 - fraction)).ln()
            }
        }
    }

    fn to_natural(self, theta: f64) -> f64 {
        match self {
            Self::Linear { .. } => theta,
            Self::Above(low) => low + theta.exp(),
            Self::Between(low, high) => low + (high - low) / (1.0 + (-theta).exp()),
        }
    }

    /// Whether an interval is narrow enough for the parameter to count as identified.
    fn identified(self, value: f64, low: f64, high: f64) -> bool {
        match self {
            Self::Linear { typical } => high - low < value.abs().max(typical),
            Self::Above(least) => (high - least) < 10.0 * (low - least),
            Self::Between(least, most) => high - low < 0.5 * (most - least),
        }
    }
}

/// One parameter of a law.
#[derive(Debug, Clone)]
pub(super) struct Spec {
    pub(super) name: String,
    pub(super) unit: String,
    pub(super) scale: Scale,
    /// Whether it is identifiable only from motion in both directions.
    pub(super) friction: bool,
}

impl Spec {
    pub(super) fn new(name: &str, unit: &str, scale: Scale) -> Self {
        Self { name: name.to_owned(), unit: unit.to_owned(), scale, friction: false }
    }

    pub(super) fn friction(name: &str, unit: &str, scale: Scale) -> Self {
        Self { friction: true, ..Self::new(name, unit, scale) }
    }
}

/// Predictions for every row from natural parameters; `false` outside the domain.
pub(super) type Predict = Box<dyn Fn(&Samples, &[f64], &mut [f64]) -> bool + Send + Sync>;
/// Quantities computed from the natural parameters, with the gradient by finite differences.
pub(super) type Derived = (Spec, fn(&[f64]) -> f64);

/// A law ready to be fitted.
pub(super) struct Law {
    pub(super) name: String,
    pub(super) equation: String,
    pub(super) specs: Vec<Spec>,
    /// Natural parameters to start from.
    pub(super) starts: Vec<Vec<f64>>,
    pub(super) predict: Predict,
    pub(super) derived: Vec<Derived>,
    /// What data of this kind do not determine.
    pub(super) note: String,
    /// Indices of parameters that these data cannot determine, whatever the covariance.
    pub(super) undetermined: Vec<usize>,
    /// Why these data do not determine a parameter, by its index.
    pub(super) reason: fn(usize) -> &'static str,
    /// Whether only samples in which the cable slides for certain are fitted: a law without memory is wrong
    /// by the whole friction where the direction is.
    pub(super) sliding_only: bool,
}

/// A fitted law.
pub(super) struct Fitted {
    pub(super) fit: ClassicalFit,
    /// Numbers that were fitted.
    pub(super) size: usize,
    /// What it predicts for every row.
    pub(super) predictions: Vec<f64>,
}

/// Fewest samples that are fitted.
const FEWEST: usize = 20;

/// Correlation of two positive parameters from which the data determine only the two together.
const COLLINEAR: f64 = 0.95;

/// The law on given samples as a sum of squares.
struct Problem<'a> {
    law: &'a Law,
    samples: &'a Samples,
    predictions: std::cell::RefCell<Vec<f64>>,
}

impl LeastSquares for Problem<'_> {
    fn parameters(&self) -> usize {
        self.law.specs.len()
    }

    fn residuals(&self) -> usize {
        self.samples.fitted.len()
    }

    fn evaluate(&self, theta: &[f64], residuals: &mut [f64]) -> bool {
        // NaN and divergent steps are outside the domain.
        if !theta.iter().all(|t| t.abs() < 1e12) {
            return false;
        }
        let natural = self.law.to_natural(theta);
        let mut predictions = self.predictions.borrow_mut();
        if !(self.law.predict)(self.samples, &natural, &mut predictions) {
            return false;
        }
        for (residual, &row) in residuals.iter_mut().zip(&self.samples.fitted) {
            *residual = predictions[row] - self.samples.far[row];
        }
        true
    }
}

impl Law {
    /// A parameter limited to a factor of a thousand around its starts where it is positive: beyond, the law
    /// no longer depends on it, and its Jacobian should be zero.
    fn limited(&self, i: usize, theta: f64) -> f64 {
        let scale = self.specs[i].scale;
        let starts = || self.starts.iter().map(|start| scale.to_search(start[i]));
        match scale {
            Scale::Linear { .. } => theta,
            Scale::Above(_) | Scale::Between(..) => {
                let least = starts().fold(f64::INFINITY, f64::min);
                let most = starts().fold(f64::NEG_INFINITY, f64::max);
                theta.max(least - 7.0).min(most + 7.0)
            }
        }
    }

    fn to_natural(&self, theta: &[f64]) -> Vec<f64> {
        (0..theta.len()).map(|i| self.specs[i].scale.to_natural(self.limited(i, theta[i]))).collect()
    }

    /// The fit, with intervals; `None` where the law cannot be evaluated at all.
    pub(super) fn fit(&self, samples: &Samples, all: &Samples, signals: &Signals) -> Option<Fitted> {
        let sliding = self.sliding_only.then(|| samples.only_sliding());
        let samples = sliding.as_ref().unwrap_or(samples);
        if samples.fitted.len() < FEWEST {
            return None;
        }
        let predictions = std::cell::RefCell::new(vec![0.0; samples.far.len()]);
        let problem = Problem { law: self, samples, predictions };
        let to_search = |start: &Vec<f64>| -> Vec<f64> {
            self.specs.iter().zip(start).map(|(spec, &value)| spec.scale.to_search(value)).collect()
        };
        let starts: Vec<Vec<f64>> = self.starts.iter().map(to_search).collect();
        let options = Options { steps: 40, tolerance: 1e-6 };
        let solution = solve_from_many(&problem, &starts, options)?;
        let natural = self.to_natural(&solution.theta);
        let (rmse, predictions) = self.rmse(all, &natural)?;
        let covariance = solution.covariance();
        let tau = autocorrelation_time(samples, &solution.residuals);
        let free = (solution.residuals.len() as f64 / tau - natural.len() as f64).max(1.0) * tau;
        // |r|^2 / free is the variance of a residual; tau accounts for its correlation.
        let spread = (solution.squares / free * tau).sqrt();
        let mut parameters: Vec<Parameter> =
            (0..natural.len()).map(|i| self.parameter(i, &solution, &covariance, spread, signals)).collect();
        for derived in &self.derived {
            let parameter = self.derived_parameter(derived, &solution, &covariance, spread, signals);
            // The friction angle is undefined for lines of different sign.
            if parameter.value.is_finite() {
                parameters.push(parameter);
            }
        }
        let fitted_rmse = (solution.squares / solution.residuals.len() as f64).sqrt();
        let remark = self.remark(&parameters, fitted_rmse, tau, all, signals);
        let fit = ClassicalFit {
            law: self.name.clone(),
            equation: self.equation.clone(),
            rmse,
            percent_of_range: 100.0 * rmse / signals.far_range,
            parameters,
            condition: covariance.condition,
            remark,
        };
        Some(Fitted { fit, size: natural.len(), predictions })
    }

    fn rmse(&self, all: &Samples, natural: &[f64]) -> Option<(f64, Vec<f64>)> {
        let mut predictions = vec![0.0; all.far.len()];
        if !(self.predict)(all, natural, &mut predictions) {
            return None;
        }
        let mut comparison = Comparison::new();
        for &row in &all.fitted {
            comparison.push(all.far[row], predictions[row]).ok()?;
        }
        Some((comparison.rmse()?, predictions))
    }

    fn parameter(
        &self,
        i: usize,
        solution: &Solution,
        covariance: &Covariance,
        spread: f64,
        signals: &Signals,
    ) -> Parameter {
        let spec = &self.specs[i];
        let seen = if self.undetermined.contains(&i) { f64::INFINITY } else { covariance.variance[i] };
        let half = 1.96 * spread * seen.sqrt();
        let at = |theta: f64| spec.scale.to_natural(theta);
        let theta = self.limited(i, solution.theta[i]);
        let (value, low, high) = (at(theta), at(theta - half), at(theta + half));
        let mut parameter = parameter(spec, value, low, high, signals, (self.reason)(i));
        if let Some(other) = self.collinear_with(i, covariance).filter(|_| parameter.identified) {
            parameter.identified = false;
            parameter.remark = format!("determined only together with {}", self.specs[other].name);
        }
        parameter
    }

    /// The positive parameter that this one cannot be told from, if there is one: in the logarithm, where
    /// both are fitted, the linearised interval of neither holds.
    fn collinear_with(&self, i: usize, covariance: &Covariance) -> Option<usize> {
        let positive = |k: usize| matches!(self.specs[k].scale, Scale::Above(_));
        let variance = |k: usize| covariance.matrix[(k, k)];
        let correlation = |k: usize| covariance.matrix[(i, k)] / (variance(i) * variance(k)).sqrt();
        (0..self.specs.len())
            .filter(|&k| k != i && positive(i) && positive(k) && correlation(k).abs() > COLLINEAR)
            .max_by(|&a, &b| correlation(a).abs().total_cmp(&correlation(b).abs()))
    }

    fn derived_parameter(
        &self,
        (spec, of): &Derived,
        solution: &Solution,
        covariance: &Covariance,
        spread: f64,
        signals: &Signals,
    ) -> Parameter {
        let p = solution.theta.len();
        let value = of(&self.to_natural(&solution.theta));
        let gradient: Vec<f64> = (0..p)
            .map(|i| {
                let mut moved = solution.theta.clone();
                let step = (1e-6 * moved[i].abs()).max(1e-9);
                moved[i] += step;
                (of(&self.to_natural(&moved)) - value) / step
            })
            .collect();
        let mut variance = 0.0;
        for i in 0..p {
            if gradient[i].abs() > 0.0 && covariance.variance[i].is_infinite() {
                variance = f64::INFINITY;
            }
            for j in 0..p {
                variance += gradient[i] * covariance.matrix[(i, j)] * gradient[j];
            }
        }
        let half = 1.96 * spread * variance.max(0.0).sqrt();
        parameter(spec, value, value - half, value + half, signals, "")
    }

    fn remark(
        &self,
        parameters: &[Parameter],
        rmse: f64,
        tau: f64,
        all: &Samples,
        signals: &Signals,
    ) -> String {
        let mut remarks: Vec<String> = vec![];
        if signals.reversals == 0 {
            remarks.push(format!(
                "{} never reverses, so friction cannot be separated from gain and offset",
                signals.drive_name
            ));
        }
        let open: Vec<&str> = parameters.iter().filter(|p| !p.identified).map(|p| p.name.as_str()).collect();
        if !open.is_empty() {
            remarks.push(format!("these data do not determine {}", open.join(", ")));
        }
        let noise = sensor_noise(&all.runs, &all.far);
        if tau > 3.0 && rmse > 3.0 * noise && rmse > 0.002 * signals.far_range {
            // Of a rounded or filtered signal the noise is a fraction of nothing, and its ratio means
            // nothing.
            let ratio = if rmse < 1e3 * noise {
                format!("RMSE {:.0} times the sensor's noise, ", rmse / noise)
            } else {
                String::new()
            };
            remarks.push(format!(
                "the residuals are not noise ({ratio}correlated over {tau:.0} samples): \
                 the structure of this law is wrong or incomplete here, and its intervals do not hold"
            ));
        }
        if !self.note.is_empty() {
            remarks.push(self.note.clone());
        }
        remarks.join(". ")
    }
}

fn parameter(spec: &Spec, value: f64, low: f64, high: f64, signals: &Signals, why: &str) -> Parameter {
    // An interval over three decades is reported as undefined.
    let vague = matches!(spec.scale, Scale::Above(least) if high - least > 1e3 * (value - least));
    let known = low.is_finite() && high.is_finite() && !vague;
    let one_way = spec.friction && signals.reversals == 0;
    let identified = known && !one_way && spec.scale.identified(value, low, high);
    let remark = match (identified, one_way) {
        (true, _) => "",
        (false, true) => "needs motion both ways",
        (false, false) if why.is_empty() => "these data do not determine it",
        (false, false) => why,
    };
    Parameter {
        name: spec.name.clone(),
        unit: spec.unit.clone(),
        value,
        low: if known { low } else { f64::NAN },
        high: if known { high } else { f64::NAN },
        identified,
        remark: remark.to_owned(),
    }
}

/// An entry without a fit, with the reason.
pub(super) fn not_fitted(why: &str) -> ClassicalFit {
    ClassicalFit {
        law: "none".to_owned(),
        equation: String::new(),
        rmse: f64::NAN,
        percent_of_range: f64::NAN,
        parameters: vec![],
        condition: f64::NAN,
        remark: format!("no classical law was fitted: {why}"),
    }
}

/// `tau = 1 + 2 sum_k rho_k` over neighbouring fitted rows of a run, until `rho_k < 0.05`.
fn autocorrelation_time(samples: &Samples, residuals: &[f64]) -> f64 {
    let n = residuals.len();
    let mean = residuals.iter().sum::<f64>() / n.max(1) as f64;
    let variance = residuals.iter().map(|r| (r - mean) * (r - mean)).sum::<f64>() / n.max(1) as f64;
    if variance <= 0.0 {
        return 1.0;
    }
    let mut run_of = vec![0; samples.far.len()];
    for (id, run) in samples.runs.iter().enumerate() {
        run_of[run.clone()].fill(id);
    }
    let mut tau = 1.0;
    for lag in 1..n / 4 {
        let (mut sum, mut pairs) = (0.0, 0_usize);
        for i in 0..n - lag {
            let (a, b) = (samples.fitted[i], samples.fitted[i + lag]);
            if b - a == lag && run_of[a] == run_of[b] {
                sum += (residuals[i] - mean) * (residuals[i + lag] - mean);
                pairs += 1;
            }
        }
        let rho = if pairs > 0 { sum / pairs as f64 / variance } else { 0.0 };
        if rho < 0.05 {
            break;
        }
        tau += 2.0 * rho;
    }
    tau
}

/// Least squares of `target` on `columns`, `None` where they are dependent.
pub(super) fn linear_fit(columns: &[Vec<f64>], target: &[f64]) -> Option<(Vec<f64>, f64)> {
    let p = columns.len();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    let scale: Vec<f64> = columns.iter().map(|c| 1.0 / dot(c, c).sqrt().max(1e-150)).collect();
    let normal = Matrix::from_fn(p, |i, j| {
        let ridge = if i == j { 1e-12 } else { 0.0 };
        dot(&columns[i], &columns[j]) * scale[i] * scale[j] + ridge
    });
    let right: Vec<f64> = (0..p).map(|i| dot(&columns[i], target) * scale[i]).collect();
    let mut weights = Cholesky::new(normal)?.solve(&right)?;
    for (weight, s) in weights.iter_mut().zip(&scale) {
        *weight *= s;
    }
    let squares = (0..target.len())
        .map(|row| {
            let fitted: f64 = columns.iter().zip(&weights).map(|(c, w)| c[row] * w).sum();
            (fitted - target[row]).powi(2)
        })
        .sum();
    Some((weights, squares))
}
