//! A folder to work in, small logs, and the program.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tempfile::TempDir;

/// Samples of the logs made here.
pub(crate) const ROWS: usize = 600;

/// A folder with two days of a transmission, `a.csv` and `b.csv`.
pub(crate) struct Bench {
    folder: TempDir,
}

/// Exit code and output of a run of the program.
pub(crate) struct Outcome {
    pub(crate) code: Option<i32>,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl From<Output> for Outcome {
    /// Without the lines of progress, which a slow machine sees sooner than a fast one.
    fn from(output: Output) -> Self {
        let stderr = String::from_utf8(output.stderr).unwrap();
        Self {
            code: output.status.code(),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: stderr.split_inclusive('\n').filter(|line| !line.starts_with('[')).collect(),
        }
    }
}

impl Bench {
    pub(crate) fn new() -> Self {
        let bench = Self { folder: TempDir::new().unwrap() };
        bench.write("a.csv", log(0.4));
        bench.write("b.csv", log(0.53));
        bench
    }

    /// With a model of the two days in `out`.
    pub(crate) fn with_model() -> Self {
        let bench = Self::new();
        bench.succeeds("identify a.csv b.csv --model cell --out out");
        bench
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), content).unwrap();
    }

    pub(crate) fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.path(name)).unwrap()
    }

    /// The program in this folder; arguments are separated by blanks.
    pub(crate) fn command(&self, arguments: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_sinew"));
        command.args(arguments.split_whitespace()).current_dir(self.folder.path());
        command.env("TERM", "xterm-256color").env_remove("NO_COLOR");
        command
    }

    pub(crate) fn run(&self, arguments: &str) -> Outcome {
        self.command(arguments).output().unwrap().into()
    }

    #[track_caller]
    pub(crate) fn succeeds(&self, arguments: &str) -> Outcome {
        let outcome = self.run(arguments);
        assert_eq!(outcome.code, Some(0), "{arguments}: {}", outcome.stderr);
        assert_eq!(outcome.stderr, "", "{arguments}");
        outcome
    }

    /// One line of error with all of `parts`, the exit code of bad input, and the folder unchanged to the
    /// byte.
    #[track_caller]
    pub(crate) fn refuses(&self, arguments: &str, parts: &[&str]) {
        self.ends_with(BAD_INPUT, arguments, parts);
    }

    /// As [`refuses`](Self::refuses), with the exit code of a failing system.
    #[track_caller]
    pub(crate) fn fails(&self, arguments: &str, parts: &[&str]) {
        self.ends_with(SYSTEM, arguments, parts);
    }

    /// As [`refuses`](Self::refuses), with the exit code of a result that is not what was asked for.
    #[track_caller]
    pub(crate) fn declines(&self, arguments: &str, parts: &[&str]) {
        self.ends_with(NOT_AS_ASKED, arguments, parts);
    }

    #[track_caller]
    fn ends_with(&self, code: i32, arguments: &str, parts: &[&str]) {
        let before = self.content();
        let outcome = self.run(arguments);
        ended(code, arguments, &outcome, parts);
        assert!(self.content() == before, "{arguments}: left {:?}", self.names());
    }

    /// The command line is refused by its parser, with all of `parts` and a pointer to the help.
    #[track_caller]
    pub(crate) fn refuses_usage(&self, arguments: &str, parts: &[&str]) {
        let before = self.content();
        let Outcome { code, stdout, stderr } = self.run(arguments);
        assert_eq!(code, Some(BAD_INPUT), "{arguments}: {stdout}{stderr}");
        assert!(stdout.is_empty() && stderr.starts_with("error: ") && stderr.contains("--help"), "{stderr}");
        for part in parts {
            assert!(stderr.contains(part), "{arguments}: `{part}` is not in: {stderr}");
        }
        assert!(self.content() == before, "{arguments}: left {:?}", self.names());
    }

    /// Every folder and file here with its bytes; folders have none.
    pub(crate) fn content(&self) -> BTreeMap<PathBuf, Option<Vec<u8>>> {
        let mut content = BTreeMap::new();
        collect(self.folder.path(), &mut content);
        content
    }

    fn names(&self) -> Vec<PathBuf> {
        self.content().into_keys().collect()
    }

    /// Names of the files in a folder here.
    pub(crate) fn files(&self, folder: &str) -> Vec<String> {
        let entries = std::fs::read_dir(self.path(folder)).unwrap();
        let mut names: Vec<String> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }
}

fn collect(folder: &Path, content: &mut BTreeMap<PathBuf, Option<Vec<u8>>>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            collect(&path, content);
            content.insert(path, None);
        } else {
            let bytes = std::fs::read(&path).unwrap();
            content.insert(path, Some(bytes));
        }
    }
}

/// Exit codes.
pub(crate) const SYSTEM: i32 = 1;
pub(crate) const BAD_INPUT: i32 = 2;
pub(crate) const NOT_AS_ASKED: i32 = 3;

/// One line of error; standard output is empty, or the same error as a document, or what `identify` and
/// `adapt` say before they fit.
#[track_caller]
pub(crate) fn ended(expected: i32, what: &str, outcome: &Outcome, parts: &[&str]) {
    let Outcome { code, stdout, stderr } = outcome;
    assert_eq!(*code, Some(expected), "{what}: {stdout}{stderr}");
    if what.contains("--json") {
        let document: serde_json::Value = serde_json::from_str(stdout).unwrap();
        assert_eq!(document["exit_code"], expected, "{what}: {stdout}");
        assert_eq!(stderr.trim_end(), format!("error: {}", document["error"]["message"].as_str().unwrap()));
    } else {
        let fits = ["identify", "adapt"].iter().any(|verb| what.starts_with(verb));
        let account = fits && stdout.starts_with("log ");
        assert!(stdout.is_empty() || account, "{what}: {stdout}");
    }
    assert!(stderr.starts_with("error: ") && stderr.ends_with('\n'), "{what}: {stderr}");
    assert_eq!(stderr.lines().count(), 1, "{what}: {stderr}");
    for part in parts {
        assert!(stderr.contains(part), "{what}: `{part}` is not in: {stderr}");
    }
}

/// Capstan play of a cable at 50 Hz: time, near tension, far tension with a little noise.
pub(crate) fn samples(frequency_hz: f64) -> Vec<[f64; 3]> {
    let mut far = 56.0_f64;
    (0..ROWS)
        .map(|i| {
            let t = 0.02 * i as f64;
            let phase = std::f64::consts::TAU * frequency_hz * t;
            let near = 60.0 + 30.0 * phase.sin() + 12.0 * (2.3 * phase).sin();
            far = far.clamp(0.75 * near, 1.125 * near);
            [t, near, far + 0.05 * (12.9898 * i as f64).sin()]
        })
        .collect()
}

/// [`samples`] as CSV with canonical names.
pub(crate) fn log(frequency_hz: f64) -> String {
    let mut text = String::from("time_s,tension_in_n,tension_out_n\n");
    for [t, near, far] in samples(frequency_hz) {
        writeln!(text, "{t:.2},{near:.4},{far:.4}").unwrap();
    }
    text
}

/// A log whose line `number`, counted from 1, reads otherwise.
pub(crate) fn with_line(number: usize, line: &str) -> String {
    let text = log(0.4);
    let mut lines: Vec<&str> = text.lines().collect();
    lines[number - 1] = line;
    lines.join("\n") + "\n"
}
