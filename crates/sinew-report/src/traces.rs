//! Out-of-fold predictions over time beside the measured far side: a static plot and thumbnails as SVG, and
//! packed samples for the interactive plot.

use super::error::Error;
use super::format::{percent, percent_of_range};
use super::pack::{SAMPLES, pack};
use super::plot::Plot;
use super::record::{Record, Signals};
use super::scale::{Axis, padded, robust_range};
use super::svg_path::{Pen, decimate, line, ribbon};
use super::view::{error_view, far_view};

/// Points of a static plot, about one per unit of its width.
const STILL_POINTS: usize = 2200;
/// Points of all thumbnails together; bounds the size of the page.
const THUMB_POINTS: usize = 9000;
/// Maximum number of thumbnails; the selection lists every record.
const THUMBS: usize = 60;

/// The section on traces; records are referred to by their index in `records`.
#[derive(Debug)]
pub(super) struct Traces {
    pub(super) records: Vec<Entry>,
    /// The record that is shown first, the one with the median error.
    pub(super) start: usize,
    pub(super) start_label: String,
    /// Static plots of that record, for a page without its script: far side, error, inputs.
    pub(super) still: Vec<Plot>,
    /// Empty for a single record.
    pub(super) thumbs: Vec<Thumb>,
    /// Whether the samples of the interactive plot are decimated.
    pub(super) thinned: bool,
    /// Whether any interval is not scored.
    pub(super) skipped: bool,
    /// The record with the least RMSE; records without a scored sample have no place in this order.
    pub(super) best: usize,
    /// The record with the median RMSE, the upper one of two.
    pub(super) typical: usize,
    /// The record with the largest RMSE.
    pub(super) worst: usize,
    /// Samples as JSON, safe within a script element.
    pub(super) data: String,
}

/// One choice of the selection.
#[derive(Debug)]
pub(super) struct Entry {
    /// Log and trial.
    pub(super) label: String,
    /// RMSE as % of the range of the far signal.
    pub(super) percent: String,
}

/// One small picture that selects its record.
#[derive(Debug)]
pub(super) struct Thumb {
    /// The record.
    pub(super) index: usize,
    /// As in [`Entry`].
    pub(super) label: String,
    /// As in [`Entry`].
    pub(super) percent: String,
    /// Fraction of the samples within the 95 % band, %.
    pub(super) coverage: String,
    /// SVG path data.
    pub(super) measured: String,
    /// SVG path data.
    pub(super) predicted: String,
}

/// The content of the section; `None` without a record of two samples. `range` is that of the far signal over
/// all logs, in its unit; errors are relative to it.
pub(super) fn section(records: &[Record], signals: &Signals, range: f64) -> Result<Option<Traces>, Error> {
    let records: Vec<&Record> = records.iter().filter(|r| r.len() > 1).collect();
    if records.is_empty() {
        return Ok(None);
    }
    let scores: Vec<_> = records.iter().map(|r| r.score()).collect();
    let mut order: Vec<usize> = (0..records.len()).filter(|&i| scores[i].samples > 0).collect();
    order.sort_by(|&a, &b| scores[a].rmse().total_cmp(&scores[b].rmse()));
    let pick = |place: usize| order.get(place).copied().unwrap_or(0);
    let (best, typical, worst) = (pick(0), pick(order.len() / 2), pick(order.len().saturating_sub(1)));
    let fraction = |i: usize| percent_of_range(100.0 * scores[i].rmse() / range);
    // At most 260 points each: a thumbnail is about 170 px wide.
    let per_thumb = (THUMB_POINTS / records.len().min(THUMBS)).min(260);
    let thumbs = (0..records.len().min(THUMBS)).map(|i| {
        let (measured, predicted) = thumbnail(records[i], per_thumb);
        let coverage = percent(scores[i].coverage());
        Thumb {
            index: i,
            label: records[i].label.clone(),
            percent: fraction(i),
            coverage,
            measured,
            predicted,
        }
    });
    Ok(Some(Traces {
        start: typical,
        start_label: records[typical].label.clone(),
        still: still(records[typical], signals),
        thumbs: if records.len() > 1 { thumbs.collect() } else { Vec::new() },
        thinned: records.iter().map(|r| r.len()).sum::<usize>() > SAMPLES,
        skipped: records.iter().any(|r| !skipped(r).is_empty()),
        best,
        typical,
        worst,
        data: pack(&records, signals, &fraction)?,
        records: (0..records.len())
            .map(|i| Entry { label: records[i].label.clone(), percent: fraction(i) })
            .collect(),
    }))
}

/// Axes of one record: time, s, with about `ticks` ticks, and the far signal in its unit, widened by the band
/// up to 30 % of the signal's range ([`far_view`]).
pub(super) fn far_axes(record: &Record, ticks: usize) -> (Axis, Axis) {
    let time = Axis::new(robust_ends(&record.time_s), ticks);
    (time, Axis::new(far_view(record), 5))
}

/// Smallest and largest finite time, s; infinite without one, which [`Axis::new`] replaces.
fn robust_ends(time_s: &[f64]) -> (f64, f64) {
    let finite = || time_s.iter().copied().filter(|t| t.is_finite());
    (finite().fold(f64::INFINITY, f64::min), finite().fold(f64::NEG_INFINITY, f64::max))
}

/// Measured, predicted and band (predicted ± half width) of the rows `kept` of one record, as SVG path data.
pub(super) fn paths(record: &Record, kept: &[usize], x: &Axis, y: &Axis) -> [String; 3] {
    let t = |i: usize| record.time_s[i];
    let band = kept.iter().map(|&i| {
        let (p, h) = (record.predicted[i], record.half_width[i]);
        (t(i), p - h, p + h)
    });
    [
        line(kept.iter().map(|&i| (t(i), record.far[i])), x, y),
        line(kept.iter().map(|&i| (t(i), record.predicted[i])), x, y),
        ribbon(band, x, y),
    ]
}

/// Far signal, error and every input of one record, stacked.
fn still(record: &Record, signals: &Signals) -> Vec<Plot> {
    let kept = decimate(record, STILL_POINTS);
    let (x, y) = far_axes(record, 8);
    let title = format!("Measured and predicted {} of {} over time", signals.far, record.label);
    let mut far = Plot::new("trace", title, (&x, String::new()), (&y, signals.far_label()));
    let [measured, predicted, band] = paths(record, &kept, &x, &y);
    let mut shade = Pen::default();
    for (from, to) in skipped(record) {
        let (from, to) = (x.at(from), x.at(to));
        [(from, 0.0), (from, 1.0), (to, 1.0), (to, 0.0)].into_iter().for_each(|(a, b)| shade.line_to(a, b));
        shade.close();
    }
    far.draw("skipped", "not scored", shade.finish());
    far.draw("band", "95 % band", band);
    far.draw("measured", "measured", measured);
    far.draw("predicted", "predicted", predicted);
    let errors = || kept.iter().map(|&i| (record.time_s[i], record.scored_error(i)));
    let y = Axis::new(error_view(record), 3);
    let label = signals.in_far_unit("error, predicted − measured");
    let mut error = Plot::new("trace low", "Error over time".to_owned(), (&x, String::new()), (&y, label));
    error.draw("zero", "", line([(x.low, 0.0), (x.high, 0.0)].into_iter(), &x, &y));
    error.draw("median", "error", line(errors(), &x, &y));
    let mut plots = vec![far.linked("record"), error.linked("record").without_names()];
    let columns =
        [(&signals.near, &record.near)].into_iter().chain(signals.others.iter().zip(&record.others));
    let labels = core::iter::once(signals.near_label()).chain(signals.other_labels());
    let count = columns.clone().count();
    for (k, ((name, values), label)) in columns.zip(labels).enumerate() {
        let scaling = record.scaling();
        let y = Axis::new(padded(robust_range(scaling.iter().map(|&i| values[i])), 0.05), 3);
        let x_label = if k + 1 == count { "time (s)" } else { "" };
        let title = format!("{label} over time");
        let mut plot = Plot::new("trace low", title, (&x, x_label.to_owned()), (&y, label));
        plot.draw("near", name, line(kept.iter().map(|&i| (record.time_s[i], values[i])), &x, &y));
        plots.push(plot.linked("record").without_names());
    }
    plots
}

/// Intervals that are not scored, s; single rows are left out.
fn skipped(record: &Record) -> Vec<(f64, f64)> {
    let mut stretches = Vec::new();
    let mut start = None;
    for i in 0..=record.len() {
        match (start, record.scored.get(i) == Some(&false)) {
            (None, true) => start = Some(i),
            (Some(from), false) => {
                if i - from > 1 {
                    stretches.push((record.time_s[from], record.time_s[i.min(record.len() - 1)]));
                }
                start = None;
            }
            _ => {}
        }
    }
    stretches
}

/// Measured and predicted far signal as SVG path data, about `points` points each.
fn thumbnail(record: &Record, points: usize) -> (String, String) {
    let kept = decimate(record, points);
    let x = Axis::new(robust_ends(&record.time_s), 2);
    let view = padded(robust_range(record.far.iter().chain(&record.predicted).copied()), 0.06);
    let [measured, predicted, _] = paths(record, &kept, &x, &Axis::new(view, 2));
    (measured, predicted)
}
