//! `sinew log plot` of the table that `--record FILE.csv` has written of a simulated run.

use crate::answer::{Answer, Content};
use crate::arguments::{General, LogPlotArguments};
use crate::error::Error;
use crate::output::write_all;
use crate::table_error::TableError;
use crate::verbs::read_text;
use crate::verbs::track::{record, report};

pub(super) fn run(arguments: &LogPlotArguments, general: &General) -> Result<Answer, Error> {
    let LogPlotArguments { file, report: out } = arguments;
    let (head, trace) = record::parse(&read_text(file)?).map_err(Error::table(file))?;
    let variant = head.compensation.parse().map_err(|_| {
        Error::table(file)(TableError::in_line(2, "the name of a compensation", head.compensation.clone()))
    })?;
    let page = report(&head, variant, &trace, None)?;
    let written = write_all(&[(out.clone(), page.as_bytes())])?;
    let content = if general.json {
        Content::json(&serde_json::json!({"title": head.title, "rows": trace.len()}))?
    } else {
        Content::Text(format!("SIMULATED {}: {} rows\n", head.title, trace.len()))
    };
    Ok(Answer::done(content, written))
}
