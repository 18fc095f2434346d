//! Figures 11 to 13: end point, muscle lengths and their errors.

use super::plot::Plot;
use super::scale::{Axis, padded};
use super::svg_path::line;
use sinew_lab::arm::TraceRow;

fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    padded(values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v))), 0.05)
}

fn first_repeat<'a>(rows: &[&'a TraceRow]) -> Vec<&'a TraceRow> {
    rows.iter().copied().filter(|row| row.repeat == Some(0)).collect()
}

fn time_axis(rows: &[&TraceRow]) -> Axis {
    Axis::new((rows.first().map_or(0.0, |r| r.time_s), rows.last().map_or(1.0, |r| r.time_s)), 5)
}

/// Figure 11: coordinates of the first repeat, error of all repeats.
pub(super) fn end_point(rows: &[&TraceRow]) -> Vec<Plot> {
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

/// Figure 12: all repeats superimposed.
pub(super) fn lengths(rows: &[&TraceRow], names: &[String], repeats: u32) -> Vec<Plot> {
    let first = first_repeat(rows);
    let since = since_repeat(rows, repeats);
    let plots = names.iter().enumerate().map(|(k, name)| {
        let start = first.first().map_or(0.0, |row| row.length_m[k]);
        let reference = |row: &TraceRow| 1e3 * (row.length_m[k] - start);
        let truth = |row: &TraceRow| reference(row) + 1e3 * row.length_error_m[k];
        let x = repeat_axis(&since);
        let y = Axis::new(range(rows.iter().flat_map(|row| [reference(row), truth(row)])), 3);
        let title = format!("{name} (mm)");
        let mut plot = Plot::new("trace low", title.clone(), (&x, "time (s)".to_owned()), (&y, title));
        plot.draw("measured", line(first.iter().zip(&since).map(|(row, t)| (*t, reference(row))), &x, &y));
        plot.draw("predicted", line(superimposed(rows, &since, truth), &x, &y));
        plot
    });
    plots.collect()
}

/// Figure 13: mean length error of every muscle.
pub(super) fn means(per_muscle: &[f64]) -> Vec<Plot> {
    #[expect(clippy::cast_precision_loss, reason = "a few dozen muscles")]
    let points: Vec<(f64, f64)> =
        per_muscle.iter().enumerate().map(|(k, mean)| (k as f64 + 1.0, 1e3 * mean)).collect();
    #[expect(clippy::cast_precision_loss, reason = "a few dozen muscles")]
    let x = Axis::new((0.0, points.len() as f64 + 1.0), 8);
    let y = Axis::new((0.0, 1.1 * points.iter().map(|p| p.1).fold(0.01, f64::max)), 5);
    let title = "mean length error (mm)".to_owned();
    let mut plot =
        Plot::new("trace", title.clone(), (&x, "muscle, in the order above".to_owned()), (&y, title));
    // A bar is a vertical line; a NaN lifts the pen.
    let bars = points.iter().flat_map(|p| [(p.0, 0.0), *p, (f64::NAN, f64::NAN)]);
    plot.draw("bars", line(bars, &x, &y));
    vec![plot]
}

/// Length errors of all repeats, superimposed.
pub(super) fn errors(rows: &[&TraceRow], names: &[String], repeats: u32) -> Vec<Plot> {
    let since = since_repeat(rows, repeats);
    let plots = names.iter().enumerate().map(|(k, name)| {
        let error = |row: &TraceRow| 1e3 * row.length_error_m[k];
        let x = repeat_axis(&since);
        let y = Axis::new(range(rows.iter().map(|row| error(row))), 3);
        let title = format!("{name} (mm)");
        let mut plot = Plot::new("trace low", title.clone(), (&x, "time (s)".to_owned()), (&y, title));
        plot.draw("median", line(superimposed(rows, &since, error), &x, &y));
        plot
    });
    plots.collect()
}

/// Time of every row since the start of its repeat, s.
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

/// One line through all repeats; a NaN lifts the pen between them.
fn superimposed<'a>(
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
