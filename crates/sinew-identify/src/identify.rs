//! The whole identification: logs in, a model and the report of its identification out.

use crate::Error;
use crate::calibration::{calibrate, far_range};
use crate::conditioning::ConditionedLogs;
use crate::log::Dataset;
use crate::report::build::report;
use crate::report::{Evidence, IdentificationReport};
use crate::select::agreement::report_shift;
use crate::select::candidates::{CandidateRecipe, candidates, not_compared};
use crate::select::choice::{Choice, selection_rmse};
use crate::select::cross_validation::{ScoredCandidate, cross_validate_all};
use crate::select::folds::Folds;
pub use crate::select::influence::Keep;
use crate::select::influence::{check_keep, exclude_outlier_logs};
use crate::select::laws::cross_validate_laws;
use crate::select::mean::cross_validate_means;
use crate::select::trend::report_trend;
use crate::specimen::monitor;
use crate::training::{fit, mean_of};
use rayon::prelude::*;
use sinew::predictor::{Estimator, Model};

/// Which model is chosen.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Preference {
    /// The least error on unseen data.
    #[default]
    Accurate,
    /// The fewest parameters, at an error on unseen data that is larger by no more than a loss.
    Simple {
        /// In % of the range of the far side.
        loss_percent: f64,
    },
}

/// Options of an identification.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Seed of every random draw.
    pub seed: u64,
    /// Names of the candidates to compare; empty for all.
    pub models: Vec<String>,
    /// Logs that stay whatever the influence check says.
    pub keep: Keep,
    /// Which model is chosen.
    pub prefer: Preference,
}

/// Receives the stage of an identification and the fraction that is done, for a progress display.
pub type Progress<'a> = dyn Fn(&str, f64) + Sync + 'a;

/// A model with its report.
#[derive(Debug, Clone)]
pub struct Identification {
    /// The chosen model, ready to run.
    pub model: Model,
    /// Candidates, errors, warnings and recommendations.
    pub report: IdentificationReport,
}

/// Fits a candidate, or the members of a mean, to all logs.
fn fit_candidate(
    candidates: &[CandidateRecipe],
    scored: &[ScoredCandidate],
    chosen: usize,
    logs: &ConditionedLogs,
    seed: u64,
) -> Option<Estimator> {
    let (candidate, runs) = (&candidates[chosen], logs.counted());
    if candidate.mean_of.is_empty() {
        return fit(&candidate.recipe, &runs, seed);
    }
    let member = |(name, inside): &(String, bool)| {
        let member = candidates.iter().find(|candidate| candidate.recipe.name == *name)?;
        Some((fit(&member.recipe, &runs, seed)?, *inside))
    };
    let members = candidate.mean_of.par_iter().map(member).collect::<Option<Vec<_>>>()?;
    Some(mean_of(members, &scored[chosen].validation()?.weights))
}

/// Checks the names in the options against a dataset, before any fit.
///
/// # Errors
/// [`Error::UnknownModel`], [`Error::UnknownLog`], as [`identify`].
pub fn check_options(data: &Dataset, options: &Options) -> Result<(), Error> {
    candidates(&ConditionedLogs::new(data.clone()), &options.models)?;
    check_keep(data, &options.keep)
}

/// Identifies the transmission that made a dataset.
///
/// # Errors
/// [`Error::UnknownModel`] where no candidate has a requested name, [`Error::UnknownLog`] where no log has
/// the name of one to keep, [`Error::NothingFitted`] where no candidate could be fitted.
pub fn identify(data: &Dataset, options: &Options, progress: &Progress<'_>) -> Result<Identification, Error> {
    // 1. Read: conditioned as the predictor conditions its samples.
    let logs = ConditionedLogs::new(data.clone());
    let candidates = candidates(&logs, &options.models)?;

    progress("measuring the influence of each log", 0.05);
    let not_compared = if options.models.is_empty() { not_compared(&logs) } else { Vec::new() };
    let (mut logs, influence) = exclude_outlier_logs(logs, &options.keep)?; // 2. Influence.
    report_shift(&mut logs);
    report_trend(&mut logs);
    let folds = Folds::new(&logs.data); // 3. Folds.

    let stage = |done: f64| progress("cross-validating the candidates", 0.1 + 0.7 * done);
    let single = cross_validate_all(&candidates, &logs, &folds, options.seed, &stage); // 4. Cross-validation.
    let scored = cross_validate_means(&candidates, &single, &logs, &folds);
    let extrapolates = folds.extrapolates(&logs.data);
    let choice = Choice {
        candidates: &candidates,
        scored: &scored,
        grouped: folds.grouped,
        extrapolates: &extrapolates,
        loss: match options.prefer {
            Preference::Accurate => None,
            Preference::Simple { loss_percent } => Some(0.01 * loss_percent * far_range(&logs.runs)),
        },
    };
    let choose = |without| choice.choose(without);
    let chosen = choose(None).ok_or(Error::NothingFitted { what: "any candidate model" })?;
    let rmse = selection_rmse(&scored, chosen, &choose);

    progress("fitting the chosen model to everything", 0.85);
    let estimator = fit_candidate(&candidates, &scored, chosen, &logs, options.seed) // 5. Fit and calibrate.
        .ok_or(Error::NothingFitted { what: "the chosen model" })?;
    let specimen = monitor(&logs, &folds);
    let model =
        calibrate(estimator, &scored[chosen], rmse, (&logs, &folds), specimen.as_ref().ok(), options.seed)?;

    progress("writing the report", 0.95);
    let laws = cross_validate_laws(&logs, &folds);
    let reason = choice.reason(chosen) + &choice.least(chosen, &laws, far_range(&logs.runs));
    let evidence = Evidence {
        logs: &logs,
        scored: &scored,
        laws: &laws,
        not_compared: &not_compared,
        chosen,
        reason,
        model: &model,
        folds: &folds,
        not_monitored: specimen.err(),
    };
    let report = report(&evidence, influence); // 6. Report.
    Ok(Identification { model, report })
}
