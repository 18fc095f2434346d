//! From what an identification found to its report.

use super::recommendations::{advice, warnings};
use super::traces::traces;
use super::{Candidate, ChosenSummary, IdentificationReport, InfluenceRow, Parameter};
use crate::fit::run::Run;
use crate::log::Dataset;
use crate::select::cross_validation::{CrossValidation, ScoredCandidate};
use crate::select::folds::Folds;
use sinew::metrics::Comparison;
use sinew::predictor::{CableModel, MemoryLaw, Model, Signal};
use sinew::transmission::{BasisTerm, ClampCell};

/// What the stages of an identification found.
pub(crate) struct Found<'a> {
    pub(crate) data: &'a Dataset,
    pub(crate) runs: &'a [Run],
    pub(crate) tried: &'a [ScoredCandidate],
    pub(crate) chosen: usize,
    pub(crate) model: &'a Model,
    pub(crate) folds: &'a Folds,
}

/// The report of an identification.
pub(crate) fn report(found: &Found<'_>, influence: Vec<InfluenceRow>) -> IdentificationReport {
    let Found { data, runs, tried, chosen, model, folds } = *found;
    let range = model.provenance.far_range;
    let mut candidates: Vec<Candidate> =
        tried.iter().enumerate().map(|(k, tried)| candidate(tried, range, k == chosen, runs)).collect();
    candidates.sort_by(|a, b| a.rmse.total_cmp(&b.rmse));
    let validation = tried[chosen].validation.as_ref();
    let mut report = IdentificationReport {
        version: env!("CARGO_PKG_VERSION").to_string(),
        seed: model.provenance.seed,
        far: model.far.clone(),
        inputs: model.inputs.clone(),
        logs: data.logs.clone(),
        conditions: data.conditions.clone(),
        question: folds.question.clone(),
        folds: folds.held_out.len(),
        far_range: range,
        candidates,
        influence,
        classical: crate::fit::classical::fit_classical(data),
        traces: validation.map_or_else(Vec::new, |j| traces(data, runs, j, model)),
        warnings: Vec::new(),
        advice: [String::new(), String::new()],
        chosen: ChosenSummary {
            name: model.provenance.member.clone(),
            description: model.provenance.description.clone(),
            parameters: validation.map_or_else(Vec::new, |j| parameters(model, &j.laws)),
            band_factor: model.band_factor,
            size: size(model),
        },
    };
    report.warnings = warnings(found, &report);
    report.advice = advice(found, &report);
    report
}

fn candidate(tried: &ScoredCandidate, range: f64, chosen: bool, runs: &[Run]) -> Candidate {
    let validation = tried.validation.as_ref();
    let comparison = validation.map(|j| j.comparison).unwrap_or_default();
    let rmse = comparison.rmse().unwrap_or(f64::NAN);
    Candidate {
        name: tried.name.clone(),
        description: tried.description.clone(),
        chosen,
        rmse,
        percent_of_range: 100.0 * rmse / range,
        pearson: comparison.pearson().unwrap_or(f64::NAN),
        coverage95: validation.map_or(f64::NAN, |j| coverage(j, runs)),
        fold_rmse: validation.map_or_else(Vec::new, |j| j.fold_rmse.clone()),
        rmse_in_sample: validation.map_or(f64::NAN, |j| j.rmse_in_sample),
        failed: validation.is_none().then(|| "could not be fitted to these logs".to_string()),
    }
}

/// Coverage of the band, each fold with the worst factor of the other folds.
fn coverage(validation: &CrossValidation, runs: &[Run]) -> f64 {
    let factor = |fold: usize| {
        let others = validation
            .fold_factor
            .iter()
            .enumerate()
            .filter(|(f, _)| *f != fold || validation.fold_factor.len() == 1);
        others.map(|(_, factor)| *factor).fold(0.0, f64::max)
    };
    let mut band = Comparison::new();
    for (run, outputs) in runs.iter().zip(&validation.outputs) {
        for (row, output) in outputs.iter().enumerate() {
            if let (Some((output, fold)), true) = (output, run.weight[row] > 0.0) {
                let half = factor(*fold) * output.variance.sqrt();
                let _ = band.push_with_band(run.far[row], output.mean, half);
            }
        }
    }
    band.coverage().unwrap_or(f64::NAN)
}

/// Numbers of the physics with intervals from the spread over the folds (delete-one-fold jackknife).
fn parameters(model: &Model, folds: &[MemoryLaw]) -> Vec<Parameter> {
    let law = &model.estimator.law;
    if let Some(cable) = &law.cable {
        let folds: Vec<&CableModel> = folds.iter().filter_map(|f| Some(&f.cable.as_ref()?.model)).collect();
        return cable_parameters(&cable.model, &folds);
    }
    let Some(cell) = &law.cell else { return Vec::new() };
    let folds: Vec<&ClampCell> = folds.iter().filter_map(|f| f.cell.as_ref()).collect();
    cell_parameters(model, cell, &folds)
}

/// What a log shows of a cable.
fn cable_parameters(model: &CableModel, folds: &[&CableModel]) -> Vec<Parameter> {
    type Number = fn(&CableModel) -> f64;
    let numbers: [(&str, &str, Number); 5] = [
        ("friction angle, mu phi - ln eta", "1", |m| m.law().map_or(f64::NAN, |law| law.friction_angle())),
        ("drag of the grease", "N s/m", |m| m.parameters.drag),
        ("pretension", "N", |m| m.parameters.pretension),
        ("compliance of the whole cable", "m/N", |m| {
            m.law().map_or(f64::NAN, |law| law.compliance().iter().sum())
        }),
        ("compliance near the drive", "m/N", |m| {
            m.law().ok().and_then(|law| law.compliance().first().copied()).unwrap_or(f64::NAN)
        }),
    ];
    let one = |(name, unit, number): (&str, &str, Number)| {
        let others: Vec<f64> = folds.iter().map(|m| number(m)).collect();
        let (value, (low, high)) = (number(model), jackknife(number(model), &others));
        let identified = low.is_finite() && low > 0.0;
        let remark = match (low.is_finite(), identified) {
            (false, _) => "too few folds to tell",
            (true, false) => "these logs do not determine it",
            (true, true) => "",
        };
        Parameter {
            name: name.into(),
            unit: unit.into(),
            value,
            low,
            high,
            identified,
            remark: remark.into(),
        }
    };
    numbers.into_iter().map(one).collect()
}

fn cell_parameters(model: &Model, cell: &ClampCell, folds: &[&ClampCell]) -> Vec<Parameter> {
    let law = &model.estimator.law;
    let name_of = |signal: usize| signal_name(&law.signals[signal], model);
    let term_name = |term: &BasisTerm| match *term {
        BasisTerm::One => "constant".to_owned(),
        BasisTerm::Signal(i) => name_of(i),
        BasisTerm::Product(i, j) => format!("{} x {}", name_of(i), name_of(j)),
    };
    let parameter = |name: String, value: f64, others: Vec<f64>| {
        let (low, high) = jackknife(value, &others);
        let crosses = low <= 0.0 && high >= 0.0;
        let known = low.is_finite();
        Parameter {
            name,
            unit: "far/near".to_owned(),
            value,
            low,
            high,
            identified: known && !crosses,
            remark: if !known {
                "too few folds to tell".to_owned()
            } else if crosses {
                "the folds do not agree on its sign: these logs do not determine it".to_owned()
            } else {
                String::new()
            },
        }
    };
    let mut parameters = Vec::new();
    for (k, term) in cell.basis.iter().enumerate() {
        let name = format!("lower bound, {}", term_name(term));
        parameters.push(parameter(name, cell.low[k], folds.iter().map(|c| c.low[k]).collect()));
        let name = format!("upper bound, {}", term_name(term));
        parameters.push(parameter(name, cell.high[k], folds.iter().map(|c| c.high[k]).collect()));
    }
    for (k, &signal) in cell.elastic.iter().enumerate() {
        let name = format!("stiffness inside the band, {}", name_of(signal));
        parameters.push(parameter(name, cell.kappa[k], folds.iter().map(|c| c.kappa[k]).collect()));
    }
    parameters
}

/// 95 % interval from delete-one-fold values; not a number with fewer than three.
fn jackknife(value: f64, folds: &[f64]) -> (f64, f64) {
    let n = folds.len() as f64;
    if folds.len() < 3 {
        return (f64::NAN, f64::NAN);
    }
    let mean = folds.iter().sum::<f64>() / n;
    let spread = folds.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>();
    // Student's t at 97.5 % for n - 1 degrees of freedom, to 2 % from n = 3 on.
    let t = 1.96 + 2.5 / (n - 1.0) + 3.7 / ((n - 1.0) * (n - 1.0));
    let half = t * (spread * (n - 1.0) / n).sqrt();
    (value - half, value + half)
}

fn signal_name(signal: &Signal, model: &Model) -> String {
    let column = |i: usize| model.inputs[i].column.as_str();
    match *signal {
        Signal::Input(i) => column(i).to_owned(),
        Signal::Difference(i, j) => format!("{} - {}", column(i), column(j)),
        Signal::LogTension { input, .. } => format!("ln {}", column(input)),
        Signal::LogRatio { first, second, .. } => format!("ln({} / {})", column(first), column(second)),
    }
}

/// Numbers in a model.
fn size(model: &Model) -> usize {
    let law = &model.estimator.law;
    let cell = law.cell.as_ref().map_or(0, |c| c.low.len() + c.high.len() + c.kappa.len());
    let ensemble = model.estimator.ensemble.as_ref().map_or(0, |e| {
        let lanes = e.hidden_weights.len() + e.hidden_bias.len() + e.output_weights.len() + e.skip.len() + 1;
        lanes * sinew::predictor::MEMBERS + 4 * e.mean.len()
    });
    let perceptron = model.estimator.perceptron.as_ref().map_or(0, |p| p.hidden() * (p.inputs() + 2) + 1);
    cell + ensemble + perceptron
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jackknife_intervals_are_those_of_a_mean() {
        // Delete-one means of 1, 2, 3, 4, 5: the standard error of their mean is sqrt(0.5).
        let values = [1.0, 2.0, 3.0, 4.0, 5.0];
        let folds: Vec<f64> = values.iter().map(|v| (15.0 - v) / 4.0).collect();
        let (low, high) = jackknife(3.0, &folds);
        let half = 2.776 * 0.5_f64.sqrt();
        assert!((high - 3.0 - half).abs() < 0.03 * half && (3.0 - low - half).abs() < 0.03 * half);
        assert!(jackknife(1.0, &[1.0, 2.0]).0.is_nan());
    }
}
