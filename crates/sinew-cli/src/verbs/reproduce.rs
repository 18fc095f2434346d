//! `sinew reproduce`.

use super::{track, twin};
use crate::answer::{Answer, Content, Outcome};
use crate::arguments::{General, Part, ReproduceArguments};
use crate::error::Error;
use crate::output::{Folder, refuse_overwrite, write_all};
use crate::progress::Progress;
use crate::table::{number, table};
use serde_json::Value;
use sinew_lab::CompensationVariant;
use sinew_lab::arm::TrackOutcome;
use sinew_lab::machine_file::load_machine;
use sinew_lab::paper;
use sinew_lab::reproduce::{
    ArmOptions, ArmPart, BenchOptions, BenchPart, Indices, Sides, reproduce_arm, reproduce_bench,
};
use sinew_report::{reproduction, tracking};
use std::path::Path;

pub(crate) fn run(arguments: &ReproduceArguments, general: &General) -> Result<Answer, Error> {
    let folder = Folder::open(&arguments.out)?;
    let (report, results) = (folder.file("report.html"), folder.file("results.json"));
    refuse_overwrite([], &[report.clone(), results.clone()], general.no_clobber)?;
    let progress = Progress::new();
    let (quick, seed) = (arguments.quick, arguments.seed);
    let both = arguments.part == Part::All;
    let bench = (both || arguments.part == Part::Bench)
        .then(|| {
            let options = if quick { BenchOptions::quick(seed) } else { BenchOptions::full(seed) };
            let fraction = if both { 0.6 } else { 1.0 };
            reproduce_bench(&options, &|stage, done| progress.show(stage, fraction * done))
        })
        .transpose()?;
    let arm = (both || arguments.part == Part::Arm)
        .then(|| {
            let machine = load_machine(Path::new("lm_arm"), None)?.machine;
            let options = if quick { ArmOptions::quick(seed) } else { ArmOptions::full(seed) };
            let begin = if both { 0.6 } else { 0.0 };
            let part = reproduce_arm(&machine, &options, &|stage, done| {
                progress.show(stage, begin + (1.0 - begin) * done);
            })?;
            Ok::<_, Error>(part)
        })
        .transpose()?;
    drop(progress);
    let numbers = numbers(bench.as_ref(), arm.as_ref(), seed)?;
    let json = serde_json::to_string_pretty(&numbers)? + "\n";
    let page = page(bench.as_ref(), arm.as_ref(), quick)?;
    let written = write_all(&[(report, page.as_bytes()), (results, json.as_bytes())])?;
    // Without compensation the arm is stopped: that is a result of the programme, not a failure of it.
    let completed = |part: &ArmPart| {
        let observer = part.tracking.get(&CompensationVariant::Observer);
        observer.is_none_or(|numbers| numbers.ended == TrackOutcome::Completed)
    };
    let outcome = Outcome::new(arm.as_ref().is_none_or(completed));
    if general.json {
        return Ok(Answer { outcome, content: Content::json(&numbers)?, written });
    }
    let mut text = bench.as_ref().map_or_else(String::new, |part| summary_text(part) + "\n");
    if let Some(part) = &arm {
        let [mean_mm, _, max_mm] = paper::END_POINT_ERROR_MM;
        text += &track::tracking_table(&part.tracking);
        text += &format!("The paper reports {mean_mm} mm mean and {max_mm} mm max.\n\n");
    }
    Ok(Answer { outcome, content: Content::Text(text), written })
}

/// Everything as one object.
fn numbers(bench: Option<&BenchPart>, arm: Option<&ArmPart>, seed: u64) -> Result<Value, Error> {
    let mut all = match bench {
        Some(part) => serde_json::to_value(&part.results)?,
        None => serde_json::json!({"simulated": true, "seed": seed}),
    };
    if let (Some(part), Some(object)) = (arm, all.as_object_mut()) {
        object.insert("tracking".to_owned(), serde_json::to_value(&part.tracking)?);
    }
    Ok(all)
}

fn page(bench: Option<&BenchPart>, arm: Option<&ArmPart>, quick: bool) -> Result<String, Error> {
    match (bench, arm) {
        (Some(part), arm) => Ok(reproduction::render(part, arm, &twin::two_strokes()?, quick)?),
        (None, Some(part)) => {
            let amount = format!("Seed {}. All results are simulated.", part.options.seed);
            Ok(tracking::page(&reproduction::arm_view(part), "The paper’s arm in simulation", &amount)?)
        }
        (None, None) => Ok(String::new()),
    }
}

/// Table I for the terminal.
fn summary_text(part: &BenchPart) -> String {
    let results = &part.results;
    let mut rows = Vec::new();
    for (name, sides) in &results.table1 {
        let (estimate, cycles) = (results.table1_estimate.get(name), results.table1_cycles.get(name));
        let of = |side: fn(&Sides<Indices>) -> &Indices, muscle: &str| {
            let maximum = |indices: Option<&Indices>| {
                number(indices.map(|i| i.rmse_n.iter().copied().fold(f64::NAN, f64::max)))
            };
            vec![
                name.to_string(),
                muscle.to_owned(),
                maximum(Some(side(sides))),
                maximum(estimate.map(side)),
                maximum(cycles.map(side)),
            ]
        };
        rows.push(of(|s| &s.active, "active"));
        rows.push(of(|s| &s.passive, "passive"));
    }
    let head = ["SIMULATED bench", "muscle", "tracking, N rms", "estimation", "tracking, whole cycles"];
    let mut text = table(&head, &rows, 2);
    let [active, passive] = reproduction::paper_mean_rmse();
    text += &format!(
        "Maxima over the six speeds. The paper reports tracking errors of {active:.2} N (active) and \
         {passive:.2} N (passive), averaged over the speeds.\n"
    );
    text
}
