//! Rates and smoothing without lag, and linear regression on smoothed columns.

use super::sequence::Sequence;
use crate::fit::linear_algebra::{Cholesky, Matrix};

/// Rate of a column by central differences: `[n]`, per s. A sequence's ends take one-sided ones.
pub(super) fn rate(values: &[f64], dt_s: &[f64]) -> Vec<f64> {
    let last = values.len().saturating_sub(1);
    let slope = |i: usize| {
        let (from, to) = (i.saturating_sub(1), (i + 1).min(last));
        let elapsed: f64 = dt_s[from + 1..=to].iter().sum();
        if elapsed > 0.0 { (values[to] - values[from]) / elapsed } else { 0.0 }
    };
    if last == 0 { vec![0.0; values.len()] } else { (0..=last).map(slope).collect() }
}

/// Two first-order low-passes, forwards and backwards: no lag.
pub(super) fn smooth(values: &mut [f64], dt_s: &[f64], tau_s: f64) {
    for _ in 0..2 {
        for i in 1..values.len() {
            let fraction = dt_s[i] / (dt_s[i] + tau_s);
            values[i] = values[i - 1] + fraction * (values[i] - values[i - 1]);
        }
        for i in (1..values.len()).rev() {
            let fraction = dt_s[i] / (dt_s[i] + tau_s);
            values[i - 1] = values[i] + fraction * (values[i - 1] - values[i]);
        }
    }
}

/// Weight of the rows that count under the filter above which a smoothed row is used: of what is held out
/// less than a hundredth enters.
const COUNTED: f64 = 0.99;

/// Columns and target of a regression in which both have passed the same filter.
pub(super) struct Regression {
    columns: Vec<Vec<f64>>,
    target: Vec<f64>,
    /// Products of the columns, once for all choices of them.
    normal: Matrix,
    /// Products of the columns with the target.
    right: Vec<f64>,
}

impl Regression {
    /// From every sequence its `[columns][n]` and target `[n]`, smoothed over `tau_s`.
    pub(super) fn new(
        sequences: &[Sequence<'_>],
        tau_s: f64,
        of: impl Fn(&Sequence<'_>) -> (Vec<Vec<f64>>, Vec<f64>),
    ) -> Self {
        let (mut all_columns, mut all_target): (Vec<Vec<f64>>, Vec<f64>) = (Vec::new(), Vec::new());
        for sequence in sequences {
            let (mut columns, mut target) = of(sequence);
            let mut counted = sequence.weight.to_vec();
            columns
                .iter_mut()
                .chain([&mut target, &mut counted])
                .for_each(|c| smooth(c, sequence.dt_s, tau_s));
            all_columns.resize(columns.len(), Vec::new());
            for row in (0..target.len()).filter(|row| counted[*row] > COUNTED) {
                all_columns.iter_mut().zip(&columns).for_each(|(all, column)| all.push(column[row]));
                all_target.push(target[row]);
            }
        }
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let product = |i: usize, j: usize| if j <= i { dot(&all_columns[i], &all_columns[j]) } else { 0.0 };
        Self {
            normal: Matrix::from_fn(all_columns.len(), product),
            right: all_columns.iter().map(|column| dot(column, &all_target)).collect(),
            columns: all_columns,
            target: all_target,
        }
    }

    /// Coefficients and sum of squared residuals by least squares on the columns `used`, in ascending order;
    /// the others are zero. `None` where there are too few rows.
    pub(super) fn solve(&self, used: &[usize]) -> Option<(Vec<f64>, f64)> {
        self.with_squares(self.coefficients(used)?)
    }

    fn coefficients(&self, used: &[usize]) -> Option<Vec<f64>> {
        if self.target.len() < 20 * used.len().max(1) {
            return None;
        }
        let scale: Vec<f64> = used
            .iter()
            .map(|&i| self.normal[(i, i)].sqrt())
            .map(|size| if size > 0.0 { size } else { 1.0 })
            .collect();
        let product = |i: usize, j: usize| {
            let ridge = if i == j { RIDGE } else { 0.0 };
            self.normal[(used[i], used[j])] / (scale[i] * scale[j]) + ridge
        };
        let normal = Matrix::from_fn(used.len(), |i, j| if j <= i { product(i, j) } else { 0.0 });
        let right: Vec<f64> = used.iter().zip(&scale).map(|(&i, scale)| self.right[i] / scale).collect();
        let scaled = Cholesky::new(normal)?.solve(&right)?;
        let mut found = vec![0.0; self.columns.len()];
        for ((&i, value), scale) in used.iter().zip(&scaled).zip(&scale) {
            found[i] = value / scale;
        }
        Some(found)
    }

    /// Coefficients with their sum of squared residuals.
    fn with_squares(&self, found: Vec<f64>) -> Option<(Vec<f64>, f64)> {
        let residual = |row: usize| {
            let fitted: f64 = self.columns.iter().zip(&found).map(|(column, w)| w * column[row]).sum();
            fitted - self.target[row]
        };
        let squares: f64 = (0..self.target.len()).map(|row| residual(row).powi(2)).sum();
        squares.is_finite().then_some((found, squares))
    }

    /// The same with all coefficients of `one_sided` of one sign, or zero: those of the wrong sign are left
    /// out, the largest first. Of both signs the better one.
    pub(super) fn solve_one_sided(&self, one_sided: &[usize]) -> Option<(Vec<f64>, f64)> {
        let with_sign = |sign: f64| {
            let mut used: Vec<usize> = (0..self.columns.len()).collect();
            loop {
                let found = self.coefficients(&used)?;
                let wrong = |i: &&usize| one_sided.contains(i) && sign * found[**i] < 0.0;
                let size =
                    |i: usize| found[i].abs() * self.columns[i].iter().fold(0.0, |m: f64, v| m.max(v.abs()));
                let Some(&worst) = used.iter().filter(wrong).max_by(|a, b| size(**a).total_cmp(&size(**b)))
                else {
                    return self.with_squares(found);
                };
                used.retain(|i| *i != worst);
            }
        };
        [1.0, -1.0].into_iter().filter_map(with_sign).min_by(|a, b| a.1.total_cmp(&b.1))
    }
}

/// Ridge relative to the square of a column: decides only what the data leave open.
const RIDGE: f64 = 1e-9;
