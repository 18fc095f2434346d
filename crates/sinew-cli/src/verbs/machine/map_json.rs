//! A map as JSON.

use serde_json::{Value, json};
use sinew::control::capability::{EndPointCapability, Extreme, JointCapability};
use sinew_report::capability::{MapView, quantities};

/// The summary, and every pose.
pub(super) fn json(view: &MapView<'_>) -> Value {
    let summary: Vec<Value> = quantities(view)
        .iter()
        .map(|quantity| {
            let [least, median, most] = quantity.spread;
            let limited_by =
                quantity.limited_by.as_ref().map(|(muscle, count)| json!({"muscle": muscle, "poses": count}));
            json!({"quantity": quantity.name, "unit": quantity.unit, "poses": quantity.count,
                "min": least, "median": median, "max": most, "limited_by": limited_by})
        })
        .collect();
    let names: Vec<&String> = view.joints.iter().map(|(name, _)| name).collect();
    let poses: Vec<Value> = view
        .poses
        .iter()
        .map(|pose| {
            let joints: Vec<Value> = pose.joints.iter().map(|joint| of_joint(view, joint)).collect();
            let end_point = pose.end_point.as_ref().map(|end_point| of_end_point(view, end_point));
            json!({"q": pose.pose, "joints": joints, "end_point": end_point})
        })
        .collect();
    json!({"name": view.name, "joints": names, "muscles": view.muscles, "summary": summary, "poses": poses,
        "payload": view.payload})
}

fn extreme(view: &MapView<'_>, extreme: &Extreme) -> Value {
    let limit = if extreme.largest { "largest" } else { "least" };
    let muscle = extreme.muscle.map(|muscle| &view.muscles[muscle]);
    json!({"value": extreme.value, "limited_by": muscle, "limit": muscle.map(|_| limit)})
}

fn of_joint(view: &MapView<'_>, joint: &JointCapability) -> Value {
    let torque = joint.torque.as_ref().map(|torque| torque.each_ref().map(|one| extreme(view, one)));
    json!({"needed_torque": joint.needed, "additional_torque": torque, "speed": extreme(view, &joint.speed),
        "stiffness": joint.stiffness})
}

fn of_end_point(view: &MapView<'_>, end_point: &EndPointCapability) -> Value {
    let [lifted, held, lowered] =
        end_point.payload.each_ref().map(|one| one.as_ref().map(|one| extreme(view, one)));
    let directed = |one: &Option<(Extreme, [f64; 3])>| {
        one.as_ref().map(|(one, direction)| {
            let mut value = extreme(view, one);
            value["direction"] = json!(direction);
            value
        })
    };
    json!({"position_m": end_point.position, "payload_kg": {"lifted": lifted, "held": held, "lowered": lowered},
        "force_n": directed(&end_point.force), "speed_m_per_s": directed(&end_point.speed),
        "stiffness_n_per_m": end_point.stiffness})
}
