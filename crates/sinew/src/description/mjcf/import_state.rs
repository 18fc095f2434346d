//! State of an import: settings, names already read, parts and warnings so far.

use super::compiler::Compiler;
use super::defaults::Defaults;
use super::mesh_asset::MeshAsset;
use super::place::Place;
use crate::body::{Parts, WrapKind};
use crate::description::Description;
use crate::description::attributes::Attributes;
use crate::description::error::{DescriptionError, Warning};
use crate::description::origin::Origins;
use crate::description::tree::Tree;
use alloc::collections::{BTreeMap, BTreeSet};
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;

/// A named geom, around which a cable may wrap.
pub(super) struct Surface {
    pub(super) body: usize,
    pub(super) kind: Option<WrapKind>,
    pub(super) radius: f64,
    pub(super) place: Place,
    /// File and line.
    pub(super) at: (String, usize),
    /// Its index among the shapes of bodies.
    pub(super) geom: Option<usize>,
    /// Its index among the wraps once a cable uses it.
    pub(super) wrap: Option<usize>,
}

/// Reads a model that so many others attach.
pub(super) type Read = fn(
    &str,
    &str,
    &mut dyn FnMut(&str) -> Result<String, String>,
    usize,
) -> Result<Description, DescriptionError>;

/// What has been read of a file so far.
pub(super) struct Import<'a> {
    pub(super) tree: &'a Tree,
    pub(super) compiler: Compiler,
    pub(super) defaults: &'a Defaults,
    pub(super) parts: Parts,
    pub(super) surfaces: BTreeMap<String, Surface>,
    /// Meshes by the names of their assets.
    pub(super) meshes: BTreeMap<String, MeshAsset>,
    /// Models that were attached, by the names of their assets, how they are read, and how many attach this
    /// one.
    pub(super) models: BTreeMap<String, Parts>,
    pub(super) read: Read,
    pub(super) depth: usize,
    /// Text of a file: what it includes, and triangles of meshes.
    pub(super) files: &'a mut dyn FnMut(&str) -> Result<String, String>,
    /// Groups of the shapes of bodies, and of those in files.
    pub(super) geom_groups: Vec<f64>,
    pub(super) mesh_groups: Vec<f64>,
    pub(super) warnings: Vec<Warning>,
    pub(super) origins: Origins,
    /// Names by kind, each with its index in the list of its kind.
    names: BTreeMap<&'static str, BTreeMap<String, usize>>,
    warned: BTreeSet<String>,
    /// Joints with the time constant, s, and the damping ratio of their springs and dampers.
    pub(super) spring_dampers: Vec<(usize, [f64; 2])>,
}

impl<'a> Import<'a> {
    /// Nothing read but settings.
    pub(super) fn new(
        tree: &'a Tree,
        compiler: Compiler,
        defaults: &'a Defaults,
        file: &str,
        files: &'a mut dyn FnMut(&str) -> Result<String, String>,
        (read, depth): (Read, usize),
    ) -> Self {
        let parts = Parts {
            name: tree.elements[0].attribute("model").unwrap_or("MuJoCo Model").to_string(),
            gravity: [0.0, 0.0, -9.81],
            ..Parts::default()
        };
        Self {
            tree,
            compiler,
            defaults,
            parts,
            surfaces: BTreeMap::new(),
            meshes: BTreeMap::new(),
            models: BTreeMap::new(),
            read,
            depth,
            files,
            geom_groups: Vec::new(),
            mesh_groups: Vec::new(),
            warnings: Vec::new(),
            origins: Origins::new(file),
            names: BTreeMap::new(),
            warned: BTreeSet::new(),
            spring_dampers: Vec::new(),
        }
    }

    /// The attributes of an element, with the defaults of its class.
    pub(super) fn attributes(
        &self,
        element: usize,
        childclass: Option<&str>,
    ) -> Result<Attributes<'a>, DescriptionError> {
        let given = self.defaults.of(self.tree, element, childclass)?;
        Ok(Attributes { tree: self.tree, element, given })
    }

    /// The element's name, if it has one; names are unique within a kind.
    pub(super) fn name(
        &mut self,
        kind: &'static str,
        at: Attributes<'_>,
    ) -> Result<Option<String>, DescriptionError> {
        self.name_as(kind, at, 0)
    }

    /// The same, recorded with the index of the part in its list.
    pub(super) fn name_as(
        &mut self,
        kind: &'static str,
        at: Attributes<'_>,
        place: usize,
    ) -> Result<Option<String>, DescriptionError> {
        self.describe(kind, place, at);
        let Some(name) = at.text("name").filter(|name| !name.is_empty()) else { return Ok(None) };
        if !self.take(kind, name, place) {
            return Err(at.error("name", format!("is taken already by another {kind}")));
        }
        Ok(Some(name.to_string()))
    }

    /// Gives a name, unless it is empty, to the part with an index; false where another has it.
    pub(super) fn take(&mut self, kind: &'static str, name: &str, place: usize) -> bool {
        name.is_empty() || self.names.entry(kind).or_default().insert(name.to_string(), place).is_none()
    }

    /// Records file and line of a part.
    pub(super) fn describe(&mut self, kind: &'static str, place: usize, at: Attributes<'_>) {
        let element = &self.tree.elements[at.element];
        self.origins.set(kind, place, &self.tree.files[element.file], element.line);
    }

    /// Index of the part that an attribute names.
    pub(super) fn find(
        &self,
        kind: &'static str,
        at: Attributes<'_>,
        attribute: &str,
    ) -> Result<usize, DescriptionError> {
        let name = at.required(attribute)?;
        let found = self.names.get(kind).and_then(|names| names.get(name)).copied();
        found.ok_or_else(|| at.error(attribute, format!("is `{name}`, but there is no {kind} of that name")))
    }

    /// Warns of attributes that are not read and change forces in MuJoCo.
    pub(super) fn ignored(&mut self, at: Attributes<'_>, names: &[&'static str]) {
        for name in names {
            let has_effect = at.text(name).is_some_and(|text| {
                !matches!(text, "false" | "auto")
                    && text.split_ascii_whitespace().any(|word| word.parse() != Ok(0.0))
            });
            if has_effect {
                let tag = at.tree.elements[at.element].name.as_str();
                let what = format!("`{name}` of a <{tag}> is not read, what it does is left out");
                self.without(at.element, &format!("{tag} {name}"), &what);
            }
        }
    }

    /// Warns once per kind of what changes forces and is left out: a machine is refused with it.
    pub(super) fn without(&mut self, element: usize, kind: &str, what: &str) {
        let before = self.warnings.len();
        self.pass_over(element, kind, what);
        self.warnings[before..].iter_mut().for_each(|warning| warning.changes_forces = true);
    }

    /// Warns once per kind of omission.
    pub(super) fn pass_over(&mut self, element: usize, kind: &str, what: &str) {
        if self.warned.insert(kind.to_string()) {
            let at = &self.tree.elements[element];
            let file = self.tree.files[at.file].clone();
            self.warnings.push(Warning {
                file,
                line: at.line,
                what: what.to_string(),
                changes_forces: false,
            });
        }
    }
}
