//! The report of an identification from its results.

use super::assessment::Assessment;
use super::evidence::Evidence;
use super::excitation;
use super::headline::{headline, withdraw_others};
use super::parameters::parameters;
use super::recommendations::{recommendations, warnings};
use super::traces::traces;
use super::types::{Candidate, ChosenSummary, ExpectedError, Grade, IdentificationReport, Noticed};
use crate::estimation::size;
use crate::fit::classical::fit_classical;
use crate::fit::run::Run;
use crate::select::cross_validation::{CrossValidation, ScoredCandidate};
use crate::select::influence::InfluenceRow;
use crate::select::laws::ScoredLaw;
use sinew::metrics::Comparison;
use sinew::predictor::LoopCheck;

/// The report of an identification.
pub(crate) fn report(evidence: &Evidence<'_>, influence: Vec<InfluenceRow>) -> IdentificationReport {
    let Evidence { logs, scored, chosen, model, folds, .. } = *evidence;
    let range = model.provenance.far_range;
    let validation = scored[chosen].validation();
    let rmse = model.provenance.rmse_unseen;
    let mut report = IdentificationReport {
        version: env!("CARGO_PKG_VERSION").to_string(),
        seed: model.provenance.seed,
        far: model.far.clone(),
        far_unit: logs.data.unit(&model.far),
        inputs: model.inputs.clone(),
        logs: logs.data.logs.clone(),
        columns: logs.data.columns.clone(),
        conditions: logs.data.conditions.clone(),
        question: folds.question.clone(),
        folds: folds.held_out.len(),
        far_range: range,
        expected: ExpectedError { rmse, percent_of_range: 100.0 * rmse / range },
        beyond: model.outside.as_ref().map_or_else(Vec::new, |outside| outside.sides.clone()),
        specimen: model.specimen.iter().flat_map(|monitor| monitor.checks.iter().map(noticed)).collect(),
        candidates: candidates(evidence),
        influence,
        classical: fit_classical(&logs.data),
        headline: None,
        traces: validation.map_or_else(Vec::new, |v| traces(logs, v, model)),
        warnings: Vec::new(),
        grade: Grade::Use,
        recommendations: [String::new(), String::new()],
        chosen: ChosenSummary {
            name: model.provenance.member.clone(),
            description: model.provenance.description.clone(),
            reason: evidence.reason.clone(),
            parameters: validation.map_or_else(Vec::new, |v| parameters(model, &v.laws)),
            band_factor: model.band_factor,
            size: size(&model.estimator),
        },
    };
    report.headline = headline(evidence, &report.classical, &report.chosen.parameters);
    if let Some(headline) = &report.headline {
        withdraw_others(headline, evidence, &mut report.classical);
    }
    let poor = excitation::limits(logs, model);
    report.warnings = warnings(evidence, &report, &poor);
    let assessment = Assessment::new(evidence, &report, &poor);
    report.grade = assessment.grade;
    report.recommendations = recommendations(evidence, &report, &assessment);
    report
}

/// What a check notices, at the middle of the training logs.
fn noticed(check: &LoopCheck) -> Noticed {
    Noticed { quantity: check.quantity, mean: check.offset, change: check.limit * check.deviation }
}

/// One entry per candidate, in the order by which one is chosen.
fn candidates(evidence: &Evidence<'_>) -> Vec<Candidate> {
    let (range, runs) = (evidence.model.provenance.far_range, &evidence.logs.runs);
    let scored = evidence.scored.iter().enumerate();
    let mut candidates: Vec<Candidate> =
        scored.map(|(k, scored)| candidate(scored, range, k == evidence.chosen, runs)).collect();
    let law = |law: &ScoredLaw| Candidate { law: true, ..candidate(&law.scored, range, false, runs) };
    candidates.extend(evidence.laws.iter().map(law));
    candidates.extend(evidence.not_compared.iter().map(not_compared));
    candidates.sort_by(|a, b| a.score.total_cmp(&b.score));
    candidates
}

fn candidate(scored: &ScoredCandidate, range: f64, chosen: bool, runs: &[Run]) -> Candidate {
    let validation = scored.validation();
    let comparison = validation.map(|v| v.comparison).unwrap_or_default();
    let rmse = comparison.rmse().unwrap_or(f64::NAN);
    Candidate {
        name: scored.name.clone(),
        description: scored.description.clone(),
        chosen,
        law: false,
        size: validation.map_or(0, |v| v.size),
        score: validation.map_or(f64::NAN, |v| v.score(None)),
        rmse,
        percent_of_range: 100.0 * rmse / range,
        pearson: comparison.pearson().unwrap_or(f64::NAN),
        coverage95: validation.map_or(f64::NAN, |v| coverage(v, runs)),
        fold_rmse: validation.map_or_else(Vec::new, |v| v.folds.iter().map(|fold| fold.rmse).collect()),
        rmse_in_sample: validation.map_or(f64::NAN, |v| v.rmse_in_sample),
        failed: scored.outcome.as_ref().err().cloned(),
    }
}

/// A candidate that these logs do not allow.
fn not_compared((name, reason): &(String, String)) -> Candidate {
    let none =
        ScoredCandidate { name: name.clone(), description: String::new(), outcome: Err(reason.clone()) };
    candidate(&none, f64::NAN, false, &[])
}

/// Coverage of the band, each fold with the factor of the other folds.
fn coverage(validation: &CrossValidation, runs: &[Run]) -> f64 {
    let mut band = Comparison::new();
    for (sequence, row, output, fold) in validation.rows() {
        let run = &runs[sequence];
        if run.weight[row] > 0.0 {
            let half = validation.band_factors[fold] * output.variance.sqrt();
            let _ = band.push_with_band(run.far[row], output.mean, half);
        }
    }
    band.coverage().unwrap_or(f64::NAN)
}
