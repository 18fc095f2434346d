//! Training: from the recipe of a candidate and its data to a fitted estimator.

use crate::cable::fit_observed;
use crate::estimation::rmse;
use crate::fit::axis::fit_axis;
use crate::fit::cell::{CellData, CellPlan, fit_cell};
use crate::fit::ensemble::{self, Rows};
use crate::fit::linear::RIDGE;
use crate::fit::recipe::{FeaturePlan, Learner, Recipe};
use crate::fit::run::Run;
use crate::fit::statistics::quantiles;
use sinew::predictor::{Estimator, Feature, Member, MemoryLaw};
use sinew::transmission::ClampCell;

/// Ridge of a regression on many plays, relative to the variance of a feature: several times that of others,
/// because plays of neighbouring widths are nearly collinear.
const PLAYS_RIDGE: f64 = 1e-3;

/// Fits a recipe to runs; `None` where they hold too little to fit.
#[must_use]
pub(crate) fn fit(recipe: &Recipe, runs: &[&Run], seed: u64) -> Option<Estimator> {
    fit_on(fit_law(recipe, runs)?, recipe, runs, seed)
}

/// The mean of fitted estimators by weights with the sum 1; of each whether it counts inside the training
/// data alone.
pub(crate) fn mean_of(members: Vec<(Estimator, bool)>, weights: &[f64]) -> Estimator {
    // What the mean errs in training is at most the mean of what its members do.
    let sigma0 = members.iter().zip(weights).map(|((estimator, _), weight)| weight * estimator.sigma0).sum();
    let law = MemoryLaw { signals: vec![], cell: None, cable: None, axis: None, features: vec![] };
    let member = |((estimator, inside), &weight)| Member { weight, inside, estimator };
    let members = members.into_iter().zip(weights).map(member).collect();
    Estimator { sigma0, members, ..Estimator::of(law) }
}

/// Fits the physics of a recipe: its law without features.
#[must_use]
pub(crate) fn fit_law(recipe: &Recipe, runs: &[&Run]) -> Option<MemoryLaw> {
    let mut law = MemoryLaw {
        signals: recipe.signals.clone(),
        cell: None,
        cable: None,
        axis: None,
        features: Vec::new(),
    };
    if let Some(plan) = &recipe.cell {
        law.cell = Some(fit_cell_of(&law, plan, runs)?);
    }
    if let Some((columns, newtons)) = recipe.cable {
        law.cable = Some(fit_observed(runs, columns, newtons)?);
    }
    if let Some(plan) = &recipe.axis {
        law.axis = Some(fit_axis(&law, runs, plan)?.axis);
    }
    Some(law)
}

/// Fits the rest of a recipe to runs, its physics being given.
#[must_use]
pub(crate) fn fit_on(mut law: MemoryLaw, recipe: &Recipe, runs: &[&Run], seed: u64) -> Option<Estimator> {
    if let Some(plan) = &recipe.features {
        law.features = features(plan, &Columns::new(&law, runs), &law)?;
    }
    fit_networks(law, recipe, runs, seed)
}

/// The features of a plan on the signals of a law.
pub(crate) fn features_of(plan: &FeaturePlan, law: &MemoryLaw, runs: &[&Run]) -> Option<Vec<Feature>> {
    features(plan, &Columns::new(law, runs), law)
}

/// Fits a cell on the signals of a law.
pub(crate) fn fit_cell_of(law: &MemoryLaw, plan: &CellPlan, runs: &[&Run]) -> Option<ClampCell> {
    fit_cell(&Columns::new(law, runs).data(), plan)
}

/// Fits the regression and trains the networks of a recipe on the residual of a given law.
pub(crate) fn fit_networks(law: MemoryLaw, recipe: &Recipe, runs: &[&Run], seed: u64) -> Option<Estimator> {
    let mut estimator = Estimator::of(law);
    if recipe.features.is_some() {
        let mut rows = Rows::collect(&estimator.law, runs, recipe.rows);
        match recipe.learner {
            Learner::Regression => {
                let clamped = estimator.law.features.iter().any(|f| matches!(f, Feature::Clamped { .. }));
                let ridge = if clamped { PLAYS_RIDGE } else { RIDGE };
                estimator.linear = Some(ensemble::train_law(&rows, ridge)?);
            }
            Learner::Skeleton => {
                let linear = ensemble::train_law(&rows, RIDGE)?;
                rows.subtract(&linear);
                let ensemble = ensemble::train(&rows, recipe, seed)?;
                estimator.gate_power = Some(ensemble::mean_square_correction(&ensemble, &rows));
                (estimator.linear, estimator.ensemble) = (Some(linear), Some(ensemble));
            }
            Learner::Paper => estimator.perceptron = Some(ensemble::train_paper(&rows, recipe, seed)?),
            Learner::Linear => estimator.ensemble = Some(ensemble::train_linear(&rows)?),
            Learner::Ensemble => {
                let ensemble = ensemble::train(&rows, recipe, seed)?;
                if estimator.law.has_physics() {
                    estimator.gate_power = Some(ensemble::mean_square_correction(&ensemble, &rows));
                }
                estimator.ensemble = Some(ensemble);
            }
        }
    }
    estimator.sigma0 = rmse(&estimator, runs);
    estimator.sigma0.is_finite().then_some(estimator)
}

/// The signals and far sides of all runs, one after the other.
struct Columns {
    signals: Vec<f64>,
    stride: usize,
    far: Vec<f64>,
    weight: Vec<f64>,
    first: Vec<bool>,
    dt_s: Vec<f64>,
}

impl Columns {
    fn new(law: &MemoryLaw, runs: &[&Run]) -> Self {
        let stride = law.signals.len();
        let (mut signals, mut far, mut weight, mut first) = (vec![], vec![], vec![], vec![]);
        let dt_s = runs.iter().flat_map(|run| run.dt_s.iter().copied()).collect();
        for run in runs {
            for i in 0..run.len() {
                signals.extend(law.signals.iter().map(|signal| signal.value(run.row(i))));
                first.push(i == 0);
            }
            far.extend_from_slice(&run.far);
            weight.extend_from_slice(&run.weight);
        }
        Self { signals, stride, far, weight, first, dt_s }
    }

    fn column(&self, signal: usize) -> impl Iterator<Item = f64> + '_ {
        self.signals.iter().skip(signal).step_by(self.stride).copied()
    }

    /// The quantiles of a signal at `level` and at `1 - level`.
    fn edges(&self, signal: usize, level: f64) -> [f64; 2] {
        let edge = quantiles(self.column(signal).collect(), &[level, 1.0 - level]);
        [edge[0], edge[1]]
    }

    /// Size of the rate of a signal: the root of its mean square.
    fn rate(&self, signal: usize) -> f64 {
        let (mut sum, mut count, mut before) = (0.0, 0.0, 0.0);
        for ((u, first), dt) in self.column(signal).zip(&self.first).zip(&self.dt_s) {
            if !first && *dt > 0.0 {
                (sum, count) = (sum + ((u - before) / dt).powi(2), count + 1.0);
            }
            before = u;
        }
        (sum / f64::max(count, 1.0)).sqrt().max(1e-9)
    }

    fn data(&self) -> CellData<'_> {
        let Self { signals, stride, far, weight, first, .. } = self;
        CellData { signals, stride: *stride, far, weight, first }
    }
}

/// Past rates of a signal in a regression; with fewer its noise is the limit, with more its lag.
const RATES: usize = 4;

/// Rates at which the smooth sign of a motion is 0.7, over the size of its rate.
const SIGNS: [f64; 2] = [0.03, 0.3];

fn features(plan: &FeaturePlan, columns: &Columns, law: &MemoryLaw) -> Option<Vec<Feature>> {
    let FeaturePlan { signals, plain, radii, taus, rates, loops, times, clamped } = plan;
    let mut all = signals.iter().chain(plain).chain(rates).chain(loops).chain(times);
    if all.any(|&signal| signal >= columns.stride) {
        return None;
    }
    let mut features = Vec::new();
    for &signal in signals {
        let [low, high] = columns.edges(signal, 0.0005);
        let whole = if *clamped { Feature::Clamped { signal, low, high } } else { Feature::Signal(signal) };
        features.push(whole);
        let [least, most] = columns.edges(signal, 0.01);
        let range = (most - least).max(1e-9);
        features.extend(radii.iter().map(|r| Feature::Stop { signal, radius: r * range }));
        features.extend(taus.iter().map(|&tau_s| Feature::LowPassDifference { signal, tau_s }));
    }
    for &signal in rates {
        let scale = columns.rate(signal);
        let first = features.len();
        features.push(Feature::Rate(signal));
        features.extend((0..RATES - 1).map(|k| Feature::Previous(first + k)));
        features.extend(SIGNS.map(|part| Feature::Sign { feature: first, scale: part * scale }));
    }
    for &signal in loops {
        features.extend([Feature::BelowMaximum(signal), Feature::AboveMinimum(signal)]);
    }
    let near = features.len();
    features.extend(plain.iter().chain(times).map(|&signal| Feature::Signal(signal)));
    for &signal in times {
        features.extend((0..near).map(|feature| Feature::Product { feature, signal }));
    }
    if law.cell.is_some() {
        features.extend([Feature::CellState, Feature::CellWidth, Feature::CellPosition]);
    } else if law.cable.is_some() {
        features.extend([Feature::CellState, Feature::Innovation]);
    } else if law.axis.is_some() {
        features.push(Feature::CellState);
    }
    Some(features)
}
