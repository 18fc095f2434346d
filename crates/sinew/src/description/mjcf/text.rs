//! Values of attributes as text.

use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;

/// Text escaped for an attribute.
pub(super) fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}

/// Shortest decimals that read back to the same bits.
pub(super) fn numbers(values: &[f64]) -> String {
    values.iter().map(|x| format!("{x:?}")).collect::<Vec<_>>().join(" ")
}
