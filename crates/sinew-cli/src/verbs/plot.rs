//! `sinew plot`.

use super::log;
use super::read_text;
use super::recording::is_recording;
use super::track::{record, report};
use crate::answer::{Answer, Content};
use crate::arguments::{General, LogPlotArguments, PlotArguments};
use crate::error::Error;
use crate::output::{refuse_overwrite, write_all};
use crate::table_error::TableError;

pub(crate) fn run(arguments: &PlotArguments, general: &General) -> Result<Answer, Error> {
    let PlotArguments { record: file, report: out } = arguments;
    if is_recording(file) {
        return log::draw(&LogPlotArguments { file: file.clone(), report: out.clone() }, general);
    }
    refuse_overwrite([file], std::slice::from_ref(out), general.no_clobber)?;
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
