//! What a page has to know of a machine before its states.

use crate::choices::Choices;
use crate::drawing::{Drawing, POINTS, SHEATH_POINTS};
use crate::layout::Layout;
use serde_json::{Value, json};
use sinew::Error;
use sinew::control::supervisor::{FaultCode, Mode};
use sinew::machine::Machine;
use sinew::trajectory::{Reference, Trajectory};
use sinew_session::signals::{Axis, Kind, Signal};
use sinew_view::Shape;

/// Points of the path of the end point.
const PATH_POINTS: usize = 240;
/// Poses of a motion whose extent is shown.
const EXTENT_POSES: usize = 60;

/// An event of a recording.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Event {
    /// Time of the event, s.
    pub(crate) time: f64,
    /// `fault`, `state` or `repeat`.
    pub(crate) kind: &'static str,
    pub(crate) text: String,
}

/// A recording as the page shows it.
#[derive(Debug, Clone, Default)]
pub(crate) struct Recorded<'a> {
    /// How long it lasts, s.
    pub(crate) duration: f64,
    pub(crate) events: &'a [Event],
    /// Names of recordings that can be laid over it.
    pub(crate) overlays: &'a [String],
}

/// What the scene is made of.
pub(crate) struct SceneParts<'a> {
    pub(crate) machine: &'a Machine,
    pub(crate) layout: &'a Layout,
    pub(crate) choices: &'a Choices,
    pub(crate) revision: u32,
    /// `twin`, `segment`, `ethercat` or `recording`.
    pub(crate) source: &'static str,
    pub(crate) simulated: bool,
    /// Requested path of the end point and its name.
    pub(crate) trajectory: Option<&'a Trajectory>,
    pub(crate) path: &'a str,
    /// What the reader has to know first, in words.
    pub(crate) notice: Option<&'a str>,
    /// What is shown beside the first machine.
    pub(crate) compared: Option<&'a str>,
    /// Commands that are accepted, and among the modes those that can be asked for.
    pub(crate) commands: &'a [&'static str],
    pub(crate) requests: Vec<&'static str>,
    /// Failures as `--fault` writes them, with what they are; `{}` is the name of a muscle.
    pub(crate) failures: &'a [(&'static str, &'static str)],
    /// Whether tensions along cables are interpolated between their ends.
    pub(crate) interpolated: bool,
    pub(crate) recorded: Option<Recorded<'a>>,
}

/// All faults by their codes: kind, part, and whether its index is that of a joint or a muscle.
fn fault_codes() -> Value {
    let named = |code: FaultCode| {
        let about = json!({"kind": code.kind.name(), "part": code.part, "of": code.counted.name()});
        (code.number.to_string(), about)
    };
    FaultCode::all().map(named).collect::<serde_json::Map<_, _>>().into()
}

/// The answer to `/scene`.
pub(crate) fn scene(parts: &SceneParts<'_>, drawing: &mut Drawing) -> Result<Value, Error> {
    let SceneParts { machine, layout, choices, recorded, .. } = parts;
    let robot = &machine.robot;
    let bodies = &robot.parts().bodies;
    let name = |(k, body): (usize, &sinew::body::Body)| match (k, body.name.as_str()) {
        (0, _) => "world".to_owned(),
        (k, "") => format!("body_{k}"),
        (_, name) => name.to_owned(),
    };
    let bodies: Value = bodies
        .iter()
        .enumerate()
        .map(|(k, body)| json!({"name": name((k, body)), "parent": body.parent}))
        .collect();
    let joints: Value = robot
        .independent_joints()
        .into_iter()
        .map(|joint| {
            let joint = &robot.parts().joints[joint];
            let unit = joint.kind.unit();
            json!({"name": joint.name, "unit": unit, "range": joint.range, "body": joint.body, "axis": joint.axis,
                "position": joint.anchor})
        })
        .collect();
    let muscles: Value = machine
        .muscles
        .iter()
        .zip(&robot.parts().tendons)
        .enumerate()
        .map(|(k, (design, tendon))| {
            json!({"name": tendon.name, "tension_limits_n": choices.tension_limits.get(k),
                "sheath": {"length_m": design.sheath, "bend_rad": design.bend, "mu": design.cable.friction,
                    "pretension_n": design.cable.pretension},
                "winch": drawing.winch(k), "points": POINTS, "sheath_points": SHEATH_POINTS})
        })
        .collect();
    let end_point = machine.task.site().map(|site| {
        let site = &robot.parts().sites[site];
        json!({"body": site.body, "position": site.position})
    });
    let line = match parts.trajectory.filter(|_| end_point.is_some()) {
        Some(trajectory) => path_points(trajectory, drawing)?,
        None => Vec::new(),
    };
    let shapes = sinew_view::shapes(robot.parts());
    let extent = parts.trajectory.map(|trajectory| extent(trajectory, &shapes, drawing)).transpose()?;
    let events = recorded.iter().flat_map(|recorded| recorded.events);
    let events: Value =
        events.map(|event| json!({"time_s": event.time, "kind": event.kind, "text": event.text})).collect();
    let recording = recorded.as_ref().map(|recorded| json!({"duration_s": recorded.duration}));
    Ok(json!({
        "schema": "sinew.live/1",
        "machine": robot.parts().name,
        "source": parts.source,
        "simulated": parts.simulated,
        "period_s": machine.period,
        "gravity": robot.parts().gravity,
        "bodies": bodies,
        "shapes": shapes,
        "meshes": sinew_view::meshes(robot.parts()),
        "joints": joints,
        "muscles": muscles,
        "end_point": end_point,
        "path": if line.is_empty() { Value::Null } else { json!(line) },
        "extent": extent.unwrap_or_default(),
        "path_name": parts.path,
        "notice": parts.notice,
        "paths": choices.paths,
        "poses": {},
        "supervisor": {"modes": Mode::ALL.map(Mode::name), "faults": fault_codes()},
        "variants": choices.variants,
        "compare": parts.compared,
        "fault_kinds": parts.failures,
        "commands": parts.commands,
        "requests": parts.requests,
        "layout": layout.json(),
        "layout_revision": parts.revision,
        "signals": signals(machine, layout),
        "tension_along": if parts.interpolated { "interpolated" } else { "simulated" },
        "events": events,
        "overlays": recorded.as_ref().map_or(&[][..], |recorded| recorded.overlays),
        "recording": recording,
    }))
}

/// The outermost corners of bodies along a motion, m: what a view of it should contain.
fn extent(trajectory: &Trajectory, shapes: &[Shape], drawing: &mut Drawing) -> Result<Vec<[f64; 3]>, Error> {
    let mut at = Reference::new(trajectory.joints());
    let sides = [-1.0, 0.0, 1.0];
    let directions =
        sides.into_iter().flat_map(|x| sides.into_iter().flat_map(move |y| sides.map(|z| [x, y, z])));
    let mut farthest: Vec<([f64; 3], f64, [f64; 3])> =
        directions.map(|direction| (direction, f64::NEG_INFINITY, [0.0; 3])).collect();
    for k in 0..=EXTENT_POSES {
        trajectory.sample(trajectory.duration() * k as f64 / EXTENT_POSES as f64, &mut at)?;
        drawing.evaluate(&at.q)?;
        // Surfaces that cables wrap are drawn as cylinders of a chosen length.
        let drawn = shapes.iter().filter(|shape| shape.body > 0 && !shape.wrap);
        let corners = drawn.flat_map(|shape| shape.corners().map(|corner| (shape.body, corner)));
        let mut points: Vec<[f64; 3]> = corners.map(|(body, at)| drawing.place(body, at)).collect();
        points.extend(drawing.end_point());
        for (direction, distance, outermost) in &mut farthest {
            for point in &points {
                let along = (0..3).map(|k| direction[k] * point[k]).sum::<f64>();
                if along > *distance {
                    (*distance, *outermost) = (along, *point);
                }
            }
        }
    }
    Ok(farthest
        .into_iter()
        .filter(|(_, distance, _)| distance.is_finite())
        .map(|(_, _, point)| point)
        .collect())
}

/// Points of the end point along a path, m.
fn path_points(trajectory: &Trajectory, drawing: &mut Drawing) -> Result<Vec<[f64; 3]>, Error> {
    let (mut line, mut at) = (Vec::with_capacity(PATH_POINTS + 1), Reference::new(trajectory.joints()));
    for k in 0..=PATH_POINTS {
        trajectory.sample(trajectory.duration() * k as f64 / PATH_POINTS as f64, &mut at)?;
        drawing.evaluate(&at.q)?;
        line.extend(drawing.end_point());
    }
    Ok(line)
}

/// Every number of a muscle or joint by its name.
fn signals(machine: &Machine, layout: &Layout) -> Value {
    let robot = &machine.robot;
    let muscles = robot.parts().tendons.iter().map(|tendon| (tendon.name.as_str(), None));
    let joint = |joint: usize| {
        let joint = &robot.parts().joints[joint];
        (joint.name.as_str(), Some(joint.kind.unit()))
    };
    let joints = robot.independent_joints().into_iter().map(joint);
    let mut all = Vec::new();
    for (axis, parts) in [(Axis::Muscle, muscles.collect::<Vec<_>>()), (Axis::Joint, joints.collect())] {
        for (k, (part, unit)) in parts.into_iter().enumerate() {
            let rows = Signal::ALL.iter().map(|signal| signal.row());
            for row in rows.filter(|row| row.axis == axis && layout.has(row.name)) {
                let [muscle, joint] = [Axis::Muscle, Axis::Joint].map(|of| (of == axis).then_some(k));
                all.push(json!({"name": format!("{}:{part}", row.name), "label": row.label,
                    "unit": unit.unwrap_or(row.unit), "group": if unit.is_some() { "joint" } else { row.label },
                    "muscle": muscle, "joint": joint, "field": row.name, "index": k,
                    "simulated_truth": row.kind == Kind::Truth}));
            }
        }
    }
    all.into()
}
