use alloc::vec::Vec;
use serde::{Deserialize, Serialize};

/// Elastic clamp cell with branches: the state follows the near side elastically and is held between two
/// bounds.
///
/// ```text
/// lo = l . b(u),   hi = h . b(u),   m = (lo + hi)/2,   w = hi - lo;     where hi < lo: m as before, w = 0
/// z_j <- clamp(z_j + kappa . (u - u_prev), m - r_j w/2, m + r_j w/2),   z = sum_j p_j z_j
/// ```
///
/// | symbol   | field                | unit                | shape, domain | meaning                        |
/// |----------|----------------------|---------------------|---------------|--------------------------------|
/// | u        | `signals` of a step  | of the signals      | `[signals]`   | near-side signals              |
/// | b(u)     | `basis`              | products of signals | `[b]`         | basis of the bounds            |
/// | l, h     | `low`, `high`        | far unit per b      | `[b]`, finite | coefficients of the bounds     |
/// | kappa    | `kappa`, `elastic`   | far unit per signal | `[e]`, finite | elasticity, indices of signals |
/// | r_j, p_j | `branches`           | 1                   | `[branches]`  | relative width, fraction          |
/// | lambda_0 | `start`              | 1                   | [0, 1]        | position in band at the start  |
/// | z        | [`ClampStep::state`] | far unit            |               | state and estimate             |
///
/// One law covers capstan play (`b = [T, 1]`, `kappa = 0`), backlash (`b = [q, 1]`, equal slopes), an
/// elastic-plastic element (`b = [1]`, `kappa > 0`) and bounds that depend on load or bend. Branches with
/// `r_j < 1` yield before the widest one does (generalised Maxwell slip), which rounds the corners of the
/// loop.
///
/// # Assumes
/// Rate-independent. Until a bound of a branch with `r_j = 1` is active the state depends on its start.
/// The cell maps signals to a signal. It is a friction force only with constant bounds, `kappa >= 0` on one
/// displacement and fractions `>= 0`; it is then passive.
///
/// Shapes agree and indices exist in `signals`: [`Model::validate`](crate::predictor::Model::validate) checks
/// both, the step does not. Signals that the constants keep finite give a finite state.
///
/// # Example
/// ```
/// use sinew::transmission::{BasisTerm, Branch, ClampCell};
/// // Capstan play: the far tension stays between 0.5 and 2 times the near one.
/// let cell = ClampCell {
///     basis: vec![BasisTerm::Signal(0)],
///     low: vec![0.5],
///     high: vec![2.0],
///     elastic: vec![],
///     kappa: vec![],
///     branches: vec![Branch { width: 1.0, fraction: 1.0 }],
///     start: 0.5,
/// };
/// let mut states = [0.0];
/// assert_eq!(cell.start(&mut states, &[8.0], Some(10.0)).state, 10.0);
/// let pulled = cell.step(&mut states, &[30.0], &[8.0]);
/// assert_eq!((pulled.state, pulled.slid), (15.0, 1.0)); // the one branch, of full width, slides
/// ```
///
/// # Source
/// Own combination of the generalised play of `brokate1996` and the elastic-plastic elements of
/// `albender2005`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClampCell {
    /// The basis `b`.
    pub basis: Vec<BasisTerm>,
    /// `l`, coefficients of the lower bound: `[b]`.
    pub low: Vec<f64>,
    /// `h`, coefficients of the upper bound: `[b]`.
    pub high: Vec<f64>,
    /// Indices of the signals that move the state between the bounds: `[e]`.
    pub elastic: Vec<usize>,
    /// Change of the state per change of each of them, far unit per signal unit: `[e]`.
    pub kappa: Vec<f64>,
    /// Branches; one of width 1 and fraction 1 is the plain cell.
    pub branches: Vec<Branch>,
    /// Position in the band at which a sequence starts whose far end is not measured: 0 at the lower bound, 1
    /// at the upper. Estimated from the starts of the training sequences.
    #[serde(default = "middle")]
    pub start: f64,
}

fn middle() -> f64 {
    0.5
}

/// One function of the signals in which the bounds of a [`ClampCell`] are linear.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum BasisTerm {
    /// The constant 1.
    One,
    /// A signal.
    Signal(usize),
    /// The product of two signals.
    Product(usize, usize),
}

impl BasisTerm {
    /// Its value at the signals of one sample.
    #[inline]
    #[must_use]
    pub fn value(&self, signals: &[f64]) -> f64 {
        match *self {
            Self::One => 1.0,
            Self::Signal(i) => signals[i],
            Self::Product(i, j) => signals[i] * signals[j],
        }
    }
}

/// One branch of a [`ClampCell`]: the same law with a narrower band around the same middle.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Branch {
    /// `r_j`, width of its band relative to that of the cell, in (0, 1].
    pub width: f64,
    /// `p_j`, its fraction in the state of the cell; the fractions sum to 1.
    #[serde(alias = "share")]
    pub fraction: f64,
}

/// Result of one step of a [`ClampCell`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClampStep {
    /// `z`, the weighted sum of the branches, far unit.
    pub state: f64,
    /// `lo`, far unit; `m` where the bounds cross.
    pub low: f64,
    /// `hi`, far unit; `m` where the bounds cross.
    pub high: f64,
    /// Relative width of the widest branch that is at a bound, 0 where none is: this one and narrower ones no
    /// longer depend on their start.
    pub slid: f64,
}

impl ClampCell {
    /// The band at the signals of one sample.
    #[inline]
    #[must_use]
    pub fn band(&self, signals: &[f64]) -> Band {
        let (mut low, mut high) = (0.0, 0.0);
        for ((term, l), h) in self.basis.iter().zip(&self.low).zip(&self.high) {
            let b = term.value(signals);
            low += l * b;
            high += h * b;
        }
        Band::new(low, high)
    }

    /// First sample of a sequence: every branch starts at `far`, projected onto its band, or at
    /// [`start`](Self::start) where the far end is not measured. `states: [branches]`, `signals: [signals]`.
    #[inline]
    pub fn start(&self, states: &mut [f64], signals: &[f64], far: Option<f64>) -> ClampStep {
        let band = self.band(signals);
        self.project(states, band, |_, branch| far.unwrap_or_else(|| band.at(branch.width, self.start)))
    }

    /// One step from the signals `previous` to `signals`; `states: [branches]`, `signals, previous:
    /// [signals]`.
    #[inline]
    pub fn step(&self, states: &mut [f64], signals: &[f64], previous: &[f64]) -> ClampStep {
        let mut increment = 0.0;
        for (&signal, kappa) in self.elastic.iter().zip(&self.kappa) {
            increment += kappa * (signals[signal] - previous[signal]);
        }
        self.project(states, self.band(signals), |state, _| state + increment)
    }

    #[inline]
    fn project(&self, states: &mut [f64], band: Band, trial: impl Fn(f64, &Branch) -> f64) -> ClampStep {
        let (mut sum, mut slid) = (0.0, 0.0_f64);
        for (state, branch) in states.iter_mut().zip(&self.branches) {
            let (projected, active) = band.project(trial(*state, branch), branch.width);
            *state = projected;
            // A narrower branch reaches its bound first and does not determine the others.
            if active.is_some() && branch.width > slid {
                slid = branch.width;
            }
            sum += branch.fraction * projected;
        }
        ClampStep { state: sum, low: band.low, high: band.high, slid }
    }

    /// Width of the interval in which the state may be, of branches wider than `slid`, the largest
    /// [`ClampStep::slid`] so far; `low` and `high` are those of the last step, far unit.
    #[inline]
    #[must_use]
    pub fn unknown_width(&self, slid: f64, low: f64, high: f64) -> f64 {
        let mut fraction = 0.0;
        for branch in self.branches.iter().filter(|branch| branch.width > slid) {
            fraction += branch.fraction.abs() * branch.width;
        }
        if slid < 1.0 { fraction * (high - low) } else { 0.0 }
    }
}

/// The interval `lo <= z <= hi` of a [`ClampCell`] at one sample, and the projection onto that of a branch.
///
/// ```text
/// lower = n lo + (1 - n) hi,   upper = (1 - n) lo + n hi,   n = (1 + r)/2;   n = 1/2 where hi < lo
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Band {
    low: f64,
    high: f64,
    crossed: bool,
}

/// A bound of a [`Band`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bound {
    /// The lower one.
    Lower,
    /// The upper one.
    Upper,
}

impl Band {
    /// The band between two bounds; bounds that cross are replaced by their mean.
    #[inline]
    #[must_use]
    pub fn new(low: f64, high: f64) -> Self {
        if high < low {
            let mean = 0.5 * (low + high);
            return Self { low: mean, high: mean, crossed: true };
        }
        Self { low, high, crossed: false }
    }

    /// Projects a trial state onto the band of a branch of relative width `width`; the bound that was active,
    /// if any.
    #[inline]
    #[must_use]
    pub fn project(&self, trial: f64, width: f64) -> (f64, Option<Bound>) {
        let (lower, upper) = self.bounds_of(width);
        let active = if trial < lower {
            Some(Bound::Lower)
        } else if trial > upper {
            Some(Bound::Upper)
        } else {
            None
        };
        (saturate(trial, lower, upper), active)
    }

    /// Derivative of a state at an active bound by `lo`; that by `hi` is one less this. A state between the
    /// bounds depends on neither.
    #[inline]
    #[must_use]
    pub fn weight_of_low(&self, active: Bound, width: f64) -> f64 {
        let near = if self.crossed { 0.5 } else { 0.5 * (1.0 + width) };
        match active {
            Bound::Lower => near,
            Bound::Upper => 1.0 - near,
        }
    }

    /// The state at a position in the band of a branch, 0 at its lower bound, 1 at its upper.
    #[inline]
    fn at(&self, width: f64, position: f64) -> f64 {
        let (lower, upper) = self.bounds_of(width);
        lower + position * (upper - lower)
    }

    #[inline]
    fn bounds_of(&self, width: f64) -> (f64, f64) {
        let (middle, half) = (0.5 * (self.low + self.high), 0.5 * (self.high - self.low));
        (middle - width * half, middle + width * half)
    }
}

/// `value` limited to `low <= high`.
#[inline(always)]
#[must_use]
pub fn saturate(value: f64, low: f64, high: f64) -> f64 {
    value.max(low).min(high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec;

    /// Play of radius 1 with the given branches `(r_j, p_j)`.
    fn cell(branches: &[(f64, f64)]) -> ClampCell {
        ClampCell {
            basis: vec![BasisTerm::Signal(0), BasisTerm::One],
            low: vec![1.0, -1.0],
            high: vec![1.0, 1.0],
            elastic: vec![],
            kappa: vec![],
            branches: branches.iter().map(|&(width, fraction)| Branch { width, fraction }).collect(),
            start: 0.5,
        }
    }

    fn along(cell: &ClampCell, path: &[f64], far: Option<f64>) -> Vec<ClampStep> {
        let mut states = vec![0.0; cell.branches.len()];
        let mut steps = vec![cell.start(&mut states, &path[..1], far)];
        steps.extend((1..path.len()).map(|i| cell.step(&mut states, &[path[i]], &[path[i - 1]])));
        steps
    }

    #[test]
    fn one_branch_is_the_play_operator() {
        let steps = along(&cell(&[(1.0, 1.0)]), &[0.0, 0.5, 3.0, 2.0, 1.5, 0.0], None);
        for (step, play) in steps.iter().zip([0.0, 0.0, 2.0, 2.0, 2.0, 1.0]) {
            assert!((step.state - play).abs() < 1e-12, "{steps:?}");
        }
        let active: Vec<bool> = steps.iter().map(|step| step.slid >= 1.0).collect();
        assert_eq!(active, [false, false, true, false, false, true]);
    }

    #[test]
    fn narrow_branches_yield_before_the_widest_does() {
        let (single, spread) = (cell(&[(1.0, 1.0)]), cell(&[(1.0, 0.5), (0.5, 0.5)]));
        let mut path = vec![0.0];
        path.extend((0..40).map(|i| 5.0 - 0.05 * f64::from(i)));
        let (single, spread) = (along(&single, &path, None), along(&spread, &path, None));
        // 1.2 below the reversal the narrow branch slides and the wide one sticks.
        assert!(spread[25].state < spread[1].state - 0.05);
        assert!((single[25].state - single[1].state).abs() < 1e-12);
        assert!(spread.iter().all(|step| step.low - 1e-12 <= step.state && step.state <= step.high + 1e-12));
    }

    #[test]
    fn only_branches_that_have_not_slid_are_unknown() {
        let spread = cell(&[(1.0, 0.4), (0.5, 0.6)]);
        assert!((spread.unknown_width(0.0, -1.0, 1.0) - 1.4).abs() < 1e-12);
        // From 0 to 0.8 the branch of half the width slides, the other one does not.
        let steps = along(&spread, &[0.0, 0.8, 0.8, 3.0], None);
        let slid: Vec<f64> = steps.iter().map(|step| step.slid).collect();
        assert!(slid.iter().zip([0.0, 0.5, 0.0, 1.0]).all(|(a, b)| (a - b).abs() < 1e-15), "{slid:?}");
        assert!((spread.unknown_width(0.5, -0.2, 1.8) - 0.8).abs() < 1e-12);
        assert!(spread.unknown_width(1.0, 2.0, 4.0).abs() < 1e-15);
    }

    #[test]
    fn an_active_bound_removes_the_dependence_on_the_start() {
        let mut cell = cell(&[(1.0, 1.0)]);
        (cell.elastic, cell.kappa) = (vec![0], vec![0.5]);
        let end = |far: f64| along(&cell, &[0.0, 3.0, -3.0, 0.5], Some(far))[3].state;
        assert!((end(-7.0) - end(11.0)).abs() < 1e-15);
    }

    #[test]
    fn crossed_bounds_give_their_mean_and_share_its_derivative() {
        let band = Band::new(2.0, 1.0);
        for (trial, bound) in [(5.0, Bound::Upper), (-5.0, Bound::Lower)] {
            let (state, active) = band.project(trial, 0.7);
            assert!((state - 1.5).abs() < 1e-15);
            assert_eq!(active, Some(bound));
            assert!((band.weight_of_low(bound, 0.7) - 0.5).abs() < 1e-15);
        }
    }

    #[test]
    fn the_weight_of_a_bound_is_its_derivative() {
        for (low, high, width) in [(-1.0, 2.0, 1.0), (0.3, 0.9, 0.5), (2.0, 1.0, 0.8)] {
            for (trial, bound) in [(9.0, Bound::Upper), (-9.0, Bound::Lower)] {
                let at = |low: f64, high: f64| Band::new(low, high).project(trial, width).0;
                let by_low = (at(low + 1e-6, high) - at(low - 1e-6, high)) / 2e-6;
                let by_high = (at(low, high + 1e-6) - at(low, high - 1e-6)) / 2e-6;
                let weight = Band::new(low, high).weight_of_low(bound, width);
                assert!((by_low - weight).abs() < 1e-8 && (by_high - 1.0 + weight).abs() < 1e-8);
            }
        }
    }

    #[test]
    fn the_state_moves_by_its_elasticity_times_the_change_of_the_signals_and_bounds_are_bilinear() {
        let cell = ClampCell {
            basis: vec![BasisTerm::Product(0, 1), BasisTerm::One],
            low: vec![0.0, -100.0],
            high: vec![2.0, 0.0],
            elastic: vec![1, 0],
            kappa: vec![0.5, -2.0],
            ..cell(&[(1.0, 1.0)])
        };
        let mut states = [0.0];
        cell.start(&mut states, &[3.0, 7.0], Some(1.0));
        let step = cell.step(&mut states, &[2.5, 11.0], &[3.0, 7.0]);
        assert!((step.state - (1.0 + 0.5 * 4.0 + 2.0 * 0.5)).abs() < 1e-12, "{step:?}");
        assert!((step.high - 2.0 * 2.5 * 11.0).abs() < 1e-12 && (step.low + 100.0).abs() < 1e-12);
    }

    #[test]
    fn a_cell_written_without_its_start_begins_in_the_middle_of_its_band() {
        let text = r#"{"basis": ["one"], "low": [2.0], "high": [5.0], "elastic": [], "kappa": [],
            "branches": [{"width": 1.0, "fraction": 1.0}]}"#;
        let cell: ClampCell = serde_json::from_str(text).unwrap();
        assert!((cell.start(&mut [0.0], &[], None).state - 3.5).abs() < 1e-15);
    }
}
