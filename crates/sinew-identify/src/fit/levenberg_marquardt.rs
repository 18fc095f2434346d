//! Levenberg-Marquardt on a regularised sum of squares: the one search of all fits.
//!
//! ```text
//! minimise  C(theta) = beta r^T W r + sum_g alpha_g |theta_g - m_g|^2
//! (H + mu D) d = -g,   H = beta J^T W J + diag(alpha),   g = beta J^T W r + diag(alpha) (theta - m)
//! theta <- theta + d   where that lowers C
//! ```
//!
//! A [`Problem`] supplies `r^T W r`, `J^T W r` and `J^T W J`, a [`Prior`] the rest; [`Damping`] says what `D`
//! is and how `mu` follows the success of the steps.
//!
//! # Source
//! `levenberg1944`, `marquardt1963`; the gain ratio of [`Adaptation::GainRatio`]: `nielsen1999`.

use super::linear_algebra::Cholesky;
use super::linearisation::Linearisation;
use super::prior::Prior;
use std::ops::ControlFlow;

/// A weighted sum of squared residuals.
pub(crate) trait Problem {
    /// `r^T W r` at `theta: [p]`; `None` outside the domain.
    fn squares(&mut self, theta: &[f64]) -> Option<f64>;

    /// Writes the linearisation at `theta: [p]`; `false` outside the domain.
    fn linearise(&mut self, theta: &[f64], at: &mut Linearisation) -> bool;

    /// Called after every accepted step with the new parameters and their `r^T W r`. May change the weights,
    /// which the next linearisation then uses, and may end the search.
    fn accepted(&mut self, _theta: &[f64], _squares: f64) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

/// The damping term `mu D`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Damping {
    /// First `mu`.
    pub initial: f64,
    /// Smallest `mu`.
    pub min: f64,
    /// `D`.
    pub scaling: Scaling,
    /// How `mu` changes.
    pub adaptation: Adaptation,
}

/// Largest `mu`: beyond it steps are below rounding, and the search has converged.
const MAX_DAMPING: f64 = 1e12;

/// The matrix `D`.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Scaling {
    /// `D = factor beta I`: for parameters of one scale.
    Identity {
        /// Multiplies the precision of the residuals.
        factor: f64,
    },
    /// `D = diag(H) + floor max(diag(H)) I`: invariant to the scales of the parameters; the floor keeps the
    /// system definite where a parameter has no effect.
    Diagonal {
        /// Relative to the largest entry of the diagonal.
        floor: f64,
    },
}

/// How `mu` follows the success of the steps.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Adaptation {
    /// `mu` times `max(1/3, 1 - (2 rho - 1)^3)` after a step whose decrease was `rho` times the predicted
    /// one; times 2, 4, 8, .. after rejected ones in a row.
    GainRatio,
    /// `mu / factor` after an accepted step; times 2, 4, 8, .. after rejected ones in a row: for residuals
    /// with kinks, where the predicted decrease is unreliable.
    Growing(f64),
    /// `mu / factor` after a step that succeeded at once, `mu * factor` after a rejected one.
    Factor(f64),
}

/// Limits of a search.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Limits {
    /// Accepted steps, at most.
    pub steps: usize,
    /// Steps tried, accepted or rejected, at most.
    pub trials: usize,
    /// A step that lowers `C` by less than this fraction is small; where a rejected one was predicted to, the
    /// search has converged.
    pub tolerance: f64,
    /// Small steps in a row that end the search.
    pub small_steps: usize,
}

/// Why a search ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum End {
    /// Small steps only, or none that lowers `C`.
    Converged,
    /// A limit on steps or trials.
    Limit,
    /// [`Problem::accepted`] ended it.
    Stopped,
}

/// Outcome of a search.
#[derive(Debug, Clone)]
pub(crate) struct Minimum {
    /// The best parameters found: `[p]`.
    pub theta: Vec<f64>,
    /// `C` there, under the prior of the last step; infinite where no step was allowed.
    pub cost: f64,
    /// Accepted steps.
    pub steps: usize,
    /// Rejected steps.
    pub rejected: usize,
    /// Why it ended.
    pub end: End,
}

/// Searches from `theta: [p]`; `None` where the problem is not finite there. `prior` is left as last
/// re-estimated.
pub(crate) fn minimise(
    problem: &mut impl Problem,
    mut theta: Vec<f64>,
    prior: &mut Prior,
    damping: &Damping,
    limits: &Limits,
) -> Option<Minimum> {
    let mut at = Linearisation::zeros(theta.len());
    let mut mu = Mu { value: damping.initial, growth: 2.0, rejected_before: false };
    let (mut steps, mut rejected, mut small, mut linearised_at) = (0, 0, 0, None);
    let mut cost = f64::INFINITY;
    let end = loop {
        if steps >= limits.steps || steps + rejected >= limits.trials {
            break End::Limit;
        }
        if linearised_at != Some(steps) {
            if !problem.linearise(&theta, &mut at) {
                return None;
            }
            if steps > 0 {
                prior.update(&at, &theta);
            }
            linearised_at = Some(steps);
            cost = prior.cost(at.squares, &theta);
            if !cost.is_finite() {
                return None;
            }
        }
        let step = Step::compute(&at, &theta, prior, damping.scaling, mu.value);
        let predicted = step.as_ref().map_or(f64::INFINITY, |step| step.predicted_decrease);
        let trial = step.and_then(|step| {
            let squares = problem.squares(&step.theta)?;
            let lower = prior.cost(squares, &step.theta);
            (lower < cost).then_some((step, squares, lower))
        });
        let Some((step, squares, lower)) = trial else {
            rejected += 1;
            mu.increase(damping);
            // A shorter step would lower `C` by even less than this one was predicted to.
            if mu.value > MAX_DAMPING || predicted < limits.tolerance * cost {
                break End::Converged;
            }
            continue;
        };
        mu.decrease(damping, (cost - lower) / predicted);
        small = if cost - lower < limits.tolerance * cost { small + 1 } else { 0 };
        theta = step.theta;
        cost = lower;
        steps += 1;
        if problem.accepted(&theta, squares).is_break() {
            break End::Stopped;
        }
        if small >= limits.small_steps || cost <= 0.0 {
            break End::Converged;
        }
    };
    Some(Minimum { theta, cost, steps, rejected, end })
}

/// One trial step.
struct Step {
    theta: Vec<f64>,
    /// Decrease of `C` that the linearisation predicts.
    predicted_decrease: f64,
}

impl Step {
    /// `None` where the damped system is not positive definite.
    fn compute(at: &Linearisation, theta: &[f64], prior: &Prior, scaling: Scaling, mu: f64) -> Option<Self> {
        let p = theta.len();
        let gradient = prior.gradient(at, theta);
        let mut system = prior.matrix(at);
        let largest = (0..p).map(|i| system[(i, i)]).fold(0.0, f64::max);
        let mut added = vec![0.0; p];
        for (i, added) in added.iter_mut().enumerate() {
            *added = mu
                * match scaling {
                    Scaling::Identity { factor } => factor * prior.precision,
                    Scaling::Diagonal { floor } => system[(i, i)] + floor * largest,
                };
            system[(i, i)] += *added;
        }
        let downhill = Cholesky::new(system)?.solve(&gradient)?;
        let predicted = |((s, g), a): ((&f64, &f64), &f64)| s * (a * s + g);
        let predicted_decrease = downhill.iter().zip(&gradient).zip(&added).map(predicted).sum();
        Some(Self { theta: theta.iter().zip(&downhill).map(|(t, s)| t - s).collect(), predicted_decrease })
    }
}

/// The damping parameter during a search.
struct Mu {
    value: f64,
    growth: f64,
    rejected_before: bool,
}

impl Mu {
    fn increase(&mut self, damping: &Damping) {
        match damping.adaptation {
            Adaptation::GainRatio | Adaptation::Growing(_) => {
                self.value *= self.growth;
                self.growth *= 2.0;
            }
            Adaptation::Factor(factor) => self.value *= factor,
        }
        self.rejected_before = true;
    }

    fn decrease(&mut self, damping: &Damping, ratio: f64) {
        let factor = match damping.adaptation {
            Adaptation::GainRatio => (1.0 - (2.0 * ratio - 1.0).powi(3)).clamp(1.0 / 3.0, 2.0),
            Adaptation::Growing(factor) => 1.0 / factor,
            // A rejection before showed that less damping would be rejected again.
            Adaptation::Factor(_) if self.rejected_before => 1.0,
            Adaptation::Factor(factor) => 1.0 / factor,
        };
        self.value = (self.value * factor).max(damping.min);
        (self.growth, self.rejected_before) = (2.0, false);
    }
}
