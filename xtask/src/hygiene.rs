//! What no compiler looks at: sizes, stubs, leftovers of a merge, paths of one person's machine.

use crate::tree;
use std::path::Path;

const MOST_LINES: usize = 800;
const MOST_BYTES: u64 = 1 << 20;

/// Third-party files, kept as they came.
const VENDORED: [&str; 1] = ["crates/sinew-view/assets/vendor/"];

/// Words that mark unfinished work or a slip; split so that this file passes its own check.
const STUBS: [&str; 5] = [
    concat!("TO", "DO"),
    concat!("FIX", "ME"),
    concat!("XX", "X"),
    concat!("todo", "!("),
    concat!("unimplemented", "!("),
];
const MERGE: [&str; 2] = [concat!("<<<<", "<<< "), concat!(">>>>", ">>> ")];
const PRIVATE: [&str; 4] =
    [concat!("/ho", "me/"), concat!("/ro", "ot/"), concat!("/Us", "ers/"), concat!("C:\\Us", "ers")];

/// Words of earlier versions and what replaced them, one pair a line.
const RETIRED: &str = include_str!("../retired_words.txt");
/// Where they may stand: their list, the history, and the attributes of another program's format.
const MAY_NAME_RETIRED: [&str; 3] =
    ["xtask/retired_words.txt", "CHANGELOG.md", "crates/sinew/src/description/mjcf/schema.txt"];

/// Pairs of a retired word and its replacement.
fn retired() -> impl Iterator<Item = (&'static str, &'static str)> {
    RETIRED.lines().filter(|line| !line.starts_with('#')).filter_map(|line| line.split_once(" = "))
}

/// Checks every file and reports all findings at once.
pub(crate) fn check(root: &Path) -> Result<(), String> {
    let mut findings = Vec::new();
    let files = tree::files(root)?;
    for file in &files {
        let name = file.to_string_lossy().replace('\\', "/");
        let place = root.join(file);
        let bytes = std::fs::metadata(&place).map_err(|e| format!("{name}: {e}"))?.len();
        if bytes > MOST_BYTES {
            findings.push(format!("{name}: {bytes} bytes, expected at most {MOST_BYTES}"));
            continue;
        }
        // What is not UTF-8 is not text: pictures and test fixtures.
        let content = std::fs::read(&place).map_err(|e| format!("{name}: {e}"))?;
        if let Ok(text) = String::from_utf8(content) {
            findings.extend(findings_in(&name, &text));
        }
    }
    if findings.is_empty() {
        println!("{} files", files.len());
        return Ok(());
    }
    Err(findings.join("\nerror: "))
}

/// What is wrong with a text file.
fn findings_in(name: &str, text: &str) -> Vec<String> {
    if VENDORED.iter().any(|folder| name.starts_with(folder)) {
        return Vec::new();
    }
    let mut findings = Vec::new();
    let lines = text.lines().count();
    if name.ends_with(".rs") && lines > MOST_LINES {
        findings.push(format!("{name}: {lines} lines, expected at most {MOST_LINES}"));
    }
    for (i, line) in text.lines().enumerate() {
        let mut report = |what: &str, found: &str| {
            findings.push(format!("{name}:{}: {what} `{}`", i + 1, found.trim()));
        };
        if let Some(stub) = STUBS.iter().find(|stub| has_word(line, stub)) {
            report("unfinished work", stub);
        }
        if let Some(marker) = MERGE.iter().find(|marker| line.starts_with(**marker)) {
            report("a merge left", marker);
        }
        if !MAY_NAME_RETIRED.contains(&name)
            && let Some((word, term)) = retired().find(|(word, _)| has_word(line, word))
        {
            report(&format!("a retired word, the term is `{term}`:"), word);
        }
        if let Some(path) = PRIVATE.iter().find(|path| line.contains(**path)) {
            report("a path of one machine", path);
        }
    }
    findings
}

/// Whether `word` stands in `line` and is not part of a longer word.
fn has_word(line: &str, word: &str) -> bool {
    let letter = |c: char| c.is_alphanumeric() || c == '_';
    line.match_indices(word).any(|(at, _)| {
        let before = line[..at].chars().next_back().is_some_and(letter);
        let after = line[at + word.len()..].chars().next().is_some_and(letter);
        !before && (word.ends_with('(') || !after)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stub_is_found_with_its_line_and_a_longer_word_is_not_one() {
        let stub = concat!("// TO", "DO: later");
        let found = findings_in("a.rs", &format!("fn f() {{}}\n{stub}\n"));
        assert_eq!(found.len(), 1);
        assert!(found[0].starts_with("a.rs:2:"), "{}", found[0]);
        assert!(findings_in("a.rs", "MASTODONS and XXXL").is_empty());
        assert_eq!(findings_in("a.rs", concat!("let x = todo", "!(\"x\");")).len(), 1);
    }

    #[test]
    fn too_many_lines_of_rust_are_found_and_of_text_are_not() {
        let long = "\n".repeat(MOST_LINES + 1);
        assert_eq!(findings_in("a.rs", &long).len(), 1);
        assert!(findings_in("a.csv", &long).is_empty());
        assert!(findings_in("a.rs", &"\n".repeat(MOST_LINES)).is_empty());
    }

    #[test]
    fn a_retired_word_is_refused_with_its_replacement_and_may_stand_in_the_list_itself() {
        let (word, term) = retired().next().unwrap();
        let found = findings_in("a.rs", &format!("struct {word};"));
        assert_eq!(found.len(), 1);
        assert!(found[0].contains(term), "{}", found[0]);
        assert!(findings_in("xtask/retired_words.txt", word).is_empty());
        assert!(retired().count() > 20);
    }

    #[test]
    fn leftovers_of_a_merge_and_private_paths_are_found() {
        assert_eq!(findings_in("a.md", concat!("<<<<", "<<< HEAD")).len(), 1);
        assert_eq!(findings_in("a.md", concat!("see /ho", "me/someone/x")).len(), 1);
    }
}
