//! Newton's method in the few unknowns of the dual: one multiplier per joint instead of one tension per muscle.

use super::block::{Block, Limit};
use super::closest::Closest;
use super::factor::{factor, solve};
use super::line_search::{Event, Ray, room, search};
use super::pattern::places;
use super::rows::{LANES, Rows};
use alloc::vec::Vec;

/// What the steps work in.
#[derive(Debug, Clone)]
pub(super) struct Work {
    /// Per muscle: tension, tension without limits, its change along the step, what the step does to the muscle.
    pub(super) tension: Vec<f64>,
    pub(super) wanted: Vec<f64>,
    pub(super) rate: Vec<f64>,
    pub(super) pull: Vec<f64>,
    /// The first two after the step.
    pub(super) tension_ahead: Vec<f64>,
    pub(super) wanted_ahead: Vec<f64>,
    pub(super) limit: Vec<Limit>,
    /// Per joint: what is left of the torque, what it is made of, the step, the smallest pivot.
    pub(super) residual: Vec<f64>,
    pub(super) scale: Vec<f64>,
    pub(super) step: Vec<f64>,
    pub(super) floor: Vec<f64>,
    /// Stiffness that the `counted` muscles give the joints, and its factors.
    stiffness: Vec<f64>,
    factors: Vec<f64>,
    counted: Vec<bool>,
    /// Muscles to add to the stiffness, with their compliance; those to take have it negative.
    parts: Vec<(usize, f64)>,
    pub(super) events: Vec<Event>,
    /// Room for the places of the free muscles.
    pub(super) free: Vec<usize>,
    /// What every joint yields to a multiplier of its own accord: none but where the torque is out of reach.
    pub(super) softness: f64,
    /// Greatest stiffness of a joint, every muscle free.
    pub(super) stiffest: f64,
    pub(super) closest: Closest,
}

/// How the method ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Outcome {
    /// The torque is reached, at least cost.
    Reached,
    /// No tensions within the limits give the torque, or rounding hid them.
    Unreached,
}

/// What is known of the stiffness.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stiffness {
    None,
    Exact,
    /// Muscles were added and taken: it has their rounding.
    Updated,
}

/// Pivots relative to the stiffness of all muscles together: below it, the free muscles do not move the joint.
const LEAST_PIVOT: f64 = 1e-13;

/// Residual relative to what it is made of: a few units in the last place of a sum.
pub(super) const BALANCED: f64 = 2e-15;

/// Along a null space, a residual of rounding leads far away: step length and residual that tell it.
pub(super) const FAR: f64 = 2.0;
pub(super) const NOISE: f64 = 1e-13;

/// Residual, relative to what it is made of, up to which a torque counts as reached.
pub(super) const REACHED: f64 = 1e-9;

/// Energy of the multipliers one by one, relative to that of the tensions, from which on they cancel too much.
const SHARP: f64 = 1e7 * LEAST_PIVOT * LEAST_PIVOT;

impl Work {
    pub(super) fn new(muscles: usize, joints: usize) -> Self {
        let joints_given = joints;
        let joints = places(joints);
        Self {
            tension: alloc::vec![0.0; muscles],
            wanted: alloc::vec![0.0; muscles],
            rate: alloc::vec![0.0; muscles],
            pull: alloc::vec![0.0; muscles],
            tension_ahead: alloc::vec![0.0; muscles],
            wanted_ahead: alloc::vec![0.0; muscles],
            limit: alloc::vec![Limit::Free; muscles],
            residual: alloc::vec![0.0; joints],
            scale: alloc::vec![0.0; joints],
            step: alloc::vec![0.0; joints],
            floor: alloc::vec![0.0; joints],
            stiffness: alloc::vec![0.0; joints * joints],
            factors: alloc::vec![0.0; joints * joints],
            counted: alloc::vec![false; muscles],
            parts: Vec::with_capacity(muscles),
            events: room(muscles),
            free: alloc::vec![0; muscles],
            softness: 0.0,
            stiffest: 0.0,
            closest: Closest::new(muscles, joints_given),
        }
    }

    /// Whether the multipliers are small enough for what is made of them: where joints are hard to tell apart, large
    /// ones cancel, and leave rounding in the tensions.
    #[inline(always)]
    pub(super) fn is_sharp(&self, lambda: &[f64]) -> bool {
        let energy: f64 = self.floor.iter().zip(lambda).map(|(floor, lambda)| floor * lambda * lambda).sum();
        let mut joints = self.floor.iter().zip(&self.scale[..lambda.len()]);
        joints.all(|(floor, scale)| *scale == 0.0 || floor * energy <= SHARP * scale * scale)
    }

    /// Maximises the dual from `lambda` on; adds the number of steps to `steps`.
    ///
    /// ```text
    /// F = clip(F_ref + W^-1 R lambda, F_min, F_max)          g = tau - R^T F          (gradient of the dual)
    /// H = R_free^T W^-1 R_free                               lambda := lambda + s H^-1 g
    /// ```
    ///
    /// The dual is concave and piecewise quadratic. `s` is its exact maximum along the step (1 where no muscle meets or
    /// leaves a limit), so every step ascends, a piece is left for good, and a step within a piece ends the search:
    /// what follows it only removes rounding. `H` has full rank only if the free muscles move every joint; elsewhere
    /// its factors send the step along the null space until a muscle comes free, or show that none ever does.
    #[inline(always)]
    pub(super) fn ascend<R: Rows>(
        &mut self,
        block: &Block<R>,
        lambda: &mut [f64],
        most: u32,
        steps: &mut u32,
    ) -> Outcome {
        self.set_floor(block);
        let n = block.joints();
        let mut stiffness = Stiffness::None;
        if n > 0 && lambda.iter().all(|lambda| *lambda == 0.0) {
            self.start(block, lambda);
            *steps += 1;
            stiffness = Stiffness::Exact;
        }
        self.evaluate(block, lambda);
        self.measure(block);
        let (mut settled, mut last) = (false, f64::INFINITY);
        for _ in 0..most {
            let error = self.error(n);
            if error <= BALANCED {
                return Outcome::Reached;
            }
            // The last step should have ended it, and the one before as well.
            if settled && error > 0.5 * last {
                break;
            }
            stiffness = self.factor(block, stiffness, settled);
            *steps += 1;
            self.newton_step(n);
            settled = self.look_ahead(block);
            let length = if settled { 1.0 } else { self.length(block) };
            if length > FAR && error <= NOISE {
                return Outcome::Reached;
            }
            if length == f64::INFINITY {
                break;
            }
            for (lambda, step) in lambda.iter_mut().zip(&self.step) {
                *lambda += length * step;
            }
            last = error;
            if settled {
                self.move_free(block);
            } else {
                self.evaluate(block, lambda);
            }
            // What the residual is made of changes little, and matters where the residual is small.
            if settled {
                self.measure(block);
                continue;
            }
            block.residual(&self.tension, &mut self.residual);
            if self.error(n) <= REACHED {
                self.measure(block);
            }
        }
        // Tensions made of multipliers cost least for the torque they give: it may be the wanted one.
        self.measure(block);
        if self.error(n) <= NOISE { Outcome::Reached } else { Outcome::Unreached }
    }

    /// The step that makes the residual vanish if no muscle meets or leaves a limit.
    #[inline(always)]
    pub(super) fn newton_step(&mut self, joints: usize) {
        self.step[..joints].copy_from_slice(&self.residual[..joints]);
        solve(&self.factors[..joints * joints], &mut self.step[..joints]);
    }

    /// The multipliers that muscles without limits would have.
    #[inline(always)]
    fn start<R: Rows>(&mut self, block: &Block<R>, lambda: &mut [f64]) {
        let (m, n) = (block.muscles(), block.joints());
        self.counted[..m].fill(true);
        self.parts.clear();
        self.parts.extend(block.compliance.iter().copied().enumerate());
        self.refactor(block, true);
        block.residual(block.reference, &mut self.residual);
        lambda.copy_from_slice(&self.residual[..n]);
        solve(&self.factors[..n * n], lambda);
    }

    /// Adds the parts to the stiffness, or to nothing where it is `new`, and factors it.
    #[inline(always)]
    fn refactor<R: Rows>(&mut self, block: &Block<R>, new: bool) {
        let n = block.joints();
        let (stiffness, factors) = (&mut self.stiffness[..n * n], &mut self.factors[..n * n]);
        if new {
            stiffness.fill(0.0);
        }
        block.rows.stiffen(&self.parts, stiffness);
        factors.copy_from_slice(stiffness);
        soften(factors, n, self.softness);
        factor(factors, &self.floor[..n]);
    }

    /// Smallest pivots: a fraction of the stiffness with every muscle free.
    #[inline(always)]
    pub(super) fn set_floor<R: Rows>(&mut self, block: &Block<R>) {
        let floor = &mut self.floor[..block.joints()];
        floor.fill(0.0);
        block.rows.stiffen_each(block.compliance, floor);
        self.stiffest = floor.iter().copied().fold(0.0, f64::max);
        for floor in floor {
            *floor = least_pivot(*floor);
        }
    }

    /// Tensions and limits at `lambda`.
    #[inline(always)]
    pub(super) fn evaluate<R: Rows>(&mut self, block: &Block<R>, lambda: &[f64]) {
        let m = block.muscles();
        let (wanted, tension, limit) = (&mut self.wanted[..m], &mut self.tension[..m], &mut self.limit[..m]);
        let (lower, upper) = (&block.lower[..m], &block.upper[..m]);
        let (reference, compliance) = (&block.reference[..m], &block.compliance[..m]);
        for i in 0..m {
            wanted[i] = reference[i] + compliance[i] * block.rows.dot(i, lambda);
            tension[i] = wanted[i].max(lower[i]).min(upper[i]);
            limit[i] = Limit::of(wanted[i], lower[i], upper[i]);
        }
    }

    /// The same after a full step that changes no limit, without another product: what a large multiplier rounds
    /// away stays in the tensions.
    #[inline(always)]
    fn move_free<R: Rows>(&mut self, block: &Block<R>) {
        let m = block.muscles();
        let (wanted, tension, rate) = (&mut self.wanted[..m], &mut self.tension[..m], &self.rate[..m]);
        let (lower, upper) = (&block.lower[..m], &block.upper[..m]);
        for i in 0..m {
            wanted[i] += rate[i];
            tension[i] = wanted[i].max(lower[i]).min(upper[i]);
        }
    }

    /// What the tensions leave of the torque.
    #[inline(always)]
    pub(super) fn measure<R: Rows>(&mut self, block: &Block<R>) {
        block.measure(&self.tension, &mut self.residual, &mut self.scale);
    }

    /// Largest residual relative to what it is made of.
    #[inline(always)]
    pub(super) fn error(&self, joints: usize) -> f64 {
        error(&self.residual[..joints], &self.scale[..joints])
    }

    /// Factors of the stiffness that the free muscles give the joints; those that are `known` are brought up to date.
    #[inline(always)]
    pub(super) fn factor<R: Rows>(&mut self, block: &Block<R>, known: Stiffness, settled: bool) -> Stiffness {
        let (mut changed, mut free_count) = (0, 0);
        self.parts.clear();
        let states = self.limit.iter().zip(&mut self.counted).zip(block.compliance).enumerate();
        for (i, ((limit, counted), compliance)) in states {
            let free = *limit == Limit::Free;
            if R::LARGE && free != *counted {
                self.parts.push((i, if free { *compliance } else { -compliance }));
            }
            free_count += usize::from(free);
            changed += usize::from(free != *counted);
            *counted = free;
        }
        // A step that settled and did not reach the torque suffers from the rounding of what came and went.
        let sound = known == Stiffness::Exact || (known == Stiffness::Updated && !settled);
        if sound && changed == 0 {
            return known;
        }
        if !R::LARGE {
            self.factor_few(block);
            return Stiffness::Exact;
        }
        let update = sound && 2 * changed <= free_count;
        if !update {
            self.parts.clear();
            let free = self.counted.iter().zip(block.compliance).enumerate().filter(|(_, (free, _))| **free);
            self.parts.extend(free.map(|(i, (_, compliance))| (i, *compliance)));
        }
        self.refactor(block, !update);
        if update { Stiffness::Updated } else { Stiffness::Exact }
    }

    /// The same for few joints: a muscle is quicker added than asked for.
    #[inline(always)]
    fn factor_few<R: Rows>(&mut self, block: &Block<R>) {
        let n = block.joints();
        let factors = &mut self.factors[..n * n];
        factors.fill(0.0);
        let counted = block.compliance.iter().zip(&self.counted);
        block.rows.stiffen_all(counted.map(|(f, free)| if *free { *f } else { 0.0 }), factors);
        soften(factors, n, self.softness);
        factor(factors, &self.floor[..n]);
    }

    /// What the full step does to every muscle; whether none meets or leaves a limit.
    #[inline(always)]
    pub(super) fn look_ahead<R: Rows>(&mut self, block: &Block<R>) -> bool {
        let m = block.muscles();
        let (pull, rate) = (&mut self.pull[..m], &mut self.rate[..m]);
        let (wanted, limit) = (&self.wanted[..m], &self.limit[..m]);
        let (lower, upper, compliance) = (&block.lower[..m], &block.upper[..m], &block.compliance[..m]);
        let mut same = true;
        for i in 0..m {
            pull[i] = block.rows.dot(i, &self.step);
            rate[i] = compliance[i] * pull[i];
            same &= Limit::of(wanted[i] + rate[i], lower[i], upper[i]) == limit[i];
        }
        same
    }

    /// Length of the step that maximises the dual; infinite if it rises for ever.
    #[inline(always)]
    pub(super) fn length<R: Rows>(&mut self, block: &Block<R>) -> f64 {
        let n = block.joints();
        let slope = along(&self.residual[..n], &self.step);
        let softness = self.softness * along(&self.step[..n], &self.step);
        let torque = along(&block.torque[..n], &self.step);
        let rays = rays(block, &self.wanted, &self.rate, &self.pull);
        search(rays, slope, torque, softness, f64::INFINITY, &mut self.events)
    }
}

/// How the muscles meet the step.
#[inline(always)]
pub(super) fn rays<'a, R: Rows>(
    block: &Block<'a, R>,
    from: &'a [f64],
    rate: &'a [f64],
    pull: &'a [f64],
) -> impl Iterator<Item = Ray> {
    let m = block.muscles();
    let (lower, upper) = (&block.lower[..m], &block.upper[..m]);
    let (from, rate, pull) = (&from[..m], &rate[..m], &pull[..m]);
    (0..m).map(move |i| Ray { from: from[i], lower: lower[i], upper: upper[i], rate: rate[i], pull: pull[i] })
}

/// How fast something of the joints changes along the step.
#[inline(always)]
pub(super) fn along(x: &[f64], step: &[f64]) -> f64 {
    x.iter().zip(step).map(|(x, step)| x * step).sum()
}

/// Adds to the diagonal.
#[inline(always)]
fn soften(stiffness: &mut [f64], joints: usize, softness: f64) {
    stiffness.iter_mut().step_by(joints + 1).for_each(|pivot| *pivot += softness);
}

/// Smallest pivot of a joint to which all muscles together give so much stiffness.
#[inline(always)]
pub(super) fn least_pivot(stiffness: f64) -> f64 {
    // A joint that no muscle crosses, or whose arms vanished in this pose, has none.
    if stiffness > 0.0 { LEAST_PIVOT * stiffness } else { 1.0 }
}

/// Largest residual relative to what it is made of.
#[inline(always)]
pub(super) fn error(residual: &[f64], scale: &[f64]) -> f64 {
    // Where nothing pulls, nothing is left: 0 / 0 is no larger than any.
    let mut most = [0.0; LANES];
    let ((residuals, more), (scales, rest)) = (residual.as_chunks::<LANES>(), scale.as_chunks::<LANES>());
    for (residual, scale) in residuals.iter().zip(scales) {
        for k in 0..LANES {
            let ratio = residual[k].abs() / scale[k];
            most[k] = if ratio > most[k] { ratio } else { most[k] };
        }
    }
    for (residual, scale) in more.iter().zip(rest) {
        let ratio = residual.abs() / scale;
        most[0] = if ratio > most[0] { ratio } else { most[0] };
    }
    most.into_iter().fold(0.0, |a, b| if b > a { b } else { a })
}
