//! The documentation of the supervisor is that of its tables; a machine is operated by the rules of its page.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

mod bench;
mod control;
mod limits;
mod modes;
mod pretension;
mod reports;

use sinew::control::supervisor::{FaultKind, fault_codes_markdown, transitions_markdown};
use sinew::machine::SafetyLimits;

fn page(name: &str) -> (std::path::PathBuf, String) {
    let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs").join(name);
    let text = std::fs::read_to_string(&file).unwrap();
    (file, text)
}

/// Holds what stands between two marks of a page against a table of the code; `SINEW_WRITE_DOCS=1` writes it.
fn hold(name: &str, [begin, end]: [&str; 2], table: &str) {
    let (file, text) = page(name);
    let (before, rest) = text.split_once(begin).unwrap();
    let (written, after) = rest.split_once(end).unwrap();
    let expected = format!("\n\n{table}\n");
    if std::env::var_os("SINEW_WRITE_DOCS").is_some() {
        std::fs::write(file, format!("{before}{begin}{expected}{end}{after}")).unwrap();
        return;
    }
    assert_eq!(written, expected, "SINEW_WRITE_DOCS=1 writes the table anew");
}

#[test]
fn the_documented_transitions_are_those_of_the_table() {
    let marks = ["<!-- transitions -->", "<!-- end of transitions -->"];
    hold("supervisor.md", marks, &transitions_markdown());
}

#[test]
fn the_documented_codes_of_faults_are_those_of_link_recording_and_page() {
    hold("link.md", ["<!-- faults: begin -->", "<!-- faults: end -->"], &fault_codes_markdown());
}

#[test]
fn every_fault_and_every_limit_is_documented() {
    let text = page("supervisor.md").1 + &page("faults.md").1 + &page("health.md").1;
    for kind in FaultKind::ALL {
        assert!(text.contains(&format!("`{}`", kind.name())), "{}", kind.name());
    }
    let limits = serde_json::to_value(SafetyLimits::default()).unwrap();
    for key in limits.as_object().unwrap().keys() {
        assert!(text.contains(&format!("`{key}`")), "{key}");
    }
}
