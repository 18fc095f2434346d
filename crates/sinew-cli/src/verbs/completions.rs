//! `sinew completions`.

use crate::arguments::{Arguments, CompletionsArguments};
use crate::error::Error;
use crate::output::print;
use clap::CommandFactory;

pub(crate) fn run(arguments: &CompletionsArguments) -> Result<(), Error> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut Arguments::command(), "sinew", &mut script);
    print(&String::from_utf8_lossy(&script))
}
