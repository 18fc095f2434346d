//! One network of an ensemble, trained under a Gaussian prior whose strength follows the evidence.
//!
//! ```text
//! y = b + a . z + sum_j v_j tanh(d_j + W_j . z)
//! ```
//!
//! Inputs and targets are standardised. Weights of samples are Huber's, from the residuals of the step
//! before.
//!
//! # Source
//! Regularisation: `mackay1992`; `foresee1997` for its use with Levenberg-Marquardt.

use super::levenberg_marquardt::{Adaptation, Damping, Limits, Problem, Scaling, minimise};
use super::linear_algebra::Matrix;
use super::linearisation::Linearisation;
use super::prior::{Evidence, Group, Prior};
use super::tiles::BLOCK;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use sinew::math::quick_tanh;
use std::ops::ControlFlow;

/// Standardised inputs `[n x features]` row-major and targets `[n]`.
#[derive(Clone, Copy)]
pub(crate) struct NetworkData<'a> {
    pub inputs: &'a [f64],
    pub targets: &'a [f64],
    pub features: usize,
}

impl NetworkData<'_> {
    /// The prior of a network on these rows, of which `correlation` are one independent sample.
    fn prior(&self, hidden: usize, correlation: f64) -> Prior {
        let correlation = correlation.max(1.0);
        let samples = self.targets.len() as f64 / correlation;
        prior(hidden, self.features, samples, 1.0 / (FIRST_VARIANCE * correlation))
    }
}

/// How a network is trained.
#[derive(Debug, Clone, Copy)]
pub(crate) struct NetworkOptions {
    /// Hidden tanh nodes.
    pub hidden: usize,
    /// Rows per independent sample; the evidence counts independent samples.
    pub correlation: f64,
    /// Accepted steps, at most.
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
        let parts = Parts::new(&self.theta, self.hidden, self.features);
        parts.output(z, &mut vec![0.0; self.hidden])
    }

    pub(crate) fn parts(&self) -> Parts<'_> {
        Parts::new(&self.theta, self.hidden, self.features)
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
    fn new(theta: &'a [f64], hidden: usize, features: usize) -> Self {
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

/// The prior of a network: one group for each of W, d, v, a and b.
fn prior(hidden: usize, features: usize, samples: f64, precision: f64) -> Prior {
    let w = hidden * features;
    let (d, v) = (w + hidden, w + 2 * hidden);
    let a = v + features;
    let group = |range, alpha| Group { range, alpha };
    Prior {
        precision,
        // Weights of standardised data are of size 3; the offset is free.
        groups: vec![
            group(0..w, 0.1),
            group(w..d, 0.1),
            group(d..v, 0.1),
            group(v..a, 0.1),
            group(a..a + 1, 1e-6),
        ],
        mean: vec![0.0; a + 1],
        evidence: Some(Evidence { samples, steps: 0 }),
    }
}

/// Rows of the first, coarse stage of training.
const COARSE_ROWS: usize = 1500;

/// Residual variance of a standardised target that is assumed before the first evidence.
const FIRST_VARIANCE: f64 = 0.05;

/// Accepted steps from which on samples are weighted by their residuals. Before, residuals are what is not
/// yet learned, and large ones must not be discarded.
const ROBUST_FROM: usize = 7;

/// A step that gains less than 2e-5 of the cost is far below the noise of the estimate; four in a row are not
/// a saddle.
const TOLERANCE: f64 = 2e-5;
const SMALL_STEPS: usize = 4;

/// Mean square of the derivative of the output by one weight, in order of magnitude: makes `mu` relative to
/// the curvature of the data.
const SENSITIVITY: f64 = 1.0 / 50.0;

/// Trains one network. Deterministic: the same data and seed give the same bits.
///
/// Most of the steps are made on a thinned copy of the rows, the last ones on all of them.
pub(crate) fn train(data: &NetworkData<'_>, options: &NetworkOptions) -> Network {
    let (h, f) = (options.hidden, data.features);
    let mut theta = initial(options, f);
    let stride = data.targets.len() / COARSE_ROWS;
    let mut prior = data.prior(h, options.correlation);
    let mut steps = 0;
    if stride > 1 {
        let inputs: Vec<f64> = data.inputs.chunks_exact(f).step_by(stride).flatten().copied().collect();
        let targets: Vec<f64> = data.targets.iter().step_by(stride).copied().collect();
        let coarse = NetworkData { inputs: &inputs, targets: &targets, features: f };
        let correlation = options.correlation / stride as f64;
        let mut coarse_prior = coarse.prior(h, correlation);
        (theta, steps) = descend(&coarse, h, theta, &mut coarse_prior, options.steps, 0);
        // A precision is per row, and rows apart are less correlated.
        let precision = coarse_prior.precision * correlation.max(1.0) / options.correlation.max(1.0);
        let evidence = prior.evidence.map(|evidence| Evidence { steps, ..evidence });
        prior = Prior { precision, evidence, ..coarse_prior };
    }
    (theta, _) = descend(data, h, theta, &mut prior, options.steps, steps);
    Network { hidden: h, features: f, theta }
}

/// Continues the training of a network under a prior that draws to its old weights: what the new data do not
/// determine stays.
pub(crate) fn retrain(data: &NetworkData<'_>, options: &NetworkOptions, old: &[f64]) -> Network {
    let mut prior = data.prior(options.hidden, options.correlation);
    prior.mean.copy_from_slice(old);
    let (theta, _) = descend(data, options.hidden, old.to_vec(), &mut prior, options.steps, 0);
    Network { hidden: options.hidden, features: data.features, theta }
}

/// Searches until `limit` steps were accepted, `before` earlier ones included, or progress ends: parameters
/// and steps.
fn descend(
    data: &NetworkData<'_>,
    hidden: usize,
    theta: Vec<f64>,
    prior: &mut Prior,
    limit: usize,
    before: usize,
) -> (Vec<f64>, usize) {
    let n = data.targets.len();
    let mut problem = Training::new(*data, hidden, theta.len(), before);
    if before >= ROBUST_FROM {
        problem.squares(&theta);
        problem.reweight();
    }
    let damping = Damping {
        initial: 0.005,
        min: 1e-9,
        scaling: Scaling::Identity { factor: SENSITIVITY * n as f64 },
        adaptation: Adaptation::GainRatio,
    };
    let limit = limit.max(before + 1);
    let limits =
        Limits { steps: limit - before, trials: 2 * limit, tolerance: TOLERANCE, small_steps: SMALL_STEPS };
    match minimise(&mut problem, theta.clone(), prior, &damping, &limits) {
        Some(found) => (found.theta, before + found.steps),
        None => (theta, before),
    }
}

/// A network on its rows as a problem of the search.
struct Training<'a> {
    data: NetworkData<'a>,
    hidden: usize,
    steps: usize,
    /// Of every row, in the sum of squares: `[n]`.
    weight: Vec<f64>,
    /// At the parameters evaluated last: `[n]`.
    residual: Vec<f64>,
    jacobian: Vec<f64>,
    activation: Vec<f64>,
}

impl<'a> Training<'a> {
    fn new(data: NetworkData<'a>, hidden: usize, parameters: usize, steps: usize) -> Self {
        let n = data.targets.len();
        Self {
            data,
            hidden,
            steps,
            weight: vec![1.0; n],
            residual: vec![0.0; n],
            jacobian: vec![0.0; BLOCK.min(n) * Matrix::stride(parameters)],
            activation: vec![0.0; hidden],
        }
    }

    fn reweight(&mut self) {
        huber(&self.residual, &mut self.weight);
    }
}

impl Problem for Training<'_> {
    fn squares(&mut self, theta: &[f64]) -> Option<f64> {
        let parts = Parts::new(theta, self.hidden, self.data.features);
        let rows = self.data.inputs.chunks_exact(self.data.features).zip(self.data.targets);
        let mut sum = 0.0;
        for (((z, target), residual), weight) in rows.zip(&mut self.residual).zip(&self.weight) {
            *residual = parts.output(z, &mut self.activation) - target;
            sum += weight * *residual * *residual;
        }
        Some(sum)
    }

    fn linearise(&mut self, theta: &[f64], at: &mut Linearisation) -> bool {
        at.clear();
        let (f, n, stride) = (self.data.features, self.data.targets.len(), Matrix::stride(theta.len()));
        let parts = Parts::new(theta, self.hidden, f);
        for start in (0..n).step_by(BLOCK) {
            let rows = BLOCK.min(n - start);
            for (row, values) in (start..start + rows).zip(self.jacobian.chunks_exact_mut(stride)) {
                let z = &self.data.inputs[row * f..][..f];
                let error = parts.output(z, &mut self.activation) - self.data.targets[row];
                at.squares += self.weight[row] * error * error;
                let root = self.weight[row].sqrt();
                parts.gradient(z, &self.activation, root, values);
                for (sum, value) in at.gradient.iter_mut().zip(&*values) {
                    *sum += root * error * *value;
                }
            }
            at.normal.add_square(&self.jacobian[..rows * stride]);
        }
        true
    }

    fn accepted(&mut self, _theta: &[f64], _squares: f64) -> ControlFlow<()> {
        self.steps += 1;
        if self.steps >= ROBUST_FROM {
            self.reweight();
        }
        ControlFlow::Continue(())
    }
}

fn initial(options: &NetworkOptions, features: usize) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(options.seed);
    let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
    let h = options.hidden;
    let mut theta = Vec::with_capacity(Network::size(h, features));
    let spread = 1.0 / (features as f64).sqrt();
    theta.extend((0..h * features).map(|_| spread * normal()));
    // Standard deviation of a uniform number in -1..1.
    theta.extend((0..h).map(|_| (normal() / 3.0_f64.sqrt()).clamp(-1.0, 1.0)));
    theta.extend((0..h).map(|_| 0.1 * normal()));
    theta.resize(Network::size(h, features), 0.0);
    theta
}

/// Huber weights at three robust standard deviations, 1.4826 times the median of the absolute residuals each.
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
    use rand::RngExt;

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
        let mut training = Training::new(data, 3, theta.len(), 0);
        training.weight = (0..40).map(|i| 0.5 + 0.01 * f64::from(i)).collect();
        let mut at = Linearisation::zeros(theta.len());
        assert!(training.linearise(&theta, &mut at));
        for i in 0..theta.len() {
            let mut shifted = |step: f64| {
                let mut theta = theta.clone();
                theta[i] += step;
                training.squares(&theta).unwrap()
            };
            let numeric = (shifted(1e-6) - shifted(-1e-6)) / 4e-6;
            // The slope 1 - tanh^2 is that of the exact tanh: good to its 1e-4.
            assert!((at.gradient[i] - numeric).abs() < 2e-3 * (1.0 + numeric.abs()), "{i}");
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
