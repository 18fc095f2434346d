//! True parameters and states of the cables, for the oracle that observers are compared with.

use sinew::control::arm::GroundTruth;
use sinew::predictor::CableModel;
use sinew::transmission::cable::{CablePath, Segment};
use sinew::twin::arm::{ArmSpecimen, ArmTwin};
use sinew::twin::cable::Specimen;

/// Models with the true parameters of the cables, which no identification can reach. The drag's change with
/// temperature is part of the state, not of the model.
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

/// Buffers of the true states of all cables: `[muscles]` each.
#[derive(Debug, Clone)]
pub(super) struct CableTruth {
    tension_out: Vec<f64>,
    stretch: Vec<f64>,
    drag_factor: Vec<f64>,
}

impl CableTruth {
    pub(super) fn new(muscles: usize) -> Self {
        Self { tension_out: vec![0.0; muscles], stretch: vec![0.0; muscles], drag_factor: vec![1.0; muscles] }
    }

    /// The true states of the plant at the present time.
    pub(super) fn update(&mut self, arm: &ArmTwin) -> GroundTruth<'_> {
        for (k, cable) in arm.truth().cables.iter().enumerate() {
            self.tension_out[k] = cable.tension_out;
            self.stretch[k] = cable.stretch;
            let heat = arm.specimen().cables[k].effects.heat;
            self.drag_factor[k] = heat.map_or(1.0, |heat| libm::exp(-heat.softening * cable.warming));
        }
        GroundTruth { tension_out: &self.tension_out, stretch: &self.stretch, drag_factor: &self.drag_factor }
    }
}
