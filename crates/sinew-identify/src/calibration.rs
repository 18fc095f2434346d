//! From a chosen and fitted estimator to a model: prediction band, provenance, validation.

use crate::Error;
use crate::conditioning::ConditionedLogs;
use crate::fit::run::Run;
use crate::fit::statistics::quantiles;
use crate::select::cross_validation::{ScoredCandidate, band_factor};
use sinew::predictor::{Estimator, Model, Provenance, SpecimenMonitor};

/// The model of an estimator fitted to all logs, with the band that its cross-validation asks for and what
/// notices another specimen.
///
/// # Errors
/// [`Error::Physics`] where the model is not valid.
pub(crate) fn calibrate(
    estimator: Estimator,
    chosen: &ScoredCandidate,
    rmse_unseen: f64,
    logs: &ConditionedLogs,
    specimen: Option<&SpecimenMonitor>,
    seed: u64,
) -> Result<Model, Error> {
    let roles = &logs.data.roles;
    let folds = chosen.validation().map_or(&[][..], |validation| validation.folds.as_slice());
    let model = Model {
        far: roles.far.clone().unwrap_or_default(),
        inputs: roles.inputs.clone(),
        time: roles.time.clone(),
        trial: roles.trial.clone(),
        guards: logs.limits.clone(),
        gap_s: logs.gap_s,
        estimator,
        band_factor: band_factor(folds, None),
        specimen: specimen.cloned(),
        provenance: Provenance {
            member: chosen.name.clone(),
            description: chosen.description.clone(),
            program: env!("CARGO_PKG_VERSION").to_string(),
            seed,
            logs: logs.data.logs.iter().map(|log| log.name.clone()).collect(),
            samples: logs.runs.iter().map(Run::len).sum(),
            rmse_unseen,
            far_range: far_range(&logs.runs),
        },
    };
    model.validate()?;
    Ok(model)
}

/// Range of the far side over the samples that count, from its 0.05 % to its 99.95 % quantile.
pub(crate) fn far_range(runs: &[Run]) -> f64 {
    let counted = |run: &Run| -> Vec<f64> {
        run.far.iter().zip(&run.weight).filter(|(_, w)| **w > 0.0).map(|(y, _)| *y).collect()
    };
    let edge = quantiles(runs.iter().flat_map(counted).collect(), &[0.0005, 0.9995]);
    edge[1] - edge[0]
}
