//! Identification of logs, scores and predictions.

use crate::Answer;
use serde::Deserialize;
use serde_json::{Value, json};
use sinew::predictor::{Model, Predictor, Sample};
use sinew_identify::evaluate::{evaluate, predict, read_for};
use sinew_identify::identify::{Options, identify};
use sinew_identify::log::{ReadOptions, RequestedRoles, read_dataset};
use std::path::PathBuf;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Identify {
    logs: Vec<PathBuf>,
    unseen: Vec<PathBuf>,
    far: String,
    models: Vec<String>,
    seed: u64,
}

impl Identify {
    pub(crate) fn answer(&self) -> Answer {
        let roles = RequestedRoles { far: Some(self.far.clone()), ..RequestedRoles::default() };
        let options = |paths: &[PathBuf]| ReadOptions {
            far_required: true,
            paths: paths.to_vec(),
            ..ReadOptions::default()
        };
        let data = read_dataset(&roles, &options(&self.logs))?;
        let choice = Options { seed: self.seed, models: self.models.clone(), ..Options::default() };
        let found = identify(&data, &choice, &|_, _| {})?;
        let unseen = read_for(&found.model, &options(&self.unseen))?;
        let predictions = predict(&found.model, &unseen, None)?.rows;
        let means: Vec<f64> = predictions.iter().flatten().map(|prediction| prediction.mean).collect();
        let mut report = serde_json::to_value(&found.report)?;
        report["traces"] = json!([]);
        let evaluation = serde_json::to_value(evaluate(&found.model, &unseen, None)?)?;
        let (model, page) = (found.model.to_json()?, sinew_report::render(&found.report)?);
        Ok(
            json!({ "model": model, "report": report, "page": page, "evaluation": evaluation, "means": means }),
        )
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Predict {
    model: String,
    time: Vec<f64>,
    inputs: Vec<Vec<f64>>,
}

impl Predict {
    pub(crate) fn answer(&self) -> Answer {
        let mut predictor = Predictor::new(Model::from_json(&self.model)?)?;
        let rows = self.time.iter().zip(&self.inputs);
        let rows: Vec<Value> = rows
            .map(|(time_s, inputs)| {
                let found = predictor.step(&Sample { time_s: *time_s, inputs });
                json!([found.mean, found.standard_deviation, found.half_width(), found.gate])
            })
            .collect();
        Ok(Value::Array(rows))
    }
}
