//! One member of the comparison: from its recipe to a fitted model.

use crate::fit::cell::{CellData, fit_cell};
use crate::fit::network::{self, NetworkData, NetworkOptions};
use rayon::prelude::*;
use sinew::predictor::{Cell, Ensemble, Feature, MEMBERS, Memory, MemoryLaw, Signal, Term};

/// One sequence ready for fitting: finite, conditioned as the predictor would have.
#[derive(Debug, Clone)]
pub struct Run {
    pub log: usize,
    pub group: Vec<usize>,
    /// Seconds since the sample before, 0 at the first: `[n]`.
    pub dt_s: Vec<f64>,
    /// `[n x inputs]`.
    pub inputs: Vec<f64>,
    /// Far side to fit: `[n]`.
    pub far: Vec<f64>,
    /// 1 where a sample counts: `[n]`.
    pub weight: Vec<f64>,
    pub width: usize,
}

impl Run {
    pub fn len(&self) -> usize {
        self.far.len()
    }
    fn row(&self, i: usize) -> &[f64] {
        &self.inputs[i * self.width..][..self.width]
    }
}

/// Which signals get which memory.
#[derive(Debug, Clone)]
pub struct FeaturePlan {
    /// Signals whose memory the network sees.
    pub signals: Vec<usize>,
    /// Signals it sees only as they are.
    pub plain: Vec<usize>,
    /// Radii of the stop operators as fractions of the signal's range.
    pub radii: Vec<f64>,
    /// Time constants of low-pass differences, s.
    pub taus: Vec<f64>,
}

/// What a member is made of.
#[derive(Debug, Clone)]
pub struct Recipe {
    pub name: String,
    pub signals: Vec<Signal>,
    pub cell: Option<(Vec<Term>, Vec<usize>)>,
    pub features: Option<FeaturePlan>,
    pub hidden: usize,
    /// Samples per independent sample, counted before thinning.
    pub correlation: f64,
    pub rows: usize,
    pub steps: usize,
}

/// A fitted member.
#[derive(Debug, Clone)]
pub struct Member {
    pub law: MemoryLaw,
    pub ensemble: Option<Ensemble>,
    /// Mean square of the correction in training; `None` without a gate.
    pub gate_power: Option<f64>,
    pub sigma0: f64,
}

#[derive(Debug, Clone, Copy)]
pub struct Output {
    pub mean: f64,
    pub variance: f64,
    pub gate: f64,
    pub known: bool,
}

pub const GATE: f64 = 8.0;

impl Member {
    /// Runs the member over one sequence as at run time.
    pub fn run(&self, run: &Run) -> Vec<Output> {
        let mut memory = Memory::new(&self.law);
        let mut scratch = vec![0.0; self.law.features.len()];
        (0..run.len())
            .map(|i| {
                memory.step(&self.law, run.dt_s[i], run.row(i));
                self.output(&memory, &mut scratch)
            })
            .collect()
    }

    fn output(&self, memory: &Memory, scratch: &mut [f64]) -> Output {
        let cell = memory.cell();
        match &self.ensemble {
            None => {
                Output { mean: cell.state, variance: self.sigma0 * self.sigma0, gate: 1.0, known: cell.known }
            }
            Some(ensemble) => {
                let opinion = ensemble.opinion(memory.features(), scratch);
                let gate = self.gate_power.map_or(1.0, |p| p / (p + GATE * opinion.variance));
                Output {
                    mean: cell.state + gate * opinion.median,
                    variance: self.sigma0 * self.sigma0 + opinion.variance,
                    gate,
                    known: cell.known,
                }
            }
        }
    }
}

/// Fits a recipe to runs.
pub fn fit(recipe: &Recipe, runs: &[&Run], seed: u64) -> Option<Member> {
    let mut law = MemoryLaw { signals: recipe.signals.clone(), cell: None, features: Vec::new() };
    let (signals, far, weight, first) = signals_of(&law, runs);
    let s = recipe.signals.len();
    if let Some((basis, elastic)) = &recipe.cell {
        let data = CellData { signals: &signals, stride: s, far: &far, weight: &weight, first: &first };
        law.cell = Some(fit_cell(&data, basis, elastic)?);
    }
    if let Some(plan) = &recipe.features {
        law.features = features(plan, &signals, s, law.cell.is_some());
    }
    let mut member = Member { law, ensemble: None, gate_power: None, sigma0: 0.0 };
    if recipe.features.is_some() {
        train_ensemble(&mut member, recipe, runs, seed)?;
    }
    let (mut sum, mut count) = (0.0, 0.0);
    for run in runs {
        for ((o, y), w) in member.run(run).iter().zip(&run.far).zip(&run.weight) {
            sum += w * (o.mean - y) * (o.mean - y);
            count += w;
        }
    }
    member.sigma0 = (sum / count).sqrt();
    Some(member)
}

fn signals_of(law: &MemoryLaw, runs: &[&Run]) -> (Vec<f64>, Vec<f64>, Vec<f64>, Vec<bool>) {
    let (mut signals, mut far, mut weight, mut first) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for run in runs {
        for i in 0..run.len() {
            signals.extend(law.signals.iter().map(|signal| signal.value(run.row(i))));
            far.push(run.far[i]);
            weight.push(run.weight[i]);
            first.push(i == 0);
        }
    }
    (signals, far, weight, first)
}

pub fn quantiles(mut values: Vec<f64>, at: &[f64]) -> Vec<f64> {
    values.sort_unstable_by(f64::total_cmp);
    let last = (values.len() - 1) as f64;
    at.iter().map(|q| values[(q * last).round() as usize]).collect()
}

fn features(plan: &FeaturePlan, signals: &[f64], stride: usize, cell: bool) -> Vec<Feature> {
    let mut features = Vec::new();
    for &signal in &plan.signals {
        features.push(Feature::Signal(signal));
        let column: Vec<f64> = signals.iter().skip(signal).step_by(stride).copied().collect();
        let edge = quantiles(column, &[0.01, 0.99]);
        let range = (edge[1] - edge[0]).max(1e-9);
        features.extend(plan.radii.iter().map(|r| Feature::Stop { signal, radius: r * range }));
        features.extend(plan.taus.iter().map(|&tau_s| Feature::LowPassDifference { signal, tau_s }));
    }
    features.extend(plan.plain.iter().map(|&signal| Feature::Signal(signal)));
    if cell {
        features.extend([Feature::CellState, Feature::CellWidth, Feature::CellPlace]);
    }
    features
}

fn train_ensemble(member: &mut Member, recipe: &Recipe, runs: &[&Run], seed: u64) -> Option<()> {
    let f = member.law.features.len();
    let (mut x, mut target, mut all_rows) = (Vec::new(), Vec::new(), 0usize);
    let total: usize = runs.iter().map(|r| r.weight.iter().filter(|w| **w > 0.0).count()).sum();
    let stride = total.div_ceil(recipe.rows).max(1);
    for run in runs {
        let mut memory = Memory::new(&member.law);
        for i in 0..run.len() {
            let start = None;
            memory.step_from(&member.law, run.dt_s[i], run.row(i), start);
            if run.weight[i] == 0.0 {
                continue;
            }
            all_rows += 1;
            if all_rows % stride == 0 {
                x.extend_from_slice(memory.features());
                target.push(run.far[i] - memory.cell().state);
            }
        }
    }
    let n = target.len();
    if n < 20 {
        return None;
    }
    let (mut low, mut high, mut mean, mut scale) = (vec![], vec![], vec![], vec![]);
    for i in 0..f {
        let column: Vec<f64> = x.iter().skip(i).step_by(f).copied().collect();
        let edge = quantiles(column.clone(), &[0.0005, 0.9995]);
        let clipped = column.iter().map(|v| v.clamp(edge[0], edge[1]));
        let m = clipped.clone().sum::<f64>() / n as f64;
        let sd = (clipped.map(|v| (v - m) * (v - m)).sum::<f64>() / n as f64).sqrt();
        low.push(edge[0]);
        high.push(edge[1]);
        mean.push(m);
        scale.push(if sd > 1e-9 { sd } else { 1.0 });
    }
    for row in x.chunks_exact_mut(f) {
        for i in 0..f {
            row[i] = (row[i].clamp(low[i], high[i]) - mean[i]) / scale[i];
        }
    }
    let target_mean = target.iter().sum::<f64>() / n as f64;
    let target_sd = (target.iter().map(|t| (t - target_mean) * (t - target_mean)).sum::<f64>() / n as f64)
        .sqrt()
        .max(1e-12);
    target.iter_mut().for_each(|t| *t = (*t - target_mean) / target_sd);
    let data = NetworkData { inputs: &x, targets: &target, features: f };
    let correlation = (recipe.correlation / stride as f64).max(1.0);
    let networks: Vec<_> = (0..MEMBERS as u64)
        .into_par_iter()
        .map(|k| {
            let options = NetworkOptions {
                hidden: recipe.hidden,
                correlation,
                steps: recipe.steps,
                seed: seed.wrapping_mul(1_000_003).wrapping_add(k),
            };
            network::train(&data, &options)
        })
        .collect();
    let h = recipe.hidden;
    let lanes = |pick: &dyn Fn(&network::Parts<'_>) -> f64| -> [f64; MEMBERS] {
        core::array::from_fn(|k| pick(&networks[k].parts()))
    };
    let ensemble = Ensemble {
        clip_low: low,
        clip_high: high,
        mean,
        scale,
        hidden_weights: (0..h * f).map(|i| lanes(&|p| p.weights[i])).collect(),
        hidden_bias: (0..h).map(|i| lanes(&|p| p.bias[i])).collect(),
        output_weights: (0..h).map(|i| lanes(&|p| p.output[i] * target_sd)).collect(),
        skip: (0..f).map(|i| lanes(&|p| p.skip[i] * target_sd)).collect(),
        bias: lanes(&|p| p.offset * target_sd + target_mean),
    };
    member.ensemble = Some(ensemble);
    if member.law.cell.is_some() {
        let ensemble = member.ensemble.as_ref()?;
        let (mut power, mut count) = (0.0, 0.0);
        let mut scratch = vec![0.0; f];
        for run in runs {
            let mut memory = Memory::new(&member.law);
            for i in 0..run.len() {
                memory.step(&member.law, run.dt_s[i], run.row(i));
                if run.weight[i] > 0.0 && i % 4 == 0 {
                    let c = ensemble.opinion(memory.features(), &mut scratch).median;
                    power += c * c;
                    count += 1.0;
                }
            }
        }
        member.gate_power = Some(power / count);
    }
    Some(())
}
