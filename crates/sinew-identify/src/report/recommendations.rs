//! Limits of an identification, and what to do next.

use super::assessment::{Assessment, MIN_COVERAGE};
use super::evidence::Evidence;
use super::types::{Grade, IdentificationReport, Noticed};
use crate::select::cross_validation::FoldScore;
use sinew::predictor::{Beyond, LoopQuantity, Role};

/// Ratio of the largest fold error to the median from which that fold's conditions deserve a log of their
/// own.
const UNEVEN: f64 = 1.8;

/// Limits of the identification, most important first.
pub(super) fn warnings(
    evidence: &Evidence<'_>,
    report: &IdentificationReport,
    poor: &[String],
) -> Vec<String> {
    let mut warnings = Vec::new();
    for row in report.influence.iter().filter(|row| row.dropped) {
        warnings.push(format!("{} was left out. {}", row.log, row.remark));
    }
    for log in &report.logs {
        let sentences = log.defects.iter().map(|defect| format!("{}: {}.", log.name, defect.sentence));
        warnings.extend(sentences);
    }
    let Some(chosen) = report.candidates.iter().find(|c| c.chosen) else { return warnings };
    if chosen.coverage95 < MIN_COVERAGE {
        warnings.push(format!(
            "Only {:.0} % of the unseen samples lie inside the 95 % band: it is too narrow for some \
                conditions.",
            100.0 * chosen.coverage95
        ));
    }
    warnings.extend(poor.iter().map(|limit| format!("{}.", capitalised(limit))));
    let weights = || evidence.logs.runs.iter().flat_map(|run| &run.weight);
    let (unscored, all) = (weights().filter(|w| **w == 0.0).count(), weights().count());
    if 2 * unscored > all {
        warnings.push(format!("{unscored} of {all} samples do not count: skipped, missing or spikes."));
    }
    for (input, limits) in report.inputs.iter().zip(&evidence.model.guards) {
        if limits.high - limits.low <= 1e-9 * limits.high.abs().max(1e-9) {
            let name = &input.column;
            warnings.push(format!("`{name}` is constant in these logs: its effect is not identified."));
        }
    }
    if !report.inputs.iter().any(|i| matches!(i.role, Role::Motion | Role::Anchor)) {
        warnings.push(
            "No position was given: the direction of sliding comes from the tension alone, which is right \
                only while the far end stands still or moves little."
                .to_owned(),
        );
    }
    warnings.push(specimen(evidence, report));
    warnings
}

/// Which change of specimen is noticed, and what to do after one.
fn specimen(evidence: &Evidence<'_>, report: &IdentificationReport) -> String {
    let adapt = "after a change of tool, cable or sheath the band is not valid until the model has been adapted \
                 to a short log with the far side measured";
    let Some(monitor) = &evidence.model.specimen else {
        let because = evidence.not_monitored.as_deref().unwrap_or_default();
        return format!("A change of specimen is not noticed, because {because}: {adapt}.");
    };
    let (effort, motion) = (&report.inputs[monitor.effort].column, &report.inputs[monitor.motion].column);
    let change = |noticed: &Noticed| {
        let percent = 100.0 * noticed.change / noticed.mean.abs();
        let what = match noticed.quantity {
            LoopQuantity::Height => "height (friction)",
            LoopQuantity::Slope => "slope (stiffness)",
            LoopQuantity::Level => "level (pretension, load)",
        };
        format!("its {what} by {percent:.0} %")
    };
    let changes: Vec<String> = report.specimen.iter().map(change).collect();
    format!(
        "Another specimen is noticed where the loop of `{effort}` over `{motion}` changes: {}; a change that does \
            not show there is not, and {adapt}.",
        changes.join(", ")
    )
}

/// Two sentences: whether and where the model can be used with which error, and what to do next.
pub(super) fn recommendations(
    evidence: &Evidence<'_>,
    report: &IdentificationReport,
    assessment: &Assessment,
) -> [String; 2] {
    let expected = report.expected.percent_of_range;
    let kind = if evidence.folds.grouped { "new logs" } else { "later stretches of the same day" };
    let error = format!(
        "expect an error of about {expected:.1} % of the range on {kind}{}{}{}",
        fold_range(evidence, report.expected.rmse),
        in_words(&report.beyond, report.far_range, report.expected.rmse),
        references(evidence, assessment)
    );
    let because = assessment.reasons.join("; ");
    let validity = match assessment.grade {
        Grade::Use => format!("Use the model inside the ranges of these logs and {error}."),
        Grade::UseWithCare => {
            format!("Use the model with care, inside the ranges of these logs, because {because}; {error}.")
        }
        Grade::DoNotUse => format!("Do not use the model, because {because}; {error}."),
    };
    let next = match assessment.grade {
        Grade::DoNotUse => {
            "Check the roles and the synchronisation of the signals, and record logs in which the near side \
                            moves through the whole range in both directions."
                .to_owned()
        }
        _ => next_step(evidence, report),
    };
    [validity, next]
}

/// The errors of the two references, in words.
fn references(evidence: &Evidence<'_>, assessment: &Assessment) -> String {
    let percent = |rmse: f64| 100.0 * rmse / evidence.model.provenance.far_range;
    match (assessment.constant, assessment.linear) {
        (Some(constant), Some(linear)) => {
            format!(
                "; a constant has {:.1} %, a linear regression {:.1} %",
                percent(constant),
                percent(linear)
            )
        }
        (Some(constant), None) => format!("; a constant has {:.1} %", percent(constant)),
        _ => String::new(),
    }
}

/// With a capital letter, unless it begins with a name.
fn capitalised(sentence: &str) -> String {
    let mut characters = sentence.chars();
    characters.next().map_or_else(String::new, |first| first.to_uppercase().chain(characters).collect())
}

/// The smallest and the largest fold error of the chosen model, in words, and why the expected error is not
/// its RMSE where the two differ; nothing with a single fold.
fn fold_range(evidence: &Evidence<'_>, expected: f64) -> String {
    let validation = evidence.scored[evidence.chosen].validation();
    let errors: Vec<f64> = validation.map_or_else(Vec::new, |v| v.folds.iter().map(|f| f.rmse).collect());
    if errors.len() < 2 {
        return String::new();
    }
    let percent = |rmse: f64| 100.0 * rmse / evidence.model.provenance.far_range;
    let (least, most) = errors.iter().fold((f64::MAX, 0.0_f64), |(l, m), e| (l.min(*e), m.max(*e)));
    let range = format!("{:.1} to {:.1} % fold by fold", percent(least), percent(most));
    let rmse = validation.and_then(|v| v.comparison.rmse()).unwrap_or(expected);
    if (expected / rmse - 1.0).abs() < 0.02 {
        return format!(" ({range})");
    }
    format!(", the choice among the models included (the chosen one alone {:.1} %, {range})", percent(rmse))
}

fn next_step(evidence: &Evidence<'_>, report: &IdentificationReport) -> String {
    let dropped: Vec<&str> =
        report.influence.iter().filter(|row| row.dropped).map(|row| row.log.as_str()).collect();
    if let Some((last, before)) = dropped.split_last() {
        let names =
            if before.is_empty() { (*last).to_owned() } else { format!("{} and {last}", before.join(", ")) };
        let (were, them) = if before.is_empty() { ("was", "it") } else { ("were", "them") };
        return format!(
            "Find out what was different when {names} {were} recorded, and record {them} again if it matters."
        );
    }
    if !evidence.folds.grouped {
        return "Record a second log on another day: one log does not show the change between days."
            .to_owned();
    }
    let validation = evidence.scored[evidence.chosen].validation();
    let folds = validation.map_or(&[][..], |validation| validation.folds.as_slice());
    if let Some((fold, ratio)) = uneven_fold(folds) {
        let held_out = held_out(evidence, fold);
        return format!(
            "Record more like {held_out}: predicted without it, the error is {ratio:.1} times the median."
        );
    }
    "Adapt the model with a few trials whenever the specimen changes, and evaluate it on a fresh log now and then."
        .to_owned()
}

/// The fold of the largest error, and its ratio to the median, where that is above [`UNEVEN`].
fn uneven_fold(folds: &[FoldScore]) -> Option<(usize, f64)> {
    let mut sorted: Vec<&FoldScore> = folds.iter().collect();
    sorted.sort_by(|a, b| a.rmse.total_cmp(&b.rmse));
    let (median, worst) = (sorted.get(sorted.len() / 2)?, sorted.last()?);
    (worst.rmse > UNEVEN * median.rmse).then(|| (worst.fold, worst.rmse / median.rmse))
}

/// The logs or conditions of a fold, in words.
fn held_out(evidence: &Evidence<'_>, fold: usize) -> String {
    let data = &evidence.logs.data;
    let sequences = data.sequences.iter().zip(&evidence.folds.held_out[fold]);
    let held: Vec<_> = sequences.filter(|(_, range)| range.is_some()).map(|(s, _)| s).collect();
    for (c, condition) in data.conditions.iter().enumerate() {
        let mut values: Vec<&str> = held.iter().map(|s| s.condition_values[c].as_str()).collect();
        values.sort_unstable();
        values.dedup();
        if !values.is_empty() && values.len() < condition.values.len() && values.len() <= 4 {
            return format!("`{}` {}", condition.column, values.join(", "));
        }
    }
    let mut logs: Vec<&str> = held.iter().map(|s| data.logs[s.log].name.as_str()).collect();
    logs.dedup();
    logs.join(", ")
}

/// What to expect one step beyond either side of a condition, at least what is expected inside, in words;
/// nothing without conditions.
fn in_words(beyond: &[Beyond], range: f64, inside: f64) -> String {
    let one = |side: &Beyond| {
        let at = side.outermost + side.step;
        let percent = 100.0 * side.expected(at).max(inside) / range;
        format!("at `{}` {at} expect {percent:.1} %", side.column)
    };
    let sides: Vec<String> = beyond.iter().map(one).collect();
    if sides.is_empty() { String::new() } else { format!("; beyond them {}", sides.join(", ")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_to_expect_one_step_beyond_is_said_of_every_side() {
        let side = Beyond { column: "load".into(), outermost: 60.0, step: 20.0, rmse: 2.0 };
        let sides = [side];
        assert_eq!(in_words(&sides, 50.0, 1.0), "; beyond them at `load` 80 expect 4.0 %");
        assert_eq!(in_words(&sides, 50.0, 3.0), "; beyond them at `load` 80 expect 6.0 %");
        assert!(in_words(&[], 50.0, 1.0).is_empty());
    }
}
