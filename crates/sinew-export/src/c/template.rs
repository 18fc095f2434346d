//! Templates of C: parts that are left out, and places that are filled.
//!
//! ```text
//! //%if WORD .. //%else .. //%end      lines that stand where the word is set, or where it is not
//! //%include WORD                      the lines of another template
//! //%slot WORD                         generated lines
//! //%here WORD                         a generated text, up to the end of the word, within a line
//! @ and @@                             the model's name, and the same in capitals
//! ```

use crate::Name;
use std::collections::{BTreeMap, BTreeSet};

/// The templates by the word that includes them.
const TEMPLATES: [(&str, &str); 11] = [
    ("cable", include_str!("templates/cable.c")),
    ("cell", include_str!("templates/cell.c")),
    ("axis_force", include_str!("templates/axis_force.c")),
    ("axis_motion", include_str!("templates/axis_motion.c")),
    ("linear", include_str!("templates/linear.c")),
    ("state", include_str!("templates/state.h")),
    ("specimen", include_str!("templates/specimen.c")),
    ("inverse", include_str!("templates/inverse.c")),
    ("ensemble", include_str!("templates/ensemble.c")),
    ("perceptron", include_str!("templates/perceptron.c")),
    ("process", include_str!("../fmu/templates/process.h")),
];

/// What fills a template.
#[derive(Debug, Default)]
pub(crate) struct Filling {
    words: BTreeSet<&'static str>,
    texts: BTreeMap<&'static str, String>,
}

impl Filling {
    /// Sets a word where `holds`.
    pub(crate) fn when(&mut self, word: &'static str, holds: bool) {
        if holds {
            self.words.insert(word);
        }
    }

    /// Fills a place; lines end in a line break, texts within a line do not.
    #[expect(clippy::needless_pass_by_value, reason = "callers hand over numbers and texts as they come")]
    pub(crate) fn set(&mut self, word: &'static str, text: impl ToString) {
        self.texts.insert(word, text.to_string());
    }

    /// The template with its places filled and `@` replaced by the name.
    pub(crate) fn render(&self, template: &str, name: &Name) -> String {
        let mut out = String::new();
        // Whether the lines of every open `if` stand.
        let mut open: Vec<bool> = Vec::new();
        for line in template.lines() {
            let (word, rest) = line.strip_prefix("//%").and_then(|d| d.split_once(' ')).unwrap_or(("", line));
            match (word, line) {
                ("if", _) => open.push(self.words.contains(rest.trim())),
                (_, "//%else") => {
                    if let Some(last) = open.last_mut() {
                        *last = !*last;
                    }
                }
                (_, "//%end") => {
                    open.pop();
                }
                _ if open.contains(&false) => {}
                ("slot", _) => out += self.text(rest.trim()),
                ("include", _) => {
                    let found = TEMPLATES.iter().find(|(word, _)| *word == rest.trim());
                    out += &self.render(found.map_or("", |(_, template)| template), name);
                }
                _ => out += &(self.line(line, name) + "\n"),
            }
        }
        out
    }

    fn text(&self, word: &str) -> &str {
        self.texts.get(word).map_or("", String::as_str)
    }

    fn line(&self, line: &str, name: &Name) -> String {
        let named = |text: &str| text.replace("@@", &name.upper()).replace('@', name.as_str());
        let mut parts = line.split("//%here ");
        let mut out = named(parts.next().unwrap_or_default());
        for part in parts {
            let end = part.find(|c: char| !(c.is_ascii_lowercase() || c == '_')).unwrap_or(part.len());
            let (word, rest) = part.split_at(end);
            out += self.text(word);
            out += &named(rest);
        }
        out
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a failing test may panic")]
    use super::*;

    #[test]
    fn parts_stand_where_their_word_is_set_and_places_are_filled_verbatim() {
        let mut filling = Filling::default();
        filling.when("a", true);
        filling.when("b", false);
        filling.set("x", "1@");
        filling.set("rows", "r\n");
        let template = "@@ @_f\n//%if a\nA //%here x + //%here x;\n//%if \
            b\nB\n//%else\nC\n//%end\n//%end\n//%slot rows\n";
        assert_eq!(filling.render(template, &Name::new("m").unwrap()), "M m_f\nA 1@ + 1@;\nC\nr\n");
    }
}
