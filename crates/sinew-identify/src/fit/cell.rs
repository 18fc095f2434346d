//! Fit of a clamp cell with exact forward sensitivities.
//!
//! ```text
//! theta = [l, h, kappa, p_2 ..],   p_1 = 1 - sum_{j > 1} p_j,   r = z - y
//! dz_j/d(l, h, kappa): d kappa += u - u_prev between the bounds;
//!                      at a bound n lo + (1 - n) hi:  dl = n b, dh = (1 - n) b, dkappa = 0
//! ```
//!
//! The state is piecewise linear in `l`, `h` and `kappa`, so the recursion is exact wherever the derivative
//! exists.

use super::levenberg_marquardt::{Adaptation, Damping, Limits, Problem, Scaling, minimise};
use super::linear_algebra::{Cholesky, Matrix};
use super::linearisation::Linearisation;
use super::prior::Prior;
use sinew::transmission::{Band, BasisTerm, Branch, ClampCell};

/// Signals and far side of several sequences, one after the other.
///
/// Shapes: `signals: [n x stride]` row-major, `far: [n]`, `weight: [n]`, `first: [n]`.
pub(crate) struct CellData<'a> {
    /// Signals of the model, row by row.
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

/// Structure of a clamp cell, before its coefficients are fitted.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct CellPlan {
    /// Factors of the bounds; the last one is the constant.
    pub basis: Vec<BasisTerm>,
    /// Signals that move the state inside the band.
    pub elastic: Vec<usize>,
    /// Widths of the branches relative to the band, the first of them 1. `[1.0]` is the plain cell;
    /// [`CellPlan::DISTRIBUTED`] fits loops with round corners better, but not every log.
    pub branches: Vec<f64>,
    /// What the factors of the bounds are restricted to; empty where nothing is.
    pub effects: Vec<Effect>,
    /// Whether the restricted fit is a start only.
    pub released: bool,
}

/// What a factor of the bounds does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Effect {
    /// Moves either bound by its own coefficient.
    Both,
    /// Moves both alike.
    Centre,
    /// Moves them apart.
    Width,
    /// Nothing.
    Neither,
}

impl CellPlan {
    /// Three branches: round corners at the price of two parameters.
    pub(crate) const DISTRIBUTED: [f64; 3] = [1.0, 0.8, 0.5];
}

/// Fraction of every further branch at the start of its fit: large enough for a gradient, small enough to
/// vanish.
const FIRST_FRACTION: f64 = 0.05;

/// Weight of the prior mean of the start (the middle of the band), in sequences.
pub(crate) const START_PRIOR_SEQUENCES: f64 = 3.0;

/// Fits the bounds, elasticities and branch fractions of a cell.
///
/// Starts: least squares of the far side on the basis, opened by several widths on the constant or on all
/// coefficients, rigid and elastic, with one branch; each start is improved on a thinned copy, the best two
/// on all rows. The other branches join the best of these with small fractions. `None` where there are too
/// few samples, or the basis is empty.
pub(crate) fn fit_cell(data: &CellData<'_>, plan: &CellPlan) -> Option<ClampCell> {
    if plan.basis.is_empty() {
        return None;
    }
    let restricted = CellPlan { branches: vec![1.0], released: false, ..plan.clone() };
    let mut full = Scaled::new(data, &restricted, FINE_ROWS)?;
    let mut theta = search(&full, &Scaled::new(data, &restricted, COARSE_ROWS)?, None)?;
    if plan.released {
        let single = CellPlan { effects: Vec::new(), ..restricted };
        let start = full.expanded(&theta);
        full = Scaled::new(data, &single, FINE_ROWS)?;
        theta = search(&full, &Scaled::new(data, &single, COARSE_ROWS)?, Some(start))?;
    }
    if plan.branches.len() > 1 {
        full.widths.clone_from(&plan.branches);
        theta.resize(full.parameters(), FIRST_FRACTION);
        (_, theta) = full.improve(theta, FINE_STEPS)?;
    }
    Some(full.cell(&theta, plan))
}

/// The best of all starts and of a given one, improved.
fn search(full: &Scaled, thin: &Scaled, given: Option<Vec<f64>>) -> Option<Vec<f64>> {
    let starts = thin.starts().into_iter();
    let mut starts: Vec<(f64, Vec<f64>)> =
        starts.filter_map(|theta| thin.improve(thin.restricted(&theta), COARSE_STEPS)).collect();
    starts.sort_by(|a, b| a.0.total_cmp(&b.0));
    starts.truncate(2);
    let starts = starts.into_iter().map(|(_, theta)| theta).chain(given);
    let improved = starts.filter_map(|theta| full.improve(theta, FINE_STEPS));
    improved.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, theta)| theta)
}

/// Rows and steps that rank the starts.
const COARSE_ROWS: usize = 3_000;
const COARSE_STEPS: usize = 20;
/// Rows and steps of the final searches: a few hundred times as many rows as parameters.
const FINE_ROWS: usize = 20_000;
const FINE_STEPS: usize = 60;

/// Ridge on all parameters together, relative to the variance of the far side: decides only what data leave
/// open.
const RIDGE: f64 = 1e-5;

/// Columns have size one; bounds, elasticities and fractions differ in effect.
const DAMPING: Damping = Damping {
    initial: 1e-3,
    min: 1e-12,
    scaling: Scaling::Diagonal { floor: 1e-6 },
    adaptation: Adaptation::Factor(5.0),
};

/// The data, scaled so that every column has size one.
struct Scaled {
    basis: Vec<f64>,
    basis_scale: Vec<f64>,
    step: Vec<f64>,
    step_scale: Vec<f64>,
    far: Vec<f64>,
    far_scale: f64,
    weight: Vec<f64>,
    first: Vec<bool>,
    /// Relative widths of the branches.
    widths: Vec<f64>,
    /// `[2 b]`: the parameter that is a coefficient of a bound, and its sign there.
    bounds: Vec<Option<(usize, f64)>>,
    /// Number of those parameters.
    free: usize,
    b: usize,
    e: usize,
}

/// For every coefficient of the lower and of the upper bound the parameter and its sign, and how many there
/// are.
fn bounds(plan: &CellPlan) -> (Vec<Option<(usize, f64)>>, usize) {
    let b = plan.basis.len();
    let mut bounds = vec![None; 2 * b];
    let mut free = 0;
    for k in 0..b {
        let (low, high, count) = match plan.effects.get(k).unwrap_or(&Effect::Both) {
            // The coefficients of a free cell stand in their order.
            Effect::Both if plan.effects.is_empty() => (Some((k, 1.0)), Some((b + k, 1.0)), 2),
            Effect::Both => (Some((free, 1.0)), Some((free + 1, 1.0)), 2),
            Effect::Centre => (Some((free, 1.0)), Some((free, 1.0)), 1),
            Effect::Width => (Some((free, -1.0)), Some((free, 1.0)), 1),
            Effect::Neither => (None, None, 0),
        };
        (bounds[k], bounds[b + k]) = (low, high);
        free += count;
    }
    (bounds, free)
}

impl Scaled {
    fn new(data: &CellData<'_>, plan: &CellPlan, rows: usize) -> Option<Self> {
        let (basis, elastic) = (&plan.basis, &plan.elastic);
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
            for (previous, &signal) in previous.iter_mut().zip(elastic.iter()) {
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
        // Increments are scaled by the size of the signal.
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
        let (bounds, free) = bounds(plan);
        Some(Self {
            bounds,
            free,
            basis: columns,
            basis_scale,
            step: steps,
            step_scale,
            far,
            far_scale,
            weight,
            first,
            widths: plan.branches.clone(),
            b,
            e,
        })
    }

    fn parameters(&self) -> usize {
        self.free + self.e + self.widths.len() - 1
    }

    /// Coefficients of both bounds, then the other parameters.
    fn expanded(&self, theta: &[f64]) -> Vec<f64> {
        let bound = |of: &Option<(usize, f64)>| of.map_or(0.0, |(index, sign)| sign * theta[index]);
        self.bounds.iter().map(bound).chain(theta[self.free..].iter().copied()).collect()
    }

    /// The parameters nearest to coefficients of both bounds; the other parameters follow.
    fn restricted(&self, expanded: &[f64]) -> Vec<f64> {
        let mut sums = vec![(0.0, 0.0); self.free];
        for (value, bound) in expanded.iter().zip(&self.bounds) {
            if let Some((index, sign)) = bound {
                sums[*index].0 += sign * value;
                sums[*index].1 += 1.0;
            }
        }
        let means = sums.iter().map(|(sum, count)| sum / count);
        means.chain(expanded[2 * self.b..].iter().copied()).collect()
    }

    fn starts(&self) -> Vec<Vec<f64>> {
        let (middle, spread) = self.least_squares();
        let constant = self.b - 1;
        let mut starts = Vec::new();
        for kappa in [0.0, 0.5] {
            for d in [0.3, 1.0, 2.0] {
                let mut theta = vec![0.0; 2 * self.b + self.e];
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
        let mut normal = Matrix::zeros(b);
        let mut right = vec![0.0; b];
        let mut total = 0.0;
        for ((x, y), w) in self.basis.chunks_exact(b).zip(&self.far).zip(&self.weight) {
            total += w;
            for i in 0..b {
                right[i] += w * x[i] * y;
                for j in 0..=i {
                    normal[(i, j)] += w * x[i] * x[j];
                }
            }
        }
        for i in 0..b {
            normal[(i, i)] += 1e-8 * total;
        }
        let solution = Cholesky::new(normal).and_then(|factor| factor.solve(&right));
        let solution = solution.unwrap_or_else(|| vec![0.0; b]);
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

    /// Cost and parameters after a search from one start.
    fn improve(&self, theta: Vec<f64>, trials: usize) -> Option<(f64, Vec<f64>)> {
        let limits = Limits { steps: trials, trials, tolerance: 1e-6, small_steps: 3 };
        let p = self.parameters();
        let mut prior = Prior::ridge(p, RIDGE / p as f64);
        let found = minimise(&mut &*self, theta, &mut prior, &DAMPING, &limits)?;
        Some((found.cost, found.theta))
    }

    fn cell(&self, theta: &[f64], plan: &CellPlan) -> ClampCell {
        let theta = self.expanded(theta);
        let (bounds, rest) = theta.split_at(2 * self.b);
        let (kappa, fractions) = rest.split_at(self.e);
        let unscale = |part: &[f64], scale: &[f64]| -> Vec<f64> {
            part.iter().zip(scale).map(|(t, s)| t * self.far_scale / s).collect()
        };
        let first = 1.0 - fractions.iter().sum::<f64>();
        let fractions = core::iter::once(first).chain(fractions.iter().copied());
        ClampCell {
            basis: plan.basis.clone(),
            low: unscale(&bounds[..self.b], &self.basis_scale),
            high: unscale(&bounds[self.b..], &self.basis_scale),
            elastic: plan.elastic.clone(),
            kappa: unscale(kappa, &self.step_scale),
            branches: self
                .widths
                .iter()
                .zip(fractions)
                .map(|(&width, fraction)| Branch { width, fraction })
                .collect(),
            start: self.start(bounds),
        }
    }

    /// First rows of the sequences of which samples within the first tenth are fitted.
    fn beginnings(&self) -> Vec<usize> {
        let mut rows: Vec<usize> = (0..self.far.len()).filter(|&row| self.first[row]).collect();
        rows.push(self.far.len());
        let counts = |pair: &&[usize]| {
            let tenth = pair[0] + (pair[1] - pair[0]).div_ceil(10);
            self.weight[pair[0]..tenth].iter().any(|w| *w > 0.0)
        };
        rows.windows(2).filter(counts).map(|pair| pair[0]).collect()
    }

    /// Where in the band the sequences start, on average; the middle counts as [`START_PRIOR_SEQUENCES`] more
    /// sequences.
    fn start(&self, bounds: &[f64]) -> f64 {
        let (low, high) = bounds.split_at(self.b);
        let (mut sum, mut count) = (0.5 * START_PRIOR_SEQUENCES, START_PRIOR_SEQUENCES);
        for row in self.beginnings() {
            let x = &self.basis[row * self.b..][..self.b];
            let (low, high) = (dot(low, x), dot(high, x));
            if high > low {
                sum += ((self.far[row] - low) / (high - low)).clamp(0.0, 1.0);
                count += 1.0;
            }
        }
        sum / count
    }
}

impl Problem for &Scaled {
    /// Mean squared error, scaled.
    fn squares(&mut self, theta: &[f64]) -> Option<f64> {
        let theta = self.expanded(theta);
        let mut simulation = Simulation::new(self, &theta);
        let (mut sum, mut total) = (0.0, 0.0);
        for row in 0..self.far.len() {
            let error = simulation.step(self, row, false) - self.far[row];
            sum += self.weight[row] * error * error;
            total += self.weight[row];
        }
        Some(sum / total)
    }

    fn linearise(&mut self, theta: &[f64], at: &mut Linearisation) -> bool {
        at.clear();
        let theta = self.expanded(theta);
        let mut simulation = Simulation::new(self, &theta);
        let mut gradient = vec![0.0; self.parameters()];
        let mut total = 0.0;
        for row in 0..self.far.len() {
            let error = simulation.step(self, row, true) - self.far[row];
            let weight = self.weight[row];
            if weight > 0.0 {
                at.squares += weight * error * error;
                total += weight;
                let (bounds, rest) = simulation.gradient.split_at(2 * self.b);
                let (of_bounds, of_rest) = gradient.split_at_mut(self.free);
                of_bounds.fill(0.0);
                for (g, bound) in bounds.iter().zip(&self.bounds) {
                    bound.iter().for_each(|(index, sign)| of_bounds[*index] += sign * g);
                }
                of_rest.copy_from_slice(rest);
                add_row(at, &gradient, weight, error);
            }
        }
        at.divide(total);
        true
    }
}

/// The cell stepped through the rows, with the derivative of its output by every parameter.
struct Simulation<'a> {
    low: &'a [f64],
    high: &'a [f64],
    kappa: &'a [f64],
    fractions: Vec<f64>,
    /// One per branch.
    states: Vec<f64>,
    /// One row per branch over bounds and elasticities: `[branches x (2 b + e)]`.
    sensitivities: Vec<f64>,
    /// Of the output, by all parameters.
    gradient: Vec<f64>,
}

impl<'a> Simulation<'a> {
    fn new(data: &Scaled, theta: &'a [f64]) -> Self {
        let (low, rest) = theta.split_at(data.b);
        let (high, rest) = rest.split_at(data.b);
        let (kappa, others) = rest.split_at(data.e);
        let branches = data.widths.len();
        let mut fractions = vec![1.0 - others.iter().sum::<f64>()];
        fractions.extend_from_slice(others);
        Self {
            low,
            high,
            kappa,
            fractions,
            states: vec![0.0; branches],
            sensitivities: vec![0.0; branches * (2 * data.b + data.e)],
            gradient: vec![0.0; theta.len()],
        }
    }

    /// Advances to one row and returns the output; with `differentiate`, `self.gradient` is that of the row.
    fn step(&mut self, data: &Scaled, row: usize, differentiate: bool) -> f64 {
        let (b, e) = (data.b, data.e);
        let x = &data.basis[row * b..][..b];
        let du = &data.step[row * e..][..e];
        let band = Band::new(dot(self.low, x), dot(self.high, x));
        let increment = dot(self.kappa, du);
        let start = data.first[row].then_some(data.far[row]);
        let rows = self.sensitivities.chunks_exact_mut(2 * b + e);
        for ((state, g), width) in self.states.iter_mut().zip(rows).zip(&data.widths) {
            let (projected, active) = band.project(start.unwrap_or(*state + increment), *width);
            *state = projected;
            if !differentiate {
                continue;
            }
            if let Some(bound) = active {
                let of_low = band.weight_of_low(bound, *width);
                g[..b].iter_mut().zip(x).for_each(|(g, x)| *g = of_low * x);
                g[b..2 * b].iter_mut().zip(x).for_each(|(g, x)| *g = (1.0 - of_low) * x);
                g[2 * b..].fill(0.0);
            } else if start.is_some() {
                g.fill(0.0);
            } else {
                g[2 * b..].iter_mut().zip(du).for_each(|(g, d)| *g += d);
            }
        }
        if differentiate {
            self.collect(2 * b + e);
        }
        dot(&self.fractions, &self.states)
    }

    fn collect(&mut self, inner: usize) {
        let (of_inner, of_fractions) = self.gradient.split_at_mut(inner);
        of_inner.fill(0.0);
        for (fraction, row) in self.fractions.iter().zip(self.sensitivities.chunks_exact(inner)) {
            of_inner.iter_mut().zip(row).for_each(|(sum, g)| *sum += fraction * g);
        }
        for (g, state) in of_fractions.iter_mut().zip(&self.states[1..]) {
            *g = state - self.states[0];
        }
    }
}

/// Adds one sample to `J^T W J` and `J^T W r`; most sensitivities of a cell are zero.
fn add_row(at: &mut Linearisation, g: &[f64], weight: f64, error: f64) {
    for (i, gi) in g.iter().enumerate().filter(|(_, gi)| **gi != 0.0) {
        let gi = weight * gi;
        at.gradient[i] += gi * error;
        for (j, gj) in g[..=i].iter().enumerate() {
            at.normal[(i, j)] += gi * gj;
        }
    }
}

fn dot(a: &[f64], x: &[f64]) -> f64 {
    a.iter().zip(x).map(|(a, x)| a * x).sum()
}

fn rms_columns(columns: &[f64], width: usize) -> Vec<f64> {
    let mut scale = vec![0.0; width];
    for row in columns.chunks_exact(width) {
        scale.iter_mut().zip(row).for_each(|(s, x)| *s += x * x);
    }
    let n = (columns.len() / width).max(1) as f64;
    scale.iter().map(|s| (s / n).sqrt().max(1e-12)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use sinew::predictor::{Memory, MemoryLaw, Signal};

    fn plan() -> CellPlan {
        CellPlan {
            basis: vec![BasisTerm::Signal(0), BasisTerm::Signal(1), BasisTerm::One],
            elastic: vec![0],
            branches: CellPlan::DISTRIBUTED.to_vec(),
            effects: vec![],
            released: false,
        }
    }

    fn truth() -> ClampCell {
        let branches = [(1.0, 0.5), (0.8, 0.2), (0.5, 0.3)];
        ClampCell {
            start: 0.5,
            basis: plan().basis,
            low: vec![0.6, 0.05, -0.1],
            high: vec![1.1, 0.1, 0.2],
            elastic: vec![0],
            kappa: vec![0.1],
            branches: branches.map(|(width, fraction)| Branch { width, fraction }).to_vec(),
        }
    }

    struct Log {
        signals: Vec<f64>,
        far: Vec<f64>,
        weight: Vec<f64>,
        first: Vec<bool>,
    }

    impl Log {
        /// Three sequences of loading and unloading under a slowly changing second signal.
        fn simulated(n: usize, noise: f64) -> Self {
            let law = MemoryLaw {
                signals: vec![Signal::Input(0), Signal::Input(1)],
                cell: Some(truth()),
                cable: None,
                axis: None,
                features: vec![],
            };
            let mut memory = Memory::new(&law);
            let mut rng = ChaCha8Rng::seed_from_u64(7);
            let mut log = Self { signals: vec![], far: vec![], weight: vec![1.0; n], first: vec![] };
            for i in 0..n {
                let t = i as f64 * 0.02;
                let first = i % (n / 3 + 1) == 0;
                if first {
                    memory.reset();
                }
                let inputs = [5.0 + 3.0 * t.sin() + (2.7 * t).sin(), (0.11 * t).cos()];
                memory.step(&law, 0.02, &inputs);
                log.signals.extend(inputs);
                log.far.push(memory.cell().state + noise * (rng.random::<f64>() - 0.5));
                log.first.push(first);
            }
            log
        }

        fn data(&self) -> CellData<'_> {
            CellData {
                signals: &self.signals,
                stride: 2,
                far: &self.far,
                weight: &self.weight,
                first: &self.first,
            }
        }
    }

    #[test]
    fn sensitivities_equal_finite_differences_for_every_parameter() {
        let log = Log::simulated(400, 0.1);
        let scaled = Scaled::new(&log.data(), &plan(), 1_000).unwrap();
        // The third start has crossed bounds: there the derivative is that of their mean.
        for (low, high) in [(0.7, 1.2), (0.9, 1.0), (1.2, 0.7)] {
            let p = scaled.parameters();
            let mut theta: Vec<f64> = (0..p).map(|i| 0.1 + 0.01 * i as f64).collect();
            theta[0] = low;
            theta[scaled.b] = high;
            let mut at = Linearisation::zeros(p);
            assert!((&mut &scaled).linearise(&theta, &mut at));
            assert!(at.gradient.iter().filter(|g| g.abs() > 1e-6).count() >= 2 * scaled.b);
            for i in 0..p {
                let shifted = |step: f64| {
                    let mut theta = theta.clone();
                    theta[i] += step;
                    (&mut &scaled).squares(&theta).unwrap()
                };
                let numeric = (shifted(1e-7) - shifted(-1e-7)) / 2e-7;
                let difference = (2.0 * at.gradient[i] - numeric).abs();
                assert!(difference < 1e-5 * (1.0 + numeric.abs()), "{i}: {} {numeric}", 2.0 * at.gradient[i]);
            }
        }
    }

    #[test]
    fn a_noisy_log_gives_its_parameters_back() {
        let log = Log::simulated(6_000, 0.05);
        let cell = fit_cell(&log.data(), &plan()).unwrap();
        let truth = truth();
        let pairs = cell.low.iter().zip(&truth.low).chain(cell.high.iter().zip(&truth.high));
        for (fitted, true_value) in pairs {
            assert!((fitted - true_value).abs() < 0.02, "{cell:?}");
        }
        assert!((cell.kappa[0] - truth.kappa[0]).abs() < 0.02, "{cell:?}");
        for (fitted, true_branch) in cell.branches.iter().zip(&truth.branches) {
            assert!((fitted.fraction - true_branch.fraction).abs() < 0.1, "{cell:?}");
        }
    }

    #[test]
    fn the_fit_steps_as_the_predictor_does() {
        let log = Log::simulated(900, 0.0);
        let scaled = Scaled::new(&log.data(), &plan(), 1_000).unwrap();
        let theta: Vec<f64> = (0..scaled.parameters()).map(|i| if i < 3 { 0.2 } else { 0.3 }).collect();
        let cell = scaled.cell(&theta, &plan());
        let signals = vec![Signal::Input(0), Signal::Input(1)];
        let law = MemoryLaw { signals, cell: Some(cell), cable: None, axis: None, features: vec![] };
        let mut memory = Memory::new(&law);
        let mut simulation = Simulation::new(&scaled, &theta);
        for row in 0..log.far.len() {
            let start = log.first[row].then_some(log.far[row]);
            if start.is_some() {
                memory.reset();
            }
            memory.step_from(&law, 0.02, &log.signals[2 * row..][..2], start);
            let fitted = simulation.step(&scaled, row, false) * scaled.far_scale;
            assert!((memory.cell().state - fitted).abs() < 1e-9, "{row}");
        }
    }

    /// One gain of the first signal; the second opens the band.
    fn narrow() -> CellPlan {
        CellPlan { effects: vec![Effect::Centre, Effect::Width, Effect::Both], ..plan() }
    }

    #[test]
    fn restricted_sensitivities_equal_finite_differences_and_restrictions_hold() {
        let log = Log::simulated(400, 0.1);
        let scaled = Scaled::new(&log.data(), &narrow(), 1_000).unwrap();
        let theta = vec![0.9, 0.2, -0.3, 0.4, 0.1, 0.2, 0.1];
        assert_eq!(scaled.parameters(), theta.len());
        assert_eq!(scaled.restricted(&scaled.expanded(&theta)), theta);
        let mut at = Linearisation::zeros(theta.len());
        assert!((&mut &scaled).linearise(&theta, &mut at));
        for i in 0..theta.len() {
            let shifted = |step: f64| {
                let mut theta = theta.clone();
                theta[i] += step;
                (&mut &scaled).squares(&theta).unwrap()
            };
            let numeric = (shifted(1e-7) - shifted(-1e-7)) / 2e-7;
            assert!((2.0 * at.gradient[i] - numeric).abs() < 1e-5 * (1.0 + numeric.abs()), "{i}");
        }
        let cell = fit_cell(&log.data(), &narrow()).unwrap();
        assert!((cell.low[0] - cell.high[0]).abs() < 1e-12 && (cell.low[1] + cell.high[1]).abs() < 1e-12);
    }

    #[test]
    fn a_released_cell_fits_no_worse_than_the_free_one() {
        let log = Log::simulated(2_000, 0.05);
        let error = |plan: &CellPlan| {
            let cell = fit_cell(&log.data(), plan).unwrap();
            let signals = vec![Signal::Input(0), Signal::Input(1)];
            let law = MemoryLaw { signals, cell: Some(cell), cable: None, axis: None, features: vec![] };
            let mut memory = Memory::new(&law);
            let mut sum = 0.0;
            for row in 0..log.far.len() {
                let start = log.first[row].then(|| {
                    memory.reset();
                    log.far[row]
                });
                memory.step_from(&law, 0.02, &log.signals[2 * row..][..2], start);
                sum += (memory.cell().state - log.far[row]).powi(2);
            }
            sum
        };
        let free = error(&plan());
        assert!(error(&CellPlan { released: true, ..narrow() }) < 1.01 * free);
        assert!(error(&narrow()) > 1.01 * free, "the restricted one cannot");
    }

    #[test]
    fn too_little_to_fit_is_refused_without_a_panic() {
        let log = Log::simulated(1, 0.0);
        assert!(fit_cell(&log.data(), &plan()).is_none());
        let empty = CellPlan { basis: vec![], ..plan() };
        assert!(fit_cell(&Log::simulated(50, 0.0).data(), &empty).is_none());
    }
}
