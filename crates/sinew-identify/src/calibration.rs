//! From a chosen and fitted estimator to a model: prediction band, provenance, validation.

use crate::Error;
use crate::conditioning::ConditionedLogs;
use crate::fit::run::Run;
use crate::fit::statistics::{mean_and_deviation, quantiles};
use crate::log::{Dataset, unit_of};
use crate::outside::outside;
use crate::select::cross_validation::{CrossValidation, ScoredCandidate, Stretch, band_factor};
use crate::select::folds::Folds;
use sinew::predictor::{Estimator, Model, OffsetVariance, Provenance, SpecimenMonitor};
use std::collections::BTreeMap;

/// The model of an estimator fitted to all logs, with the band that its cross-validation asks for and what
/// notices another specimen.
///
/// # Errors
/// [`Error::Physics`] where the model is not valid.
pub(crate) fn calibrate(
    estimator: Estimator,
    chosen: &ScoredCandidate,
    rmse_unseen: f64,
    (logs, folds): (&ConditionedLogs, &Folds),
    specimen: Option<&SpecimenMonitor>,
    seed: u64,
) -> Result<Model, Error> {
    let roles = &logs.data.roles;
    let scores = chosen.validation().map_or(&[][..], |validation| validation.folds.as_slice());
    let inside = band_factor(scores, None);
    let model = Model {
        far: roles.far.clone().unwrap_or_default(),
        inputs: roles.inputs.clone(),
        units: units(&logs.data),
        time: roles.time.clone(),
        trial: roles.trial.clone(),
        guards: logs.limits.clone(),
        gap_s: logs.gap_s,
        estimator,
        band_factor: inside,
        outside: chosen.validation().and_then(|validation| outside(validation, logs, folds, inside)),
        specimen: specimen.cloned(),
        offset: chosen.validation().and_then(|validation| offset_variance(validation, &logs.runs)),
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

/// Units that the logs state of the columns of a model, where their names do not.
fn units(data: &Dataset) -> BTreeMap<String, String> {
    let columns = data.roles.inputs.iter().map(|input| &input.column).chain(&data.roles.far);
    let stated = columns.map(|column| (column.clone(), data.unit(column)));
    stated.filter(|(column, unit)| !unit.is_empty() && *unit != unit_of(column)).collect()
}

/// Fewest recordings that show how much of an error is an offset.
const RECORDINGS: usize = 3;

/// Errors of what the folds held out, between its stretches and within them.
fn offset_variance(validation: &CrossValidation, runs: &[Run]) -> Option<OffsetVariance> {
    let moments = |stretch: &Stretch| {
        let run = &runs[stretch.sequence];
        let rows = (stretch.from..).zip(&stretch.estimates).filter(|(row, _)| run.weight[*row] > 0.0);
        let errors: Vec<f64> = rows.map(|(row, estimate)| run.far[row] - estimate.mean).collect();
        (!errors.is_empty()).then(|| mean_and_deviation(&errors))
    };
    let all: Vec<(f64, f64)> = validation.outputs.iter().flatten().filter_map(moments).collect();
    let mean = |of: fn(&(f64, f64)) -> f64| all.iter().map(of).sum::<f64>() / all.len() as f64;
    let (between, within) = (mean(|(mean, _)| mean * mean), mean(|(_, deviation)| deviation * deviation));
    (all.len() >= RECORDINGS && within > 0.0).then_some(OffsetVariance { between, within })
}

/// Range of the far side over the samples that count, from its 0.05 % to its 99.95 % quantile.
pub(crate) fn far_range(runs: &[Run]) -> f64 {
    let counted = |run: &Run| -> Vec<f64> {
        run.far.iter().zip(&run.weight).filter(|(_, w)| **w > 0.0).map(|(y, _)| *y).collect()
    };
    let edge = quantiles(runs.iter().flat_map(counted).collect(), &[0.0005, 0.9995]);
    edge[1] - edge[0]
}
