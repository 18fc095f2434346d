//! An arm along a trajectory: errors, end point, muscles; the section of a reproduction, or a page of its own.

use super::error::Error;
use super::format::{NONE, fixed};
use super::plot::Plot;
use super::scale::{Axis, padded};
use super::svg_path::line;
use askama::Template;
use sinew_lab::CompensationVariant;
use sinew_lab::arm::{TraceRow, TrackingNumbers};
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

/// What there is to show.
#[derive(Debug)]
pub(crate) struct TrackView<'a> {
    /// Above the table.
    pub(crate) heading: String,
    /// Below the heading.
    pub(crate) lead: String,
    /// By variant.
    pub(crate) tracking: &'a BTreeMap<CompensationVariant, TrackingNumbers>,
    /// The run that is drawn, and the variant it is of.
    pub(crate) trace: &'a [TraceRow],
    /// See [`trace`](Self::trace).
    pub(crate) drawn: CompensationVariant,
    /// Of the muscles.
    pub(crate) names: &'a [String],
    /// Of the run that is drawn.
    pub(crate) repeats: u32,
    /// Whether the paper did the same and its row may stand there.
    pub(crate) paper: bool,
}

/// Names in the order of the table.
const NAMES: [(CompensationVariant, &str); 8] = [
    (CompensationVariant::None, "tensions, no compensation"),
    (CompensationVariant::Capstan, "tensions, static capstan"),
    (CompensationVariant::Paper, "tensions, the paper’s network"),
    (CompensationVariant::NoObserver, "winch speed, no observer"),
    (CompensationVariant::NoDisturbanceObserver, "observer, no disturbance observer"),
    (CompensationVariant::Observer, "observer (ours)"),
    (CompensationVariant::ObserverNetwork, "observer + network"),
    (CompensationVariant::Perfect, "perfect knowledge of the cables"),
];
const LABELS: [&str; 6] = [
    "mean, mm",
    "std, mm",
    "max, mm",
    "muscle length, mm",
    "least anchor tension, N",
    "most drive tension, N",
];

/// The section, to be put into a page.
pub(crate) fn section(view: &TrackView<'_>) -> Result<String, Error> {
    let moving: Vec<&TraceRow> = view.trace.iter().filter(|row| row.repeat.is_some()).collect();
    let section = Section {
        heading: view.heading.clone(),
        lead: view.lead.clone(),
        rows: rows(view),
        end_point: end_point(&moving),
        lengths: lengths(&moving, view.names, view.repeats),
        means: means(view),
        errors: errors(&moving, view),
        repeats: view.repeats,
        remarks: remarks(view),
        incidents: incidents(view),
        paper: view.paper,
    };
    Ok(section.render()?)
}

/// A page of its own.
pub(crate) fn page(view: &TrackView<'_>, title: &str, amount: &str) -> Result<String, Error> {
    let numbers = view.tracking.get(&view.drawn);
    let verdict = numbers.map_or_else(String::new, |n| match (&n.stopped_by, n.stopped_s) {
        (Some(why), time) => format!(
            "The controller stopped the arm {} s after the run began: {why}.",
            fixed(time.unwrap_or(f64::NAN), 2)
        ),
        (None, Some(time)) => format!(
            "The simulation was lost {} s after the run began: the arm was thrown out of all bounds.",
            fixed(time, 2)
        ),
        (None, None) => format!(
            "The end point stayed {} mm from where it was to be on average, {} mm at most.",
            fixed(1e3 * n.end_point_error_m.mean, 2),
            fixed(1e3 * n.end_point_error_m.max, 1)
        ),
    });
    let page = Page {
        version: env!("CARGO_PKG_VERSION"),
        style: include_str!("../../assets/report.css"),
        script: include_str!("../../assets/report.js"),
        title,
        amount,
        verdict,
        section: section(view)?,
    };
    Ok(page.render()?)
}

/// What the table has no room for, of the run that is drawn.
fn remarks(view: &TrackView<'_>) -> Vec<String> {
    let Some(numbers) = view.tracking.get(&view.drawn) else { return Vec::new() };
    let mut remarks = Vec::new();
    let unseen = numbers.unseen_error_m;
    let [mean, max] = [(unseen.mean, 2), (unseen.max, 1)].map(|(m, digits)| fixed(1e3 * m, digits));
    remarks.push(format!(
        "Joint encoders that all read what is wanted would leave {mean} mm on average, {max} mm at most: their zeros are off, and without a sensor at the end point nobody knows."
    ));
    let repeats = &numbers.end_point_error_per_repeat_m;
    if repeats.len() > 1 {
        let means: Vec<String> = repeats.iter().map(|repeat| fixed(1e3 * repeat.mean, 2)).collect();
        remarks.push(format!("Mean error repeat by repeat: {} mm.", means.join(", ")));
    }
    if let Some(hold) = numbers.hold {
        let e = hold.end_point_error_m;
        let [mean, max] = [(e.mean, 2), (e.max, 2)].map(|(m, digits)| fixed(1e3 * m, digits));
        let [unrest, unseen] = [hold.tension_unrest_n, 1e3 * hold.unseen_error_m].map(|x| fixed(x, 2));
        remarks.push(format!(
            "Held at the end: {mean} mm off on average, {max} mm at most ({unseen} mm are the encoders' zeros); tensions at the anchors within {unrest} N rms."
        ));
    }
    remarks
}

/// What was wrong with the run that is drawn, and when.
fn incidents(view: &TrackView<'_>) -> Vec<String> {
    let Some(numbers) = view.tracking.get(&view.drawn) else { return Vec::new() };
    let each = numbers.incidents.iter();
    each.map(|one| {
        format!("{} to {} s: {}, {}", fixed(one.from_s, 3), fixed(one.until_s, 3), one.what, one.answer)
    })
    .collect()
}

fn rows(view: &TrackView<'_>) -> Vec<Row> {
    let mut rows = Vec::new();
    for (key, name) in NAMES {
        let Some(n) = view.tracking.get(&key) else { continue };
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
            (None, Some(time)) => format!("lost at {} s", fixed(time, 1)),
            _ => "as planned".to_owned(),
        };
        rows.push(Row {
            name,
            ours: key == CompensationVariant::Observer,
            cells: LABELS.into_iter().zip(cells).collect(),
            ended,
        });
    }
    if view.paper {
        let cells = ["15.80", "7.10", "39.0", "0.780", NONE, NONE].map(str::to_owned);
        let cells = LABELS.into_iter().zip(cells).collect();
        rows.push(Row { name: "the paper, measured", ours: false, cells, ended: "six repeats".to_owned() });
    }
    rows
}

fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    padded(values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v))), 0.05)
}

fn first_repeat<'a>(rows: &[&'a TraceRow]) -> Vec<&'a TraceRow> {
    rows.iter().copied().filter(|row| row.repeat == Some(0)).collect()
}

fn time_axis(rows: &[&TraceRow]) -> Axis {
    Axis::new((rows.first().map_or(0.0, |r| r.time_s), rows.last().map_or(1.0, |r| r.time_s)), 5)
}

/// Figure 11: the coordinates of the first repeat, the error of all.
fn end_point(rows: &[&TraceRow]) -> Vec<Plot> {
    let first = first_repeat(rows);
    let mut plots = Vec::new();
    for (k, name) in ["x", "y", "z"].into_iter().enumerate() {
        let x = time_axis(&first);
        let values = first.iter().flat_map(|row| [row.wanted_m[k], row.end_point_m[k]]);
        let y = Axis::new(range(values), 5);
        let mut plot = Plot::new(
            "trace",
            format!("End point {name}"),
            (&x, "time of the run (s)".to_owned()),
            (&y, format!("{name} (m)")),
        );
        plot.draw("measured", line(first.iter().map(|row| (row.time_s, row.wanted_m[k])), &x, &y));
        plot.draw("predicted", line(first.iter().map(|row| (row.time_s, row.end_point_m[k])), &x, &y));
        plots.push(plot);
    }
    let distance = |row: &TraceRow| {
        let squares = row.wanted_m.iter().zip(&row.end_point_m).map(|(a, b)| (a - b) * (a - b));
        1e3 * squares.sum::<f64>().sqrt()
    };
    let x = time_axis(rows);
    let y = Axis::new((0.0, 1.05 * rows.iter().map(|row| distance(row)).fold(0.1, f64::max)), 5);
    let title = "error, all repeats (mm)".to_owned();
    let mut plot = Plot::new("trace", title.clone(), (&x, "time of the run (s)".to_owned()), (&y, title));
    plot.draw("predicted", line(rows.iter().map(|row| (row.time_s, distance(row))), &x, &y));
    plots.push(plot);
    plots
}

/// Figure 12: every repeat over each other.
fn lengths(rows: &[&TraceRow], names: &[String], repeats: u32) -> Vec<Plot> {
    let first = first_repeat(rows);
    let since = since_repeat(rows, repeats);
    let plots = names.iter().enumerate().map(|(k, name)| {
        let start = first.first().map_or(0.0, |row| row.length_m[k]);
        let wanted = |row: &TraceRow| 1e3 * (row.length_m[k] - start);
        let truth = |row: &TraceRow| wanted(row) + 1e3 * row.length_error_m[k];
        let x = repeat_axis(&since);
        let y = Axis::new(range(rows.iter().flat_map(|row| [wanted(row), truth(row)])), 3);
        let title = format!("{name} (mm)");
        let mut plot = Plot::new("trace low", title.clone(), (&x, "time (s)".to_owned()), (&y, title));
        plot.draw("measured", line(first.iter().zip(&since).map(|(row, t)| (*t, wanted(row))), &x, &y));
        plot.draw("predicted", line(over_each_other(rows, &since, truth), &x, &y));
        plot
    });
    plots.collect()
}

/// Figure 13: the mean of every muscle.
fn means(view: &TrackView<'_>) -> Vec<Plot> {
    let Some(numbers) = view.tracking.get(&view.drawn) else { return Vec::new() };
    #[expect(clippy::cast_precision_loss, reason = "a few dozen muscles")]
    let points: Vec<(f64, f64)> =
        numbers.per_muscle.iter().enumerate().map(|(k, mean)| (k as f64 + 1.0, 1e3 * mean)).collect();
    #[expect(clippy::cast_precision_loss, reason = "a few dozen muscles")]
    let x = Axis::new((0.0, points.len() as f64 + 1.0), 8);
    let y = Axis::new((0.0, 1.1 * points.iter().map(|p| p.1).fold(0.01, f64::max)), 5);
    let title = "mean length error (mm)".to_owned();
    let mut plot =
        Plot::new("trace", title.clone(), (&x, "muscle, in the order above".to_owned()), (&y, title));
    // A bar is a line from nothing; a point that is no number lifts the pen.
    let bars = points.iter().flat_map(|p| [(p.0, 0.0), *p, (f64::NAN, f64::NAN)]);
    plot.draw("bars", line(bars, &x, &y));
    vec![plot]
}

/// All repeats over each other.
fn errors(rows: &[&TraceRow], view: &TrackView<'_>) -> Vec<Plot> {
    let since = since_repeat(rows, view.repeats);
    let plots = view.names.iter().enumerate().map(|(k, name)| {
        let error = |row: &TraceRow| 1e3 * row.length_error_m[k];
        let x = repeat_axis(&since);
        let y = Axis::new(range(rows.iter().map(|row| error(row))), 3);
        let title = format!("{name} (mm)");
        let mut plot = Plot::new("trace low", title.clone(), (&x, "time (s)".to_owned()), (&y, title));
        plot.draw("median", line(over_each_other(rows, &since, error), &x, &y));
        plot
    });
    plots.collect()
}

/// Of every row, s since its repeat began.
fn since_repeat(rows: &[&TraceRow], repeats: u32) -> Vec<f64> {
    let begin: Vec<f64> = (0..repeats)
        .map(|k| rows.iter().find(|row| row.repeat == Some(k)).map_or(0.0, |row| row.time_s))
        .collect();
    let began = |row: &TraceRow| row.repeat.and_then(|k| begin.get(usize::try_from(k).ok()?)).copied();
    rows.iter().map(|row| row.time_s - began(row).unwrap_or(0.0)).collect()
}

fn repeat_axis(since: &[f64]) -> Axis {
    Axis::new((0.0, since.iter().copied().fold(1.0, f64::max)), 5)
}

/// One line through all repeats; a point that is no number lifts the pen between them.
fn over_each_other<'a>(
    rows: &'a [&TraceRow],
    since: &'a [f64],
    of: impl Fn(&TraceRow) -> f64 + 'a,
) -> impl Iterator<Item = (f64, f64)> + 'a {
    let mut repeat = None;
    rows.iter().zip(since).flat_map(move |(row, since)| {
        let new = repeat.replace(row.repeat) != Some(row.repeat);
        let point = (*since, of(row));
        [if new { (f64::NAN, f64::NAN) } else { point }, point]
    })
}
