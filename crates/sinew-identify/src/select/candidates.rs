//! The candidate models of a comparison, made from the roles of the columns and the sampling alone.

use super::axes::{self, axis_plans};
use super::signals::{RoleIndices, SignalSet};
use crate::Error;
use crate::cable::{cable_logs, far_scale};
use crate::conditioning::ConditionedLogs;
use crate::fit::axis::{AxisKind, AxisPlan};
use crate::fit::cell::CellPlan;
use crate::fit::recipe::{FeaturePlan, Learner, Recipe};
use sinew::predictor::{CableColumns, MEMBERS, Signal};

/// A recipe with its description and the physical structure it is built on.
#[derive(Debug, Clone)]
pub(crate) struct CandidateRecipe {
    pub(crate) recipe: Recipe,
    pub(crate) description: String,
    pub(crate) prior: PhysicsPrior,
    /// The candidates whose mean it is, and of each whether it counts inside the training data alone; empty
    /// for a model of its own.
    pub(crate) mean_of: Vec<(String, bool)>,
}

impl CandidateRecipe {
    fn new(recipe: Recipe, description: &str, prior: PhysicsPrior) -> Self {
        Self { recipe, description: description.to_owned(), prior, mean_of: Vec::new() }
    }

    /// Whether it is a moving mass.
    pub(crate) fn is_axis(&self) -> bool {
        self.recipe.name.starts_with(INERTIA)
    }
}

/// The physical structure of a candidate. A later one is chosen only where it is clearly better than all
/// earlier ones.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum PhysicsPrior {
    /// Several laws that are built differently: a single one can be right by chance.
    Mean,
    /// The physics of what the roles describe: the capstan's ratio where two tensions are antagonistic.
    Matched,
    /// Physics on every signal separately although two of them are antagonistic.
    Separate,
    /// Networks or a regression without a physical part, all or some.
    Learned,
    /// A reference for comparison, never chosen.
    Reference,
}

impl PhysicsPrior {
    /// Those that can be chosen, most physics first.
    pub(crate) const CHOICES: [Self; 4] = [Self::Mean, Self::Matched, Self::Separate, Self::Learned];

    /// For reports; completes "models".
    pub(crate) fn describe(self) -> &'static str {
        match self {
            Self::Mean => "that are means of laws built differently",
            Self::Matched => "with the physics of the signals' roles",
            Self::Separate => "with the physics of each signal by itself",
            Self::Learned => "that are learned as a whole or in part",
            Self::Reference => "for reference",
        }
    }
}

/// Radii of the stop operators as fractions of a signal's range.
const RADII: [f64; 3] = [0.02, 0.08, 0.25];

/// Radii of the stops of a motion that show presliding, as fractions of its range.
const AXIS_STOPS: [f64; 3] = [0.0005, 0.005, 0.05];

/// Nodes of a network; eight keep a prediction below 200 ns.
const HIDDEN: usize = 8;

/// Branch widths of a clamp cell with one element.
const RIGID: [f64; 1] = [1.0];

/// Every candidate for these logs.
pub(crate) fn all_candidates(logs: &ConditionedLogs) -> Vec<CandidateRecipe> {
    let roles = RoleIndices::new(&logs.data);
    let separate = SignalSet::separate(logs, &roles);
    let antagonists = SignalSet::antagonists(logs, &roles);
    let prior = if antagonists.is_some() { PhysicsPrior::Separate } else { PhysicsPrior::Matched };
    let family = Family::new(logs, &separate, "", prior);
    let mut candidates = family.with_cells();
    candidates.extend(family.learned());
    if let Some(pair) = &antagonists {
        let pair = Family::new(logs, pair, PAIR, PhysicsPrior::Matched);
        candidates.extend(pair.with_cells());
        candidates.extend(pair.narrow());
    }
    candidates.push(family.plays());
    if has_loops(logs, &roles) {
        candidates.push(family.loops());
    }
    if let Ok((columns, _)) = cable_logs(&logs.data) {
        candidates.extend(family.observers((columns, far_scale(&logs.data)), &roles));
    }
    for plan in axis_plans(logs, &separate, &roles) {
        candidates.extend(family.axes(&plan));
    }
    let means = means(&candidates, &family);
    candidates.extend(means);
    candidates
}

/// Means of candidates that are built differently.
fn means(candidates: &[CandidateRecipe], family: &Family<'_>) -> Vec<CandidateRecipe> {
    let find = |name: &str| candidates.iter().find(|candidate| candidate.recipe.name == name);
    let mut means = Vec::new();
    let mut add = |name: &str, description: &str, prior, mean_of: &[(&str, bool)]| {
        let mut mean = CandidateRecipe::new(family.recipe(name), description, prior);
        mean.mean_of = mean_of.iter().map(|(name, inside)| ((*name).to_owned(), *inside)).collect();
        means.push(mean);
    };
    let (narrow, wide) = (format!("{NARROW}{PAIR}"), format!("cells{PAIR}"));
    if find(&narrow).is_some() {
        let words =
            "mean of `cells-narrow-pair`, `cells-pair` and `plays`: where they differ, none is certain";
        let members = [(narrow.as_str(), false), (&wide, false), (PLAYS_NAME, false)];
        add("mean-cells-plays", words, PhysicsPrior::Mean, &members);
    }
    for (hybrid, network) in [("hybrid", "network"), ("hybrid-slow", "network-slow")] {
        let words = format!("mean of `{hybrid}` and `{network}`");
        let members = [(hybrid, false), (network, false)];
        add(&format!("mean-{hybrid}-network"), &words, PhysicsPrior::Learned, &members);
        if find(LOOP).is_some() {
            let words = format!(
                "mean of `{hybrid}`, `{network}` and `loop` inside the ranges of the logs, `loop` beyond"
            );
            let members = [(hybrid, true), (network, true), (LOOP, false)];
            add(&format!("mean-{hybrid}-network-loop"), &words, PhysicsPrior::Mean, &members);
            let words = format!("mean of `{hybrid}` and `loop` inside the ranges of the logs, `loop` beyond");
            add(&format!("mean-{hybrid}-loop"), &words, PhysicsPrior::Mean, &[(hybrid, true), (LOOP, false)]);
        }
    }
    means
}

/// Trials from which the extremes of a trial say more than which trial it is.
const LOOP_TRIALS: usize = 6;

/// Whether near effort and motion are measured over so many trials that loop coordinates mean something.
fn has_loops(logs: &ConditionedLogs, roles: &RoleIndices) -> bool {
    !roles.efforts.is_empty() && !roles.motions.is_empty() && logs.runs.len() >= LOOP_TRIALS
}

/// Names of the two references that stand beside every comparison.
pub(crate) const CONSTANT: &str = "constant";
pub(crate) const LINEAR: &str = "linear";

/// Appended to names of candidates on the ratio of two antagonistic tensions.
const PAIR: &str = "-pair";

/// Names of candidates that means are made of.
const NARROW: &str = "cells-narrow";
const PLAYS_NAME: &str = "plays";
const LOOP: &str = "loop";

/// Widths of the plays, and radii of the stops beside loop coordinates, as fractions of a signal's range.
const PLAYS: [f64; 10] = [0.02, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.65, 0.8];
pub(crate) const LOOP_RADII: [f64; 4] = [0.02, 0.08, 0.25, 0.5];

/// Name of the axis without networks.
const INERTIA: &str = "inertia";

/// The candidates named, or without a name all but, where no inertia shows, those of an axis. Beside them the
/// constant and the linear regression, as references where they are not named.
///
/// # Errors
/// [`Error::UnknownModel`] for a name that no candidate has, [`Error::Samples`] with the reason where these
/// logs do not allow it.
pub(crate) fn candidates(logs: &ConditionedLogs, names: &[String]) -> Result<Vec<CandidateRecipe>, Error> {
    let all = all_candidates(logs);
    if names.is_empty() {
        let inertia_shows = axes::inertia_shows(logs);
        let compared = |candidate: &CandidateRecipe| !candidate.is_axis() || inertia_shows;
        return Ok(all.into_iter().filter(compared).collect());
    }
    let known: Vec<String> = all.iter().map(|candidate| candidate.recipe.name.clone()).collect();
    if let Some(name) = names.iter().find(|name| !known.contains(name)) {
        let reason =
            not_compared(logs).into_iter().find(|(barred, _)| name.split('-').next() == Some(barred));
        return Err(match reason {
            Some((_, reason)) => {
                Error::samples(format!("candidate model `{name}`"), "logs that allow it", &reason)
            }
            None => Error::UnknownModel { name: name.clone(), known },
        });
    }
    let requested = |candidate: &&CandidateRecipe| names.contains(&candidate.recipe.name);
    let members: Vec<String> = all
        .iter()
        .filter(requested)
        .flat_map(|candidate| candidate.mean_of.iter().map(|(name, _)| name.clone()))
        .collect();
    let beside = all.into_iter().filter_map(|mut candidate| {
        let name = candidate.recipe.name.as_str();
        if names.iter().any(|requested| requested == name) {
            // A constant that was asked for can be chosen.
            let reference = candidate.prior == PhysicsPrior::Reference;
            candidate.prior = if reference { PhysicsPrior::Learned } else { candidate.prior };
            return Some(candidate);
        }
        candidate.prior = PhysicsPrior::Reference;
        let needed = [CONSTANT, LINEAR].contains(&name) || members.iter().any(|member| member == name);
        needed.then_some(candidate)
    });
    Ok(beside.collect())
}

/// Candidates that the roles of these logs do not allow, with the reason in words.
pub(crate) fn not_compared(logs: &ConditionedLogs) -> Vec<(String, String)> {
    let observer = cable_logs(&logs.data).err().map(|reason| ("observer".to_owned(), reason.to_string()));
    let inertia = (!axes::inertia_shows(logs))
        .then(|| (INERTIA.to_owned(), "no part of the far side is explained by a moving mass".to_owned()));
    observer.into_iter().chain(inertia).collect()
}

/// A recipe as candidates are compared: with half the networks, trained for half as long, the ranks stay the
/// same.
pub(crate) fn screening_recipe(recipe: &Recipe) -> Recipe {
    if matches!(recipe.learner, Learner::Linear | Learner::Regression) {
        return recipe.clone();
    }
    if recipe.learner == Learner::Paper {
        return Recipe { rows: 10_000, steps: 40, ..recipe.clone() };
    }
    Recipe { rows: 3000, steps: 25, networks: 4, ..recipe.clone() }
}

/// The recipe of the influence check: a small hybrid, because an outlier log changes a cell alone too little.
pub(crate) fn influence_recipe(logs: &ConditionedLogs) -> Recipe {
    let roles = RoleIndices::new(&logs.data);
    let separate = SignalSet::separate(logs, &roles);
    let hybrid = Family::new(logs, &separate, "", PhysicsPrior::Matched).hybrid();
    Recipe { rows: 1500, steps: 25, hidden: 4, networks: 4, ..hybrid.recipe }
}

/// The recipe by which logs and channels are compared: a regression on plays and low-pass filters, which is
/// fitted in milliseconds, extrapolates, and takes a lag for no shift.
pub(crate) fn comparison_recipe(logs: &ConditionedLogs) -> Recipe {
    let roles = RoleIndices::new(&logs.data);
    let separate = SignalSet::separate(logs, &roles);
    let family = Family::new(logs, &separate, "", PhysicsPrior::Learned);
    let mut recipe = Recipe { rows: 4000, ..family.linear().recipe };
    if let Some(features) = &mut recipe.features {
        features.radii = vec![0.02, 0.05, 0.1, 0.2, 0.35];
        features.taus = family.slow().to_vec();
    }
    recipe
}

/// The recipe of a clamp cell alone.
pub(crate) fn cell_recipe(logs: &ConditionedLogs) -> Recipe {
    let roles = RoleIndices::new(&logs.data);
    let separate = SignalSet::separate(logs, &roles);
    Family::new(logs, &separate, "", PhysicsPrior::Matched).cell_alone("", &RIGID, "").recipe
}

/// Candidates on one set of signals.
struct Family<'a> {
    signals: &'a SignalSet,
    /// Appended to the names.
    suffix: &'static str,
    /// What candidates with a cell are built on.
    prior: PhysicsPrior,
    interval_s: f64,
}

impl<'a> Family<'a> {
    fn new(
        logs: &ConditionedLogs,
        signals: &'a SignalSet,
        suffix: &'static str,
        prior: PhysicsPrior,
    ) -> Self {
        Self { signals, suffix, prior, interval_s: logs.interval_s().max(1e-4) }
    }

    /// Time constants that show the last instants: speeds, in effect.
    fn short(&self) -> [f64; 1] {
        [4.0 * self.interval_s]
    }

    /// Time constants that show the last seconds.
    fn slow(&self) -> [f64; 3] {
        [5.0, 20.0, 80.0].map(|intervals| intervals * self.interval_s)
    }

    /// A recipe without physics and without networks.
    fn recipe(&self, name: &str) -> Recipe {
        Recipe {
            name: format!("{name}{}", self.suffix),
            signals: self.signals.signals.clone(),
            cell: None,
            cable: None,
            axis: None,
            features: None,
            hidden: HIDDEN,
            rows: 5000,
            steps: 50,
            networks: MEMBERS,
            learner: Learner::Ensemble,
        }
    }

    fn cell(&self, branches: &[f64]) -> Option<CellPlan> {
        let SignalSet { basis, elastic, given, .. } = self.signals;
        // With every product of slow and other signals there are many minima: the start is the narrow cell.
        let released = self.suffix == PAIR && !given.is_empty();
        let effects = if released { self.signals.narrow() } else { Vec::new() };
        let (basis, elastic, branches) = (basis.clone(), elastic.clone(), branches.to_vec());
        Some(CellPlan { basis, elastic, branches, effects, released })
    }

    /// A cell whose width alone depends on the slow signals; `None` without them.
    fn narrow(&self) -> Option<CandidateRecipe> {
        let mut plan = self.cell(&CellPlan::DISTRIBUTED).filter(|plan| plan.released)?;
        plan.released = false;
        let description =
            "`cells` with one gain for every value of the given quantities, which change the friction alone";
        let recipe = Recipe { cell: Some(plan), ..self.recipe(NARROW) };
        Some(self.physical(recipe, description))
    }

    /// Regression on plays of many widths, and on their products with the slow signals.
    fn plays(&self) -> CandidateRecipe {
        let features = FeaturePlan {
            signals: self.inputs(),
            radii: PLAYS.to_vec(),
            clamped: true,
            times: self.signals.given.clone(),
            ..FeaturePlan::default()
        };
        let recipe = Recipe {
            features: Some(features),
            learner: Learner::Regression,
            rows: 50_000,
            ..self.recipe(PLAYS_NAME)
        };
        let description = "regression on plays of ten widths (Prandtl-Ishlinskii), and on their products with given quantities";
        CandidateRecipe::new(recipe, description, PhysicsPrior::Learned)
    }

    /// Regression on where in its loop every signal is, and networks on its residual.
    fn loops(&self) -> CandidateRecipe {
        let features = FeaturePlan {
            signals: self.inputs(),
            radii: LOOP_RADII.to_vec(),
            plain: self.signals.given.clone(),
            loops: self.inputs(),
            ..FeaturePlan::default()
        };
        let recipe = Recipe { features: Some(features), learner: Learner::Skeleton, ..self.recipe(LOOP) };
        let description =
            "regression on the extremes of every signal since the trial began, plus gated networks";
        CandidateRecipe::new(recipe, description, PhysicsPrior::Learned)
    }

    /// The inputs that are not slow.
    fn inputs(&self) -> Vec<usize> {
        let given = &self.signals.given;
        let signals = &self.signals.signals;
        let is_input = |k: &usize| matches!(signals[*k], Signal::Input(_)) && !given.contains(k);
        (0..signals.len()).filter(is_input).collect()
    }

    fn features(&self, radii: &[f64], taus: &[f64], plain: &[usize]) -> Option<FeaturePlan> {
        let signals = self.signals.memory.clone();
        Some(FeaturePlan {
            signals,
            plain: plain.to_vec(),
            radii: radii.to_vec(),
            taus: taus.to_vec(),
            ..FeaturePlan::default()
        })
    }

    fn physical(&self, recipe: Recipe, description: &str) -> CandidateRecipe {
        CandidateRecipe::new(recipe, description, self.prior)
    }

    /// A clamp cell alone.
    fn cell_alone(&self, name: &str, branches: &[f64], description: &str) -> CandidateRecipe {
        self.physical(Recipe { cell: self.cell(branches), ..self.recipe(name) }, description)
    }

    /// A clamp cell and networks on stop operators and low-pass differences.
    fn hybrid_with(&self, name: &str, branches: &[f64], taus: &[f64], description: &str) -> CandidateRecipe {
        let (cell, features) = (self.cell(branches), self.features(&RADII, taus, &[]));
        self.physical(Recipe { cell, features, ..self.recipe(name) }, description)
    }

    fn hybrid(&self) -> CandidateRecipe {
        let description = "`cells` plus gated networks on stop operators";
        self.hybrid_with("hybrid", &CellPlan::DISTRIBUTED, &[], description)
    }

    /// Candidates with a clamp cell.
    fn with_cells(&self) -> Vec<CandidateRecipe> {
        let distributed = &CellPlan::DISTRIBUTED;
        let elastic = "elastic clamp cell: friction and stretch with memory, nothing learned";
        let rigid = "`cell` plus gated networks on stop operators";
        let short = "`hybrid` with the changes over the last instants";
        let slow = "`hybrid` with the changes over the last seconds";
        vec![
            self.cell_alone("cell", &RIGID, elastic),
            self.cell_alone(
                "cells",
                distributed,
                "several `cell`s side by side: friction that gives way piece by piece",
            ),
            self.hybrid(),
            self.hybrid_with("hybrid-rigid", &RIGID, &[], rigid),
            self.hybrid_with("hybrid-short", distributed, &self.short(), short),
            self.hybrid_with("hybrid-slow", distributed, &self.slow(), slow),
        ]
    }

    /// Candidates that learn the far side, all or in part, without physics.
    fn learned(&self) -> Vec<CandidateRecipe> {
        let network = "networks on stop operators alone, no physics";
        let network_slow = "`network` with the changes over the last seconds";
        vec![
            self.paper(),
            self.network("network", &[], network),
            self.network("network-slow", &self.slow(), network_slow),
            self.linear(),
            self.constant(),
        ]
    }

    /// Linear regression on the inputs and their differences from low-pass filters: a bank of lags that does
    /// not depend on even sampling.
    fn linear(&self) -> CandidateRecipe {
        let taus = [1.0, 2.0, 4.0, 8.0, 16.0, 32.0].map(|intervals| intervals * self.interval_s);
        let given = &self.signals.given;
        let features = FeaturePlan {
            signals: self.inputs(),
            plain: given.clone(),
            taus: taus.to_vec(),
            ..FeaturePlan::default()
        };
        let recipe = Recipe {
            features: Some(features),
            learner: Learner::Linear,
            rows: 50_000,
            ..self.recipe(LINEAR)
        };
        let description = "linear regression on the signals and their changes over 1 to 32 samples";
        CandidateRecipe::new(recipe, description, PhysicsPrior::Learned)
    }

    /// The mean of the far side.
    fn constant(&self) -> CandidateRecipe {
        let features = FeaturePlan::default();
        let recipe = Recipe { features: Some(features), learner: Learner::Linear, ..self.recipe(CONSTANT) };
        let description = "the mean of the far side, whatever the signals";
        CandidateRecipe::new(recipe, description, PhysicsPrior::Reference)
    }

    /// `yuan2023`, eq. 17: present inputs and the cable's velocity, here as the change over the last
    /// instants.
    fn paper(&self) -> CandidateRecipe {
        let words = "the paper's network: 30 nodes on present values and velocities, no memory, full batch";
        let recipe = Recipe {
            features: self.features(&[], &self.short(), &self.signals.given),
            learner: Learner::Paper,
            hidden: 30,
            rows: 500_000,
            steps: 60,
            ..self.recipe("paper")
        };
        CandidateRecipe::new(recipe, words, PhysicsPrior::Learned)
    }

    fn network(&self, name: &str, taus: &[f64], description: &str) -> CandidateRecipe {
        let features = self.features(&RADII, taus, &self.signals.given);
        let recipe = Recipe { features, ..self.recipe(name) };
        CandidateRecipe::new(recipe, description, PhysicsPrior::Learned)
    }

    /// An axis alone, with networks on its residual, and as a regression.
    fn axes(&self, plan: &AxisPlan) -> Vec<CandidateRecipe> {
        let alone = Recipe { axis: Some(plan.clone()), ..self.recipe(INERTIA) };
        let taus = [2.0, 10.0, 50.0].map(|intervals| intervals * self.interval_s);
        let features = self.features(&RADII, &taus, &self.signals.given);
        let with_networks = Recipe { name: "inertia-network".to_owned(), features, ..alone.clone() };
        let law = "a moving mass with dry and viscous friction and a spring";
        let residual = "`inertia` plus gated networks on stop operators and recent changes";
        let of = |recipe, description| CandidateRecipe::new(recipe, description, PhysicsPrior::Matched);
        let mut axes = vec![of(alone, law), of(with_networks, residual)];
        if plan.kind == AxisKind::Force {
            let features = FeaturePlan {
                signals: self.inputs(),
                radii: AXIS_STOPS.to_vec(),
                rates: plan.motions.clone(),
                plain: self.signals.given.clone(),
                ..FeaturePlan::default()
            };
            let recipe = Recipe {
                features: Some(features),
                learner: Learner::Regression,
                rows: 50_000,
                ..self.recipe("inertia-regression")
            };
            let causal = "regression on the last four rates of every motion, their direction and stops: \
                          inertia and friction, fitted as they are predicted";
            axes.push(of(recipe, causal));
        }
        axes
    }

    /// The cable observer, which reads both displacements, alone and with networks on its residual.
    fn observers(&self, cable: (CableColumns, f64), roles: &RoleIndices) -> [CandidateRecipe; 2] {
        let alone = Recipe { cable: Some(cable), ..self.recipe("observer") };
        let index_of = |input: &usize| {
            let signals = &self.signals.signals;
            signals.iter().position(|signal| *signal == Signal::Input(*input))
        };
        let signals = roles.efforts.iter().chain(&roles.motions).filter_map(index_of).collect();
        let taus = [5.0, 50.0].map(|intervals| intervals * self.interval_s).to_vec();
        let features = FeaturePlan { signals, taus, ..FeaturePlan::default() };
        let name = "observer-network".to_owned();
        let with_networks = Recipe { name, features: Some(features), ..alone.clone() };
        let law = "the cable's own law, driven by both ends' displacements and corrected by the near tension";
        let residual = "`observer` plus gated networks on its residual";
        [(alone, law), (with_networks, residual)]
            .map(|(recipe, description)| CandidateRecipe::new(recipe, description, PhysicsPrior::Matched))
    }
}
