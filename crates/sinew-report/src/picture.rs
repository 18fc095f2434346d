//! One standalone picture: loop and trace, in colours that are legible on light and dark pages.

use super::error::Error;
use super::format::{percent, percent_of_range};
use super::page::{chosen, simulated};
use super::record::{Record, Signals, records};
use super::scale::Axis;
use super::svg_path::{WIDTH, decimate};
use super::{loops, traces};
use askama::Template;
use sinew_identify::report::IdentificationReport;

#[derive(Template)]
#[template(path = "picture.svg")]
struct Picture {
    title: String,
    subtitle: String,
    simulated: bool,
    panels: Vec<Panel>,
}

struct Panel {
    /// Left edge, top edge, width and height of the plotting area.
    left: f64,
    top: f64,
    width: f64,
    height: f64,
    x_scale: String,
    y_scale: String,
    x_ticks: Vec<(String, String)>,
    y_ticks: Vec<(String, String)>,
    x_label: String,
    y_label: String,
    measured: String,
    predicted: String,
    band: String,
}

/// A standalone SVG picture of an identification: the near/far loop, and a typical trace with its band.
///
/// # Errors
/// [`Error`] where the picture could not be written; no content of a report makes that happen.
pub fn picture_svg(report: &IdentificationReport) -> Result<String, Error> {
    let signals = Signals::new(report);
    let records = records(report);
    let subtitle = match chosen(report) {
        Some(c) => format!(
            "{}: cross-validated RMSE {} of the range, {} of the samples within the 95\u{202f}% band",
            c.name,
            percent_of_range(c.percent_of_range),
            percent(c.coverage95)
        ),
        None => "no model could be evaluated".to_owned(),
    };
    let mut panels = Vec::new();
    if let Some(typical) = typical(&records) {
        panels.push(loop_panel(typical, &signals));
        panels.push(trace_panel(typical, &signals));
    }
    let title = format!("{}, measured and predicted", signals.far_label());
    Ok(Picture { title, subtitle, simulated: simulated(report), panels }.render()?)
}

/// The record with the median error.
fn typical(records: &[Record]) -> Option<&Record> {
    let mut useful: Vec<&Record> = records.iter().filter(|r| r.len() > 1).collect();
    useful.sort_by(|a, b| a.score().rmse().total_cmp(&b.score().rmse()));
    useful.get(useful.len() / 2).copied()
}

fn loop_panel(record: &Record, signals: &Signals) -> Panel {
    let (x, y) = loops::axes(&[record], 5);
    let (measured, predicted) = loops::paths(&[record], 4000, &x, &y);
    let (x_label, y_label) = (signals.near_label(), signals.far_label());
    panel((76.0, 330.0), (&x, x_label), (&y, y_label), [measured, predicted, String::new()])
}

fn trace_panel(record: &Record, signals: &Signals) -> Panel {
    let (x, y) = traces::far_axes(record, 6);
    let paths = traces::paths(record, &decimate(record, 1600), &x, &y);
    panel((486.0, 684.0), (&x, "time (s)".to_owned()), (&y, signals.far_label()), paths)
}

fn panel(
    (left, width): (f64, f64),
    (x, x_label): (&Axis, String),
    (y, y_label): (&Axis, String),
    [measured, predicted, band]: [String; 3],
) -> Panel {
    let (top, height) = (108.0, 290.0);
    let place = |v: f64| format!("{v:.1}");
    Panel {
        left,
        top,
        width,
        height,
        x_scale: format!("{:.4}", width / WIDTH),
        y_scale: format!("{:.4}", height / super::svg_path::HEIGHT),
        x_ticks: x.ticks().into_iter().map(|(v, l)| (place(left + x.at(v) * width), l)).collect(),
        y_ticks: y.ticks().into_iter().map(|(v, l)| (place(top + (1.0 - y.at(v)) * height), l)).collect(),
        x_label,
        y_label,
        measured,
        predicted,
        band,
    }
}
