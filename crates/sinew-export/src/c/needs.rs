//! What the code of an estimator needs.

use sinew::predictor::{Estimator, Feature};

/// Whether the state of an estimator or of a member depends on its start.
pub(super) fn has_state(estimator: &Estimator) -> bool {
    estimator.law.has_physics() || estimator.members.iter().any(|member| has_state(&member.estimator))
}

/// Whether an estimator or a member reads the time since the sample before.
pub(super) fn uses_dt(estimator: &Estimator) -> bool {
    let timed = |feature: &Feature| matches!(feature, Feature::LowPassDifference { .. } | Feature::Rate(_));
    let law = &estimator.law;
    let own = law.axis.is_some() || (has_networks(estimator) && law.features.iter().any(timed));
    own || estimator.members.iter().any(|member| uses_dt(&member.estimator))
}

/// Whether the features are read.
pub(super) fn has_networks(estimator: &Estimator) -> bool {
    estimator.ensemble.is_some() || estimator.perceptron.is_some() || estimator.linear.is_some()
}
