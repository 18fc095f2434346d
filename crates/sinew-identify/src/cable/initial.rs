//! An initial cable model from logs alone.

use super::fit::{CableFit, FitOptions, fit_cable, fit_cable_model};
use super::log::{CableLog, coarse};
use crate::Error;
use crate::fit::statistics::quantiles;
use sinew::predictor::CableModel;
use sinew::transmission::cable::{CableParameters, CablePath, Segment};

/// Length over which displacements and tensions are compared, s.
const WINDOW_S: f64 = 0.05;

/// Changes over one window.
#[derive(Debug, Clone, Copy)]
pub(super) struct Change {
    pub(super) seconds: f64,
    pub(super) motor: f64,
    pub(super) anchor: f64,
    pub(super) tension_in: f64,
    pub(super) far: f64,
}

/// Every window of a log whose far side counts at both of its ends.
pub(super) fn windows(log: &CableLog, mut visit: impl FnMut(Change)) {
    let (mut from, mut seconds) = (0, 0.0);
    for row in 1..log.len() {
        seconds += log.interval_s[row];
        if seconds < WINDOW_S {
            continue;
        }
        let (a, b) = (&log.samples[from], &log.samples[row]);
        let change = Change {
            seconds,
            motor: b.motor - a.motor,
            anchor: b.anchor - a.anchor,
            tension_in: b.tension_in - a.tension_in,
            far: log.far[row] - log.far[from],
        };
        let whole = change.motor + change.anchor + change.tension_in;
        if log.weight[from] > 0.0 && log.weight[row] > 0.0 && whole.is_finite() {
            visit(change);
        }
        (from, seconds) = (row, 0.0);
    }
}

/// A cable consistent with these logs, from which a fit can start.
///
/// One sheath between two free lengths. Its length is one metre and its bend one turn whatever they really
/// are: a log shows compliances and friction angles, so lengths and curvature are in units of these.
///
/// | number              | from                                                                       |
/// |---------------------|----------------------------------------------------------------------------|
/// | near, far compliance | the steepest changes of each tension with the displacement beside it         |
/// | whole compliance    | spread of the total stretch over that of the mean tension                    |
/// | friction angle      | 90 % quantile of `abs(ln(T_in/T_out))`                                       |
/// | drag                | a twentieth of the mean tension at a high speed                              |
/// | correction          | 47/s times the near compliance: what serves on the calibrated bench           |
///
/// # Errors
/// [`Error::Samples`] where the logs hold fewer than 50 windows of motion, or a tension that never changes.
pub fn initial_cable(logs: &[CableLog]) -> Result<CableModel, Error> {
    let mut seen = Vec::new();
    logs.iter().for_each(|log| windows(log, |change| seen.push(change)));
    let moving = |of: fn(&Change) -> f64| quantiles(seen.iter().map(|c| of(c).abs()).collect(), &[0.5])[0];
    let (motor, anchor) = (moving(|c| c.motor), moving(|c| c.anchor));
    let steepest = |slopes: Vec<f64>| {
        if slopes.len() < 50 {
            let expected = "at least 50 windows of motion in which the tension follows";
            return Err(Error::samples("logs", expected, &slopes.len()));
        }
        Ok(1.0 / quantiles(slopes, &[0.9])[0])
    };
    let rising = |slope: &f64| *slope > 0.0;
    let moved = seen.iter().filter(|c| c.motor.abs() > motor);
    let near = steepest(moved.map(|c| c.tension_in / c.motor).filter(rising).collect())?;
    let moved = seen.iter().filter(|c| c.anchor.abs() > anchor);
    let far = steepest(moved.map(|c| -c.far / c.anchor).filter(rising).collect())?;
    let tensions = Tensions::new(logs)?;
    let whole = tensions.compliance.max(1.5 * (near + far));
    let speed = quantiles(seen.iter().map(|c| (c.motor / c.seconds).abs()).collect(), &[0.9])[0];
    let sheath = whole - near - far;
    let turn = 2.0 * std::f64::consts::PI;
    let path = CablePath::new(vec![
        Segment::Free { length: near / sheath },
        Segment::Sheath { length: 1.0, bend: turn, curvature: vec![] },
        Segment::Free { length: far / sheath },
    ])?;
    let parameters = CableParameters {
        friction: tensions.angle / turn,
        efficiency: 1.0,
        drag: 0.05 * tensions.mean / speed.max(1e-3),
        drag_fade: (0.05 * tensions.mean).max(1e-3),
        pretension: 0.02 * tensions.mean,
        compliance: sheath,
        ..CableParameters::bench()
    };
    let model = CableModel { path, parameters, correction: correction(near), ..CableModel::bench() };
    model.law()?;
    Ok(model)
}

/// Speed of the correction, m/(N s), that serves beside a near compliance, m/N.
fn correction(near: f64) -> f64 {
    (47.0 * near).min(1.0)
}

/// A cable identified from logs alone: searched for from [`initial_cable`] on samples that are farther apart,
/// then fitted with the correction that suits the near compliance that was found, because both shape each
/// other.
///
/// # Errors
/// As [`initial_cable`] and [`fit_cable`].
pub fn identify_cable(logs: &[CableLog], options: &FitOptions) -> Result<CableFit, Error> {
    let initial = initial_cable(logs)?;
    let first = fit_cable_model(&coarse(logs), &initial, options);
    let mut start = first.or_else(|_| fit_cable_model(logs, &initial, options))?;
    if let Some(Segment::Free { length }) = start.path.segments().first() {
        start.correction = correction(length * start.parameters.compliance);
    }
    fit_cable(logs, &start, &FitOptions { multistart: false, ..options.clone() })
}

/// Mean, friction angle and compliance from the tensions and the stretch.
struct Tensions {
    mean: f64,
    angle: f64,
    compliance: f64,
}

impl Tensions {
    fn new(logs: &[CableLog]) -> Result<Self, Error> {
        let (mut means, mut angles, mut squares) = (Vec::new(), Vec::new(), [0.0; 2]);
        for log in logs {
            let rows = log.samples.iter().zip(&log.far).zip(&log.weight).filter(|(_, w)| **w > 0.0);
            let mut stretches = Vec::new();
            let mut levels = Vec::new();
            for ((sample, far), _) in rows {
                let (near, far) = (sample.tension_in.max(0.0), far.max(0.0));
                let stretch = sample.motor - sample.anchor;
                if !(near + stretch).is_finite() {
                    continue;
                }
                means.push(0.5 * (near + far));
                stretches.push(stretch);
                levels.push(0.5 * (near + far));
                if near > 0.0 && far > 0.0 {
                    angles.push((near / far).ln().abs());
                }
            }
            // Each log has its own origin of positions.
            squares[0] += scatter(&stretches);
            squares[1] += scatter(&levels);
        }
        if angles.len() < 50 || squares[1] <= 0.0 || squares[0] <= 0.0 {
            return Err(Error::samples("tensions", "two that change, above zero", &"others"));
        }
        let angle = quantiles(angles, &[0.9])[0].clamp(0.02, 3.0);
        let mean = means.iter().sum::<f64>() / means.len() as f64;
        Ok(Self { mean, angle, compliance: (squares[0] / squares[1]).sqrt() })
    }
}

/// Sum of squared distances from the mean.
fn scatter(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    values.iter().map(|v| (v - mean) * (v - mean)).sum()
}
