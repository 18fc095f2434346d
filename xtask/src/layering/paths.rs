//! Paths in Rust source, found without a compiler: enough grammar to see every `crate::`, `super::` and `std::`.

/// A word or a sign of the source, with its 1-based line.
#[derive(Debug, PartialEq)]
struct Token {
    line: usize,
    text: String,
}

/// How many modules below the crate root the top of a file is: `lib.rs` 0, `room.rs` and `room/mod.rs` 1.
pub(super) fn depth(inside: &str) -> usize {
    if inside == "lib.rs" {
        return 0;
    }
    let parts = inside.split('/').count();
    if inside.ends_with("/mod.rs") { parts - 1 } else { parts }
}

/// The first name below the crate root of every path that goes through it, by `crate::` or by enough `super::`.
pub(super) fn from_root(source: &str, depth: usize) -> Vec<(usize, String)> {
    let tokens = tokens(source);
    let (mut found, mut braces, mut modules) = (Vec::new(), 0_usize, Vec::new());
    let mut i = 0;
    while i < tokens.len() {
        match tokens[i].text.as_str() {
            "mod" if is(&tokens, i + 2, "{") => modules.push(braces + 1),
            "{" => braces += 1,
            "}" => {
                modules.retain(|opened| *opened != braces);
                braces = braces.saturating_sub(1);
            }
            "crate" if is(&tokens, i + 1, "::") => found.extend(names(&tokens, i + 2)),
            "super" => {
                let mut climbed = 1;
                while is(&tokens, i + 1, "::") && is(&tokens, i + 2, "super") {
                    climbed += 1;
                    i += 2;
                }
                if climbed >= depth + modules.len() && is(&tokens, i + 1, "::") {
                    found.extend(names(&tokens, i + 2));
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
pub(super) fn imports(source: &str) -> Vec<Import> {
    let tokens = without_tests(&tokens(source));
    let (mut found, mut i) = (Vec::new(), 0);
    while i < tokens.len() {
        if tokens[i].text == "use" {
            let public = i > 0 && (tokens[i - 1].text == "pub" || tokens[i - 1].text == ")");
            i = leaves(&tokens, i + 1, &[], public, &mut found);
        } else if word(&tokens, i) && is(&tokens, i + 1, "::") && !(i > 0 && tokens[i - 1].text == "::") {
            let mut path = vec![tokens[i].text.clone()];
            while is(&tokens, i + 1, "::") && word(&tokens, i + 2) {
                path.push(tokens[i + 2].text.clone());
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
fn leaves(tokens: &[Token], from: usize, before: &[String], public: bool, found: &mut Vec<Import>) -> usize {
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
        if word(tokens, i) && (token.text != "self" || path.is_empty()) {
            path.push(token.text.clone());
        }
        i += 1;
        if !is(tokens, i, "::") {
            break;
        }
        i += 1;
    }
    let mut alias = path.last().cloned().unwrap_or_default();
    if is(tokens, i, "as") {
        alias = tokens.get(i + 1).map_or_else(String::new, |token| token.text.clone());
        i += 2;
    }
    found.push(Import { path, alias, in_use: true, public });
    // A `;` ends the statement, what else stands here belongs to the tree around this branch.
    i
}

fn word(tokens: &[Token], at: usize) -> bool {
    tokens.get(at).is_some_and(|t| t.text.starts_with(|c: char| c.is_alphabetic() || c == '_'))
}

/// The tokens outside of modules and other items that only tests are compiled with.
fn without_tests(tokens: &[Token]) -> Vec<Token> {
    let mut kept: Vec<Token> = Vec::new();
    let mut i = 0;
    while i < tokens.len() {
        let marked = ["#", "[", "cfg", "(", "test", ")", "]"];
        if !marked.iter().enumerate().all(|(k, text)| is(tokens, i + k, text)) {
            kept.push(Token { line: tokens[i].line, text: tokens[i].text.clone() });
            i += 1;
            continue;
        }
        let mut open = 0_usize;
        i += marked.len();
        while let Some(token) = tokens.get(i) {
            i += 1;
            match token.text.as_str() {
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
pub(super) fn after(source: &str, start: &str) -> Vec<(usize, String)> {
    let tokens = tokens(source);
    let starts = (0..tokens.len()).filter(|&i| tokens[i].text == start && is(&tokens, i + 1, "::"));
    starts.flat_map(|i| names(&tokens, i + 2)).collect()
}

fn is(tokens: &[Token], at: usize, text: &str) -> bool {
    tokens.get(at).is_some_and(|token| token.text == text)
}

/// The name at a place, or the first name of every branch of a `{a::b, c}`.
fn names(tokens: &[Token], at: usize) -> Vec<(usize, String)> {
    let Some(first) = tokens.get(at) else { return Vec::new() };
    if first.text != "{" {
        return vec![(first.line, first.text.clone())];
    }
    let (mut found, mut open, mut fresh) = (Vec::new(), 1, true);
    for token in &tokens[at + 1..] {
        match token.text.as_str() {
            "{" => open += 1,
            "}" => open -= 1,
            "," if open == 1 => fresh = true,
            name if fresh && open == 1 => {
                found.push((token.line, name.to_owned()));
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

/// Words, `::` and single signs; comments and literals are left out.
fn tokens(source: &str) -> Vec<Token> {
    let text: Vec<char> = source.chars().collect();
    let at = |i: usize| text.get(i).copied().unwrap_or('\0');
    let (mut found, mut line, mut i) = (Vec::new(), 1, 0);
    while i < text.len() {
        let start = i;
        let letter = |c: char| c.is_alphanumeric() || c == '_';
        match text[i] {
            '/' if at(i + 1) == '/' => i = skip(&text, i, &['\n']),
            '/' if at(i + 1) == '*' => i = after_comment(&text, i),
            '"' => i = after_string(&text, i),
            'r' if at(i + 1) == '"' || (at(i + 1) == '#' && matches!(at(i + 2), '#' | '"')) => {
                i = after_raw_string(&text, i + 1);
            }
            // A character, not a lifetime.
            '\'' if at(i + 1) == '\\' => i = skip(&text, i + 3, &['\'']) + 1,
            '\'' if at(i + 2) == '\'' => i += 3,
            c if letter(c) => {
                while letter(at(i)) {
                    i += 1;
                }
                found.push(Token { line, text: text[start..i].iter().collect() });
            }
            ':' if at(i + 1) == ':' => {
                found.push(Token { line, text: "::".into() });
                i += 2;
            }
            c => {
                if !c.is_whitespace() {
                    found.push(Token { line, text: c.into() });
                }
                i += 1;
            }
        }
        line += text[start..i.min(text.len())].iter().filter(|c| **c == '\n').count();
    }
    found
}

fn skip(text: &[char], from: usize, until: &[char]) -> usize {
    (from..text.len()).find(|&i| until.contains(&text[i])).unwrap_or(text.len())
}

fn after_comment(text: &[char], from: usize) -> usize {
    let (mut open, mut i) = (0, from);
    while i < text.len() {
        let pair = (text[i], text.get(i + 1).copied().unwrap_or('\0'));
        match pair {
            ('/', '*') => (open, i) = (open + 1, i + 2),
            ('*', '/') => (open, i) = (open - 1, i + 2),
            _ => i += 1,
        }
        if open == 0 {
            break;
        }
    }
    i
}

fn after_string(text: &[char], from: usize) -> usize {
    let mut i = from + 1;
    while i < text.len() && text[i] != '"' {
        i += if text[i] == '\\' { 2 } else { 1 };
    }
    i + 1
}

fn after_raw_string(text: &[char], from: usize) -> usize {
    let hashes = text[from..].iter().take_while(|c| **c == '#').count();
    let mut i = from + hashes + 1;
    while i < text.len() {
        let closes = text[i] == '"' && text[i + 1..].iter().take_while(|c| **c == '#').count() >= hashes;
        i += 1;
        if closes {
            return i + hashes;
        }
    }
    i
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rooms(source: &str, depth: usize) -> Vec<String> {
        from_root(source, depth).into_iter().map(|(_, name)| name).collect()
    }

    #[test]
    fn plain_grouped_and_inline_paths_are_seen_with_their_line() {
        let source =
            "use crate::math::tanh;\npub(crate) fn f() { crate::twin::g(); }\nuse crate::{a::{b, c}, d};";
        let found = from_root(source, 2);
        let expected = [(1, "math"), (2, "twin"), (3, "a"), (3, "d")];
        assert_eq!(found, expected.map(|(line, name)| (line, name.to_owned())));
    }

    #[test]
    fn enough_supers_reach_the_root_and_fewer_do_not() {
        assert_eq!(rooms("use super::super::control::X;", 2), ["control"]);
        assert!(rooms("use super::Sheath;", 2).is_empty());
        assert!(rooms("mod tests { use super::super::Sheath; }", 2).is_empty());
        assert_eq!(
            rooms("mod tests { use super::super::super::twin; } use super::super::body;", 2),
            ["twin", "body"]
        );
    }

    #[test]
    fn comments_strings_and_lifetimes_hide_nothing_and_show_nothing() {
        let hidden = "// crate::twin\n/* crate::twin /* nested */ crate::twin */ let a = \"crate::twin \\\" crate::twin\"; \
                      let b = r#\"crate::twin \" \"#; let c = '\"';";
        assert!(rooms(hidden, 1).is_empty());
        assert_eq!(
            rooms("fn f<'a>(x: &'a str, c: char) { if c == '\\'' || c == '{' { crate::seen::y(x) } }", 1),
            ["seen"]
        );
    }

    #[test]
    fn depth_counts_modules_below_the_root() {
        for (file, expected) in [("lib.rs", 0), ("math.rs", 1), ("twin/mod.rs", 1), ("twin/step.rs", 2)] {
            assert_eq!(depth(file), expected, "{file}");
        }
        assert_eq!(after("use std::{fs, vec::Vec};", "std").len(), 2);
    }
}
