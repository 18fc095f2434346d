//! Tendons: spatial, or fixed (weighted sums of joints).

use super::import_state::Import;
use super::ranges::{limits, linear};
use crate::body::{JointKind, PathElement, Tendon, TendonPath, Wrap};
use crate::description::attributes::Attributes;
use crate::description::error::DescriptionError;
use alloc::format;
use alloc::string::ToString;
use alloc::vec::Vec;

pub(super) fn read(import: &mut Import<'_>, element: usize) -> Result<(), DescriptionError> {
    let tree = import.tree;
    let at = import.attributes(element, None)?;
    let name = import.name_as("tendon", at, import.parts.tendons.len())?.unwrap_or_default();
    import.ignored(at, &["armature", "frictionloss", "springyield"]);
    let children = &tree.elements[element].children;
    let path = match tree.elements[element].name.as_str() {
        "spatial" => {
            let elements = children.iter().map(|&child| path_element(import, Attributes::own(tree, child)));
            TendonPath::Spatial(elements.collect::<Result<Vec<_>, _>>()?)
        }
        "fixed" => {
            let terms = children.iter().map(|&child| term(import, Attributes::own(tree, child)));
            TendonPath::Fixed(terms.collect::<Result<Vec<_>, _>>()?)
        }
        _ => return Err(at.error("", "is no tendon: expected <spatial> or <fixed>")),
    };
    if children.is_empty() {
        return Err(at.error("", "is empty: expected what it goes through"));
    }
    // MuJoCo's sign for the length where the joints' springs are at rest.
    let unset = |x: f64| x + 1.0 == 0.0;
    let spring = match at.list("springlength", 1, 2)?.as_deref() {
        Some([one]) if !unset(*one) => Some([*one; 2]),
        Some([low, high]) if low <= high && !(unset(*low) && unset(*high)) => Some([*low, *high]),
        Some([low, high]) if low > high => {
            return Err(at.error(
                "springlength",
                format!("is `{low} {high}`: expected a low end not above the high end"),
            ));
        }
        _ => None,
    };
    let (damping, stiffness) = (linear(import, at, "damping")?, linear(import, at, "stiffness")?);
    let tendon = Tendon {
        name,
        path,
        sheath: None,
        range: limits(at, import.compiler.auto_limits, "limited", "range")?,
        damping,
        stiffness,
        spring_length: spring,
    };
    import.parts.tendons.push(tendon);
    Ok(())
}

fn path_element(import: &mut Import<'_>, at: Attributes<'_>) -> Result<PathElement, DescriptionError> {
    match at.tree.elements[at.element].name.as_str() {
        "site" => Ok(PathElement::Site(import.find("site", at, "site")?)),
        "pulley" => {
            at.required("divisor")?;
            match at.number_or("divisor", 0.0)? {
                divisor if divisor > 0.0 => Ok(PathElement::Pulley(divisor)),
                divisor => Err(at.error("divisor", format!("is {divisor}: expected a number > 0"))),
            }
        }
        "geom" => {
            let wrap = surface(import, at)?;
            let side = at.text("sidesite").map(|_| import.find("site", at, "sidesite")).transpose()?;
            Ok(PathElement::Wrap { wrap, side })
        }
        _ => Err(at.error("", "is no element of a path: expected <site>, <geom> or <pulley>")),
    }
}

/// Index among the wraps of the geom that a tendon names.
fn surface(import: &mut Import<'_>, at: Attributes<'_>) -> Result<usize, DescriptionError> {
    let name = at.required("geom")?;
    let count = import.parts.wraps.len();
    let Some(surface) = import.surfaces.get_mut(name) else {
        return Err(
            at.error("geom", format!("is `{name}`, but there is no geom of that name, or it is a mesh"))
        );
    };
    if let Some(wrap) = surface.wrap {
        return Ok(wrap);
    }
    let Some(kind) = surface.kind else {
        return Err(at.error(
            "geom",
            format!("is `{name}`, which is neither a sphere nor a cylinder: cables wrap around these"),
        ));
    };
    surface.wrap = Some(count);
    import.origins.set("wrap", count, &surface.at.0, surface.at.1);
    import.parts.wraps.push(Wrap {
        name: name.to_string(),
        body: surface.body,
        kind,
        radius: surface.radius,
        position: surface.place.position,
        orientation: surface.place.orientation,
    });
    Ok(count)
}

fn term(import: &Import<'_>, at: Attributes<'_>) -> Result<(usize, f64), DescriptionError> {
    if at.tree.elements[at.element].name != "joint" {
        return Err(at.error("", "is no part of a fixed tendon: expected <joint>"));
    }
    let joint = import.find("joint", at, "joint")?;
    if matches!(import.parts.joints[joint].kind, JointKind::Ball | JointKind::Free) {
        return Err(at.error("joint", "has more than one coordinate: expected a hinge or a slide"));
    }
    at.required("coef")?;
    Ok((joint, at.number_or("coef", 0.0)?))
}
