//! The reachable torque next to one that is not: least squares with limits.

use super::block::{Block, Limit};
use super::least_squares::LeastSquares;
use super::pattern::places;
use super::rows::{Rows, Sparse};
use alloc::vec::Vec;

/// What the search works in.
#[derive(Debug, Clone)]
pub(super) struct Closest {
    /// Per muscle.
    pub(super) tension: Vec<f64>,
    pub(super) limit: Vec<Limit>,
    /// Muscles that were freed in this round and did not want to leave their limit: rounding.
    barred: Vec<bool>,
    /// Muscles between their limits, and how far each shall go.
    free: Vec<usize>,
    change: Vec<f64>,
    /// Per joint.
    pub(super) residual: Vec<f64>,
    scale: Vec<f64>,
    squares: LeastSquares,
}

/// Wish to leave a limit, relative to the residual and to what it is made of, that is no rounding.
const CERTAIN: f64 = 1e-11;
const ROUNDING: f64 = 4e-15;

impl Closest {
    pub(super) fn new(muscles: usize, joints: usize) -> Self {
        let joints = places(joints);
        Self {
            tension: alloc::vec![0.0; muscles],
            limit: alloc::vec![Limit::Lower; muscles],
            barred: alloc::vec![false; muscles],
            free: Vec::with_capacity(joints),
            change: alloc::vec![0.0; joints],
            residual: alloc::vec![0.0; joints],
            scale: alloc::vec![0.0; joints],
            squares: LeastSquares::new(joints),
        }
    }

    /// Finds tensions within the limits whose torque is closest; adds the number of muscles freed to `steps`.
    ///
    /// ```text
    /// min |tau - R^T F|^2      s.t.   F_min <= F <= F_max
    /// ```
    ///
    /// Muscles start at the limits in `self.limit` (free ones at their least tension). The one that would lower the
    /// residual fastest is freed, the free ones go to their least squares or to the first limit in their way, and so
    /// on until none would lower it. Every round lowers the residual, so no set of free muscles comes twice.
    ///
    /// # Source
    /// `stark1995`.
    pub(super) fn solve(&mut self, block: &Block<Sparse>, most: u32, steps: &mut u32) {
        let (m, n) = (block.muscles(), block.joints());
        self.free.clear();
        self.barred[..m].fill(false);
        for i in 0..m {
            let upper = self.limit[i] == Limit::Upper;
            self.limit[i] = if upper { Limit::Upper } else { Limit::Lower };
            self.tension[i] = if upper { block.upper[i] } else { block.lower[i] };
        }
        block.measure(&self.tension, &mut self.residual, &mut self.scale);
        for _ in 0..most {
            let Some(muscle) = self.most_willing(block) else { break };
            *steps += 1;
            if self.free.len() == n {
                break;
            }
            self.limit[muscle] = Limit::Free;
            self.free.push(muscle);
            self.settle(block, muscle);
        }
    }

    /// How fast the residual falls as the muscle's tension rises, and how much of that may be rounding.
    pub(super) fn wish(&self, block: &Block<Sparse>, muscle: usize) -> (f64, f64) {
        let n = block.joints();
        let size = libm::sqrt(self.residual[..n].iter().map(|r| r * r).sum());
        block.rows.row(muscle).fold((0.0, 0.0), |(wish, doubt), (joint, arm)| {
            let error = CERTAIN * size + ROUNDING * self.scale[joint];
            (wish + arm * self.residual[joint], doubt + arm.abs() * error)
        })
    }

    /// The muscle at a limit that would lower the residual fastest by leaving it.
    fn most_willing(&self, block: &Block<Sparse>) -> Option<usize> {
        let (mut best, mut best_rate) = (None, 0.0);
        for i in 0..block.muscles() {
            if self.barred[i] || block.lower[i] >= block.upper[i] {
                continue;
            }
            let (wish, doubt) = self.wish(block, i);
            let wish = match self.limit[i] {
                Limit::Lower => wish,
                Limit::Upper => -wish,
                Limit::Free => continue,
            };
            let arm = libm::sqrt(block.rows.row(i).map(|(_, arm)| arm * arm).sum());
            if wish > doubt && wish / arm > best_rate {
                (best, best_rate) = (Some(i), wish / arm);
            }
        }
        best
    }

    /// Moves the free muscles to their least squares; those that meet a limit on the way stay there.
    fn settle(&mut self, block: &Block<Sparse>, freed: usize) {
        let (m, n) = (block.muscles(), block.joints());
        let mut first = true;
        while !self.free.is_empty() {
            self.squares.solve(block, &self.free, &self.residual[..n], &mut self.change);
            if first {
                let rising = self.change[self.free.len() - 1] > 0.0;
                let from_lower = self.tension[freed] <= block.lower[freed];
                if rising != from_lower {
                    self.free.pop();
                    self.barred[freed] = true;
                    self.limit[freed] = if from_lower { Limit::Lower } else { Limit::Upper };
                    return;
                }
                self.barred[..m].fill(false);
                first = false;
            }
            let (length, met) = self.first_limit(block);
            for (&i, change) in self.free.iter().zip(&self.change) {
                self.tension[i] = (self.tension[i] + length * change).max(block.lower[i]).min(block.upper[i]);
            }
            if let Some(k) = met {
                let i = self.free.remove(k);
                let upper = self.change[k] > 0.0;
                self.limit[i] = if upper { Limit::Upper } else { Limit::Lower };
                self.tension[i] = if upper { block.upper[i] } else { block.lower[i] };
            }
            block.measure(&self.tension, &mut self.residual, &mut self.scale);
            if met.is_none() {
                return;
            }
        }
    }

    /// How far the free muscles can go, 1 being all the way, and which of them stops it.
    fn first_limit(&self, block: &Block<Sparse>) -> (f64, Option<usize>) {
        let (mut length, mut met) = (1.0, None);
        for (k, (&i, &change)) in self.free.iter().zip(&self.change).enumerate() {
            let room = if change > 0.0 { block.upper[i] } else { block.lower[i] } - self.tension[i];
            if change != 0.0 && room / change < length {
                (length, met) = (room / change, Some(k));
            }
        }
        (length.max(0.0), met)
    }
}
