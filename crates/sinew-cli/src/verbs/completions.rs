//! `sinew completions`.

use crate::answer::{Answer, Content};
use crate::arguments::{Arguments, CompletionsArguments, General};
use crate::error::Error;
use clap::CommandFactory;

pub(crate) fn run(arguments: &CompletionsArguments, general: &General) -> Result<Answer, Error> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut Arguments::command(), "sinew", &mut script);
    let text = String::from_utf8_lossy(&script).into_owned();
    let content =
        if general.json { Content::json(&serde_json::json!({"script": text}))? } else { Content::Text(text) };
    Ok(Answer::done(content, Vec::new()))
}
