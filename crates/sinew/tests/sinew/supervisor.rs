//! The documentation of the supervisor is that of its tables; a machine is operated by the rules of its page.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

mod bench;
mod control;
mod limits;
mod modes;
mod pretension;
mod reports;

use sinew::control::supervisor::{FaultKind, transitions_markdown};
use sinew::machine::SafetyLimits;

const BEGIN: &str = "<!-- transitions -->\n";
const END: &str = "<!-- end of transitions -->";

fn page() -> (std::path::PathBuf, String) {
    let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/supervisor.md");
    let text = std::fs::read_to_string(&file).unwrap();
    (file, text)
}

#[test]
fn the_documented_transitions_are_those_of_the_table() {
    // `SINEW_WRITE_DOCS=1` writes them.
    let (file, text) = page();
    let (before, rest) = text.split_once(BEGIN).unwrap();
    let (written, after) = rest.split_once(END).unwrap();
    let expected = format!("\n{}\n", transitions_markdown());
    if std::env::var_os("SINEW_WRITE_DOCS").is_some() {
        std::fs::write(file, format!("{before}{BEGIN}{expected}{END}{after}")).unwrap();
        return;
    }
    assert_eq!(written, expected, "SINEW_WRITE_DOCS=1 writes the table anew");
}

#[test]
fn every_fault_and_every_limit_is_documented() {
    let text = page().1;
    for kind in FaultKind::ALL {
        assert!(text.contains(&format!("`{}`", kind.name())), "{}", kind.name());
    }
    let limits = serde_json::to_value(SafetyLimits::default()).unwrap();
    for key in limits.as_object().unwrap().keys() {
        assert!(text.contains(&format!("`{key}`")), "{key}");
    }
}
