//! Whether a model is recommended: its errors on unseen data beside those of two references.

use super::evidence::Evidence;
use super::types::{Grade, IdentificationReport};
use crate::log::DefectKind;
use crate::select::candidates::{CONSTANT, LINEAR};
use crate::select::cross_validation::CrossValidation;
use sinew::metrics::Comparison;

/// Error over that of a constant above which a model is not to be used: a quarter of the variance remains.
const USELESS: f64 = 0.5;

/// The same above which it is to be used with care.
const DOUBTFUL: f64 = 0.33;

/// Error over that of linear regression above which the regression does as well.
const NO_BETTER_THAN_LINEAR: f64 = 0.9;

/// Coverage of the 95 % band on held-out samples below which it is too narrow.
pub(super) const MIN_COVERAGE: f64 = 0.85;

/// One of so many logs may be left out without a word.
const MANY_LEFT_OUT: usize = 4;

/// The grade of a model with its reasons.
pub(super) struct Assessment {
    pub(super) grade: Grade,
    /// Why it is not recommended without reserve, most important first; each completes "because".
    pub(super) reasons: Vec<String>,
    /// RMSE on held-out data of the constant and of linear regression, far unit; `None` where not compared.
    pub(super) constant: Option<f64>,
    pub(super) linear: Option<f64>,
}

impl Assessment {
    /// The assessment on the chosen model; `poor` are the limits of the logs' excitation; of the report it
    /// reads the candidates and the influence of the logs.
    pub(super) fn new(evidence: &Evidence<'_>, report: &IdentificationReport, poor: &[String]) -> Self {
        let expected = evidence.model.provenance.rmse_unseen;
        let chosen = evidence.scored[evidence.chosen].name.as_str();
        let (constant, linear) = (reference(evidence, CONSTANT), reference(evidence, LINEAR));
        let rmse = |found: Option<&CrossValidation>| found.and_then(|v| Comparison::rmse(&v.comparison));
        let over = |error: Option<f64>| error.map_or(0.0, |error| expected / error.max(1e-300));
        let (constant_rmse, linear_rmse) = (rmse(constant), rmse(linear));
        let mut reasons = Vec::new();
        let fraction = over(constant_rmse);
        if fraction > DOUBTFUL {
            reasons
                .push(format!("its error on unseen data is {:.0} % of that of a constant", 100.0 * fraction));
        }
        if chosen != LINEAR && over(linear_rmse) > NO_BETTER_THAN_LINEAR {
            reasons.push("a linear regression predicts unseen data as well".to_owned());
        }
        let validation = evidence.scored[evidence.chosen].validation();
        if let (Some(validation), Some(constant)) = (validation, constant) {
            let folds = validation.folds.iter().zip(&constant.folds);
            let lost = folds.filter(|(model, constant)| model.rmse > USELESS * constant.rmse).count();
            if fraction <= DOUBTFUL && lost > 0 {
                let of = validation.folds.len();
                reasons.push(format!("it predicts {lost} of {of} folds hardly better than a constant"));
            }
        }
        let covered =
            report.candidates.iter().find(|candidate| candidate.chosen).map(|chosen| chosen.coverage95);
        if let Some(covered) = covered.filter(|covered| *covered < MIN_COVERAGE) {
            reasons.push(format!(
                "only {:.0} % of the unseen samples lie inside its 95 % band",
                100.0 * covered
            ));
        }
        let (left_out, logs) =
            (report.influence.iter().filter(|row| row.dropped).count(), report.influence.len());
        if MANY_LEFT_OUT * left_out > logs {
            reasons.push(format!("{left_out} of {logs} logs were left out as outliers"));
        }
        reasons.extend(defects(report));
        if !evidence.folds.grouped {
            reasons.push("one log does not show the change between days".to_owned());
        }
        if let Some(first) = poor.first() {
            reasons.push(format!("the logs are poor: {first}"));
        }
        let grade = match (fraction > USELESS, reasons.is_empty()) {
            (true, _) => Grade::DoNotUse,
            (false, true) => Grade::Use,
            (false, false) => Grade::UseWithCare,
        };
        Self { grade, reasons, constant: constant_rmse, linear: linear_rmse }
    }
}

/// Defects of the logs that were fitted, kind by kind.
fn defects(report: &IdentificationReport) -> Vec<String> {
    let mut reasons: Vec<String> = Vec::new();
    for (log, defect) in report.logs.iter().flat_map(|log| log.defects.iter().map(move |d| (log, d))) {
        let channel =
            if defect.column.is_empty() { String::new() } else { format!("`{}` of ", defect.column) };
        let (what, name) = (in_words(defect.kind), log.name.as_str());
        let reason = format!("{channel}{name} {what}");
        if !reasons.contains(&reason) {
            reasons.push(reason);
        }
    }
    let more = reasons.len().saturating_sub(SHOWN);
    reasons.truncate(SHOWN);
    reasons.extend((more > 0).then(|| format!("{more} more channels or logs are damaged")));
    reasons
}

/// Defects that are named one by one in the reasons.
const SHOWN: usize = 3;

/// Completes the name of a channel or a log.
fn in_words(kind: DefectKind) -> &'static str {
    match kind {
        DefectKind::Clipped => "is clipped",
        DefectKind::Frozen => "is frozen for a stretch",
        DefectKind::Clock => "is of another unit or clock",
        DefectKind::Short => "is too short",
        DefectKind::Shifted => "is shifted in time",
        DefectKind::Gain => "has another gain, offset or sign than the other logs",
        DefectKind::Contradiction => "contradicts another log",
        DefectKind::Trend => "changes from log to log",
    }
}

fn reference<'a>(evidence: &'a Evidence<'_>, name: &str) -> Option<&'a CrossValidation> {
    evidence.scored.iter().find(|scored| scored.name == name)?.validation()
}
