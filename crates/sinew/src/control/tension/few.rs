//! Newton's method for few joints, eight at most: one pass over the muscles does all there is to do at a place, its sums
//! in registers.

use super::block::{Block, Limit};
use super::factor::Factors;
use super::line_search::{OUTSIDE, search};
use super::newton::{BALANCED, FAR, NOISE, Outcome, Work, along, error, least_pivot, rays};
use super::rows::{Dense, LANES, Rows, dot_few};

/// What one pass over the muscles finds.
#[derive(Clone, Copy)]
struct Sums<const N: usize> {
    /// What is left of the torque, and what it is made of.
    residual: [f64; N],
    scale: [f64; N],
}

/// A symmetric matrix, upper triangle.
type Square<const N: usize> = [[f64; N]; N];

impl<const N: usize> Sums<N> {
    /// No muscle pulls.
    #[inline(always)]
    fn new(torque: &[f64]) -> Self {
        let mut residual = [0.0; N];
        residual.copy_from_slice(&torque[..N]);
        Self { residual, scale: residual.map(f64::abs) }
    }

    #[inline(always)]
    fn pull(&mut self, arms: &[f64; N], tension: f64) {
        for ((residual, scale), arm) in self.residual.iter_mut().zip(&mut self.scale).zip(arms) {
            let torque = arm * tension;
            *residual -= torque;
            *scale += torque.abs();
        }
    }

    #[inline(always)]
    fn error(&self) -> f64 {
        error(&self.residual, &self.scale)
    }
}

/// Adds `f r^T r`.
#[inline(always)]
fn stiffen<const N: usize>(stiffness: &mut Square<N>, arms: &[f64; N], f: f64) {
    for i in 0..N {
        let f = f * arms[i];
        // Whole rows where there are lanes for them.
        for j in if N < LANES { i..N } else { 0..N } {
            stiffness[i][j] += f * arms[j];
        }
    }
}

impl Work {
    /// [`Work::ascend`] for few joints.
    #[inline(always)]
    pub(super) fn ascend_few<const N: usize>(
        &mut self,
        block: &Block<Dense<N>>,
        given: &mut [f64],
        most: u32,
        steps: &mut u32,
    ) -> Outcome {
        let mut lambda = [0.0; N];
        lambda.copy_from_slice(&given[..N]);
        let floor = least_pivots(block);
        self.floor[..N].copy_from_slice(&floor);
        if lambda.iter().all(|lambda| *lambda == 0.0) {
            lambda = start(block, &floor);
            *steps += 1;
        }
        let mut sums = self.sweep(block, &lambda);
        let (mut settled, mut factors, mut last) = (false, None, f64::INFINITY);
        let mut outcome = None;
        for _ in 0..most {
            let error = sums.error();
            if error <= BALANCED {
                outcome = Some(Outcome::Reached);
                break;
            }
            // The last step should have ended it, and the one before as well.
            if settled && error > 0.5 * last {
                break;
            }
            let known = factors.unwrap_or_else(|| Factors::new(self.stiffness(block), &floor));
            *steps += 1;
            let step = known.solve(sums.residual);
            let ahead;
            (ahead, settled) = self.sweep_ahead(block, &step);
            let length = if settled { 1.0 } else { self.length_few(block, &sums, &ahead, &step) };
            if length > FAR && error <= NOISE {
                outcome = Some(Outcome::Reached);
                break;
            }
            if length == f64::INFINITY {
                break;
            }
            for (lambda, step) in lambda.iter_mut().zip(&step) {
                *lambda += length * step;
            }
            last = error;
            if settled {
                core::mem::swap(&mut self.tension, &mut self.tension_ahead);
                core::mem::swap(&mut self.wanted, &mut self.wanted_ahead);
                sums = ahead;
                factors = Some(known);
            } else {
                sums = self.sweep(block, &lambda);
                factors = None;
            }
        }
        given[..N].copy_from_slice(&lambda);
        self.residual[..N].copy_from_slice(&sums.residual);
        self.scale[..N].copy_from_slice(&sums.scale);
        // Tensions made of multipliers cost least for the torque they give: it may be the wanted one.
        outcome.unwrap_or(if sums.error() <= NOISE { Outcome::Reached } else { Outcome::Unreached })
    }

    /// Tensions, limits, and what they leave of the torque.
    #[inline(always)]
    fn sweep<const N: usize>(&mut self, block: &Block<Dense<N>>, lambda: &[f64; N]) -> Sums<N> {
        let m = block.muscles();
        let (wanted, tension, limit) = (&mut self.wanted[..m], &mut self.tension[..m], &mut self.limit[..m]);
        let (lower, upper) = (&block.lower[..m], &block.upper[..m]);
        let (reference, compliance, arms) =
            (&block.reference[..m], &block.compliance[..m], &block.rows.arms()[..m]);
        let mut sums = Sums::new(block.torque);
        for i in 0..m {
            let pull = dot_few(&arms[i], lambda);
            wanted[i] = reference[i] + compliance[i] * pull;
            tension[i] = Limit::clip(wanted[i], lower[i], upper[i]);
            limit[i] = Limit::of(wanted[i], lower[i], upper[i]);
            sums.pull(&arms[i], tension[i]);
        }
        sums
    }

    /// What the free muscles give the joints.
    #[inline(always)]
    fn stiffness<const N: usize>(&mut self, block: &Block<Dense<N>>) -> Square<N> {
        let m = block.muscles();
        let (limit, free) = (&self.limit[..m], &mut self.free[..m]);
        let (compliance, arms) = (&block.compliance[..m], &block.rows.arms()[..m]);
        let mut stiffness = [[0.0; N]; N];
        // A muscle is quicker added to few joints than asked for.
        if N < LANES {
            for i in 0..m {
                stiffen(&mut stiffness, &arms[i], if limit[i] == Limit::Free { compliance[i] } else { 0.0 });
            }
            return stiffness;
        }
        let mut count = 0;
        for (i, limit) in limit.iter().enumerate() {
            free[count] = i;
            count += usize::from(*limit == Limit::Free);
        }
        for &i in &free[..count] {
            stiffen(&mut stiffness, &arms[i], compliance[i]);
        }
        stiffness
    }

    /// What the full step does to every muscle, and where it leads if no muscle meets or leaves a limit.
    #[inline(always)]
    fn sweep_ahead<const N: usize>(&mut self, block: &Block<Dense<N>>, step: &[f64; N]) -> (Sums<N>, bool) {
        let m = block.muscles();
        let (pull, rate) = (&mut self.pull[..m], &mut self.rate[..m]);
        let (wanted, limit) = (&self.wanted[..m], &self.limit[..m]);
        let (wanted_ahead, tension_ahead) = (&mut self.wanted_ahead[..m], &mut self.tension_ahead[..m]);
        let (lower, upper) = (&block.lower[..m], &block.upper[..m]);
        let (compliance, arms) = (&block.compliance[..m], &block.rows.arms()[..m]);
        let (mut same, mut sums) = (true, Sums::new(block.torque));
        for i in 0..m {
            pull[i] = dot_few(&arms[i], step);
            rate[i] = compliance[i] * pull[i];
            wanted_ahead[i] = wanted[i] + rate[i];
            tension_ahead[i] = Limit::clip(wanted_ahead[i], lower[i], upper[i]);
            same &= Limit::of(wanted_ahead[i], lower[i], upper[i]) == limit[i];
            sums.pull(&arms[i], tension_ahead[i]);
        }
        (sums, same)
    }

    /// [`Work::length`], given where the full step leads.
    #[inline(always)]
    fn length_few<const N: usize>(
        &mut self,
        block: &Block<Dense<N>>,
        here: &Sums<N>,
        ahead: &Sums<N>,
        step: &[f64; N],
    ) -> f64 {
        let torque = along(&block.torque[..N], step);
        let slope = along(&ahead.residual, step);
        // A slope of rounding counts as none: the last event may lie before.
        if slope > OUTSIDE * along(&ahead.scale, &step.map(f64::abs)) {
            let rays = rays(block, &self.wanted_ahead, &self.rate, &self.pull);
            return 1.0 + search(rays, slope, torque, 0.0, f64::INFINITY, &mut self.events);
        }
        let rays = rays(block, &self.wanted, &self.rate, &self.pull);
        search(rays, along(&here.residual, step), torque, 0.0, 1.0, &mut self.events)
    }
}

/// The smallest pivots.
#[inline(always)]
fn least_pivots<const N: usize>(block: &Block<Dense<N>>) -> [f64; N] {
    let mut whole = [0.0; N];
    block.rows.stiffen_each(block.compliance, &mut whole);
    whole.map(least_pivot)
}

/// The multipliers that muscles without limits would have.
#[inline(always)]
fn start<const N: usize>(block: &Block<Dense<N>>, floor: &[f64; N]) -> [f64; N] {
    let (mut sums, mut stiffness) = (Sums::new(block.torque), [[0.0; N]; N]);
    let muscles = block.rows.arms().iter().zip(block.reference).zip(block.compliance);
    for ((arms, reference), compliance) in muscles {
        sums.pull(arms, *reference);
        stiffen(&mut stiffness, arms, *compliance);
    }
    Factors::new(stiffness, floor).solve(sums.residual)
}
