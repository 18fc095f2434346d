//! `sinew evaluate`.

use super::columns::{findings, findings_json};
use super::read_model;
use crate::answer::{Answer, Content};
use crate::arguments::{EvaluateArguments, General};
use crate::error::Error;
use crate::output::one_line;
use crate::table::{number, percent, table};
use sinew::predictor::{LoopQuantity, Model};
use sinew_identify::evaluate::{Evaluation, LogScores, Scores, SpecimenScore, evaluate, read_for};
use sinew_identify::log::ReadOptions;

pub(crate) fn run(arguments: &EvaluateArguments, general: &General) -> Result<Answer, Error> {
    let model = read_model(&arguments.model)?;
    let options = ReadOptions {
        skip_s: arguments.skip,
        far_required: true,
        paths: arguments.logs.clone(),
        columns: arguments.columns.options(),
        ..ReadOptions::default()
    };
    let data = read_for(&model, &options)?;
    let evaluation = evaluate(&model, &data, arguments.reading.anchor_reading)?;
    if general.json {
        let mut answer = serde_json::to_value(&evaluation)?;
        answer["findings"] = findings_json(&data);
        return Ok(Answer::done(Content::json(&answer)?, Vec::new()));
    }
    let mut text = findings(&data);
    if !text.is_empty() {
        text.push('\n');
    }
    Ok(Answer::done(Content::Text(text + &scores_table(&model, &evaluation)), Vec::new()))
}

/// Fraction of samples outside the ranges of the training logs from which a note is due.
pub(super) const NOTABLE_FRACTION: f64 = 0.02;

/// What the expected error does not cover; nothing where the logs stay inside the ranges.
fn range_note(model: &Model, scores: &Scores) -> String {
    if !scores.out_of_range.is_some_and(|fraction| fraction > NOTABLE_FRACTION) {
        return String::new();
    }
    format!(
        "\nNote: {} of the samples lie outside the ranges of the training logs (RMSE there {}, inside {}); {}.\n",
        percent(scores.out_of_range),
        number(scores.rmse_out_of_range),
        number(scores.rmse_in_range),
        outside_note(model),
    )
}

/// What the band says where the hysteresis is not known; nothing where that is the beginning of a log alone.
fn unknown_note(scores: &Scores) -> String {
    if !scores.state_unknown.is_some_and(|fraction| fraction > MOSTLY) {
        return String::new();
    }
    format!(
        "\nNote: at {} of the samples the state of the hysteresis is unknown, and the 95 % band is as wide as \
            friction allows: the far end has not slid for long enough, or noise of the displacements hides it; \
            a mean over more samples at a lower rate has less of it.\n",
        percent(scores.state_unknown)
    )
}

/// Fraction of samples with an unknown state from which a note is due.
const MOSTLY: f64 = 0.5;

/// What the expected error and the band say outside the ranges; completes a sentence.
pub(super) fn outside_note(model: &Model) -> String {
    match &model.outside {
        Some(outside) if outside.band_factor > model.band_factor => format!(
            "the 95 % band is {} times as wide there, by what was held out of the training logs outside the ranges \
                of the others",
            number(Some(outside.band_factor / model.band_factor))
        ),
        Some(_) => "the 95 % band is calibrated there as inside them".to_owned(),
        None => "the expected error and the 95 % band are for samples inside them".to_owned(),
    }
}

/// Scores as a table; the last column is the fraction of samples outside the ranges of the training logs.
pub(crate) fn scores_table(model: &Model, evaluation: &Evaluation) -> String {
    let row = |name: &str, fitted: &str, scores: &Scores| {
        vec![
            one_line(name),
            fitted.to_owned(),
            scores.n.to_string(),
            number(scores.mse),
            number(scores.rmse),
            number(scores.expected),
            number(scores.pearson),
            percent(scores.percent_of_range.map(|p| p / 100.0)),
            percent(scores.coverage95),
            percent(scores.out_of_range),
        ]
    };
    let fitted = |log: &LogScores| if log.in_training { "yes" } else { "no" };
    let mut rows: Vec<Vec<String>> =
        evaluation.logs.iter().map(|log| row(&log.log, fitted(log), &log.scores)).collect();
    rows.push(row("all", "", &evaluation.overall));
    let head = [
        model.far.as_str(),
        "in training",
        "samples",
        "MSE",
        "RMSE",
        "expected",
        "Pearson",
        "of range",
        "in 95 % band",
        "outside",
    ];
    let mut text = table(&head, &rows, 2);
    let seen = evaluation.logs.iter().filter(|log| log.in_training).count();
    if seen > 0 {
        text += &format!(
            "\nNote: {seen} of {} logs have the name of one that the model was fitted to; their errors are \
                not those on unseen data.\n",
            evaluation.logs.len()
        );
    }
    let specimen = specimen_note(model, evaluation.overall.specimen.as_ref());
    text + &failed_note(model, evaluation)
        + &range_note(model, &evaluation.overall)
        + &unknown_note(&evaluation.overall)
        + &specimen
}

/// Trials that are not of the specimen in training; nothing where all are, or none was judged.
pub(super) fn specimen_note(model: &Model, score: Option<&SpecimenScore>) -> String {
    let (Some(monitor), Some(score)) = (&model.specimen, score.filter(|score| score.other > 0)) else {
        return String::new();
    };
    let quantity = match score.most.quantity {
        LoopQuantity::Height => "height",
        LoopQuantity::Slope => "slope",
        LoopQuantity::Level => "level",
    };
    let column = |input: usize| one_line(&model.inputs[input].column);
    format!(
        "\nWarning: {} of {} trials look like another specimen than that of the training logs: the {quantity} of \
            the loop of {} over {} is {} where {} is expected. Neither the expected error nor the band holds; \
            `sinew adapt` fits the model to the new specimen.\n",
        score.other,
        score.judged,
        column(monitor.effort),
        column(monitor.motion),
        number(Some(score.most.value)),
        number(Some(score.most.expected)),
    )
}

/// Error inside the ranges over the expected one from which on a log is not predicted.
const NOT_PREDICTED: f64 = 3.0;

/// Logs that the model does not predict although their near side is inside the ranges of its training.
fn failed_note(model: &Model, evaluation: &Evaluation) -> String {
    let expected = model.provenance.rmse_unseen;
    let failed = evaluation.logs.iter().filter_map(|log| {
        let inside = log.scores.rmse_in_range.filter(|inside| *inside > NOT_PREDICTED * expected)?;
        let inverted = log.scores.pearson.is_some_and(|pearson| pearson < INVERTED);
        let sign = if inverted { "; it runs against the prediction: look for a swapped sign" } else { "" };
        let (name, ratio) = (one_line(&log.log), number(Some(inside / expected)));
        Some(format!(
            "Note: {name} is NOT predicted: its error inside the ranges is {ratio} times the \
            expected one{sign}.\n"
        ))
    });
    let failed: String = failed.collect();
    let narrow = evaluation.logs.iter().filter(|log| !log.in_training && log.scores.n >= MANY);
    let narrow = narrow.filter_map(|log| {
        let covered = log.scores.coverage95.filter(|covered| *covered < TOO_FEW)?;
        Some(format!(
            "Note: the 95 % band holds {} of {}: it is less like the training logs than they are like each other.\n",
            percent(Some(covered)),
            one_line(&log.log)
        ))
    });
    let notes = failed + &narrow.collect::<String>();
    if notes.is_empty() { notes } else { format!("\n{notes}") }
}

/// Fraction of a log's samples in the band below which that is said, where it has so many.
const TOO_FEW: f64 = 0.9;
const MANY: u64 = 200;

/// Correlation below which a far side runs against its prediction.
const INVERTED: f64 = -0.5;
