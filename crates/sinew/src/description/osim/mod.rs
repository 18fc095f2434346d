//! OpenSim's models (`.osim`, documents of version 4): bodies, joints with the functions of their
//! coordinates, paths of muscles.

mod function;
mod joints;
mod model;
mod paths;
mod wraps;

use super::Description;
use super::attributes::Attributes;
use super::error::DescriptionError;
use super::tree::Tree;
use alloc::format;
use alloc::string::ToString;
use model::{Model, child};

/// First version of a document that is read.
const VERSION: f64 = 40_000.0;

/// Reads a robot from a model of OpenSim 4: angles in rad, lengths in m, as in the file.
///
/// A coordinate is a hinge or a slide of its name; what follows a coordinate by a function is a joint with a
/// [`Coupling`](crate::body::Coupling). A muscle is a tendon whose largest tension is the largest
/// isometric force.
///
/// # Errors
///
/// The first error: file, line, element, its value and what was expected.
///
/// # Source
/// `delp2007`, and what version 4.6 of OpenSim is observed to do.
pub fn from_osim(file: &str, text: &str) -> Result<Description, DescriptionError> {
    let tree = Tree::parse(file, text, &mut |_| Err("OpenSim knows no include".to_string()))?;
    let document = Attributes::own(&tree, 0);
    if tree.elements[0].name != "OpenSimDocument" {
        return Err(document.error("", "is the root: expected <OpenSimDocument>"));
    }
    match document.number("Version")? {
        Some(version) if version >= VERSION => {}
        version => {
            let version = version.map_or_else(|| "missing".to_string(), |version| format!("{version}"));
            let problem = format!(
                "is {version}: expected {VERSION} or later; open the model in OpenSim 4 and save it, or in \
                    Python `opensim.Model(\"old.osim\").printToXML(\"new.osim\")`"
            );
            return Err(document.error("Version", problem));
        }
    }
    let at = child(&tree, 0, "Model").ok_or_else(|| document.error("", "has no <Model>"))?;
    let mut model = Model::new(&tree, at, file)?;
    joints::read(&mut model)?;
    joints::constraints(&mut model)?;
    let arounds = paths::read(&mut model)?;
    model.couple();
    wraps::place(&mut model, &arounds)?;
    model.finish();
    Ok(Description { parts: model.parts, warnings: model.warnings, origins: model.origins })
}
