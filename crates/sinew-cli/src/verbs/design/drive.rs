//! `sinew design drive`.

use crate::answer::{Answer, Content, Outcome};
use crate::arguments::{DriveArguments, General};
use crate::error::Error;
use crate::table::{number, percent, table};
use crate::verbs::read_text;
use serde::Serialize;
use sinew::drive::Catalogue;
use sinew::drive::sizing::{Bound, Choice, Design, EnvelopePoint, Requirement, choose};
use std::path::Path;

/// Points of a printed envelope.
const ENVELOPE_POINTS: usize = 13;

pub(super) fn run(arguments: &DriveArguments, general: &General) -> Result<Answer, Error> {
    let required = requirement(arguments);
    let all = catalogue(arguments.catalogue.as_deref())?;
    let catalogue = all.for_drives(arguments.drives.as_deref());
    let choices = choose(&catalogue, &required)?;
    let answers: Vec<FoundDrive<'_>> =
        choices.iter().map(|choice| FoundDrive::new(choice, &required)).collect();
    let able = answers.iter().filter(|answer| answer.meets).count();
    let outcome = Outcome::new(able > 0);
    if general.json {
        let content = Content::json(&FoundDrives { choices: answers })?;
        return Ok(Answer { outcome, content, written: Vec::new() });
    }
    let mut text = format!("{able} of {} pairs of motor and reducer meet the requirement\n", answers.len());
    text += &summary_text(&answers);
    if let Some(first) = answers.first() {
        text += &format!(
            "\nEnvelope of {} with {} {} and {}\n",
            first.motor, first.reducer, first.ratio, first.winch
        );
        text += &envelope(&first.envelope);
    }
    Ok(Answer { outcome, content: Content::Text(text), written: Vec::new() })
}

fn requirement(arguments: &DriveArguments) -> Requirement {
    let DriveArguments { tension, speed, acceleration, stroke, .. } = *arguments;
    Requirement { tension, speed, acceleration, stroke }
}

fn catalogue(file: Option<&Path>) -> Result<Catalogue, Error> {
    let read = |file: &Path| Ok(Catalogue::from_toml(&file.to_string_lossy(), &read_text(file)?)?);
    file.map_or_else(|| Ok(Catalogue::built_in()?), read)
}

/// What is printed with `--json`.
#[derive(Debug, Serialize)]
struct FoundDrives<'a> {
    choices: Vec<FoundDrive<'a>>,
}

#[derive(Debug, Serialize)]
struct FoundDrive<'a> {
    meets: bool,
    motor: &'a str,
    reducer: &'a str,
    winch: &'a str,
    ratio: f64,
    radius_m: f64,
    /// An unbounded end is null.
    ratios: Option<[Option<f64>; 2]>,
    mass_kg: f64,
    mass_at_cable_kg: f64,
    copper_loss_w: f64,
    max_acceleration_m_per_s2: f64,
    limit: &'static str,
    used: f64,
    #[serde(skip)]
    here: [Bound; 2],
    envelope: Vec<Point>,
}

#[derive(Debug, Serialize)]
struct Point {
    speed_m_per_s: f64,
    continuous_n: f64,
    continuous_limit: &'static str,
    peak_n: f64,
    peak_limit: &'static str,
}

impl From<EnvelopePoint> for Point {
    fn from(point: EnvelopePoint) -> Self {
        Self {
            speed_m_per_s: point.speed,
            continuous_n: point.continuous.tension,
            continuous_limit: point.continuous.limit.name(),
            peak_n: point.peak.tension,
            peak_limit: point.peak.limit.name(),
        }
    }
}

impl<'a> FoundDrive<'a> {
    fn new(choice: &Choice<'a>, required: &Requirement) -> Self {
        let design: &Design = &choice.design;
        let (limit, used) = choice.demand.worst();
        let here = design.envelope_at(required.speed, 0.0);
        Self {
            meets: choice.demand.is_met(),
            motor: &choice.motor.name,
            reducer: &choice.reducer.name,
            winch: &choice.winch.name,
            ratio: design.reducer.ratio,
            radius_m: design.winch.radius,
            ratios: choice.ratios.map(|range| range.map(|end| Some(end).filter(|end| end.is_finite()))),
            mass_kg: design.mass,
            mass_at_cable_kg: design.mass_at_cable(),
            copper_loss_w: choice.copper_loss,
            max_acceleration_m_per_s2: design.acceleration(required.tension, required.speed),
            limit: limit.name(),
            used,
            here: [here.continuous, here.peak],
            envelope: design.envelope(ENVELOPE_POINTS).into_iter().map(Point::from).collect(),
        }
    }
}

fn summary_text(answers: &[FoundDrive<'_>]) -> String {
    let end = |end: Option<f64>| end.map_or_else(|| "any".to_owned(), |end| format!("{end:.1}"));
    let row = |answer: &FoundDrive<'_>| {
        vec![
            if answer.meets { "yes" } else { "no" }.to_owned(),
            answer.motor.to_owned(),
            answer.reducer.to_owned(),
            answer.winch.to_owned(),
            answer.limit.to_owned(),
            percent(Some(answer.used)),
            answer.ratio.to_string(),
            answer
                .ratios
                .map_or_else(|| "-".to_owned(), |[low, high]| format!("{}..{}", end(low), end(high))),
            number(Some(answer.mass_kg)),
            number(Some(answer.mass_at_cable_kg)),
            number(Some(answer.copper_loss_w)),
            number(Some(answer.here[0].tension)),
            number(Some(answer.here[1].tension)),
            number(Some(answer.max_acceleration_m_per_s2)),
        ]
    };
    let head = [
        "meets",
        "motor",
        "reducer",
        "winch",
        "nearest limit",
        "used",
        "ratio",
        "ratios",
        "kg",
        "kg at cable",
        "copper W",
        "continuous N",
        "peak N",
        "max m/s2",
    ];
    table(&head, &answers.iter().map(row).collect::<Vec<_>>(), 5)
}

fn envelope(points: &[Point]) -> String {
    let row = |point: &Point| {
        vec![
            point.continuous_limit.to_owned(),
            point.peak_limit.to_owned(),
            number(Some(point.speed_m_per_s)),
            number(Some(point.continuous_n)),
            number(Some(point.peak_n)),
        ]
    };
    let head = ["continuous limit", "peak limit", "m/s", "continuous N", "peak N"];
    table(&head, &points.iter().map(row).collect::<Vec<_>>(), 2)
}
