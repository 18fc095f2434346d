//! Which poses tell most about where the end point is.

use super::place::{Place, Seen};
use super::{GeometryError, GeometryModel};
use crate::fit::linear_algebra::{Cholesky, Matrix};

/// Poses that were chosen, and what they promise.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// Indices of the candidates, in the order in which they were chosen.
    pub chosen: Vec<usize>,
    /// Root mean square of the end point's error over the task after as many of them, m: `[chosen + 1]`.
    pub expected_m: Vec<f64>,
}

/// Information of the camera's place before, which a glance at the base gives, 1/m^2 and 1/rad^2.
const CAMERA: f64 = 1e4;

/// Chooses `count` of the candidates so that the mean variance of the point over the poses of the task
/// is least
/// (I-optimality): one after the other, then each exchanged once for a better one.
///
/// # Shapes
/// `candidates: [n][joints]`, `task: [poses][joints]`, readings; `noise` of a place in m; `point`: body
/// and place.
///
/// # Errors
/// As [`GeometryModel::sensitivity`].
pub fn plan(
    model: &GeometryModel,
    candidates: &[Vec<f64>],
    task: &[Vec<f64>],
    (point, noise, count): ((usize, [f64; 3]), f64, usize),
) -> Result<Plan, GeometryError> {
    let n = model.parameters().len();
    let theta = vec![0.0; n];
    let unit = |k: usize| {
        let tolerance = model.parameters()[k].tolerance;
        if tolerance.is_finite() { tolerance } else { CAMERA.powf(-0.5) }
    };
    let seen: Vec<Seen> =
        (0..model.markers.len()).map(|marker| Seen { marker, position: [0.0; 3] }).collect();
    let places: Vec<Place> = candidates
        .iter()
        .map(|reading| Place { time: [0.0; 2], reading: reading.clone(), seen: seen.clone(), epoch: 0 })
        .collect();
    let lines = super::estimate::planned(model, &theta, &places)?;
    // Rows of every candidate in units of tolerance and noise.
    let all: Vec<Vec<Vec<f64>>> = lines
        .chunks(seen.len())
        .map(|points| {
            let rows = points.iter().flat_map(|slopes| {
                (0..3).map(|a| (0..n).map(|k| slopes[k][a] * unit(k) / noise).collect::<Vec<f64>>())
            });
            rows.collect()
        })
        .collect();
    let mut goal = vec![0.0; n * n];
    for (_, slopes) in model.sensitivity(&theta, task, point.0, point.1)? {
        for i in 0..n {
            for j in 0..n {
                let dot: f64 = (0..3).map(|a| slopes[i][a] * slopes[j][a]).sum();
                goal[i * n + j] += dot * unit(i) * unit(j) / task.len() as f64;
            }
        }
    }
    let mut state = State { n, covariance: vec![0.0; n * n], goal };
    (0..n).for_each(|k| state.covariance[k * n + k] = 1.0);
    let mut found = Plan { chosen: Vec::new(), expected_m: vec![state.expected()] };
    let mut free: Vec<bool> = vec![true; all.len()];
    for _ in 0..count.min(all.len()) {
        let Some(next) = state.best(&all, &free) else { break };
        free[next] = false;
        state.add(&all[next], 1.0);
        found.chosen.push(next);
        found.expected_m.push(state.expected());
    }
    for at in 0..found.chosen.len() {
        let old = found.chosen[at];
        state.add(&all[old], -1.0);
        free[old] = true;
        let next = state.best(&all, &free).unwrap_or(old);
        free[next] = false;
        state.add(&all[next], 1.0);
        found.chosen[at] = next;
    }
    if let Some(last) = found.expected_m.last_mut() {
        *last = state.expected();
    }
    Ok(found)
}

/// Covariance in units of the tolerances, and the weight of it in the goal.
struct State {
    n: usize,
    covariance: Vec<f64>,
    goal: Vec<f64>,
}

impl State {
    fn expected(&self) -> f64 {
        self.covariance.iter().zip(&self.goal).map(|(c, g)| c * g).sum::<f64>().max(0.0).sqrt()
    }

    fn times(&self, matrix: &[f64], v: &[f64]) -> Vec<f64> {
        matrix.chunks_exact(self.n).map(|row| row.iter().zip(v).map(|(a, b)| a * b).sum()).collect()
    }

    /// `C J^T` of rows, and `S^-1` applied through its factor, `S = J C J^T + sign`.
    fn gains(&self, rows: &[Vec<f64>], sign: f64) -> Option<(Vec<Vec<f64>>, Cholesky)> {
        let spread: Vec<Vec<f64>> = rows.iter().map(|row| self.times(&self.covariance, row)).collect();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        // For a removal S is negative definite: its opposite is factorised.
        let s = Matrix::from_fn(rows.len(), |i, j| {
            sign * dot(&rows[i], &spread[j]) + f64::from(u8::from(i == j))
        });
        Cholesky::new(s).map(|factor| (spread, factor))
    }

    /// The free candidate that lowers the goal most.
    fn best(&self, all: &[Vec<Vec<f64>>], free: &[bool]) -> Option<usize> {
        let gain = |rows: &[Vec<f64>]| {
            let Some((spread, factor)) = self.gains(rows, 1.0) else { return 0.0 };
            let weighted: Vec<Vec<f64>> = spread.iter().map(|v| self.times(&self.goal, v)).collect();
            let column = |j: usize| -> f64 {
                let right: Vec<f64> =
                    spread.iter().map(|v| v.iter().zip(&weighted[j]).map(|(a, b)| a * b).sum()).collect();
                factor.solve(&right).map_or(0.0, |x| x[j])
            };
            (0..rows.len()).map(column).sum()
        };
        let free = (0..all.len()).filter(|k| free[*k]);
        let gains: Vec<(usize, f64)> = free.map(|k| (k, gain(&all[k]))).collect();
        gains.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)).map(|(k, _)| k)
    }

    /// Adds an observation, or removes it.
    fn add(&mut self, rows: &[Vec<f64>], sign: f64) {
        let Some((spread, factor)) = self.gains(rows, sign) else { return };
        for i in 0..self.n {
            let column: Vec<f64> = spread.iter().map(|v| v[i]).collect();
            let Some(solved) = factor.solve(&column) else { return };
            for j in 0..self.n {
                let change: f64 = spread.iter().zip(&solved).map(|(v, x)| v[j] * x).sum();
                self.covariance[i * self.n + j] -= sign * change;
            }
        }
    }
}
