//! The page: everything that its template shows.

use super::differences::differences;
use super::plots::{scatters, strokes};
use super::tables::{ElongationRow, Row, Table, beyond, elongation, others, table1, tables23};
use super::verdict::{arm_verdict, figures, verdict};
use crate::error::Error;
use crate::format::fixed;
use crate::plot::Plot;
use crate::scene::scene_script;
use crate::shell::{SHELL, Shell};
use crate::tracking::{self, TrackView};
use askama::Template;
use sinew_lab::CompensationVariant;
use sinew_lab::paper::{self, SPEEDS};
use sinew_lab::reproduce::{ArmPart, BenchPart, BenchResults};

#[derive(Template)]
#[template(path = "reproduce.html")]
struct Page<'a> {
    shell: Shell,
    scene_script: String,
    seed: u64,
    quick: bool,
    verdict: String,
    figures: Vec<(&'static str, String, bool)>,
    speeds: Vec<String>,
    table1: Vec<Table>,
    uncompensated: String,
    figure7: Vec<Plot>,
    figure8: Vec<Plot>,
    mechanism: String,
    tables23: Vec<Table>,
    beyond: String,
    figure9: Vec<Plot>,
    /// Picture of one cable.
    cable: &'a str,
    elongation: Vec<ElongationRow>,
    stretch_range: String,
    others: Vec<Row>,
    /// The arm's sections as HTML; empty without the arm.
    arm: String,
    differences: Vec<String>,
    disagreements: Vec<&'static str>,
}

/// The whole page, with the arm's sections where the arm was part of the run.
pub fn render(part: &BenchPart, arm: Option<&ArmPart>, cable: &str, quick: bool) -> Result<String, Error> {
    let results = &part.results;
    let [rms, largest] = part.mechanism.differences();
    let page = Page {
        shell: SHELL,
        scene_script: scene_script(),
        seed: results.seed,
        quick,
        verdict: verdict(results) + &arm.map_or_else(String::new, arm_verdict),
        arm: arm.map(arm_sections).transpose()?.unwrap_or_default(),
        figures: figures(results, rms),
        speeds: SPEEDS.map(|v| fixed(v, 2)).to_vec(),
        table1: table1(results),
        uncompensated: uncompensated(results),
        figure7: [1, 5]
            .into_iter()
            .filter_map(|speed| strokes(part, CompensationVariant::None, speed, true))
            .collect(),
        figure8: [0, 2, 5]
            .into_iter()
            .flat_map(|speed| {
                [CompensationVariant::Paper, CompensationVariant::Observer].map(|variant| (variant, speed))
            })
            .filter_map(|(variant, speed)| strokes(part, variant, speed, false))
            .collect(),
        mechanism: format!(
            "Means over the steady windows of the calibration runs. The 24 means of the simulation deviate \
             from the paper’s by {} % rms and {} % max.",
            fixed(100.0 * rms, 1),
            fixed(100.0 * largest, 1)
        ),
        tables23: tables23(part),
        beyond: beyond(part),
        figure9: scatters(part),
        cable,
        elongation: elongation(results),
        stretch_range: fixed(results.elongation_mm.range, 0),
        others: others(results),
        differences: differences(part, arm),
        disagreements: paper::DISAGREEMENTS.to_vec(),
    };
    Ok(page.render()?)
}

/// The errors without compensation beside the paper's, which fit when they are exchanged.
fn uncompensated(results: &BenchResults) -> String {
    let ours = [results.uncompensated_mean_error_n.active, results.uncompensated_mean_error_n.passive];
    let reported = paper::UNCOMPENSATED_N;
    let deviation = |k: usize, other: usize| (ours[k] / reported[other] - 1.0).abs();
    let (straight, exchanged) = (deviation(0, 0).max(deviation(1, 1)), deviation(0, 1).max(deviation(1, 0)));
    let mut text = format!(
        "Without compensation, while the pulling end varies between 40 and 200 N, the mean difference \
            between the tensions of the two ends is {} N (active) and {} N (passive); the paper reports {} \
            and {} N.",
        fixed(ours[0], 1),
        fixed(ours[1], 1),
        fixed(reported[0], 1),
        fixed(reported[1], 1)
    );
    if exchanged < straight {
        text += &format!(
            " Exchanged, the paper’s numbers are within {} % of these. Its own Table II supports that: the \
                pulling end at 40 to 200 N, its mean efficiencies give {} N (active) and {} N (passive).",
            fixed(100.0 * exchanged, 0),
            fixed(120.0 * (1.0 - mean(&paper::EFFICIENCY[0])), 0),
            fixed(120.0 * (1.0 - 1.0 / mean(&paper::EFFICIENCY[1])), 0)
        );
    }
    text
}

fn mean(row: &[f64; 6]) -> f64 {
    row.iter().sum::<f64>() / 6.0
}

/// The arm's results as a section.
pub fn arm_view(part: &ArmPart) -> TrackView<'_> {
    let seconds = fixed(part.options.duration, 1);
    TrackView {
        heading: "Tracking with the arm".to_owned(),
        lead: format!(
            "{} muscles, two periods of a sine-shaped path in {seconds} s, {} with the observer, once {}. \
             The simulated arm deviates from the controller’s model in masses, attachments, friction and \
             sensor offsets; each cable is calibrated in a run of its own.",
            part.muscles.len(),
            match part.options.repeats {
                1 => "once".to_owned(),
                n => format!("{n} times"),
            },
            if part.options.all { "with every other variant" } else { "without compensation" }
        ),
        tracking: &part.tracking,
        injected: &[],
        trace: &part.trace,
        drawn: CompensationVariant::Observer,
        names: &part.muscles,
        joints: &part.joints,
        joint_units: &part.joint_units,
        gears: &[],
        robot: None,
        repeats: part.options.repeats,
        paper: true,
    }
}

fn arm_sections(part: &ArmPart) -> Result<String, Error> {
    tracking::section(&arm_view(part))
}
