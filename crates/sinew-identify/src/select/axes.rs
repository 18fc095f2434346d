//! Whether a moving mass stands between the two sides.

use super::signals::{RoleIndices, SignalSet};
use crate::conditioning::ConditionedLogs;
use crate::fit::axis::{AxisKind, AxisPlan, fit_axis};
use sinew::predictor::{MemoryLaw, Signal};

/// Units of forces and of positions; a far side in one of them is no motion, or no force.
const FORCES: [&str; 7] = ["N", "kN", "mN", "Nm", "mNm", "Nmm", "Ncm"];
const POSITIONS: [&str; 9] = ["m", "mm", "cm", "um", "rad", "mrad", "deg", "rev", "counts"];

/// The axes that roles and units allow, at most one of each kind.
pub(super) fn axis_plans(logs: &ConditionedLogs, set: &SignalSet, roles: &RoleIndices) -> Vec<AxisPlan> {
    let unit = logs.data.roles.far.as_deref().map_or_else(String::new, |far| logs.data.unit(far));
    let signals_of = |inputs: &[usize]| -> Vec<usize> {
        let place = |input: &usize| set.signals.iter().position(|signal| *signal == Signal::Input(*input));
        inputs.iter().filter_map(place).collect()
    };
    let (motions, efforts) = (signals_of(&roles.motions), signals_of(&roles.efforts));
    let mut plans = Vec::new();
    if !motions.is_empty() && !POSITIONS.contains(&unit.as_str()) {
        plans.push(AxisPlan { kind: AxisKind::Force, motions: motions.clone(), efforts: efforts.clone() });
    } else if motions.is_empty() && !efforts.is_empty() && !FORCES.contains(&unit.as_str()) {
        plans.push(AxisPlan { kind: AxisKind::Motion, motions, efforts });
    }
    plans
}

/// Whether an axis fitted to all logs would be clearly worse without its inertia.
pub(super) fn inertia_shows(logs: &ConditionedLogs) -> bool {
    let roles = RoleIndices::new(&logs.data);
    let set = SignalSet::separate(logs, &roles);
    let law =
        MemoryLaw { signals: set.signals.clone(), cell: None, cable: None, axis: None, features: Vec::new() };
    let shows = |plan: &AxisPlan| fit_axis(&law, &logs.counted(), plan).is_some_and(|fit| fit.inertia_shows);
    axis_plans(logs, &set, &roles).iter().any(shows)
}
