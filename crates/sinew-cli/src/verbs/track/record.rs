//! A run as a table.

use crate::csv_text::Csv;
use crate::error::Error;
use sinew_lab::arm::TraceRow;

/// CSV, one row per sample; columns are named after the muscles.
pub(super) fn csv(muscles: &[String], trace: &[TraceRow]) -> Result<String, Error> {
    let mut table = Csv::new();
    table.row(header(muscles))?;
    for row in trace {
        let lengths =
            row.wanted_m.iter().chain(&row.end_point_m).chain(&row.length_m).chain(&row.length_error_m);
        let tensions = row.wanted_n.iter().chain(&row.anchor_n).chain(&row.drive_n);
        let repeat = row.repeat.map_or(String::new(), |repeat| repeat.to_string());
        let cells = [format!("{:.3}", row.time_s), repeat].into_iter();
        let cells = cells.chain(lengths.map(|length| format!("{length:.7}")));
        table.row(cells.chain(tensions.map(|tension| format!("{tension:.3}"))))?;
    }
    Ok("# SIMULATED by sinew track\n".to_owned() + &table.text()?)
}

fn header(muscles: &[String]) -> Vec<String> {
    let mut header = vec!["time_s".to_owned(), "repeat".to_owned()];
    for quantity in ["wanted", "end_point"] {
        header.extend(["x", "y", "z"].map(|axis| format!("{quantity}_{axis}_m")));
    }
    for quantity in ["length_m", "length_error_m", "wanted_n", "anchor_n", "drive_n"] {
        header.extend(muscles.iter().map(|muscle| format!("{quantity}:{muscle}")));
    }
    header
}
