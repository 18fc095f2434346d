//! The project's own checks: `cargo xtask check` is the test command.
#![expect(clippy::print_stdout, reason = "a program for people at a terminal and for CI logs")]

mod book;
mod check;
mod commands;
mod hygiene;
mod layering;
mod page;
mod pictures;
mod python;
mod readme;
mod release;
mod targets;
mod tree;

use std::process::ExitCode;

const HELP: &str = "\
The project's own checks.

usage: cargo xtask check [STEP...]     run every step, or only those named, in the order of the list
       cargo xtask check long          the statistical tests over many seeds
       cargo xtask check python        the Python package, where Python 3.11 and pip are there
       cargo xtask check batch         long tests of MJX and MuJoCo Warp, with old and new versions
       cargo xtask check page          the live page in a headless Chromium, where there is one
       cargo xtask check --list        the steps and what each is for
       cargo xtask book                docs/ as a book of HTML, by mdbook
       cargo xtask wheel               the Python package for Linux on x86-64, tried when installed
       cargo xtask archive             the program for Linux on x86-64, tried when unpacked
       cargo xtask pictures            draw the machines of models/ anew, into docs/machines
       cargo xtask --help              this text

The first step that fails ends the run with exit code 1; exit code 2 means the command was not understood.
While working, one step is quick:

       cargo xtask check fmt clippy
       cargo xtask check readme";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match words.as_slice() {
        [] | ["help" | "--help" | "-h"] | ["check", "--help" | "-h"] => {
            println!("{HELP}");
            ExitCode::SUCCESS
        }
        ["check", "--list"] => {
            println!("{}", check::list());
            ExitCode::SUCCESS
        }
        ["book"] => made(book::make(&tree::root())),
        ["wheel"] => made(release::wheel(&tree::root())),
        ["archive"] => made(release::archive(&tree::root())),
        ["pictures"] => made(pictures::make(&tree::root())),
        ["check", names @ ..] => check::run(names).unwrap_or_else(|message| misunderstood(&message)),
        [other, ..] => misunderstood(&format!(
            "`{other}` is not a command; expected `check`, `book`, `wheel`, `archive` or `pictures`"
        )),
    }
}

fn made(outcome: Result<(), String>) -> ExitCode {
    let Err(message) = outcome else { return ExitCode::SUCCESS };
    eprintln!("error: {message}");
    ExitCode::FAILURE
}

fn misunderstood(message: &str) -> ExitCode {
    eprintln!("error: {message}; see `cargo xtask --help`");
    ExitCode::from(2)
}
