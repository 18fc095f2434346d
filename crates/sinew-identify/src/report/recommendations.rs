//! What the user should know, and do next.

use super::IdentificationReport;
use super::build::Found;
use sinew::predictor::Role;

/// Ratio of the worst fold's error to the median's from which the worst is worth a log of its own.
const UNEVEN: f64 = 1.8;

/// Things the user should know, most important first.
pub(super) fn warnings(found: &Found<'_>, report: &IdentificationReport) -> Vec<String> {
    let mut warnings = Vec::new();
    for row in report.influence.iter().filter(|row| row.dropped) {
        warnings.push(format!("{} was left out. {}", row.log, row.remark));
    }
    let Some(chosen) = report.candidates.iter().find(|c| c.chosen) else { return warnings };
    if chosen.coverage95 < 0.85 {
        warnings.push(format!(
            "Only {:.0} % of the unseen samples lie inside the 95 % band: some conditions surprise the model.",
            100.0 * chosen.coverage95
        ));
    }
    let unscored = found.runs.iter().flat_map(|r| &r.weight).filter(|w| **w == 0.0).count();
    let all: usize = found.runs.iter().map(|r| r.weight.len()).sum();
    if 2 * unscored > all {
        warnings.push(format!("{unscored} of {all} samples do not count: skipped, missing or spikes."));
    }
    for (input, name) in report.inputs.iter().enumerate().map(|(i, input)| (i, &input.column)) {
        let guard = &found.model.guards[input];
        if guard.high - guard.low <= 1e-9 * guard.high.abs().max(1e-9) {
            warnings.push(format!("`{name}` is constant in these logs: nothing could be learned from it."));
        }
    }
    if !report.inputs.iter().any(|i| matches!(i.role, Role::Motion | Role::Anchor)) {
        warnings.push(
            "No position was given: the direction of sliding comes from the tension alone, which is right only \
             while the far end stands still or moves little."
                .to_owned(),
        );
    }
    warnings.push(
        "Another specimen looks the same from the near side: after a change of tool, cable or sheath the band means \
         nothing until `sinew adapt` has seen a short log with the far side measured."
            .to_owned(),
    );
    warnings
}

/// Two sentences: what the model is good for, and what to do next.
pub(super) fn advice(found: &Found<'_>, report: &IdentificationReport) -> [String; 2] {
    let Some(chosen) = report.candidates.iter().find(|c| c.chosen) else {
        return [String::new(), String::new()];
    };
    let use_it = format!(
        "Use the model inside the ranges of these logs and expect an error of about {:.1} % of the range where \
         it has not been before.",
        chosen.percent_of_range
    );
    let mut sorted = chosen.fold_rmse.clone();
    sorted.sort_by(f64::total_cmp);
    let median = sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN);
    let worst = chosen.fold_rmse.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1));
    let next = if let Some(row) = report.influence.iter().find(|row| row.dropped) {
        format!(
            "Find out what was different when {} was recorded, and record it again if it matters.",
            row.log
        )
    } else if !found.folds.grouped {
        "Record a second log on another day: one log cannot say how much the transmission changes between days."
            .to_owned()
    } else if let Some((fold, error)) = worst.filter(|(_, error)| **error > UNEVEN * median) {
        format!(
            "Record more like {}: predicted without it, it is {:.1} times worse than the median.",
            held_out(found, fold),
            error / median
        )
    } else {
        "Run `sinew adapt` with a few trials whenever the specimen changes, and `sinew evaluate` on a fresh log now \
         and then."
            .to_owned()
    };
    [use_it, next]
}

/// The logs or conditions of a fold, in words.
fn held_out(found: &Found<'_>, fold: usize) -> String {
    let sequences = found.data.sequences.iter().zip(&found.folds.held_out[fold]);
    let held: Vec<_> = sequences.filter(|(_, range)| range.is_some()).map(|(s, _)| s).collect();
    for (c, condition) in found.data.conditions.iter().enumerate() {
        let mut values: Vec<&str> = held.iter().map(|s| s.condition_values[c].as_str()).collect();
        values.sort_unstable();
        values.dedup();
        if !values.is_empty() && values.len() < condition.values.len() && values.len() <= 4 {
            return format!("`{}` {}", condition.column, values.join(", "));
        }
    }
    let mut logs: Vec<&str> = held.iter().map(|s| found.data.logs[s.log].name.as_str()).collect();
    logs.dedup();
    logs.join(", ")
}
