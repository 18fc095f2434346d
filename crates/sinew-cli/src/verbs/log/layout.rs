//! `sinew log layout`.

use crate::answer::{Answer, Content};
use crate::arguments::{General, LogLayoutArguments};
use crate::error::Error;
use crate::output::{refuse_overwrite, write_all};
use crate::verbs::recording::{read_bytes, recording};
use serde_json::{Value, json};
use sinew_record::{Head, Signal};

pub(super) fn run(arguments: &LogLayoutArguments, general: &General) -> Result<Answer, Error> {
    let LogLayoutArguments { file, out } = arguments;
    refuse_overwrite([file], std::slice::from_ref(out), general.no_clobber)?;
    let bytes = read_bytes(file)?;
    let recording = recording(file, &bytes)?;
    let text = serde_json::to_string_pretty(&layout(&recording.head))?;
    let written = write_all(&[(out.clone(), text.as_bytes())])?;
    let content = if general.json {
        Content::json(&json!({"machine": recording.head.machine}))?
    } else {
        Content::Text("Open it in Foxglove: layouts, import from file\n".to_owned())
    };
    Ok(Answer::done(content, written))
}

/// Machine on the left; joints, tensions and commands above each other in the middle; states and times on the
/// right.
fn layout(head: &Head) -> Value {
    let found = if head.simulated { Signal::TensionOut } else { Signal::TensionOutEstimated };
    let plot = |title: &str, signals: &[(&str, Signal)]| plot(head, title, signals);
    json!({
        "configById": {
            "3D!machine": {
                "followTf": "world", "followMode": "follow-none", "layers": {},
                "scene": {"transforms": {"showLabel": false, "axisScale": 0.1}},
                "topics": {"/sinew/scene": {"visible": true}},
                "cameraState": {"perspective": true, "distance": 2.0, "phi": 60, "thetaOffset": 45},
            },
            "Plot!joints": plot("Joints, rad or m", &[
                ("reference", Signal::JointReference), ("measured", Signal::Joint),
            ]),
            "Plot!tensions": plot("Tensions at the anchors, N", &[
                ("desired", Signal::TensionOutDesired), ("found", found),
            ]),
            "Plot!commands": plot("Commands of the drives, m/s or N", &[("", Signal::Command)]),
            "Plot!times": plot("Cycle, us", &[("wake-up", Signal::WakeUp), ("control", Signal::Control)]),
            "StateTransitions!status": {
                "isSynced": true,
                "paths": [{"value": "/sinew/cycle.status", "label": "status", "timestampMethod": "receiveTime"}],
            },
            "RosOut!log": {"topicToRender": "/sinew/log", "searchTerms": [], "minLogLevel": 1},
        },
        "globalVariables": {}, "userNodes": {}, "playbackConfig": {"speed": 1},
        "layout": {
            "direction": "row", "splitPercentage": 35, "first": "3D!machine",
            "second": {
                "direction": "row", "splitPercentage": 65,
                "first": {
                    "direction": "column", "splitPercentage": 34, "first": "Plot!joints",
                    "second": {"direction": "column", "first": "Plot!tensions", "second": "Plot!commands"},
                },
                "second": {
                    "direction": "column", "splitPercentage": 34, "first": "StateTransitions!status",
                    "second": {"direction": "column", "first": "RosOut!log", "second": "Plot!times"},
                },
            },
        },
    })
}

/// A plot of the columns of signals, by the fields that they are in the messages.
fn plot(head: &Head, title: &str, signals: &[(&str, Signal)]) -> Value {
    let paths = signals.iter().flat_map(|(what, signal)| {
        head.paths(*signal).into_iter().map(move |(part, path)| {
            json!({
                "value": path, "label": format!("{part} {what}").trim(), "enabled": true,
                "timestampMethod": "receiveTime",
            })
        })
    });
    json!({
        "title": title, "showLegend": true, "isSynced": true, "xAxisVal": "timestamp",
        "paths": paths.collect::<Value>(),
    })
}
