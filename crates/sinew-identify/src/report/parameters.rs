//! Physical parameters of the chosen model with their intervals.

use crate::fit::classical::Parameter;
use sinew::predictor::{CableModel, MemoryLaw, Model, Signal};
use sinew::transmission::{BasisTerm, ClampCell};

/// Numbers of the physics with intervals from the spread over the folds (delete-one-fold jackknife).
pub(super) fn parameters(model: &Model, folds: &[MemoryLaw]) -> Vec<Parameter> {
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
            (false, _) => "too few folds for an interval",
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
                "too few folds for an interval".to_owned()
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
