//! `sinew man`.

use crate::answer::{Answer, Content};
use crate::arguments::{Arguments, General, ManArguments};
use crate::error::Error;
use crate::output::{Folder, refuse_overwrite, write_all};
use clap::{Command, CommandFactory};
use clap_mangen::Man;
use std::path::PathBuf;

pub(crate) fn run(arguments: &ManArguments, general: &General) -> Result<Answer, Error> {
    let mut command = Arguments::command();
    command.build();
    let Some(out) = &arguments.out else {
        let text = String::from_utf8_lossy(&page(command)?).into_owned();
        let content = if general.json {
            Content::json(&serde_json::json!({"page": text}))?
        } else {
            Content::Text(text)
        };
        return Ok(Answer::done(content, Vec::new()));
    };
    let folder = Folder::open(out)?;
    let mut pages = Vec::new();
    collect(&command, &mut pages)?;
    let pages: Vec<(PathBuf, Vec<u8>)> =
        pages.into_iter().map(|(name, page)| (folder.file(&format!("{name}.1")), page)).collect();
    let places: Vec<PathBuf> = pages.iter().map(|(path, _)| path.clone()).collect();
    refuse_overwrite([], &places, general.no_clobber)?;
    let files: Vec<_> = pages.iter().map(|(path, page)| (path.clone(), page.as_slice())).collect();
    let written = write_all(&files)?;
    let content =
        if general.json { Content::json(&serde_json::json!({}))? } else { Content::Text(String::new()) };
    Ok(Answer::done(content, written))
}

/// The page of a command and of every command within it, by name.
fn collect(command: &Command, pages: &mut Vec<(String, Vec<u8>)>) -> Result<(), Error> {
    for inner in command.get_subcommands().filter(|inner| inner.get_name() != "help") {
        collect(inner, pages)?;
    }
    let name = command.get_display_name().unwrap_or_else(|| command.get_name());
    pages.push((name.to_owned(), page(command.clone())?));
    Ok(())
}

fn page(command: Command) -> Result<Vec<u8>, Error> {
    let mut text = Vec::new();
    // Writing into memory fails only where the memory does.
    let program = concat!("sinew ", env!("CARGO_PKG_VERSION"));
    Man::new(command).source(program).render(&mut text).map_err(Error::Stdout)?;
    Ok(text)
}
