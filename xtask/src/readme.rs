//! The README, the tutorials and the pages on exported models cannot go stale: their commands run, and the
//! pictures are what the program draws; the list of commands names the program's verbs and flags.

use crate::commands::{cargo, succeed, target};
use crate::{pictures, tree};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The page with which a reader begins, and the folder of those that follow.
const README: &str = "README.md";
const TUTORIALS: &str = "docs/tutorials";

/// The list of verbs and flags.
const COMMANDS: &str = "docs/commands.md";
/// Verbs that `--help` mentions in a sentence.
const HIDDEN: [&str; 2] = ["completions", "man"];

/// Pages whose commands go on with files of those before: each from where below `target/readme`, and its
/// name.
const FURTHER: [(&str, &[(&str, &str)]); 2] = [
    (
        "docs/export.md",
        &[("bench/bench/networks/model.json", "model.json"), ("bench/bench/simulated_day_5.csv", "LOG.csv")],
    ),
    (
        "docs/compensate.md",
        &[
            ("README/bench/cable/model.json", "cable/model.json"),
            ("README/bench/simulated_day_5.csv", "desired.csv"),
        ],
    ),
];

/// What stands before the blocks. `cargo run` of the program becomes the program that was just built, because
/// a release build would double the time; the test command is not started from inside itself; any other cargo
/// command fails, so that nothing is skipped unnoticed.
const PRELUDE: &str = r#"
cargo() {
  case "$*" in
    "run --release -p sinew-cli -- "*) shift 5; sinew "$@" ;;
    "xtask check") ;;
    *) echo "the check of the pages does not know how to run: cargo $*" >&2; return 1 ;;
  esac
}
"#;

/// A fenced block of a Markdown text.
#[derive(Debug, Clone, PartialEq)]
struct Block<'a> {
    /// Line of its first line of content, counted from 1.
    line: usize,
    language: &'a str,
    content: String,
}

/// Runs and compares.
pub(crate) fn check(root: &Path) -> Result<(), String> {
    let read = |name: &Path| {
        std::fs::read_to_string(root.join(name)).map_err(|e| format!("{}: {e}", name.display()))
    };
    let program = program(root)?;
    usage(&blocks(&read(Path::new(COMMANDS))?), &program)?;
    pictures::check(root, &program)?;
    let mut pages = tree::files(root)?;
    pages.retain(|page| page == Path::new(README) || page.starts_with(TUTORIALS));
    pages.iter().try_for_each(|page| run(root, page, &blocks(&read(page)?), &[], &program))?;
    FURTHER.iter().try_for_each(|(page, given)| {
        let text = read(Path::new(page))?;
        let commands = [blocks(&text), commands_in_tables(&text)].concat();
        run(root, Path::new(page), &commands, given, &program)
    })
}

/// Builds the program as the tests did, so that nothing is compiled a second time, and says where it is. The
/// programs of the fuzzer are not among it.
pub(crate) fn program(root: &Path) -> Result<PathBuf, String> {
    succeed(&mut cargo(
        root,
        &["build", "--quiet", "--workspace", "--all-features", "--bin", "sinew", "--tests"],
    ))?;
    Ok(target(root).join(format!("debug/sinew{}", std::env::consts::EXE_SUFFIX)))
}

/// Runs the `sh` blocks of a page one after another in a folder that holds the given files alone.
fn run(
    root: &Path,
    page: &Path,
    blocks: &[Block<'_>],
    given: &[(&str, &str)],
    program: &Path,
) -> Result<(), String> {
    let pages = root.join("target/readme");
    let folder = pages.join(page.file_stem().unwrap_or_default());
    let named = |path: &Path, e: std::io::Error| format!("{}: {e}", path.display());
    if folder.exists() {
        std::fs::remove_dir_all(&folder).map_err(|e| named(&folder, e))?;
    }
    std::fs::create_dir_all(&folder).map_err(|e| named(&folder, e))?;
    for (from, to) in given {
        let (from, to) = (pages.join(from), folder.join(to));
        std::fs::create_dir_all(to.parent().unwrap_or(&folder)).map_err(|e| named(&to, e))?;
        std::fs::copy(&from, to).map_err(|e| named(&from, e))?;
    }
    let mut places = vec![program.parent().unwrap_or(root).to_path_buf()];
    places.extend(std::env::split_paths(&std::env::var_os("PATH").unwrap_or_default()));
    let path = std::env::join_paths(places).map_err(|e| format!("PATH: {e}"))?;
    let shell: Vec<_> = blocks.iter().filter(|block| block.language == "sh").collect();
    if shell.is_empty() {
        return Err(format!("{}: no `sh` block", page.display()));
    }
    // One shell, so that a block begins where the one before it ended.
    let page = page.display();
    let named = |block: &&Block<'_>| format!("echo '{page}:{}' >&2\n{}", block.line, block.content);
    let script: String = std::iter::once(PRELUDE.to_owned()).chain(shell.iter().map(named)).collect();
    let mut command = Command::new("sh");
    command.args(["-eu", "-c", &script]).current_dir(&folder).env("PATH", &path).stdin(Stdio::null());
    let output = command.output().map_err(|e| format!("sh: {e}"))?;
    if !output.status.success() {
        let said = [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned());
        return Err(format!("{page}: ended with {}\n{}", output.status, said.concat()));
    }
    println!("{page}: {} blocks ran", shell.len());
    Ok(())
}

/// Compares the verbs and flags of the list of commands with what the program says of itself.
fn usage(blocks: &[Block<'_>], program: &Path) -> Result<(), String> {
    let written: String =
        blocks.iter().filter(|b| b.language == "text").map(|b| b.content.as_str()).collect();
    let help = |arguments: &[&str]| {
        let output = Command::new(program).args(arguments).output();
        let output = output.map_err(|e| format!("{}: {e}", program.display()))?;
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        if output.status.success() { Ok(text) } else { Err(format!("sinew {} failed", arguments.join(" "))) }
    };
    let mut verbs = verbs(&help(&["--help"])?);
    verbs.extend(HIDDEN.map(str::to_owned));
    let usages = usages(&written);
    let first = |verbs: &str| verbs.split(' ').next().unwrap_or_default().to_owned();
    let named: BTreeSet<String> = usages.iter().map(|(verb, _)| first(verb)).collect();
    differ("docs/commands.md names the verbs", &named, "the program has", &verbs)?;
    for (verb, flags) in &usages {
        let asked: Vec<&str> = verb.split(' ').chain(["--help"]).collect();
        let real = flags_in(&help(&asked)?);
        differ(&format!("{COMMANDS} gives `{verb}` the flags"), flags, "the program", &real)?;
    }
    Ok(())
}

fn differ(left: &str, a: &BTreeSet<String>, right: &str, b: &BTreeSet<String>) -> Result<(), String> {
    let spoken = |set: &BTreeSet<String>| set.iter().cloned().collect::<Vec<_>>().join(" ");
    if a == b { Ok(()) } else { Err(format!("{left} {}; {right} {}", spoken(a), spoken(b))) }
}

/// Every fenced block.
fn blocks(text: &str) -> Vec<Block<'_>> {
    let (mut found, mut open): (Vec<Block<'_>>, Option<Block<'_>>) = (Vec::new(), None);
    for (i, line) in text.lines().enumerate() {
        match (line.strip_prefix("```"), &mut open) {
            (Some(language), None) => {
                open = Some(Block { line: i + 2, language: language.trim(), content: String::new() });
            }
            (Some(_), Some(_)) => found.extend(open.take()),
            (None, Some(block)) => {
                block.content.push_str(line);
                block.content.push('\n');
            }
            (None, None) => {}
        }
    }
    found
}

/// The program's commands that stand as code in the tables of a page, as blocks.
fn commands_in_tables(text: &str) -> Vec<Block<'_>> {
    let rows = text.lines().enumerate().filter(|(_, line)| line.starts_with('|'));
    let spans = rows.flat_map(|(i, line)| line.split('`').skip(1).step_by(2).map(move |code| (i, code)));
    // A verb alone is spoken of.
    let commands =
        spans.filter(|(_, code)| code.starts_with("sinew ") && code.split_whitespace().count() > 2);
    commands.map(|(i, code)| Block { line: i + 1, language: "sh", content: format!("{code}\n") }).collect()
}

/// Verb, or verb and verb below it, and flags of every `sinew verb ...` of a usage text; an indented line
/// goes on with the one before.
fn usages(text: &str) -> Vec<(String, BTreeSet<String>)> {
    let mut found: Vec<(String, BTreeSet<String>)> = Vec::new();
    for line in text.lines() {
        if let Some(rest) = line.strip_prefix("sinew ") {
            let plain = |word: &&str| word.bytes().all(|b| b.is_ascii_lowercase());
            let verbs: Vec<&str> = rest.split_whitespace().take_while(plain).collect();
            found.push((verbs.join(" "), flags_in(line)));
        } else if let (true, Some((_, flags))) = (line.starts_with(' '), found.last_mut()) {
            flags.extend(flags_in(line));
        }
    }
    found
}

/// Flags of every verb, which the README explains once.
const COMMON: [&str; 4] = ["--help", "--version", "--json", "--no-clobber"];

/// Every `--flag` of a text, without those that every verb has.
fn flags_in(text: &str) -> BTreeSet<String> {
    let part = |c: char| c.is_ascii_alphanumeric() || c == '-';
    let words = text.split(|c: char| !part(c)).filter(|word| word.starts_with("--") && word.len() > 2);
    words.filter(|word| !COMMON.contains(word)).map(str::to_owned).collect()
}

/// The verbs in the groups of a help text.
fn verbs(help: &str) -> BTreeSet<String> {
    let groups = help.lines().skip_while(|line| !line.starts_with("Usage:"));
    let rows = groups.take_while(|line| !line.starts_with("Options:"));
    let first = rows.filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    first.filter_map(|line| Some(line.split_whitespace().next()?.to_owned())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_carry_their_language_and_line() {
        let found = blocks("a\n```sh\nx --y\n```\nb\n```text\nz\n```\n");
        let expected = [(3, "sh", "x --y\n"), (7, "text", "z\n")];
        let shown: Vec<_> = found.iter().map(|b| (b.line, b.language, b.content.as_str())).collect();
        assert_eq!(shown, expected);
    }

    #[test]
    fn commands_in_tables_carry_their_line() {
        let found =
            commands_in_tables("`sinew a --c`\n| C | `sinew b --c`<br>`make` | `sinew d` | `sinew e f` |\n");
        let shown: Vec<_> = found.iter().map(|b| (b.line, b.content.as_str())).collect();
        assert_eq!(shown, [(2, "sinew b --c\n"), (2, "sinew e f\n")]);
    }

    #[test]
    fn a_usage_goes_on_over_indented_lines() {
        let found = usages(
            "sinew identify LOG... --far COL [--time COL]\n    --out DIR\nsinew predict M --out FILE.csv\n\
             sinew machine body|convert M\nsinew bench run [--speeds V] --out LOG\n",
        );
        let flags = |k: usize| found[k].1.iter().map(String::as_str).collect::<Vec<_>>();
        assert_eq!((found[0].0.as_str(), flags(0)), ("identify", vec!["--far", "--out", "--time"]));
        assert_eq!((found[1].0.as_str(), flags(1)), ("predict", vec!["--out"]));
        assert_eq!((found[2].0.as_str(), flags(2)), ("machine", vec![]));
        assert_eq!((found[3].0.as_str(), flags(3)), ("bench run", vec!["--out", "--speeds"]));
    }

    #[test]
    fn verbs_and_flags_are_read_from_help() {
        let help = "Usage: sinew <COMMAND>\n\nIdentify:\n  identify  From logs\n            to a model\n\n\
                    Options:\n  -h, --help  Print\n      --seed  Of all\n";
        assert_eq!(verbs(help).into_iter().collect::<Vec<_>>(), ["identify"]);
        assert_eq!(flags_in(help).into_iter().collect::<Vec<_>>(), ["--seed"]);
    }
}
