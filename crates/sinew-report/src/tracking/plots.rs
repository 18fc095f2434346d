//! Signals of a run over its time: end point, joints, tensions, lengths. Every axis has the same zero, the
//! start of the run.

use super::marks::{Marks, reversals};
use super::view::TrackView;
use crate::envelope::{self, ENVELOPE};
use crate::format::{shown_unit, significant, with_unit};
use crate::plot::{BEYOND, Legend, Plot};
use crate::scale::{Axis, extended, padded, settled};
use crate::svg_path::{line, ribbon};
use sinew_lab::arm::TraceRow;
use sinew_lab::signals::{Axis as Parts, Kind, Signal};

/// Plots of one kind with a legend for all of them.
#[derive(Debug)]
pub(super) struct Family {
    pub(super) plots: Vec<Plot>,
    pub(super) legend: Legend,
    /// Signals that are constant, in a sentence each.
    pub(super) constants: Vec<String>,
}

/// Coordinate of the end point that is none, m.
const NOTHING: f64 = 1e-9;

type Line<'a> = (&'static str, &'static str, Box<dyn Fn(&TraceRow) -> f64 + 'a>);

/// Draws signals of a run.
pub(super) struct Plotter<'a> {
    view: &'a TrackView<'a>,
    rows: Vec<&'a TraceRow>,
    time: Axis,
    marks: Marks,
}

fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let finite = values.filter(|v| v.is_finite());
    finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
}

fn distance(row: &TraceRow) -> f64 {
    row.end_point_reference_m.iter().zip(&row.end_point_m).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

impl<'a> Plotter<'a> {
    pub(super) fn new(view: &'a TrackView<'a>) -> Self {
        let rows: Vec<&TraceRow> = view.trace.iter().collect();
        let last = rows.last().map_or(1.0, |row| row.time_s);
        let incidents = view.tracking.get(&view.drawn).map_or(&[][..], |numbers| &numbers.incidents);
        let marks = Marks::new(view.trace, incidents, view.repeats);
        Self { view, rows, time: Axis::new((0.0, last), 6), marks }
    }

    /// Whether the run has an end point.
    pub(super) fn has_end_point(&self) -> bool {
        self.rows.iter().any(|row| distance(row).is_finite())
    }

    /// Times at which any joint reverses, s.
    pub(super) fn joint_reversals(&self) -> Vec<f64> {
        let joints = 0..self.view.joints.len();
        joints.flat_map(|k| reversals(&self.rows, move |row| row.at(Signal::JointReference, k))).collect()
    }

    /// One plot of signals, in the order of drawing; the range is that of the motion, and that of the whole
    /// run where it is little larger.
    fn plot(&self, small: bool, title: &str, label: String, signals: &[Line<'_>], reversed: &[f64]) -> Plot {
        let moving = || self.rows.iter().filter(|row| row.repeat.is_some());
        let count = moving().count();
        let rows = self.rows.iter().filter(|row| count == 0 || row.repeat.is_some());
        let inner = range(rows.flat_map(|row| signals.iter().map(|(_, _, of)| of(row))));
        let outer = range(self.rows.iter().flat_map(|row| signals.iter().map(|(_, _, of)| of(row))));
        let ends = padded(settled(extended(inner, outer)), 0.05);
        let y = Axis::new(ends, if small { 3 } else { 5 });
        let class = if small { "trace low" } else { "trace" };
        let mut plot = Plot::new(class, title.to_owned(), (&self.time, "time (s)".to_owned()), (&y, label))
            .linked("run");
        if small {
            plot = plot.without_legend();
        }
        self.marks.draw(&mut plot, &self.time, reversed);
        for (class, name, of) in signals {
            let points: Vec<_> = self.rows.iter().map(|row| (row.time_s, of(row))).collect();
            envelope::draw(&mut plot, (class, name), points, (&self.time, &y));
        }
        plot
    }

    fn family(&self, plots: Vec<Plot>, signals: &[(&'static str, &'static str)]) -> Family {
        let mut legend = signals.to_vec();
        legend.extend(plots.iter().any(|plot| plot.has(ENVELOPE.0)).then_some(ENVELOPE));
        legend.extend(plots.iter().any(Plot::leaves_its_axis).then_some(BEYOND));
        let marks = self.marks.legend();
        legend.extend(marks.into_iter().filter(|(class, _)| plots.iter().any(|plot| plot.has(class))));
        Family { plots, legend: Legend::new(&legend), constants: Vec::new() }
    }

    /// Coordinates of the end point with their references, components of the error, and its magnitude with
    /// its limit.
    pub(super) fn end_point(&self) -> Vec<Plot> {
        let reversed = self.joint_reversals();
        let axes = ["x", "y", "z"].into_iter().enumerate();
        // A planar machine stays in its plane.
        let moves = |k: usize| {
            let of = |row: &TraceRow| row.end_point_reference_m[k].abs().max(row.end_point_m[k].abs());
            self.rows.iter().any(|row| of(row) > NOTHING)
        };
        let mut plots: Vec<Plot> = axes
            .filter(|(k, _)| moves(*k))
            .map(|(k, name)| {
                let signals: [Line<'_>; 2] = [
                    ("measured", "reference", Box::new(move |row| row.end_point_reference_m[k])),
                    ("predicted", "true", Box::new(move |row| row.end_point_m[k])),
                ];
                self.plot(false, &format!("End point, {name}"), format!("{name} (m)"), &signals, &reversed)
            })
            .collect();
        let part = |k: usize| move |row: &TraceRow| 1e3 * (row.end_point_m[k] - row.end_point_reference_m[k]);
        let parts: [Line<'_>; 3] = [
            ("predicted", "x", Box::new(part(0))),
            ("lowered", "y", Box::new(part(1))),
            ("near", "z", Box::new(part(2))),
        ];
        let label = "error, true − reference (mm)".to_owned();
        plots.push(self.plot(false, "Components of the end point's error", label, &parts, &reversed));
        let numbers = self.view.tracking.get(&self.view.drawn);
        let limit = numbers.and_then(|numbers| numbers.end_point_limit_m).map(|limit| 1e3 * limit);
        let mut magnitude: Vec<Line<'_>> =
            vec![("predicted", "magnitude of the error", Box::new(|row| 1e3 * distance(row)))];
        // A limit far above the error would flatten it.
        let most =
            self.rows.iter().map(|row| 1e3 * distance(row)).filter(|e| e.is_finite()).fold(0.0, f64::max);
        let mut label = "magnitude of the error (mm)".to_owned();
        match limit {
            Some(limit) if most > 0.5 * limit => {
                magnitude.push(("bound", "limit", Box::new(move |_| limit)));
            }
            Some(limit) => label = format!("magnitude of the error, limit {} (mm)", significant(limit, 3)),
            None => {}
        }
        plots.push(self.plot(false, "Magnitude of the end point's error", label, &magnitude, &reversed));
        plots
    }

    /// Angles of the joints, or positions of slides.
    pub(super) fn joints(&self) -> Family {
        let plot = |(k, name): (usize, &String)| {
            let unit = self.unit(k);
            let signals: [Line<'_>; 3] = [
                ("measured", "reference", Box::new(move |row| row.at(Signal::JointReference, k))),
                ("third", "estimate", Box::new(move |row| row.at(Signal::JointEstimated, k))),
                ("predicted", "true", Box::new(move |row| row.at(Signal::JointTrue, k))),
            ];
            let reversed = reversals(&self.rows, move |row| row.at(Signal::JointReference, k));
            self.plot(true, &format!("Coordinate of {name}"), format!("{name} ({unit})"), &signals, &reversed)
        };
        let plots = self.view.joints.iter().enumerate().map(plot).collect();
        self.family(plots, &[("measured", "reference"), ("third", "estimate"), ("predicted", "true")])
    }

    /// Their errors.
    pub(super) fn joint_errors(&self) -> Family {
        let plot = |(k, name): (usize, &String)| {
            let unit = if self.unit(k) == "m" { "mm" } else { "mrad" };
            let of = |signal: Signal| {
                move |row: &TraceRow| 1e3 * (row.at(signal, k) - row.at(Signal::JointReference, k))
            };
            let signals: [Line<'_>; 2] = [
                ("predicted", "true − reference", Box::new(of(Signal::JointTrue))),
                ("third", "estimate − reference", Box::new(of(Signal::JointEstimated))),
            ];
            let reversed = reversals(&self.rows, move |row| row.at(Signal::JointReference, k));
            self.plot(true, &format!("Error of {name}"), format!("{name} ({unit})"), &signals, &reversed)
        };
        let plots = self.view.joints.iter().enumerate().map(plot).collect();
        self.family(plots, &[("predicted", "true − reference"), ("third", "estimate − reference")])
    }

    fn unit(&self, joint: usize) -> &str {
        self.view.joint_units.get(joint).map_or("rad", String::as_str)
    }

    /// Tensions at both ends of every cable against their limits.
    pub(super) fn tensions(&self) -> Family {
        let numbers = self.view.tracking.get(&self.view.drawn);
        let limits = |k: usize| numbers.and_then(|numbers| numbers.tension_limits_n.get(k)).copied();
        let plot = |(k, name): (usize, &String)| {
            let mut signals: Vec<Line<'_>> = vec![
                (
                    "measured",
                    "desired at the anchor",
                    Box::new(move |row| row.at(Signal::TensionOutDesired, k)),
                ),
                ("near", "at the drive", Box::new(move |row| row.at(Signal::TensionInTrue, k))),
                (
                    "third",
                    "estimated at the anchor",
                    Box::new(move |row| row.at(Signal::TensionOutEstimated, k)),
                ),
                ("predicted", "at the anchor", Box::new(move |row| row.at(Signal::TensionOut, k))),
            ];
            let mut label = format!("{name} (N)");
            if let Some([least, most]) = limits(k) {
                signals.push(("bound", "limits at the anchor", Box::new(move |_| least)));
                let largest = self
                    .rows
                    .iter()
                    .map(|row| row.at(Signal::TensionInTrue, k).max(row.at(Signal::TensionOutDesired, k)));
                if largest.filter(|n| n.is_finite()).fold(0.0, f64::max) > 0.3 * most {
                    signals.push(("bound", "limits at the anchor", Box::new(move |_| most)));
                } else {
                    label = format!("{name}, limit {} (N)", significant(most, 3));
                }
            }
            let reversed = reversals(&self.rows, move |row| row.length_m[k]);
            self.plot(true, &format!("Tension of {name}"), label, &signals, &reversed)
        };
        let plots = self.view.names.iter().enumerate().map(plot).collect();
        let mut legend = vec![
            ("measured", "desired at the anchor"),
            ("near", "at the drive"),
            ("third", "estimated at the anchor"),
            ("predicted", "at the anchor"),
        ];
        if limits(0).is_some() {
            legend.push(("bound", "limits at the anchor"));
        }
        self.family(plots, &legend)
    }

    /// Whatever else is measured at every drive.
    pub(super) fn drives(&self) -> Family {
        let drawn = [Signal::PositionIn, Signal::TensionIn];
        let others = Signal::ALL.iter().filter(|signal| {
            let row = signal.row();
            row.axis == Parts::Muscle && row.kind == Kind::Measured && !drawn.contains(signal)
        });
        let mut constants = Vec::new();
        let mut plots = Vec::new();
        for signal in others {
            let (signal, row) = (*signal, signal.row());
            let of = |k: usize| self.rows.iter().map(move |row| row.at(signal, k));
            let known: Vec<usize> =
                (0..self.view.names.len()).filter(|k| of(*k).any(f64::is_finite)).collect();
            let unit = shown_unit(row.unit);
            if let Some(sentence) =
                constant(row.label, unit, &known.iter().map(|k| range(of(*k))).collect::<Vec<_>>())
            {
                constants.push(sentence);
                continue;
            }
            for k in known {
                let name = &self.view.names[k];
                let lines: [Line<'_>; 1] = [("near", row.label, Box::new(move |row| row.at(signal, k)))];
                let (title, label) =
                    (format!("{} of {name}", row.label), format!("{name}, {} ({unit})", row.label));
                plots.push(self.plot(true, &title, label, &lines, &[]));
            }
        }
        Family { constants, ..self.family(plots, &[("near", "measured")]) }
    }

    /// Changes of the muscles' lengths since the start of the run.
    pub(super) fn lengths(&self) -> Family {
        let plot = |(k, name): (usize, &String)| {
            let start = self.rows.first().map_or(0.0, |row| row.length_m[k]);
            let reference = move |row: &TraceRow| 1e3 * (row.length_m[k] - start);
            let truth = move |row: &TraceRow| reference(row) + 1e3 * row.length_error_m[k];
            let signals: [Line<'_>; 2] =
                [("measured", "reference", Box::new(reference)), ("predicted", "true", Box::new(truth))];
            let reversed = reversals(&self.rows, move |row| row.length_m[k]);
            self.plot(true, &format!("Length of {name}"), format!("{name} (mm)"), &signals, &reversed)
        };
        let plots = self.view.names.iter().enumerate().map(plot).collect();
        self.family(plots, &[("measured", "reference"), ("predicted", "true")])
    }

    /// Errors of the muscles' lengths.
    pub(super) fn length_errors(&self) -> Family {
        let plot = |(k, name): (usize, &String)| {
            let signals: [Line<'_>; 1] =
                [("predicted", "true − reference", Box::new(move |row| 1e3 * row.length_error_m[k]))];
            let reversed = reversals(&self.rows, move |row| row.length_m[k]);
            self.plot(true, &format!("Length error of {name}"), format!("{name} (mm)"), &signals, &reversed)
        };
        let plots = self.view.names.iter().enumerate().map(plot).collect();
        self.family(plots, &[("predicted", "true − reference")])
    }

    /// Mean magnitude of the length error of every muscle, with its standard deviation over time.
    pub(super) fn means(&self) -> Vec<Plot> {
        let Some(numbers) = self.view.tracking.get(&self.view.drawn) else { return Vec::new() };
        let each = numbers.per_muscle.iter().enumerate().map(|(k, mean)| {
            let spread = numbers.per_muscle_std.get(k).copied().unwrap_or(0.0);
            (k as f64, 1e3 * mean, 1e3 * spread)
        });
        let each: Vec<(f64, f64, f64)> = each.collect();
        let x = Axis::new((-0.7, each.len() as f64 - 0.3), 8);
        let most = each.iter().map(|(_, mean, spread)| mean + spread).fold(0.01, f64::max);
        let y = Axis::new((0.0, 1.08 * most), 5);
        let title = "Mean magnitude of the length error".to_owned();
        let label = "mean length error (mm)".to_owned();
        let mut plot =
            Plot::new("trace", title, (&x, String::new()), (&y, label)).with_names(&x, self.view.names);
        // A bar is a vertical line; a NaN lifts the pen.
        let lift = (f64::NAN, f64::NAN);
        let bars = each.iter().flat_map(|(k, mean, _)| [(*k, 0.0), (*k, *mean), lift]);
        plot.draw("bars", "mean over time", line(bars, &x, &y));
        let whiskers = each.iter().flat_map(|(k, mean, spread)| {
            let [low, high] = [(mean - spread).max(0.0), mean + spread];
            let cap = |at: f64| [(k - 0.12, at), (k + 0.12, at), lift];
            [[(*k, low), (*k, high), lift], cap(low), cap(high)].concat()
        });
        plot.draw("whisker", "standard deviation over time", line(whiskers, &x, &y));
        vec![plot]
    }

    /// Mean and standard deviation of the end point's error over one period, over the repeats.
    pub(super) fn over_repeats(&self) -> Option<Plot> {
        const BINS: usize = 200;
        let repeats = self.view.repeats;
        let starts: Vec<f64> = (0..repeats)
            .filter_map(|k| self.rows.iter().find(|row| row.repeat == Some(k)).map(|row| row.time_s))
            .collect();
        let period = starts.windows(2).map(|pair| pair[1] - pair[0]).next()?;
        let mut bins = vec![Vec::new(); BINS];
        for row in self.rows.iter().filter(|row| distance(row).is_finite()) {
            let start = row.repeat.and_then(|k| starts.get(usize::try_from(k).ok()?));
            let Some(start) = start else { continue };
            let place = ((row.time_s - start) / period * BINS as f64) as usize;
            bins[place.min(BINS - 1)].push(1e3 * distance(row));
        }
        let each: Vec<(f64, f64, f64)> = bins
            .iter()
            .enumerate()
            .filter(|(_, errors)| errors.len() > 1)
            .map(|(k, errors)| {
                let count = errors.len() as f64;
                let mean = errors.iter().sum::<f64>() / count;
                let squares: f64 = errors.iter().map(|e| (e - mean) * (e - mean)).sum();
                ((k as f64 + 0.5) / BINS as f64 * period, mean, (squares / (count - 1.0)).sqrt())
            })
            .collect();
        let most = each.iter().map(|(_, mean, spread)| mean + spread).fold(0.1, f64::max);
        let (x, y) = (Axis::new((0.0, period), 6), Axis::new((0.0, 1.05 * most), 5));
        let title = "Error of the end point over a repeat".to_owned();
        let labels =
            ("time since the start of the repeat (s)".to_owned(), "error of the end point (mm)".to_owned());
        let mut plot = Plot::new("trace", title, (&x, labels.0), (&y, labels.1));
        let band = each.iter().map(|(t, mean, spread)| (*t, (mean - spread).max(0.0), mean + spread));
        plot.draw("spread", "± standard deviation over the repeats", ribbon(band, &x, &y));
        plot.draw("predicted", "mean over the repeats", line(each.iter().map(|e| (e.0, e.1)), &x, &y));
        Some(plot)
    }
}

/// A signal that no drive changes during the run, in a sentence; its ranges are those of the drives.
fn constant(label: &str, unit: &str, ranges: &[(f64, f64)]) -> Option<String> {
    let same = |(low, high): &(f64, f64)| high - low <= 1e-9 * low.abs().max(high.abs());
    if ranges.is_empty() || !ranges.iter().all(same) {
        return None;
    }
    let (low, high) = range(ranges.iter().map(|range| range.0));
    let value = |value: f64| significant(value, 3);
    let values = if same(&(low, high)) { value(low) } else { format!("{} to {}", value(low), value(high)) };
    let mut label = label.to_owned();
    label[..1].make_ascii_uppercase();
    Some(format!("{label}: {} at every drive, constant over the run.", with_unit(&values, unit)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_no_drive_changes_is_a_sentence() {
        let told = constant("age of the set-point", "µs", &[(800.0, 800.0), (800.0, 800.0)]);
        let expected = "Age of the set-point: 800\u{202f}µs at every drive, constant over the run.";
        assert_eq!(told.as_deref(), Some(expected));
        assert!(constant("motor current", "A", &[(1.0, 1.0), (1.0, 2.0)]).is_none());
        assert!(constant("motor current", "A", &[]).is_none());
    }
}
