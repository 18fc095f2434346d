//! Paths in Rust source: enough grammar to see every `crate::`, `super::` and `std::`.

use proc_macro2::{Delimiter, TokenStream, TokenTree};

/// The words and signs of a source, groups opened and closed; literals and comments are left out.
///
/// # Errors
/// Where it is no Rust.
pub(super) fn tokens(source: &str) -> Result<Vec<String>, String> {
    let stream: TokenStream = source.parse().map_err(|error| format!("{error}"))?;
    let mut found = Vec::new();
    flatten(stream, &mut found);
    Ok(found)
}

fn flatten(stream: TokenStream, found: &mut Vec<String>) {
    let mut tokens = stream.into_iter().peekable();
    while let Some(token) = tokens.next() {
        match token {
            TokenTree::Group(group) => {
                let [open, close] = match group.delimiter() {
                    Delimiter::Brace => ["{", "}"],
                    Delimiter::Parenthesis => ["(", ")"],
                    Delimiter::Bracket => ["[", "]"],
                    Delimiter::None => ["", ""],
                };
                found.push(open.to_owned());
                flatten(group.stream(), found);
                found.push(close.to_owned());
            }
            TokenTree::Punct(sign) if sign.as_char() == ':' => {
                let double = tokens.next_if(|next| matches!(next, TokenTree::Punct(p) if p.as_char() == ':'));
                found.push(if double.is_some() { "::" } else { ":" }.to_owned());
            }
            TokenTree::Literal(_) => {}
            other => found.push(other.to_string()),
        }
    }
}

/// The first name below the crate's root of every path that goes through it, by `crate::` or by enough
/// `super::` for a file of so many modules below the root.
pub(super) fn from_root(tokens: &[String], depth: usize) -> Vec<String> {
    let (mut found, mut braces, mut modules) = (Vec::new(), 0_usize, Vec::new());
    let mut i = 0;
    while i < tokens.len() {
        match tokens[i].as_str() {
            "mod" if is(tokens, i + 2, "{") => modules.push(braces + 1),
            "{" => braces += 1,
            "}" => {
                modules.retain(|opened| *opened != braces);
                braces = braces.saturating_sub(1);
            }
            "crate" if is(tokens, i + 1, "::") => found.extend(names(tokens, i + 2)),
            "super" => {
                let mut climbed = 1;
                while is(tokens, i + 1, "::") && is(tokens, i + 2, "super") {
                    climbed += 1;
                    i += 2;
                }
                if climbed >= depth + modules.len() && is(tokens, i + 1, "::") {
                    found.extend(names(tokens, i + 2));
                }
            }
            _ => {}
        }
        i += 1;
    }
    found
}

/// A path that a file names, in a `use` or in its code.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Import {
    /// Its parts, with `crate`, `self` and `super` as written.
    pub(super) path: Vec<String>,
    /// The name it has in the file: the last part, or what stands after `as`.
    pub(super) alias: String,
    /// Whether it stands in a `use`.
    pub(super) in_use: bool,
    /// Whether that `use` re-exports it.
    pub(super) public: bool,
}

/// Every path of two parts and more, test modules left out; a `use` of a tree becomes one import a leaf.
pub(super) fn imports(tokens: &[String]) -> Vec<Import> {
    let tokens = without_tests(tokens);
    let (mut found, mut i) = (Vec::new(), 0);
    while i < tokens.len() {
        if tokens[i] == "use" {
            let public = i > 0 && (tokens[i - 1] == "pub" || tokens[i - 1] == ")");
            i = leaves(&tokens, i + 1, &[], public, &mut found);
        } else if word(&tokens, i) && is(&tokens, i + 1, "::") && !(i > 0 && tokens[i - 1] == "::") {
            let mut path = vec![tokens[i].clone()];
            while is(&tokens, i + 1, "::") && word(&tokens, i + 2) {
                path.push(tokens[i + 2].clone());
                i += 2;
            }
            let alias = path.last().cloned().unwrap_or_default();
            found.push(Import { path, alias, in_use: false, public: false });
            i += 1;
        } else {
            i += 1;
        }
    }
    found
}

/// Reads one branch of a `use` tree into its leaves; the place after it.
fn leaves(tokens: &[String], from: usize, before: &[String], public: bool, found: &mut Vec<Import>) -> usize {
    let (mut path, mut i) = (before.to_vec(), from);
    loop {
        if is(tokens, i, "{") {
            i += 1;
            while i < tokens.len() && !is(tokens, i, "}") {
                i = leaves(tokens, i, &path, public, found);
                i += usize::from(is(tokens, i, ","));
            }
            return i + 1;
        }
        let Some(token) = tokens.get(i) else { return i };
        if word(tokens, i) && (token != "self" || path.is_empty()) {
            path.push(token.clone());
        }
        i += 1;
        if !is(tokens, i, "::") {
            break;
        }
        i += 1;
    }
    let mut alias = path.last().cloned().unwrap_or_default();
    if is(tokens, i, "as") {
        alias = tokens.get(i + 1).cloned().unwrap_or_default();
        i += 2;
    }
    found.push(Import { path, alias, in_use: true, public });
    // A `;` ends the statement, what else stands here belongs to the tree around this branch.
    i
}

fn word(tokens: &[String], at: usize) -> bool {
    tokens.get(at).is_some_and(|token| token.starts_with(|c: char| c.is_alphabetic() || c == '_'))
}

/// The tokens outside of modules and other items that only tests are compiled with.
fn without_tests(tokens: &[String]) -> Vec<String> {
    const MARK: [&str; 7] = ["#", "[", "cfg", "(", "test", ")", "]"];
    let (mut kept, mut i) = (Vec::new(), 0);
    while i < tokens.len() {
        if !MARK.iter().enumerate().all(|(k, text)| is(tokens, i + k, text)) {
            kept.push(tokens[i].clone());
            i += 1;
            continue;
        }
        let mut open = 0_usize;
        i += MARK.len();
        while let Some(token) = tokens.get(i) {
            i += 1;
            match token.as_str() {
                "{" => open += 1,
                "}" if open == 1 => break,
                "}" => open = open.saturating_sub(1),
                ";" if open == 0 => break,
                _ => {}
            }
        }
    }
    kept
}

/// The name after every `start::`.
pub(super) fn after(tokens: &[String], start: &str) -> Vec<String> {
    let starts = (0..tokens.len()).filter(|&i| tokens[i] == start && is(tokens, i + 1, "::"));
    starts.flat_map(|i| names(tokens, i + 2)).collect()
}

fn is(tokens: &[String], at: usize, text: &str) -> bool {
    tokens.get(at).is_some_and(|token| token == text)
}

/// The name at a place, or the first name of every branch of a `{a::b, c}`.
fn names(tokens: &[String], at: usize) -> Vec<String> {
    if !is(tokens, at, "{") {
        return tokens.get(at).cloned().into_iter().collect();
    }
    let (mut found, mut open, mut fresh) = (Vec::new(), 1, true);
    for token in &tokens[at + 1..] {
        match token.as_str() {
            "{" => open += 1,
            "}" => open -= 1,
            "," if open == 1 => fresh = true,
            name if fresh && open == 1 => {
                found.push(name.to_owned());
                fresh = false;
            }
            _ => {}
        }
        if open == 0 {
            break;
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rooms(source: &str, depth: usize) -> Vec<String> {
        from_root(&tokens(source).unwrap(), depth)
    }

    #[test]
    fn plain_grouped_and_inline_paths_are_seen() {
        let source =
            "use crate::math::tanh;\npub(crate) fn f() { crate::twin::g(); }\nuse crate::{a::{b, c}, d};";
        assert_eq!(rooms(source, 2), ["math", "twin", "a", "d"]);
    }

    #[test]
    fn enough_supers_reach_the_root_and_fewer_do_not() {
        assert_eq!(rooms("use super::super::control::X;", 2), ["control"]);
        assert!(rooms("use super::Sheath;", 2).is_empty());
        assert!(rooms("mod tests { use super::super::Sheath; }", 2).is_empty());
        let in_tests = "mod tests { use super::super::super::twin; } use super::super::body;";
        assert_eq!(rooms(in_tests, 2), ["twin", "body"]);
    }

    #[test]
    fn comments_and_strings_show_nothing_and_macros_hide_nothing() {
        assert!(rooms("// crate::twin\nconst A: &str = \"crate::twin\";", 1).is_empty());
        assert_eq!(rooms("fn f() { vec![crate::seen::y('{')] }", 1), ["seen"]);
        assert_eq!(after(&tokens("use std::{fs, vec::Vec};").unwrap(), "std"), ["fs", "vec"]);
    }
}
