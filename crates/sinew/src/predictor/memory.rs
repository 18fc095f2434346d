//! What the model remembers: the elastic clamp cell, stop operators, low-passes.

use super::cable::{ObservedCable, Watch};
use super::signal::Signal;
use crate::transmission::hold;
use alloc::vec;
use alloc::vec::Vec;
use serde::{Deserialize, Serialize};

/// One factor of the bounds of the clamp cell.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Term {
    /// The constant 1.
    One,
    /// A signal.
    Signal(usize),
    /// The product of two signals.
    Product(usize, usize),
}

impl Term {
    /// Its value, given the signals of one sample.
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

/// The elastic clamp cell: the far end stays where it is until a bound drags it along.
///
/// ```text
/// lo = l . b(x),  hi = h . b(x),  m = (lo + hi) / 2,  w = hi - lo
/// s_j <- clamp(s_j + kappa . (u - u_prev), m - r_j w / 2, m + r_j w / 2),    s = sum_j p_j s_j
/// ```
///
/// One operator covers capstan play (`b = [T, 1]`), backlash (`b = [q, 1]`, equal slopes), elastic friction
/// (`kappa > 0`) and their dependence on load and bend. Several branches `r_j <= 1` with shares `p_j` let the far
/// end follow before all of the friction has given way (generalised Maxwell slip): a loop with round corners.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cell {
    /// The basis `b`.
    pub basis: Vec<Term>,
    /// Coefficients of the lower bound, one per basis term.
    pub low: Vec<f64>,
    /// Coefficients of the upper bound.
    pub high: Vec<f64>,
    /// Which signals move the state inside the band.
    pub elastic: Vec<usize>,
    /// How far they move it, far unit per signal unit.
    pub kappa: Vec<f64>,
    /// Friction that gives way piece by piece; one branch of width 1 and share 1 is a rigid piece.
    pub branches: Vec<Branch>,
    /// Where in its band the state of a new sequence starts, 0 at the lower bound, 1 at the upper: nobody knows, but
    /// logs of one rig often start from the same rest.
    #[serde(default = "middle")]
    pub start: f64,
}

fn middle() -> f64 {
    0.5
}

/// One piece of a friction that gives way piece by piece: the same cell with a narrower band.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Branch {
    /// Width of its band as a fraction of the cell's, in (0, 1].
    pub width: f64,
    /// What its state contributes to the cell's; the shares sum to 1.
    pub share: f64,
}

/// One number handed to the network.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Feature {
    /// A signal as it is.
    Signal(usize),
    /// The stop operator of a signal, in [-1, 1]: where it stands between its last reversals.
    Stop {
        /// Which signal.
        signal: usize,
        /// Half width of the play it is the complement of, signal unit.
        radius: f64,
    },
    /// A signal minus its low-pass: what moved within the last `tau_s` seconds.
    LowPassDifference {
        /// Which signal.
        signal: usize,
        /// Time constant, s.
        tau_s: f64,
    },
    /// State of the cell, far unit.
    CellState,
    /// Width of the cell's band, far unit.
    CellWidth,
    /// Place of the state inside the band, 0 at the lower bound, 1 at the upper.
    CellPosition,
    /// Measured minus believed near tension of the cable's observer, N.
    Innovation,
}

/// How signals, cell and features are computed: the part of a model before its network.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MemoryLaw {
    /// The signals.
    pub signals: Vec<Signal>,
    /// The physics; none in a pure network.
    pub cell: Option<Cell>,
    /// Physics where both ends' displacements are known, in place of the cell.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cable: Option<ObservedCable>,
    /// What the network sees.
    pub features: Vec<Feature>,
}

impl MemoryLaw {
    /// Whether there is physics to lean on.
    #[must_use]
    pub fn has_physics(&self) -> bool {
        self.cell.is_some() || self.cable.is_some()
    }
}

/// The cell, or the cable in its place, as it stands after a sample.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CellOutput {
    /// Its state: the physical prediction of the far end.
    pub state: f64,
    /// Lower bound.
    pub low: f64,
    /// Upper bound.
    pub high: f64,
    /// Whether a bound was touched since the last reset; before, the state is a guess.
    pub known: bool,
}

/// The state of a [`MemoryLaw`] along one sequence.
#[derive(Debug, Clone)]
pub struct Memory {
    signals: Vec<f64>,
    previous: Vec<f64>,
    states: Vec<f64>,
    features: Vec<f64>,
    cell: CellOutput,
    branches: Vec<f64>,
    watch: Option<Watch>,
    started: bool,
}

impl Memory {
    /// A memory that has seen nothing.
    #[must_use]
    pub fn new(law: &MemoryLaw) -> Self {
        Self {
            signals: vec![0.0; law.signals.len()],
            previous: vec![0.0; law.signals.len()],
            states: vec![0.0; law.features.len()],
            features: vec![0.0; law.features.len()],
            cell: CellOutput::default(),
            branches: vec![0.0; law.cell.as_ref().map_or(0, |c| c.branches.len())],
            watch: law.cable.as_ref().and_then(Watch::new),
            started: false,
        }
    }

    /// Forgets everything: the next sample starts a new sequence.
    pub fn reset(&mut self) {
        self.started = false;
    }

    /// Places the cell at a known far-end value, inside its band, before the first sample of a sequence is taken.
    /// Training does this; at run time nobody knows the far end and the cell starts at [`Cell::start`].
    pub fn step_from(&mut self, law: &MemoryLaw, dt_s: f64, inputs: &[f64], far: Option<f64>) {
        for (value, signal) in self.signals.iter_mut().zip(&law.signals) {
            *value = signal.value(inputs);
        }
        if let Some(cell) = &law.cell {
            self.step_cell(cell, far);
        } else if let Some(watch) = &mut self.watch {
            self.cell = watch.step(self.started, dt_s, inputs);
        }
        self.step_features(law, dt_s);
        self.previous.copy_from_slice(&self.signals);
        self.started = true;
    }

    /// Takes one sample, `dt_s` after the one before.
    #[inline]
    pub fn step(&mut self, law: &MemoryLaw, dt_s: f64, inputs: &[f64]) {
        self.step_from(law, dt_s, inputs, None);
    }

    /// The features after the last sample: `[law.features]`.
    #[inline]
    #[must_use]
    pub fn features(&self) -> &[f64] {
        &self.features
    }

    /// The signals of the last sample: `[law.signals]`.
    #[inline]
    #[must_use]
    pub fn signals(&self) -> &[f64] {
        &self.signals
    }

    /// The cell after the last sample; zeros where the law has none.
    #[inline]
    #[must_use]
    pub fn cell(&self) -> CellOutput {
        self.cell
    }

    #[inline]
    fn step_cell(&mut self, cell: &Cell, far: Option<f64>) {
        let (mut low, mut high) = (0.0, 0.0);
        for ((term, l), h) in cell.basis.iter().zip(&cell.low).zip(&cell.high) {
            let b = term.value(&self.signals);
            low += l * b;
            high += h * b;
        }
        if high < low {
            low = 0.5 * (low + high);
            high = low;
        }
        let mut elastic = 0.0;
        for (&signal, kappa) in cell.elastic.iter().zip(&cell.kappa) {
            elastic += kappa * (self.signals[signal] - self.previous[signal]);
        }
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        let mut known = if self.started { self.cell.known } else { far.is_some() };
        let mut state = 0.0;
        for (own, branch) in self.branches.iter_mut().zip(&cell.branches) {
            let (lower, upper) = (middle - branch.width * half, middle + branch.width * half);
            let guess = || lower + cell.start * (upper - lower);
            let moved = if self.started { *own + elastic } else { far.unwrap_or_else(guess) };
            *own = hold(moved, lower, upper);
            // A narrow branch says nothing of the widest one, which touches last.
            known |= branch.width >= 1.0 && (moved < lower || moved > upper);
            state += branch.share * *own;
        }
        self.cell = CellOutput { state, low, high, known };
    }

    #[inline]
    fn step_features(&mut self, law: &MemoryLaw, dt_s: f64) {
        let width = self.cell.high - self.cell.low;
        for ((value, state), feature) in self.features.iter_mut().zip(&mut self.states).zip(&law.features) {
            *value = match *feature {
                Feature::Signal(i) => self.signals[i],
                Feature::Stop { signal, radius } => {
                    let u = self.signals[signal];
                    let play = if self.started { *state } else { u };
                    *state = hold(play, u - radius, u + radius);
                    (u - *state) / radius
                }
                Feature::LowPassDifference { signal, tau_s } => {
                    let u = self.signals[signal];
                    let low_pass = if self.started { *state } else { u };
                    *state = low_pass + (u - low_pass) * dt_s / (dt_s + tau_s);
                    u - *state
                }
                Feature::CellState => self.cell.state,
                Feature::CellWidth => width,
                Feature::Innovation => self.watch.as_ref().map_or(0.0, |watch| watch.innovation),
                Feature::CellPosition => (self.cell.state - self.cell.low) / width.max(1e-12),
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn law(branches: &[(f64, f64)]) -> MemoryLaw {
        let cell = Cell {
            start: 0.5,
            basis: vec![Term::Signal(0), Term::One],
            low: vec![1.0, -1.0],
            high: vec![1.0, 1.0],
            elastic: vec![],
            kappa: vec![],
            branches: branches.iter().map(|&(width, share)| Branch { width, share }).collect(),
        };
        MemoryLaw { signals: vec![Signal::Input(0)], cell: Some(cell), cable: None, features: vec![] }
    }

    fn path(law: &MemoryLaw, inputs: &[f64]) -> Vec<CellOutput> {
        let mut memory = Memory::new(law);
        let mut one = |&u: &f64| {
            memory.step(law, 0.01, &[u]);
            memory.cell()
        };
        inputs.iter().map(&mut one).collect()
    }

    #[test]
    fn one_branch_is_play() {
        let outputs = path(&law(&[(1.0, 1.0)]), &[0.0, 0.5, 3.0, 2.0, 1.5, 0.0]);
        let states: Vec<f64> = outputs.iter().map(|o| o.state).collect();
        for (state, play) in states.iter().zip([0.0, 0.0, 2.0, 2.0, 2.0, 1.0]) {
            assert!((state - play).abs() < 1e-12, "{states:?}");
        }
        assert_eq!(
            outputs.iter().map(|o| o.known).collect::<Vec<_>>(),
            [false, false, true, true, true, true]
        );
    }

    #[test]
    fn narrow_branches_follow_before_the_whole_friction_gives_way() {
        let (rigid, spread) = (law(&[(1.0, 1.0)]), law(&[(1.0, 0.5), (0.5, 0.5)]));
        let mut turned = vec![0.0];
        turned.extend((0..40).map(|i| 5.0 - 0.05 * f64::from(i)));
        let (rigid, spread) = (path(&rigid, &turned), path(&spread, &turned));
        // 1.2 below the reversal the narrow half slides and the wide half sticks.
        assert!(spread[25].state < spread[1].state - 0.05);
        assert!((rigid[25].state - rigid[1].state).abs() < 1e-12);
        assert!(spread.iter().all(|o| o.low - 1e-12 <= o.state && o.state <= o.high + 1e-12));
    }
}
