//! The `sinew` program: identifies, simulates and controls cable transmissions.

mod arguments;
mod csv_text;
mod error;
mod interrupt;
mod output;
mod progress;
mod table;
mod table_error;
mod verbs;

use arguments::{Arguments, Verb};
use clap::{Command, CommandFactory, FromArgMatches};
use std::process::ExitCode;
use verbs::Outcome;

fn main() -> ExitCode {
    let arguments = parse_arguments();
    match output::install_interrupt_handler().and_then(|()| run(&arguments.verb)) {
        Ok(outcome) => outcome.into(),
        // A closed pipe, as in `sinew evaluate ... | head`, is no error.
        Err(error::Error::Stdout(e)) if e.kind() == std::io::ErrorKind::BrokenPipe => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{}: {}", output::red("error"), output::one_line(&error.to_string()));
            ExitCode::from(error.exit_code())
        }
    }
}

fn run(verb: &Verb) -> Result<Outcome, error::Error> {
    match verb {
        Verb::Track(arguments) => return verbs::track::run(arguments),
        Verb::Run(arguments) => return verbs::run::run(arguments),
        Verb::Ethercat(arguments) => return verbs::ethercat::run(arguments),
        Verb::Tension(arguments) => return verbs::tension::run(arguments),
        Verb::Drive(arguments) => return verbs::drive::run(arguments),
        Verb::Machine(arguments) => return verbs::machine::run(arguments),
        Verb::Identify(arguments) => verbs::identify::run(arguments),
        Verb::Evaluate(arguments) => verbs::evaluate::run(arguments),
        Verb::Predict(arguments) => verbs::predict::run(arguments),
        Verb::Adapt(arguments) => verbs::adapt::run(arguments),
        Verb::Demo(arguments) => verbs::demo::run(arguments),
        Verb::Arm(arguments) => verbs::arm::run(arguments),
        Verb::Reproduce(arguments) => verbs::reproduce::run(arguments),
        Verb::Bench(arguments) => verbs::bench::run(arguments),
        Verb::Twin(arguments) => verbs::twin::run(arguments),
        Verb::Completions(arguments) => verbs::completions::run(arguments),
    }?;
    Ok(Outcome::AsAsked)
}

/// Parses the command line. A negative number is a value, not a flag, so that the flag's own parser refuses
/// it.
fn parse_arguments() -> Arguments {
    fn negative_numbers(command: Command) -> Command {
        command.allow_negative_numbers(true).mut_subcommands(negative_numbers)
    }
    let matches = negative_numbers(Arguments::command()).get_matches();
    Arguments::from_arg_matches(&matches).unwrap_or_else(|error| error.exit())
}
