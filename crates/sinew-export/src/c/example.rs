//! The program that runs a predictor over a log.

use super::literal;
use super::template::Filling;
use crate::{ExportedFile, Name};
use sinew::predictor::Model;

const EXAMPLE: &str = include_str!("templates/example.c");

/// `example.c`.
pub(super) fn file(model: &Model, name: &Name) -> ExportedFile {
    let mut filling = Filling::default();
    let time = model.time.as_deref().unwrap_or_default();
    let ends = |suffixes: &[&str]| suffixes.iter().any(|suffix| time.to_lowercase().ends_with(suffix));
    let scale = if ends(&["_ms"]) {
        "1e-3"
    } else if ends(&["_us"]) {
        "1e-6"
    } else {
        "1.0"
    };
    let columns = model.inputs.iter().map(|input| input.column.as_str());
    let columns = columns.chain([time, model.trial.as_deref().unwrap_or_default()]);
    let list: Vec<String> = columns.map(|column| format!("    {}", literal::string(column))).collect();
    let table = format!("static const char *const columns[COLUMNS] = {{\n{}\n}};\n", list.join(",\n"));
    filling.set("columns", table);
    filling.set("time_scale", scale);
    ExportedFile::text("example.c", filling.render(EXAMPLE, name))
}
