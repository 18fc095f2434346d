//! `sinew compensate`.

use super::columns::{findings, findings_json};
use super::read_model;
use crate::answer::{Answer, Content};
use crate::arguments::{CompensateArguments, General};
use crate::csv_text::Csv;
use crate::error::Error;
use crate::output::{refuse_overwrite, write_all};
use crate::table::{number, percent};
use sinew::compensator::{CommandFlags, Compensator, CompensatorError, CompensatorSettings};
use sinew::predictor::{Model, ModelFileError};
use sinew_identify::compensate::{CommandRow, Desired, input_named};
use sinew_identify::evaluate::unit_in;
use sinew_identify::log::{ReadOptions, unit_of};

/// Flags that an answer counts, the first ones: the others only say where a sequence begins.
const COUNTED: usize = 5;

pub(crate) fn run(arguments: &CompensateArguments, general: &General) -> Result<Answer, Error> {
    let inputs = [&arguments.desired, &arguments.model];
    refuse_overwrite(inputs, std::slice::from_ref(&arguments.out), general.no_clobber)?;
    let mut compensator = compensator(arguments)?;
    if arguments.preview.is_some() && compensator.sliding().is_none() {
        let expected = "the observer of a cable, whose motor is commanded, for --preview".to_owned();
        let got = compensator.model().provenance.member.clone();
        let source = Box::new(ModelFileError { name: "law".to_owned(), expected, got });
        return Err(Error::Model { file: arguments.model.clone(), source });
    }
    let options = ReadOptions {
        skip_s: 0.0,
        far_required: false,
        paths: vec![arguments.desired.clone()],
        columns: arguments.columns.options(),
        ..ReadOptions::default()
    };
    let desired = Desired::read(&compensator, &options)?;
    let rows = desired.commands(&mut compensator, arguments.preview.unwrap_or(0.0));
    let text = csv_text(compensator.model(), &desired, &rows)?;
    let written = write_all(&[(arguments.out.clone(), text.as_bytes())])?;
    let (model, near) = (compensator.model(), &compensator.model().inputs[compensator.near()].column);
    let content = if general.json {
        let mut answer = serde_json::json!({
            "far": model.far, "far_unit": unit_in(model, &model.far), "near": near, "near_unit": unit_in(model, near),
            "commands": rows.len(), "error": error_of(&rows), "findings": findings_json(desired.data()),
        });
        for (name, count) in counts(&rows) {
            answer[name] = count.into();
        }
        Content::json(&answer)?
    } else {
        Content::Text(findings(desired.data()) + &summary(model, near, &rows))
    };
    Ok(Answer::done(content, written))
}

fn compensator(arguments: &CompensateArguments) -> Result<Compensator, Error> {
    let model = read_model(&arguments.model)?;
    let refused = |source| Error::Model { file: arguments.model.clone(), source: Box::new(source) };
    let near = match &arguments.near {
        None => None,
        Some(column) => Some(input_named(&model, column).ok_or_else(|| {
            let names: Vec<&str> = model.inputs.iter().map(|input| input.column.as_str()).collect();
            let expected = format!("--near to be one of {}", names.join(", "));
            refused(ModelFileError { name: "inputs".to_owned(), expected, got: column.clone() })
        })?),
    };
    let settings = CompensatorSettings {
        near,
        min: arguments.min,
        max: arguments.max,
        rate: arguments.max_rate,
        tolerance: arguments.tolerance,
    };
    Compensator::new(model, &settings).map_err(|error| match error {
        CompensatorError::Model(source) => refused(source),
        CompensatorError::Settings(error) => sinew_identify::Error::Physics(error).into(),
    })
}

/// How far the model's far end is from the desired one, far unit.
#[derive(serde::Serialize)]
struct Distance {
    rms: f64,
    /// 95 % of the samples are nearer.
    p95: f64,
    largest: f64,
}

/// None where nothing is desired.
fn error_of(rows: &[CommandRow]) -> Option<Distance> {
    let errors = rows.iter().map(|row| (row.command.mean - row.desired).abs());
    let mut errors: Vec<f64> = errors.filter(|error| error.is_finite()).collect();
    errors.sort_by(f64::total_cmp);
    let square: f64 = errors.iter().map(|error| error * error).sum();
    let place = (0.95 * errors.len() as f64) as usize;
    let (p95, largest) = (*errors.get(place)?, *errors.last()?);
    Some(Distance { rms: (square / errors.len() as f64).sqrt(), p95, largest })
}

/// The flags that are counted, with their counts.
fn counts(rows: &[CommandRow]) -> Vec<(&'static str, usize)> {
    let names = CommandFlags::default().named();
    let count = |k: usize| rows.iter().filter(|row| row.command.flags.named()[k].1).count();
    (0..COUNTED).map(|k| (names[k].0, count(k))).collect()
}

fn summary(model: &Model, near: &str, rows: &[CommandRow]) -> String {
    let fraction = |count: usize| percent(Some(count as f64 / rows.len().max(1) as f64));
    let mut text = format!("{} commands for `{near}` from desired `{}`\n", rows.len(), model.far);
    if let Some(Distance { rms, p95, largest }) = error_of(rows) {
        let unit = unit_in(model, &model.far);
        text += &format!(
            "the model's far end at these commands is off by {} {unit} rms, {} in 95 %, {} at most\n",
            number(Some(rms)),
            number(Some(p95)),
            number(Some(largest))
        );
    }
    for (name, count) in counts(rows).into_iter().filter(|(_, count)| *count > 0) {
        text += &format!("{name}: {count} ({})\n", fraction(count));
    }
    text
}

fn csv_text(model: &Model, desired: &Desired, rows: &[CommandRow]) -> Result<String, Error> {
    let (time, per_second) = match desired.time() {
        Some(name) if unit_of(name) == "ms" => (name, 1e3),
        Some(name) if unit_of(name) == "us" => (name, 1e6),
        Some(name) => (name, 1.0),
        None => ("time_s", 1.0),
    };
    let inputs = || model.inputs.iter().map(|input| input.column.as_str());
    let mut table = Csv::new();
    let ends = ["command_low", "command_high", "gate", "flags"];
    table.row(
        desired.trial().into_iter().chain([time]).chain(inputs()).chain([model.far.as_str()]).chain(ends),
    )?;
    for row in rows {
        let number = |x: f64| if x.is_nan() { String::new() } else { x.to_string() };
        let trial = desired.trial().map(|_| row.trial.clone());
        let numbers = [row.time_s * per_second].into_iter().chain(row.inputs.iter().copied());
        let command = [row.desired, row.command.low, row.command.high, row.command.gate];
        let cells = trial.into_iter().chain(numbers.chain(command).map(number));
        table.row(cells.chain([flags(&row.command.flags)]))?;
    }
    table.text()
}

/// Names of the flags that are set, separated by `|`.
fn flags(flags: &CommandFlags) -> String {
    let set = flags.named().into_iter().filter(|(_, set)| *set);
    set.map(|(name, _)| name).collect::<Vec<_>>().join("|")
}
