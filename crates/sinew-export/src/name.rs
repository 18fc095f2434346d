//! The name of an exported model: of its files, types and functions.

use crate::ExportError;

/// Longest name: what Simulink allows for a block's function, less the suffixes.
const LONGEST: usize = 40;

/// Names whose `NAME.h` or `NAME.c` would hide a file of the C library or of the export.
const TAKEN: [&str; 27] = [
    "arduino", "assert", "complex", "ctype", "errno", "example", "fenv", "float", "fmi2", "fmi3", "inttypes",
    "iso646", "limits", "locale", "math", "setjmp", "signal", "simstruc", "stdarg", "stdbool", "stddef",
    "stdint", "stdio", "stdlib", "string", "tgmath", "time",
];

/// A C identifier that begins with a letter.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Name(String);

impl Name {
    /// A checked name.
    ///
    /// # Errors [`ExportError::Name`] for what is no identifier of at most 40 letters, digits and single
    /// underscores, and for names of the C library's headers and of the export's own files.
    pub fn new(name: &str) -> Result<Self, ExportError> {
        let refuse = |expected| Err(ExportError::Name { name: name.to_owned(), expected });
        let word = |c: char| c.is_ascii_alphanumeric() || c == '_';
        let starts = name.starts_with(|c: char| c.is_ascii_alphabetic());
        if !starts || !name.chars().all(word) || name.contains("__") || name.len() > LONGEST {
            return refuse(
                "a C identifier: a letter, then letters, digits and single underscores, at most 40",
            );
        }
        if TAKEN.contains(&name.to_ascii_lowercase().as_str()) {
            return refuse("a name that is no header of the C library and none of the export's other files");
        }
        Ok(Self(name.to_owned()))
    }

    /// As files and functions carry it.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// Of a member of the estimator that carries this one.
    pub(crate) fn of_member(&self, k: usize) -> Self {
        Self(format!("{}_m{k}", self.0))
    }

    /// As macros carry it.
    pub(crate) fn upper(&self) -> String {
        self.0.to_ascii_uppercase()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a failing test may panic")]
    use super::*;

    #[test]
    fn identifiers_are_taken_as_they_are() {
        for name in ["model", "Cable_7", "a", "left_knee_extensor"] {
            assert_eq!(Name::new(name).unwrap().as_str(), name);
        }
    }

    #[test]
    fn what_is_no_identifier_or_hides_a_file_is_refused_with_what_would_do() {
        let long = "a".repeat(41);
        for name in ["", "7up", "_x", "a__b", "a-b", "ä", "a b", "math", "Stdio", "example", "a\n", &long] {
            let message = Name::new(name).unwrap_err().to_string();
            assert!(message.contains(&format!("name `{name}`: expected a")), "{message}");
        }
    }
}
