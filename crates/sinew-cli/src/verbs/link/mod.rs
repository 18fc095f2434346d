//! `sinew link`.

pub(crate) mod key_file;
mod watch;

use crate::answer::{Answer, Content};
use crate::arguments::{General, LinkArguments, LinkKeyArguments, LinkVerb};
use crate::error::Error;
use crate::output::Written;
use sinew_link::Key;

pub(crate) fn run(arguments: &LinkArguments, general: &General) -> Result<Answer, Error> {
    match &arguments.verb {
        LinkVerb::Key(arguments) => key(arguments, general),
        LinkVerb::Watch(arguments) => watch::run(arguments, general),
    }
}

fn key(arguments: &LinkKeyArguments, general: &General) -> Result<Answer, Error> {
    Key::create(&arguments.file).map_err(sinew_link::Error::from)?;
    let content = if general.json {
        Content::json(&serde_json::json!({}))?
    } else {
        Content::Text(format!("{}: a new key that its owner alone may read\n", arguments.file.display()))
    };
    let written = Written { file: arguments.file.clone(), replaced: false };
    Ok(Answer::done(content, vec![written]))
}
