//! Folds that follow the intended use: another log, another load, another stretch of time.

use crate::fit::statistics::quantiles;
use crate::log::{Dataset, Role};

/// At most this many folds along one condition, or over logs and trials.
const MAX_FOLDS: usize = 5;

/// Folds along each of several conditions.
const FOLDS_PER_CONDITION: usize = 3;

/// Which samples each fold holds out.
#[derive(Debug, Clone)]
pub(crate) struct Folds {
    /// `[fold][sequence]`: the rows held out, as half-open ranges.
    pub(crate) held_out: Vec<Vec<Option<(usize, usize)>>>,
    /// Whether a fold holds out whole sequences: other logs, trials or conditions.
    pub(crate) grouped: bool,
    /// What was held out, for the report.
    pub(crate) question: String,
}

impl Folds {
    /// Folds for these logs: by the group that was requested, else by conditions found in the logs, else by
    /// log, else by trial, else by time.
    pub(crate) fn new(data: &Dataset) -> Self {
        let asked = data.roles.group.is_some();
        let logs = data.logs.len();
        let conditions: Vec<usize> = if asked { vec![0] } else { separating_conditions(data) };
        if !conditions.is_empty() {
            return Self::by_conditions(data, &conditions);
        }
        if logs >= 2 {
            let label = data.sequences.iter().map(|s| s.log).collect::<Vec<_>>();
            let question =
                format!("Each of the {logs} logs was predicted by models that were not fitted to it.");
            return Self::by_label(&label, MAX_FOLDS.max(logs.min(8)), question);
        }
        let mut trials: Vec<(usize, &str)> = Vec::new();
        let label: Vec<usize> = data
            .sequences
            .iter()
            .map(|s| {
                let key = (s.log, s.trial.as_str());
                trials.iter().position(|t| *t == key).unwrap_or_else(|| {
                    trials.push(key);
                    trials.len() - 1
                })
            })
            .collect();
        if trials.len() >= 3 {
            let question = format!(
                "The {} trials were assigned to folds; each was predicted by models that were not fitted to it.",
                trials.len()
            );
            return Self::by_label(&label, MAX_FOLDS, question);
        }
        Self::by_time(data)
    }

    /// `[fold]`: whether it holds out a value of a condition or of a given quantity beyond all those that
    /// remain.
    pub(crate) fn extrapolates(&self, data: &Dataset) -> Vec<bool> {
        let quantities = numeric_quantities(data);
        let beyond = |held: &[Option<(usize, usize)>], values: &[f64]| {
            let of = |kept: bool| {
                let pairs = values
                    .iter()
                    .zip(held)
                    .filter(move |(value, h)| h.is_none() == kept && value.is_finite());
                pairs.fold((f64::MAX, f64::MIN), |(low, high), (v, _)| (low.min(*v), high.max(*v)))
            };
            let ((low, high), (least, most)) = (of(true), of(false));
            low <= high && (least < low || most > high)
        };
        let fold = |held: &Vec<Option<(usize, usize)>>| {
            self.grouped && quantities.iter().any(|(_, values)| beyond(held, values))
        };
        self.held_out.iter().map(fold).collect()
    }

    fn by_label(label: &[usize], most: usize, question: String) -> Self {
        let count = label.iter().max().map_or(0, |m| m + 1);
        let folds = count.min(most);
        let held_out = (0..folds)
            .map(|fold| label.iter().map(|l| (l % folds == fold).then_some((0, usize::MAX))).collect())
            .collect();
        Self { held_out, grouped: true, question }
    }

    fn by_conditions(data: &Dataset, conditions: &[usize]) -> Self {
        let mut held_out = Vec::new();
        for &condition in conditions {
            let mut values: Vec<&str> =
                data.sequences.iter().map(|s| s.condition_values[condition].as_str()).collect();
            values.sort_by(|a, b| natural(a, b));
            values.dedup();
            let most = if conditions.len() > 1 { FOLDS_PER_CONDITION } else { MAX_FOLDS };
            let folds = values.len().min(most);
            for fold in 0..folds {
                let held = |s: &crate::log::Sequence| {
                    let place = values.iter().position(|v| *v == s.condition_values[condition]).unwrap_or(0);
                    (place % folds == fold).then_some((0, usize::MAX))
                };
                held_out.push(data.sequences.iter().map(held).collect());
            }
        }
        let names: Vec<String> =
            conditions.iter().map(|&c| format!("`{}`", data.conditions[c].column)).collect();
        let question = format!(
            "Values of {} were held out in turn: every score is for conditions that the model was not fitted to.",
            names.join(" and of ")
        );
        Self { held_out, grouped: true, question }
    }

    fn by_time(data: &Dataset) -> Self {
        let total: usize = data.sequences.iter().map(|s| s.time_s.len()).sum();
        let folds = MAX_FOLDS;
        let held_out = (0..folds)
            .map(|fold| {
                let (from, to) = (total * fold / folds, total * (fold + 1) / folds);
                let mut start = 0;
                data.sequences
                    .iter()
                    .map(|s| {
                        let n = s.time_s.len();
                        let range = (from.max(start) - start, to.min(start + n).saturating_sub(start));
                        start += n;
                        (range.0 < range.1).then_some(range)
                    })
                    .collect()
            })
            .collect();
        let question = format!(
            "The log was cut into {folds} stretches; each was predicted by models fitted to the others. \
             Another day may be harder: record a second log to measure that."
        );
        Self { held_out, grouped: false, question }
    }
}

/// Conditions along which trials can be split: several values, each shared by several trials.
fn separating_conditions(data: &Dataset) -> Vec<usize> {
    let mut found: Vec<usize> = (0..data.conditions.len())
        .filter(|&c| {
            let values = data.conditions[c].values.len();
            let mut trials: Vec<(usize, &str)> =
                data.sequences.iter().map(|s| (s.log, s.trial.as_str())).collect();
            trials.dedup();
            values >= 3 && trials.len() >= 2 * values
        })
        .collect();
    found.truncate(2);
    found
}

/// Name and `[sequence]` of every quantity: conditions that are numbers, and the medians of given quantities;
/// NaN where there is none.
pub(crate) fn numeric_quantities(data: &Dataset) -> Vec<(String, Vec<f64>)> {
    let condition = |c: usize| -> (String, Vec<f64>) {
        let value = |s: &crate::log::Sequence| s.condition_values[c].parse().unwrap_or(f64::NAN);
        (data.conditions[c].column.clone(), data.sequences.iter().map(value).collect())
    };
    let width = data.roles.inputs.len();
    let given = |input: usize| -> (String, Vec<f64>) {
        let median = |s: &crate::log::Sequence| {
            let column = s.inputs.iter().skip(input).step_by(width).copied();
            let values: Vec<f64> = column.filter(|v| v.is_finite()).collect();
            if values.is_empty() { f64::NAN } else { quantiles(values, &[0.5])[0] }
        };
        (data.roles.inputs[input].column.clone(), data.sequences.iter().map(median).collect())
    };
    let givens = (0..width).filter(|&i| data.roles.inputs[i].role == Role::Given);
    (0..data.conditions.len()).map(condition).chain(givens.map(given)).collect()
}

/// Numbers by size, text by alphabet.
fn natural(a: &str, b: &str) -> std::cmp::Ordering {
    match (a.parse::<f64>(), b.parse::<f64>()) {
        (Ok(a), Ok(b)) => a.total_cmp(&b),
        _ => a.cmp(b),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::{ReadOptions, RequestedRoles, read_bytes};
    use std::fmt::Write as _;

    /// Trials of 40 samples; each has a load and a speed.
    fn trials(conditions: &[(u32, u32)], columns: &str) -> Dataset {
        let mut text = format!("trial,t_s,tension_in_n,tension_out_n{columns}\n");
        for (trial, (load, speed)) in conditions.iter().enumerate() {
            for i in 0..40 {
                let near = f64::from(i * i % 17) + f64::from(*load);
                write!(text, "{trial},{},{near},{}", f64::from(i) * 0.01, 0.8 * near).unwrap();
                text.push_str(&if columns.is_empty() { String::new() } else { format!(",{load},{speed}") });
                text.push('\n');
            }
        }
        let options = ReadOptions { far_required: true, ..ReadOptions::default() };
        read_bytes(&[("log.csv", text.as_bytes())], &RequestedRoles::default(), &options).unwrap()
    }

    /// Every sequence is held out by some fold, and no fold holds out all.
    fn is_sound(folds: &Folds, sequences: usize) {
        for s in 0..sequences {
            assert!(folds.held_out.iter().any(|fold| fold[s].is_some()));
        }
        assert!(folds.held_out.iter().all(|fold| fold.iter().any(Option::is_none) || !folds.grouped));
    }

    #[test]
    fn conditions_found_in_the_trials_are_held_out_one_after_the_other() {
        let all: Vec<(u32, u32)> = (0..3).flat_map(|l| (0..3).map(move |s| (10 * l, s))).collect();
        let data = trials(&all, ",load,speed");
        let folds = Folds::new(&data);
        assert!(folds.grouped && folds.question.contains("load") && folds.question.contains("speed"));
        is_sound(&folds, 9);
        // The smallest and the largest load and speed are beyond the others, the middle ones are not.
        assert_eq!(folds.extrapolates(&data), [true, false, true, true, false, true]);
        for fold in &folds.held_out {
            let held: Vec<(u32, u32)> =
                fold.iter().zip(&all).filter(|(f, _)| f.is_some()).map(|(_, c)| *c).collect();
            let one_value = |pick: fn(&(u32, u32)) -> u32| held.iter().all(|c| pick(c) == pick(&held[0]));
            assert!(one_value(|c| c.0) || one_value(|c| c.1), "{held:?}");
        }
    }

    #[test]
    fn three_trials_are_held_out_each() {
        let data = trials(&[(10, 0), (20, 0), (30, 0)], "");
        let folds = Folds::new(&data);
        assert_eq!(folds.held_out.len(), 3);
        is_sound(&folds, 3);
    }

    #[test]
    fn one_stretch_is_cut_by_time_and_every_row_is_held_out_once() {
        let data = trials(&[(10, 0)], "");
        let folds = Folds::new(&data);
        assert!(!folds.grouped);
        let rows: usize = folds.held_out.iter().flatten().flatten().map(|(from, to)| to - from).sum();
        assert_eq!(rows, data.sequences.iter().map(|s| s.time_s.len()).sum::<usize>());
    }
}
