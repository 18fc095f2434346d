//! A small network by Levenberg-Marquardt under Bayesian regularisation (MacKay's evidence).

use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::linalg::solvers::{DenseSolveCore, Solve};
use faer::{Accum, Mat, MatRef, Par};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sinew::math::quick_tanh;

/// Standardised inputs `[n x features]` row-major and targets `[n]`.
#[derive(Clone, Copy)]
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
            *node = quick_tanh(*node);
        }
        self.offset
            + self.skip.iter().zip(z).map(|(a, z)| a * z).sum::<f64>()
            + self.output.iter().zip(activation.iter()).map(|(v, h)| v * h).sum::<f64>()
    }

    /// `factor` times the derivative of the output by every parameter, in their order.
    #[inline]
    fn gradient(&self, z: &[f64], activation: &[f64], factor: f64, out: &mut [f64]) {
        let (h, f) = (activation.len(), z.len());
        let (w, rest) = out.split_at_mut(h * f);
        let (d, rest) = rest.split_at_mut(h);
        let (v, rest) = rest.split_at_mut(h);
        for (j, row) in w.chunks_exact_mut(f).enumerate() {
            let slope = factor * self.output[j] * (1.0 - activation[j] * activation[j]);
            d[j] = slope;
            v[j] = factor * activation[j];
            row.iter_mut().zip(z).for_each(|(w, z)| *w = slope * z);
        }
        rest.iter_mut().zip(z).for_each(|(a, z)| *a = factor * z);
        rest[f] = factor;
    }
}

/// Strength of the prior on each group of parameters.
#[derive(Clone)]
struct Prior {
    groups: [core::ops::Range<usize>; 5],
    alpha: [f64; 5],
    /// What the parameters are drawn to: zeros, or an older network.
    mean: Vec<f64>,
}

impl Prior {
    fn new(hidden: usize, features: usize) -> Self {
        let w = hidden * features;
        let (d, v) = (w + hidden, w + 2 * hidden);
        let a = v + features;
        Self {
            groups: [0..w, w..d, d..v, v..a, a..a + 1],
            alpha: [0.1, 0.1, 0.1, 0.1, 1e-6],
            mean: vec![0.0; a + 1],
        }
    }

    fn energy(&self, theta: &[f64]) -> f64 {
        let group =
            |(range, alpha): (&core::ops::Range<usize>, &f64)| 0.5 * alpha * self.distance(theta, range);
        self.groups.iter().zip(&self.alpha).map(group).sum()
    }

    /// Squared distance of a group from its prior mean.
    fn distance(&self, theta: &[f64], range: &core::ops::Range<usize>) -> f64 {
        let pairs = theta[range.clone()].iter().zip(&self.mean[range.clone()]);
        pairs.map(|(t, m)| (t - m) * (t - m)).sum()
    }

    fn diagonal(&self, p: usize) -> Vec<f64> {
        let mut diagonal = vec![0.0; p];
        for (range, alpha) in self.groups.iter().zip(&self.alpha) {
            diagonal[range.clone()].fill(*alpha);
        }
        diagonal
    }
}

/// Rows of the first, coarse stage of training.
const COARSE_ROWS: usize = 1500;

/// Rows of the Jacobian built at a time: small enough to stay in the second-level cache.
const BLOCK: usize = 512;

/// Trains one network. Deterministic: the same data and seed give the same bits.
///
/// Most of the way is made on every few rows, the rest on all of them.
pub(crate) fn train(data: &NetworkData<'_>, options: &NetworkOptions) -> Network {
    let (h, f) = (options.hidden, data.features);
    let theta = initial(options, f);
    let stride = data.targets.len() / COARSE_ROWS;
    let start = Trainer::new(*data, h, theta, options.correlation);
    let mut trainer = if stride > 1 {
        let inputs: Vec<f64> = data.inputs.chunks_exact(f).step_by(stride).flatten().copied().collect();
        let targets: Vec<f64> = data.targets.iter().step_by(stride).copied().collect();
        let coarse = NetworkData { inputs: &inputs, targets: &targets, features: f };
        let mut trainer = Trainer::new(coarse, h, start.theta, options.correlation / stride as f64);
        trainer.run(options.steps, 4);
        let mut fine = Trainer::new(*data, h, trainer.theta, options.correlation);
        fine.prior = trainer.prior;
        fine.beta = trainer.beta * trainer.correlation / fine.correlation;
        fine.steps = trainer.steps;
        fine
    } else {
        start
    };
    trainer.run(options.steps, 4);
    trainer.finish()
}

/// Levenberg-Marquardt in progress.
struct Trainer<'a> {
    data: NetworkData<'a>,
    hidden: usize,
    correlation: f64,
    theta: Vec<f64>,
    prior: Prior,
    /// Inverse noise variance of one row, counted as `1 / correlation` independent rows.
    beta: f64,
    damping: f64,
    growth: f64,
    steps: usize,
    weight: Vec<f64>,
    residual: Vec<f64>,
    jacobian: Vec<f64>,
    gram: Mat<f64>,
    gradient: Vec<f64>,
    squares: f64,
}

impl<'a> Trainer<'a> {
    fn new(data: NetworkData<'a>, hidden: usize, theta: Vec<f64>, correlation: f64) -> Self {
        let (n, p) = (data.targets.len(), theta.len());
        let correlation = correlation.max(1.0);
        Self {
            data,
            hidden,
            correlation,
            theta,
            prior: Prior::new(hidden, data.features),
            beta: 1.0 / (0.05 * correlation),
            damping: 0.005,
            growth: 2.0,
            steps: 0,
            weight: vec![1.0; n],
            residual: vec![0.0; n],
            jacobian: vec![0.0; BLOCK.min(n) * p],
            gram: Mat::zeros(p, p),
            gradient: vec![0.0; p],
            squares: 0.0,
        }
    }

    /// Steps until `limit` were accepted or `patience` in a row brought next to nothing.
    fn run(&mut self, limit: usize, patience: usize) {
        self.linearise();
        if self.steps >= 7 {
            huber(&self.residual, &mut self.weight);
            self.linearise();
        }
        let limit = limit.max(self.steps + 1);
        let mut flat = 0;
        for _ in 0..2 * limit {
            match self.step() {
                None => self.reject(),
                Some(gain) => {
                    flat = if gain < 2e-5 { flat + 1 } else { 0 };
                    self.steps += 1;
                    if self.steps >= 7 {
                        huber(&self.residual, &mut self.weight);
                    }
                    self.linearise();
                    if self.steps >= 3 && (self.steps < 12 || self.steps.is_multiple_of(2)) {
                        self.evidence();
                    }
                }
            }
            if self.steps >= limit || flat >= patience || self.damping > 1e12 {
                break;
            }
        }
    }

    fn reject(&mut self) {
        self.damping *= self.growth;
        self.growth *= 2.0;
    }

    /// One trial step with Nielsen's damping; the relative gain where it was accepted.
    fn step(&mut self) -> Option<f64> {
        let n = self.data.targets.len() as f64;
        let diagonal = self.prior.diagonal(self.theta.len());
        let shift = self.damping * self.beta * n / 50.0;
        let right: Vec<f64> = self
            .gradient
            .iter()
            .zip(&diagonal)
            .zip(self.theta.iter().zip(&self.prior.mean))
            .map(|((g, a), (t, m))| self.beta * g + a * (t - m))
            .collect();
        let before = 0.5 * self.beta * self.squares + self.prior.energy(&self.theta);
        let step = solve(&self.system(&diagonal, shift), &right)?;
        let trial: Vec<f64> = self.theta.iter().zip(&step).map(|(t, s)| t - s).collect();
        let promised = 0.5 * step.iter().zip(&right).map(|(s, r)| s * (shift * s + r)).sum::<f64>();
        let squares = self.evaluate(&trial);
        let after = 0.5 * self.beta * squares + self.prior.energy(&trial);
        if !(after.is_finite() && after < before) {
            return None;
        }
        let ratio = (before - after) / promised;
        self.damping = (self.damping * (1.0 - (2.0 * ratio - 1.0).powi(3)).clamp(1.0 / 3.0, 2.0)).max(1e-9);
        self.growth = 2.0;
        self.theta = trial;
        Some((before - after) / before.abs())
    }

    /// `beta J'wJ + A + shift`.
    fn system(&self, diagonal: &[f64], shift: f64) -> Mat<f64> {
        let p = diagonal.len();
        Mat::from_fn(p, p, |i, j| {
            let prior = if i == j { diagonal[i] + shift } else { 0.0 };
            self.beta * self.gram[(i.max(j), i.min(j))] + prior
        })
    }

    /// Residuals at `theta`; returns the weighted sum of their squares.
    fn evaluate(&mut self, theta: &[f64]) -> f64 {
        let parts = Parts::of(theta, self.hidden, self.data.features);
        let mut activation = vec![0.0; self.hidden];
        let rows = self.data.inputs.chunks_exact(self.data.features).zip(self.data.targets);
        let mut sum = 0.0;
        for (((z, target), residual), weight) in rows.zip(&mut self.residual).zip(&self.weight) {
            *residual = parts.output(z, &mut activation) - target;
            sum += weight * *residual * *residual;
        }
        sum
    }

    /// `J'wJ` (lower triangle), `J'we`, residuals and weighted squares at `theta`.
    fn linearise(&mut self) {
        let (f, p) = (self.data.features, self.theta.len());
        let parts = Parts::of(&self.theta, self.hidden, f);
        let mut activation = vec![0.0; self.hidden];
        self.gradient.fill(0.0);
        self.gram.fill(0.0);
        self.squares = 0.0;
        let n = self.data.targets.len();
        for start in (0..n).step_by(BLOCK) {
            let rows = BLOCK.min(n - start);
            for (row, values) in (start..start + rows).zip(self.jacobian.chunks_exact_mut(p)) {
                let z = &self.data.inputs[row * f..][..f];
                let error = parts.output(z, &mut activation) - self.data.targets[row];
                self.residual[row] = error;
                self.squares += self.weight[row] * error * error;
                let root = self.weight[row].sqrt();
                parts.gradient(z, &activation, root, values);
                for (sum, value) in self.gradient.iter_mut().zip(values) {
                    *sum += root * error * *value;
                }
            }
            let block = MatRef::from_row_major_slice(&self.jacobian[..rows * p], rows, p);
            matmul(
                self.gram.as_mut(),
                BlockStructure::TriangularLower,
                Accum::Add,
                block.transpose(),
                BlockStructure::Rectangular,
                block,
                BlockStructure::Rectangular,
                1.0,
                Par::Seq,
            );
        }
    }

    /// MacKay's re-estimation of the prior strengths and the noise level.
    fn evidence(&mut self) {
        let count = self.data.targets.len() as f64 / self.correlation;
        let diagonal = self.prior.diagonal(self.theta.len());
        let Ok(factor) = self.system(&diagonal, 0.0).llt(faer::Side::Lower) else { return };
        let inverse = factor.inverse();
        let mut determined = 0.0;
        for (range, alpha) in self.prior.groups.iter().zip(&mut self.prior.alpha) {
            let trace: f64 = range.clone().map(|i| inverse[(i, i)]).sum();
            let gamma = (range.len() as f64 - *alpha * trace).max(0.0);
            determined += gamma;
            let pairs = self.theta[range.clone()].iter().zip(&self.prior.mean[range.clone()]);
            let size: f64 = pairs.map(|(t, m)| (t - m) * (t - m)).sum();
            *alpha = (*alpha * gamma / size.max(1e-12)).sqrt().clamp(1e-4, 1e5);
        }
        let determined = determined.min(0.8 * count);
        self.beta = ((count - determined) / self.squares.max(1e-12)).clamp(1e-6, 1e8);
    }

    fn finish(self) -> Network {
        Network { hidden: self.hidden, features: self.data.features, theta: self.theta }
    }
}

/// Trains on from an older network, which is also what the prior draws to: what the new data do not tell stays.
pub(crate) fn retrain(data: &NetworkData<'_>, options: &NetworkOptions, old: &[f64]) -> Network {
    let mut trainer = Trainer::new(*data, options.hidden, old.to_vec(), options.correlation);
    trainer.prior.mean.copy_from_slice(old);
    trainer.run(options.steps, 4);
    trainer.finish()
}

fn initial(options: &NetworkOptions, features: usize) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(options.seed);
    let mut normal = move || {
        let (u, v): (f64, f64) = (rng.random(), rng.random());
        (-2.0 * (1.0 - u).ln()).sqrt() * (core::f64::consts::TAU * v).cos()
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

fn solve(system: &Mat<f64>, right: &[f64]) -> Option<Vec<f64>> {
    let factor = system.llt(faer::Side::Lower).ok()?;
    let rhs = Mat::from_fn(right.len(), 1, |i, _| right[i]);
    let x = factor.solve(&rhs);
    Some((0..right.len()).map(|i| x[(i, 0)]).collect())
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

#[cfg(test)]
mod tests {
    use super::*;

    fn options(steps: usize) -> NetworkOptions {
        NetworkOptions { hidden: 3, correlation: 1.0, steps, seed: 3 }
    }

    /// Two inputs that fill the square, and a target with a curve and noise of variance 0.01 / 12 * 4.
    fn data(n: usize) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let inputs: Vec<f64> = (0..2 * n).map(|_| 4.0 * rng.random::<f64>() - 2.0).collect();
        let clean = |z: &[f64]| (1.5 * z[0]).tanh() - 0.3 * z[1] + 0.5 * (z[0] + z[1]).tanh();
        let truth: Vec<f64> = inputs.chunks_exact(2).map(clean).collect();
        let targets = truth.iter().map(|t| t + 0.2 * (rng.random::<f64>() - 0.5)).collect();
        (inputs, targets, truth)
    }

    #[test]
    fn the_gradient_equals_finite_differences_for_every_parameter() {
        let (inputs, targets, _) = data(40);
        let data = NetworkData { inputs: &inputs, targets: &targets, features: 2 };
        let mut theta = initial(&options(1), 2);
        theta.iter_mut().enumerate().for_each(|(i, t)| *t += 0.1 * (i as f64).cos());
        let mut trainer = Trainer::new(data, 3, theta.clone(), 1.0);
        trainer.weight = (0..40).map(|i| 0.5 + 0.01 * f64::from(i)).collect();
        trainer.linearise();
        for i in 0..theta.len() {
            let mut at = |step: f64| {
                let mut moved = theta.clone();
                moved[i] += step;
                trainer.evaluate(&moved)
            };
            let numeric = (at(1e-6) - at(-1e-6)) / 4e-6;
            // The slope 1 - tanh^2 is that of the exact tanh: good to its 1e-4.
            assert!((trainer.gradient[i] - numeric).abs() < 2e-3 * (1.0 + numeric.abs()), "{i}");
        }
    }

    #[test]
    fn a_network_finds_the_curve_under_the_noise() {
        let (inputs, targets, truth) = data(4_000);
        let data = NetworkData { inputs: &inputs, targets: &targets, features: 2 };
        let network = train(&data, &options(60));
        let errors = inputs.chunks_exact(2).zip(&truth).map(|(z, t)| (network.evaluate(z) - t).powi(2));
        let rms = (errors.sum::<f64>() / 4_000.0).sqrt();
        assert!(rms < 0.02, "{rms}: the noise has 0.058");
    }

    #[test]
    fn targets_without_structure_leave_the_network_flat() {
        let (inputs, targets, truth) = data(2_000);
        let noise: Vec<f64> = targets.iter().zip(&truth).map(|(t, c)| 15.0 * (t - c)).collect();
        let data = NetworkData { inputs: &inputs, targets: &noise, features: 2 };
        let network = train(&data, &options(60));
        let power = inputs.chunks_exact(2).map(|z| network.evaluate(z).powi(2)).sum::<f64>() / 2_000.0;
        assert!(power < 0.02, "{power} of a target of power 0.75");
    }

    #[test]
    fn the_same_seed_gives_the_same_bits() {
        let (inputs, targets, _) = data(300);
        let data = NetworkData { inputs: &inputs, targets: &targets, features: 2 };
        assert_eq!(train(&data, &options(20)).theta, train(&data, &options(20)).theta);
    }
}
