//! A run as a table: a comment with the numbers of the run (JSON), a header, and a row every 10 ms.
//!
//! | column | unit | meaning |
//! |---|---|---|
//! | `time_s`, `repeat` | s, 1 | time of the run; index of the repeat, empty at rest |
//! | `status` | | operating state of the controller |
//! | `end_point_reference_x_m` .., `end_point_x_m` .. | m | reference and true position of the end point |
//! | `length_m:MUSCLE`, `length_error_m:MUSCLE` | m | reference length; true minus reference length |
//!
//! and the columns of every joint and muscle that a recording has (`docs/recording.md`).

use crate::csv_text::Csv;
use crate::error::Error;
use crate::table_error::TableError;
use serde::{Deserialize, Serialize};
use sinew_lab::arm::{TraceRow, TrackingNumbers};
use sinew_lab::signals::{Axis, Frame, FrameLayout, Row, Signal};
use sinew_report::tracking::{Gear, Injected};
use std::sync::Arc;

/// Begins the comment with the numbers.
const RUN: &str = "# run ";

/// What the rows do not say.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RunHead {
    pub(crate) title: String,
    pub(crate) conditions: String,
    pub(crate) compensation: String,
    pub(crate) repeats: u32,
    pub(crate) muscles: Vec<String>,
    pub(crate) joints: Vec<String>,
    /// rad or m.
    #[serde(default)]
    pub(crate) joint_units: Vec<String>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) gears: Vec<Gear>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) injected: Vec<Injected>,
    pub(crate) numbers: TrackingNumbers,
}

/// CSV, one row per sample; columns are named after the muscles and joints.
pub(super) fn csv(head: &RunHead, trace: &[TraceRow]) -> Result<String, Error> {
    let mut table = Csv::new();
    table.row(header(head))?;
    for row in trace {
        let repeat = row.repeat.map_or(String::new(), |repeat| repeat.to_string());
        let mut cells = vec![format!("{:.3}", row.time_s), repeat, row.status.clone()];
        let metres = [&row.end_point_reference_m[..], &row.end_point_m, &row.length_m, &row.length_error_m];
        cells.extend(metres.into_iter().flatten().map(|x| shown(*x, Some(7))));
        for signal in signals() {
            cells.extend(row.frame.of(signal).iter().map(|x| shown(*x, signal.row().digits())));
        }
        table.row(cells)?;
    }
    let head = serde_json::to_string(head)?;
    Ok(format!("# SIMULATED by sinew track\n{RUN}{head}\n{}", table.text()?))
}

/// A number, or an empty cell where there is none.
fn shown(number: f64, digits: Option<usize>) -> String {
    match digits {
        _ if !number.is_finite() => String::new(),
        Some(digits) => format!("{number:.digits$}"),
        None => number.to_string(),
    }
}

/// Signals with a column a joint or muscle.
fn signals() -> impl Iterator<Item = Signal> {
    Signal::ALL.iter().copied().filter(|signal| signal.row().axis != Axis::Cycle)
}

fn header(head: &RunHead) -> Vec<String> {
    let mut header: Vec<String> = ["time_s", "repeat", "status"].map(str::to_owned).to_vec();
    for quantity in ["end_point_reference", "end_point"] {
        header.extend(["x", "y", "z"].map(|axis| format!("{quantity}_{axis}_m")));
    }
    for quantity in ["length_m", "length_error_m"] {
        header.extend(head.muscles.iter().map(|muscle| format!("{quantity}:{muscle}")));
    }
    for signal in signals() {
        match signal.row() {
            Row { axis: Axis::Muscle, .. } => {
                header.extend(head.muscles.iter().map(|muscle| signal.column(muscle, "")));
            }
            _ => {
                let parts = head.joints.iter().zip(&head.joint_units);
                header.extend(parts.map(|(joint, unit)| signal.column(joint, unit)));
            }
        }
    }
    header
}

/// The run of a table that [`csv()`] has written.
pub(crate) fn parse(text: &str) -> Result<(RunHead, Vec<TraceRow>), TableError> {
    let expected = "a table that `sinew track --record` has written";
    let found = text.lines().enumerate().find_map(|(k, line)| Some((k + 1, line.strip_prefix(RUN)?)));
    let (line, head) = found.ok_or_else(|| TableError::in_line(1, expected, "another file"))?;
    let head: RunHead =
        serde_json::from_str(head).map_err(|error| TableError::in_line(line, expected, error.to_string()))?;
    let table: String = text.lines().skip(line).flat_map(|row| [row, "\n"]).collect();
    let mut reader = csv::ReaderBuilder::new().from_reader(table.as_bytes());
    let names =
        reader.headers().map_err(|error| TableError::in_line(line + 1, expected, error.to_string()))?;
    if !names.iter().eq(header(&head)) {
        return Err(TableError::in_line(line + 1, "the columns of this run", "other columns"));
    }
    let layout = Arc::new(FrameLayout::new([head.muscles.len(), head.joints.len()], true));
    let mut trace = Vec::new();
    for (k, record) in reader.records().enumerate() {
        let line = line + 2 + k;
        let record = record.map_err(|error| TableError::in_line(line, expected, error.to_string()))?;
        trace.push(row(&head, &layout, &record, line)?);
    }
    if trace.len() < 2 {
        return Err(TableError::in_line(
            line + 1,
            "at least 2 rows below the header",
            trace.len().to_string(),
        ));
    }
    Ok((head, trace))
}

/// One row; cells are taken in the order of [`header`].
fn row(
    head: &RunHead,
    layout: &Arc<FrameLayout>,
    record: &csv::StringRecord,
    line: usize,
) -> Result<TraceRow, TableError> {
    let names = header(head);
    let number = |column: usize| -> Result<f64, TableError> {
        let cell = record.get(column).unwrap_or_default();
        let refuse = || TableError::in_column(line, &names[column], "a finite number", cell);
        if cell.is_empty() {
            return Ok(f64::NAN);
        }
        cell.parse().ok().filter(|x: &f64| x.is_finite()).ok_or_else(refuse)
    };
    let mut next = 3;
    let mut take = |count: usize| -> Result<Vec<f64>, TableError> {
        let taken = (next..next + count).map(number).collect();
        next += count;
        taken
    };
    let muscles = head.muscles.len();
    let point = |taken: Vec<f64>| std::array::from_fn(|k| taken[k]);
    let repeat = record.get(1).filter(|cell| !cell.is_empty());
    let refuse = |cell: &str| TableError::in_column(line, "repeat", "a whole number", cell);
    let repeat = repeat.map(|cell| cell.parse().map_err(|_| refuse(cell))).transpose()?;
    // In the order of the header.
    let (end_point_reference_m, end_point_m) = (point(take(3)?), point(take(3)?));
    let (length_m, length_error_m) = (take(muscles)?, take(muscles)?);
    let mut frame = Frame::new(Arc::clone(layout));
    for signal in signals() {
        let place = frame.of_mut(signal);
        let taken = take(place.len())?;
        place.copy_from_slice(&taken);
    }
    let (time_s, status) = (number(0)?, record.get(2).unwrap_or_default().to_owned());
    Ok(TraceRow {
        time_s,
        repeat,
        status,
        end_point_reference_m,
        end_point_m,
        length_m,
        length_error_m,
        frame,
    })
}
