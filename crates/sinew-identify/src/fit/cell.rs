//! The clamp cell by Levenberg-Marquardt with exact forward sensitivities.

use sinew::predictor::{Cell, Term};

/// What the cell is fitted to: signals and far side of several sequences, one after the other.
///
/// Shapes: `signals: [n x stride]` row-major, `far: [n]`, `weight: [n]`, `first: [n]`.
pub(crate) struct CellData<'a> {
    /// The model's signals, row by row.
    pub signals: &'a [f64],
    /// Signals per row.
    pub stride: usize,
    /// Far side to fit.
    pub far: &'a [f64],
    /// 0 where a sample is stepped but not fitted.
    pub weight: &'a [f64],
    /// True at the first sample of a sequence.
    pub first: &'a [bool],
}

const MAX_PARAMETERS: usize = 40;

/// Fits the bounds and elasticities of a cell with the given `basis` and `elastic` signals.
///
/// Starts: least squares of the far side on the basis, opened by several widths on the constant or on all
/// coefficients, rigid and elastic; each start is improved on a thinned copy, the best two on all rows.
pub(crate) fn fit_cell(data: &CellData<'_>, basis: &[Term], elastic: &[usize]) -> Option<Cell> {
    let full = Scaled::new(data, basis, elastic, 20_000)?;
    let thin = Scaled::new(data, basis, elastic, 3_000)?;
    let mut starts: Vec<(f64, Vec<f64>)> =
        thin.starts().into_iter().map(|theta| thin.improve(theta, 20)).collect();
    starts.sort_by(|a, b| a.0.total_cmp(&b.0));
    starts.truncate(2);
    let best =
        starts.into_iter().map(|(_, theta)| full.improve(theta, 60)).min_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(full.cell(&best.1, basis, elastic))
}

/// The data in units in which every column has size one.
struct Scaled {
    basis: Vec<f64>,
    basis_scale: Vec<f64>,
    step: Vec<f64>,
    step_scale: Vec<f64>,
    far: Vec<f64>,
    far_scale: f64,
    weight: Vec<f64>,
    first: Vec<bool>,
    b: usize,
    e: usize,
}

impl Scaled {
    fn new(data: &CellData<'_>, basis: &[Term], elastic: &[usize], rows: usize) -> Option<Self> {
        let (b, e) = (basis.len(), elastic.len());
        let stride = data.far.len().div_ceil(rows).max(1);
        let (mut columns, mut steps) = (Vec::new(), Vec::new());
        let (mut far, mut weight, mut first) = (Vec::new(), Vec::new(), Vec::new());
        let mut since_first = 0;
        let mut previous = vec![0.0; e];
        for row in 0..data.far.len() {
            since_first = if data.first[row] { 0 } else { since_first + 1 };
            if since_first % stride != 0 {
                continue;
            }
            let signals = &data.signals[row * data.stride..][..data.stride];
            columns.extend(basis.iter().map(|term| term.value(signals)));
            for (previous, &signal) in previous.iter_mut().zip(elastic) {
                steps.push(if since_first == 0 { 0.0 } else { signals[signal] - *previous });
                *previous = signals[signal];
            }
            far.push(data.far[row]);
            weight.push(data.weight[row]);
            first.push(since_first == 0);
        }
        let n = far.len();
        let total: f64 = weight.iter().sum();
        if n < 2 || total < 2.0 {
            return None;
        }
        let mean = far.iter().zip(&weight).map(|(y, w)| y * w).sum::<f64>() / total;
        let variance = far.iter().zip(&weight).map(|(y, w)| w * (y - mean) * (y - mean)).sum::<f64>() / total;
        let far_scale = variance.sqrt().max(1e-12);
        far.iter_mut().for_each(|y| *y /= far_scale);
        let basis_scale = rms_columns(&columns, b);
        for row in columns.chunks_exact_mut(b) {
            row.iter_mut().zip(&basis_scale).for_each(|(x, s)| *x /= s);
        }
        // A step is compared with the size of the signal, not of its increments.
        let step_scale: Vec<f64> = elastic
            .iter()
            .map(|&signal| {
                let column = || data.signals.iter().skip(signal).step_by(data.stride);
                let count = data.far.len() as f64;
                let mean = column().sum::<f64>() / count;
                (column().map(|u| (u - mean) * (u - mean)).sum::<f64>() / count).sqrt().max(1e-12)
            })
            .collect();
        if e > 0 {
            for row in steps.chunks_exact_mut(e) {
                row.iter_mut().zip(&step_scale).for_each(|(x, s)| *x /= s);
            }
        }
        Some(Self {
            basis: columns,
            basis_scale,
            step: steps,
            step_scale,
            far,
            far_scale,
            weight,
            first,
            b,
            e,
        })
    }

    fn parameters(&self) -> usize {
        2 * self.b + self.e
    }

    fn starts(&self) -> Vec<Vec<f64>> {
        let (middle, spread) = self.least_squares();
        let constant = self.b - 1;
        let mut starts = Vec::new();
        for kappa in [0.0, 0.5] {
            for d in [0.3, 1.0, 2.0] {
                let mut theta = vec![0.0; self.parameters()];
                theta[..self.b].copy_from_slice(&middle);
                theta[self.b..2 * self.b].copy_from_slice(&middle);
                theta[2 * self.b..].fill(kappa);
                let mut slanted = theta.clone();
                theta[constant] -= d * spread;
                theta[self.b + constant] += d * spread;
                for i in 0..self.b {
                    slanted[i] *= 1.0 - 0.4 * d;
                    slanted[self.b + i] *= 1.0 + 0.4 * d;
                }
                starts.push(theta);
                starts.push(slanted);
            }
        }
        starts
    }

    /// Ordinary least squares of the far side on the basis, and the spread of its residual.
    fn least_squares(&self) -> (Vec<f64>, f64) {
        let b = self.b;
        let mut normal = vec![0.0; b * b];
        let mut right = vec![0.0; b];
        let mut total = 0.0;
        for ((x, y), w) in self.basis.chunks_exact(b).zip(&self.far).zip(&self.weight) {
            total += w;
            for i in 0..b {
                right[i] += w * x[i] * y;
                for j in 0..=i {
                    normal[i * b + j] += w * x[i] * x[j];
                }
            }
        }
        for i in 0..b {
            normal[i * b + i] += 1e-8 * total;
        }
        let solution = super::dense::solve(&mut normal, &right, b).unwrap_or_else(|| vec![0.0; b]);
        let residual: f64 = self
            .basis
            .chunks_exact(b)
            .zip(&self.far)
            .zip(&self.weight)
            .map(|((x, y), w)| {
                let error = y - x.iter().zip(&solution).map(|(x, t)| x * t).sum::<f64>();
                w * error * error
            })
            .sum();
        (solution, (residual / total).sqrt())
    }

    /// Levenberg-Marquardt from one start.
    fn improve(&self, mut theta: Vec<f64>, steps: usize) -> (f64, Vec<f64>) {
        let p = self.parameters();
        let mut damping = 1e-3;
        let (mut normal, mut gradient) = (vec![0.0; p * p], vec![0.0; p]);
        let mut cost = self.linearise(&theta, Some((&mut normal, &mut gradient)));
        let mut flat = 0;
        for _ in 0..steps {
            let mut system = normal.clone();
            for i in 0..p {
                system[i * p + i] += damping * (normal[i * p + i] + 1e-6);
            }
            let Some(step) = super::dense::solve(&mut system, &gradient, p) else {
                damping *= 10.0;
                continue;
            };
            let trial: Vec<f64> = theta.iter().zip(&step).map(|(t, s)| t - s).collect();
            let trial_cost = self.linearise(&trial, None);
            if trial_cost < cost {
                flat = if cost - trial_cost < 1e-6 * cost { flat + 1 } else { 0 };
                theta = trial;
                damping = (damping / 5.0).max(1e-12);
                cost = self.linearise(&theta, Some((&mut normal, &mut gradient)));
            } else {
                damping *= 5.0;
                flat += 1;
            }
            if flat >= 6 || damping > 1e10 {
                break;
            }
        }
        (cost, theta)
    }

    /// Mean squared error (scaled) with its Gauss-Newton matrix and gradient, by forward sensitivities.
    fn linearise(&self, theta: &[f64], mut derivative: Option<(&mut Vec<f64>, &mut Vec<f64>)>) -> f64 {
        let (b, e, p) = (self.b, self.e, self.parameters());
        let (low, rest) = theta.split_at(b);
        let (high, kappa) = rest.split_at(b);
        if let Some((normal, gradient)) = &mut derivative {
            normal.fill(0.0);
            gradient.fill(0.0);
        }
        let mut g = [0.0; MAX_PARAMETERS];
        let g = &mut g[..p];
        let (mut state, mut sum, mut total) = (0.0, 0.0, 0.0);
        let mut crossings = 0.0;
        for row in 0..self.far.len() {
            let x = &self.basis[row * b..][..b];
            let du = &self.step[row * e..][..e];
            let mut lo: f64 = low.iter().zip(x).map(|(l, x)| l * x).sum();
            let mut hi: f64 = high.iter().zip(x).map(|(h, x)| h * x).sum();
            let crossed = hi < lo;
            if crossed {
                crossings += (lo - hi) * (lo - hi);
                lo = 0.5 * (lo + hi);
                hi = lo;
            }
            if self.first[row] {
                g.fill(0.0);
                state = self.far[row];
            } else {
                state += kappa.iter().zip(du).map(|(k, d)| k * d).sum::<f64>();
                g[2 * b..].iter_mut().zip(du).for_each(|(g, d)| *g += d);
            }
            let below = state < lo;
            if below || state > hi {
                state = if below { lo } else { hi };
                g.fill(0.0);
                if crossed {
                    g[..b].iter_mut().zip(x).for_each(|(g, x)| *g = 0.5 * x);
                    g[b..2 * b].iter_mut().zip(x).for_each(|(g, x)| *g = 0.5 * x);
                } else {
                    let offset = if below { 0 } else { b };
                    g[offset..offset + b].iter_mut().zip(x).for_each(|(g, x)| *g = *x);
                }
            }
            let weight = self.weight[row];
            if weight == 0.0 {
                continue;
            }
            let error = state - self.far[row];
            sum += weight * error * error;
            total += weight;
            if let Some((normal, gradient)) = &mut derivative {
                for i in 0..p {
                    if g[i] == 0.0 {
                        continue;
                    }
                    let gi = weight * g[i];
                    gradient[i] += gi * error;
                    for j in 0..=i {
                        normal[i * p + j] += gi * g[j];
                    }
                }
            }
        }
        let ridge = 1e-5 / p as f64;
        if let Some((normal, gradient)) = derivative {
            normal.iter_mut().for_each(|v| *v /= total);
            gradient.iter_mut().for_each(|v| *v /= total);
            for i in 0..p {
                normal[i * p + i] += ridge;
                gradient[i] += ridge * theta[i];
            }
        }
        let _ = crossings;
        sum / total + ridge * theta.iter().map(|t| t * t).sum::<f64>()
    }

    fn cell(&self, theta: &[f64], basis: &[Term], elastic: &[usize]) -> Cell {
        let unscale = |part: &[f64]| -> Vec<f64> {
            part.iter().zip(&self.basis_scale).map(|(t, s)| t * self.far_scale / s).collect()
        };
        Cell {
            basis: basis.to_vec(),
            low: unscale(&theta[..self.b]),
            high: unscale(&theta[self.b..2 * self.b]),
            elastic: elastic.to_vec(),
            kappa: theta[2 * self.b..]
                .iter()
                .zip(&self.step_scale)
                .map(|(k, s)| k * self.far_scale / s)
                .collect(),
        }
    }
}

fn rms_columns(columns: &[f64], width: usize) -> Vec<f64> {
    let mut scale = vec![0.0; width];
    for row in columns.chunks_exact(width) {
        scale.iter_mut().zip(row).for_each(|(s, x)| *s += x * x);
    }
    let n = (columns.len() / width).max(1) as f64;
    scale.iter().map(|s| (s / n).sqrt().max(1e-12)).collect()
}
