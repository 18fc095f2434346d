//! Out-of-fold traces with what residuals are sampled against: speed and time since reversal.

use super::types::{InputTrace, Trace};
use crate::conditioning::ConditionedLogs;
use crate::fit::statistics::quantiles;
use crate::select::cross_validation::CrossValidation;
use sinew::predictor::{Estimate, Model, Role};

/// One trace per sequence, predicted by models that were not fitted to it.
pub(super) fn traces(logs: &ConditionedLogs, validation: &CrossValidation, model: &Model) -> Vec<Trace> {
    let ConditionedLogs { data, runs, .. } = logs;
    let mut all: Vec<Vec<Option<(Estimate, usize)>>> = runs.iter().map(|run| vec![None; run.len()]).collect();
    for (sequence, row, estimate, fold) in validation.rows() {
        all[sequence][row] = Some((*estimate, fold));
    }
    let near = model.inputs.iter().position(|i| i.role == Role::Effort).unwrap_or(0);
    data.sequences
        .iter()
        .zip(runs)
        .zip(&all)
        .map(|((sequence, run), outputs)| {
            let input =
                |k: usize| -> Vec<f64> { run.inputs.iter().skip(k).step_by(run.width).copied().collect() };
            let column = input(near);
            let others = (0..model.inputs.len()).filter(|k| *k != near);
            let pick = |f: &dyn Fn(&Estimate, usize) -> f64| -> Vec<f64> {
                outputs.iter().map(|o| o.as_ref().map_or(f64::NAN, |(o, fold)| f(o, *fold))).collect()
            };
            let (near_rate, since_reversal_s) =
                rates(&column, &run.dt_s, model.guards[near].high - model.guards[near].low);
            Trace {
                log: data.logs[sequence.log].name.clone(),
                trial: sequence.trial.clone(),
                time_s: sequence.time_s.clone(),
                near_name: model.inputs[near].column.clone(),
                others: others
                    .map(|k| InputTrace { column: model.inputs[k].column.clone(), values: input(k) })
                    .collect(),
                far: sequence.far.clone(),
                predicted: pick(&|o, _| o.mean),
                half_width: pick(&|o, fold| validation.band_factors[fold] * o.variance.sqrt()),
                gate: pick(&|o, _| o.gate),
                near_rate,
                since_reversal_s,
                scored: run.weight.iter().map(|w| *w > 0.0).collect(),
                near: column,
            }
        })
        .collect()
}

/// Smoothed rate of a signal and the time since it last turned by more than 1 % of its range.
fn rates(signal: &[f64], dt_s: &[f64], range: f64) -> (Vec<f64>, Vec<f64>) {
    const SMOOTHING: f64 = 8.0;
    let typical = {
        let positive: Vec<f64> = dt_s.iter().copied().filter(|dt| *dt > 0.0).collect();
        if positive.is_empty() { 1.0 } else { quantiles(positive, &[0.5])[0] }
    };
    let tau = SMOOTHING * typical;
    let (mut low_pass, mut direction, mut extreme, mut since) = (0.0, 0.0, 0.0, f64::NAN);
    let mut rate = Vec::with_capacity(signal.len());
    let mut time = Vec::with_capacity(signal.len());
    for (&u, &dt) in signal.iter().zip(dt_s) {
        if dt == 0.0 {
            (low_pass, extreme, direction, since) = (u, u, 0.0, f64::NAN);
        }
        low_pass += (u - low_pass) * dt / (dt + tau);
        rate.push((u - low_pass) / tau);
        since += dt;
        if (u - extreme) * direction > 0.0 {
            extreme = u;
        } else if (u - extreme).abs() > 0.01 * range {
            since = if direction == 0.0 { f64::NAN } else { 0.0 };
            direction = (u - extreme).signum();
            extreme = u;
        }
        time.push(since);
    }
    (rate, time)
}
