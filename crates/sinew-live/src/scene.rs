//! What a page has to know of a machine before its states.

use crate::choices::Choices;
use crate::drawing::{Drawing, POINTS, SHEATH_POINTS};
use crate::layout::Layout;
use crate::simulation::CYCLE;
use serde_json::{Value, json};
use sinew::Error;
use sinew::body::JointKind;
use sinew::control::supervisor::{FaultKind, Mode};
use sinew::machine::Machine;
use sinew::trajectory::{Reference, Trajectory};

/// Points of the path of the end point.
const PATH_POINTS: usize = 240;
/// Commands that a simulated machine takes.
const COMMANDS: [&str; 8] = ["mode", "path", "drag", "push", "payload", "fault", "speed", "step"];
/// Failures as `--fault` writes them, with what they are; `{}` is the name of a muscle.
const FAULTS: [(&str, &str); 9] = [
    ("load-cell:{}:lost", "load cell gives no value"),
    ("load-cell:{}:stuck", "load cell is stuck"),
    ("motor-encoder:{}:lost", "motor encoder gives no value"),
    ("motor-encoder:{}:stuck", "motor encoder is stuck"),
    ("drive:{}", "drive has no power"),
    ("winch:{}", "winch is jammed"),
    ("cable:{}", "cable breaks"),
    ("wear:{}:friction=1", "friction doubles"),
    ("wear:{}:pretension=0.5", "half of the pretension is lost"),
];

/// What the scene is made of.
pub(crate) struct SceneParts<'a> {
    pub(crate) machine: &'a Machine,
    pub(crate) trajectory: &'a Trajectory,
    pub(crate) layout: &'a Layout,
    pub(crate) choices: &'a Choices,
    pub(crate) compared: Option<&'a str>,
    pub(crate) path: &'a str,
    pub(crate) revision: u32,
}

/// The answer to `/scene`.
pub(crate) fn scene(parts: &SceneParts<'_>, drawing: &mut Drawing) -> Result<Value, Error> {
    let SceneParts { machine, trajectory, layout, choices, compared, path, revision } = *parts;
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
            let unit = if joint.kind == JointKind::Slide { "m" } else { "rad" };
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
    let mut line = Vec::new();
    if end_point.is_some() {
        let mut at = Reference::new(trajectory.joints());
        for k in 0..=PATH_POINTS {
            trajectory.sample(trajectory.duration() * k as f64 / PATH_POINTS as f64, &mut at)?;
            drawing.evaluate(&at.q)?;
            line.extend(drawing.end_point());
        }
    }
    let mut commands: Vec<&str> = COMMANDS.to_vec();
    commands.retain(|command| *command != "drag" || end_point.is_some());
    if choices.variants.len() > 1 {
        commands.push("compare");
    }
    let faults: Vec<&str> =
        ["none"].into_iter().chain(FaultKind::ALL.iter().map(|kind| kind.name())).collect();
    Ok(json!({
        "schema": "sinew.live/1",
        "machine": robot.parts().name,
        "source": "twin",
        "simulated": true,
        "period_s": CYCLE,
        "gravity": robot.parts().gravity,
        "bodies": bodies,
        "shapes": sinew_view::shapes(robot.parts()),
        "joints": joints,
        "muscles": muscles,
        "end_point": end_point,
        "path": if line.is_empty() { Value::Null } else { json!(line) },
        "path_name": path,
        "paths": choices.paths,
        "poses": {},
        "supervisor": {"modes": Mode::ALL.map(Mode::name), "faults": faults},
        "variants": choices.variants,
        "compare": compared,
        "fault_kinds": FAULTS,
        "commands": commands,
        "layout": layout.json(),
        "layout_revision": revision,
        "signals": signals(machine),
        "events": [],
        "recording": null,
    }))
}

/// Every number of a muscle or joint by its name.
fn signals(machine: &Machine) -> Value {
    let robot = &machine.robot;
    let muscles = robot.parts().tendons.iter().map(|tendon| tendon.name.as_str());
    let joints = robot.independent_joints();
    let mut all = Vec::new();
    for (k, muscle) in muscles.enumerate() {
        for (field, label, unit, group, truth) in [
            ("tension_in", "near tension", "N", "near tension", false),
            ("tension_out_desired", "far tension, reference", "N", "far tension", false),
            ("tension_out_estimated", "far tension, estimated", "N", "far tension", false),
            ("tension_out_true", "far tension, true", "N", "far tension", true),
            ("winch_position", "winch position", "m", "winch", false),
            ("motor_temperature", "winding temperature", "degC", "temperature", true),
        ] {
            all.push(
                json!({"name": format!("{field}:{muscle}"), "label": label, "unit": unit, "group": group,
                "muscle": k, "joint": null, "field": field, "index": k, "simulated_truth": truth}),
            );
        }
    }
    for (k, joint) in joints.into_iter().enumerate() {
        let joint = &robot.parts().joints[joint];
        let unit = if joint.kind == JointKind::Slide { "m" } else { "rad" };
        for (field, label, truth) in [
            ("joint_reference", "reference", false),
            ("joint_estimated", "estimated", false),
            ("joint_true", "true", true),
        ] {
            all.push(json!({"name": format!("{field}:{}", joint.name), "label": label, "unit": unit, "group": "joint",
                "muscle": null, "joint": k, "field": field, "index": k, "simulated_truth": truth}));
        }
    }
    all.into()
}
