//! A machine as a drawing: bodies as silhouettes, cables, joints and wrapping surfaces in a parallel
//! projection.

use super::colours::Colours;
use super::error::Error;
use super::format::{plural, significant};
use super::machine_scene::{MachineScene, unit};
use super::scale::round_step;
use sinew::machine::Machine;
use std::fmt::Write;

/// Size of the drawing and of the part in which the machine is sampled: left, top, width, height.
const SIZE: [f64; 2] = [260.0, 230.0];
const BOX: [f64; 4] = [20.0, 58.0, 220.0, 136.0];
/// Directions of view that are compared: about the vertical, and above the horizontal, degrees.
const AZIMUTHS: usize = 12;
const ELEVATIONS: [f64; 2] = [0.0, 20.0];
/// Points of a circle.
const CIRCLE: usize = 24;

/// A drawing of a machine in the pose in which motions start.
pub fn draw(machine: &Machine, colours: &Colours) -> Result<String, Error> {
    let scene = MachineScene::at_start(machine)?;
    let view = View::from_scene(&scene);
    let Colours { card, paper, line, ink, soft, far, toward, .. } = colours;
    let parts = machine.robot.parts();
    let joints = plural(machine.robot.independent_joints().len(), "joint", "joints");
    let muscles = plural(parts.tendons.len(), "muscle", "muscles");
    let [width, height] = SIZE;
    let name = escaped(&parts.name);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" \
            height=\"{height}\" role=\"img\" aria-label=\"{name} in its start pose\" \
            font-family=\"system-ui, sans-serif\" font-size=\"13\"><rect x=\"0.5\" y=\"0.5\" width=\"{}\" \
            height=\"{}\" rx=\"10\" fill=\"{card}\" stroke=\"{line}\" stroke-opacity=\"0.5\"/><text x=\"16\" \
            y=\"27\" font-size=\"16\" font-weight=\"600\" fill=\"{ink}\">{name}</text><text x=\"16\" \
            y=\"46\" fill=\"{soft}\">{joints}, {muscles}</text>",
        width - 1.0,
        height - 1.0
    );
    // The strokes of an empty path are none; writing into a string cannot fail.
    let mut path = |data: String, style: String| {
        if !data.is_empty() {
            let _ = write!(svg, "<path d=\"{data}\" {style}/>");
        }
    };
    let round = "stroke-linejoin=\"round\" stroke-linecap=\"round\"";
    for fixed in [true, false] {
        let opacity = if fixed { 0.13 } else { 0.28 };
        for body in scene.bodies.iter().filter(|body| body.fixed == fixed) {
            let outline = hull(body.points.iter().map(|point| view.place(*point)).collect());
            let width = f64::max(2.0 * body.radius * view.scale, 2.0);
            let style = format!(
                "fill=\"{line}\" stroke=\"{line}\" stroke-width=\"{width:.1}\" opacity=\"{opacity}\" {round}"
            );
            path(closed(&outline), style);
        }
    }
    let circles: String = scene.surfaces.iter().map(|one| closed(&view.circle(*one))).collect();
    path(circles, format!("fill=\"none\" stroke=\"{soft}\" stroke-opacity=\"0.5\""));
    let cables: String =
        scene.cables.iter().flatten().map(|cable| open(cable.iter().map(|p| view.place(*p)))).collect();
    path(cables, format!("fill=\"none\" stroke=\"{far}\" stroke-width=\"1.2\" {round}"));
    let ends = scene.cables.iter().flatten().flat_map(|cable| [cable.first(), cable.last()]).flatten();
    let ends: String = ends.map(|point| dot(view.place(*point))).collect();
    path(ends, format!("stroke=\"{far}\" stroke-width=\"3\" {round}"));
    let joints: String = scene.joints.iter().map(|point| dot(view.place(*point))).collect();
    path(joints.clone(), format!("stroke=\"{ink}\" stroke-width=\"7\" {round}"));
    path(joints, format!("stroke=\"{paper}\" stroke-width=\"4\" {round}"));
    let end_point = scene.end_point.map(|point| dot(view.place(point))).unwrap_or_default();
    path(end_point, format!("stroke=\"{toward}\" stroke-width=\"6.5\" {round}"));
    svg += &view.scale_bar(soft);
    svg.push_str("</svg>\n");
    Ok(svg)
}

/// A parallel projection into the box.
struct View {
    right: [f64; 3],
    up: [f64; 3],
    /// Of the projected middle, m, and units per metre.
    middle: [f64; 2],
    scale: f64,
}

impl View {
    /// The direction in which the points are spread most: with the largest determinant of their covariance.
    fn from_scene(scene: &MachineScene) -> Self {
        let cables = scene.cables.iter().flatten().flatten();
        let points: Vec<[f64; 3]> =
            scene.bodies.iter().flat_map(|body| &body.points).chain(cables).copied().collect();
        let up = scene.up;
        let ahead = unit(across([0.0, 1.0, 0.0], up)).or_else(|| unit(across([1.0, 0.0, 0.0], up)));
        let ahead = ahead.unwrap_or([1.0, 0.0, 0.0]);
        let left = across(up, ahead);
        let mut best: Option<(f64, [[f64; 3]; 2])> = None;
        for elevation in ELEVATIONS {
            let (rise, level) = elevation.to_radians().sin_cos();
            for k in 0..AZIMUTHS {
                // From the machine's right side, so that ahead is to the right.
                let (sine, cosine) = (std::f64::consts::PI * (k as f64 / AZIMUTHS as f64 - 0.5)).sin_cos();
                let right: [f64; 3] = std::array::from_fn(|i| cosine * ahead[i] - sine * left[i]);
                let eye = across(right, up).map(|x| level * x);
                let eye: [f64; 3] = std::array::from_fn(|i| eye[i] + rise * up[i]);
                let axes = [right, across(eye, right)];
                let spread = spread(&points, axes);
                if best.is_none_or(|(most, _)| spread > 1.001 * most) {
                    best = Some((spread, axes));
                }
            }
        }
        let [right, up] = best.map_or([ahead, up], |(_, axes)| axes);
        let range = |axis: [f64; 3]| {
            let along = points.iter().map(|point| dot_product(*point, axis));
            along.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
        };
        let (x, y) = (range(right), range(up));
        let [_, _, width, height] = BOX;
        let scale = f64::min(width / (x.1 - x.0).max(1e-6), height / (y.1 - y.0).max(1e-6));
        Self { right, up, middle: [0.5 * (x.0 + x.1), 0.5 * (y.0 + y.1)], scale }
    }

    fn place(&self, point: [f64; 3]) -> [f64; 2] {
        let [left, top, width, height] = BOX;
        [
            left + 0.5 * width + self.scale * (dot_product(point, self.right) - self.middle[0]),
            top + 0.5 * height - self.scale * (dot_product(point, self.up) - self.middle[1]),
        ]
    }

    /// Outline of a sphere, or the middle section of a cylinder.
    fn circle(&self, (centre, axis, radius): ([f64; 3], Option<[f64; 3]>, f64)) -> Vec<[f64; 2]> {
        let first =
            axis.and_then(|axis| unit(across(axis, self.right)).or_else(|| unit(across(axis, self.up))));
        let (a, b) = match (axis, first) {
            (Some(axis), Some(first)) => (first, across(axis, first)),
            _ => (self.right, self.up),
        };
        let point = |k: usize| {
            let (sine, cosine) = (std::f64::consts::TAU * k as f64 / CIRCLE as f64).sin_cos();
            self.place(std::array::from_fn(|i| centre[i] + radius * (cosine * a[i] + sine * b[i])))
        };
        (0..CIRCLE).map(point).collect()
    }

    /// A round length, a fifth to a half of the box.
    fn scale_bar(&self, colour: &str) -> String {
        let length = round_step(0.3 * BOX[2] / self.scale);
        let (x, y) = (16.0, SIZE[1] - 16.0);
        let end = x + length * self.scale;
        format!(
            "<path d=\"M{x} {:.0}v8M{x} {y:.0}H{end:.1}M{end:.1} {:.0}v8\" fill=\"none\" \
                stroke=\"{colour}\"/><text x=\"{:.1}\" y=\"{:.0}\" fill=\"{colour}\">{} mm</text>",
            y - 4.0,
            y - 4.0,
            end + 8.0,
            y + 4.5,
            significant(1e3 * length, 1)
        )
    }
}

/// Determinant of the covariance of the points along two axes.
fn spread(points: &[[f64; 3]], axes: [[f64; 3]; 2]) -> f64 {
    let count = points.len().max(1) as f64;
    let [x, y] = axes.map(|axis| points.iter().map(|p| dot_product(*p, axis)).collect::<Vec<_>>());
    let mean = |values: &[f64]| values.iter().sum::<f64>() / count;
    let (mx, my) = (mean(&x), mean(&y));
    let moment = |a: &[f64], ma: f64, b: &[f64], mb: f64| {
        a.iter().zip(b).map(|(a, b)| (a - ma) * (b - mb)).sum::<f64>() / count
    };
    let cross = moment(&x, mx, &y, my);
    moment(&x, mx, &x, mx) * moment(&y, my, &y, my) - cross * cross
}

fn dot_product(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn across([a, b, c]: [f64; 3], [x, y, z]: [f64; 3]) -> [f64; 3] {
    [b * z - c * y, c * x - a * z, a * y - b * x]
}

/// Corners of the convex hull, by monotone chains.
fn hull(mut points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    points.dedup();
    if points.len() < 3 {
        return points;
    }
    let chain = |points: &mut dyn Iterator<Item = [f64; 2]>| {
        let mut chain: Vec<[f64; 2]> = Vec::new();
        for point in points {
            while let [.., a, b] = chain[..] {
                let turn = (b[0] - a[0]) * (point[1] - a[1]) - (b[1] - a[1]) * (point[0] - a[0]);
                if turn > 0.0 {
                    break;
                }
                chain.pop();
            }
            chain.push(point);
        }
        chain.pop();
        chain
    };
    let mut corners = chain(&mut points.iter().copied());
    corners.extend(chain(&mut points.iter().rev().copied()));
    corners
}

/// A line as path data.
fn open(points: impl Iterator<Item = [f64; 2]>) -> String {
    let mut data = String::new();
    for (k, [x, y]) in points.enumerate() {
        let _ = write!(data, "{}{x:.1} {y:.1}", if k == 0 { "M" } else { "L" });
    }
    data
}

/// An area as path data.
fn closed(points: &[[f64; 2]]) -> String {
    if points.is_empty() { String::new() } else { open(points.iter().copied()) + "Z" }
}

/// A point, which a round cap makes a dot.
fn dot([x, y]: [f64; 2]) -> String {
    format!("M{x:.1} {y:.1}h0")
}

/// Text that stands in SVG.
fn escaped(text: &str) -> String {
    let clean = text.chars().fold(String::new(), |mut line, c| {
        if c.is_control() {
            line.extend(c.escape_default());
        } else {
            line.push(c);
        }
        line
    });
    clean.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hull_of_a_square_with_points_inside_is_its_corners() {
        let points = vec![[0.0, 0.0], [1.0, 1.0], [0.5, 0.5], [1.0, 0.0], [0.0, 1.0], [0.5, 0.0], [0.0, 0.0]];
        assert_eq!(hull(points), [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
        assert_eq!(hull(vec![[1.0, 2.0]; 3]), [[1.0, 2.0]]);
    }

    #[test]
    fn a_planar_machine_is_seen_from_the_side_and_a_name_cannot_leave_its_text() {
        let robot = |text: &str| {
            let (robot, _) =
                sinew::description::robot_from_toml("m", text, &mut |_| Err(String::new())).unwrap();
            Machine::from_robot(&robot).unwrap()
        };
        let text = sinew_models::PLANAR_LEG;
        let scene = MachineScene::at_start(&robot(text)).unwrap();
        let view = View::from_scene(&scene);
        assert!((view.right[0] - 1.0).abs() < 1e-9 && (view.up[2] - 1.0).abs() < 1e-9);
        let named = text.replacen("\"planar_leg\"", "\"<b>&\"", 1);
        let svg = draw(&robot(&named), &crate::colours::STANDALONE).unwrap();
        assert!(svg.contains("&lt;b&gt;&amp;") && !svg.contains("<b>") && !svg.contains("NaN"));
    }
}
