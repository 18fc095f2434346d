//! Training of the ensemble of a candidate: rows, standardisation, networks, mean square of the correction.

use super::linear::{linear_law, regress};
use super::network::{self, Network, NetworkData, NetworkOptions};
use super::perceptron::{self, TrainOptions};
use super::recipe::{CORRELATION, Recipe};
use super::run::Run;
use super::standardisation::Standardisation;
use super::statistics::mean_and_deviation;
use rayon::prelude::*;
use sinew::predictor::{Ensemble, LinearLaw, MEMBERS, Memory, MemoryLaw, PerNetwork};
use sinew::transmission::Perceptron;

/// Continues the training of an ensemble on new rows under a prior centred on its old weights, in the units
/// of its standardisation.
pub(crate) fn retrain(rows: &Rows, old: &Ensemble) -> Option<Ensemble> {
    let (f, h) = (rows.width, old.hidden_bias.len());
    if rows.targets.len() < MIN_ROWS || f != old.mean.len() {
        return None;
    }
    let fresh = Standardisation::new(&rows.features, rows.width);
    let standard = Standardisation {
        low: fresh.low.iter().zip(&old.clip_low).map(|(a, b)| a.min(*b)).collect(),
        high: fresh.high.iter().zip(&old.clip_high).map(|(a, b)| a.max(*b)).collect(),
        mean: old.mean.clone(),
        scale: old.inverse_scale.iter().map(|s| 1.0 / s).collect(),
    };
    let training_set = TrainingSet::new(standard.apply(&rows.features), f, &rows.targets);
    let networks: Vec<Network> = (0..MEMBERS)
        .into_par_iter()
        .map(|lane| {
            let at = |v: &PerNetwork| f64::from(v[lane]);
            let mut theta: Vec<f64> = old.hidden_weights.iter().map(at).collect();
            theta.extend(old.hidden_bias.iter().map(at));
            theta.extend(old.output_weights.iter().chain(&old.skip).map(|v| at(v) / training_set.spread));
            theta.push((at(&old.bias) - training_set.centre) / training_set.spread);
            let data =
                NetworkData { inputs: &training_set.inputs, targets: &training_set.targets, features: f };
            let correlation = CORRELATION / rows.stride as f64;
            let options = NetworkOptions { hidden: h, correlation, steps: RETRAIN_STEPS, seed: 0 };
            network::retrain(&data, &options, &theta)
        })
        .collect();
    Some(packed(&networks, &training_set, standard, h))
}

/// Accepted steps of a [`retrain`], at most: it starts near its minimum.
const RETRAIN_STEPS: usize = 30;

/// Fewest rows for which a network is trained.
const MIN_ROWS: usize = 20;

/// Features and targets of the networks.
pub(crate) struct Rows {
    /// `[n x features]` row-major.
    features: Vec<f64>,
    /// Residual of the physics, far unit: `[n]`.
    targets: Vec<f64>,
    width: usize,
    /// Samples per row.
    stride: usize,
}

impl Rows {
    /// Steps the law through the runs as at run time and keeps at most `limit` evenly spread rows.
    pub(crate) fn collect(law: &MemoryLaw, runs: &[&Run], limit: usize) -> Self {
        let counted = runs.iter().flat_map(|run| &run.weight).filter(|w| **w > 0.0).count();
        let stride = counted.div_ceil(limit.max(1)).max(1);
        let mut rows = Self { features: vec![], targets: vec![], width: law.features.len(), stride };
        let mut scored = 0;
        let mut memory = Memory::new(law);
        for run in runs {
            memory.reset();
            for i in 0..run.len() {
                memory.step(law, run.dt_s[i], run.row(i));
                if run.weight[i] > 0.0 {
                    scored += 1;
                    if scored % stride == 0 {
                        rows.features.extend_from_slice(memory.features());
                        rows.targets.push(run.far[i] - memory.cell().state);
                    }
                }
            }
        }
        rows
    }

    /// Leaves the residual of a regression as target.
    pub(crate) fn subtract(&mut self, linear: &LinearLaw) {
        let rows = self.features.chunks_exact(self.width.max(1));
        self.targets.iter_mut().zip(rows).for_each(|(target, x)| *target -= linear.value(x));
    }
}

/// Trains the networks of a recipe side by side, each from its own start.
pub(crate) fn train(rows: &Rows, recipe: &Recipe, seed: u64) -> Option<Ensemble> {
    let (n, f, h) = (rows.targets.len(), rows.width, recipe.hidden);
    if n < MIN_ROWS || f == 0 {
        return None;
    }
    let standard = Standardisation::new(&rows.features, rows.width);
    let training_set = TrainingSet::new(standard.apply(&rows.features), f, &rows.targets);
    let networks: Vec<Network> = (0..recipe.networks.clamp(2, MEMBERS))
        .into_par_iter()
        .map(|k| {
            let options = NetworkOptions {
                hidden: h,
                correlation: CORRELATION / rows.stride as f64,
                steps: recipe.steps,
                seed: seed.wrapping_mul(1_000_003).wrapping_add(k as u64),
            };
            training_set.train(&options)
        })
        .collect();
    Some(packed(&networks, &training_set, standard, h))
}

/// Linear regression on the same rows.
pub(crate) fn train_linear(rows: &Rows) -> Option<Ensemble> {
    regress(&rows.features, &rows.targets, rows.width)
}

/// The same as a law; `ridge` relative to the variance of a feature.
pub(crate) fn train_law(rows: &Rows, ridge: f64) -> Option<LinearLaw> {
    linear_law(&rows.features, &rows.targets, rows.width, ridge)
}

/// The plain network of `yuan2023` on the same rows.
pub(crate) fn train_paper(rows: &Rows, recipe: &Recipe, seed: u64) -> Option<Perceptron> {
    let options =
        TrainOptions { hidden: recipe.hidden, steps: recipe.steps, seed, ..TrainOptions::default() };
    perceptron::train(&rows.features, &rows.targets, &options).ok()?.network.to_perceptron()
}

/// Standardised inputs and targets of the networks of one kind.
struct TrainingSet {
    inputs: Vec<f64>,
    width: usize,
    targets: Vec<f64>,
    centre: f64,
    spread: f64,
}

impl TrainingSet {
    fn new(inputs: Vec<f64>, width: usize, targets: &[f64]) -> Self {
        let (centre, spread) = mean_and_deviation(targets);
        let spread = spread.max(1e-12);
        let targets = targets.iter().map(|t| (t - centre) / spread).collect();
        Self { inputs, width, targets, centre, spread }
    }

    fn train(&self, options: &NetworkOptions) -> Network {
        let data = NetworkData { inputs: &self.inputs, targets: &self.targets, features: self.width };
        network::train(&data, options)
    }
}

/// One network per lane, in far units. Where there are fewer networks than lanes they repeat: the median
/// stays, the variance nearly.
fn packed(networks: &[Network], set: &TrainingSet, standard: Standardisation, hidden: usize) -> Ensemble {
    let per_network = |pick: &dyn Fn(&network::Parts<'_>) -> f64| -> PerNetwork {
        core::array::from_fn(|lane| pick(&networks[lane % networks.len()].parts()) as f32)
    };
    let width = standard.mean.len();
    Ensemble {
        hidden_weights: (0..hidden * width).map(|i| per_network(&|p| p.weights[i])).collect(),
        hidden_bias: (0..hidden).map(|i| per_network(&|p| p.bias[i])).collect(),
        output_weights: (0..hidden).map(|i| per_network(&|p| p.output[i] * set.spread)).collect(),
        skip: (0..width).map(|i| per_network(&|p| p.skip[i] * set.spread)).collect(),
        bias: per_network(&|p| p.offset * set.spread + set.centre),
        clip_low: standard.low,
        clip_high: standard.high,
        inverse_scale: standard.scale.iter().map(|s| 1.0 / s).collect(),
        mean: standard.mean,
    }
}

/// Mean square of the correction over the training rows.
pub(crate) fn mean_square_correction(ensemble: &Ensemble, rows: &Rows) -> f64 {
    let mut scratch = vec![0.0; rows.width];
    let squares = rows.features.chunks_exact(rows.width).map(|features| {
        let correction = ensemble.evaluate(features, &mut scratch).median;
        correction * correction
    });
    squares.sum::<f64>() / rows.targets.len().max(1) as f64
}
