//! The networks of a member: rows, standardisation, training, the power of their correction.

use super::network::{self, NetworkData, NetworkOptions};
use crate::member::{Recipe, Run, quantiles};
use rayon::prelude::*;
use sinew::predictor::{Ensemble, Lanes, MEMBERS, Memory, MemoryLaw};

/// Fewest rows worth a network.
const FEWEST_ROWS: usize = 20;

/// What the networks are trained on.
pub(crate) struct Rows {
    /// `[n x features]` row-major.
    features: Vec<f64>,
    /// What the physics left over, far unit: `[n]`.
    targets: Vec<f64>,
    width: usize,
    /// Every how manyth sample was taken.
    stride: usize,
}

impl Rows {
    /// Steps the law through the runs as at run time and keeps at most `limit` evenly spread rows.
    pub(crate) fn collect(law: &MemoryLaw, runs: &[&Run], limit: usize) -> Self {
        let counted = runs.iter().flat_map(|run| &run.weight).filter(|w| **w > 0.0).count();
        let stride = counted.div_ceil(limit.max(1)).max(1);
        let mut rows = Self { features: vec![], targets: vec![], width: law.features.len(), stride };
        let mut seen = 0;
        let mut memory = Memory::new(law);
        for run in runs {
            memory.reset();
            for i in 0..run.len() {
                memory.step(law, run.dt_s[i], run.row(i));
                if run.weight[i] > 0.0 {
                    seen += 1;
                    if seen % stride == 0 {
                        rows.features.extend_from_slice(memory.features());
                        rows.targets.push(run.far[i] - memory.cell().state);
                    }
                }
            }
        }
        rows
    }
}

/// Clip box, mean and scale of every feature: `[features]` each.
struct Standard {
    low: Vec<f64>,
    high: Vec<f64>,
    mean: Vec<f64>,
    scale: Vec<f64>,
}

impl Standard {
    fn of(rows: &Rows) -> Self {
        let mut standard = Self { low: vec![], high: vec![], mean: vec![], scale: vec![] };
        for i in 0..rows.width {
            let mut column: Vec<f64> = rows.features.iter().skip(i).step_by(rows.width).copied().collect();
            let edge = quantiles(column.clone(), &[0.0005, 0.9995]);
            column.iter_mut().for_each(|v| *v = v.max(edge[0]).min(edge[1]));
            let (mean, spread) = mean_and_spread(&column);
            standard.low.push(edge[0]);
            standard.high.push(edge[1]);
            standard.mean.push(mean);
            // A constant feature tells nothing: it becomes 0.
            standard.scale.push(if spread > 1e-9 { spread } else { 1.0 });
        }
        standard
    }

    fn apply(&self, features: &[f64]) -> Vec<f64> {
        let width = self.mean.len();
        let one = |(k, x): (usize, &f64)| {
            let i = k % width;
            (x.max(self.low[i]).min(self.high[i]) - self.mean[i]) / self.scale[i]
        };
        features.iter().enumerate().map(one).collect()
    }
}

fn mean_and_spread(values: &[f64]) -> (f64, f64) {
    let n = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / n;
    (mean, (values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / n).sqrt())
}

/// Trains the networks of a recipe side by side, each from its own start.
pub(crate) fn train(rows: &Rows, recipe: &Recipe, seed: u64) -> Option<Ensemble> {
    let (n, f, h) = (rows.targets.len(), rows.width, recipe.hidden);
    if n < FEWEST_ROWS || f == 0 {
        return None;
    }
    let standard = Standard::of(rows);
    let inputs = standard.apply(&rows.features);
    let (centre, spread) = mean_and_spread(&rows.targets);
    let spread = spread.max(1e-12);
    let targets: Vec<f64> = rows.targets.iter().map(|t| (t - centre) / spread).collect();
    let data = NetworkData { inputs: &inputs, targets: &targets, features: f };
    let networks: Vec<_> = (0..recipe.networks.clamp(2, MEMBERS) as u64)
        .into_par_iter()
        .map(|k| {
            let options = NetworkOptions {
                hidden: h,
                correlation: recipe.correlation / rows.stride as f64,
                steps: recipe.steps,
                seed: seed.wrapping_mul(1_000_003).wrapping_add(k),
            };
            network::train(&data, &options)
        })
        .collect();
    // Fewer networks than lanes repeat: median and, nearly, variance stay what they are.
    let lanes = |pick: &dyn Fn(&network::Parts<'_>) -> f64| -> Lanes {
        core::array::from_fn(|k| pick(&networks[k % networks.len()].parts()) as f32)
    };
    Some(Ensemble {
        hidden_weights: (0..h * f).map(|i| lanes(&|p| p.weights[i])).collect(),
        hidden_bias: (0..h).map(|i| lanes(&|p| p.bias[i])).collect(),
        output_weights: (0..h).map(|i| lanes(&|p| p.output[i] * spread)).collect(),
        skip: (0..f).map(|i| lanes(&|p| p.skip[i] * spread)).collect(),
        bias: lanes(&|p| p.offset * spread + centre),
        clip_low: standard.low,
        clip_high: standard.high,
        mean: standard.mean,
        inverse_scale: standard.scale.iter().map(|s| 1.0 / s).collect(),
    })
}

/// Mean square of the correction over the training rows.
pub(crate) fn power(ensemble: &Ensemble, rows: &Rows) -> f64 {
    let mut scratch = vec![0.0; rows.width];
    let squares = rows.features.chunks_exact(rows.width).map(|features| {
        let correction = ensemble.opinion(features, &mut scratch).median;
        correction * correction
    });
    squares.sum::<f64>() / rows.targets.len().max(1) as f64
}
