//! The influence check: does a log spoil the prediction of all others?

use super::judge::rmse_on;
use crate::account::InfluenceRow;
use crate::log::Dataset;
use crate::member::{Recipe, Run, fit};

/// A log that raises the others' error by more than exp(0.2), 22 %, is foreign.
const LIMIT: f64 = 0.2;

/// Logs that must remain.
const FEWEST: usize = 3;

/// Leaves out foreign logs, the worst first, and says why; `keep[log]`.
///
/// ```text
/// influence_k = mean over i != k of ln( error on i, fitted to all but i / fitted to all but i and k )
/// ```
///
/// A log that is unlike the others pulls the fit away from all of them; a log that merely covers another
/// condition does not, for without it the others are predicted no better.
pub(crate) fn check(data: &Dataset, runs: &[Run], recipe: &Recipe) -> (Vec<bool>, Vec<InfluenceRow>) {
    let logs = data.logs.len();
    let mut keep = vec![true; logs];
    let mut first_values: Option<Vec<f64>> = None;
    let mut remarks = vec![String::new(); logs];
    while keep.iter().filter(|k| **k).count() > FEWEST {
        let values = influences(runs, recipe, &keep);
        let worst = (0..logs).filter(|&k| keep[k]).max_by(|&a, &b| values[a].total_cmp(&values[b]));
        let foreign = worst.filter(|&k| values[k] > LIMIT);
        if let Some(k) = foreign {
            keep[k] = false;
            remarks[k] = format!(
                "With it in training the other logs are predicted {:.1} times worse: a foreign recording. \
                 It was left out; look at what was different that day.",
                values[k].exp()
            );
        }
        let first = first_values.get_or_insert_with(|| values.clone());
        if let Some(k) = foreign {
            first[k] = values[k];
        } else {
            for k in 0..logs {
                if keep[k] {
                    first[k] = values[k];
                }
            }
            break;
        }
    }
    let rows = first_values.map_or_else(Vec::new, |values| {
        (0..logs)
            .map(|k| InfluenceRow {
                log: data.logs[k].name.clone(),
                influence: values[k],
                dropped: !keep[k],
                remark: remarks[k].clone(),
            })
            .collect()
    });
    (keep, rows)
}

fn influences(runs: &[Run], recipe: &Recipe, keep: &[bool]) -> Vec<f64> {
    let present: Vec<usize> = (0..keep.len()).filter(|&k| keep[k]).collect();
    let error = |test: usize, without: Option<usize>| -> Option<f64> {
        let training: Vec<&Run> =
            runs.iter().filter(|r| keep[r.log] && r.log != test && Some(r.log) != without).collect();
        let member = fit(recipe, &training, 0)?;
        let held: Vec<&Run> = runs.iter().filter(|r| r.log == test).collect();
        Some(rmse_on(&member, &held).max(1e-300))
    };
    let base: Vec<Option<f64>> =
        (0..keep.len()).map(|i| if keep[i] { error(i, None) } else { None }).collect();
    (0..keep.len())
        .map(|k| {
            if !keep[k] {
                return f64::NAN;
            }
            let ratios: Vec<f64> = present
                .iter()
                .filter(|&&i| i != k)
                .filter_map(|&i| Some((base[i]? / error(i, Some(k))?).ln()))
                .filter(|r| r.is_finite())
                .collect();
            if ratios.is_empty() { 0.0 } else { ratios.iter().sum::<f64>() / ratios.len() as f64 }
        })
        .collect()
}
