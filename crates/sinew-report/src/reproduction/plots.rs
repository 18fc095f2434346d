//! Figures 7 to 10.

use super::indices::MUSCLES;
use crate::format::fixed;
use crate::plot::Plot;
use crate::scale::{Axis, padded};
use crate::svg_path::{Pen, line};
use crate::variants::label;
use sinew_lab::CompensationVariant;
use sinew_lab::paper::SPEEDS;
use sinew_lab::reproduce::{BenchPart, Point, Trace};

/// One cycle of a variant at a speed.
pub(super) fn strokes(
    part: &BenchPart,
    variant: CompensationVariant,
    speed: usize,
    near: bool,
) -> Option<Plot> {
    let trace: &Trace = part.traces.iter().find(|trace| trace.variant == variant && trace.speed == speed)?;
    let rows: Vec<_> = trace.rows.iter().filter(|row| row.time > 3.0).collect();
    let (first, last) = (rows.first()?.time, rows.last()?.time);
    let most = rows.iter().map(|row| row.far.max(row.desired)).fold(220.0, f64::max);
    let (x, y) = (Axis::new((first, last), 5), Axis::new(padded((0.0, most.min(700.0)), 0.03), 5));
    let title = format!("{}, {} m/s", label(variant), fixed(SPEEDS[speed], 2));
    let mut plot =
        Plot::new("trace", title.clone(), (&x, "time (s)".to_owned()), (&y, format!("{title}: tension (N)")));
    plot.draw("measured", "reference", line(rows.iter().map(|row| (row.time, row.desired)), &x, &y));
    if near {
        plot.draw("near", "near tension", line(rows.iter().map(|row| (row.time, row.near)), &x, &y));
    }
    plot.draw("predicted", "far tension", line(rows.iter().map(|row| (row.time, row.far)), &x, &y));
    Some(plot)
}

/// Classes of the points by speed.
const DOTS: [&str; 6] = ["dots v0", "dots v1", "dots v2", "dots v3", "dots v4", "dots v5"];

/// Figures 9 and 10 at all speeds.
pub(super) fn scatters(part: &BenchPart) -> Vec<Plot> {
    let mut plots = Vec::new();
    for (label, of) in [
        ("far tension (N)", (|p: &Point| p.far) as fn(&Point) -> f64),
        ("elongation (mm)", |p: &Point| p.stretch),
    ] {
        for (side, muscle) in MUSCLES.into_iter().enumerate() {
            let speeds = &part.mechanism.points[side];
            let most = |of: fn(&Point) -> f64| speeds.iter().flatten().map(of).fold(1.0, f64::max);
            let (x, y) = (
                Axis::new(padded((0.0, most(|p| p.near)), 0.03), 5),
                Axis::new(padded((0.0, most(of)), 0.03), 5),
            );
            let title = format!("{muscle}: {label}");
            let mut plot = Plot::new("loop", title.clone(), (&x, "near tension (N)".to_owned()), (&y, title));
            for ((points, class), speed) in speeds.iter().zip(DOTS).zip(SPEEDS) {
                let mut pen = Pen::default();
                for point in points {
                    pen.lift();
                    pen.line_to(x.at(point.near), y.at(of(point)));
                }
                plot.draw(class, &format!("{} m/s", fixed(speed, 2)), pen.finish());
            }
            plots.push(plot);
        }
    }
    plots
}
