//! A plot as HTML around a stretched SVG: text keeps its size on every screen, and the page's script reads
//! the paths to show values under the cursor, to zoom and to save the picture.

use super::format::NONE;
use super::scale::Axis;
use super::svg_path::{HEIGHT, WIDTH, beyond, horizontal_lines, vertical_lines};
use askama::Template;

/// Classes of marks on a time axis.
const MARKS: [&str; 3] = ["reversal", "repeat", "fault"];

/// Class and name of the bars where signals leave the picture.
pub(super) const BEYOND: (&str, &str) = ("beyond", "beyond the axis");

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
    /// Ends of the axes.
    ends: String,
    /// Whether the labels of the horizontal axis are names.
    named: bool,
    /// Plots of one name show the same horizontal range.
    link: &'static str,
    legend: bool,
    /// Whether bars at the edges have a legend of their own.
    names_beyond: bool,
    shapes: Vec<Shape>,
}

/// A label at a position of an axis.
#[derive(Debug)]
struct Tick {
    at: String,
    label: String,
}

/// One path: coloured, dashed or filled by its class.
#[derive(Debug)]
struct Shape {
    class: &'static str,
    /// In the legend and beside the value under the cursor; empty: in neither.
    name: String,
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
    /// An empty plot with its grid; `title` is for screen readers and the name of the saved picture.
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
        let shapes = vec![Shape { class: "grid", name: String::new(), data: grid }];
        let ends = format!("{} {} {} {}", x.0.low, x.0.high, y.0.low, y.0.high);
        Self {
            class,
            title,
            ends,
            x_label,
            y_label,
            x_ticks,
            y_ticks,
            widest,
            shapes,
            named: false,
            link: "",
            legend: true,
            names_beyond: false,
        }
    }

    /// Names in place of numbers along the horizontal axis: the name of 0 first, one apart.
    pub(super) fn with_names(mut self, x: &Axis, names: &[String]) -> Self {
        let place = |k: usize| css_percent(x.at(k as f64));
        self.x_ticks =
            names.iter().enumerate().map(|(k, n)| Tick { at: place(k), label: n.clone() }).collect();
        self.named = true;
        self
    }

    /// Shows the same horizontal range as the others with this name, also after a zoom.
    pub(super) fn linked(mut self, link: &'static str) -> Self {
        self.link = link;
        self
    }

    /// Without a legend of its own, where one legend serves several plots.
    pub(super) fn without_legend(mut self) -> Self {
        self.legend = false;
        self
    }

    /// Without a legend but of what leaves the axis, where nothing stands beside the plot that would name it.
    pub(super) fn without_names(mut self) -> Self {
        (self.legend, self.names_beyond) = (false, true);
        self
    }

    /// Draws a path on top of the others, with its name in the legend.
    pub(super) fn draw(&mut self, class: &'static str, name: &str, data: String) {
        if !data.is_empty() {
            self.shapes.push(Shape { class, name: name.to_owned(), data });
        }
    }

    /// Bars on the edges where signals leave the picture.
    fn beyond(&self) -> String {
        let signals = self
            .shapes
            .iter()
            .filter(|shape| !shape.name.is_empty() && !shape.data.contains(['h', 'v', 'z']));
        beyond(&signals.map(|shape| shape.data.as_str()).collect::<Vec<_>>())
    }

    /// Whether a signal leaves the picture.
    pub(super) fn leaves_its_axis(&self) -> bool {
        !self.beyond().is_empty()
    }

    /// Whether a path of this class was drawn.
    pub(super) fn has(&self, class: &str) -> bool {
        self.shapes.iter().any(|shape| shape.class == class)
    }

    /// Entries of the legend: class and name, every name once.
    fn entries(&self) -> Vec<(&str, &str)> {
        let mut entries: Vec<(&str, &str)> = Vec::new();
        for shape in self.shapes.iter().filter(|shape| self.legend && !shape.name.is_empty()) {
            if !entries.contains(&(shape.class, shape.name.as_str())) {
                entries.push((shape.class, &shape.name));
            }
        }
        if (self.legend || self.names_beyond) && !self.beyond().is_empty() {
            entries.push(BEYOND);
        }
        // Marks stand behind the signals.
        entries.sort_by_key(|(class, _)| MARKS.contains(class));
        entries
    }

    fn size(&self) -> [f64; 2] {
        [WIDTH, HEIGHT]
    }
}

/// A legend beside plots that have none: class and name of every line.
#[derive(Debug, Template)]
#[template(path = "legend.html")]
pub(super) struct Legend {
    entries: Vec<(&'static str, String)>,
}

impl Legend {
    pub(super) fn new(entries: &[(&'static str, &str)]) -> Self {
        Self { entries: entries.iter().map(|(class, name)| (*class, (*name).to_owned())).collect() }
    }
}
