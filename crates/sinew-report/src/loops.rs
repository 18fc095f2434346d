//! The hysteresis loop of far over near signal, measured and predicted.

use super::plot::Plot;
use super::record::{Record, Signals};
use super::scale::{Axis, padded, robust_range};
use super::svg_path::{decimate, line};

/// Points of all records together.
const POINTS: usize = 9000;
/// Maximum number of records: more loops would hide each other.
const RECORDS: usize = 8;

/// The records a loop picture shows, evenly spread over all of them.
pub(super) fn shown(records: &[Record]) -> Vec<&Record> {
    let useful: Vec<&Record> = records.iter().filter(|r| r.len() > 1).collect();
    let n = useful.len();
    (0..n.min(RECORDS)).map(|k| useful[k * n / n.min(RECORDS)]).collect()
}

/// Axes for near (x) and far (y), of the samples that are scored.
pub(super) fn axes(records: &[&Record], ticks: usize) -> (Axis, Axis) {
    let scaling: Vec<(&Record, usize)> =
        records.iter().flat_map(|r| r.scaling().into_iter().map(|i| (*r, i))).collect();
    let near = robust_range(scaling.iter().map(|(r, i)| r.near[*i]));
    let far = robust_range(scaling.iter().flat_map(|(r, i)| [r.far[*i], r.predicted[*i]]));
    (Axis::new(padded(near, 0.03), ticks), Axis::new(padded(far, 0.04), ticks))
}

/// Measured and predicted loops as path data.
pub(super) fn paths(records: &[&Record], points: usize, x: &Axis, y: &Axis) -> (String, String) {
    let (mut measured, mut predicted) = (String::new(), String::new());
    for record in records {
        let kept = decimate(record, points / records.len().max(1));
        measured.push_str(&line(kept.iter().map(|&i| (record.near[i], record.far[i])), x, y));
        predicted.push_str(&line(kept.iter().map(|&i| (record.near[i], record.predicted[i])), x, y));
    }
    (measured, predicted)
}

/// The picture, or nothing where no trace has two samples.
pub(super) fn plot(records: &[Record], signals: &Signals) -> Option<Plot> {
    let shown = shown(records);
    if shown.is_empty() {
        return None;
    }
    let (x, y) = axes(&shown, 6);
    let title = format!("Measured and predicted {} over {}", signals.far, signals.near);
    let mut plot = Plot::new("loop", title, (&x, signals.near_label()), (&y, signals.far_label()));
    let (measured, predicted) = paths(&shown, POINTS, &x, &y);
    plot.draw("measured", "measured", measured);
    plot.draw("predicted", "predicted (cross-validated)", predicted);
    Some(plot)
}
