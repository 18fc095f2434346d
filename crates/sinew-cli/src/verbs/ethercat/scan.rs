//! `sinew ethercat scan`.

use crate::answer::{Answer, Content, Outcome};
use crate::arguments::{EthercatScanArguments, General};
use crate::error::Error;
use crate::table::table;
use crate::verbs::machine_source::load_machine;
use sinew_runtime::ethercat::{EthercatDevice, FoundDevice, FrameStorage, Master, RawSocketLink, compare};

pub(super) fn run(arguments: &EthercatScanArguments, general: &General) -> Result<Answer, Error> {
    let (_, devices) = load_machine(&arguments.machine, None, arguments.root.dir.as_deref())?;
    let expected = devices.of();
    let storage = FrameStorage::new();
    let mut master = Master::new(&storage, RawSocketLink::open(&arguments.interface)?)?;
    let found = master.scan()?;
    let fits = compare(expected, &found).is_empty();
    let content = if general.json {
        Content::json(&json(expected, &found, fits))?
    } else {
        Content::Text(text(expected, &found))
    };
    Ok(Answer { outcome: Outcome::new(fits), content, written: Vec::new() })
}

fn json(expected: &[EthercatDevice], found: &[FoundDevice], fits: bool) -> serde_json::Value {
    let found: Vec<_> = found
        .iter()
        .map(|device| {
            let [vendor, product, revision] = device.identity;
            serde_json::json!({
                "position": device.position, "name": device.name, "vendor": vendor, "product": product,
                "revision": revision, "serial": device.serial, "alias": device.alias,
            })
        })
        .collect();
    let expected: Vec<_> = expected
        .iter()
        .map(|device| {
            let identity = device.identity;
            serde_json::json!({
                "name": device.name(), "vendor": identity.vendor, "product": identity.product,
                "revision": identity.revision, "alias": device.alias,
            })
        })
        .collect();
    serde_json::json!({"found": found, "expected": expected, "matches": fits})
}

/// Both lists side by side in the order on the wire, differences marked.
fn text(expected: &[EthercatDevice], found: &[FoundDevice]) -> String {
    let mismatches = compare(expected, found);
    let rows: Vec<Vec<String>> = (0..expected.len().max(found.len()))
        .map(|k| {
            let on_wire = found.get(k).map_or([String::from("none"), String::new()], |device| {
                [device.name.clone(), identity(device.identity)]
            });
            let differs = mismatches.iter().any(|mismatch| mismatch.position == k);
            let desired = expected.get(k).map_or([String::from("none"), String::new()], |device| {
                let of = device.identity;
                [device.name().to_owned(), identity([of.vendor, of.product, of.revision])]
            });
            let mark = if differs { "differs" } else { "" };
            [k.to_string()].into_iter().chain(on_wire).chain(desired).chain([mark.to_owned()]).collect()
        })
        .collect();
    let header =
        ["position", "on the wire", "vendor:product:revision", "machine file", "vendor:product:revision", ""];
    let mut text = table(&header, &rows, 6);
    for mismatch in &mismatches {
        text += &format!("{mismatch}\n");
    }
    text
}

fn identity([vendor, product, revision]: [u32; 3]) -> String {
    format!("{vendor:#x}:{product:#x}:{revision:#x}")
}
