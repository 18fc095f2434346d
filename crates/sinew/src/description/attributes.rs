//! Typed access to the attributes of an element; its own take precedence over those of its class.

use super::error::DescriptionError;
use super::tree::Tree;
use alloc::collections::BTreeMap;
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;

/// Attributes that a class gives to one kind of element.
pub(super) type Given = BTreeMap<String, String>;

/// One element with the defaults of its class.
#[derive(Clone, Copy)]
pub(super) struct Attributes<'a> {
    pub(super) tree: &'a Tree,
    pub(super) element: usize,
    pub(super) given: Option<&'a Given>,
}

impl<'a> Attributes<'a> {
    pub(super) fn own(tree: &'a Tree, element: usize) -> Attributes<'a> {
        Attributes { tree, element, given: None }
    }

    pub(super) fn text(&self, name: &str) -> Option<&'a str> {
        let own = self.tree.elements[self.element].attribute(name);
        own.or_else(|| self.given.and_then(|given| given.get(name)).map(String::as_str))
    }

    pub(super) fn error(&self, attribute: &str, problem: impl ToString) -> DescriptionError {
        self.tree.error(self.element, attribute, problem)
    }

    /// The text of a required attribute.
    pub(super) fn required(&self, name: &str) -> Result<&'a str, DescriptionError> {
        self.text(name).ok_or_else(|| self.error(name, "is missing"))
    }

    /// A list of `least` to `most` finite numbers.
    pub(super) fn list(
        &self,
        name: &str,
        least: usize,
        most: usize,
    ) -> Result<Option<Vec<f64>>, DescriptionError> {
        let Some(text) = self.text(name) else { return Ok(None) };
        let mut numbers = Vec::new();
        for word in text.split_ascii_whitespace() {
            let number = word.parse::<f64>().ok().filter(|number| number.is_finite());
            numbers.push(
                number
                    .ok_or_else(|| self.error(name, format!("is `{text}`: `{word}` is no finite number")))?,
            );
            if numbers.len() > most {
                break;
            }
        }
        if (least..=most).contains(&numbers.len()) {
            return Ok(Some(numbers));
        }
        let expected = if least == most { format!("{least}") } else { format!("{least} to {most}") };
        let some = numbers.len();
        let got = if some > most { "more".to_string() } else { some.to_string() };
        Err(self.error(name, format!("is `{}`: expected {expected} numbers, got {got}", shortened(text))))
    }

    pub(super) fn array<const N: usize>(&self, name: &str) -> Result<Option<[f64; N]>, DescriptionError> {
        Ok(self.list(name, N, N)?.and_then(|list| list.try_into().ok()))
    }

    pub(super) fn array_or<const N: usize>(
        &self,
        name: &str,
        other: [f64; N],
    ) -> Result<[f64; N], DescriptionError> {
        Ok(self.array(name)?.unwrap_or(other))
    }

    pub(super) fn number(&self, name: &str) -> Result<Option<f64>, DescriptionError> {
        Ok(self.array::<1>(name)?.map(|[number]| number))
    }

    pub(super) fn number_or(&self, name: &str, other: f64) -> Result<f64, DescriptionError> {
        Ok(self.number(name)?.unwrap_or(other))
    }

    /// A number that may not be negative.
    pub(super) fn not_negative(&self, name: &str) -> Result<f64, DescriptionError> {
        match self.number_or(name, 0.0)? {
            value if value >= 0.0 => Ok(value),
            value => Err(self.error(name, format!("is {value}: expected a number >= 0"))),
        }
    }

    /// A keyword, as its index in the list of keywords.
    pub(super) fn word(&self, name: &str, words: &[&str]) -> Result<Option<usize>, DescriptionError> {
        let Some(text) = self.text(name) else { return Ok(None) };
        match words.iter().position(|word| *word == text) {
            Some(place) => Ok(Some(place)),
            None => {
                Err(self
                    .error(name, format!("is `{}`: expected one of {}", shortened(text), words.join(", "))))
            }
        }
    }

    pub(super) fn flag(&self, name: &str, other: bool) -> Result<bool, DescriptionError> {
        Ok(self.word(name, &["false", "true"])?.map_or(other, |place| place == 1))
    }
}

/// A value truncated for an error message.
pub(super) fn shortened(text: &str) -> String {
    let short: String = text.chars().take(60).collect();
    if short.len() < text.len() { format!("{short}...") } else { short }
}
