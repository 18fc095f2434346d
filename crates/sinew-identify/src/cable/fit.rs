//! Least squares of the far tension over the numbers of a cable.

use super::log::{CableLog, observe_log, shortened};
use super::quantity::{FittedQuantity, Quantity};
use crate::Error;
use crate::fit::least_squares::{LeastSquares, Options, Solution, linearise, minimise};
use rayon::prelude::*;
use sinew::predictor::{CableEstimate, CableModel, CableObserver, CableObservers, CableSample};

/// Quantities to fit and limits of the search.
#[derive(Debug, Clone)]
pub struct FitOptions {
    /// Which quantities may move; the others stay as the start has them.
    pub free: Vec<Quantity>,
    /// Samples that the observer is run through, at most: longer logs are used in pieces from all of their
    /// length.
    pub samples: usize,
    /// Residuals at most; samples between are run through but not compared.
    pub residuals: usize,
    /// Accepted steps of a search, at most.
    pub steps: usize,
    /// Whether to evaluate a grid around the start and search from its two best points: for starts that are
    /// estimates, not designs.
    pub multistart: bool,
    /// Weight of the near tension's error beside the far one's, 1: without it the near free length is hardly
    /// determined.
    pub near_weight: f64,
}

impl Default for FitOptions {
    fn default() -> Self {
        Self {
            free: Quantity::USUAL.to_vec(),
            samples: 80_000,
            residuals: 4000,
            steps: 30,
            multistart: true,
            near_weight: 0.5,
        }
    }
}

/// A model of a cable with the account of its fit.
#[derive(Debug, Clone)]
pub struct CableFit {
    /// The model, ready for a [`CableObserver`](sinew::predictor::CableObserver).
    pub model: CableModel,
    /// Root mean square error of the far tension where it was compared, N.
    pub rmse: f64,
    /// The same at the start of the search, N.
    pub rmse_start: f64,
    /// Every free quantity with its interval.
    pub quantities: Vec<FittedQuantity>,
    /// Condition number of the scaled normal matrix.
    pub condition: f64,
    /// Samples per independent residual: intervals are widened by its root.
    pub correlation: f64,
    /// Samples that were compared.
    pub compared: usize,
}

/// Fits the observer to logs, from several starts around `start`.
///
/// What is compared is the far tension that the observer estimates as it will run, correction included,
/// against the far sensor, from the first sample at which the observer of the start has determined its state.
/// Sensitivities are central differences.
///
/// # Errors
/// [`Error::Samples`] for lists of different lengths, nothing free, or fewer than 50 samples to compare;
/// [`Error::Physics`] where the start is no cable.
pub fn fit_cable(logs: &[CableLog], start: &CableModel, options: &FitOptions) -> Result<CableFit, Error> {
    fit(logs, start, options, |problem, first, theta| {
        let rmse_start = problem.far_rmse(first).unwrap_or(f64::NAN);
        let found = linearise(problem, theta).ok_or_else(cannot_follow)?;
        problem.summarise(&found, rmse_start)
    })
}

/// The model of [`fit_cable`] without the account of its fit, which takes one more linearisation.
///
/// # Errors
/// As [`fit_cable`].
pub fn fit_cable_model(
    logs: &[CableLog],
    start: &CableModel,
    options: &FitOptions,
) -> Result<CableModel, Error> {
    fit(logs, start, options, |problem, _, theta| problem.fitted(&theta))
}

fn cannot_follow() -> Error {
    Error::samples("start", "a cable that can follow the logs", &"one that cannot")
}

/// Searches, and makes a result of the problem, the first parameters and those found.
fn fit<T>(
    logs: &[CableLog],
    start: &CableModel,
    options: &FitOptions,
    result: impl FnOnce(&Problem<'_>, &[f64], Vec<f64>) -> Result<T, Error>,
) -> Result<T, Error> {
    start.law()?;
    for (place, log) in logs.iter().enumerate() {
        log.check(place)?;
    }
    if options.free.is_empty() {
        return Err(Error::samples("free quantities", "at least one", &0));
    }
    let logs = &shortened(logs, options.samples);
    let rows = rows_to_compare(logs, start, options.residuals)?;
    let problem = Problem { logs, start, options, rows };
    let first: Vec<f64> = options.free.iter().map(|q| q.to_search(q.first(start))).collect();
    let found = problem.search(&first).ok_or_else(cannot_follow)?;
    result(&problem, &first, found)
}

/// Rows `(log, sample)` whose far side counts and whose estimate is no guess, thinned evenly.
fn rows_to_compare(logs: &[CableLog], start: &CableModel, most: usize) -> Result<Vec<(usize, usize)>, Error> {
    let mut rows = Vec::new();
    for (place, log) in logs.iter().enumerate() {
        let estimates = observe_log(start, log)?;
        let known = estimates.iter().zip(&log.weight).enumerate();
        rows.extend(known.filter(|(_, (e, w))| e.known && **w > 0.0).map(|(row, _)| (place, row)));
    }
    let every = rows.len().div_ceil(most.max(1)).max(1);
    let rows: Vec<_> = rows.into_iter().step_by(every).collect();
    if rows.len() < 50 {
        let expected = "at least 50 samples after the whole cable has slid once";
        return Err(Error::samples("logs", expected, &rows.len()));
    }
    Ok(rows)
}

struct Problem<'a> {
    logs: &'a [CableLog],
    start: &'a CableModel,
    options: &'a FitOptions,
    rows: Vec<(usize, usize)>,
}

impl Problem<'_> {
    fn model(&self, theta: &[f64]) -> Option<CableModel> {
        let mut model = self.start.clone();
        for (quantity, theta) in self.options.free.iter().zip(theta) {
            // Beyond a factor of fifty the start was of another cable.
            let home = quantity.to_search(quantity.of(self.start));
            if (theta - home).abs() > 4.0 {
                return None;
            }
            quantity.set(&mut model, quantity.physical_value(*theta))?;
        }
        model.law().ok()?;
        Some(model)
    }

    /// The start itself and its neighbours in friction, drag and stiffness of the free lengths; the best are
    /// followed.
    fn search(&self, theta: &[f64]) -> Option<Vec<f64>> {
        let options = Options { steps: self.options.steps, tolerance: 1e-4 };
        if !self.options.multistart {
            return minimise(self, theta, options).map(|(theta, _)| theta);
        }
        let moved = |friction: f64, drag: f64, free: f64| {
            let factor = |quantity: &Quantity| match quantity {
                Quantity::FrictionAngle => friction,
                Quantity::Drag => drag,
                Quantity::NearLength | Quantity::FarLength => free,
                _ => 1.0,
            };
            theta.iter().zip(&self.options.free).map(|(t, q)| t + factor(q).ln()).collect::<Vec<f64>>()
        };
        let around = [(1.0, 1.0), (0.7, 1.0), (1.4, 1.0), (1.0, 0.4), (1.0, 2.5), (0.7, 2.5), (1.4, 0.4)];
        let points: Vec<_> = [1.0, 0.3, 0.1]
            .iter()
            .flat_map(|free| around.iter().map(move |(friction, drag)| moved(*friction, *drag, *free)))
            .collect();
        let found = self.evaluate_side_by_side(&points);
        let far = |residuals: Vec<f64>| rms(&residuals[..self.rows.len()]);
        let mut starts: Vec<(f64, Vec<f64>)> =
            found.into_iter().zip(points).filter_map(|(found, theta)| Some((far(found?), theta))).collect();
        starts.sort_by(|a, b| a.0.total_cmp(&b.0));
        starts.truncate(2);
        let found = starts.iter().filter_map(|(_, theta)| minimise(self, theta, options));
        found.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(theta, _)| theta)
    }

    /// Stretch while both positions read zero, if it is the same in all logs: within a third of what it
    /// changes by, which is still better than nothing.
    fn zero_stretch(&self, model: &CableModel) -> Result<Option<f64>, Error> {
        let (mut zeros, mut stretches) = (Vec::new(), Vec::new());
        for (place, log) in self.logs.iter().enumerate() {
            let estimates = observe_log(model, log)?;
            for (_, row) in self.rows.iter().filter(|(of, _)| *of == place) {
                let (sample, stretch) = (&log.samples[*row], estimates[*row].stretch);
                let zero = stretch - sample.motor + sample.anchor;
                if zero.is_finite() {
                    zeros.push(zero);
                    stretches.push(stretch);
                }
            }
        }
        let mean = zeros.iter().sum::<f64>() / zeros.len().max(1) as f64;
        let steady = spread(&zeros) < 0.33 * spread(&stretches);
        Ok(Some(mean).filter(|mean| steady && mean.is_finite()))
    }

    fn far_rmse(&self, theta: &[f64]) -> Option<f64> {
        let mut residuals = vec![0.0; self.residuals()];
        self.evaluate(theta, &mut residuals).then(|| rms(&residuals[..self.rows.len()]))
    }

    /// The model of fitted parameters.
    fn fitted(&self, theta: &[f64]) -> Result<CableModel, Error> {
        let numbers = || Error::samples("fit", "numbers of a cable", &"others");
        let mut model = self.model(theta).ok_or_else(numbers)?;
        model.zero_stretch = self.zero_stretch(&model)?;
        Ok(model)
    }

    fn summarise(&self, found: &Solution, rmse_start: f64) -> Result<CableFit, Error> {
        let n = self.rows.len();
        let far = &found.residuals[..n];
        let covariance = found.covariance();
        let correlation = correlation(far);
        let free = (n as f64 / correlation - found.theta.len() as f64).max(1.0) * correlation;
        let spread = (found.squares / free * correlation).sqrt();
        let interval = |(i, quantity): (usize, &Quantity)| {
            let half = 1.96 * spread * covariance.variance[i].sqrt();
            FittedQuantity {
                quantity: *quantity,
                value: quantity.physical_value(found.theta[i]),
                low: quantity.physical_value(found.theta[i] - half),
                high: quantity.physical_value(found.theta[i] + half),
            }
        };
        Ok(CableFit {
            model: self.fitted(&found.theta)?,
            rmse: rms(far),
            rmse_start,
            quantities: self.options.free.iter().enumerate().map(interval).collect(),
            condition: covariance.condition,
            correlation,
            compared: n,
        })
    }
}

/// Models that one pass over the logs serves.
const SIDE_BY_SIDE: usize = 8;

impl Problem<'_> {
    /// Residuals of several models in one pass: errors of the far tension, then those of the near one; `None`
    /// for a model outside of the domain.
    fn evaluate_side_by_side(&self, thetas: &[Vec<f64>]) -> Vec<Option<Vec<f64>>> {
        let models: Vec<Option<CableModel>> = thetas.iter().map(|theta| self.model(theta)).collect();
        let valid: Vec<CableModel> = models.iter().flatten().cloned().collect();
        let mut found = vec![vec![0.0; self.residuals()]; valid.len()];
        if !valid.is_empty() && self.pass(&valid, &mut found).is_err() {
            return vec![None; thetas.len()];
        }
        let mut found = found.into_iter();
        models.into_iter().map(|model| model.and_then(|_| found.next())).collect()
    }

    fn pass(&self, models: &[CableModel], residuals: &mut [Vec<f64>]) -> Result<(), Error> {
        let mut observers = CableObservers::new(models)?;
        let mut estimates = vec![CableEstimate::default(); models.len()];
        let mut samples = vec![CableSample::default(); models.len()];
        self.walk(|first, interval, sample, compared| {
            if first {
                observers.reset();
            }
            samples.fill(*sample);
            observers.step(interval, &samples, &mut estimates)?;
            if let Some(i) = compared {
                for (residuals, estimate) in residuals.iter_mut().zip(&estimates) {
                    self.set_residuals(i, estimate, residuals);
                }
            }
            Ok(())
        })
    }

    /// Visits every sample of the logs: whether it is the first of its log, the interval before it, the
    /// sample, and where it is compared the index of its residual.
    fn walk(
        &self,
        mut visit: impl FnMut(bool, f64, &CableSample, Option<usize>) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let mut rows = self.rows.iter().enumerate().peekable();
        for (place, log) in self.logs.iter().enumerate() {
            for (row, (interval, sample)) in log.interval_s.iter().zip(&log.samples).enumerate() {
                let compared = rows.next_if(|(_, at)| **at == (place, row)).map(|(i, _)| i);
                visit(row == 0, *interval, sample, compared)?;
            }
        }
        Ok(())
    }

    /// Errors of the far and of the near tension where the sample of residual `i` is compared.
    fn set_residuals(&self, i: usize, estimate: &CableEstimate, residuals: &mut [f64]) {
        let (place, row) = self.rows[i];
        residuals[i] = estimate.far - self.logs[place].far[row];
        residuals[self.rows.len() + i] = self.options.near_weight * estimate.innovation;
    }
}

impl LeastSquares for Problem<'_> {
    fn parameters(&self) -> usize {
        self.options.free.len()
    }

    fn residuals(&self) -> usize {
        2 * self.rows.len()
    }

    /// A single observer takes half the time of lanes that are filled with one, to the same bits.
    fn evaluate(&self, theta: &[f64], residuals: &mut [f64]) -> bool {
        let Some(mut observer) = self.model(theta).and_then(|model| CableObserver::new(&model).ok()) else {
            return false;
        };
        self.walk(|first, interval, sample, compared| {
            if first {
                observer.reset();
            }
            let estimate = observer.step(interval, sample);
            if let Some(i) = compared {
                self.set_residuals(i, &estimate, residuals);
            }
            Ok(())
        })
        .is_ok()
    }

    /// Central differences, wide enough to pass over the corners of stick and slip.
    fn slopes(&self, theta: &[f64], residuals: &[f64], jacobian: &mut [f64]) -> bool {
        const STEP: f64 = 5e-3;
        let shifted = |i: usize, by: f64| {
            let mut theta = theta.to_vec();
            theta[i] += by;
            theta
        };
        let points: Vec<_> = (0..theta.len()).flat_map(|i| [shifted(i, STEP), shifted(i, -STEP)]).collect();
        let found: Vec<_> = points
            .par_chunks(SIDE_BY_SIDE)
            .flat_map_iter(|points| self.evaluate_side_by_side(points))
            .collect();
        for (column, pair) in jacobian.chunks_exact_mut(residuals.len().max(1)).zip(found.chunks_exact(2)) {
            // At the edge of the domain the inner side serves.
            let width = STEP * pair.iter().flatten().count() as f64;
            if width <= 0.0 {
                return false;
            }
            let [up, down] = [&pair[0], &pair[1]].map(|found| found.as_deref().unwrap_or(residuals));
            for (slope, (up, down)) in column.iter_mut().zip(up.iter().zip(down)) {
                *slope = (up - down) / width;
            }
        }
        true
    }
}

/// Standard deviation.
fn spread(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    rms(&values.iter().map(|v| v - mean).collect::<Vec<_>>())
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|r| r * r).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

/// `1 + 2 sum_k rho_k` of neighbouring residuals, until `rho_k < 0.05`.
fn correlation(residuals: &[f64]) -> f64 {
    let n = residuals.len();
    let mean = residuals.iter().sum::<f64>() / n as f64;
    let centred: Vec<f64> = residuals.iter().map(|r| r - mean).collect();
    let variance: f64 = centred.iter().map(|r| r * r).sum();
    let mut sum = 1.0;
    for lag in 1..n / 4 {
        let product: f64 = centred.iter().zip(&centred[lag..]).map(|(a, b)| a * b).sum();
        let rho = product / variance;
        // NaN, of residuals that are all the same, ends it too.
        if rho.is_nan() || rho < 0.05 {
            break;
        }
        sum += 2.0 * rho;
    }
    sum
}
