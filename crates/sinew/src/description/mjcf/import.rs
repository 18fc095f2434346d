//! From MJCF text to parts: settings and classes first, then bodies, then what refers to them.

use super::compiler::Compiler;
use super::defaults::Defaults;
use super::geom::Place;
use super::{body, lists, replicate, schema, tendon};
use crate::body::{Parts, WrapKind};
use crate::description::attributes::Attributes;
use crate::description::error::{DescriptionError, Warning};
use crate::description::origin::Origins;
use crate::description::tree::Tree;
use crate::description::{Description, attributes};
use alloc::collections::{BTreeMap, BTreeSet};
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;

/// A named geom: what a cable may wrap around.
pub(super) struct Surface {
    pub(super) body: usize,
    pub(super) kind: Option<WrapKind>,
    pub(super) radius: f64,
    pub(super) place: Place,
    /// File and line.
    pub(super) at: (String, usize),
    /// Its place among the wraps once a cable uses it.
    pub(super) wrap: Option<usize>,
}

/// What is known while a file is read.
pub(super) struct Import<'a> {
    pub(super) tree: &'a Tree,
    pub(super) compiler: Compiler,
    pub(super) defaults: &'a Defaults,
    pub(super) parts: Parts,
    pub(super) surfaces: BTreeMap<String, Surface>,
    pub(super) warnings: Vec<Warning>,
    pub(super) origins: Origins,
    /// Names by kind, each with its place in the list of its kind.
    names: BTreeMap<&'static str, BTreeMap<String, usize>>,
    warned: BTreeSet<String>,
}

/// Reads a robot from MJCF, with MuJoCo 4's meaning of it.
///
/// `file` names the text in errors; `resolve` hands over what `include` asks for by name, or says why not.
/// Masses, lengths and angles come out in kg, m and rad.
///
/// # Errors
///
/// The first thing that is wrong: file, line, element, attribute, what stands there and what was expected.
pub fn from_mjcf(
    file: &str,
    text: &str,
    resolve: &mut dyn FnMut(&str) -> Result<String, String>,
) -> Result<Description, DescriptionError> {
    let mut tree = Tree::parse(file, text, resolve)?;
    if tree.elements[0].name != "mujoco" {
        return Err(tree.error(0, "", "is the root: expected <mujoco>"));
    }
    schema::check(&tree)?;
    let compiler = Compiler::read(&tree)?;
    replicate::expand(&mut tree, &compiler)?;
    let defaults = Defaults::read(&tree)?;
    let parts = Parts {
        name: tree.elements[0].attribute("model").unwrap_or("MuJoCo Model").to_string(),
        gravity: [0.0, 0.0, -9.81],
        ..Parts::default()
    };
    let mut import = Import {
        tree: &tree,
        compiler,
        defaults: &defaults,
        parts,
        surfaces: BTreeMap::new(),
        warnings: Vec::new(),
        origins: Origins::new(file),
        names: BTreeMap::new(),
        warned: BTreeSet::new(),
    };
    import.top(false)?;
    body::world(&mut import)?;
    import.top(true)?;
    Ok(Description { parts: import.parts, warnings: import.warnings, origins: import.origins })
}

impl<'a> Import<'a> {
    /// The outermost elements: those that stand alone, or those that refer to bodies (tendons before actuators).
    fn top(&mut self, refer: bool) -> Result<(), DescriptionError> {
        let tree = self.tree;
        let all = |name: &str| -> Vec<usize> {
            tree.elements[0].children.iter().copied().filter(|&e| tree.elements[e].name == name).collect()
        };
        if refer {
            let children = |name: &str| -> Vec<usize> {
                all(name).into_iter().flat_map(|e| tree.elements[e].children.iter().copied()).collect()
            };
            children("tendon").into_iter().try_for_each(|e| tendon::read(self, e))?;
            children("equality").into_iter().try_for_each(|e| lists::equality(self, e))?;
            children("actuator").into_iter().try_for_each(|e| lists::actuator(self, e))?;
            return children("keyframe").into_iter().try_for_each(|e| lists::key(self, e));
        }
        for compiler in all("compiler") {
            self.ignored(Attributes::own(tree, compiler), &["alignfree"]);
        }
        for option in all("option") {
            let at = Attributes::own(tree, option);
            self.parts.gravity = at.array_or("gravity", self.parts.gravity)?;
            self.ignored(at, &["density", "viscosity", "wind"]);
            for &flag in tree.elements[option].children.iter().filter(|&&e| tree.elements[e].name == "flag") {
                self.flags(Attributes::own(tree, flag))?;
            }
        }
        for &element in &tree.elements[0].children {
            match tree.elements[element].name.as_str() {
                "compiler" | "option" | "default" | "worldbody" | "tendon" | "equality" | "actuator"
                | "keyframe" | "size" | "statistic" | "visual" | "asset" | "sensor" | "custom" => {}
                name @ ("contact" | "deformable" | "extension") => {
                    self.pass_over(element, name, &format!("<{name}> is not read, what it says is left out"));
                }
                name => {
                    let name = attributes::shortened(name);
                    return Err(tree.error(
                        element,
                        "",
                        format!("<{name}> is no element of MJCF's outermost level"),
                    ));
                }
            }
        }
        Ok(())
    }

    /// What MuJoCo is told to leave out.
    fn flags(&mut self, at: Attributes<'a>) -> Result<(), DescriptionError> {
        let off = |name: &str| Ok::<_, DescriptionError>(at.word(name, &["disable", "enable"])? == Some(0));
        if off("gravity")? {
            self.parts.gravity = [0.0; 3];
        }
        for name in ["spring", "damper", "frictionloss", "limit", "equality", "constraint", "actuation"] {
            if off(name)? {
                let what = format!("`{name}` of <flag> is not read, what it turns off stays on");
                self.pass_over(at.element, &format!("flag {name}"), &what);
            }
        }
        Ok(())
    }

    /// An element with what its class gives it.
    pub(super) fn attributes(
        &self,
        element: usize,
        childclass: Option<&str>,
    ) -> Result<Attributes<'a>, DescriptionError> {
        let given = self.defaults.of(self.tree, element, childclass)?;
        Ok(Attributes { tree: self.tree, element, given })
    }

    /// The element's name, if it has one, taken for the next of its kind.
    pub(super) fn name(
        &mut self,
        kind: &'static str,
        at: Attributes<'_>,
    ) -> Result<Option<String>, DescriptionError> {
        self.name_as(kind, at, 0)
    }

    /// The same, remembered with a place in a list.
    pub(super) fn name_as(
        &mut self,
        kind: &'static str,
        at: Attributes<'_>,
        place: usize,
    ) -> Result<Option<String>, DescriptionError> {
        self.describe(kind, place, at);
        let Some(name) = at.text("name").filter(|name| !name.is_empty()) else { return Ok(None) };
        if self.names.entry(kind).or_default().insert(name.to_string(), place).is_some() {
            return Err(at.error("name", format!("is taken already by another {kind}")));
        }
        Ok(Some(name.to_string()))
    }

    /// Remembers where a part is described.
    pub(super) fn describe(&mut self, kind: &'static str, place: usize, at: Attributes<'_>) {
        let element = &self.tree.elements[at.element];
        self.origins.set(kind, place, &self.tree.files[element.file], element.line);
    }

    /// The place of what an attribute names.
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

    /// Says so where an attribute that is not read asks for something.
    pub(super) fn ignored(&mut self, at: Attributes<'_>, names: &[&'static str]) {
        for name in names {
            let asks = at.text(name).is_some_and(|text| {
                !matches!(text, "false" | "auto")
                    && text.split_ascii_whitespace().any(|word| word.parse() != Ok(0.0))
            });
            if asks {
                let tag = at.tree.elements[at.element].name.as_str();
                let what = format!("`{name}` of a <{tag}> is not read, what it does is left out");
                self.pass_over(at.element, &format!("{tag} {name}"), &what);
            }
        }
    }

    /// Says once for each kind of thing that it is passed over.
    pub(super) fn pass_over(&mut self, element: usize, kind: &str, what: &str) {
        if self.warned.insert(kind.to_string()) {
            let at = &self.tree.elements[element];
            let file = self.tree.files[at.file].clone();
            self.warnings.push(Warning { file, line: at.line, what: what.to_string() });
        }
    }
}
