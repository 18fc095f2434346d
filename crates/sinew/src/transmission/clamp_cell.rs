use crate::error::{Error, finite};
use alloc::vec::Vec;
use serde::{Deserialize, Serialize};

/// Elastic clamp cell: a state carried along by the near side and held between two moving bounds.
///
/// ```text
/// lo = l . b(x),   hi = h . b(x)
/// s <- clamp(s + kappa . (u - u_prev), lo, hi);     where hi < lo, s = (lo + hi)/2
/// ```
///
/// | symbol | argument       | unit          | domain | meaning                                        |
/// |--------|----------------|---------------|--------|------------------------------------------------|
/// | l      | `low`          | far unit / b  | finite | weights of the lower bound                      |
/// | h      | `high`         | far unit / b  | finite | weights of the upper bound                      |
/// | kappa  | `elasticity`   | far unit / u  | finite | how the state moves between the bounds           |
/// | b(x)   | `basis`        | any           | finite | functions of the near side, one of them 1        |
/// | u - u_prev | `drive_change` | as the signals | finite | change of the near-side signals in this step |
/// | s      | `state`        | far unit      | finite | state and prediction                             |
///
/// One operator covers capstan play (`b = [T, 1]`, `kappa = 0`), backlash (`b = [q, 1]` with equal slopes),
/// an elastic-plastic element (`b = [1]`, `kappa > 0`) and bounds that depend on load or bend.
///
/// # Shapes
/// `low, high, basis: [b]`, `elasticity, drive_change: [u]`; `u` may be 0.
///
/// # Assumes
/// Rate-independent. Until the state first touches a bound it is the caller's guess.
/// A map of signals, not a force: only with constant bounds and `kappa >= 0` on one displacement
/// is it a friction force, and then it is passive.
///
/// # Errors
/// [`Error::WrongLength`] names the slice, [`Error::OutOfDomain`] what is not finite.
///
/// # Example
/// ```
/// use sinew::transmission::ClampCell;
/// // Capstan play: the far tension stays between 0.5 and 2 times the near one.
/// let cell = ClampCell::new(vec![0.5, 0.0], vec![2.0, 0.0], vec![])?;
/// let first = cell.step(10.0, &[8.0, 1.0], &[])?;
/// assert_eq!((first.value, first.touched), (10.0, false));
/// let pulled = cell.step(first.value, &[30.0, 1.0], &[])?;
/// assert_eq!((pulled.value, pulled.touched), (15.0, true));
/// # Ok::<(), sinew::Error>(())
/// ```
///
/// # Source
/// Own combination; its parts are the generalised play of `brokate1996` and the elastic-plastic element of `albender2005`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "WrittenClampCell", into = "WrittenClampCell")]
pub struct ClampCell {
    low: Vec<f64>,
    high: Vec<f64>,
    elasticity: Vec<f64>,
}

/// The cell as a model file holds it.
#[derive(Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct WrittenClampCell {
    low: Vec<f64>,
    high: Vec<f64>,
    elasticity: Vec<f64>,
}

impl TryFrom<WrittenClampCell> for ClampCell {
    type Error = Error;

    fn try_from(written: WrittenClampCell) -> Result<Self, Error> {
        Self::new(written.low, written.high, written.elasticity)
    }
}

impl From<ClampCell> for WrittenClampCell {
    fn from(cell: ClampCell) -> Self {
        Self { low: cell.low, high: cell.high, elasticity: cell.elasticity }
    }
}

/// What a step of [`ClampCell`] leaves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClampStep {
    /// The state to hand to the next step, and the prediction, in the unit of the far side.
    pub value: f64,
    /// Lower bound of this step.
    pub low: f64,
    /// Upper bound of this step.
    pub high: f64,
    /// Whether a bound was touched: from then on the state no longer depends on its start.
    pub touched: bool,
}

impl ClampCell {
    /// A cell of checked weights: `low: [b]`, `high: [b]`, `elasticity: [u]`.
    ///
    /// # Errors
    /// [`Error::WrongLength`] without a basis or with `high` of another length, [`Error::OutOfDomain`]
    /// for a weight that is not finite.
    pub fn new(low: Vec<f64>, high: Vec<f64>, elasticity: Vec<f64>) -> Result<Self, Error> {
        if low.is_empty() {
            return Err(Error::WrongLength { name: "low", expected: 1, got: 0 });
        }
        of_length("high", &high, low.len())?;
        for (name, weights) in [("low", &low), ("high", &high), ("elasticity", &elasticity)] {
            for &weight in weights {
                finite(name, weight)?;
            }
        }
        Ok(Self { low, high, elasticity })
    }

    /// Weights of the lower bound, `[b]`.
    #[must_use]
    pub fn low(&self) -> &[f64] {
        &self.low
    }

    /// Weights of the upper bound, `[b]`.
    #[must_use]
    pub fn high(&self) -> &[f64] {
        &self.high
    }

    /// How the state follows every drive signal between the bounds, `[u]`.
    #[must_use]
    pub fn elasticity(&self) -> &[f64] {
        &self.elasticity
    }

    /// The bounds at a basis: `(lo, hi)`, `hi < lo` where they have crossed.
    ///
    /// # Errors
    /// As [`ClampCell::step`].
    pub fn bounds(&self, basis: &[f64]) -> Result<(f64, f64), Error> {
        of_length("basis", basis, self.low.len())?;
        Ok((finite("lower bound", dot(&self.low, basis))?, finite("upper bound", dot(&self.high, basis))?))
    }

    /// One step; on an error the caller's state is what it was. `basis: [b]`, `drive_change: [u]`.
    ///
    /// # Errors
    /// [`Error::WrongLength`] names the slice, [`Error::OutOfDomain`] the bound or state that is not finite.
    #[inline]
    pub fn step(&self, state: f64, basis: &[f64], drive_change: &[f64]) -> Result<ClampStep, Error> {
        of_length("drive_change", drive_change, self.elasticity.len())?;
        let (low, high) = self.bounds(basis)?;
        let free = finite("state", state + dot(&self.elasticity, drive_change))?;
        let value = clamp_or_mean(free, low, high);
        Ok(ClampStep { value, low, high, touched: !(free > low && free < high) })
    }
}

/// `value` between `low` and `high`; their mean where they have crossed.
#[inline]
#[must_use]
pub fn clamp_or_mean(value: f64, low: f64, high: f64) -> f64 {
    if high < low { 0.5 * (low + high) } else { hold(value, low, high) }
}

/// `value` moved to the nearest of `low <= high` where it is outside: what every law with a dead band does.
#[inline]
#[must_use]
pub fn hold(value: f64, low: f64, high: f64) -> f64 {
    value.max(low).min(high)
}

/// One step of [`ClampCell`] together with the derivative of its state to every parameter.
///
/// ```text
/// theta = [l, h, kappa],   g = ds/dtheta
/// g[kappa] += u - u_prev;   s < lo: g = 0, g[l] = b;   s > hi: g = 0, g[h] = b;
/// hi < lo: g = 0, g[l] = g[h] = b/2
/// ```
///
/// The state is piecewise linear in `theta`, so the recursion is exact wherever the derivative exists.
/// Start with `g = 0`: the first state does not depend on `theta`.
///
/// # Shapes
/// `theta, sensitivity: [2 b + u]`, `basis: [b]`, `drive_change: [u]`. Nothing is allocated.
///
/// # Errors
/// [`Error::WrongLength`] names the slice, [`Error::OutOfDomain`] the state that is not finite; then neither
/// the state nor the sensitivity has moved.
///
/// # Source
/// As [`ClampCell`].
pub fn step_with_sensitivity(
    theta: &[f64],
    state: f64,
    basis: &[f64],
    drive_change: &[f64],
    sensitivity: &mut [f64],
) -> Result<f64, Error> {
    let (bases, drives) = (basis.len(), drive_change.len());
    of_length("theta", theta, 2 * bases + drives)?;
    of_length("sensitivity", sensitivity, 2 * bases + drives)?;
    let (low, high) = (dot(&theta[..bases], basis), dot(&theta[bases..2 * bases], basis));
    let free = state + dot(&theta[2 * bases..], drive_change);
    let value = finite("state", clamp_or_mean(finite("state", free)?, low, high))?;
    // How much of the new state comes from the old one, the lower and the upper bound.
    let (kept, from_low, from_high) = if high < low {
        (false, 0.5, 0.5)
    } else if free < low {
        (false, 1.0, 0.0)
    } else if free > high {
        (false, 0.0, 1.0)
    } else {
        (true, 0.0, 0.0)
    };
    if kept {
        for (g, &change) in sensitivity[2 * bases..].iter_mut().zip(drive_change) {
            *g += change;
        }
    } else {
        sensitivity.fill(0.0);
        for (i, &b) in basis.iter().enumerate() {
            sensitivity[i] = from_low * b;
            sensitivity[bases + i] = from_high * b;
        }
    }
    Ok(value)
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

fn of_length(name: &'static str, slice: &[f64], expected: usize) -> Result<(), Error> {
    if slice.len() == expected {
        Ok(())
    } else {
        Err(Error::WrongLength { name, expected, got: slice.len() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::vec;

    /// State after a path, from `theta`, with and without the recursion.
    fn run(theta: &[f64], path: &[[f64; 2]], g: &mut [f64]) -> (f64, f64) {
        let cell = ClampCell::new(theta[..3].to_vec(), theta[3..6].to_vec(), theta[6..].to_vec()).unwrap();
        let (mut plain, mut with) = (0.3, 0.3);
        let mut last = path[0];
        g.fill(0.0);
        for x in path {
            let basis = [x[0], x[1], 1.0];
            let change = [x[0] - last[0], x[1] - last[1]];
            plain = cell.step(plain, &basis, &change).unwrap().value;
            with = step_with_sensitivity(theta, with, &basis, &change, g).unwrap();
            last = *x;
        }
        (plain, with)
    }

    proptest! {
        #[test]
        fn sensitivities_equal_finite_differences(
            theta in proptest::collection::vec(-1.0..1.0_f64, 8),
            gap in -0.3..1.5_f64,
            path in proptest::collection::vec([-2.0..2.0_f64, -1.0..1.0_f64], 3..30),
        ) {
            // Mostly open bounds, sometimes crossed ones.
            let mut theta = theta;
            theta[5] = theta[2] + gap;
            let (mut g, mut scratch) = (vec![0.0; 8], vec![0.0; 8]);
            let (plain, with) = run(&theta, &path, &mut g);
            prop_assert_eq!(plain.to_bits(), with.to_bits());
            let step = 1e-6;
            for i in 0..8 {
                let mut moved = |by: f64| {
                    let mut other = theta.clone();
                    other[i] += by;
                    run(&other, &path, &mut scratch).0
                };
                let (up, down) = ((moved(step) - plain) / step, (plain - moved(-step)) / step);
                // On a kink the two sides differ and there is no derivative to compare with.
                if (up - down).abs() < 1e-7 {
                    prop_assert!((0.5 * (up + down) - g[i]).abs() < 1e-6, "{i}: {up} {down} {}", g[i]);
                }
            }
        }
    }

    #[test]
    fn crossed_bounds_give_their_mean_and_halve_the_sensitivity() {
        let theta = [2.0, 1.0, 0.7];
        let mut g = [9.0; 3];
        let value = step_with_sensitivity(&theta, 5.0, &[1.0], &[0.1], &mut g).unwrap();
        assert!((value - 1.5).abs() < 1e-15);
        assert_eq!(g.map(f64::to_bits), [0.5, 0.5, 0.0].map(f64::to_bits));
    }

    #[test]
    fn a_bound_that_was_touched_wipes_out_the_start() {
        let cell = ClampCell::new(vec![1.0, -0.2], vec![1.0, 0.2], vec![0.5]).unwrap();
        let end = |start: f64| {
            let (mut state, mut last) = (start, 0.0);
            for q in [3.0, -3.0, 0.5] {
                state = cell.step(state, &[q, 1.0], &[q - last]).unwrap().value;
                last = q;
            }
            state
        };
        assert!((end(-7.0) - end(11.0)).abs() < 1e-15);
    }

    #[test]
    fn wrong_lengths_and_non_finite_numbers_are_refused() {
        let cell = ClampCell::new(vec![1.0, 0.0], vec![1.0, 1.0], vec![0.5]).unwrap();
        assert!(cell.step(0.0, &[1.0], &[0.0]).is_err());
        assert!(cell.step(0.0, &[1.0, 1.0], &[]).is_err());
        assert!(cell.step(0.0, &[f64::NAN, 1.0], &[0.0]).is_err());
        assert!(cell.step(f64::INFINITY, &[1.0, 1.0], &[0.0]).is_err());
        assert!(ClampCell::new(vec![], vec![], vec![]).is_err());
        assert!(ClampCell::new(vec![1.0], vec![f64::NAN], vec![]).is_err());
        let mut g = [0.0; 2];
        assert!(step_with_sensitivity(&[1.0, 2.0, 3.0], 0.0, &[1.0], &[0.0], &mut g).is_err());
    }

    #[test]
    fn a_written_cell_is_checked_when_read() {
        let cell = ClampCell::new(vec![1.0], vec![2.0], vec![0.5]).unwrap();
        let text = serde_json::to_string(&cell).unwrap();
        assert_eq!(serde_json::from_str::<ClampCell>(&text).unwrap(), cell);
        for bad in
            [r#"{"low":[1],"high":[1,2],"elasticity":[]}"#, r#"{"low":[1],"high":[1],"elasticity":[],"x":1}"#]
        {
            assert!(serde_json::from_str::<ClampCell>(bad).is_err());
        }
    }
}
