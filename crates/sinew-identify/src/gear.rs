//! Losses of a gear from the currents of its motor in both directions.

use crate::Error;
use crate::fit::least_squares::{LeastSquares, Options, solve};
use crate::fit::statistics::student;
use serde::{Deserialize, Serialize};

/// One sample of a gear that turns at a constant speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GearSample {
    /// Torque of the motor less what viscous friction takes, Nm.
    pub torque: f64,
    /// Torque of the load over the ratio, Nm.
    pub load: f64,
    /// Whether the motor drives the load.
    pub driving: bool,
}

/// Losses of a gear.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct GearFit {
    /// Efficiency under a high load, 1.
    pub efficiency: Interval,
    /// Coulomb friction without load, Nm at the motor.
    #[serde(rename = "friction_nm")]
    pub friction: Interval,
}

/// A number with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Interval {
    /// The number.
    pub value: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl Interval {
    /// Of a number that was found and one that is known beforehand within `half`: their mean by the squares
    /// of their widths.
    #[must_use]
    pub fn weighed(self, known: f64, half: f64) -> Self {
        let weight = |half: f64| 1.0 / (half * half).max(f64::MIN_POSITIVE.sqrt());
        let (own, other) = (weight(0.5 * (self.high - self.low)), weight(half));
        let value = (own * self.value + other * known) / (own + other);
        let half = (own + other).powf(-0.5);
        Self { value, low: value - half, high: value + half }
    }
}

/// What the loads of a gear's samples are uncertain by as a whole, 95 %.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LoadError {
    /// Relative, up while the motor drives and down while it is driven, as the friction of a cable.
    pub relative: f64,
    /// Alike in both directions, Nm.
    pub absolute: f64,
}

/// Least strokes in either direction.
const LEAST_STROKES: usize = 2;
/// Normal quantile of 95 %.
const BAND_95: f64 = 1.96;

/// Fits the losses of a gear to strokes in both directions, each at one speed.
///
/// ```text
/// tau = x/eta + tau_c  while the motor drives,     tau = eta x - tau_c  while it is driven
/// ```
///
/// | symbol | meaning                                                  | unit |
/// |--------|----------------------------------------------------------|------|
/// | tau, x | torque of the motor, of the load over the ratio           | Nm   |
/// | eta, tau_c | efficiency, friction without load                     | 1, Nm |
///
/// Samples of one stroke err alike, so that the intervals are of the strokes: each is left out in turn
/// (jackknife). The uncertainty of the loads as a whole, which no stroke shows, is added.
///
/// # Errors
/// [`Error::Samples`] for fewer than two strokes in either direction, or loads that do not differ.
pub fn fit_gear(strokes: &[Vec<GearSample>], load_error: LoadError) -> Result<GearFit, Error> {
    let strokes: Vec<&[GearSample]> = strokes.iter().map(Vec::as_slice).filter(|s| !s.is_empty()).collect();
    let driving = strokes.iter().filter(|stroke| stroke[0].driving).count();
    for (direction, count) in [("driving", driving), ("driven", strokes.len() - driving)] {
        if count < LEAST_STROKES {
            return Err(Error::samples(
                format!("strokes with the motor {direction}"),
                format!("at least {LEAST_STROKES}"),
                &count,
            ));
        }
    }
    let undetermined = || Error::samples("strokes of a gear", "loads that determine its losses", &"others");
    let whole = losses(&strokes).ok_or_else(undetermined)?;
    let left_out = (0..strokes.len()).map(|k| {
        let rest: Vec<&[GearSample]> =
            strokes.iter().enumerate().filter(|(i, _)| *i != k).map(|(_, stroke)| *stroke).collect();
        losses(&rest)
    });
    let left_out: Vec<[f64; 2]> = left_out.collect::<Option<_>>().ok_or_else(undetermined)?;
    let n = strokes.len() as f64;
    let half = |i: usize, of_load: f64| {
        let mean = left_out.iter().map(|found| found[i]).sum::<f64>() / n;
        let squares = left_out.iter().map(|found| (found[i] - mean).powi(2)).sum::<f64>();
        (student(BAND_95, strokes.len() - 1) * ((n - 1.0) / n * squares).sqrt()).hypot(of_load)
    };
    let [log, friction] = whole;
    let width = half(0, load_error.relative);
    let efficiency = (-log).exp();
    let friction_width = half(1, load_error.absolute / efficiency);
    Ok(GearFit {
        efficiency: Interval {
            value: efficiency,
            low: (-log - width).exp(),
            high: (-log + width).exp().min(1.0),
        },
        friction: Interval {
            value: friction,
            low: (friction - friction_width).max(0.0),
            high: friction + friction_width,
        },
    })
}

/// `ln(1/eta)` and `tau_c` of least squares, both held at or above zero.
fn losses(strokes: &[&[GearSample]]) -> Option<[f64; 2]> {
    let problem = Problem { strokes, samples: strokes.iter().map(|stroke| stroke.len()).sum() };
    let found = solve(&problem, &[0.3, 1e-3], Options { steps: 50, tolerance: 1e-10 })?;
    let [log, friction] = [found.theta[0], found.theta[1]];
    (log.is_finite() && friction.is_finite()).then_some([log.max(0.0), friction.max(0.0)])
}

struct Problem<'a> {
    strokes: &'a [&'a [GearSample]],
    samples: usize,
}

impl LeastSquares for Problem<'_> {
    fn parameters(&self) -> usize {
        2
    }

    fn residuals(&self) -> usize {
        self.samples
    }

    fn evaluate(&self, theta: &[f64], residuals: &mut [f64]) -> bool {
        let (inverse, friction) = (theta[0].exp(), theta[1]);
        let samples = self.strokes.iter().copied().flatten();
        for (residual, GearSample { torque, load, driving }) in residuals.iter_mut().zip(samples) {
            let expected = if *driving { load * inverse + friction } else { load / inverse - friction };
            *residual = expected - torque;
        }
        inverse.is_finite()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Strokes of a gear of 0.65 and 4 mNm whose losses differ from stroke to stroke by up to `spread`.
    fn strokes(count: usize, spread: f64) -> Vec<Vec<GearSample>> {
        let stroke = |k: usize| {
            let differs = 1.0 + spread * ((k * 7 % 5) as f64 / 2.0 - 1.0);
            let driving = k.is_multiple_of(2);
            let sample = |i: usize| {
                let load = 0.01 + 0.02 * i as f64 / 50.0;
                let (inverse, friction) = (1.0 + (1.0 / 0.65 - 1.0) * differs, 4e-3 * differs);
                let torque = if driving { load * inverse + friction } else { load / inverse - friction };
                GearSample { torque, load, driving }
            };
            (0..50).map(sample).collect()
        };
        (0..count).map(stroke).collect()
    }

    #[test]
    fn losses_are_found_from_strokes_in_both_directions_and_their_intervals_are_those_of_the_strokes() {
        let exact = fit_gear(&strokes(6, 0.0), LoadError::default()).unwrap();
        assert!((exact.efficiency.value - 0.65).abs() < 1e-6 && (exact.friction.value - 4e-3).abs() < 1e-7);
        assert!(exact.efficiency.high - exact.efficiency.low < 1e-6);
        let spread = fit_gear(&strokes(10, 0.2), LoadError::default()).unwrap();
        let Interval { low, high, .. } = spread.efficiency;
        assert!(low < 0.65 && 0.65 < high && high - low > 0.01, "{spread:?}");
        let loads = LoadError { relative: 0.1, absolute: 1e-3 };
        let wide = fit_gear(&strokes(6, 0.0), loads).unwrap();
        assert!((wide.efficiency.low / 0.65 - (-0.1_f64).exp()).abs() < 1e-6, "{wide:?}");
        assert!((wide.friction.high - 4e-3 - 1e-3 / 0.65).abs() < 1e-6, "{wide:?}");
    }

    #[test]
    fn a_number_that_is_found_exactly_is_kept_and_one_that_is_not_stays_as_known() {
        let found = |half: f64| Interval { value: 2.0, low: 2.0 - half, high: 2.0 + half };
        assert!((found(1e-6).weighed(1.0, 0.1).value - 2.0).abs() < 1e-6);
        assert!((found(1e3).weighed(1.0, 0.1).value - 1.0).abs() < 1e-6);
        let even = found(0.1).weighed(1.0, 0.1);
        assert!(
            (even.value - 1.5).abs() < 1e-12 && (even.high - even.low - 0.2 / 2.0_f64.sqrt()).abs() < 1e-9
        );
    }

    #[test]
    fn strokes_in_one_direction_are_refused() {
        let one_way: Vec<Vec<GearSample>> = strokes(8, 0.0).into_iter().step_by(2).collect();
        let error = fit_gear(&one_way, LoadError::default()).unwrap_err().to_string();
        assert!(error.contains("driven") && error.contains("at least 2"), "{error}");
    }
}
