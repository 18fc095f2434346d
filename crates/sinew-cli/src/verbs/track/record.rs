//! A run as a table that other tools open.

use sinew_lab::arm::TraceRow;
use std::fmt::Write;

/// CSV, a row per sample; columns named after muscles. Writing into a string cannot fail.
pub(super) fn csv(names: &[String], trace: &[TraceRow]) -> String {
    let mut text = String::from("# SIMULATED by sinew track\ntime_s,repeat");
    for what in ["wanted", "end_point"] {
        for axis in ["x", "y", "z"] {
            let _ = write!(text, ",{what}_{axis}_m");
        }
    }
    for what in ["length_m", "length_error_m", "wanted_n", "anchor_n", "drive_n"] {
        for name in names {
            let _ = write!(text, ",{what}:{name}");
        }
    }
    text.push('\n');
    for row in trace {
        let _ = write!(
            text,
            "{:.3},{}",
            row.time_s,
            row.repeat.map_or(String::new(), |repeat| repeat.to_string())
        );
        for value in
            row.wanted_m.iter().chain(&row.end_point_m).chain(&row.length_m).chain(&row.length_error_m)
        {
            let _ = write!(text, ",{value:.7}");
        }
        for value in row.wanted_n.iter().chain(&row.anchor_n).chain(&row.drive_n) {
            let _ = write!(text, ",{value:.3}");
        }
        text.push('\n');
    }
    text
}
