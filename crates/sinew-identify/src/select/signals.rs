//! Which signals a candidate computes from the inputs, and which functions of them bound its clamp cell.

use crate::conditioning::ConditionedLogs;
use crate::fit::cell::Effect;
use crate::fit::run::Run;
use crate::fit::statistics::quantiles;
use crate::log::Dataset;
use sinew::metrics::Comparison;
use sinew::predictor::{Role, Signal};
use sinew::transmission::BasisTerm;

/// Two efforts are antagonists where their Pearson correlation is below this.
const ANTAGONISTIC: f64 = -0.3;

/// Inputs by role, as indices into [`Roles::inputs`](crate::log::Roles::inputs).
pub(super) struct RoleIndices {
    /// Near-side tensions and torques.
    pub(super) efforts: Vec<usize>,
    /// Positions of the drive and of the anchor.
    pub(super) motions: Vec<usize>,
    /// Slow quantities.
    pub(super) givens: Vec<usize>,
}

impl RoleIndices {
    /// The roles of a dataset.
    pub(super) fn new(data: &Dataset) -> Self {
        let with = |requested: &[Role]| -> Vec<usize> {
            let inputs = data.roles.inputs.iter().enumerate();
            inputs.filter(|(_, input)| requested.contains(&input.role)).map(|(i, _)| i).collect()
        };
        Self {
            efforts: with(&[Role::Effort]),
            motions: with(&[Role::Motion, Role::Anchor]),
            givens: with(&[Role::Given]),
        }
    }
}

/// Signals of a candidate and their uses; every index refers to `signals`.
pub(super) struct SignalSet {
    /// The signals.
    pub(super) signals: Vec<Signal>,
    /// Functions of the signals that bound the clamp cell; the last one is the constant.
    pub(super) basis: Vec<BasisTerm>,
    /// Signals that move the cell's state inside its band.
    pub(super) elastic: Vec<usize>,
    /// Signals that enter the networks with memory operators.
    pub(super) memory: Vec<usize>,
    /// Slow signals.
    pub(super) given: Vec<usize>,
    /// Signals of which a slow one changes the friction but not the gain.
    main: Vec<usize>,
}

impl SignalSet {
    /// Every input by itself; tensions enter the memory operators as their logarithm.
    pub(super) fn separate(logs: &ConditionedLogs, roles: &RoleIndices) -> Self {
        let mut signals: Vec<Signal> =
            roles.motions.iter().chain(&roles.efforts).map(|&input| Signal::Input(input)).collect();
        let main: Vec<usize> = (0..signals.len()).collect();
        let mut memory = main.clone();
        for (place, &input) in roles.efforts.iter().enumerate() {
            if let Some(offset) = log_offset(&logs.runs, input) {
                signals.push(Signal::LogTension { input, offset });
                memory[roles.motions.len() + place] = signals.len() - 1;
            }
        }
        Self::with_givens(signals, &main, &main, memory, &roles.givens)
    }

    /// Two antagonistic tensions: their difference drives the joint, the logarithm of their ratio enters the
    /// capstan equation. `None` unless there are exactly two efforts and they are antagonistic.
    pub(super) fn antagonists(logs: &ConditionedLogs, roles: &RoleIndices) -> Option<Self> {
        let [first, second] = roles.efforts[..] else { return None };
        if correlation(&logs.runs, first, second) > ANTAGONISTIC {
            return None;
        }
        let mut signals: Vec<Signal> = roles.motions.iter().map(|&input| Signal::Input(input)).collect();
        let motions: Vec<usize> = (0..signals.len()).collect();
        signals.push(Signal::Difference(first, second));
        let difference = signals.len() - 1;
        signals.push(Signal::LogRatio { first, second, offset: 1.0 });
        let ratio = signals.len() - 1;
        let main: Vec<usize> = motions.iter().copied().chain([ratio]).collect();
        let memory = motions.iter().copied().chain([difference]).collect();
        Some(Self::with_givens(signals, &main, &motions, memory, &roles.givens))
    }

    /// One gain of every main signal whatever the slow ones, which change the width of the band alone.
    pub(super) fn narrow(&self) -> Vec<Effect> {
        let effect = |term: &BasisTerm| match term {
            BasisTerm::One => Effect::Both,
            BasisTerm::Signal(i) if self.main.contains(i) => Effect::Centre,
            BasisTerm::Signal(_) => Effect::Width,
            BasisTerm::Product(..) => Effect::Neither,
        };
        self.basis.iter().map(effect).collect()
    }

    /// Adds the slow inputs, their products with the main signals, and the constant.
    fn with_givens(
        mut signals: Vec<Signal>,
        main: &[usize],
        elastic: &[usize],
        memory: Vec<usize>,
        givens: &[usize],
    ) -> Self {
        let mut basis: Vec<BasisTerm> = main.iter().map(|&s| BasisTerm::Signal(s)).collect();
        let mut given = Vec::new();
        for &input in givens {
            signals.push(Signal::Input(input));
            let slow = signals.len() - 1;
            given.push(slow);
            basis.push(BasisTerm::Signal(slow));
            basis.extend(main.iter().map(|&s| BasisTerm::Product(s, slow)));
        }
        basis.push(BasisTerm::One);
        Self { signals, basis, elastic: elastic.to_vec(), memory, given, main: main.to_vec() }
    }
}

/// Pearson correlation of two inputs over all runs.
fn correlation(runs: &[Run], first: usize, second: usize) -> f64 {
    let mut comparison = Comparison::new();
    for run in runs {
        for row in run.inputs.chunks_exact(run.width) {
            // Conditioned values are finite: `push` cannot fail.
            let _ = comparison.push(row[first], row[second]);
        }
    }
    comparison.pearson().unwrap_or(0.0)
}

/// The offset of a logarithm, 1.5 % of the range, for an input that is a tension: hardly ever negative.
fn log_offset(runs: &[Run], input: usize) -> Option<f64> {
    let values: Vec<f64> =
        runs.iter().flat_map(|r| r.inputs.iter().skip(input).step_by(r.width)).copied().collect();
    let edge = quantiles(values, &[0.01, 0.99]);
    let range = edge[1] - edge[0];
    (range > 0.0 && edge[0] > -0.02 * range).then_some(0.015 * range)
}
