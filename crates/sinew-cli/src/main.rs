//! The `sinew` program: what happens at the far end of a cable, told from the motor's side.

mod arguments;
mod error;
mod output;
mod progress;
mod report;
mod table;
mod verbs;

use arguments::{Arguments, Verb};
use clap::{Command, CommandFactory, FromArgMatches};
use std::process::ExitCode;

/// Exit code of everything that is the input's fault, as clap uses for flags.
const BAD_INPUT: u8 = 2;

fn main() -> ExitCode {
    let arguments = arguments();
    let outcome = output::install_interrupt_handler().and_then(|()| match &arguments.verb {
        Verb::Identify(arguments) => verbs::identify::run(arguments),
        Verb::Evaluate(arguments) => verbs::evaluate::run(arguments),
        Verb::Predict(arguments) => verbs::predict::run(arguments),
        Verb::Adapt(arguments) => verbs::adapt::run(arguments),
        Verb::Demo(arguments) => verbs::demo::run(arguments),
        Verb::Arm(arguments) => verbs::arm::run(arguments),
        Verb::Track(arguments) => verbs::track::run(arguments),
        Verb::Reproduce(arguments) => verbs::reproduce::run(arguments),
        Verb::Bench(arguments) => verbs::bench::run(arguments),
        Verb::Twin(arguments) => verbs::twin::run(arguments),
        Verb::Tension(arguments) => verbs::tension::run(arguments),
        Verb::Drive(arguments) => verbs::drive::run(arguments),
    });
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        // A reader that has seen enough, as in `sinew evaluate ... | head`, is no error.
        Err(error::Error::Stdout(e)) if e.kind() == std::io::ErrorKind::BrokenPipe => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{}: {}", output::red("error"), output::one_line(&error.to_string()));
            ExitCode::from(BAD_INPUT)
        }
    }
}

/// What was asked for. A number below nothing is a number and not a flag: what is wrong with it is said by its flag.
fn arguments() -> Arguments {
    fn numbers(command: Command) -> Command {
        command.allow_negative_numbers(true).mut_subcommands(numbers)
    }
    let matches = numbers(Arguments::command()).get_matches();
    Arguments::from_arg_matches(&matches).unwrap_or_else(|error| error.exit())
}
