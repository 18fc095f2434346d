//! What no compiler looks at: sizes, stubs, leftovers of a merge, paths of one person's machine.

use crate::commands::{installed, succeed};
use crate::tree;
use std::path::Path;
use std::process::Command;

const MAX_LINES: usize = 800;
/// Of a comment.
const MAX_COLUMNS: usize = 110;
const MAX_BYTES: u64 = 1 << 20;

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
fn retired() -> Vec<(&'static str, &'static str)> {
    RETIRED.lines().filter(|line| !line.starts_with('#')).filter_map(|line| line.split_once(" = ")).collect()
}

/// Checks every file and reports all findings at once.
pub(crate) fn check(root: &Path) -> Result<(), String> {
    let mut findings = Vec::new();
    let files = tree::files(root)?;
    let retired = retired();
    for file in &files {
        let name = file.to_string_lossy().replace('\\', "/");
        let place = root.join(file);
        let bytes = std::fs::metadata(&place).map_err(|e| format!("{name}: {e}"))?.len();
        if bytes > MAX_BYTES {
            findings.push(format!("{name}: {bytes} bytes, expected at most {MAX_BYTES}"));
            continue;
        }
        // What is not UTF-8 is not text: pictures and test fixtures.
        let content = std::fs::read(&place).map_err(|e| format!("{name}: {e}"))?;
        if let Ok(text) = String::from_utf8(content) {
            findings.extend(findings_in(&name, &text, &retired));
        }
    }
    if findings.is_empty() {
        println!("{} files", files.len());
        return spelling(root);
    }
    Err(findings.join("\nerror: "))
}

/// No misspelt word, by `typos.toml`.
fn spelling(root: &Path) -> Result<(), String> {
    if installed("typos") {
        return succeed(Command::new("typos").arg("--format=brief").current_dir(root));
    }
    println!("spelling: skipped, typos is not installed (cargo install typos-cli)");
    Ok(())
}

/// What is wrong with a text file, line by line.
fn findings_in(name: &str, text: &str, retired: &[(&str, &str)]) -> Vec<String> {
    if VENDORED.iter().any(|folder| name.starts_with(folder)) {
        return Vec::new();
    }
    let mut findings = Vec::new();
    let lines = text.lines().count();
    if name.ends_with(".rs") && lines > MAX_LINES {
        findings.push((0, format!("{name}: {lines} lines, expected at most {MAX_LINES}")));
    }
    if name.ends_with(".rs") {
        findings.extend(
            wide_comments(text)
                .map(|line| (line, format!("{name}:{line}: a comment of more than {MAX_COLUMNS} columns"))),
        );
    }
    let mut report = |what: &str, part: &str, is: fn(&str, usize, &str) -> bool| {
        // The whole text at once: to begin a search costs more than to go on with it.
        for (at, _) in text.match_indices(part).filter(|(at, _)| is(text, *at, part)) {
            let line = text[..at].matches('\n').count() + 1;
            findings.push((line, format!("{name}:{line}: {what} `{}`", part.trim())));
        }
    };
    STUBS.iter().for_each(|stub| report("unfinished work", stub, is_word));
    MERGE.iter().for_each(|marker| report("a merge left", marker, begins_line));
    PRIVATE.iter().for_each(|path| report("a path of one machine", path, |_, _, _| true));
    if !MAY_NAME_RETIRED.contains(&name) {
        for (word, term) in retired {
            report(&format!("a retired word, the term is `{term}`:"), word, is_word);
        }
    }
    findings.sort();
    findings.into_iter().map(|(_, finding)| finding).collect()
}

/// Lines of comments that are too wide; equations and examples in fences, and tables, may be.
fn wide_comments(text: &str) -> impl Iterator<Item = usize> {
    let mut fenced = false;
    text.lines().enumerate().filter_map(move |(number, line)| {
        let comment = line.trim_start().starts_with("//");
        fenced = comment && (fenced != line.contains("```"));
        let free = fenced || line.contains("```") || line.contains('|');
        (comment && !free && line.chars().count() > MAX_COLUMNS).then_some(number + 1)
    })
}

/// Whether what stands at a place is not part of a longer word.
fn is_word(text: &str, at: usize, word: &str) -> bool {
    let letter = |c: char| c.is_alphanumeric() || c == '_';
    let before = text[..at].chars().next_back().is_some_and(letter);
    let after = text[at + word.len()..].chars().next().is_some_and(letter);
    !before && (word.ends_with('(') || !after)
}

fn begins_line(text: &str, at: usize, _: &str) -> bool {
    at == 0 || text[..at].ends_with('\n')
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found_in(name: &str, text: &str) -> Vec<String> {
        findings_in(name, text, &retired())
    }

    #[test]
    fn a_stub_is_found_with_its_line_and_a_longer_word_is_not_one() {
        let stub = concat!("// TO", "DO: later");
        let found = found_in("a.rs", &format!("fn f() {{}}\n{stub}\n"));
        assert_eq!(found.len(), 1);
        assert!(found[0].starts_with("a.rs:2:"), "{}", found[0]);
        assert!(found_in("a.rs", "MASTODONS and XXXL").is_empty());
        assert_eq!(found_in("a.rs", concat!("let x = todo", "!(\"x\");")).len(), 1);
    }

    #[test]
    fn too_many_lines_of_rust_are_found_and_of_text_are_not() {
        let long = "\n".repeat(MAX_LINES + 1);
        assert_eq!(found_in("a.rs", &long).len(), 1);
        assert!(found_in("a.csv", &long).is_empty());
        assert!(found_in("a.rs", &"\n".repeat(MAX_LINES)).is_empty());
    }

    #[test]
    fn a_retired_word_is_refused_with_its_replacement_and_may_stand_in_the_list_itself() {
        let (word, term) = retired()[0];
        let found = found_in("a.rs", &format!("struct {word};"));
        assert_eq!(found.len(), 1);
        assert!(found[0].contains(term), "{}", found[0]);
        assert!(found_in("xtask/retired_words.txt", word).is_empty());
        assert!(retired().len() > 20);
    }

    #[test]
    fn a_wide_comment_is_found_and_an_equation_in_a_fence_is_not() {
        let wide = format!("/// {}", "word ".repeat(25));
        assert_eq!(
            found_in("a.rs", &format!("{wide}\nfn f() {{}}")),
            ["a.rs:1: a comment of more than 110 columns"]
        );
        assert!(found_in("a.rs", &format!("/// ```text\n{wide}\n/// ```\nfn f() {{}}")).is_empty());
    }

    #[test]
    fn leftovers_of_a_merge_and_private_paths_are_found() {
        assert_eq!(found_in("a.md", concat!("<<<<", "<<< HEAD")).len(), 1);
        assert_eq!(found_in("a.md", concat!("see /ho", "me/someone/x")).len(), 1);
    }
}
