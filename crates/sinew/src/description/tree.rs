//! The elements of a robot file and its includes as a flat list, each with file and line.

use super::error::DescriptionError;
use alloc::borrow::Cow;
use alloc::collections::BTreeSet;
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;

/// Largest depth of nested elements, which bounds memory.
pub(super) const DEEPEST: usize = 1000;
/// Bytes of one file.
const LONGEST: usize = 64 << 20;
/// Elements of all files.
const MOST: usize = 2_000_000;
/// Attributes of one element: the parser compares each with all before it.
const MAX_ATTRIBUTES: usize = 1000;
/// Namespace declarations of a file: every element resolves its prefixes among all that are in scope.
const MAX_NAMESPACES: usize = 100;

/// One element.
#[derive(Debug, Clone)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) attributes: Vec<(String, String)>,
    pub(super) children: Vec<usize>,
    pub(super) file: usize,
    pub(super) line: usize,
}

/// All elements; the first is the root.
#[derive(Debug)]
pub(super) struct Tree {
    pub(super) elements: Vec<Element>,
    pub(super) files: Vec<String>,
}

/// Returns the text of a named file, or the reason why there is none.
pub(super) type Resolve<'a> = &'a mut dyn FnMut(&str) -> Result<String, String>;

impl Tree {
    /// Parses `text` and everything it includes.
    pub(super) fn parse(file: &str, text: &str, resolve: Resolve<'_>) -> Result<Tree, DescriptionError> {
        let mut tree = Tree { elements: Vec::new(), files: Vec::new() };
        tree.read(file, text)?;
        let mut seen: BTreeSet<String> = BTreeSet::from([file.to_string()]);
        // Every include is replaced by the children of the included root; these may include again.
        while let Some((parent, place)) = tree.first_include() {
            let include = tree.elements[parent].children[place];
            let element = &tree.elements[include];
            let name = element.attribute("file").map(ToString::to_string);
            let Some(name) = name else {
                return Err(tree.error(include, "file", "is missing: the name of the file to include"));
            };
            if !seen.insert(name.clone()) {
                let problem =
                    format!("`{name}` is included already: a file may not include itself or stand twice");
                return Err(tree.error(include, "file", problem));
            }
            let text = resolve(&name)
                .map_err(|problem| tree.error(include, "file", format!("`{name}`: {problem}")))?;
            let root = tree.read(&name, &text)?;
            let children = core::mem::take(&mut tree.elements[root].children);
            tree.elements[parent].children.splice(place..=place, children);
        }
        tree.depth()?;
        Ok(tree)
    }

    fn first_include(&self) -> Option<(usize, usize)> {
        let mut open = Vec::from([0]);
        while let Some(at) = open.pop() {
            let children = &self.elements[at].children;
            if let Some(place) = children.iter().position(|&child| self.elements[child].name == "include") {
                return Some((at, place));
            }
            open.extend(children.iter().copied());
        }
        None
    }

    /// Checks the depth again, because includes nest.
    fn depth(&self) -> Result<(), DescriptionError> {
        let mut open = Vec::from([(0, 0)]);
        while let Some((at, depth)) = open.pop() {
            if depth > DEEPEST {
                return Err(self.error(at, "", format!("lies more than {DEEPEST} elements deep")));
            }
            open.extend(self.elements[at].children.iter().map(|&child| (child, depth + 1)));
        }
        Ok(())
    }

    fn read(&mut self, file: &str, text: &str) -> Result<usize, DescriptionError> {
        let at = self.files.len();
        self.files.push(file.to_string());
        let wrong = |line: usize, problem: String| DescriptionError {
            file: file.to_string(),
            line,
            place: "file".to_string(),
            problem,
        };
        // OpenSim names some elements by two names of C++, which no name of XML may be.
        let known = text.contains("<OpenSimDocument") && text.contains("::");
        let text = &*if known { Cow::Owned(text.replace("::", "..")) } else { Cow::Borrowed(text) };
        if text.len() > LONGEST {
            return Err(wrong(1, format!("has {} bytes, more than the {LONGEST} that are read", text.len())));
        }
        check_attributes(text).map_err(|(line, problem)| wrong(line, problem))?;
        let options =
            roxmltree::ParsingOptions { allow_dtd: false, nodes_limit: 4_000_000, ..Default::default() };
        let document = roxmltree::Document::parse_with_options(text, options).map_err(|error| {
            let problem = match &error {
                roxmltree::Error::DtdDetected => {
                    "has a document type declaration: entities are not expanded here, remove it".to_string()
                }
                other => format!("is no well-formed XML: {other}"),
            };
            wrong((error_line(text, &error) as usize).max(1), problem)
        })?;
        let starts: Vec<usize> = core::iter::once(0)
            .chain(text.bytes().enumerate().filter(|(_, b)| *b == b'\n').map(|(i, _)| i + 1))
            .collect();
        let line = |position: usize| starts.partition_point(|&start| start <= position);
        let root = self.elements.len();
        // OpenSim writes what others write as attributes as elements with a text: they count as both.
        let texts = document.root_element().has_tag_name("OpenSimDocument");
        let mut open = Vec::from([(document.root_element(), None, 0)]);
        while let Some((node, parent, depth)) = open.pop() {
            let line = line(node.range().start);
            let name = node.tag_name().name().to_string();
            if depth > DEEPEST || self.elements.len() >= MOST {
                let problem =
                    format!("<{name}>: more than {DEEPEST} elements within each other, or {MOST} in all");
                return Err(wrong(line, problem));
            }
            let attributes =
                node.attributes().map(|a| (a.name().to_string(), a.value().to_string())).collect();
            let index = self.elements.len();
            self.elements.push(Element { name, attributes, children: Vec::new(), file: at, line });
            if let Some(parent) = parent {
                let parent: &mut Element = &mut self.elements[parent];
                parent.children.push(index);
                if texts && !node.children().any(|child| child.is_element()) {
                    let text: String = node
                        .children()
                        .filter(|child| child.is_text())
                        .filter_map(|child| child.text())
                        .collect();
                    let name = node.tag_name().name().to_string();
                    parent.attributes.push((name, text.trim().to_string()));
                }
            }
            // Pushed in reverse, so that the stack returns them in document order.
            let children: Vec<_> = node.children().filter(roxmltree::Node::is_element).collect();
            open.extend(children.into_iter().rev().map(|child| (child, Some(index), depth + 1)));
        }
        Ok(root)
    }

    /// An error about an attribute of an element, or with `""` about the element.
    #[expect(clippy::needless_pass_by_value, reason = "literals and fresh text come alike")]
    pub(super) fn error(&self, element: usize, attribute: &str, problem: impl ToString) -> DescriptionError {
        let at = &self.elements[element];
        let mut place = format!("<{}", at.name);
        if let Some(name) = at.attribute("name") {
            place.push_str(&format!(" name=\"{name}\""));
        }
        place.push('>');
        if !attribute.is_empty() {
            place.push_str(&format!(" `{attribute}`"));
        }
        let is_text = |child: &&Element| child.name == attribute && child.children.is_empty();
        let written = at.children.iter().map(|&child| &self.elements[child]).find(is_text).unwrap_or(at);
        DescriptionError {
            file: self.files[at.file].clone(),
            line: written.line,
            place,
            problem: problem.to_string(),
        }
    }
}

impl Element {
    pub(super) fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(key, _)| key == name).map(|(_, value)| value.as_str())
    }
}

/// Refuses a tag with more attributes, and a file with more namespaces, than a parser of quadratic cost is
/// given; `Err` carries the line.
fn check_attributes(text: &str) -> Result<(), (usize, String)> {
    let (mut line, mut quote, mut in_tag, mut attributes) = (1, None, false, 0);
    for byte in text.bytes() {
        line += usize::from(byte == b'\n');
        match (quote, byte) {
            (Some(open), _) if in_tag => quote = if byte == open { None } else { quote },
            (_, b'<') => (in_tag, attributes, quote) = (true, 0, None),
            (_, b'>') => in_tag = false,
            (_, b'=') if in_tag => attributes += 1,
            (_, b'"' | b'\'') if in_tag => quote = Some(byte),
            _ => {}
        }
        if attributes > MAX_ATTRIBUTES {
            return Err((line, format!("has an element with more than {MAX_ATTRIBUTES} attributes")));
        }
    }
    let namespaces = text.matches("xmlns").count();
    if namespaces > MAX_NAMESPACES {
        return Err((1, format!("has {namespaces} namespace declarations, more than {MAX_NAMESPACES}")));
    }
    Ok(())
}

fn error_line(text: &str, error: &roxmltree::Error) -> u32 {
    match error {
        // These errors carry no position: that of the document type is searched for, the other is the end of
        // the text.
        roxmltree::Error::DtdDetected => {
            let before = text.find("<!DOCTYPE").map_or("", |at| &text[..at]);
            before.bytes().filter(|b| *b == b'\n').count() as u32 + 1
        }
        roxmltree::Error::UnclosedRootNode => text.bytes().filter(|b| *b == b'\n').count() as u32 + 1,
        other => other.pos().row,
    }
}
