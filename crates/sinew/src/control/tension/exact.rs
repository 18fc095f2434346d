//! Newton's method again, in twice the digits and held by an anchor: slower, and never without an answer.

use super::block::{Block, Limit};
use super::newton::{BALANCED, REACHED};
use super::pattern::places;
use super::rows::{Rows, Sparse};
use super::twofold::Twofold;
use alloc::vec::Vec;

/// What the steps work in.
#[derive(Debug, Clone)]
pub(super) struct Exact {
    /// Per muscle: limits, compliance, tension without them, tension, limit; limits when the stiffness was factored.
    lower: Vec<f64>,
    upper: Vec<f64>,
    compliance: Vec<f64>,
    wanted: Vec<Twofold>,
    tension: Vec<Twofold>,
    limit: Vec<Limit>,
    factored: Vec<Limit>,
    events: Vec<Event>,
    /// Per joint: torque, multiplier, its anchor, what is left of the torque now and before, what that is made of and its rounding, gradient, step.
    torque: Vec<Twofold>,
    lambda: Vec<Twofold>,
    anchor: Vec<Twofold>,
    residual: Vec<Twofold>,
    last: Vec<Twofold>,
    gradient: Vec<Twofold>,
    scale: Vec<f64>,
    rounding: Vec<f64>,
    doubt: Vec<f64>,
    step: Vec<Twofold>,
    factors: Vec<Twofold>,
}

/// Where a muscle leaves or reaches a limit along a step, and what the curvature gains there.
#[derive(Debug, Clone, Copy, Default)]
struct Event {
    at: Twofold,
    gain: Twofold,
}

/// Softness of the first anchor relative to the greatest stiffness of a joint: twice the digits hold a multiplier that
/// it lets grow.
const SOFTNESS: f64 = 1e-14;

/// Gradient relative to what it is made of that is rounding.
const ROUNDING: f64 = 1e-30;

/// Change of the residual, or residual, relative to what it is made of, that counts as none.
const STILL: f64 = 1e-16;

/// Wish to leave a limit, relative to the residual, that is no rounding.
const CERTAIN: f64 = 1e-13;

/// How much softer each anchor may be than the last, and the last than the first.
const SOFTER: f64 = 1e-2;
const SOFTEST: f64 = 1e-6;

/// Anchors at most. Each leaves but a small part of what the last left.
const ANCHORS: u32 = 100;

const ZERO: Twofold = Twofold::ZERO;

impl Exact {
    pub(super) fn new(muscles: usize, joints: usize) -> Self {
        let joints = places(joints);
        Self {
            lower: alloc::vec![0.0; muscles],
            upper: alloc::vec![0.0; muscles],
            compliance: alloc::vec![1.0; muscles],
            wanted: alloc::vec![ZERO; muscles],
            tension: alloc::vec![ZERO; muscles],
            limit: alloc::vec![Limit::Free; muscles],
            factored: alloc::vec![Limit::Free; muscles],
            events: Vec::with_capacity(2 * muscles),
            torque: alloc::vec![ZERO; joints],
            lambda: alloc::vec![ZERO; joints],
            anchor: alloc::vec![ZERO; joints],
            residual: alloc::vec![ZERO; joints],
            last: alloc::vec![ZERO; joints],
            gradient: alloc::vec![ZERO; joints],
            scale: alloc::vec![0.0; joints],
            rounding: alloc::vec![0.0; joints],
            doubt: alloc::vec![0.0; joints],
            step: alloc::vec![ZERO; joints],
            factors: alloc::vec![ZERO; joints * joints],
        }
    }

    /// Tensions of least cost for the closest torque, and their multipliers.
    ///
    /// ```text
    /// max_lambda  dual(lambda) - eps/2 |lambda - anchor|^2           anchor := lambda, and again
    /// ```
    ///
    /// The anchor makes the stiffness regular and the multipliers finite whatever the arms are and whether or not the
    /// torque can be reached. Its optimum is that of `cost + |tau - R^T F + eps anchor|^2 / 2 eps`, so that the torque
    /// goes to the closest. What is out of reach moves the multipliers by `residual / eps` each time, without end: it
    /// is taken from the torque, muscles that would still lower it stay where they are, and what is left can be reached.
    ///
    /// # Source
    /// `chiche2016` for the augmented Lagrangian of infeasible problems, of which this is the dual.
    pub(super) fn solve(
        &mut self,
        block: &Block<Sparse>,
        lambda: &mut [f64],
        tension: &mut [f64],
        steps: &mut u32,
    ) {
        let m = block.muscles();
        self.begin(block);
        self.settle(block, steps);
        self.narrow(block);
        self.compliance[..m].copy_from_slice(block.compliance);
        self.settle(block, steps);
        for (tension, exact) in tension[..m].iter_mut().zip(&self.tension) {
            *tension = exact.rounded();
        }
        for (lambda, exact) in lambda.iter_mut().zip(&self.lambda) {
            *lambda = exact.rounded();
        }
    }

    fn begin(&mut self, block: &Block<Sparse>) {
        let m = block.muscles();
        self.lower[..m].copy_from_slice(block.lower);
        self.upper[..m].copy_from_slice(block.upper);
        // Which torque is the closest has nothing to do with weights.
        self.compliance[..m].fill(1.0);
        for (torque, wanted) in self.torque.iter_mut().zip(block.torque) {
            *torque = Twofold::from(*wanted);
        }
    }

    /// The best multipliers, from none on, with one anchor after the other until the residual is gone or stands still.
    ///
    /// The less is left of the torque, the softer the anchor: multipliers then have less far to go.
    fn settle(&mut self, block: &Block<Sparse>, steps: &mut u32) {
        let n = block.joints();
        let stiffness = self.stiffest(block);
        let stiffness = if stiffness > 0.0 { stiffness } else { 1.0 };
        let mut left = 1.0;
        self.lambda[..n].fill(ZERO);
        self.last[..n].fill(ZERO);
        for _ in 0..ANCHORS {
            self.anchor[..n].copy_from_slice(&self.lambda[..n]);
            self.ascend(block, SOFTNESS * left * stiffness, steps);
            let error = |j: usize| self.residual[j].abs().rounded() / self.scale[j].max(f64::MIN_POSITIVE);
            let error = (0..n).map(error).fold(0.0, f64::max);
            if error <= BALANCED || self.stands_still(block) {
                break;
            }
            left = (SOFTER * left).max(error).max(SOFTEST).min(1.0);
            self.last[..n].copy_from_slice(&self.residual[..n]);
        }
    }

    /// Whether neither the residual moves nor a muscle will that it would draw from its limit.
    fn stands_still(&mut self, block: &Block<Sparse>) -> bool {
        let n = block.joints();
        for j in 0..n {
            self.doubt[j] = (self.residual[j] - self.last[j]).abs().rounded().max(self.rounding[j]);
            if self.doubt[j] > self.rounding[j].max(STILL * self.scale[j]) {
                return false;
            }
        }
        (0..block.muscles()).all(|i| match (self.limit[i], self.lower[i] < self.upper[i]) {
            (Limit::Lower, true) => self.wish(block, i) <= 0.0,
            (Limit::Upper, true) => self.wish(block, i) >= 0.0,
            _ => true,
        })
    }

    /// How fast the residual falls as the muscle's tension rises; zero where that is in doubt.
    fn wish(&self, block: &Block<Sparse>, muscle: usize) -> f64 {
        let wish = dot(block, muscle, &self.residual).rounded();
        let size = |j: usize| self.doubt[j] + CERTAIN * self.residual[j].rounded().abs();
        let doubt: f64 = block.rows.row(muscle).map(|(j, arm)| arm.abs() * size(j)).sum();
        if wish.abs() <= doubt { 0.0 } else { wish }
    }

    /// Largest stiffness that all muscles together give a joint.
    fn stiffest(&mut self, block: &Block<Sparse>) -> f64 {
        let diagonal = &mut self.scale[..block.joints()];
        diagonal.fill(0.0);
        for muscle in 0..block.muscles() {
            for (joint, arm) in block.rows.row(muscle) {
                diagonal[joint] += self.compliance[muscle] * arm * arm;
            }
        }
        diagonal.iter().copied().fold(0.0, f64::max)
    }

    /// Asks for the closest torque in place of the wanted one. Muscles that would still lower the residual stay where
    /// they are in every answer; the choice is among the others.
    fn narrow(&mut self, block: &Block<Sparse>) {
        let n = block.joints();
        if (0..n).all(|j| self.residual[j].abs().rounded() <= REACHED * self.scale[j]) {
            return;
        }
        for i in 0..block.muscles() {
            if self.limit[i] != Limit::Free && self.wish(block, i) != 0.0 {
                let at = if self.limit[i] == Limit::Lower { self.lower[i] } else { self.upper[i] };
                (self.lower[i], self.upper[i]) = (at, at);
            }
        }
        for (torque, residual) in self.torque[..n].iter_mut().zip(&self.residual) {
            *torque -= *residual;
        }
    }

    /// The best multipliers for this anchor.
    fn ascend(&mut self, block: &Block<Sparse>, softness: f64, steps: &mut u32) {
        let (m, n) = (block.muscles(), block.joints());
        let most = 20 + 8 * (m + n);
        self.evaluate(block, softness);
        let mut known = false;
        for _ in 0..most {
            if (0..n).all(|j| self.gradient[j].abs().rounded() <= self.rounding[j]) {
                return;
            }
            *steps += 1;
            if !known || self.limit[..m] != self.factored[..m] {
                self.factored[..m].copy_from_slice(&self.limit[..m]);
                self.factor(block, softness);
                known = true;
            }
            self.step[..n].copy_from_slice(&self.gradient[..n]);
            self.back_substitute(n);
            let length = self.length(block, softness);
            for (lambda, step) in self.lambda[..n].iter_mut().zip(&self.step) {
                *lambda += length * *step;
            }
            self.evaluate(block, softness);
        }
    }

    /// Tensions, residual and gradient at `lambda`.
    fn evaluate(&mut self, block: &Block<Sparse>, softness: f64) {
        let n = block.joints();
        for j in 0..n {
            self.residual[j] = self.torque[j];
            self.scale[j] = self.torque[j].rounded().abs();
            self.rounding[j] = ROUNDING * self.scale[j];
        }
        for i in 0..block.muscles() {
            let (lower, upper) = (self.lower[i], self.upper[i]);
            let wanted = Twofold::from(block.reference[i]) + dot(block, i, &self.lambda) * self.compliance[i];
            self.limit[i] = limit(wanted, lower, upper);
            self.wanted[i] = wanted;
            self.tension[i] = match self.limit[i] {
                Limit::Lower => Twofold::from(lower),
                Limit::Free => wanted,
                Limit::Upper => Twofold::from(upper),
            };
            // A tension between the limits has the rounding of all that it is made of.
            let size = match self.limit[i] {
                Limit::Free => block.reference[i].abs() + self.compliance[i] * self.size(block, i),
                _ => self.tension[i].rounded().abs(),
            };
            for (joint, arm) in block.rows.row(i) {
                self.residual[joint] -= self.tension[i] * arm;
                self.scale[joint] += (self.tension[i].rounded() * arm).abs();
                self.rounding[joint] += ROUNDING * arm.abs() * size;
            }
        }
        for j in 0..n {
            let pull = (self.lambda[j] - self.anchor[j]) * softness;
            self.gradient[j] = self.residual[j] - pull;
        }
    }

    /// `H + eps = U^T D U`, rows of `U` right of the diagonal, `D` on it.
    fn factor(&mut self, block: &Block<Sparse>, softness: f64) {
        let n = block.joints();
        let h = &mut self.factors[..n * n];
        h.fill(ZERO);
        for i in (0..block.muscles()).filter(|i| self.limit[*i] == Limit::Free) {
            for (joint, arm) in block.rows.row(i) {
                let f = Twofold::from(arm) * self.compliance[i];
                for (other, second) in block.rows.row(i).filter(|(other, _)| *other >= joint) {
                    h[joint * n + other] += f * second;
                }
            }
        }
        for k in 0..n {
            h[k * n + k] += Twofold::from(softness);
        }
        for k in 0..n {
            // Rounding may take what the anchor gave.
            if h[k * n + k].rounded() < 0.5 * softness {
                h[k * n + k] = Twofold::from(softness);
            }
            let pivot = h[k * n + k];
            let (above, below) = h.split_at_mut((k + 1) * n);
            let row = &mut above[k * n..];
            for (i, lower) in (k + 1..n).zip(below.chunks_exact_mut(n)) {
                if row[i].rounded() != 0.0 {
                    let f = row[i] / pivot;
                    for j in i..n {
                        lower[j] -= f * row[j];
                    }
                }
            }
            for entry in &mut row[k + 1..n] {
                *entry = *entry / pivot;
            }
        }
    }

    fn back_substitute(&mut self, n: usize) {
        let (h, x) = (&self.factors[..n * n], &mut self.step[..n]);
        for k in 0..n {
            for j in k + 1..n {
                x[j] = x[j] - h[k * n + j] * x[k];
            }
        }
        for k in (0..n).rev() {
            let mut sum = x[k] / h[k * n + k];
            for j in k + 1..n {
                sum -= h[k * n + j] * x[j];
            }
            x[k] = sum;
        }
    }

    /// The length of the step where the slope vanishes: it falls, piecewise linear, from one event to the next.
    fn length(&mut self, block: &Block<Sparse>, softness: f64) -> Twofold {
        let n = block.joints();
        let (mut slope, mut curvature) = (ZERO, ZERO);
        for j in 0..n {
            slope += self.gradient[j] * self.step[j];
            curvature += self.step[j] * self.step[j] * softness;
        }
        self.events.clear();
        for i in 0..block.muscles() {
            let pull = dot(block, i, &self.step);
            let rate = pull * self.compliance[i];
            let (lower, upper) = (self.lower[i], self.upper[i]);
            if rate.rounded() == 0.0 || lower >= upper {
                continue;
            }
            let (near, far) = if rate.rounded() > 0.0 { (lower, upper) } else { (upper, lower) };
            let enter = (Twofold::from(near) - self.wanted[i]) / rate;
            let leave = (Twofold::from(far) - self.wanted[i]) / rate;
            let gain = pull * rate;
            if leave.rounded() > 0.0 {
                self.events.push(Event { at: leave, gain: -gain });
                if enter.rounded() > 0.0 {
                    self.events.push(Event { at: enter, gain });
                } else {
                    curvature += gain;
                }
            }
        }
        self.events.sort_unstable_by(|a, b| a.at.rounded().total_cmp(&b.at.rounded()));
        let mut at = ZERO;
        for event in &self.events {
            let fall = curvature * (event.at - at);
            if fall.rounded() >= slope.rounded() {
                break;
            }
            slope -= fall;
            at = event.at;
            curvature += event.gain;
        }
        at + slope / curvature
    }
}

impl Exact {
    /// Sum of the magnitudes of what a muscle feels of the multipliers.
    fn size(&self, block: &Block<Sparse>, muscle: usize) -> f64 {
        block.rows.row(muscle).map(|(joint, arm)| (self.lambda[joint].rounded() * arm).abs()).sum()
    }
}

/// What a muscle feels of one number per joint.
fn dot(block: &Block<Sparse>, muscle: usize, x: &[Twofold]) -> Twofold {
    block.rows.row(muscle).fold(ZERO, |sum, (joint, arm)| sum + x[joint] * arm)
}

fn limit(wanted: Twofold, lower: f64, upper: f64) -> Limit {
    if wanted <= Twofold::from(lower) {
        Limit::Lower
    } else if wanted >= Twofold::from(upper) {
        Limit::Upper
    } else {
        Limit::Free
    }
}
