//! A C compiler, where there is one, and programs compiled by it.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

/// All warnings that the project holds its C against, as errors.
pub(crate) const STRICT: [&str; 6] =
    ["-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-Wpedantic", "-Werror"];

/// Languages and optimisations that must give the same bits.
pub(crate) const MODES: [&[&str]; 5] = [
    &["-std=c99", "-O2", "-Wundef"],
    &["-std=gnu11", "-O3", "-march=native"],
    &["-std=gnu99", "-O2", "-march=native"],
    &["-std=c99", "-O0", "-Wcast-qual"],
    &["-std=c99", "-O1", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"],
];

/// The compilers of this machine; says so where there is none.
pub(crate) fn compilers() -> Vec<&'static str> {
    let works = |name: &&str| Command::new(name).arg("--version").output().is_ok_and(|o| o.status.success());
    let found: Vec<_> = ["cc", "clang"].into_iter().filter(works).collect();
    if found.is_empty() {
        println!("skipped: no C compiler on this machine");
    }
    found
}

/// A compiler with its mode.
pub(crate) type Build = (&'static str, &'static [&'static str]);

/// All compilers in all modes.
pub(crate) fn builds() -> Vec<Build> {
    MODES.into_iter().flat_map(|mode| compilers().into_iter().map(move |compiler| (compiler, mode))).collect()
}

/// One of some, in rotation: in short tests, as compilers take longer than what they have compiled. None of
/// none.
pub(crate) fn one_in_turn<T>(all: Vec<T>, turn: usize) -> Vec<T> {
    let count = all.len().max(1);
    all.into_iter().skip(turn % count).take(1).collect()
}

/// Compiles sources in a folder to `program`; panics with what the compiler says. Sanitizers that it cannot
/// link are left out, with a message.
pub(crate) fn compile(compiler: &str, folder: &Path, sources: &[&str], flags: &[&str]) {
    let (sanitizers, others): (Vec<&str>, Vec<&str>) =
        flags.iter().partition(|flag| flag.contains("sanitize"));
    let linked = sanitizers.is_empty() || links(compiler, folder, &sanitizers);
    if !linked {
        println!("skipped: {compiler} cannot link its sanitizers on this machine");
    }
    let flags = if linked { flags } else { &others };
    let mut command = Command::new(compiler);
    command.current_dir(folder).args(STRICT).args(flags).args(sources).args(["-o", "program", "-lm"]);
    let output = command.output().unwrap();
    assert!(
        output.status.success(),
        "{compiler} {flags:?}: {}",
        String::from_utf8_lossy(&output.stderr).chars().take(3000).collect::<String>()
    );
}

fn links(compiler: &str, folder: &Path, flags: &[&str]) -> bool {
    std::fs::write(folder.join("empty.c"), "int main(void) { return 0; }\n").unwrap();
    let mut command = Command::new(compiler);
    command.current_dir(folder).args(flags).args(["empty.c", "-o", "empty"]);
    command.output().is_ok_and(|output| output.status.success())
}

/// Runs `program` with input; returns its output.
pub(crate) fn run(folder: &Path, input: &[u8], arguments: &[&str]) -> Vec<u8> {
    let mut command = Command::new(folder.join("program"));
    command.args(arguments);
    run_program(command, input)
}

/// Runs a program with input; returns its output.
pub(crate) fn run_program(mut command: Command, input: &[u8]) -> Vec<u8> {
    let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    let mut pipe = child.stdin.take().unwrap();
    let bytes = input.to_vec();
    let writer = std::thread::spawn(move || {
        let _ = pipe.write_all(&bytes);
    });
    let output = child.wait_with_output().unwrap();
    writer.join().unwrap();
    assert!(output.status.success(), "{:?}", output.status);
    output.stdout
}

/// Rows of numbers that a program has written, bit by bit.
pub(crate) fn rows_of<const N: usize>(bytes: &[u8]) -> Vec<[u64; N]> {
    let (numbers, rest) = bytes.as_chunks::<8>();
    assert!(rest.is_empty() && numbers.len().is_multiple_of(N), "{} bytes", bytes.len());
    numbers.chunks_exact(N).map(|row| std::array::from_fn(|k| u64::from_ne_bytes(row[k]))).collect()
}

/// The first row in which two lists differ, with both as numbers.
pub(crate) fn first_difference<const N: usize>(
    got: &[[u64; N]],
    expected: &[[u64; N]],
) -> Option<(usize, [f64; N], [f64; N])> {
    assert_eq!(got.len(), expected.len());
    let row = got.iter().zip(expected).position(|(got, expected)| got != expected)?;
    Some((row, got[row].map(f64::from_bits), expected[row].map(f64::from_bits)))
}

/// Lines that a program compiled with `--coverage` has executed, and all lines of the source; none without
/// gcov.
pub(crate) fn covered(folder: &Path, source: &str) -> Option<(f64, f64)> {
    let object = format!("program-{source}");
    let output = Command::new("gcov").current_dir(folder).args(["-n", &object]).output().ok()?;
    let text = String::from_utf8(output.stdout).unwrap();
    let line = text.lines().find_map(|line| line.strip_prefix("Lines executed:"))?;
    let (percent, total) = line.split_once("% of ")?;
    let total: f64 = total.parse().ok()?;
    Some((0.01 * percent.parse::<f64>().ok()? * total, total))
}
