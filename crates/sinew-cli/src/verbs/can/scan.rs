//! `sinew can scan`.

use crate::answer::{Answer, Content, Outcome};
use crate::arguments::{CanScanArguments, General};
use crate::error::Error;
use crate::table::table;
use sinew_runtime::can::{CanError, FoundNode, MitFamily, connect, scan, scan_fd, scan_mit};

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
    let content = if general.json { Content::json(&json(&found))? } else { Content::Text(text(&found)) };
    Ok(Answer { outcome: Outcome::new(!found.is_empty()), content, written: Vec::new() })
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

fn text(found: &[FoundNode]) -> String {
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
    let rows: Vec<Vec<String>> = found.iter().map(row).collect();
    table(&["id", "protocol", "name", "vendor", "product", "profile"], &rows, 6)
}

/// The row of a node that says no more than its versions.
fn versioned(node: u8, protocol: &str, versions: String) -> Vec<String> {
    [node.to_string(), protocol.to_owned(), versions].into_iter().chain(vec![String::new(); 3]).collect()
}
