//! `sinew evaluate`.

use super::read_model;
use crate::arguments::EvaluateArguments;
use crate::error::Error;
use crate::output::print;
use crate::table::{number, percent, table};
use sinew::predictor::Model;
use sinew_identify::evaluate::{Evaluation, Scores, evaluate, read_for};
use sinew_identify::log::ReadOptions;

pub(crate) fn run(arguments: &EvaluateArguments) -> Result<(), Error> {
    let model = read_model(&arguments.model)?;
    let options = ReadOptions { skip_s: arguments.skip, far_required: true, paths: arguments.logs.clone() };
    let data = read_for(&model, &options)?;
    let evaluation = evaluate(&model, &data)?;
    if arguments.json {
        return print(&(serde_json::to_string(&evaluation)? + "\n"));
    }
    let mut text = String::new();
    for log in &data.logs {
        for finding in &log.findings {
            text += &format!("{}: {finding}\n", log.name);
        }
    }
    if !text.is_empty() {
        text.push('\n');
    }
    print(&(text + &scores_table(&model, &evaluation)))
}

/// Scores as a table.
pub(crate) fn scores_table(model: &Model, evaluation: &Evaluation) -> String {
    let row = |name: &str, scores: &Scores| {
        vec![
            name.to_owned(),
            scores.n.to_string(),
            number(scores.mse),
            number(scores.rmse),
            number(scores.pearson),
            percent(scores.percent_of_range.map(|p| p / 100.0)),
            percent(scores.coverage95),
        ]
    };
    let mut rows: Vec<Vec<String>> = evaluation.logs.iter().map(|log| row(&log.log, &log.scores)).collect();
    rows.push(row("all", &evaluation.overall));
    let head = [model.far.as_str(), "samples", "MSE", "RMSE", "Pearson", "of range", "in 95 % band"];
    table(&head, &rows, 1)
}
