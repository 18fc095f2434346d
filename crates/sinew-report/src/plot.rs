//! A plot as HTML around a stretched SVG: text keeps its size on every screen.

use super::format::NONE;
use super::scale::Axis;
use super::svg_path::{horizontal_lines, vertical_lines};
use askama::Template;

/// A plot with axes.
#[derive(Debug, Template)]
#[template(path = "plot.html")]
pub(super) struct Plot {
    class: &'static str,
    title: String,
    x_label: String,
    y_label: String,
    x_ticks: Vec<Tick>,
    y_ticks: Vec<Tick>,
    widest: String,
    /// Ends of the axes, for the script that draws into the same plot.
    ends: String,
    shapes: Vec<Shape>,
}

/// A label at a position of an axis.
#[derive(Debug)]
struct Tick {
    at: String,
    label: String,
}

/// One path, coloured by its class.
#[derive(Debug)]
pub(super) struct Shape {
    class: &'static str,
    data: String,
}

/// A fraction as a CSS percentage.
pub(super) fn css_percent(fraction: f64) -> String {
    match fraction.is_finite() {
        true => format!("{:.2}", 100.0 * fraction.clamp(0.0, 1.0)),
        false => "0".to_owned(),
    }
}

impl Plot {
    /// An empty plot with its grid; `title` is for screen readers.
    pub(super) fn new(class: &'static str, title: String, x: (&Axis, String), y: (&Axis, String)) -> Self {
        let ticks = |axis: &Axis, flip: bool| -> Vec<Tick> {
            let place = |v: f64| if flip { 1.0 - axis.at(v) } else { axis.at(v) };
            axis.ticks().into_iter().map(|(v, label)| Tick { at: css_percent(place(v)), label }).collect()
        };
        let y_ticks = ticks(y.0, true);
        let widest = y_ticks.iter().map(|t| t.label.as_str()).max_by_key(|l| l.chars().count());
        let widest = widest.unwrap_or(NONE).to_owned();
        let mut grid = horizontal_lines(y.0.ticks().iter().map(|t| y.0.at(t.0)));
        grid.push_str(&vertical_lines(x.0.ticks().iter().map(|t| x.0.at(t.0))));
        let (x_ticks, x_label, y_label) = (ticks(x.0, false), x.1, y.1);
        let shapes = vec![Shape { class: "grid", data: grid }];
        let ends = format!("{} {} {} {}", x.0.low, x.0.high, y.0.low, y.0.high);
        Self { class, title, ends, x_label, y_label, x_ticks, y_ticks, widest, shapes }
    }

    /// Draws a path on top of the others.
    pub(super) fn draw(&mut self, class: &'static str, data: String) {
        if !data.is_empty() {
            self.shapes.push(Shape { class, data });
        }
    }
}
