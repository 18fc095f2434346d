//! From MJCF text to parts: settings and classes first, then bodies, then what refers to them.

use super::compiler::Compiler;
use super::defaults::Defaults;
use super::import_state::Import;
use super::{body, lists, mesh, replicate, schema, sheath, spring_damper, tendon};
use crate::description::attributes::Attributes;
use crate::description::error::DescriptionError;
use crate::description::tree::Tree;
use crate::description::{Description, attributes};
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;

/// Reads a robot from MJCF with the semantics of MuJoCo 4.
///
/// `file` names the text in errors; `resolve` returns the text of an included file, or the reason why there
/// is none; of a mesh that has mass the triangles as lines `v x y z` and `f i j k`, as in OBJ. Masses,
/// lengths and angles come out in kg, m and rad.
///
/// # Errors
///
/// The first error: file, line, element, attribute, its value and what was expected.
pub fn from_mjcf(
    file: &str,
    text: &str,
    resolve: &mut dyn FnMut(&str) -> Result<String, String>,
) -> Result<Description, DescriptionError> {
    read(file, text, resolve, 0)
}

/// The same for a model that others attach: `depth` of them.
pub(super) fn read(
    file: &str,
    text: &str,
    resolve: &mut dyn FnMut(&str) -> Result<String, String>,
    depth: usize,
) -> Result<Description, DescriptionError> {
    let mut tree = Tree::parse(file, text, &mut *resolve)?;
    if tree.elements[0].name != "mujoco" {
        return Err(tree.error(0, "", "is the root: expected <mujoco>"));
    }
    schema::check(&tree)?;
    let compiler = Compiler::read(&tree)?;
    replicate::expand(&mut tree, &compiler)?;
    let defaults = Defaults::read(&tree)?;
    let mut import = Import::new(&tree, compiler, &defaults, file, resolve, (read, depth));
    read_settings(&mut import)?;
    for asset in top_elements(&tree, "asset") {
        let meshes = tree.elements[asset].children.iter().filter(|&&e| tree.elements[e].name == "mesh");
        meshes.copied().try_for_each(|element| mesh::read(&mut import, element))?;
    }
    body::world(&mut import)?;
    spring_damper::apply(&mut import);
    read_references(&mut import)?;
    // A surface that a cable wraps around is drawn as one.
    let wrapped: Vec<usize> =
        import.surfaces.values().filter(|surface| surface.wrap.is_some()).filter_map(|s| s.geom).collect();
    let mut index = 0..;
    import.parts.geoms.retain(|_| index.next().is_none_or(|k| !wrapped.contains(&k)));
    let mut index = 0..;
    import.geom_groups.retain(|_| index.next().is_none_or(|k| !wrapped.contains(&k)));
    keep_shown(&mut import);
    Ok(Description { parts: import.parts, warnings: import.warnings, origins: import.origins })
}

/// First of the groups that MuJoCo's viewer hides: shapes for collisions, mostly.
const HIDDEN_GROUP: f64 = 3.0;

/// Leaves out shapes in hidden groups, of a robot that has others.
fn keep_shown(import: &mut Import<'_>) {
    let Import { parts, geom_groups, mesh_groups, .. } = import;
    if geom_groups.iter().chain(&*mesh_groups).all(|group| *group >= HIDDEN_GROUP) {
        return;
    }
    let mut shown = geom_groups.iter().map(|group| *group < HIDDEN_GROUP);
    parts.geoms.retain(|_| shown.next() == Some(true));
    let mut shown = mesh_groups.iter().map(|group| *group < HIDDEN_GROUP);
    parts.meshes.retain(|_| shown.next() == Some(true));
}

/// Children of the root of one name.
fn top_elements(tree: &Tree, name: &str) -> Vec<usize> {
    tree.elements[0].children.iter().copied().filter(|&e| tree.elements[e].name == name).collect()
}

/// Outermost elements that refer to bodies and joints; tendons before actuators.
fn read_references(import: &mut Import<'_>) -> Result<(), DescriptionError> {
    let tree = import.tree;
    let children = |name: &str| -> Vec<usize> {
        top_elements(tree, name).into_iter().flat_map(|e| tree.elements[e].children.iter().copied()).collect()
    };
    children("tendon").into_iter().try_for_each(|e| tendon::read(import, e))?;
    children("custom").into_iter().try_for_each(|e| sheath::read(import, e))?;
    children("equality").into_iter().try_for_each(|e| lists::equality(import, e))?;
    children("actuator").into_iter().try_for_each(|e| lists::actuator(import, e))?;
    children("keyframe").into_iter().try_for_each(|e| lists::key(import, e))
}

/// Outermost elements that refer to nothing; warns of what is not read.
fn read_settings(import: &mut Import<'_>) -> Result<(), DescriptionError> {
    let tree = import.tree;
    for option in top_elements(tree, "option") {
        let at = Attributes::own(tree, option);
        import.parts.gravity = at.array_or("gravity", import.parts.gravity)?;
        import.ignored(at, &["density", "viscosity", "wind"]);
        for &flag in tree.elements[option].children.iter().filter(|&&e| tree.elements[e].name == "flag") {
            read_flags(import, Attributes::own(tree, flag))?;
        }
    }
    for &element in &tree.elements[0].children {
        match tree.elements[element].name.as_str() {
            "compiler" | "option" | "default" | "worldbody" | "tendon" | "equality" | "actuator"
            | "keyframe" | "size" | "statistic" | "visual" | "asset" | "sensor" | "custom" => {}
            "contact" => import.pass_over(element, "contact", "<contact> is not read: nothing touches here"),
            "extension" => {
                import.pass_over(element, "extension", "<extension> is not read: no plugin acts here");
            }
            "deformable" => {
                let what = "<deformable> is not read, what it says is left out";
                import.without(element, "deformable", what);
            }
            name => {
                let name = attributes::shortened(name);
                let problem = format!("<{name}> is no element of MJCF's outermost level");
                return Err(tree.error(element, "", problem));
            }
        }
    }
    Ok(())
}

/// Features that MuJoCo is to leave out.
fn read_flags(import: &mut Import<'_>, at: Attributes<'_>) -> Result<(), DescriptionError> {
    let off = |name: &str| Ok::<_, DescriptionError>(at.word(name, &["disable", "enable"])? == Some(0));
    if off("gravity")? {
        import.parts.gravity = [0.0; 3];
    }
    for name in ["spring", "damper", "frictionloss", "limit", "equality", "constraint", "actuation"] {
        if off(name)? {
            let what = format!("`{name}` of <flag> is not read, what it turns off stays on");
            import.without(at.element, &format!("flag {name}"), &what);
        }
    }
    Ok(())
}
