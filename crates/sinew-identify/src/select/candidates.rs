//! The members that are tried, made from the roles of the columns and the sampling alone.

use crate::cable::cable_logs;
use crate::fit::cell::CellPlan;
use crate::fit::recipe::{FeaturePlan, Learner, Recipe};
use crate::fit::run::Run;
use crate::log::Dataset;
use sinew::metrics::Comparison;
use sinew::predictor::{CableColumns, MEMBERS, Role, Signal};
use sinew::transmission::BasisTerm;

/// A recipe with its words.
#[derive(Debug, Clone)]
pub(crate) struct CandidateRecipe {
    pub(crate) recipe: Recipe,
    pub(crate) description: String,
    /// How much it must prove: a later prior is believed only where it is clearly better than every earlier one.
    pub(crate) prior: PhysicsPrior,
}

/// What a member stands on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum PhysicsPrior {
    /// The physics of what the roles describe: the capstan's ratio where two cables pull against each other.
    Physics,
    /// Physics that takes every signal for itself although two belong together.
    Loose,
    /// Networks that work without physics, all or some.
    Learned,
}

impl PhysicsPrior {
    pub(crate) const ALL: [Self; 3] = [Self::Physics, Self::Loose, Self::Learned];
}

/// Radii of the stop operators as fractions of a signal's range.
const RADII: [f64; 3] = [0.02, 0.08, 0.25];

/// Everything that is tried on these logs.
pub(crate) fn candidates(data: &Dataset, runs: &[Run]) -> Vec<CandidateRecipe> {
    let roles = Indices::of(data);
    let mut entries = Vec::new();
    let interval = data.logs.iter().map(|l| l.interval_s).fold(0.0, f64::max).max(1e-4);
    let rows: usize = runs.iter().map(Run::len).sum();
    let plentiful = rows > 20_000;
    let plain = Layout::plain(&roles, runs);
    let mut layouts = vec![("", plain)];
    let pair = Layout::pair(&roles, runs);
    let physics_of_plain = if pair.is_some() { PhysicsPrior::Loose } else { PhysicsPrior::Physics };
    layouts.extend(pair.map(|pair| ("-pair", pair)));
    let correlation = if plentiful {
        50.0
    } else if roles.efforts.len() == 2 {
        20.0
    } else {
        5.0
    };
    // More nodes pay where data are plentiful; eight keep a prediction below 200 ns.
    let hidden = if plentiful { 8 } else { 6 };
    let short = vec![4.0 * interval];
    let slow = vec![5.0 * interval, 20.0 * interval, 80.0 * interval];
    for (suffix, layout) in &layouts {
        let make = |name: &str,
                    cell: Option<&[f64]>,
                    features: Option<(&[f64], &[f64])>,
                    description: &str| CandidateRecipe {
            recipe: Recipe {
                name: format!("{name}{suffix}"),
                signals: layout.signals.clone(),
                cell: cell.map(|branches| CellPlan {
                    basis: layout.basis.clone(),
                    elastic: layout.elastic.clone(),
                    branches: branches.to_vec(),
                }),
                cable: None,
                features: features.map(|(radii, taus)| FeaturePlan {
                    signals: layout.memory.clone(),
                    plain: if cell.is_some() { Vec::new() } else { layout.given.clone() },
                    radii: radii.to_vec(),
                    taus: taus.to_vec(),
                }),
                hidden,
                correlation,
                rows: 5000,
                steps: 50,
                networks: MEMBERS,
                learner: Learner::Ensemble,
                rounds: 0,
            },
            description: description.to_string(),
            prior: match cell {
                None => PhysicsPrior::Learned,
                Some(_) if suffix.is_empty() => physics_of_plain,
                Some(_) => PhysicsPrior::Physics,
            },
        };
        let rigid: &[f64] = &[1.0];
        let yielding: &[f64] = &CellPlan::DISTRIBUTED;
        entries.push(make(
            "cell",
            Some(rigid),
            None,
            "elastic clamp cell: friction and stretch with memory, nothing learned",
        ));
        entries.push(make(
            "cells",
            Some(yielding),
            None,
            "the same, with friction that gives way piece by piece",
        ));
        entries.push(make(
            "hybrid",
            Some(yielding),
            Some((&RADII, &[])),
            "clamp cells plus gated networks on stop operators",
        ));
        entries.push(make(
            "hybrid-rigid",
            Some(rigid),
            Some((&RADII, &[])),
            "one rigid clamp cell plus gated networks on stop operators",
        ));
        entries.push(make(
            "hybrid-short",
            Some(yielding),
            Some((&RADII, &short)),
            "hybrid that also sees what moved in the last instants",
        ));
        entries.push(make(
            "hybrid-slow",
            Some(yielding),
            Some((&RADII, &slow)),
            "hybrid that also sees what moved in the last seconds",
        ));
        // Where data are plentiful the networks carry the model, and turns only cost time.
        let turns = [
            ("joint", &[][..], "hybrid whose cell and networks were fitted to each other in turns"),
            ("joint-short", &short, "the same, also seeing what moved in the last instants"),
        ];
        for (name, taus, words) in turns.into_iter().filter(|_| !plentiful) {
            let mut joint = make(name, Some(yielding), Some((&RADII, taus)), words);
            joint.recipe.rounds = 2;
            entries.push(joint);
        }
        if suffix.is_empty() {
            // Eq. 17: present inputs and the cable's velocity, here as what moved in the last instants.
            let words =
                "the paper's network: 30 nodes on present values and velocities, no memory, full batch";
            let mut paper = make("paper", None, Some((&[], &short)), words);
            let (hidden, rows, steps) = (30, 500_000, 60);
            paper.recipe = Recipe { learner: Learner::Paper, hidden, rows, steps, ..paper.recipe };
            entries.push(paper);
            for (name, taus) in [("mixed", &[][..]), ("mixed-slow", &slow)] {
                let words = "hybrids and networks without physics side by side";
                let mut mixed = make(name, Some(yielding), Some((&RADII, taus)), words);
                mixed.recipe.learner = Learner::Mixed;
                mixed.prior = PhysicsPrior::Learned;
                entries.push(mixed);
            }
            entries.push(make(
                "network",
                None,
                Some((&RADII, &[])),
                "networks on stop operators alone, no physics",
            ));
            entries.push(make(
                "network-slow",
                None,
                Some((&RADII, &slow)),
                "the same, with what moved in the last seconds",
            ));
        }
    }
    if let Ok((columns, _)) = cable_logs(data) {
        entries.extend(observers(&entries[0], columns, &roles, interval));
    }
    entries
}

/// Members that observe the cable at both of its ends.
fn observers(
    like: &CandidateRecipe,
    columns: CableColumns,
    roles: &Indices,
    interval: f64,
) -> [CandidateRecipe; 2] {
    let alone = Recipe {
        name: "observer".into(),
        cell: None,
        cable: Some(columns),
        features: None,
        ..like.recipe.clone()
    };
    // Tension, both displacements and what moved in the last instants: speeds, in effect.
    let seen = |input: &usize| like.recipe.signals.iter().position(|s| *s == Signal::Input(*input));
    let signals = roles.efforts.iter().chain(&roles.motions).filter_map(seen).collect();
    let taus = vec![5.0 * interval, 50.0 * interval];
    let with_networks = Recipe {
        name: "observer-network".into(),
        features: Some(FeaturePlan { signals, plain: Vec::new(), radii: Vec::new(), taus }),
        ..alone.clone()
    };
    let entry = |recipe, words: &str| CandidateRecipe {
        recipe,
        description: words.to_string(),
        prior: PhysicsPrior::Physics,
    };
    [
        entry(
            alone,
            "the cable's own law, driven by both ends' displacements and corrected by the near tension",
        ),
        entry(with_networks, "the same plus gated networks on what it leaves over"),
    ]
}

struct Indices {
    efforts: Vec<usize>,
    motions: Vec<usize>,
    givens: Vec<usize>,
}

impl Indices {
    fn of(data: &Dataset) -> Self {
        let with = |wanted: &[Role]| -> Vec<usize> {
            let inputs = data.roles.inputs.iter().enumerate();
            inputs.filter(|(_, input)| wanted.contains(&input.role)).map(|(i, _)| i).collect()
        };
        Self {
            efforts: with(&[Role::Effort]),
            motions: with(&[Role::Motion, Role::Anchor]),
            givens: with(&[Role::Given]),
        }
    }
}

/// Signals and what is made of them.
struct Layout {
    signals: Vec<Signal>,
    basis: Vec<BasisTerm>,
    elastic: Vec<usize>,
    memory: Vec<usize>,
    given: Vec<usize>,
}

impl Layout {
    /// Every input by itself; tensions that never push get a logarithm for their memory.
    fn plain(roles: &Indices, runs: &[Run]) -> Self {
        let mut signals = Vec::new();
        let mut main = Vec::new();
        let mut memory = Vec::new();
        for &i in roles.motions.iter().chain(&roles.efforts) {
            signals.push(Signal::Input(i));
            main.push(signals.len() - 1);
            memory.push(signals.len() - 1);
        }
        for (place, &i) in roles.efforts.iter().enumerate() {
            if let Some(offset) = log_offset(runs, i) {
                signals.push(Signal::LogTension { input: i, offset });
                memory[roles.motions.len() + place] = signals.len() - 1;
            }
        }
        Self::finish(signals, &main, &main, memory, &roles.givens)
    }

    /// Two antagonists: their difference turns the joint, the logarithm of their ratio is the capstan's.
    fn pair(roles: &Indices, runs: &[Run]) -> Option<Self> {
        let [first, second] = roles.efforts[..] else { return None };
        if correlation(runs, first, second) > OPPOSED {
            return None;
        }
        let mut signals: Vec<Signal> = roles.motions.iter().map(|&i| Signal::Input(i)).collect();
        let motions: Vec<usize> = (0..signals.len()).collect();
        signals.push(Signal::Difference(first, second));
        let difference = signals.len() - 1;
        signals.push(Signal::LogRatio { first, second, offset: 1.0 });
        let ratio = signals.len() - 1;
        let main: Vec<usize> = motions.iter().copied().chain([ratio]).collect();
        let memory = motions.iter().copied().chain([difference]).collect();
        Some(Self::finish(signals, &main, &motions, memory, &roles.givens))
    }

    fn finish(
        mut signals: Vec<Signal>,
        main: &[usize],
        elastic: &[usize],
        memory: Vec<usize>,
        givens: &[usize],
    ) -> Self {
        let mut basis: Vec<BasisTerm> = main.iter().map(|&s| BasisTerm::Signal(s)).collect();
        let mut given = Vec::new();
        for &g in givens {
            signals.push(Signal::Input(g));
            let g = signals.len() - 1;
            given.push(g);
            basis.push(BasisTerm::Signal(g));
            basis.extend(main.iter().map(|&s| BasisTerm::Product(s, g)));
        }
        basis.push(BasisTerm::One);
        Self { signals, basis, elastic: elastic.to_vec(), memory, given }
    }
}

/// Two efforts pull against each other where their correlation is below this.
const OPPOSED: f64 = -0.3;

/// Pearson correlation of two inputs over all runs.
fn correlation(runs: &[Run], first: usize, second: usize) -> f64 {
    let mut comparison = Comparison::new();
    for run in runs {
        for row in run.inputs.chunks_exact(run.width) {
            // A run holds nothing that is not finite.
            let _ = comparison.push(row[first], row[second]);
        }
    }
    comparison.pearson().unwrap_or(0.0)
}

/// The offset of a logarithm, 1.5 % of the range, for an input that is a tension: hardly ever negative.
fn log_offset(runs: &[Run], input: usize) -> Option<f64> {
    let values: Vec<f64> =
        runs.iter().flat_map(|r| r.inputs.iter().skip(input).step_by(r.width)).copied().collect();
    let edge = crate::fit::statistics::quantiles(values, &[0.01, 0.99]);
    let range = edge[1] - edge[0];
    (range > 0.0 && edge[0] > -0.02 * range).then_some(0.015 * range)
}
