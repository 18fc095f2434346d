//! Marks on the time axes of a run: reversals, faults, repeats.

use crate::plot::Plot;
use crate::scale::Axis;
use crate::svg_path::{Pen, vertical_lines};
use sinew_lab::arm::{TraceRow, TrackIncident};

/// Fraction of a reference's range by which it must turn back to reverse.
const TURNED: f64 = 0.005;
/// Range below which a reference rests, rad or m.
const RESTING: f64 = 1e-6;

/// Times at which a reference reverses, s; rows without a value are passed over.
pub(super) fn reversals(rows: &[&TraceRow], of: impl Fn(&TraceRow) -> f64) -> Vec<f64> {
    let points: Vec<(f64, f64)> =
        rows.iter().map(|row| (row.time_s, of(row))).filter(|point| point.1.is_finite()).collect();
    let ends = points.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p.1), h.max(p.1)));
    let (range, mut found) = (ends.1 - ends.0, Vec::new());
    let Some(&(mut at, mut extreme)) = points.first() else { return found };
    if range < RESTING {
        return found;
    }
    let (mut direction, mut from) = (0.0, extreme);
    for (time, value) in points {
        if (value - extreme) * direction > 0.0 {
            (at, extreme) = (time, value);
        } else if direction != 0.0 && (value - extreme) * direction < -TURNED * range {
            found.push(at);
            (direction, at, extreme) = (-direction, time, value);
        } else if direction == 0.0 && (value - from).abs() > TURNED * range {
            (direction, at, extreme) = ((value - from).signum(), time, value);
        }
        from = if direction == 0.0 { from } else { extreme };
    }
    found
}

/// Faults and repeats of a run.
#[derive(Debug)]
pub(super) struct Marks {
    /// First and last report of every fault, s.
    faults: Vec<[f64; 2]>,
    /// Starts of the repeats, s; empty for one.
    repeats: Vec<f64>,
}

impl Marks {
    pub(super) fn new(rows: &[TraceRow], incidents: &[TrackIncident], repeats: u32) -> Self {
        let begin = |k| rows.iter().find(|row| row.repeat == Some(k)).map(|row| row.time_s);
        Self {
            faults: incidents.iter().map(|one| [one.from_s, one.until_s]).collect(),
            repeats: if repeats > 1 { (0..repeats).filter_map(begin).collect() } else { Vec::new() },
        }
    }

    /// Draws them, and the reversals given, into a plot with this time axis.
    pub(super) fn draw(&self, plot: &mut Plot, x: &Axis, reversals: &[f64]) {
        let within = |times: &[f64]| {
            vertical_lines(times.iter().map(|t| x.at(*t)).filter(|f| (0.0..=1.0).contains(f)))
        };
        plot.draw("reversal", "reversal", within(reversals));
        plot.draw("repeat", "start of a repeat", within(&self.repeats));
        let mut pen = Pen::default();
        for [from, until] in &self.faults {
            // The width of an interval is seen on a zoomed axis; its start at once.
            for time in [from, until] {
                pen.line_to(x.at(*time), 0.0);
                pen.line_to(x.at(*time), 1.0);
                pen.lift();
            }
        }
        plot.draw("fault", "fault reported", pen.finish());
    }

    /// Classes and names for a legend.
    pub(super) fn legend(&self) -> Vec<(&'static str, &'static str)> {
        let mut legend = vec![("reversal", "reversal")];
        if !self.repeats.is_empty() {
            legend.push(("repeat", "start of a repeat"));
        }
        if !self.faults.is_empty() {
            legend.push(("fault", "fault reported"));
        }
        legend
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tracking::sample::row;

    #[test]
    fn a_triangle_reverses_at_its_corners_and_a_rest_does_not() {
        let triangle = |t: f64| if t < 1.0 { 2.0 } else { ((t - 1.0) % 4.0 - 2.0).abs() };
        let rows: Vec<TraceRow> = (0..1200).map(|k| row(0.01 * f64::from(k), triangle)).collect();
        let rows: Vec<&TraceRow> = rows.iter().collect();
        let found = reversals(&rows, |row| row.length_m[0]);
        let expected = [3.0, 5.0, 7.0, 9.0, 11.0];
        assert_eq!(found.len(), expected.len(), "{found:?}");
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 0.03), "{found:?}");
        assert!(reversals(&rows, |_| 0.3).is_empty(), "a constant");
        assert!(reversals(&rows, |_| f64::NAN).is_empty(), "no value");
    }
}
