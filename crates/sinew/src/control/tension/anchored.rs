//! Newton's method again, in twice the digits and held by an anchor.

use super::block::{Block, Limit};
use super::pattern::places;
use super::rows::{Rows, Sparse};
use super::twofold::Twofold;
use alloc::vec::Vec;

/// What the steps work in.
#[derive(Debug, Clone)]
pub(super) struct Anchored {
    /// Per muscle: limits, compliance, tension without limits, tension, the limit that holds it, and the one that did
    /// when the stiffness was factored.
    pub(super) lower: Vec<f64>,
    pub(super) upper: Vec<f64>,
    pub(super) compliance: Vec<f64>,
    wanted: Vec<Twofold>,
    pub(super) tension: Vec<Twofold>,
    pub(super) limit: Vec<Limit>,
    factored: Vec<Limit>,
    events: Vec<Event>,
    /// Per joint: torque, multiplier and its anchor, what is left of the torque, gradient and step; what
    /// the residual is made of, and rounding of the gradient.
    pub(super) torque: Vec<Twofold>,
    pub(super) lambda: Vec<Twofold>,
    pub(super) anchor: Vec<Twofold>,
    pub(super) residual: Vec<Twofold>,
    gradient: Vec<Twofold>,
    pub(super) scale: Vec<f64>,
    pub(super) rounding: Vec<f64>,
    step: Vec<Twofold>,
    factors: Vec<Twofold>,
}

/// Where a muscle leaves or reaches a limit along a step, and what the curvature gains there.
#[derive(Debug, Clone, Copy, Default)]
struct Event {
    at: Twofold,
    gain: Twofold,
}

/// Gradient relative to what it is made of that is rounding.
const ROUNDING: f64 = 1e-30;

const ZERO: Twofold = Twofold::ZERO;

impl Anchored {
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
            gradient: alloc::vec![ZERO; joints],
            scale: alloc::vec![0.0; joints],
            rounding: alloc::vec![0.0; joints],
            step: alloc::vec![ZERO; joints],
            factors: alloc::vec![ZERO; joints * joints],
        }
    }

    /// Largest stiffness that all muscles together give a joint.
    pub(super) fn stiffest(&mut self, block: &Block<Sparse>) -> f64 {
        let diagonal = &mut self.scale[..block.joints()];
        diagonal.fill(0.0);
        for muscle in 0..block.muscles() {
            for (joint, arm) in block.rows.row(muscle) {
                diagonal[joint] += self.compliance[muscle] * arm * arm;
            }
        }
        diagonal.iter().copied().fold(0.0, f64::max)
    }

    /// The best multipliers for this anchor.
    pub(super) fn ascend(&mut self, block: &Block<Sparse>, softness: f64, steps: &mut u32) {
        let (m, n) = (block.muscles(), block.joints());
        // Each step settles at least one muscle.
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
                x[j] -= h[k * n + j] * x[k];
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

impl Anchored {
    /// Sum of the magnitudes of what a muscle feels of the multipliers.
    fn size(&self, block: &Block<Sparse>, muscle: usize) -> f64 {
        block.rows.row(muscle).map(|(joint, arm)| (self.lambda[joint].rounded() * arm).abs()).sum()
    }
}

/// What a muscle feels of one number per joint.
pub(super) fn dot(block: &Block<Sparse>, muscle: usize, x: &[Twofold]) -> Twofold {
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
