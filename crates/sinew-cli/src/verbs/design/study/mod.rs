//! `sinew design study`.

mod file;
mod python;

use crate::answer::{Answer, Content};
use crate::arguments::{General, StudyArguments};
use crate::error::Error;
use crate::verbs::read_text;

pub(super) fn run(arguments: &StudyArguments, general: &General) -> Result<Answer, Error> {
    let file = &arguments.file;
    let refused = |problem| Error::StudyFile { file: file.clone(), problem };
    let study = file::parse(&read_text(file)?).map_err(refused)?;
    let text = python::program(&study);
    let content = if general.json {
        Content::json(&serde_json::json!({"python": text, "folder": study.folder, "trials": study.trials}))?
    } else {
        Content::Text(text)
    };
    Ok(Answer::done(content, Vec::new()))
}
