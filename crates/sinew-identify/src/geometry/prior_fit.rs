//! Many parameters near their priors from readings whose noise is not known.

use super::GeometryError;
use crate::fit::linear_algebra::{Cholesky, Matrix};

/// What a model misses of a reading, and the derivatives of the model that are not zero, by parameter.
pub(super) struct Row {
    /// Whose readings have one noise.
    pub(super) channel: usize,
    pub(super) residual: f64,
    pub(super) slopes: Vec<(usize, f64)>,
}

/// Parameters as found.
pub(super) struct PriorFit {
    pub(super) x: Vec<f64>,
    pub(super) sd: Vec<f64>,
}

const STEPS: usize = 10;
/// Share of the readings of a channel that its parameters leave free, at least.
const FREE: f64 = 0.5;

/// Most probable parameters, from 0:
///
/// ```text
/// min  sum_c sum (r / s_c)^2 + sum (x / prior)^2,      s_c: scatter of the residuals of a channel
/// ```
///
/// A parameter without a prior, 0, stays 0. `scale` is the scatter of every channel before the first step.
pub(super) fn fit(
    prior: &[f64],
    (scale, floor): (Vec<f64>, f64),
    rows: impl Fn(&[f64]) -> Result<Vec<Row>, GeometryError>,
) -> Result<PriorFit, GeometryError> {
    let n = prior.len();
    let (mut x, mut sd, mut scale) = (vec![0.0; n], prior.to_vec(), scale);
    for _ in 0..STEPS {
        let rows = rows(&x)?;
        let (mut square, mut right) = (vec![0.0; n * n], vec![0.0; n]);
        for Row { channel, residual, slopes } in &rows {
            let weight = scale[*channel].powi(-2);
            for &(i, a) in slopes {
                let a = weight * prior[i] * a;
                right[i] += a * residual;
                slopes.iter().for_each(|&(j, b)| square[i * n + j] += a * prior[j] * b);
            }
        }
        // In units of the priors.
        for (right, (x, prior)) in right.iter_mut().zip(x.iter().zip(prior)) {
            *right -= if *prior > 0.0 { x / prior } else { 0.0 };
        }
        let entry = |i: usize, j: usize| square[i * n + j] + f64::from(u8::from(i == j));
        let failed = || GeometryError::Observations("the readings determine no parameters".to_owned());
        let factor = Cholesky::new(Matrix::from_fn(n, entry)).ok_or_else(failed)?;
        let change = factor.solve(&right).ok_or_else(failed)?;
        let change: Vec<f64> = change.iter().zip(prior).map(|(change, prior)| change * prior).collect();
        x.iter_mut().zip(&change).for_each(|(x, change)| *x += change);
        sd = factor.inverse_diagonal().iter().zip(prior).map(|(v, prior)| v.sqrt() * prior).collect();
        let (mut sums, mut counts) = (vec![0.0; scale.len()], vec![0.0; scale.len()]);
        for Row { channel, residual, slopes } in rows {
            let explained: f64 = slopes.iter().map(|&(k, slope)| slope * change[k]).sum();
            sums[channel] += (residual - explained).powi(2);
            counts[channel] += FREE;
        }
        for (scale, (sum, count)) in scale.iter_mut().zip(sums.into_iter().zip(counts)) {
            *scale = if count > 0.0 { f64::max(floor, f64::sqrt(sum / count)) } else { *scale };
        }
    }
    Ok(PriorFit { x, sd })
}
