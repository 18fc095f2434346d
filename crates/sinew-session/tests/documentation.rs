//! docs/recording.md contains the table of signals.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

use sinew_session::signals::{Axis, Kind, Resolution, Signal};
use std::fmt::Write;

const BEGIN: &str = "<!-- table of signals: begin -->\n";
const END: &str = "<!-- table of signals: end -->";

fn table() -> String {
    let mut text =
        "| column | unit | from | kept | every | meaning |\n|---|---|---|---|---|---|\n".to_owned();
    for signal in Signal::ALL {
        let row = signal.row();
        let part = ["", "JOINT", "MUSCLE"][row.axis as usize];
        let unit = if row.axis == Axis::Joint { "rad" } else { "" };
        let from = match row.kind {
            Kind::State => "cycle",
            Kind::Measured => "measured",
            Kind::Estimated => "estimated",
            Kind::Reference => "reference",
            Kind::Command => "command",
            Kind::Truth => "simulation",
        };
        let kept = match row.resolution {
            Resolution::Exact => "exact".to_owned(),
            Resolution::Rounded(resolution) => resolution.to_string(),
        };
        let every = if row.slow { "20" } else { "1" };
        let column = signal.column(part, unit);
        writeln!(text, "| `{column}` | {} | {from} | {kept} | {every} | {} |", row.unit, row.about).unwrap();
    }
    text
}

/// Writes the table where `SINEW_SIGNALS_WRITE` is set.
#[test]
fn the_table_of_the_documentation_is_that_of_the_code() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/recording.md");
    let page = std::fs::read_to_string(path).unwrap();
    let (before, rest) = page.split_once(BEGIN).expect("the mark before the table");
    let (written, after) = rest.split_once(END).expect("the mark after the table");
    if std::env::var_os("SINEW_SIGNALS_WRITE").is_some() {
        std::fs::write(path, format!("{before}{BEGIN}\n{}\n{END}{after}", table())).unwrap();
        return;
    }
    assert_eq!(written.trim(), table().trim(), "run this test with SINEW_SIGNALS_WRITE=1");
}
