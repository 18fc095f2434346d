//! A small network by Levenberg-Marquardt under Bayesian regularisation (MacKay's evidence).

use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::{Accum, Mat, Par};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sinew::math::tanh;

/// Standardised inputs `[n x features]` row-major and targets `[n]`.
pub(crate) struct NetworkData<'a> {
    pub inputs: &'a [f64],
    pub targets: &'a [f64],
    pub features: usize,
}

/// How a network is trained.
#[derive(Debug, Clone, Copy)]
pub(crate) struct NetworkOptions {
    /// Hidden tanh nodes.
    pub hidden: usize,
    /// Samples per independent sample: what the evidence may count.
    pub correlation: f64,
    /// Most accepted and rejected steps.
    pub steps: usize,
    /// Seed of the initial weights.
    pub seed: u64,
}

/// A trained network; `theta` in the order W `[hidden x features]`, d, v `[hidden]`, a `[features]`, b.
#[derive(Debug, Clone)]
pub(crate) struct Network {
    pub hidden: usize,
    pub features: usize,
    pub theta: Vec<f64>,
    /// Gauss-Newton matrix of the evidence at the optimum, `beta J'wJ + A`: the prior of an adaptation.
    pub precision: Vec<f64>,
}

impl Network {
    /// Number of parameters of a network of this shape.
    pub(crate) fn size(hidden: usize, features: usize) -> usize {
        hidden * (features + 2) + features + 1
    }

    /// Output for one standardised input.
    #[cfg(test)]
    pub(crate) fn evaluate(&self, z: &[f64]) -> f64 {
        let parts = Parts::of(&self.theta, self.hidden, self.features);
        parts.output(z, &mut vec![0.0; self.hidden])
    }

    pub(crate) fn parts(&self) -> Parts<'_> {
        Parts::of(&self.theta, self.hidden, self.features)
    }
}

/// The parameter vector by its parts.
#[derive(Clone, Copy)]
pub(crate) struct Parts<'a> {
    pub weights: &'a [f64],
    pub bias: &'a [f64],
    pub output: &'a [f64],
    pub skip: &'a [f64],
    pub offset: f64,
}

impl<'a> Parts<'a> {
    fn of(theta: &'a [f64], hidden: usize, features: usize) -> Self {
        let (weights, rest) = theta.split_at(hidden * features);
        let (bias, rest) = rest.split_at(hidden);
        let (output, rest) = rest.split_at(hidden);
        let (skip, rest) = rest.split_at(features);
        Self { weights, bias, output, skip, offset: rest[0] }
    }

    #[inline]
    fn output(&self, z: &[f64], activation: &mut [f64]) -> f64 {
        for ((node, row), bias) in
            activation.iter_mut().zip(self.weights.chunks_exact(z.len())).zip(self.bias)
        {
            *node = bias + row.iter().zip(z).map(|(w, z)| w * z).sum::<f64>();
        }
        for node in activation.iter_mut() {
            *node = tanh(*node);
        }
        self.offset
            + self.skip.iter().zip(z).map(|(a, z)| a * z).sum::<f64>()
            + self.output.iter().zip(activation.iter()).map(|(v, h)| v * h).sum::<f64>()
    }
}

/// Strength of the prior on each group of parameters.
struct Prior {
    groups: [core::ops::Range<usize>; 5],
    alpha: [f64; 5],
    mean: Option<Vec<f64>>,
}

impl Prior {
    fn new(hidden: usize, features: usize) -> Self {
        let w = hidden * features;
        let (d, v) = (w + hidden, w + 2 * hidden);
        let a = v + features;
        Self { groups: [0..w, w..d, d..v, v..a, a..a + 1], alpha: [0.1, 0.1, 0.1, 0.1, 1e-6], mean: None }
    }

    fn energy(&self, theta: &[f64]) -> f64 {
        let group = |(range, alpha): (&core::ops::Range<usize>, &f64)| {
            0.5 * alpha * theta[range.clone()].iter().map(|t| t * t).sum::<f64>()
        };
        self.groups.iter().zip(&self.alpha).map(group).sum()
    }

    fn diagonal(&self, p: usize) -> Vec<f64> {
        let mut diagonal = vec![0.0; p];
        for (range, alpha) in self.groups.iter().zip(&self.alpha) {
            diagonal[range.clone()].fill(*alpha);
        }
        diagonal
    }
}

/// Rows of the Jacobian built at a time: small enough to stay in the second-level cache.
const BLOCK: usize = 512;

struct Workspace {
    jacobian: Mat<f64>,
    gram: Mat<f64>,
    gradient: Vec<f64>,
    residual: Vec<f64>,
}

/// Trains one network. Deterministic: the same data and seed give the same bits.
pub(crate) fn train(data: &NetworkData<'_>, options: &NetworkOptions) -> Network {
    let (h, f) = (options.hidden, data.features);
    let (n, p) = (data.targets.len(), Network::size(h, f));
    let mut theta = initial(options, f);
    let mut prior = Prior::new(h, f);
    let tc = options.correlation.max(1.0);
    let mut beta = 1.0 / (0.05 * tc);
    let mut damping = 0.005;
    let mut weight = vec![1.0; n];
    let mut work = Workspace {
        jacobian: Mat::zeros(BLOCK.min(n), p),
        gram: Mat::zeros(p, p),
        gradient: vec![0.0; p],
        residual: vec![0.0; n],
    };
    let mut squares = linearise(data, h, &theta, &weight, &mut work);
    let mut trial_residual = vec![0.0; n];
    let (mut flat, mut accepted, mut growth) = (0, 0, 2.0);
    for _ in 0..2 * options.steps {
        if accepted >= options.steps {
            break;
        }
        let diagonal = prior.diagonal(p);
        let shift = damping * beta * n as f64 / 50.0;
        let system = Mat::from_fn(p, p, |i, j| {
            beta * work.gram[(i.max(j), i.min(j))] + if i == j { diagonal[i] + shift } else { 0.0 }
        });
        let right: Vec<f64> = (0..p).map(|i| beta * work.gradient[i] + diagonal[i] * theta[i]).collect();
        let before = 0.5 * beta * squares + prior.energy(&theta);
        let Some(step) = solve(&system, &right) else {
            damping *= 5.0;
            continue;
        };
        let trial: Vec<f64> = theta.iter().zip(&step).map(|(t, s)| t - s).collect();
        let promised: f64 = 0.5 * step.iter().zip(&right).map(|(s, r)| s * (shift * s + r)).sum::<f64>();
        let trial_squares = residuals(data, h, &trial, &weight, &mut trial_residual);
        let after = 0.5 * beta * trial_squares + prior.energy(&trial);
        let ratio = (before - after) / promised;
        let shrink = (1.0 - (2.0 * ratio - 1.0).powi(3)).max(1.0 / 3.0).min(2.0);
        if after.is_finite() && after < before {
            flat = if before - after < 2e-5 * before.abs() { flat + 1 } else { 0 };
            theta = trial;
            damping = (damping * shrink).max(1e-9);
            growth = 2.0;
            accepted += 1;
            if accepted >= 7 {
                huber(&trial_residual, &mut weight);
            }
            squares = linearise(data, h, &theta, &weight, &mut work);
            if accepted >= 3 {
                evidence(&mut prior, &mut beta, &theta, &work.gram, squares, n as f64 / tc);
            }
        } else {
            damping *= growth;
            growth *= 2.0;
        }
        if flat >= 4 || damping > 1e12 {
            break;
        }
    }
    let diagonal = prior.diagonal(p);
    let precision = (0..p * p)
        .map(|k| {
            let (i, j) = (k / p, k % p);
            beta * work.gram[(i.max(j), i.min(j))] + if i == j { diagonal[i] } else { 0.0 }
        })
        .collect();
    let _ = &prior.mean;
    Network { hidden: h, features: f, theta, precision }
}

fn initial(options: &NetworkOptions, features: usize) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(options.seed);
    let mut normal = move || {
        let (u, v): (f64, f64) = (rng.random(), rng.random());
        (-2.0 * libm_ln(1.0 - u)).sqrt() * (core::f64::consts::TAU * v).cos()
    };
    let h = options.hidden;
    let mut theta = Vec::with_capacity(Network::size(h, features));
    let spread = 1.0 / (features as f64).sqrt();
    theta.extend((0..h * features).map(|_| spread * normal()));
    theta.extend((0..h).map(|_| (normal() * 0.577).clamp(-1.0, 1.0)));
    theta.extend((0..h).map(|_| 0.1 * normal()));
    theta.resize(Network::size(h, features), 0.0);
    theta
}

fn libm_ln(x: f64) -> f64 {
    x.ln()
}

/// Weighted residuals' sum of squares; residuals are prediction minus target.
fn residuals(data: &NetworkData<'_>, h: usize, theta: &[f64], weight: &[f64], out: &mut [f64]) -> f64 {
    let parts = Parts::of(theta, h, data.features);
    let mut activation = vec![0.0; h];
    let mut sum = 0.0;
    for (row, z) in data.inputs.chunks_exact(data.features).enumerate() {
        let error = parts.output(z, &mut activation) - data.targets[row];
        out[row] = error;
        sum += weight[row] * error * error;
    }
    sum
}

/// Fills `J'wJ` (lower triangle), `J'we` and the residuals at `theta`; returns the weighted sum of squares.
fn linearise(data: &NetworkData<'_>, h: usize, theta: &[f64], weight: &[f64], work: &mut Workspace) -> f64 {
    let f = data.features;
    let p = theta.len();
    let parts = Parts::of(theta, h, f);
    let mut activation = vec![0.0; h];
    let mut row_values = vec![0.0; p];
    work.gradient.fill(0.0);
    work.gram.fill(0.0);
    let mut sum = 0.0;
    let n = data.targets.len();
    let mut start = 0;
    while start < n {
        let rows = BLOCK.min(n - start);
        for r in 0..rows {
            let row = start + r;
            let z = &data.inputs[row * f..][..f];
            let error = parts.output(z, &mut activation) - data.targets[row];
            work.residual[row] = error;
            let root = weight[row].sqrt();
            sum += weight[row] * error * error;
            let (w, rest) = row_values.split_at_mut(h * f);
            let (d, rest) = rest.split_at_mut(h);
            let (v, rest) = rest.split_at_mut(h);
            for j in 0..h {
                let slope = root * parts.output[j] * (1.0 - activation[j] * activation[j]);
                d[j] = slope;
                v[j] = root * activation[j];
                w[j * f..][..f].iter_mut().zip(z).for_each(|(w, z)| *w = slope * z);
            }
            rest[..f].iter_mut().zip(z).for_each(|(a, z)| *a = root * z);
            rest[f] = root;
            let scaled = root * error;
            for (i, value) in row_values.iter().enumerate() {
                work.gradient[i] += scaled * value;
                work.jacobian[(r, i)] = *value;
            }
        }
        let block = work.jacobian.as_ref().subrows(0, rows);
        matmul(
            work.gram.as_mut(),
            BlockStructure::TriangularLower,
            Accum::Add,
            block.transpose(),
            BlockStructure::Rectangular,
            block,
            BlockStructure::Rectangular,
            1.0,
            Par::Seq,
        );
        start += rows;
    }
    sum
}

fn solve(system: &Mat<f64>, right: &[f64]) -> Option<Vec<f64>> {
    use faer::linalg::solvers::Solve;
    let factor = system.llt(faer::Side::Lower).ok()?;
    let rhs = Mat::from_fn(right.len(), 1, |i, _| right[i]);
    let x = factor.solve(&rhs);
    Some((0..right.len()).map(|i| x[(i, 0)]).collect())
}

/// MacKay's re-estimation of the prior strengths and the noise level.
fn evidence(prior: &mut Prior, beta: &mut f64, theta: &[f64], gram: &Mat<f64>, squares: f64, count: f64) {
    use faer::linalg::solvers::DenseSolveCore;
    let p = theta.len();
    let diagonal = prior.diagonal(p);
    let system = Mat::from_fn(p, p, |i, j| {
        *beta * gram[(i.max(j), i.min(j))] + if i == j { diagonal[i] } else { 0.0 }
    });
    let Ok(factor) = system.llt(faer::Side::Lower) else { return };
    let inverse = factor.inverse();
    let mut determined = 0.0;
    for (range, alpha) in prior.groups.iter().zip(&mut prior.alpha) {
        let trace: f64 = range.clone().map(|i| inverse[(i, i)]).sum();
        let gamma = (range.len() as f64 - *alpha * trace).max(0.0);
        determined += gamma;
        let size: f64 = theta[range.clone()].iter().map(|t| t * t).sum();
        *alpha = (*alpha * gamma / size.max(1e-12)).sqrt().clamp(1e-4, 1e5);
    }
    let determined = determined.min(0.8 * count);
    *beta = ((count - determined) / squares.max(1e-12)).clamp(1e-6, 1e8);
}

/// Huber weights at three robust standard deviations: single events do not steer the fit.
fn huber(residual: &[f64], weight: &mut [f64]) {
    let mut size: Vec<f64> = residual.iter().map(|e| e.abs()).collect();
    let middle = size.len() / 2;
    let (_, median, _) = size.select_nth_unstable_by(middle, f64::total_cmp);
    let limit = (3.0 * 1.4826 * *median).max(1e-9);
    for (w, e) in weight.iter_mut().zip(residual) {
        *w = if e.abs() > limit { limit / e.abs() } else { 1.0 };
    }
}
