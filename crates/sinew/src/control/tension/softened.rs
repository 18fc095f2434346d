//! Newton's method where the torque is out of reach: held by a little softness, it finds the limits that hold there.

use super::block::Block;
use super::closest::Verdict;
use super::newton::{Outcome, Stiffness, Work};
use super::rows::Rows;

/// Softness relative to the greatest stiffness of a joint: so small that the same limits hold as without, as a rule,
/// and so large that rounding does not hide them. Tried by turns.
const SOFTNESS: [f64; 2] = [1e-7, 1e-10];

/// Multipliers of the last torque out of reach, where the next search starts.
#[derive(Debug)]
pub(super) struct Soft<'a> {
    pub(super) lambda: &'a mut [f64],
    /// Whether they are from the last solution.
    pub(super) known: &'a mut bool,
}

impl Work {
    /// Tensions for the closest torque, those of least cost, if they can be found without more digits.
    ///
    /// ```text
    /// max_lambda  dual(lambda) - eps/2 |lambda|^2
    /// ```
    ///
    /// Its optimum is that of `cost + |tau - R^T F|^2 / 2 eps`. Only the limits that hold there are believed;
    /// [`Closest`](super::closest::Closest) proves them and finds the tensions.
    #[inline(always)]
    pub(super) fn approach<R: Rows>(
        &mut self,
        block: &Block<R>,
        lambda: &mut [f64],
        soft: &mut Soft,
        steps: &mut u32,
    ) -> Outcome {
        let (m, n) = (block.muscles(), block.joints());
        let most = 10 + u32::try_from(m + n).unwrap_or(u32::MAX / 2);
        self.set_floor(block);
        for softness in SOFTNESS {
            self.softness = softness * self.stiffest;
            if !self.ascend_softened(block, soft.lambda, most, steps) {
                break;
            }
            let verdict = self.closest.judge(block, &self.limit[..m]);
            let found = match verdict {
                Verdict::Unique => self.closest.solve(block, lambda, &mut self.tension),
                Verdict::Choice => {
                    // What the residual did not pull out of all bounds.
                    for (k, lambda) in lambda.iter_mut().enumerate() {
                        *lambda = soft.lambda[k] - self.closest.residual[k] / self.softness;
                    }
                    self.choose(block, lambda, most, steps)
                }
                Verdict::Doubtful => false,
            };
            if found {
                self.softness = 0.0;
                self.measure(block);
                *soft.known = true;
                return Outcome::Reached;
            }
        }
        self.softness = 0.0;
        Outcome::Unreached
    }

    /// Tensions of least cost among those that give the closest torque.
    #[inline(always)]
    fn choose<R: Rows>(&mut self, block: &Block<R>, lambda: &mut [f64], most: u32, steps: &mut u32) -> bool {
        let (m, n) = (block.muscles(), block.joints());
        let closest = core::mem::take(&mut self.closest);
        let narrow = Block {
            lower: &closest.lower[..m],
            upper: &closest.upper[..m],
            torque: &closest.torque[..n],
            ..*block
        };
        let softness = core::mem::replace(&mut self.softness, 0.0);
        let outcome = self.ascend(&narrow, lambda, most, steps);
        self.softness = softness;
        self.closest = closest;
        outcome == Outcome::Reached && self.is_sharp(lambda)
    }

    /// Maximises the softened dual from `lambda` on; whether it did.
    #[inline(always)]
    fn ascend_softened<R: Rows>(
        &mut self,
        block: &Block<R>,
        lambda: &mut [f64],
        most: u32,
        steps: &mut u32,
    ) -> bool {
        let n = block.joints();
        let mut stiffness = Stiffness::None;
        self.evaluate(block, lambda);
        for _ in 0..most {
            block.residual(&self.tension, &mut self.residual);
            for (residual, lambda) in self.residual.iter_mut().zip(&*lambda) {
                *residual -= self.softness * lambda;
            }
            stiffness = self.factor(block, stiffness, false);
            *steps += 1;
            self.newton_step(n);
            let settled = self.look_ahead(block);
            let length = if settled { 1.0 } else { self.length(block) };
            if length == f64::INFINITY {
                return false;
            }
            for (lambda, step) in lambda.iter_mut().zip(&self.step) {
                *lambda += length * step;
            }
            self.evaluate(block, lambda);
            if settled {
                return true;
            }
        }
        false
    }
}
