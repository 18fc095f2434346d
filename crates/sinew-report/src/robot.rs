//! The page of a robot: a three-dimensional view, moment arms over the ranges of the joints, muscles.

use super::error::Error;
use super::format::{fixed, plural, significant};
use super::plot::Plot;
use super::scale::{Axis, padded};
use super::scene::{SceneData, SceneFigure, scene_script};
use super::shell::{SHELL, Shell};
use super::svg_path::{Pen, line};
use askama::Template;

/// Colours and dashes of muscles: those of the view, in the order of the muscles.
const CLASSES: [&str; 32] = [
    "m0 d0", "m1 d1", "m2 d2", "m3 d3", "m4 d0", "m5 d1", "m6 d2", "m7 d3", "m0 d1", "m1 d2", "m2 d3",
    "m3 d0", "m4 d1", "m5 d2", "m6 d3", "m7 d0", "m0 d2", "m1 d3", "m2 d0", "m3 d1", "m4 d2", "m5 d3",
    "m6 d0", "m7 d1", "m0 d3", "m1 d0", "m2 d1", "m3 d2", "m4 d3", "m5 d0", "m6 d1", "m7 d2",
];

/// A robot as it is shown.
#[derive(Debug)]
pub struct RobotView {
    /// Its name.
    pub name: String,
    /// Mass of all bodies, and of those that move, kg.
    pub mass_kg: [f64; 2],
    /// Numbers of bodies and joints.
    pub bodies: usize,
    /// See [`bodies`](Self::bodies).
    pub joints: usize,
    /// In the order of the robot.
    pub muscles: Vec<MuscleRow>,
    /// Poses over which the ranges of the muscles were sampled.
    pub poses: usize,
    /// Moment arms.
    pub curves: Vec<ArmCurves>,
    /// Poses and sweeps.
    pub scene: SceneData,
    /// Index of the pose that is shown first.
    pub start: usize,
}

/// Geometry of one muscle: the extremes are over all sampled poses.
#[derive(Debug)]
pub struct MuscleRow {
    /// Its name.
    pub name: String,
    /// In the reference pose, m.
    pub length_m: f64,
    /// Largest minus least length, m.
    pub travel_m: f64,
    /// The joint about which its moment arm is largest.
    pub strongest: String,
    /// Smallest and largest moment arm about that joint, m.
    pub arm_m: [f64; 2],
    /// Smallest and largest wrap angle, rad.
    pub wrap_rad: [f64; 2],
}

/// Moment arms about one joint over its range.
#[derive(Debug)]
pub struct ArmCurves {
    /// The joint.
    pub joint: String,
    /// Whether it slides: its coordinate is in m, its moment arms are numbers.
    pub slides: bool,
    /// Its coordinates, rad or m.
    pub at: Vec<f64>,
    /// Index of the muscle, and its moment arms, m or 1.
    pub arms: Vec<(usize, Vec<f64>)>,
    /// Discontinuities.
    pub jumps: Vec<ArmJump>,
}

/// A discontinuity of a moment arm: a cable lifts off a surface on another way than it came, or leaves its
/// end.
#[derive(Debug, Clone, PartialEq)]
pub struct ArmJump {
    /// The muscle.
    pub muscle: usize,
    /// Coordinate of the joint, rad or m.
    pub at: f64,
    /// Moment arm below and above it, m or 1.
    pub arm: [f64; 2],
}

#[derive(Template)]
#[template(path = "robot.html")]
struct Page<'a> {
    shell: Shell,
    view: &'a RobotView,
    amount: String,
    scene: SceneFigure,
    scene_script: String,
    plots: Vec<Plot>,
    jumps: Vec<String>,
    rows: Vec<(String, [String; 2], String, [String; 4])>,
}

/// One self-contained HTML page about a robot. The same view gives the same bytes.
///
/// # Errors
/// [`Error`] where the page could not be written; no content of a view makes that happen.
pub fn page(view: &RobotView) -> Result<String, Error> {
    let name = |k: usize| view.muscles.get(k).map_or("", |muscle| muscle.name.as_str());
    let entries: Vec<(&'static str, &str)> =
        (0..view.muscles.len()).map(|k| (CLASSES[k % CLASSES.len()], name(k))).collect();
    let jumps = view
        .curves
        .iter()
        .flat_map(|curve| curve.jumps.iter().map(move |jump| sentence(curve, jump, name(jump.muscle))));
    let page = Page {
        shell: SHELL,
        view,
        amount: format!(
            "{}, {}, {}, {} kg in all, {} kg moving.",
            plural(view.bodies, "body", "bodies"),
            plural(view.joints, "joint", "joints"),
            plural(view.muscles.len(), "muscle", "muscles"),
            significant(view.mass_kg[0], 4),
            significant(view.mass_kg[1], 4)
        ),
        scene: SceneFigure::new(
            &format!("{}: bodies, cables and wrapping surfaces", view.name),
            "Bodies with their shapes, or where the file has none, as bones from joint to joint; cables with \
             their wrapping; transparent shapes are wrapping surfaces.",
            &view.scene,
            view.start,
            &entries,
        )?,
        scene_script: scene_script(),
        plots: view.curves.iter().map(|curve| plot(curve, &name)).collect(),
        jumps: jumps.collect(),
        rows: view.muscles.iter().map(row).collect(),
    };
    Ok(page.render()?)
}

fn row(muscle: &MuscleRow) -> (String, [String; 2], String, [String; 4]) {
    let [low, high] = muscle.arm_m.map(|arm| fixed(1e3 * arm, 1));
    let [from, to] = muscle.wrap_rad.map(|angle| fixed(angle, 3));
    let lengths = [fixed(muscle.length_m, 4), fixed(muscle.travel_m, 4)];
    (muscle.name.clone(), lengths, muscle.strongest.clone(), [low, high, from, to])
}

/// Moment arms in mm, those of a slide as they are.
fn factor(curve: &ArmCurves) -> f64 {
    if curve.slides { 1.0 } else { 1e3 }
}

fn plot<'a>(curve: &ArmCurves, name: &dyn Fn(usize) -> &'a str) -> Plot {
    let factor = factor(curve);
    let all = curve
        .arms
        .iter()
        .flat_map(|(_, arms)| arms.iter().map(|arm| factor * arm))
        .filter(|arm| arm.is_finite());
    let ends = all.fold((0.0_f64, 0.0_f64), |(low, high), arm| (low.min(arm), high.max(arm)));
    let ends_x = [curve.at.first(), curve.at.last()].map(|x| x.copied().unwrap_or(0.0));
    let (x, y) = (Axis::new((ends_x[0], ends_x[1]), 6), Axis::new(padded(ends, 0.06), 5));
    let (unit, arm_unit) = if curve.slides { ("m", "moment arm (1)") } else { ("rad", "moment arm (mm)") };
    let title = format!("Moment arms about {}", curve.joint);
    let labels = (format!("{} ({unit})", curve.joint), arm_unit.to_owned());
    let mut plot = Plot::new("trace", title, (&x, labels.0), (&y, labels.1));
    plot.draw("zero", "", line([(x.low, 0.0), (x.high, 0.0)].into_iter(), &x, &y));
    for (muscle, arms) in &curve.arms {
        let jumps: Vec<&ArmJump> = curve.jumps.iter().filter(|jump| jump.muscle == *muscle).collect();
        let mut points: Vec<(f64, f64)> =
            curve.at.iter().zip(arms).map(|(q, arm)| (*q, factor * arm)).collect();
        // The curve ends before a jump and begins again behind it.
        for jump in &jumps {
            let place = points.partition_point(|(q, _)| *q < jump.at);
            let [below, above] = jump.arm.map(|arm| (jump.at, factor * arm));
            points.splice(place..place, [below, (f64::NAN, f64::NAN), above]);
        }
        plot.draw(CLASSES[muscle % CLASSES.len()], name(*muscle), line(points.into_iter(), &x, &y));
    }
    let mut pen = Pen::default();
    for jump in &curve.jumps {
        for arm in jump.arm {
            pen.lift();
            pen.line_to(x.at(jump.at), y.at(factor * arm));
        }
    }
    plot.draw("dots jump", "jump", pen.finish());
    plot
}

fn sentence(curve: &ArmCurves, jump: &ArmJump, muscle: &str) -> String {
    let unit = if curve.slides { "" } else { "\u{202f}mm" };
    let [below, above] = jump.arm.map(|arm| fixed(factor(curve) * arm, 1));
    format!(
        "{muscle}: from {below} to {above}{unit} at {} = {}\u{202f}{}",
        curve.joint,
        significant(jump.at, 4),
        if curve.slides { "m" } else { "rad" }
    )
}
