//! Errors of the TOML deserializer in the words of the other errors: table, key, value, what was expected.

use super::attributes::shortened;
use super::document::Document;
use super::error::DescriptionError;
use super::spelling;
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;
use core::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// The error of a deserializer with this message at a span of the document.
pub(super) fn refused(
    document: &Document<'_>,
    root: &Spanned<DeTable<'_>>,
    span: Range<usize>,
    message: &str,
) -> DescriptionError {
    let Some((place, key, value)) = find(root.get_ref(), "", &span) else {
        return document.error(span.start, "table", message);
    };
    let mut quoted = message.split('`').skip(1).step_by(2);
    let problem = if message.contains("$__toml_private") {
        format!("{key} is {}: expected no date", document.written_in(value.span()))
    } else if message.starts_with("unknown field") {
        let unknown = quoted.next().unwrap_or(key);
        let known: Vec<&str> = quoted.collect();
        format!("`{}` is no key of it{}", shortened(unknown), spelling::expected(unknown, &known))
    } else if message.starts_with("missing field") {
        format!("{} is missing", quoted.next().unwrap_or("a key"))
    } else {
        let expected = message.rsplit_once("expected ").map_or(message, |(_, expected)| expected);
        let within = span.end - span.start < value.span().end - value.span().start;
        let written = document.written_in(if within { span.clone() } else { value.span() });
        format!("{key} is {written}: expected {}", plain(expected))
    };
    document.error(span.start, &place, &problem)
}

/// What a deserializer expects, without names of Rust types.
fn plain(expected: &str) -> String {
    match expected {
        "f64" => "a number".to_string(),
        "a string" => "a text in quotes".to_string(),
        "a sequence" => "a list".to_string(),
        table if table.starts_with("struct ") => "a table".to_string(),
        other => other.to_string(),
    }
}

/// The innermost key whose name or value has this span, with the place of its table.
fn find<'d>(
    table: &'d DeTable<'_>,
    place: &str,
    span: &Range<usize>,
) -> Option<(String, &'d str, &'d Spanned<DeValue<'d>>)> {
    let has = |outer: Range<usize>| outer.start <= span.start && span.end <= outer.end;
    let named = |entries: &DeTable<'_>| {
        let name = |key: &str| {
            entries.iter().find(|(known, _)| known.get_ref() == key).and_then(|(_, v)| v.get_ref().as_str())
        };
        name("name")
            .or_else(|| name("follower"))
            .map(|name| format!(" `{}`", shortened(name)))
            .unwrap_or_default()
    };
    for (key, value) in table {
        // A header spans its name alone: what is below it is searched in any case.
        let inner = match value.get_ref() {
            DeValue::Table(entries) => {
                let place = if place.is_empty() { format!("[{}]", key.get_ref()) } else { place.to_string() };
                find(entries, &place, span)
            }
            DeValue::Array(array) => array.iter().find_map(|part| {
                let entries = part.get_ref().as_table()?;
                let place = if place.is_empty() {
                    format!("[[{}]]{}", key.get_ref(), named(entries))
                } else {
                    place.to_string()
                };
                find(entries, &place, span)
                    .or_else(|| has(part.span()).then(|| (place, key.get_ref().as_ref(), part)))
            }),
            _ => None,
        };
        if inner.is_some() {
            return inner;
        }
        if has(key.span()) || has(value.span()) {
            let place = if place.is_empty() { "robot".to_string() } else { place.to_string() };
            return Some((place, key.get_ref(), value));
        }
    }
    None
}
