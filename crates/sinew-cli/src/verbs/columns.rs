//! The columns of the logs with their roles, for the terminal.

use crate::output::one_line;
use crate::table::{number, table};
use sinew_identify::log::{ColumnUse, Dataset};

/// Logs and columns of a dataset: what was read, and what every column is used for.
pub(super) fn account(data: &Dataset) -> String {
    let mut text = logs(data);
    text.push('\n');
    // A model fixes the roles of its logs.
    if !data.columns.is_empty() {
        text += &columns(&data.columns);
    }
    text + &findings(data)
}

/// What was noticed in the logs, a line each, where anything was.
pub(super) fn findings(data: &Dataset) -> String {
    noticed(data).map(|(log, finding)| format!("{}: {}\n", one_line(log), one_line(finding))).collect()
}

/// The same for programs.
pub(super) fn findings_json(data: &Dataset) -> serde_json::Value {
    noticed(data).map(|(log, sentence)| serde_json::json!({ "log": log, "sentence": sentence })).collect()
}

/// Every log's name with a finding.
fn noticed(data: &Dataset) -> impl Iterator<Item = (&str, &str)> {
    data.logs.iter().flat_map(|log| log.findings.iter().map(|finding| (log.name.as_str(), finding.as_str())))
}

fn logs(data: &Dataset) -> String {
    let row = |log: &sinew_identify::log::LogInfo| {
        let counts = [log.samples, log.trials].map(|count| count.to_string());
        let times = [log.duration_s, 1e3 * log.interval_s].map(|time| number(Some(time)));
        [one_line(&log.name)].into_iter().chain(counts).chain(times).collect()
    };
    let rows: Vec<Vec<String>> = data.logs.iter().map(row).collect();
    table(&["log", "samples", "trials", "duration, s", "interval, ms"], &rows, 1)
}

fn columns(columns: &[ColumnUse]) -> String {
    let row = |column: &ColumnUse| {
        let role = column.role.map_or_else(|| "not used".to_owned(), |role| role.to_string());
        let unit = if column.unit.is_empty() { "-" } else { &column.unit };
        vec![one_line(&column.column), role, one_line(unit), one_line(&column.reason)]
    };
    let rows: Vec<Vec<String>> = columns.iter().map(row).collect();
    table(&["column", "role", "unit", "why"], &rows, 4)
        + "A role is set by --far, --effort, --motion, --anchor, --given, --time, --trial, --group; \
            --ignore excludes a column.\n\
           One of --effort, --motion, --anchor, --given replaces all inputs that were taken by name.\n"
}
