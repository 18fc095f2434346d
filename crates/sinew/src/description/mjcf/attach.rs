//! `attach`: a body of another model and all below it, or all of that model, with the tendons, couplings and
//! actuators that refer to nothing else.

use super::import_state::Import;
use super::place::Place;
use crate::body::{Actuator, Body, Coupling, Geom, Joint, MeshGeom, Parts, PathElement, Site};
use crate::body::{Tendon, TendonPath, Wrap};
use crate::description::attributes::Attributes;
use crate::description::error::DescriptionError;
use crate::description::mesh_file::joined;
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec;
use alloc::vec::Vec;

/// Models that attach each other.
const DEEPEST: usize = 8;

/// Adds what an element attaches to a body, in a frame of it. Options and keyframes stay behind.
pub(super) fn attach(
    import: &mut Import<'_>,
    element: usize,
    frame: Place,
    body: usize,
) -> Result<(), DescriptionError> {
    let at = Attributes::own(import.tree, element);
    if at.text("frame").is_some() {
        return Err(at.error("frame", "is not read: expected the name of a body of the model"));
    }
    let parts = model(import, at)?;
    let root = match at.text("body") {
        Some(name) => parts.bodies.iter().position(|body| body.name == name).ok_or_else(|| {
            at.error("body", format!("is `{name}`, but the model has no body of that name"))
        })?,
        None => 0,
    };
    if root == 0 && body != 0 {
        return Err(at.error("body", "is missing: all of a model is attached to the world alone"));
    }
    let affixes = [at.text("prefix"), at.text("suffix")].map(Option::unwrap_or_default);
    Graft { at, affixes, frame, root, body }.add(import, &parts)
}

/// The parts of the model that an element names.
fn model(import: &mut Import<'_>, at: Attributes<'_>) -> Result<Parts, DescriptionError> {
    let (tree, name) = (import.tree, at.required("model")?);
    if let Some(parts) = import.models.get(name) {
        return Ok(parts.clone());
    }
    if import.depth >= DEEPEST {
        return Err(at.error("model", format!("is one of models that attach each other {DEEPEST} deep")));
    }
    let assets = tree.elements[0].children.iter().filter(|&&e| tree.elements[e].name == "asset");
    let models = assets.flat_map(|&e| &tree.elements[e].children).copied();
    let models: Vec<usize> = models.filter(|&e| tree.elements[e].name == "model").collect();
    let named = |e: usize| Attributes::own(tree, e).text("name");
    if let Some(&asset) = models.iter().find(|&&e| named(e) == Some(name)) {
        return Ok(read(import, Attributes::own(tree, asset))?.clone());
    }
    // An asset without a name has that of its file's root.
    for &asset in models.iter().filter(|&&e| named(e).is_none()) {
        let parts = read(import, Attributes::own(tree, asset))?;
        if parts.name == name {
            return Ok(parts.clone());
        }
    }
    Err(at.error("model", format!("is `{name}`, but <asset> has no <model> of that name")))
}

/// Reads the model of an asset, and keeps it under its name.
fn read<'a>(import: &'a mut Import<'_>, asset: Attributes<'_>) -> Result<&'a Parts, DescriptionError> {
    let file = asset.required("file")?;
    let refused = |problem: String| asset.error("file", format!("`{file}`: {problem}"));
    let text = (import.files)(file).map_err(refused)?;
    let folder = file.rsplit_once('/').map_or("", |(folder, _)| folder);
    let files = &mut *import.files;
    let read = import.read;
    let description = read(file, &text, &mut |inner| files(&joined(folder, inner)), import.depth + 1)?;
    import.warnings.extend(description.warnings);
    let name = asset.text("name").unwrap_or(&description.parts.name).to_string();
    Ok(import.models.entry(name).or_insert(description.parts))
}

/// Where the parts of a model go.
struct Graft<'a> {
    at: Attributes<'a>,
    /// Before and after the names; the second is that of a copy by `replicate`.
    affixes: [&'a str; 2],
    frame: Place,
    /// Body of the model that is attached, and the body that it is attached to.
    root: usize,
    body: usize,
}

impl Graft<'_> {
    fn add(&self, import: &mut Import<'_>, parts: &Parts) -> Result<(), DescriptionError> {
        let bodies = self.bodies(import, parts)?;
        let mut joints = vec![None; parts.joints.len()];
        for (joint, new) in parts.joints.iter().zip(&mut joints) {
            let Some(body) = bodies[joint.body] else { continue };
            let name = self.name(import, "joint", &joint.name, import.parts.joints.len())?;
            *new = Some(import.parts.joints.len());
            import.parts.joints.push(Joint { name, body, ..joint.clone() });
        }
        let mut sites = vec![None; parts.sites.len()];
        for (site, new) in parts.sites.iter().zip(&mut sites) {
            let Some((body, place)) = self.place(&bodies, site.body, site.position, site.orientation) else {
                continue;
            };
            let name = self.name(import, "site", &site.name, import.parts.sites.len())?;
            *new = Some(import.parts.sites.len());
            let Place { position, orientation } = place;
            import.parts.sites.push(Site { name, body, position, orientation, active: None });
        }
        let mut wraps = vec![None; parts.wraps.len()];
        for (wrap, new) in parts.wraps.iter().zip(&mut wraps) {
            let Some((body, place)) = self.place(&bodies, wrap.body, wrap.position, wrap.orientation) else {
                continue;
            };
            *new = Some(import.parts.wraps.len());
            let (name, Place { position, orientation }) = (self.affixed(&wrap.name), place);
            import.parts.wraps.push(Wrap { name, body, position, orientation, ..wrap.clone() });
        }
        for geom in &parts.geoms {
            if let Some((body, Place { position, orientation })) =
                self.place(&bodies, geom.body, geom.position, geom.orientation)
            {
                import.parts.geoms.push(Geom { body, position, orientation, ..geom.clone() });
                import.geom_groups.push(0.0);
            }
        }
        for mesh in &parts.meshes {
            if let Some((body, Place { position, orientation })) =
                self.place(&bodies, mesh.body, mesh.position, mesh.orientation)
            {
                import.parts.meshes.push(MeshGeom { body, position, orientation, ..mesh.clone() });
                import.mesh_groups.push(0.0);
            }
        }
        self.references(import, parts, &joints, &sites, &wraps)
    }

    /// Adds the bodies; the new index of each.
    fn bodies(&self, import: &mut Import<'_>, parts: &Parts) -> Result<Vec<Option<usize>>, DescriptionError> {
        let mut new = vec![None; parts.bodies.len()];
        for (k, body) in parts.bodies.iter().enumerate() {
            if k == 0 {
                new[0] = (self.root == 0).then_some(self.body);
                continue;
            }
            let place = Place { position: body.position, orientation: body.orientation };
            let (parent, place) = match new[body.parent] {
                _ if k == self.root => (self.body, self.frame.of(place)),
                Some(parent) if body.parent == 0 => (parent, self.frame.of(place)),
                Some(parent) => (parent, place),
                None => continue,
            };
            let name = self.name(import, "body", &body.name, import.parts.bodies.len())?;
            new[k] = Some(import.parts.bodies.len());
            let Place { position, orientation } = place;
            import.parts.bodies.push(Body { name, parent, position, orientation, ..body.clone() });
        }
        Ok(new)
    }

    /// Body and place of what is fixed to a body of the model.
    fn place(
        &self,
        bodies: &[Option<usize>],
        body: usize,
        position: [f64; 3],
        orientation: [f64; 4],
    ) -> Option<(usize, Place)> {
        let place = Place { position, orientation };
        Some((bodies[body]?, if body == 0 { self.frame.of(place) } else { place }))
    }

    fn references(
        &self,
        import: &mut Import<'_>,
        parts: &Parts,
        joints: &[Option<usize>],
        sites: &[Option<usize>],
        wraps: &[Option<usize>],
    ) -> Result<(), DescriptionError> {
        let element = |element: &PathElement| match *element {
            PathElement::Site(site) => Some(PathElement::Site(sites[site]?)),
            PathElement::Wrap { wrap, side: None } => {
                Some(PathElement::Wrap { wrap: wraps[wrap]?, side: None })
            }
            PathElement::Wrap { wrap, side: Some(side) } => {
                Some(PathElement::Wrap { wrap: wraps[wrap]?, side: Some(sites[side]?) })
            }
            PathElement::Pulley(divisor) => Some(PathElement::Pulley(divisor)),
        };
        let mut tendons = vec![None; parts.tendons.len()];
        for (tendon, new) in parts.tendons.iter().zip(&mut tendons) {
            let path = match &tendon.path {
                TendonPath::Spatial(path) => {
                    path.iter().map(element).collect::<Option<_>>().map(TendonPath::Spatial)
                }
                TendonPath::Fixed(terms) => {
                    let terms = terms.iter().map(|&(joint, factor)| Some((joints[joint]?, factor)));
                    terms.collect::<Option<_>>().map(TendonPath::Fixed)
                }
            };
            let Some(path) = path else { continue };
            let name = self.name(import, "tendon", &tendon.name, import.parts.tendons.len())?;
            *new = Some(import.parts.tendons.len());
            import.parts.tendons.push(Tendon { name, path, ..tendon.clone() });
        }
        for coupling in &parts.couplings {
            let leader = coupling.leader.map_or(Some(None), |leader| joints[leader].map(Some));
            if let (Some(follower), Some(leader)) = (joints[coupling.follower], leader) {
                import.parts.couplings.push(Coupling { follower, leader, ..coupling.clone() });
            }
        }
        for actuator in &parts.actuators {
            let Some(tendon) = tendons[actuator.tendon] else { continue };
            let name = self.name(import, "actuator", &actuator.name, import.parts.actuators.len())?;
            import.parts.actuators.push(Actuator { name, tendon, ..actuator.clone() });
        }
        Ok(())
    }

    /// The name of a part of the model, recorded with its new index.
    fn name(
        &self,
        import: &mut Import<'_>,
        kind: &'static str,
        name: &str,
        index: usize,
    ) -> Result<String, DescriptionError> {
        import.describe(kind, index, self.at);
        let name = if name.is_empty() { String::new() } else { self.affixed(name) };
        if !import.take(kind, &name, index) {
            let problem = format!("makes the {kind} `{name}`, but there is one of that name already");
            return Err(self.at.error("prefix", problem));
        }
        Ok(name)
    }

    fn affixed(&self, name: &str) -> String {
        let [prefix, suffix] = self.affixes;
        format!("{prefix}{name}{suffix}")
    }
}
