//! Warnings and names of what a machine or robot file describes.

use crate::output::one_line;
use sinew::description::Warning;

/// Prints warnings on standard error, one per line.
pub(super) fn print_warnings(warnings: &[Warning]) {
    for warning in warnings {
        tell!("warning: {}", one_line(&warning.to_string()));
    }
}

/// The name of a part; a generated one where it has none.
pub(super) fn display_name(kind: &str, name: &str, index: usize) -> String {
    if name.is_empty() { format!("{kind}_{index}") } else { name.to_owned() }
}
