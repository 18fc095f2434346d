//! Training of one network on all samples at once.

use super::network::{Net, Weights};
use super::normal_equations::{normal_equations, squared_error};
use super::samples::Samples;
use crate::Error;
use crate::fit::levenberg_marquardt::{
    self as search, Adaptation, Damping, Limits, Problem, Scaling, minimise,
};
use crate::fit::linearisation::Linearisation;
use crate::fit::prior::Prior;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::ops::ControlFlow;

/// `mu` of Hagan and Menhaj; inputs and target are standardised, so that `D` is the identity.
const DAMPING: Damping = Damping {
    initial: 1e-3,
    min: 1e-20,
    scaling: Scaling::Identity { factor: 1.0 },
    adaptation: Adaptation::Factor(10.0),
};

/// Samples from which on the products in `J^T J` are summed in f32 first: beyond, the steps are as good.
const F32_FROM: usize = 100_000;

/// Steps over which the decrease of the loss is compared with [`TrainOptions::tolerance`].
const WINDOW: usize = 5;
/// Steps without a lower loss on the samples held back before training stops.
const EARLY_STOPPING_STEPS: usize = 6;

/// Options of [`train`](super::train).
#[derive(Debug, Clone, PartialEq)]
pub struct TrainOptions {
    /// Hidden nodes, 1 to 512.
    pub hidden: usize,
    /// Most steps, each with one evaluation of the normal equations.
    pub steps: usize,
    /// Seed of the initial weights.
    pub seed: u64,
    /// Stop once five steps together lower the loss by less than this fraction of it; 0 never stops.
    pub tolerance: f64,
    /// Fraction of the samples, at the end, that are held back: training stops after six steps that did not
    /// lower the loss on them and returns the weights that were best on them. 0 holds nothing back; below 1.
    pub held_back: f64,
}

impl Default for TrainOptions {
    /// 30 nodes, 200 steps, nothing held back.
    fn default() -> Self {
        Self { hidden: 30, steps: 200, seed: 0, tolerance: 1e-6, held_back: 0.0 }
    }
}

impl TrainOptions {
    pub(super) fn check(&self) -> Result<(), Error> {
        if !(1..=512).contains(&self.hidden) {
            return Err(Error::samples("hidden", "1 to 512 nodes", &self.hidden));
        }
        if !(self.tolerance >= 0.0 && self.tolerance < 1.0) {
            return Err(Error::samples("tolerance", "at least 0 and below 1", &self.tolerance));
        }
        if !(self.held_back >= 0.0 && self.held_back < 1.0) {
            return Err(Error::samples("held_back", "at least 0 and below 1", &self.held_back));
        }
        Ok(())
    }
}

/// A trained network and the record of its training.
#[derive(Debug, Clone, PartialEq)]
pub struct Training {
    /// The network; with samples held back, the one that was best on them.
    pub network: Weights,
    /// Mean squared error over the training samples, unit of the target squared: before the first step and
    /// after every step. It never rises.
    pub loss_per_step: Vec<f64>,
    /// The same over the samples held back; empty if there are none.
    pub held_back_loss_per_step: Vec<f64>,
    /// Steps made, each with one evaluation of the normal equations.
    pub steps: usize,
    /// Trial steps that would have raised the loss and were not made.
    pub rejected_steps: usize,
    /// Why it ended.
    pub end: End,
}

/// Why a training ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum End {
    /// All steps made.
    Steps,
    /// Progress fell below the tolerance.
    Tolerance,
    /// No step lowers the loss any more.
    Minimum,
    /// The loss on the samples held back no longer fell.
    HeldBack,
}

/// Trains one hidden layer of tanh nodes with a linear output by Levenberg-Marquardt on all samples at once.
///
/// ```text
/// minimise  L(theta) = 1/n sum_k (y(x_k; theta) - t_k)^2
/// (J^T J / n + mu I) step = -J^T e / n;   mu / 10 if L falls at once, mu * 10 and again if not
/// ```
///
/// Inputs and target are standardised first. Network, loss and gradient are computed in f64; `J^T J`, which
/// affects the length of a step but not the minimum, in f64 too, or from 100 000 samples on in f32 within
/// each few hundred samples, whose rounding errors average out. Memory beyond the arguments is one copy of
/// the samples and a few megabytes: the Jacobian is not stored.
///
/// # Shapes
///
/// `inputs: [n x k]` row-major, `targets: [n]`; any unit.
///
/// # Assumes
///
/// Samples are exchangeable and their errors have one variance. Recordings must be split into training and
/// test data by recording, before this.
///
/// # Departs
///
/// `mu` stays after a step that needed a second trial, which avoids most rejected ones. The samples held back
/// for early stopping, if any, are the last ones, contiguous, rather than sampled at random from recordings
/// whose neighbouring samples are nearly the same.
///
/// Runs on the threads of the surrounding rayon pool; the result is bit-identical for any number of
/// them.
///
/// # Errors
///
/// [`Error::Samples`] names the argument, with sample and column, for: no samples, lengths that do not fit,
/// numbers that are not finite, a constant target, options outside their domain.
///
/// # Example
///
/// ```
/// use sinew_identify::fit::perceptron::{TrainOptions, train};
///
/// let inputs: Vec<f64> = (0..200).map(|i| f64::from(i) / 50.0 - 2.0).collect();
/// let targets: Vec<f64> = inputs.iter().map(|x| x.abs()).collect();
/// let training = train(&inputs, &targets, &TrainOptions { hidden: 6, steps: 40, ..Default::default() })?;
/// assert!((training.network.output(&[1.5]) - 1.5).abs() < 0.05);
/// # Ok::<(), sinew_identify::Error>(())
/// ```
///
/// # Source
/// Steps: `hagan1994`; initial weights: `nguyen1990`.
#[doc(alias = "trainlm")]
pub fn train(inputs: &[f64], targets: &[f64], options: &TrainOptions) -> Result<Training, Error> {
    options.check()?;
    let samples = Samples::new(inputs, targets)?;
    let n = targets.len();
    let held_back = (options.held_back * n as f64) as usize;
    let (fitted, held_back) = samples.rows.split_at((n - held_back) * (samples.inputs + 1));
    let theta = initial(samples.inputs, options.hidden, options.seed);
    let mut descent = Descent {
        inputs: samples.inputs,
        hidden: options.hidden,
        tolerance: options.tolerance,
        fitted,
        held_back,
        losses: Vec::new(),
        held_back_losses: Vec::new(),
        best: theta.clone(),
        end: None,
    };
    let loss = descent.mean_squared_error(&theta, fitted);
    descent.record(&theta, loss);
    // When to stop is decided on the recorded losses.
    let limits = Limits { steps: options.steps, trials: usize::MAX, tolerance: 0.0, small_steps: usize::MAX };
    let mut prior = Prior::none(theta.len());
    let found = minimise(&mut descent, theta, &mut prior, &DAMPING, &limits)
        .ok_or_else(|| Error::samples("loss", "a finite number", &loss))?;
    Ok(descent.finish(&samples, &found))
}

/// The network on its samples as a problem of the search, and the record of its losses.
struct Descent<'a> {
    inputs: usize,
    hidden: usize,
    tolerance: f64,
    fitted: &'a [f64],
    held_back: &'a [f64],
    losses: Vec<f64>,
    held_back_losses: Vec<f64>,
    /// Parameters with the lowest loss on the samples held back, or the last ones.
    best: Vec<f64>,
    end: Option<End>,
}

impl Descent<'_> {
    fn net(&self, theta: &[f64]) -> Net {
        Net::new(self.inputs, self.hidden, theta)
    }

    /// Mean squared error over samples `[n x (inputs + 1)]`.
    fn mean_squared_error(&self, theta: &[f64], samples: &[f64]) -> f64 {
        squared_error(&self.net(theta), samples) / self.count(samples)
    }

    fn count(&self, samples: &[f64]) -> f64 {
        (samples.len() / (self.inputs + 1)).max(1) as f64
    }

    /// Records the losses at `theta`; true once the samples held back have had no lower loss for
    /// [`EARLY_STOPPING_STEPS`] steps.
    fn record(&mut self, theta: &[f64], loss: f64) -> bool {
        self.losses.push(loss);
        if self.held_back.is_empty() {
            self.best = theta.to_vec();
            return false;
        }
        let loss = self.mean_squared_error(theta, self.held_back);
        let lowest = self.held_back_losses.iter().copied().fold(f64::INFINITY, f64::min);
        self.held_back_losses.push(loss);
        if loss < lowest {
            self.best = theta.to_vec();
            return false;
        }
        let recent =
            &self.held_back_losses[self.held_back_losses.len().saturating_sub(EARLY_STOPPING_STEPS)..];
        recent.iter().all(|loss| *loss > lowest)
    }

    fn stalled(&self) -> bool {
        let Some(before) = self.losses.len().checked_sub(WINDOW + 1) else { return false };
        let (before, now) = (self.losses[before], self.losses[self.losses.len() - 1]);
        before - now < self.tolerance * before
    }

    fn finish(self, samples: &Samples, found: &search::Minimum) -> Training {
        let (k, h) = (self.inputs, self.hidden);
        let unit = samples.target.scale * samples.target.scale;
        let in_unit = |losses: Vec<f64>| losses.into_iter().map(|loss| loss * unit).collect();
        let weights = (0..h).flat_map(|j| (0..k).map(move |i| i * h + j)).map(|at| self.best[at]);
        let network = Weights {
            inputs: k,
            hidden: h,
            hidden_weights: weights.collect(),
            hidden_bias: self.best[k * h..(k + 1) * h].to_vec(),
            output_weights: self.best[(k + 1) * h..(k + 2) * h].to_vec(),
            output_bias: self.best[(k + 2) * h],
            input_mean: samples.input.iter().map(|scaling| scaling.mean).collect(),
            input_scale: samples.input.iter().map(|scaling| scaling.scale).collect(),
            output_mean: samples.target.mean,
            output_scale: samples.target.scale,
        };
        let end = self.end.unwrap_or(match found.end {
            search::End::Converged => End::Minimum,
            search::End::Limit | search::End::Stopped => End::Steps,
        });
        Training {
            network,
            loss_per_step: in_unit(self.losses),
            held_back_loss_per_step: in_unit(self.held_back_losses),
            steps: found.steps,
            rejected_steps: found.rejected,
            end,
        }
    }
}

impl Problem for Descent<'_> {
    fn squares(&mut self, theta: &[f64]) -> Option<f64> {
        Some(self.mean_squared_error(theta, self.fitted))
    }

    fn linearise(&mut self, theta: &[f64], at: &mut Linearisation) -> bool {
        let (net, count) = (self.net(theta), self.count(self.fitted));
        *at = if count < F32_FROM as f64 {
            normal_equations::<f64>(&net, self.fitted)
        } else {
            normal_equations::<f32>(&net, self.fitted)
        };
        at.divide(count);
        at.squares.is_finite()
    }

    fn accepted(&mut self, theta: &[f64], squares: f64) -> ControlFlow<()> {
        if self.record(theta, squares) {
            self.end = Some(End::HeldBack);
        } else if self.stalled() {
            self.end = Some(End::Tolerance);
        }
        if self.end.is_some() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

/// Initial weights: nodes whose active regions cover the inputs, in random directions.
fn initial(inputs: usize, hidden: usize, seed: u64) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut symmetric = move || 2.0 * rng.random::<f64>() - 1.0;
    let reach = 0.7 * (hidden as f64).powf(1.0 / inputs as f64);
    let mut theta = vec![0.0; Net::parameters(inputs, hidden)];
    for j in 0..hidden {
        let direction: Vec<f64> = (0..inputs).map(|_| symmetric()).collect();
        let length = direction.iter().map(|x| x * x).sum::<f64>().sqrt().max(1e-9);
        for (i, x) in direction.iter().enumerate() {
            theta[i * hidden + j] = reach * x / length;
        }
        theta[inputs * hidden + j] = reach * symmetric();
        theta[(inputs + 1) * hidden + j] = symmetric() / (hidden as f64).sqrt();
    }
    theta
}
