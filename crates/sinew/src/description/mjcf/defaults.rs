//! Classes of defaults, each with the defaults it inherits.

use crate::description::attributes::Given;
use crate::description::error::DescriptionError;
use crate::description::tree::Tree;
use alloc::collections::BTreeMap;
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;

/// By class, then by kind of element.
#[derive(Debug)]
pub(super) struct Defaults {
    classes: BTreeMap<String, BTreeMap<&'static str, Given>>,
    main: String,
}

/// Kinds that this import reads; all actuators share one.
pub(super) fn kind(name: &str) -> Option<&'static str> {
    Some(match name {
        "joint" => "joint",
        "geom" => "geom",
        "mesh" => "mesh",
        "site" => "site",
        "tendon" => "tendon",
        "equality" => "equality",
        "motor" | "general" | "position" | "velocity" | "intvelocity" | "damper" | "cylinder" | "muscle"
        | "pid" | "adhesion" | "dcmotor" => "actuator",
        _ => return None,
    })
}

/// Alternative forms of one property: any of them in an element replaces all of them in its defaults.
const ORIENTATIONS: [&str; 5] = ["quat", "axisangle", "xyaxes", "zaxis", "euler"];

/// Merges `attributes` into the inherited ones.
fn lay_over(given: &mut Given, attributes: &[(String, String)]) {
    if attributes.iter().any(|(name, _)| ORIENTATIONS.contains(&name.as_str())) {
        ORIENTATIONS.iter().for_each(|name| {
            given.remove(*name);
        });
    }
    for (name, text) in attributes.iter().filter(|(name, _)| name != "class") {
        let text = completed(text, given.get(name));
        given.insert(name.clone(), text);
    }
}

/// A list completed from an inherited one: in MuJoCo `gainprm="2"` changes the first number alone.
pub(super) fn completed(own: &str, inherited: Option<&String>) -> String {
    let count = own.split_ascii_whitespace().count();
    let rest = inherited.into_iter().flat_map(|text| text.split_ascii_whitespace().skip(count));
    rest.fold(own.to_string(), |text, word| text + " " + word)
}

impl Defaults {
    pub(super) fn read(tree: &Tree) -> Result<Defaults, DescriptionError> {
        let mut defaults = Defaults { classes: BTreeMap::new(), main: "main".to_string() };
        let mut tops =
            tree.elements[0].children.iter().filter(|&&e| tree.elements[e].name == "default").peekable();
        if let Some(name) = tops.peek().and_then(|&&e| tree.elements[e].attribute("class")) {
            defaults.main = name.to_string();
        }
        defaults.classes.insert(defaults.main.clone(), BTreeMap::new());
        for &top in tops {
            let name = tree.elements[top].attribute("class").unwrap_or(&defaults.main).to_string();
            if name != defaults.main {
                return Err(tree.error(
                    top,
                    "class",
                    format!("is `{name}`: the outermost class is `{}`", defaults.main),
                ));
            }
            let mut open = Vec::from([(top, name)]);
            while let Some((at, class)) = open.pop() {
                let nested = defaults.one(tree, at, &class)?;
                open.extend(nested.into_iter().rev());
            }
        }
        Ok(defaults)
    }

    /// Reads one class and its subclasses.
    fn one(&mut self, tree: &Tree, at: usize, class: &str) -> Result<Vec<(usize, String)>, DescriptionError> {
        let mut nested = Vec::new();
        let mut kinds = self.classes.remove(class).unwrap_or_default();
        for &child in &tree.elements[at].children {
            let element = &tree.elements[child];
            if element.name == "default" {
                nested.push(child);
            } else if let Some(kind) = kind(&element.name) {
                lay_over(kinds.entry(kind).or_default(), &element.attributes);
            }
        }
        self.classes.insert(class.to_string(), kinds.clone());
        let mut names = Vec::new();
        for child in nested {
            let name = tree.elements[child].attribute("class");
            let name = name
                .ok_or_else(|| tree.error(child, "class", "is missing: a class within a class has a name"))?;
            if self.classes.insert(name.to_string(), kinds.clone()).is_some() {
                return Err(tree.error(child, "class", format!("`{name}` is taken already")));
            }
            names.push((child, name.to_string()));
        }
        Ok(names)
    }

    /// Defaults of an element: of its own `class`, else the nearest `childclass`, else the outermost class.
    pub(super) fn of(
        &self,
        tree: &Tree,
        element: usize,
        childclass: Option<&str>,
    ) -> Result<Option<&Given>, DescriptionError> {
        let at = &tree.elements[element];
        let own = at.attribute("class");
        let class = own.or(childclass).unwrap_or(&self.main);
        let kind = match at.name.as_str() {
            "spatial" | "fixed" => Some("tendon"),
            name => kind(name),
        };
        let kinds = self.class(tree, element, "class", class)?;
        Ok(kind.and_then(|kind| kinds.get(kind)))
    }

    pub(super) fn class(
        &self,
        tree: &Tree,
        element: usize,
        attribute: &str,
        name: &str,
    ) -> Result<&BTreeMap<&'static str, Given>, DescriptionError> {
        let unknown =
            || tree.error(element, attribute, format!("is `{name}`, but there is no class of that name"));
        self.classes.get(name).ok_or_else(unknown)
    }
}
