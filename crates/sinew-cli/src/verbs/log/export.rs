//! `sinew log export`.

use super::rows::{Column, Given, Rows};
use crate::answer::{Answer, Content};
use crate::arguments::{General, LogExportArguments, LogForm};
use crate::error::Error;
use crate::output::{Folder, refuse_overwrite, write_all, write_streamed};
use crate::verbs::recording::{RunSetup, read_bytes, recording};
use sinew_record::ros2_bag;
use std::io::{BufWriter, Write};
use std::path::Path;

pub(super) fn run(arguments: &LogExportArguments, general: &General) -> Result<Answer, Error> {
    let LogExportArguments { file, to, out, every, muscle } = arguments;
    if *to == LogForm::Ros2 {
        return bag(arguments, general);
    }
    refuse_overwrite([file], std::slice::from_ref(out), general.no_clobber)?;
    let format = Format::from_path(out)?;
    let bytes = read_bytes(file)?;
    let recording = recording(file, &bytes)?;
    let rows = match muscle {
        None => Rows::all(&recording, every.unwrap_or(1)),
        Some(name) => {
            let machine = RunSetup::from_recording(file, &recording)?.machine(file, &recording)?;
            Rows::of_muscle(&recording, &machine, name)?
        }
    };
    let columns: Vec<String> = rows.columns.iter().map(|column| column.name.clone()).collect();
    let (Given { count, empty }, written) = write_streamed(out, |to| match format {
        Format::Csv => csv(to, out, file, rows),
        #[cfg(feature = "parquet")]
        Format::Parquet => super::parquet::write(to, out, file, rows),
    })?;
    let content = if general.json {
        Content::json(&serde_json::json!({
            "machine": recording.head.machine, "simulated": recording.head.simulated,
            "rows": count, "columns": columns, "empty_columns": empty,
        }))?
    } else {
        let simulated = if recording.head.simulated { "SIMULATED " } else { "" };
        let machine = &recording.head.machine;
        let table = format!("{simulated}{machine}: {count} rows, {} columns\n", columns.len());
        Content::Text(table + &without_numbers(&empty))
    };
    Ok(Answer::done(content, vec![written]))
}

/// A bag in a folder of its own.
fn bag(arguments: &LogExportArguments, general: &General) -> Result<Answer, Error> {
    let LogExportArguments { file, out, every, muscle, .. } = arguments;
    if let Some(muscle) = muscle {
        let expected = "a table: a bag has all muscles";
        return Err(Error::Argument { flag: "--muscle", value: muscle.clone(), expected });
    }
    if out.exists() {
        return Err(Error::Exists { file: out.clone(), remedy: "to remove it first" });
    }
    let bytes = read_bytes(file)?;
    let recording = recording(file, &bytes)?;
    let machine = RunSetup::from_recording(file, &recording)?.machine(file, &recording)?;
    let folder = Folder::open(out)?;
    let name = out.file_name().map_or_else(|| "bag".into(), |name| name.to_string_lossy());
    let messages = format!("{name}_0.mcap");
    let bag = ros2_bag(&recording, &machine, every.unwrap_or(recording.head.stride), &messages)
        .map_err(Error::recording(file))?;
    let files: [(_, &[u8]); 2] =
        [(folder.file(&messages), &bag.mcap), (folder.file("metadata.yaml"), bag.metadata.as_bytes())];
    let written = write_all(&files)?;
    let head = &recording.head;
    let content = if general.json {
        let topics: serde_json::Map<_, _> =
            bag.topics.iter().map(|(topic, count)| ((*topic).to_owned(), (*count).into())).collect();
        Content::json(&serde_json::json!({
            "machine": head.machine, "simulated": head.simulated, "topics": topics,
        }))?
    } else {
        let simulated = if head.simulated { "SIMULATED " } else { "" };
        let topics: Vec<String> =
            bag.topics.iter().map(|(topic, count)| format!("{topic} {count}")).collect();
        Content::Text(format!("{simulated}{}: {}\n", head.machine, topics.join(", ")))
    };
    Ok(Answer::done(content, written))
}

/// Formats of a table.
#[derive(Debug, Clone, Copy)]
enum Format {
    Csv,
    #[cfg(feature = "parquet")]
    Parquet,
}

impl Format {
    fn from_path(path: &Path) -> Result<Self, Error> {
        match path.extension().and_then(|extension| extension.to_str()) {
            Some("csv") => Ok(Self::Csv),
            #[cfg(feature = "parquet")]
            Some("parquet") => Ok(Self::Parquet),
            _ => Err(Error::Argument {
                flag: "--out",
                value: path.display().to_string(),
                expected: if cfg!(feature = "parquet") {
                    "a file ending in .csv or .parquet"
                } else {
                    "a file ending in .csv; .parquet needs a program built with --features parquet"
                },
            }),
        }
    }
}

/// Columns that are said by name.
const NAMED: usize = 6;

/// A sentence on the columns that are empty: the machine has no such sensor, or the run no such plant.
fn without_numbers(empty: &[String]) -> String {
    let named = empty.iter().take(NAMED).map(String::as_str).collect::<Vec<_>>().join(", ");
    match empty.len() {
        0 => String::new(),
        count if count <= NAMED => format!("No number was recorded in {named}\n"),
        count => format!("No number was recorded in {named} and {} more columns\n", count - NAMED),
    }
}

fn csv(to: &mut std::fs::File, out: &Path, file: &Path, rows: Rows<'_>) -> Result<Given, Error> {
    let unwritable = |source| Error::Unwritable { file: out.to_owned(), source };
    let mut to = csv::Writer::from_writer(BufWriter::new(to));
    to.write_record(rows.columns.iter().map(|column| &column.name))?;
    let mut cell = Vec::new();
    let given = rows.each(file, |columns, row| {
        for (column, value) in columns.iter().zip(row) {
            cell.clear();
            write_cell(&mut cell, column, *value).map_err(unwritable)?;
            to.write_field(&cell)?;
        }
        Ok(to.write_record(None::<&[u8]>)?)
    })?;
    to.flush().map_err(unwritable)?;
    Ok(given)
}

/// A number with as many decimals as were recorded, or with all its digits; an empty cell where it is not
/// finite.
fn write_cell(cell: &mut Vec<u8>, column: &Column, value: f64) -> std::io::Result<()> {
    match column.digits {
        _ if !value.is_finite() => Ok(()),
        Some(digits) => write!(cell, "{value:.digits$}"),
        None => write!(cell, "{value}"),
    }
}
