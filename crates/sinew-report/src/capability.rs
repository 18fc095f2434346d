//! What a machine can do over its workspace: a page with tables, maps and sets.

use super::capability_plots::{Outlines, map, outlines};
use super::error::Error;
use super::format::physical;
use super::payload::Payload;
use super::plot::Plot;
use super::scene::{SceneData, SceneFigure, machine_figure, scene_script};
use super::shell::{SHELL, Shell};
use askama::Template;
use sinew::control::capability::{Extreme, PoseCapability};
use std::collections::BTreeMap;

/// A map, as it is shown.
#[derive(Debug)]
pub struct MapView<'a> {
    /// Of the machine.
    pub name: String,
    /// Name and unit of every independent joint.
    pub joints: Vec<(String, &'static str)>,
    /// Names.
    pub muscles: Vec<String>,
    /// In every pose, the start first.
    pub poses: &'a [PoseCapability],
    /// Torques of neighbouring joints at the start.
    pub torques: Vec<Outlines>,
    /// Forces of the end point at the start.
    pub forces: Vec<Outlines>,
    /// With the heat of the drives.
    pub payload: Payload,
}

/// A quantity over all poses.
#[derive(Debug)]
pub struct Quantity {
    /// Its name, with the axis or joint.
    pub name: String,
    /// Its unit.
    pub unit: &'static str,
    /// Poses in which it has a value.
    pub count: usize,
    /// Minimum, median and maximum.
    pub spread: [f64; 3],
    /// The muscle that limits it in most poses, and their number.
    pub limited_by: Option<(String, usize)>,
}

/// All quantities of a map: of the end point, then of the joints.
pub fn quantities(view: &MapView<'_>) -> Vec<Quantity> {
    let mut all = Vec::new();
    let mut add = |name: String, unit, values: Vec<Extreme>| {
        if !values.is_empty() {
            all.push(quantity(view, name, unit, &values));
        }
    };
    let end_points = || view.poses.iter().filter_map(|pose| pose.end_point.as_ref());
    let plain = |value: f64| Extreme { value, muscle: None, largest: true };
    for (k, name) in ["payload lifted", "payload held", "payload lowered"].into_iter().enumerate() {
        add(name.to_owned(), "kg", end_points().filter_map(|end_point| end_point.payload[k]).collect());
    }
    add("force".to_owned(), "N", end_points().filter_map(|e| e.force.map(|found| found.0)).collect());
    add("speed".to_owned(), "m/s", end_points().filter_map(|e| e.speed.map(|found| found.0)).collect());
    let stiffness = end_points().filter_map(|e| e.stiffness.map(|[least, _]| plain(least)));
    add("stiffness, least".to_owned(), "N/m", stiffness.collect());
    for (j, (name, unit)) in view.joints.iter().enumerate() {
        let slide = *unit == "m";
        let joints = || view.poses.iter().map(|pose| &pose.joints[j]);
        for (k, sign) in ["-", "+"].into_iter().enumerate() {
            let torque = joints().filter_map(|joint| joint.torque.map(|torque| torque[k])).collect();
            add(format!("{name}: torque {sign}"), if slide { "N" } else { "Nm" }, torque);
        }
        let unit = if slide { "m/s" } else { "rad/s" };
        add(format!("{name}: speed"), unit, joints().map(|joint| joint.speed).collect());
        let stiffness = joints().filter_map(|joint| joint.stiffness.map(plain)).collect();
        add(format!("{name}: stiffness"), if slide { "N/m" } else { "Nm/rad" }, stiffness);
    }
    all
}

fn quantity(view: &MapView<'_>, name: String, unit: &'static str, values: &[Extreme]) -> Quantity {
    let mut sorted: Vec<f64> = values.iter().map(|extreme| extreme.value).collect();
    sorted.sort_by(f64::total_cmp);
    let mut counts: BTreeMap<usize, usize> = BTreeMap::new();
    values
        .iter()
        .filter_map(|extreme| extreme.muscle)
        .for_each(|muscle| *counts.entry(muscle).or_default() += 1);
    let most = counts.into_iter().max_by_key(|&(muscle, count)| (count, std::cmp::Reverse(muscle)));
    Quantity {
        name,
        unit,
        count: values.len(),
        spread: [sorted[0], sorted[sorted.len() / 2], sorted[sorted.len() - 1]].map(nonzero),
        limited_by: most.map(|(muscle, count)| (view.muscles[muscle].clone(), count)),
    }
}

/// A number in SI units; a sum of cancelling terms below a billionth of them is zero, as where one cable
/// cannot load joints independently.
fn nonzero(value: f64) -> f64 {
    if value.abs() < NOTHING { 0.0 } else { value }
}

/// Magnitude of rounding, in SI units.
const NOTHING: f64 = 1e-9;

#[derive(Template)]
#[template(path = "capability.html")]
struct Page<'a> {
    shell: Shell,
    name: &'a str,
    poses: usize,
    scene: SceneFigure,
    scene_script: String,
    rows: Vec<Row>,
    maps: Vec<Map>,
    torques: Vec<Plot>,
    forces: Vec<Plot>,
    held: Vec<[String; 6]>,
    raised: Vec<[String; 4]>,
    /// Whether a change gives any payload.
    is_raised: bool,
}

struct Row {
    name: String,
    cells: Vec<(&'static str, String)>,
    limited_by: String,
}

/// A quantity over the workspace, in two views.
struct Map {
    heading: String,
    plots: Vec<Plot>,
}

/// A page of its own.
pub fn page(view: &MapView<'_>, scene: &SceneData) -> Result<String, Error> {
    let rows = quantities(view).into_iter().map(|quantity| {
        let [least, median, most] = quantity.spread.map(|value| physical(value, 3));
        Row {
            cells: vec![
                ("unit", quantity.unit.to_owned()),
                ("poses", quantity.count.to_string()),
                ("minimum", least),
                ("median", median),
                ("maximum", most),
            ],
            limited_by: quantity
                .limited_by
                .map_or_else(String::new, |(muscle, count)| format!("{muscle} ({count})")),
            name: quantity.name,
        }
    });
    let page = Page {
        shell: SHELL,
        name: &view.name,
        poses: view.poses.len(),
        scene: machine_figure(scene)?,
        scene_script: scene_script(),
        rows: rows.collect(),
        maps: maps(view),
        held: view.payload.held_rows(),
        raised: view.payload.raised_rows(),
        is_raised: view.payload.is_raised(),
        torques: view.torques.iter().map(|one| outlines("Joint torques", one)).collect(),
        forces: view.forces.iter().map(|one| outlines("Forces of the end point", one)).collect(),
    };
    Ok(page.render()?)
}

/// Whether a place of a map has a number, other than zero.
fn is_something(point: &([f64; 3], Option<f64>)) -> bool {
    point.1.is_some_and(|value| value.abs() > NOTHING)
}

type Value = fn(&PoseCapability) -> Option<f64>;

fn maps(view: &MapView<'_>) -> Vec<Map> {
    let all: [(&str, Value); 6] = [
        ("Payload lifted (kg)", |pose| pose.end_point.as_ref()?.payload[0].map(|extreme| extreme.value)),
        ("Payload held (kg)", |pose| pose.end_point.as_ref()?.payload[1].map(|extreme| extreme.value)),
        ("Payload lowered (kg)", |pose| pose.end_point.as_ref()?.payload[2].map(|extreme| extreme.value)),
        ("Force in the weakest direction (N)", |pose| {
            pose.end_point.as_ref()?.force.map(|found| found.0.value)
        }),
        ("Speed in the slowest direction (m/s)", |pose| {
            pose.end_point.as_ref()?.speed.map(|found| found.0.value)
        }),
        ("Stiffness in the softest direction (N/m)", |pose| {
            pose.end_point.as_ref()?.stiffness.map(|[least, _]| least)
        }),
    ];
    let mut maps = Vec::new();
    for (heading, value) in all {
        let points: Vec<([f64; 3], Option<f64>)> = view
            .poses
            .iter()
            .filter_map(|pose| Some((pose.end_point.as_ref()?.position, value(pose))))
            .collect();
        if points.iter().any(is_something) {
            let plots = map(heading, &points);
            maps.push(Map { heading: heading.to_owned(), plots });
        }
    }
    if let Some(held) = view.payload.held.last() {
        let places = view.poses.iter().zip(&held.each);
        let points: Vec<([f64; 3], Option<f64>)> =
            places.filter_map(|(pose, mass)| Some((pose.end_point.as_ref()?.position, *mass))).collect();
        if points.iter().any(is_something) {
            let heading = "Continuous payload (kg)";
            let plots = map(heading, &points);
            maps.insert(0, Map { heading: heading.to_owned(), plots });
        }
    }
    maps
}
