//! Levenberg-Marquardt over the whole data set.

use super::network::Net;
use super::normal::{NormalEquations, normal_equations, squared_error};
use super::options::TrainOptions;
use super::scale::Samples;
use super::weights::Weights;
use crate::Error;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::{factor, solve};
use faer::{Mat, Par};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// Damping at the start, after success and after failure, as everybody has it since Hagan and Menhaj.
const DAMPING: f64 = 1e-3;
const RELAX: f64 = 0.1;
const TIGHTEN: f64 = 10.0;
const LEAST_DAMPING: f64 = 1e-20;
const MOST_DAMPING: f64 = 1e10;

/// Samples from which on the products in `J^T J` are summed in f32 first: beyond, the steps are as good.
const MANY: usize = 100_000;

/// Steps whose progress is held against [`TrainOptions::tolerance`].
const MEMORY: usize = 5;
/// Steps without progress on the samples held back before training stops.
const PATIENCE: usize = 6;

/// A trained network and how it came about.
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
    /// The samples held back were no longer served.
    HeldBack,
}

/// Trains one hidden layer of tanh nodes with a linear output by Levenberg-Marquardt on all samples at once.
///
/// ```text
/// minimise  L(theta) = 1/n sum_k (y(x_k; theta) - t_k)^2
/// (J^T J / n + mu I) step = -J^T e / n;   mu / 10 if L falls at once, mu * 10 and again if not
/// ```
///
/// Inputs and target are standardised first. Network, loss and gradient are computed in f64. `J^T J`, which only
/// says how far to go, is computed in f64 too, or from 100 000 samples on in f32 within each few hundred samples:
/// what f32 rounds off differs from sample to sample and is lost among so many. Memory beyond the arguments is one
/// copy of the samples and a few megabytes: no Jacobian is ever stored.
///
/// # Shapes
///
/// `inputs: [n x k]` row-major, `targets: [n]`; any unit.
///
/// # Assumes
///
/// Samples are exchangeable and their errors alike. Whoever splits recordings into training and test data must
/// do so by recording, before this.
///
/// # Departs
///
/// From the common practice in that `mu` rests after a step that needed a second trial, which saves most of the
/// refused ones, and in that it stops
/// on samples held back if asked to, and these are the
/// last ones, contiguous, rather than drawn at random from records whose neighbours are nearly the same.
///
/// Runs on the threads of the surrounding rayon pool; the result is the same to the bit for any number of them.
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
    train_with(inputs, targets, options, MANY)
}

/// [`train`] with its own idea of how many samples are [`MANY`].
pub(super) fn train_with(
    inputs: &[f64],
    targets: &[f64],
    options: &TrainOptions,
    many: usize,
) -> Result<Training, Error> {
    options.check()?;
    let samples = Samples::new(inputs, targets)?;
    let n = targets.len();
    let held_back = (options.held_back * n as f64) as usize;
    let (fitted, held_back) = samples.rows.split_at((n - held_back) * (samples.inputs + 1));
    let mut descent = Descent { many, ..Descent::new(&samples, fitted, held_back, options) };
    let end = descent.run(options)?;
    Ok(descent.finish(&samples, end))
}

/// Where the descent stands.
struct Descent<'a> {
    inputs: usize,
    hidden: usize,
    many: usize,
    fitted: &'a [f64],
    held_back: &'a [f64],
    theta: Vec<f64>,
    net: Net,
    damping: f64,
    losses: Vec<f64>,
    held_back_losses: Vec<f64>,
    best: Vec<f64>,
    steps: usize,
    rejected: usize,
}

impl<'a> Descent<'a> {
    fn new(samples: &Samples, fitted: &'a [f64], held_back: &'a [f64], options: &TrainOptions) -> Self {
        let (inputs, hidden) = (samples.inputs, options.hidden);
        let theta = initial(inputs, hidden, options.seed);
        Self {
            inputs,
            hidden,
            many: MANY,
            fitted,
            held_back,
            net: Net::new(inputs, hidden, &theta),
            best: theta.clone(),
            theta,
            damping: DAMPING,
            losses: Vec::new(),
            held_back_losses: Vec::new(),
            steps: 0,
            rejected: 0,
        }
    }

    fn run(&mut self, options: &TrainOptions) -> Result<End, Error> {
        self.losses.push(self.mean_squared_error(&self.net, self.fitted));
        self.judge_held_back();
        while self.steps < options.steps {
            let equations = if self.fitted.len() / (self.inputs + 1) < self.many {
                normal_equations::<f64>(&self.net, self.fitted)
            } else {
                normal_equations::<f32>(&self.net, self.fitted)
            };
            if !equations.squared_error.is_finite() {
                return Err(Error::samples("loss", "a finite number", &equations.squared_error));
            }
            if !self.step(&equations) {
                return Ok(End::Minimum);
            }
            if self.judge_held_back() {
                return Ok(End::HeldBack);
            }
            if self.stalled(options.tolerance) {
                return Ok(End::Tolerance);
            }
        }
        Ok(End::Steps)
    }

    /// One step down, with as much damping as it takes. False if none leads down.
    fn step(&mut self, equations: &NormalEquations) -> bool {
        let samples = (self.fitted.len() / (self.inputs + 1)) as f64;
        let loss = self.losses.last().copied().unwrap_or(f64::INFINITY);
        self.steps += 1;
        let mut refused = 0;
        while self.damping <= MOST_DAMPING {
            if let Some(step) = solve_damped(equations, samples, self.damping) {
                let trial: Vec<f64> = self.theta.iter().zip(&step).map(|(a, b)| a - b).collect();
                let net = Net::new(self.inputs, self.hidden, &trial);
                let trial_loss = self.mean_squared_error(&net, self.fitted);
                if trial_loss < loss {
                    self.theta = trial;
                    self.net = net;
                    self.losses.push(trial_loss);
                    self.rejected += refused;
                    if refused == 0 {
                        self.damping = (self.damping * RELAX).max(LEAST_DAMPING);
                    }
                    return true;
                }
            }
            refused += 1;
            self.damping *= TIGHTEN;
        }
        self.rejected += refused;
        self.losses.push(loss);
        false
    }

    /// Keeps the best weights; true once patience is at its end.
    fn judge_held_back(&mut self) -> bool {
        if self.held_back.is_empty() {
            self.best.clone_from(&self.theta);
            return false;
        }
        let loss = self.mean_squared_error(&self.net, self.held_back);
        let lowest = self.held_back_losses.iter().copied().fold(f64::INFINITY, f64::min);
        self.held_back_losses.push(loss);
        if loss < lowest {
            self.best.clone_from(&self.theta);
            return false;
        }
        let recent = &self.held_back_losses[self.held_back_losses.len().saturating_sub(PATIENCE)..];
        recent.iter().all(|loss| *loss > lowest)
    }

    fn stalled(&self, tolerance: f64) -> bool {
        let Some(before) = self.losses.len().checked_sub(MEMORY + 1) else { return false };
        let (before, now) = (self.losses[before], self.losses[self.losses.len() - 1]);
        before - now < tolerance * before
    }

    fn mean_squared_error(&self, net: &Net, samples: &[f64]) -> f64 {
        squared_error(net, samples) / (samples.len() / (self.inputs + 1)).max(1) as f64
    }

    fn finish(self, samples: &Samples, end: End) -> Training {
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
        Training {
            network,
            loss_per_step: in_unit(self.losses),
            held_back_loss_per_step: in_unit(self.held_back_losses),
            steps: self.steps,
            rejected_steps: self.rejected,
            end,
        }
    }
}

/// `(J^T J / n + mu I)^-1 J^T e / n`, or nothing where the matrix is not positive definite in f64.
fn solve_damped(equations: &NormalEquations, samples: f64, damping: f64) -> Option<Vec<f64>> {
    let p = equations.gradient.len();
    let mut matrix = Mat::from_fn(p, p, |row, column| {
        let entry = equations.matrix[(row, column)] / samples;
        if row == column { entry + damping } else { entry }
    });
    let mut step = Mat::from_fn(p, 1, |row, _| equations.gradient[row] / samples);
    let mut buffer =
        MemBuffer::new(factor::cholesky_in_place_scratch::<f64>(p, Par::Seq, Default::default()));
    let stack = MemStack::new(&mut buffer);
    factor::cholesky_in_place(matrix.as_mut(), Default::default(), Par::Seq, stack, Default::default())
        .ok()?;
    solve::solve_in_place(matrix.as_ref(), step.as_mut(), Par::Seq, stack);
    let step: Vec<f64> = (0..p).map(|row| step[(row, 0)]).collect();
    step.iter().all(|entry| entry.is_finite()).then_some(step)
}

/// Initial weights: nodes whose active regions cover the inputs, in random directions.
fn initial(inputs: usize, hidden: usize, seed: u64) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut symmetric = move || (rng.next_u64() >> 11) as f64 / (1_u64 << 52) as f64 - 1.0;
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
