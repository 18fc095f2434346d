//! The table of errors by compensation.

use super::view::TrackView;
use crate::format::{NONE, fixed};
use crate::variants::label;
use sinew_lab::CompensationVariant;
use sinew_lab::arm::{TrackOutcome, TrackingNumbers};
use sinew_lab::paper;

/// One row: a compensation, or the paper.
pub(super) struct Row {
    pub(super) name: String,
    /// `simulated` or `hardware`.
    pub(super) source: &'static str,
    pub(super) ours: bool,
    pub(super) cells: Vec<String>,
    pub(super) ended: String,
}

pub(super) fn rows(view: &TrackView<'_>) -> Vec<Row> {
    let mut rows = Vec::new();
    for variant in CompensationVariant::ALL {
        let Some(n) = view.tracking.get(&variant) else { continue };
        let ours = variant == CompensationVariant::Observer;
        let name = label(variant).to_owned();
        rows.push(Row { name, source: "simulated", ours, cells: cells(n), ended: ended(n) });
        if view.paper && ours {
            rows.extend(paper_rows(n));
        }
    }
    rows
}

fn cells(n: &TrackingNumbers) -> Vec<String> {
    let e = &n.end_point_error_m;
    vec![
        fixed(1e3 * e.mean, 2),
        fixed(1e3 * e.std, 2),
        fixed(1e3 * e.max, 1),
        fixed(1e3 * n.muscle_length_error_m.mean, 3),
        fixed(n.min_anchor_tension_n, 1),
        fixed(n.max_drive_tension_n, 0),
    ]
}

fn ended(n: &TrackingNumbers) -> String {
    match (&n.stopped_by, n.stopped_s) {
        (Some(why), Some(time)) => format!("stopped at {} s: {why}", fixed(time, 1)),
        (None, Some(time)) => format!("diverged at {} s", fixed(time, 1)),
        _ if n.ended == TrackOutcome::Completed => "completed".to_owned(),
        _ => n.reason.clone().unwrap_or_default(),
    }
}

/// The paper's numbers, and ours minus them.
fn paper_rows(n: &TrackingNumbers) -> [Row; 2] {
    let [mean, std, max] = paper::END_POINT_ERROR_MM;
    let hardware = [mean, std, max, paper::MUSCLE_LENGTH_ERROR_MM];
    let e = &n.end_point_error_m;
    let ours = [e.mean, e.std, e.max, n.muscle_length_error_m.mean].map(|m| 1e3 * m);
    let digits = [2, 2, 1, 3];
    let row = |name: &str, source, ended: &str, values: [f64; 4]| {
        let numbers = values.into_iter().zip(digits).map(|(x, digits)| fixed(x, digits));
        let cells = numbers.chain([NONE.to_owned(), NONE.to_owned()]).collect();
        Row { name: name.to_owned(), source, ours: false, cells, ended: ended.to_owned() }
    };
    [
        row("the paper", "hardware", "six repeats", hardware),
        row("observer minus paper", "difference", "", std::array::from_fn(|k| ours[k] - hardware[k])),
    ]
}
