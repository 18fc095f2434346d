//! The most probable parameters of a machine by what a camera saw, and how well each is determined.

use super::model::{ParameterKind, camera};
use super::place::Place;
use super::places::{Frame, Readings, distance, median, refine_delay};
use super::start::start;
use super::{GeometryError, GeometryModel};
use crate::fit::linear_algebra::{Cholesky, Matrix};
use sinew::body::Pose;

/// Steps with Cauchy's weights, then with Tukey's.
const CAUCHY_STEPS: usize = 7;
const STEPS: usize = 13;
/// Scale of Cauchy's weight, and the bound of Tukey's.
const CAUCHY: f64 = 2.4;
const TUKEY: f64 = 6.0;
/// Median norm of a residual over its standard deviation a coordinate, in space.
const MEDIAN_NORM: f64 = 1.54;
/// Least standard deviation of a place, m.
const FLOOR_M: f64 = 1e-5;
/// Below this fraction of its tolerance a parameter is determined, above the second it is not at all.
pub(super) const DETERMINED: f64 = 0.5;
/// Information of a parameter of which nothing is known before, 1/m^2 or 1/rad^2.
const NOTHING: f64 = 1e-4;

/// A parameter as found.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// Its name, with its unit at the end.
    pub name: String,
    /// Found.
    pub value: f64,
    /// Standard deviation after.
    pub sd: f64,
    /// Before; infinite for nothing known.
    pub tolerance: f64,
    /// Whether the standard deviation is below half of what it was.
    pub determined: bool,
    /// The parameter that it is confounded with most, and their correlation.
    pub confounder: Option<(String, f64)>,
}

/// All parameters as found.
#[derive(Debug, Clone)]
pub struct Estimate {
    /// In the order of the model.
    pub theta: Vec<f64>,
    /// In the same order.
    pub findings: Vec<Finding>,
    /// Covariance in units of the tolerances, row by row.
    covariance: Vec<f64>,
    /// The world in the camera's frame where each of its places was first found.
    first: Vec<Pose>,
    /// Standard deviation of a place in each axis of the camera, m.
    pub noise: [f64; 3],
    /// Points, and those of them with a weight below a tenth: index of the place and of the marker.
    pub points: usize,
    /// See `points`.
    pub outliers: Vec<(usize, usize)>,
}

/// One point: what is missing in the camera's frame, and its derivatives.
struct Row {
    place: usize,
    marker: usize,
    residual: [f64; 3],
    /// In units of the tolerances: `[3][parameters]`.
    slopes: [Vec<f64>; 3],
}

/// Finds the parameters.
///
/// # Errors
/// [`GeometryError::Observations`] where the points cannot be those of this machine.
pub fn estimate(model: &GeometryModel, places: &[Place]) -> Result<Estimate, GeometryError> {
    let n = model.parameters().len();
    let mut theta = vec![0.0; n];
    let first = first_cameras(model, &theta, places)?;
    let unit: Vec<f64> =
        model.parameters().iter().map(|p| if p.tolerance.is_finite() { p.tolerance } else { 1.0 }).collect();
    let prior: Vec<f64> =
        model.parameters().iter().map(|p| if p.tolerance.is_finite() { 1.0 } else { NOTHING }).collect();
    let mut noise = [f64::NAN; 3];
    let mut last = None;
    for step in 0..=STEPS {
        let rows = rows(model, &theta, places, &first, &unit)?;
        let weights = weights(model, &rows, step < CAUCHY_STEPS);
        if step == 0 {
            // The scatter of the markers that are known best.
            let of = |m: usize| scale_of(&rows, m);
            let least =
                (0..model.markers.len()).map(of).filter(|s| s.is_finite()).fold(f64::INFINITY, f64::min);
            noise = [least.max(FLOOR_M); 3];
        }
        let (matrix, right) = normal_equations(&rows, &weights, noise, (&prior, &theta, &unit));
        let failed =
            || GeometryError::Observations("the points do not determine the camera's place".to_owned());
        let factor = Cholesky::new(matrix).ok_or_else(failed)?;
        if step == STEPS {
            last = Some((factor, rows, weights));
            break;
        }
        let change = factor.solve(&right).ok_or_else(failed)?;
        for ((theta, change), unit) in theta.iter_mut().zip(&change).zip(&unit) {
            *theta += unit * change;
        }
        noise = scatter(&rows, &weights, &change, &factor.inverse_diagonal(), &prior);
    }
    let Some((factor, rows, weights)) = last else { unreachable_estimate()? };
    let mut covariance = Vec::with_capacity(n * n);
    for k in 0..n {
        let one: Vec<f64> = (0..n).map(|i| f64::from(u8::from(i == k))).collect();
        covariance.extend(factor.solve(&one).unwrap_or_else(|| vec![f64::NAN; n]));
    }
    let outliers = rows.iter().zip(&weights).filter(|(_, w)| **w < 0.1).map(|(r, _)| (r.place, r.marker));
    Ok(Estimate {
        findings: findings(model, &theta, &covariance, &unit),
        theta,
        covariance,
        first,
        noise,
        points: rows.len(),
        outliers: outliers.collect(),
    })
}

fn unreachable_estimate<T>() -> Result<T, GeometryError> {
    Err(GeometryError::Observations("no step was taken".to_owned()))
}

/// Where the camera stands in each of its places, by the design.
fn first_cameras(model: &GeometryModel, theta: &[f64], places: &[Place]) -> Result<Vec<Pose>, GeometryError> {
    let world = model.world(theta, places)?;
    let seen = places.iter().flat_map(|place| place.seen.iter().map(|seen| (place.epoch, seen)));
    let all: Vec<_> = world.into_iter().zip(seen).collect();
    let epochs = 1 + places.iter().map(|place| place.epoch).max().unwrap_or(0);
    let of = |epoch: usize| {
        let here = all.iter().filter(|(_, (at, _))| *at == epoch);
        let pairs: Vec<_> = here.map(|(x, (_, seen))| (seen.marker, *x, seen.position)).collect();
        start(&pairs)
    };
    (0..epochs).map(of).collect()
}

/// Residuals and derivatives of all points.
fn rows(
    model: &GeometryModel,
    theta: &[f64],
    places: &[Place],
    first: &[Pose],
    unit: &[f64],
) -> Result<Vec<Row>, GeometryError> {
    let world = model.world(theta, places)?;
    let columns = model.derivatives(theta, &world, |theta| model.world(theta, places))?;
    let cameras: Vec<Pose> =
        (0..first.len()).map(|e| camera(&first[e], model.parameters(), theta, e)).collect();
    let scale = 1.0 + model.scale(theta);
    let seen = places.iter().enumerate();
    let seen = seen.flat_map(|(p, place)| place.seen.iter().map(move |seen| (p, place.epoch, seen)));
    let row = |(at, (place, epoch, seen)): (usize, (usize, usize, &super::Seen))| {
        let pose = &cameras[epoch];
        let y = pose.point(world[at]);
        let turn = |v: [f64; 3]| (Pose { origin: [0.0; 3], ..*pose }).point(v);
        let from = turn(world[at]);
        let slope = |(k, parameter): (usize, &super::Parameter)| -> [f64; 3] {
            let raw = match (parameter.kind, &columns[k]) {
                (ParameterKind::Scale, _) => return y.map(|x| unit[k] * x),
                (ParameterKind::CameraTurn(e, axis), _) if e == epoch => {
                    let mut axis_vector = [0.0; 3];
                    axis_vector[axis] = 1.0;
                    cross(axis_vector, from)
                }
                (ParameterKind::CameraPlace(e, axis), _) if e == epoch => {
                    std::array::from_fn(|i| f64::from(u8::from(i == axis)))
                }
                (_, Some(column)) => turn(column[at]),
                _ => [0.0; 3],
            };
            raw.map(|x| scale * unit[k] * x)
        };
        let all: Vec<[f64; 3]> = model.parameters().iter().enumerate().map(slope).collect();
        Row {
            place,
            marker: seen.marker,
            residual: std::array::from_fn(|i| seen.position[i] - scale * y[i]),
            slopes: std::array::from_fn(|i| all.iter().map(|s| s[i]).collect()),
        }
    };
    Ok(seen.enumerate().map(row).collect())
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Robust scale of the residuals of a marker, m.
fn scale_of(rows: &[Row], marker: usize) -> f64 {
    let norms = rows.iter().filter(|row| row.marker == marker).map(|row| distance(row.residual, [0.0; 3]));
    (median(norms) / MEDIAN_NORM).max(FLOOR_M)
}

/// Weight of every point by its residual over the scale of its marker, which is at most three times that
/// of the
/// middle one in the last steps: the first residuals of a marker on the last link are those of the whole
/// machine.
fn weights(model: &GeometryModel, rows: &[Row], early: bool) -> Vec<f64> {
    let mut scales: Vec<f64> = (0..model.markers.len()).map(|m| scale_of(rows, m)).collect();
    if !early {
        let middle = median(scales.iter().copied().filter(|s| s.is_finite()));
        scales.iter_mut().for_each(|s| *s = s.min(3.0 * middle));
    }
    let weight = |row: &Row| {
        let ratio = distance(row.residual, [0.0; 3]) / scales[row.marker];
        if early {
            1.0 / (1.0 + (ratio / CAUCHY).powi(2))
        } else {
            (1.0 - (ratio / TUKEY).powi(2)).max(0.0).powi(2)
        }
    };
    rows.iter().map(weight).collect()
}

/// `J^T W J / s^2 + prior` and `J^T W r / s^2 - prior theta`, in units of the tolerances.
fn normal_equations(
    rows: &[Row],
    weights: &[f64],
    noise: [f64; 3],
    (prior, theta, unit): (&[f64], &[f64], &[f64]),
) -> (Matrix, Vec<f64>) {
    let n = prior.len();
    let stride = Matrix::stride(n);
    let mut matrix = Matrix::zeros(n);
    let mut jacobian = vec![0.0; 3 * rows.len() * stride];
    let mut right: Vec<f64> = (0..n).map(|k| -prior[k] * theta[k] / unit[k]).collect();
    for ((row, weight), lines) in rows.iter().zip(weights).zip(jacobian.chunks_exact_mut(3 * stride)) {
        for ((axis, line), slopes) in lines.chunks_exact_mut(stride).enumerate().zip(&row.slopes) {
            let factor = weight.sqrt() / noise[axis];
            line.iter_mut().zip(slopes).for_each(|(to, slope)| *to = factor * slope);
            let residual = factor * row.residual[axis];
            right.iter_mut().zip(&*line).for_each(|(to, slope)| *to += slope * residual);
        }
    }
    matrix.add_square(&jacobian);
    for (k, prior) in prior.iter().enumerate() {
        matrix[(k, k)] += prior;
    }
    (matrix, right)
}

/// Standard deviation of a place in each axis of the camera after a step, m: of the weighted residuals,
/// for as
/// many as the parameters have left free.
fn scatter(rows: &[Row], weights: &[f64], change: &[f64], variance: &[f64], prior: &[f64]) -> [f64; 3] {
    let used: f64 = variance.iter().zip(prior).map(|(v, prior)| 1.0 - v * prior).sum();
    let total: f64 = weights.iter().sum::<f64>() * 3.0;
    let free = (1.0 - used / total).max(0.1);
    std::array::from_fn(|axis| {
        let square = |(row, weight): (&Row, &f64)| {
            let moved: f64 = row.slopes[axis].iter().zip(change).map(|(s, c)| s * c).sum();
            weight * (row.residual[axis] - moved).powi(2)
        };
        let sum: f64 = rows.iter().zip(weights).map(square).sum();
        (sum / (free * total / 3.0)).sqrt().max(FLOOR_M)
    })
}

fn findings(model: &GeometryModel, theta: &[f64], covariance: &[f64], unit: &[f64]) -> Vec<Finding> {
    let n = theta.len();
    let sd = |k: usize| covariance[k * n + k].sqrt();
    let correlation = |k: usize, i: usize| covariance[k * n + i] / (sd(k) * sd(i));
    let finding = |(k, parameter): (usize, &super::Parameter)| {
        let others = (0..n).filter(|i| *i != k);
        let most = others.max_by(|a, b| correlation(k, *a).abs().total_cmp(&correlation(k, *b).abs()));
        Finding {
            name: parameter.name.clone(),
            value: theta[k],
            sd: unit[k] * sd(k),
            tolerance: parameter.tolerance,
            determined: unit[k] * sd(k) < DETERMINED * parameter.tolerance,
            confounder: most.map(|i| (model.parameters()[i].name.clone(), correlation(k, i))),
        }
    };
    model.parameters().iter().enumerate().map(finding).collect()
}

impl Estimate {
    /// A point in the camera's frame, in one of its places, in the world, m.
    #[must_use]
    pub fn in_world(&self, model: &GeometryModel, epoch: usize, y: [f64; 3]) -> [f64; 3] {
        let pose = self.camera(model, epoch);
        pose.local(y.map(|x| x / (1.0 + model.scale(&self.theta))))
    }

    /// The world in the frame of the camera in one of its places.
    #[must_use]
    pub fn camera(&self, model: &GeometryModel, epoch: usize) -> Pose {
        camera(&self.first[epoch.min(self.first.len() - 1)], model.parameters(), &self.theta, epoch)
    }

    /// Variance of a point with these derivatives, m^2: the trace of `J C J^T`.
    #[must_use]
    pub fn variance(&self, model: &GeometryModel, slopes: &[[f64; 3]]) -> f64 {
        let n = self.theta.len();
        let unit = |k: usize| {
            let tolerance = model.parameters()[k].tolerance;
            if tolerance.is_finite() { tolerance } else { 1.0 }
        };
        let scaled: Vec<[f64; 3]> = (0..n).map(|k| slopes[k].map(|x| x * unit(k))).collect();
        let mut sum = 0.0;
        for i in 0..n {
            for j in 0..n {
                let dot: f64 = (0..3).map(|a| scaled[i][a] * scaled[j][a]).sum();
                sum += self.covariance[i * n + j] * dot;
            }
        }
        sum
    }
}

/// Derivatives of the points of planned places by all parameters, as a camera at the world's origin sees
/// them:
/// `[points][parameters]`.
pub(super) fn planned(
    model: &GeometryModel,
    theta: &[f64],
    places: &[Place],
) -> Result<Vec<Vec<[f64; 3]>>, GeometryError> {
    let ones = vec![1.0; theta.len()];
    let at_origin = [Pose::new([1.0, 0.0, 0.0, 0.0], [0.0; 3])];
    let rows = rows(model, theta, places, &at_origin, &ones)?;
    let slopes = |row: Row| (0..theta.len()).map(|k| std::array::from_fn(|i| row.slopes[i][k])).collect();
    Ok(rows.into_iter().map(slopes).collect())
}

/// What a model misses of a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointError {
    /// Index of the place, and of the marker.
    pub place: usize,
    /// See `place`.
    pub marker: usize,
    /// Distance of the point from where it is expected, m.
    pub error: f64,
    /// Mean of this distance by the uncertainty of parameters and camera, m.
    pub expected: f64,
}

/// Mean norm of a normal error in space over the root of its mean square.
const MEAN_OVER_RMS: f64 = 0.92;
/// Frames from which the delay is found, and the time over which a velocity is the difference, s.
const DELAY_FRAMES: usize = 400;
const VELOCITY_S: f64 = 5e-3;
/// Slowest marker that tells the delay, m/s.
const SLOW: f64 = 0.02;

impl Estimate {
    /// What the calibrated machine misses of the points, or the machine as designed with the same camera
    /// and
    /// markers.
    ///
    /// # Errors
    /// As [`GeometryModel::sensitivity`].
    pub fn errors(
        &self,
        model: &GeometryModel,
        places: &[Place],
        designed: bool,
    ) -> Result<Vec<PointError>, GeometryError> {
        let of_joint = |kind| {
            matches!(
                kind,
                ParameterKind::Offset(..)
                    | ParameterKind::Tilt(..)
                    | ParameterKind::Flex(_)
                    | ParameterKind::Zero(_)
            )
        };
        let parameters = model.parameters().iter().zip(&self.theta);
        let theta: Vec<f64> =
            parameters.map(|(p, value)| if designed && of_joint(p.kind) { 0.0 } else { *value }).collect();
        let ones = vec![1.0; theta.len()];
        let noise: f64 = self.noise.iter().map(|s| s * s).sum();
        let error = |row: Row| {
            let slopes: Vec<[f64; 3]> =
                (0..theta.len()).map(|k| std::array::from_fn(|i| row.slopes[i][k])).collect();
            let expected = MEAN_OVER_RMS * (self.variance(model, &slopes) + noise).sqrt();
            let error = distance(row.residual, [0.0; 3]);
            PointError { place: row.place, marker: row.marker, error, expected }
        };
        Ok(rows(model, &theta, places, &self.first, &ones)?.into_iter().map(error).collect())
    }

    /// Stamps of the frames minus the clock of the readings, s, and its standard deviation, from what
    /// the model
    /// misses of markers that move; infinite where none does.
    ///
    /// # Errors
    /// As [`GeometryModel::sensitivity`].
    pub fn delay(
        &self,
        model: &GeometryModel,
        readings: &Readings,
        frames: &[Frame],
        (delay, places): (f64, &[Place]),
    ) -> Result<(f64, f64), GeometryError> {
        let epoch = |time: f64| places.iter().rev().find(|p| p.time[0] <= time).map_or(0, |p| p.epoch);
        let moving = |m: usize| model.markers[m].body != 0;
        let stride = (frames.len() / DELAY_FRAMES).max(1);
        let at = |shift: f64| -> Result<Vec<[f64; 3]>, GeometryError> {
            let seen = frames.iter().filter(|frame| moving(frame.marker)).step_by(stride);
            let places: Vec<Place> = seen
                .map(|frame| {
                    let time = frame.time - delay;
                    let seen = vec![super::Seen { marker: frame.marker, position: frame.position }];
                    let reading = readings.at(time + shift);
                    Place { time: [time; 2], reading, seen, epoch: epoch(time) }
                })
                .collect();
            let world = model.world(&self.theta, &places)?;
            let scale = 1.0 + model.scale(&self.theta);
            let missed = |(place, x): (&Place, &[f64; 3])| {
                let y = self.camera(model, place.epoch).point(*x);
                std::array::from_fn(|k| place.seen[0].position[k] - scale * y[k])
            };
            Ok(places.iter().zip(&world).map(missed).collect())
        };
        let (before, after) = (at(-0.5 * VELOCITY_S)?, at(0.5 * VELOCITY_S)?);
        let pairs = before.iter().zip(&after).map(|(a, b)| {
            let middle = std::array::from_fn(|k| 0.5 * (a[k] + b[k]));
            (middle, std::array::from_fn(|k| (a[k] - b[k]) / VELOCITY_S))
        });
        let fast: Vec<_> = pairs.filter(|(_, v)| distance(*v, [0.0; 3]) > SLOW).collect();
        if fast.is_empty() {
            return Ok((delay, f64::INFINITY));
        }
        Ok(refine_delay(delay, &fast))
    }
}
