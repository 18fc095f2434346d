//! `sinew predict`.

use super::columns::{findings, findings_json};
use super::evaluate::{NOTABLE_FRACTION, outside_note, specimen_note};
use super::read_model;
use crate::answer::{Answer, Content};
use crate::arguments::{General, PredictArguments};
use crate::csv_text::Csv;
use crate::error::Error;
use crate::output::{refuse_overwrite, write_all};
use crate::table::percent;
use sinew::predictor::{Flags, Model, Prediction};
use sinew_identify::evaluate::{SpecimenScore, predict, read_for, unit_in};
use sinew_identify::log::{Dataset, ReadOptions};

pub(crate) fn run(arguments: &PredictArguments, general: &General) -> Result<Answer, Error> {
    let inputs = arguments.logs.iter().chain([&arguments.model]);
    refuse_overwrite(inputs, std::slice::from_ref(&arguments.out), general.no_clobber)?;
    let model = read_model(&arguments.model)?;
    let options = ReadOptions {
        skip_s: 0.0,
        far_required: false,
        paths: arguments.logs.clone(),
        columns: arguments.columns.options(),
        ..ReadOptions::default()
    };
    let data = read_for(&model, &options)?;
    let predictions = predict(&model, &data, arguments.reading.anchor_reading)?;
    let text = csv_text(&data, &predictions.rows)?;
    let written = write_all(&[(arguments.out.clone(), text.as_bytes())])?;
    let (mut rows, mut unknown, mut outside) = (0_usize, 0_usize, 0_usize);
    for prediction in predictions.rows.iter().flatten() {
        rows += 1;
        unknown += usize::from(prediction.flags.state_unknown);
        outside += usize::from(prediction.flags.out_of_range);
    }
    let specimen = SpecimenScore::of(predictions.specimen.iter().copied());
    let fraction = outside as f64 / rows.max(1) as f64;
    let content = if general.json {
        Content::json(&serde_json::json!({
            "far": model.far, "far_unit": unit_in(&model, &model.far), "predictions": rows, "state_unknown": unknown, "out_of_range": outside,
            "specimen": specimen, "findings": findings_json(&data),
        }))?
    } else {
        let note = specimen_note(&model, specimen.as_ref());
        Content::Text(findings(&data) + &summary(&model, rows, unknown, outside, fraction) + &note)
    };
    Ok(Answer::done(content, written))
}

fn summary(model: &Model, rows: usize, unknown: usize, outside: usize, fraction: f64) -> String {
    let mut text = format!(
        "{rows} predictions of `{}`; the state of the hysteresis is unknown in {unknown}, {outside} lie \
            outside the range of the training logs\n",
        model.far
    );
    if fraction > NOTABLE_FRACTION {
        text += &format!(
            "Warning: {} of the samples lie outside the ranges of the training logs; {}.\n",
            percent(Some(fraction)),
            outside_note(model)
        );
    }
    text
}

fn csv_text(data: &Dataset, predictions: &[Vec<Prediction>]) -> Result<String, Error> {
    let mut table = Csv::new();
    table.row(["log", "trial", "time_s", "prediction", "standard_deviation", "gate", "flags"])?;
    for (sequence, predictions) in data.sequences.iter().zip(predictions) {
        let log = &data.logs[sequence.log].name;
        for (time, p) in sequence.time_s.iter().zip(predictions) {
            let numbers = [*time, p.mean, p.standard_deviation, p.gate].map(|x| x.to_string());
            let [time, mean, deviation, gate] = &numbers;
            table.row([log, &sequence.trial, time, mean, deviation, gate, &flags(p.flags)])?;
        }
    }
    table.text()
}

/// Names of the flags that are set, separated by `|`.
fn flags(flags: Flags) -> String {
    let names = [
        (flags.state_unknown, "state_unknown"),
        (flags.out_of_range, "out_of_range"),
        (flags.input_held, "input_held"),
        (flags.reset, "reset"),
        (flags.other_specimen, "other_specimen"),
    ];
    names.iter().filter(|(set, _)| *set).map(|(_, name)| *name).collect::<Vec<_>>().join("|")
}
