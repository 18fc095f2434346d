//! Maps of the workspace as coloured points, and outlines of sets.

use super::format::physical;
use super::plot::Plot;
use super::scale::{Axis, padded, quantile};
use super::svg_path::{Pen, line};

/// Outlines of a set in a plane: without friction, held, lifted, lowered.
#[derive(Debug)]
pub struct Outlines {
    /// Of the horizontal axis, with its unit.
    pub x_label: String,
    /// Of the vertical axis, with its unit.
    pub y_label: String,
    /// Closed polygons in the plane's unit.
    pub lines: Vec<Vec<[f64; 2]>>,
    /// What the pose needs, where that is a point of the plane.
    pub needed: Option<[f64; 2]>,
}

/// Classes of the quarters of a map, least first, and of the points without a value.
const QUARTERS: [&str; 4] = ["dots q1", "dots q2", "dots q3", "dots q4"];
const WITHOUT: &str = "dots q0";
/// Classes of outlines: without friction, held, lifted, lowered.
const LINES: [(&str, &str); 4] =
    [("measured", "without friction"), ("predicted", "held"), ("near", "lifting"), ("lowered", "lowering")];

/// Two views of the end points, coloured by the quarter of their value.
pub(super) fn map(heading: &str, points: &[([f64; 3], Option<f64>)]) -> Vec<Plot> {
    let mut sorted: Vec<f64> = points.iter().filter_map(|point| point.1).collect();
    sorted.sort_by(f64::total_cmp);
    let edges = [0.0, 0.25, 0.5, 0.75, 1.0].map(|fraction| quantile(&sorted, fraction));
    let class = |value: Option<f64>| match value {
        None => WITHOUT,
        Some(value) => QUARTERS[edges[1..4].iter().filter(|edge| value > **edge).count()],
    };
    let classes: Vec<&str> = points.iter().map(|point| class(point.1)).collect();
    let between = |k: usize| format!("{} to {}", physical(edges[k], 3), physical(edges[k + 1], 3));
    let mut legend: Vec<(&str, String)> = (0..4).map(|k| (QUARTERS[k], between(k))).collect();
    if classes.contains(&WITHOUT) {
        legend.push((WITHOUT, "the machine itself is not held".to_owned()));
    }
    let view = |x: usize, y: usize| {
        let names = ["x (m)", "y (m)", "z (m)"];
        let axis = |k: usize| Axis::new(range(points.iter().map(|point| point.0[k])), 5);
        let (horizontal, vertical) = (axis(x), axis(y));
        let title = format!("{heading}: {} over {}", names[y], names[x]);
        let labels = (names[x].to_owned(), names[y].to_owned());
        let mut plot = Plot::new("loop", title, (&horizontal, labels.0), (&vertical, labels.1));
        for (drawn, name) in legend.iter().map(|(class, name)| (*class, name.as_str())) {
            let mut pen = Pen::default();
            for (point, _) in points.iter().zip(&classes).filter(|(_, class)| **class == drawn) {
                pen.lift();
                pen.line_to(horizontal.at(point.0[x]), vertical.at(point.0[y]));
            }
            plot.draw(drawn, name, pen.finish());
        }
        plot
    };
    // A planar machine is a line from the side.
    let flat = |axis: usize| {
        let (low, high) = range(points.iter().map(|point| point.0[axis]));
        high - low < 1e-9
    };
    let drawn: Vec<Plot> = [2, 1].into_iter().filter(|y| !flat(*y)).map(|y| view(0, y)).collect();
    if drawn.is_empty() { vec![view(0, 2)] } else { drawn }
}

/// A set in a plane, by its outlines.
pub(super) fn outlines(title: &str, of: &Outlines) -> Plot {
    let finite = |k: usize| of.lines.iter().flatten().map(move |point| point[k]).filter(|x| x.is_finite());
    let needed = |k: usize| of.needed.iter().map(move |point| point[k]);
    let x = Axis::new(range(finite(0).chain(needed(0))), 5);
    let y = Axis::new(range(finite(1).chain(needed(1))), 5);
    let title = format!("{title}: {} and {}", of.x_label, of.y_label);
    let mut plot = Plot::new("loop", title, (&x, of.x_label.clone()), (&y, of.y_label.clone()));
    for (points, (class, name)) in of.lines.iter().zip(LINES) {
        let closed = points.iter().chain(points.first()).map(|point| (point[0], point[1]));
        plot.draw(class, name, line(closed, &x, &y));
    }
    if let Some(point) = of.needed {
        plot.draw("dots needed", "what the pose needs", line([(point[0], point[1])].into_iter(), &x, &y));
    }
    plot
}

/// Ends with room.
fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    padded(values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v))), 0.05)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_planar_workspace_is_seen_from_one_side_and_a_spatial_one_from_two() {
        let points = |y: f64| [([0.1, 0.0, 0.2], Some(1.0)), ([0.3, y, 0.1], Some(2.0))];
        assert_eq!(map("payload", &points(0.0)).len(), 1);
        assert_eq!(map("payload", &points(0.2)).len(), 2);
        assert_eq!(map("payload", &[([0.0; 3], Some(1.0))]).len(), 1);
    }
}
