//! Sheaths of tendons, which MJCF lacks, as custom data:
//! `<numeric name="sheath:TENDON" data="length bend x y z"/>`.
//!
//! | entry   | unit | domain | meaning                                                                     |
//! |---------|------|--------|-----------------------------------------------------------------------------|
//! | length  | m    | > 0    | length of the sheath                                                        |
//! | bend    | rad  | >= 0   | sum of the magnitudes of its bends                                          |
//! | x, y, z | 1    |        | direction in which the cable leaves it, in the first site's frame; optional |

use super::import_state::Import;
use super::text::{escape, numbers};
use crate::body::{Parts, SheathGeometry};
use crate::description::attributes::Attributes;
use crate::description::error::DescriptionError;
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use core::fmt::Write as _;

const PREFIX: &str = "sheath:";

/// Writes the sheaths of all tendons that have one.
pub(super) fn write(out: &mut String, parts: &Parts) {
    let sheaths = || parts.tendons.iter().filter_map(|tendon| Some((tendon, tendon.sheath.as_ref()?)));
    if sheaths().next().is_none() {
        return;
    }
    out.push_str("  <custom>\n");
    for (tendon, sheath) in sheaths() {
        let mut data = Vec::from([sheath.length, sheath.bend]);
        data.extend(sheath.end_axis.iter().flatten());
        let name = escape(&tendon.name);
        let _ = writeln!(out, "    <numeric name=\"{PREFIX}{name}\" data=\"{}\"/>", numbers(&data));
    }
    out.push_str("  </custom>\n");
}

/// Reads one entry of the custom data; one of another name is another program's.
pub(super) fn read(import: &mut Import<'_>, element: usize) -> Result<(), DescriptionError> {
    let at = Attributes::own(import.tree, element);
    if at.tree.elements[element].name != "numeric" {
        return Ok(());
    }
    let Some(tendon) = at.text("name").and_then(|name| name.strip_prefix(PREFIX)) else { return Ok(()) };
    let Some(index) = import.parts.tendons.iter().position(|known| known.name == tendon) else {
        return Err(at.error("name", format!("is the sheath of `{tendon}`: expected the name of a tendon")));
    };
    let data = at.list("data", 2, 5)?.unwrap_or_default();
    let (length, bend, end_axis) = match data[..] {
        [length, bend] => (length, bend, None),
        [length, bend, x, y, z] => (length, bend, Some([x, y, z])),
        _ => {
            return Err(
                at.error("data", "is no sheath: expected length, bend and perhaps three of its end axis")
            );
        }
    };
    import.parts.tendons[index].sheath = Some(SheathGeometry { length, bend, end_axis });
    Ok(())
}
