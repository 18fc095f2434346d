//! The book: `docs/` and the texts of the root as one set of pages, by `docs/SUMMARY.md`.

use crate::commands::{installed, succeed};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Its chapters, whose links are relative to `docs`.
const SUMMARY: &str = "docs/SUMMARY.md";
const FOLDER: &str = "target/book";
/// Of every page but those in which one looks something up.
const MAX_WORDS: usize = 1500;
const REFERENCE: [&str; 5] = ["api", "commands", "json", "link", "recording"];
/// Of the README.
const MAX_README: usize = 900;

/// Every link leads to a file and a heading, every page is a chapter, none but the reference is too long;
/// then the book itself where mdBook is installed.
pub(crate) fn check(root: &Path) -> Result<(), String> {
    let pages = pages(root)?;
    let mut wrong = Vec::new();
    for page in &pages {
        let text = read(root, page)?;
        wrong.extend(dead_links(root, page, &text));
        // Not counted: the bars of tables, signs of equations.
        let words = text.split_whitespace().filter(|word| word.contains(char::is_alphanumeric)).count();
        let most = if page == Path::new("README.md") { MAX_README } else { MAX_WORDS };
        let looked_up = page.file_stem().is_some_and(|stem| REFERENCE.iter().any(|name| stem == *name));
        let counted = page == Path::new("README.md") || (page.starts_with("docs") && !looked_up);
        if counted && words > most {
            wrong.push(format!("{}: {words} words, expected at most {most}", page.display()));
        }
    }
    let summary = read(root, Path::new(SUMMARY))?;
    let chapters: BTreeSet<PathBuf> =
        links(&summary).map(|(_, target, _)| plain(&Path::new("docs").join(target))).collect();
    let missing = pages.iter().filter(|page| page.starts_with("docs") && *page != Path::new(SUMMARY));
    wrong.extend(
        missing
            .filter(|page| !chapters.contains(*page))
            .map(|page| format!("{SUMMARY}: {} is no chapter", page.display())),
    );
    if wrong.is_empty() { make(root) } else { Err(wrong.join("\nerror: ")) }
}

/// Builds the book, or says that it was skipped.
pub(crate) fn make(root: &Path) -> Result<(), String> {
    if !installed("mdbook") {
        println!("the book itself: skipped, mdbook is not installed (cargo install mdbook)");
        return Ok(());
    }
    // As in the repository, so that every link holds on both.
    let source = root.join(FOLDER).join("src");
    let failed = |e: std::io::Error| format!("{}: {e}", source.display());
    if source.exists() {
        std::fs::remove_dir_all(&source).map_err(failed)?;
    }
    let pages = pages(root)?;
    let mut files: BTreeSet<PathBuf> = pages.iter().cloned().collect();
    for page in &pages {
        let folder = page.parent().unwrap_or(Path::new(""));
        files.extend(links(&read(root, page)?).map(|(_, target, _)| plain(&folder.join(target))));
    }
    for file in files.iter().filter(|file| root.join(file).is_file()) {
        let copy = source.join(file);
        std::fs::create_dir_all(copy.parent().unwrap_or(&source)).map_err(failed)?;
        std::fs::copy(root.join(file), &copy).map_err(failed)?;
    }
    let summary = read(root, Path::new(SUMMARY))?.replace("](", "](docs/").replace("](docs/../", "](");
    std::fs::write(source.join("SUMMARY.md"), summary).map_err(failed)?;
    std::fs::copy(root.join("docs/book.toml"), root.join(FOLDER).join("book.toml")).map_err(failed)?;
    succeed(Command::new("mdbook").arg("build").arg(root.join(FOLDER)))?;
    println!("{} pages: {FOLDER}/book/index.html", pages.len());
    Ok(())
}

/// The texts of the root and of `docs`, sorted.
fn pages(root: &Path) -> Result<Vec<PathBuf>, String> {
    let mut files = crate::tree::files(root)?;
    let placed = |file: &Path| file.starts_with("docs") || file.parent() == Some(Path::new(""));
    files.retain(|file| placed(file) && file.extension().is_some_and(|end| end == "md"));
    Ok(files)
}

fn read(root: &Path, page: &Path) -> Result<String, String> {
    std::fs::read_to_string(root.join(page)).map_err(|e| format!("{}: {e}", page.display()))
}

fn dead_links(root: &Path, page: &Path, text: &str) -> Vec<String> {
    let folder = page.parent().unwrap_or(Path::new(""));
    let dead = |(line, target, heading): (usize, &str, &str)| {
        let file = if target.is_empty() { page.to_owned() } else { plain(&folder.join(target)) };
        let place = root.join(&file);
        let headed = || read(root, &file).is_ok_and(|text| anchors(&text).contains(heading));
        let lives = place.exists() && (heading.is_empty() || headed());
        (!lives).then(|| format!("{}:{line}: `{target}#{heading}` does not exist", page.display()))
    };
    links(text).filter_map(dead).collect()
}

/// Relative links outside of code, with their line, file and heading.
fn links(text: &str) -> impl Iterator<Item = (usize, &str, &str)> {
    let all = prose(text).flat_map(|(i, line)| {
        let written = line.split("](").skip(1).map(|rest| rest.split(')').next().unwrap_or(""));
        let drawn = line.split("src=\"").skip(1).map(|rest| rest.split('"').next().unwrap_or(""));
        written.chain(drawn).map(move |target| (i, target)).collect::<Vec<_>>()
    });
    let inner = all.filter(|(_, target)| !target.is_empty() && !target.contains("://"));
    inner.map(|(line, target)| {
        let (file, heading) = target.split_once('#').unwrap_or((target, ""));
        (line, file, heading)
    })
}

/// Lines outside of fenced blocks, counted from 1.
fn prose(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut fenced = false;
    text.lines().enumerate().filter_map(move |(i, line)| {
        let fence = line.starts_with("```");
        fenced ^= fence;
        (!fenced && !fence).then_some((i + 1, line))
    })
}

/// What headings are called in links.
fn anchors(text: &str) -> BTreeSet<String> {
    let headings = prose(text).filter(|(_, line)| line.starts_with('#'));
    let letters = |line: &str| {
        let kept = |c: &char| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_');
        line.trim_start_matches('#').trim().to_lowercase().chars().filter(kept).collect::<String>()
    };
    headings.map(|(_, line)| letters(line).replace(' ', "-")).collect()
}

/// A path without its `..`.
fn plain(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in path.components() {
        if part.as_os_str() != ".." {
            plain.push(part);
        } else if !plain.pop() {
            return path.to_owned();
        }
    }
    plain
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn relative_links_are_found_and_code_and_the_web_are_left_alone() {
        let text = "![p](d/p.svg) [w](https://example.org/x)\n```c\na[0](x)\n```\n[s](A.md#part) [h](#here)";
        let found: Vec<_> = links(text).collect();
        assert_eq!(found, [(1, "d/p.svg", ""), (5, "A.md", "part"), (5, "", "here")]);
    }

    #[test]
    fn a_link_to_no_file_or_no_heading_is_named_with_its_line() {
        let root = crate::tree::root();
        let text =
            "# A Title, here\n[a](../README.md) [b](../NONE.md)\n[c](#a-title-here) [d](../README.md#none)";
        let dead = dead_links(&root, Path::new("docs/x.md"), text);
        assert_eq!(dead.len(), 3, "{dead:?}");
        assert!(dead[0].starts_with("docs/x.md:2: `../NONE.md#`"), "{dead:?}");
        assert!(anchors("# A Title, here").contains("a-title-here"));
        assert_eq!(plain(Path::new("docs/../a/./b.md")), Path::new("a/b.md"));
    }
}
