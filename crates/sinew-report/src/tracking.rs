//! Tracking with the arm: errors, end point and muscles, as a section of the reproduction or as a page of its
//! own.

use super::error::Error;
use super::format::{NONE, fixed};
use super::plot::Plot;
use super::tracking_plots::{end_point, errors, lengths, means};
use super::variants::label;
use askama::Template;
use sinew_lab::CompensationVariant;
use sinew_lab::arm::{TraceRow, TrackIncident, TrackOutcome, TrackingNumbers};
use sinew_lab::paper;
use std::collections::BTreeMap;

#[derive(Template)]
#[template(path = "tracking.html")]
struct Section {
    heading: String,
    lead: String,
    rows: Vec<Row>,
    end_point: Vec<Plot>,
    lengths: Vec<Plot>,
    means: Vec<Plot>,
    errors: Vec<Plot>,
    repeats: u32,
    remarks: Vec<String>,
    incidents: Vec<String>,
    paper: bool,
}

#[derive(Template)]
#[template(path = "track.html")]
struct Page<'a> {
    version: &'static str,
    style: &'static str,
    script: &'static str,
    title: &'a str,
    amount: &'a str,
    verdict: String,
    section: String,
}

struct Row {
    name: &'static str,
    ours: bool,
    cells: Vec<(&'static str, String)>,
    ended: String,
}

/// Results of tracking, as they are shown.
#[derive(Debug)]
pub struct TrackView<'a> {
    /// Above the table.
    pub heading: String,
    /// Below the heading.
    pub lead: String,
    /// By variant.
    pub tracking: &'a BTreeMap<CompensationVariant, TrackingNumbers>,
    /// Trace of the plotted run.
    pub trace: &'a [TraceRow],
    /// Variant of the plotted run.
    pub drawn: CompensationVariant,
    /// Names of the muscles.
    pub names: &'a [String],
    /// Repeats of the plotted run.
    pub repeats: u32,
    /// Whether the run is that of the paper, whose results are then a row of the table.
    pub paper: bool,
}

const LABELS: [&str; 6] = [
    "mean, mm",
    "std, mm",
    "max, mm",
    "muscle length, mm",
    "min. anchor tension, N",
    "max. drive tension, N",
];

/// The section, to be put into a page.
pub(crate) fn section(view: &TrackView<'_>) -> Result<String, Error> {
    let numbers = view.tracking.get(&view.drawn);
    let moving: Vec<&TraceRow> = view.trace.iter().filter(|row| row.repeat.is_some()).collect();
    let section = Section {
        heading: view.heading.clone(),
        lead: view.lead.clone(),
        rows: rows(view),
        end_point: end_point(&moving),
        lengths: lengths(&moving, view.names, view.repeats),
        means: numbers.map_or_else(Vec::new, |numbers| means(&numbers.per_muscle)),
        errors: errors(&moving, view.names, view.repeats),
        repeats: view.repeats,
        remarks: remarks(view),
        incidents: incidents(view),
        paper: view.paper,
    };
    Ok(section.render()?)
}

/// A page of its own.
pub fn page(view: &TrackView<'_>, title: &str, amount: &str) -> Result<String, Error> {
    let numbers = view.tracking.get(&view.drawn);
    let verdict = numbers.map_or_else(String::new, |n| match (&n.stopped_by, n.stopped_s) {
        (Some(why), time) => format!(
            "The controller stopped the arm {} s after the start of the run: {why}.",
            fixed(time.unwrap_or(f64::NAN), 2)
        ),
        (None, Some(time)) => {
            format!("The simulation diverged {} s after the start of the run.", fixed(time, 2))
        }
        (None, None) => format!(
            "End point error: {} mm mean, {} mm max.",
            fixed(1e3 * n.end_point_error_m.mean, 2),
            fixed(1e3 * n.end_point_error_m.max, 1)
        ),
    });
    let page = Page {
        version: env!("CARGO_PKG_VERSION"),
        style: include_str!("../assets/report.css"),
        script: include_str!("../assets/report.js"),
        title,
        amount,
        verdict,
        section: section(view)?,
    };
    Ok(page.render()?)
}

/// Further results of the plotted run.
fn remarks(view: &TrackView<'_>) -> Vec<String> {
    let Some(numbers) = view.tracking.get(&view.drawn) else { return Vec::new() };
    let mut remarks = Vec::new();
    let unseen = numbers.unseen_error_m;
    let [mean, max] = [(unseen.mean, 2), (unseen.max, 1)].map(|(m, digits)| fixed(1e3 * m, digits));
    remarks.push(format!(
        "Lower bound of the mean error from encoder zero offsets: {mean} mm (max {max}); it cannot be observed without a \
         sensor at the end point."
    ));
    let repeats = &numbers.end_point_error_per_repeat_m;
    if repeats.len() > 1 {
        let means: Vec<String> = repeats.iter().map(|repeat| fixed(1e3 * repeat.mean, 2)).collect();
        remarks.push(format!("Mean error by repeat: {} mm.", means.join(", ")));
    }
    if let Some(hold) = numbers.hold {
        let e = hold.end_point_error_m;
        let [mean, max] = [(e.mean, 2), (e.max, 2)].map(|(m, digits)| fixed(1e3 * m, digits));
        let [unrest, unseen] = [hold.tension_unrest_n, 1e3 * hold.unseen_error_m].map(|x| fixed(x, 2));
        remarks.push(format!(
            "Mean error while holding: {mean} mm (max {max}), lower bound from encoder zero offsets: {unseen} mm. \
             Tension ripple while holding: {unrest} N rms."
        ));
    }
    remarks
}

/// Faults of the plotted run with their intervals and the controller's response.
fn incidents(view: &TrackView<'_>) -> Vec<String> {
    let Some(numbers) = view.tracking.get(&view.drawn) else { return Vec::new() };
    let each = numbers.incidents.iter();
    each.map(|one| {
        let (from, until) = (fixed(one.from_s, 3), fixed(one.until_s, 3));
        format!("{from} to {until} s: {}, {}", one.what, response(one))
    })
    .collect()
}

/// The controller's response to a fault.
pub fn response(incident: &TrackIncident) -> &'static str {
    match incident.answer.as_str() {
        "stopped" => "arm stopped",
        _ => "run continued",
    }
}

fn rows(view: &TrackView<'_>) -> Vec<Row> {
    let mut rows = Vec::new();
    for variant in CompensationVariant::ALL {
        let Some(n) = view.tracking.get(&variant) else { continue };
        let e = &n.end_point_error_m;
        let cells = [
            fixed(1e3 * e.mean, 2),
            fixed(1e3 * e.std, 2),
            fixed(1e3 * e.max, 1),
            fixed(1e3 * n.muscle_length_error_m.mean, 3),
            fixed(n.least_anchor_tension_n, 1),
            fixed(n.most_drive_tension_n, 0),
        ];
        let ended = match (&n.stopped_by, n.stopped_s) {
            (Some(why), Some(time)) => format!("stopped at {} s: {why}", fixed(time, 1)),
            (None, Some(time)) => format!("diverged at {} s", fixed(time, 1)),
            _ if n.ended == TrackOutcome::Completed => "completed".to_owned(),
            _ => n.reason.clone().unwrap_or_default(),
        };
        rows.push(Row {
            name: label(variant),
            ours: variant == CompensationVariant::Observer,
            cells: LABELS.into_iter().zip(cells).collect(),
            ended,
        });
    }
    if view.paper {
        let [mean_mm, std_mm, max_mm] = paper::END_POINT_ERROR_MM;
        let cells = [
            fixed(mean_mm, 2),
            fixed(std_mm, 2),
            fixed(max_mm, 1),
            fixed(paper::MUSCLE_LENGTH_ERROR_MM, 3),
            NONE.to_owned(),
            NONE.to_owned(),
        ];
        let cells = LABELS.into_iter().zip(cells).collect();
        rows.push(Row { name: "the paper, measured", ours: false, cells, ended: "six repeats".to_owned() });
    }
    rows
}
