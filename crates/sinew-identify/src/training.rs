//! Training: from the recipe of a candidate and its data to a fitted estimator.

use crate::cable::fit_observed;
use crate::estimation::rmse;
use crate::fit::axis::fit_axis;
use crate::fit::cell::{CellData, CellPlan, fit_cell};
use crate::fit::ensemble::{self, Rows};
use crate::fit::recipe::{FeaturePlan, Learner, Recipe};
use crate::fit::run::Run;
use crate::fit::statistics::quantiles;
use sinew::predictor::{Estimator, Feature, MemoryLaw};
use sinew::transmission::ClampCell;

/// Fits a recipe to runs; `None` where they hold too little to fit.
#[must_use]
pub(crate) fn fit(recipe: &Recipe, runs: &[&Run], seed: u64) -> Option<Estimator> {
    fit_on(fit_law(recipe, runs)?, recipe, runs, seed)
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
    if let Some(columns) = recipe.cable {
        law.cable = Some(fit_observed(runs, columns)?);
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

/// Fits a cell on the signals of a law.
pub(crate) fn fit_cell_of(law: &MemoryLaw, plan: &CellPlan, runs: &[&Run]) -> Option<ClampCell> {
    fit_cell(&Columns::new(law, runs).data(), plan)
}

/// Trains the networks of a recipe on the residual of a given law.
pub(crate) fn fit_networks(law: MemoryLaw, recipe: &Recipe, runs: &[&Run], seed: u64) -> Option<Estimator> {
    let mut estimator = Estimator { law, ensemble: None, gate_power: None, perceptron: None, sigma0: 0.0 };
    if recipe.features.is_some() {
        let rows = Rows::collect(&estimator.law, runs, recipe.rows);
        match recipe.learner {
            Learner::Paper => estimator.perceptron = Some(ensemble::train_paper(&rows, recipe, seed)?),
            Learner::Linear => estimator.ensemble = Some(ensemble::train_linear(&rows)?),
            Learner::Ensemble | Learner::Mixed => {
                let ensemble = ensemble::train(&rows, recipe, seed)?;
                if estimator.law.has_physics() && recipe.learner == Learner::Ensemble {
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
}

impl Columns {
    fn new(law: &MemoryLaw, runs: &[&Run]) -> Self {
        let stride = law.signals.len();
        let (mut signals, mut far, mut weight, mut first) = (vec![], vec![], vec![], vec![]);
        for run in runs {
            for i in 0..run.len() {
                signals.extend(law.signals.iter().map(|signal| signal.value(run.row(i))));
                first.push(i == 0);
            }
            far.extend_from_slice(&run.far);
            weight.extend_from_slice(&run.weight);
        }
        Self { signals, stride, far, weight, first }
    }

    fn data(&self) -> CellData<'_> {
        let Self { signals, stride, far, weight, first } = self;
        CellData { signals, stride: *stride, far, weight, first }
    }
}

fn features(plan: &FeaturePlan, columns: &Columns, law: &MemoryLaw) -> Option<Vec<Feature>> {
    if plan.signals.iter().chain(&plan.plain).any(|&signal| signal >= columns.stride) {
        return None;
    }
    let mut features = Vec::new();
    for &signal in &plan.signals {
        features.push(Feature::Signal(signal));
        let column = columns.signals.iter().skip(signal).step_by(columns.stride);
        let edge = quantiles(column.copied().collect(), &[0.01, 0.99]);
        let range = (edge[1] - edge[0]).max(1e-9);
        features.extend(plan.radii.iter().map(|r| Feature::Stop { signal, radius: r * range }));
        features.extend(plan.taus.iter().map(|&tau_s| Feature::LowPassDifference { signal, tau_s }));
    }
    features.extend(plan.plain.iter().map(|&signal| Feature::Signal(signal)));
    if law.cell.is_some() {
        features.extend([Feature::CellState, Feature::CellWidth, Feature::CellPosition]);
    } else if law.cable.is_some() {
        features.extend([Feature::CellState, Feature::Innovation]);
    } else if law.axis.is_some() {
        features.push(Feature::CellState);
    }
    Some(features)
}
