//! The program that runs a predictor over a log.

use super::content::Content;
use super::literal;
use super::template::Filling;
use crate::{ExportedFile, Name};
use sinew::predictor::Model;

const EXAMPLE: &str = include_str!("templates/example.c");

/// `example.c`.
pub(super) fn file(model: &Model, name: &Name, content: Content) -> ExportedFile {
    let mut filling = Filling::default();
    let time = model.time.as_deref().unwrap_or_default();
    // `t_ms`, `Zeit [ms]`: the last word.
    let name_of_time = time.to_lowercase();
    let mut words = name_of_time.rsplit(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty());
    let [scale, per_second] = match words.next().unwrap_or_default() {
        "ms" | "msec" | "millis" | "milliseconds" => ["1e-3", "1e3"],
        "us" | "\u{b5}s" | "\u{3bc}s" | "usec" | "micros" | "microseconds" => ["1e-6", "1e6"],
        "ns" | "nsec" => ["1e-9", "1e9"],
        _ => ["1.0", "1.0"],
    };
    let columns = model.inputs.iter().map(|input| input.column.as_str());
    let columns = columns.chain([time, model.trial.as_deref().unwrap_or_default(), &model.far]);
    let units = columns.clone().map(|column| match column {
        _ if column == time && scale == "1.0" => "s",
        _ => model.units.get(column).map_or("", String::as_str),
    });
    let table = |name: &str, texts: &mut dyn Iterator<Item = &str>| {
        let list: Vec<String> = texts.map(|text| format!("    {}", literal::string(text))).collect();
        format!("static const char *const {name}[COLUMNS] = {{\n{}\n}};\n", list.join(",\n"))
    };
    let tables = table("columns", &mut columns.clone()) + &table("units", &mut units.into_iter());
    filling.set("columns", tables);
    filling.set("time_scale", scale);
    if let Content::Compensator(settings) = content {
        // Of a cable the near tension may be missing beside the command.
        let tension = model.estimator.law.cable.as_ref().map(|cable| cable.columns.tension);
        let near = settings.near_of(model).unwrap_or_default();
        let optional = [near].into_iter().chain(tension);
        let lines: String = optional.map(|k| format!("        required[{k}] = 0;\n")).collect();
        filling.when("inverse", true);
        filling.set("optional", lines);
        filling.set("near", near);
        filling.when("scaled", scale != "1.0");
        filling.set("per_second", per_second);
    }
    ExportedFile::text("example.c", filling.render(EXAMPLE, name))
}
