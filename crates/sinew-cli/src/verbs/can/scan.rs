//! `sinew can scan`.

use crate::answer::{Answer, Content, Outcome};
use crate::arguments::{CanScanArguments, General};
use crate::error::Error;
use crate::table::table;
use sinew_runtime::can::{CanError, FoundNode, Slcan, scan};

pub(super) fn run(arguments: &CanScanArguments, general: &General) -> Result<Answer, Error> {
    let port = arguments.port.display().to_string();
    let refused = |source| CanError::Port { port: port.clone(), source };
    let mut link = Slcan::open(&port, arguments.bitrate).map_err(refused)?;
    let found = scan(&mut link).map_err(refused)?;
    let content = if general.json { Content::json(&json(&found))? } else { Content::Text(text(&found)) };
    Ok(Answer { outcome: Outcome::new(!found.is_empty()), content, written: Vec::new() })
}

fn json(found: &[FoundNode]) -> serde_json::Value {
    let nodes: Vec<_> = found
        .iter()
        .map(|node| {
            serde_json::json!({
                "node": node.node, "name": node.name, "vendor": node.identity[0], "product": node.identity[1],
                "profile": node.profile,
            })
        })
        .collect();
    serde_json::json!({ "found": nodes })
}

fn text(found: &[FoundNode]) -> String {
    if found.is_empty() {
        return "no node answers; check power, wiring, termination and --bitrate\n".to_owned();
    }
    let row = |node: &FoundNode| {
        let [vendor, product] = node.identity.map(|number| format!("{number:#x}"));
        vec![
            node.node.to_string(),
            node.name.clone().unwrap_or_default(),
            vendor,
            product,
            node.profile.to_string(),
        ]
    };
    let rows: Vec<Vec<String>> = found.iter().map(row).collect();
    table(&["id", "name", "vendor", "product", "profile"], &rows, 5)
}
