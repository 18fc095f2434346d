//! Elements of an ESI file: children, numbers, and errors with their line.

use super::DescriptionError;
use roxmltree::Node;

/// A file that is being read.
#[derive(Clone, Copy)]
pub(super) struct EsiFile<'a> {
    pub(super) name: &'a str,
}

impl EsiFile<'_> {
    pub(super) fn error(self, node: Node<'_, '_>, problem: impl Into<String>) -> DescriptionError {
        let line = node.document().text_pos_at(node.range().start).row as usize;
        let field = match node.attribute("Index").or_else(|| text_of(node, "Index")) {
            Some(index) => format!("{} {index}", node.tag_name().name()),
            None => node.tag_name().name().to_owned(),
        };
        DescriptionError { file: self.name.to_owned(), line, field, problem: problem.into() }
    }

    /// The number in a child element.
    pub(super) fn number(self, node: Node<'_, '_>, name: &str) -> Result<Option<u64>, DescriptionError> {
        let Some(found) = child(node, name) else { return Ok(None) };
        let text = found.text().unwrap_or_default().trim();
        match number(text) {
            Some(value) => Ok(Some(value)),
            None => Err(self.error(found, format!("`{text}`, expected a number as 10 or #x0a"))),
        }
    }

    /// The number in an attribute.
    pub(super) fn attribute(self, node: Node<'_, '_>, name: &str) -> Result<Option<u64>, DescriptionError> {
        let Some(text) = node.attribute(name) else { return Ok(None) };
        match number(text.trim()) {
            Some(value) => Ok(Some(value)),
            None => Err(self.error(node, format!("{name}=`{text}`, expected a number as 10 or #x0a"))),
        }
    }

    /// A number that has to be there and to fit.
    pub(super) fn required<T: TryFrom<u64>>(
        self,
        node: Node<'_, '_>,
        name: &str,
    ) -> Result<T, DescriptionError> {
        let value = self.number(node, name)?;
        let value = value.ok_or_else(|| self.error(node, format!("expected an element <{name}>")))?;
        self.fit(node, name, value)
    }

    pub(super) fn fit<T: TryFrom<u64>>(
        self,
        node: Node<'_, '_>,
        name: &str,
        value: u64,
    ) -> Result<T, DescriptionError> {
        T::try_from(value).map_err(|_| self.error(node, format!("{name} {value} is too large")))
    }
}

/// A number as in ESI files: decimal, or hexadecimal behind `#x`.
pub(super) fn number(text: &str) -> Option<u64> {
    match text.strip_prefix("#x").or_else(|| text.strip_prefix("#X")).or_else(|| text.strip_prefix("0x")) {
        Some(digits) => u64::from_str_radix(digits, 16).ok(),
        None => text.parse().ok(),
    }
}

pub(super) fn child<'a, 'input>(node: Node<'a, 'input>, name: &str) -> Option<Node<'a, 'input>> {
    children(node, name).next()
}

pub(super) fn children<'a, 'input>(
    node: Node<'a, 'input>,
    name: &str,
) -> impl Iterator<Item = Node<'a, 'input>> {
    node.children().filter(move |child| child.is_element() && child.tag_name().name() == name)
}

pub(super) fn text_of<'a>(node: Node<'a, '_>, name: &str) -> Option<&'a str> {
    child(node, name).and_then(|child| child.text()).map(str::trim)
}

/// `true` and `1`.
pub(super) fn is_set(node: Node<'_, '_>, attribute: &str) -> bool {
    node.attribute(attribute).is_some_and(|value| matches!(value.trim(), "1" | "true"))
}

/// Octets as pairs of hexadecimal digits.
pub(super) fn octets(text: &str) -> Option<Vec<u8>> {
    let digits: Vec<u32> = text.chars().map(|digit| digit.to_digit(16)).collect::<Option<_>>()?;
    digits
        .len()
        .is_multiple_of(2)
        .then(|| digits.chunks(2).map(|pair| (pair[0] << 4 | pair[1]) as u8).collect())
}
