//! The table of errors by compensation.

use super::view::TrackView;
use crate::format::{NONE, fixed};
use crate::variants::label;
use sinew_lab::CompensationVariant;
use sinew_lab::arm::{ErrorRange, TrackOutcome, TrackingNumbers};
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

/// Heads of the columns of numbers.
pub(super) fn columns(view: &TrackView<'_>, end_point: bool) -> Vec<&'static str> {
    let errors: &[_] = match (end_point, slides(view)) {
        (true, _) => &["end point: mean, mm", "std, mm", "max, mm"],
        (false, false) => &["joints: mean, mrad", "max, mrad"],
        (false, true) => &["hinges: mean, mrad", "max, mrad", "slides: mean, mm", "max, mm"],
    };
    [errors, &["muscle length: mean, mm", "min. anchor tension, N", "max. drive tension, N"]].concat()
}

fn slides(view: &TrackView<'_>) -> bool {
    view.joint_units.iter().any(|unit| unit == "m")
}

pub(super) fn rows(view: &TrackView<'_>, end_point: bool) -> Vec<Row> {
    let mut rows = Vec::new();
    for variant in CompensationVariant::ALL {
        let Some(n) = view.tracking.get(&variant) else { continue };
        let ours = variant == CompensationVariant::Observer;
        let name = label(variant).to_owned();
        rows.push(Row {
            name,
            source: "simulated",
            ours,
            cells: cells(n, end_point, slides(view)),
            ended: ended(n),
        });
        if view.paper && ours {
            rows.extend(paper_rows(n));
        }
    }
    rows
}

fn cells(n: &TrackingNumbers, end_point: bool, slides: bool) -> Vec<String> {
    let e = &n.end_point_error_m;
    let errors = if end_point {
        vec![fixed(1e3 * e.mean, 2), fixed(1e3 * e.std, 2), fixed(1e3 * e.max, 2)]
    } else {
        let pair = |range: Option<ErrorRange>| {
            let of = |value: Option<f64>, digits| fixed(1e3 * value.unwrap_or(f64::NAN), digits);
            [of(range.map(|r| r.mean), 2), of(range.map(|r| r.max), 2)]
        };
        [n.joint_error_rad, n.joint_error_m]
            .into_iter()
            .take(1 + usize::from(slides))
            .flat_map(pair)
            .collect()
    };
    let others = [
        fixed(1e3 * n.muscle_length_error_m.mean, 3),
        fixed(n.min_anchor_tension_n, 1),
        fixed(n.max_drive_tension_n, 0),
    ];
    errors.into_iter().chain(others).collect()
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
