//! True parameters of the cables, for the observers that identified ones are compared with.

use sinew::predictor::CableModel;
use sinew::transmission::cable::{CablePath, Segment};
use sinew::twin::arm::ArmSpecimen;
use sinew::twin::cable::Specimen;

/// Models with the true parameters of the cables, which no identification can reach. The drag's change with
/// temperature is part of the state, not of the model; the observer adapts to it.
#[must_use]
pub fn oracle_models(specimen: &ArmSpecimen) -> Vec<CableModel> {
    let model = |cable: &Specimen| {
        let mut parameters = cable.parameters;
        parameters.weakening = cable.effects.slow.map(|slow| slow.weakening);
        parameters.sheath_compliance += cable.effects.sheath.map_or(0.0, |sheath| sheath.compliance);
        CableModel { path: true_path(cable), parameters, start: 1.0, ..CableModel::bench() }
    };
    specimen.cables.iter().map(model).collect()
}

/// The path of a cable with the true distribution of its sheaths' curvature.
fn true_path(cable: &Specimen) -> CablePath {
    let mut segments = cable.path.segments().to_vec();
    for segment in &mut segments {
        if let (Segment::Sheath { curvature, .. }, Some(uneven)) = (segment, &cable.effects.curvature) {
            curvature.clone_from(&uneven.parts);
        }
    }
    CablePath::new(segments).unwrap_or_else(|_| cable.path.clone())
}
