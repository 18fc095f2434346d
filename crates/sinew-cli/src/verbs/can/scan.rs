//! `sinew can scan`.

use crate::answer::Answer;
use crate::arguments::{CanScanArguments, General};
use crate::error::Error;
use crate::table::table;
use crate::verbs::beside_file::{Beside, Expected, answer};
use crate::verbs::machine_source::load_machine;
use sinew_runtime::can::{
    CanDevice, CanError, FoundNode, MitFamily, Protocol, connect, scan, scan_fd, scan_mit,
};

pub(super) fn run(arguments: &CanScanArguments, general: &General) -> Result<Answer, Error> {
    let port = arguments.port.display().to_string();
    let refused = |source| CanError::Port { port: port.clone(), source };
    let mut link = connect(&port, arguments.bitrate, arguments.fd).map_err(refused)?;
    let found = match (arguments.fd, arguments.mit) {
        (true, _) => scan_fd(&mut link),
        (_, true) => scan_mit(&mut link),
        _ => scan(&mut link),
    }
    .map_err(refused)?;
    let beside = arguments.machine.as_deref().map(|file| {
        let (_, devices) = load_machine(file, None, arguments.root.dir.as_deref())?;
        let expected: Vec<Expected> =
            devices.of::<CanDevice>().iter().map(|device| expected(device, &found)).collect();
        let nodes: Vec<u8> = found.iter().map(|node| identified(node).0).collect();
        Ok::<_, Error>(Beside::new(&expected, &nodes))
    });
    let beside = beside.transpose()?;
    answer(!found.is_empty(), json(&found), |beside| text(&found, beside), beside.as_ref(), general)
}

/// The identifier of a node, and what it speaks.
fn identified(node: &FoundNode) -> (u8, Protocol) {
    match node {
        FoundNode::Canopen { node, .. } => (*node, Protocol::Canopen),
        FoundNode::Cansimple { node, .. } => (*node, Protocol::Cansimple),
        FoundNode::Moteus { node, .. } => (*node, Protocol::Moteus),
        FoundNode::Mit { node, .. } => (*node, Protocol::Mit),
    }
}

/// As in the machine file.
fn word(protocol: Protocol) -> &'static str {
    match protocol {
        Protocol::Canopen => "canopen",
        Protocol::Cansimple => "cansimple",
        Protocol::Moteus => "moteus",
        Protocol::Mit => "mit",
    }
}

/// A node of the machine file, whose protocol, vendor and product are compared with what has answered.
fn expected(device: &CanDevice, found: &[FoundNode]) -> Expected {
    let of_other = |identity: &[u32; 2]| {
        device.identity.iter().zip(identity).any(|(own, found)| own.is_some_and(|own| own != *found))
    };
    let differs = found.iter().find(|node| identified(node).0 == device.node).and_then(|node| match node {
        _ if identified(node).1 != device.protocol => Some(format!("there on {}", word(device.protocol))),
        FoundNode::Canopen { identity, .. } if of_other(identity) => {
            Some("there of another vendor or product".to_owned())
        }
        _ => None,
    });
    Expected { id: device.node, name: device.name.clone(), differs }
}

fn json(found: &[FoundNode]) -> serde_json::Value {
    let nodes: Vec<_> = found
        .iter()
        .map(|node| match node {
            FoundNode::Canopen { node, profile, identity: [vendor, product], name } => serde_json::json!({
                "node": node, "protocol": "canopen", "name": name, "vendor": vendor, "product": product,
                "profile": profile,
            }),
            FoundNode::Cansimple { node, hardware, firmware } => serde_json::json!({
                "node": node, "protocol": "cansimple", "hardware": version(hardware),
                "firmware": version(firmware),
            }),
            FoundNode::Moteus { node, model, firmware } => serde_json::json!({
                "node": node, "protocol": "moteus", "model": model, "firmware": firmware,
            }),
            FoundNode::Mit { node, family, answers_as } => serde_json::json!({
                "node": node, "protocol": "mit", "family": name(*family), "answers_as": answers_as,
            }),
        })
        .collect();
    serde_json::json!({ "found": nodes })
}

/// As in the machine file.
fn name(family: MitFamily) -> &'static str {
    match family {
        MitFamily::MiniCheetah => "mini-cheetah",
        MitFamily::Cubemars => "cubemars",
        MitFamily::Damiao => "damiao",
    }
}

fn version([major, minor, revision]: &[u8; 3]) -> String {
    format!("{major}.{minor}.{revision}")
}

fn text(found: &[FoundNode], beside: Option<&Beside>) -> String {
    if found.is_empty() {
        return "no node answers; check power, wiring, termination and --bitrate\n".to_owned();
    }
    let row = |node: &FoundNode| match node {
        FoundNode::Canopen { node, profile, identity: [vendor, product], name } => vec![
            node.to_string(),
            "canopen".to_owned(),
            name.clone().unwrap_or_default(),
            format!("{vendor:#x}"),
            format!("{product:#x}"),
            profile.to_string(),
        ],
        FoundNode::Cansimple { node, hardware, firmware } => {
            let versions = format!("hardware {}, firmware {}", version(hardware), version(firmware));
            versioned(*node, "cansimple", versions)
        }
        FoundNode::Moteus { node, model, firmware } => {
            versioned(*node, "moteus", format!("model {model:#06x}, firmware {firmware:#06x}"))
        }
        FoundNode::Mit { node, family, answers_as } => {
            versioned(*node, "mit", format!("{}, answers as {answers_as:#05x}", name(*family)))
        }
    };
    let mut rows: Vec<Vec<String>> = found.iter().map(row).collect();
    let columns = ["id", "protocol", "name", "vendor", "product", "profile", "machine file"];
    let Some(beside) = beside else { return table(&columns[..6], &rows, 6) };
    rows.iter_mut().zip(&beside.names).for_each(|(row, name)| row.push(name.clone()));
    table(&columns, &rows, 7) + &beside.text()
}

/// The row of a node that says no more than its versions.
fn versioned(node: u8, protocol: &str, versions: String) -> Vec<String> {
    [node.to_string(), protocol.to_owned(), versions].into_iter().chain(vec![String::new(); 3]).collect()
}
