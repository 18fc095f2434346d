//! The `sinew` program: identifies, simulates and controls cable transmissions.

#[macro_use]
mod tell;

mod answer;
mod arguments;
mod csv_text;
mod error;
mod interrupt;
mod output;
mod progress;
mod table;
mod table_error;
mod verbs;
mod version;

use answer::Answer;
use arguments::{Arguments, General, Verb, command, moved};
use clap::error::ErrorKind;
use clap::{ArgMatches, Command, CommandFactory, FromArgMatches};
use error::Error;
use progress::Progress;
use std::process::ExitCode;

fn main() -> ExitCode {
    // No verb: what a run with motors in MIT mode starts beside itself.
    if let Some(ended) = sinew_runtime::can::watch() {
        return ended;
    }
    let (arguments, verb) = match parse_arguments() {
        Ok(parsed) => parsed,
        Err(error) => return refuse_arguments(&error),
    };
    let answer = output::install_interrupt_handler().and_then(|()| run(&arguments.verb, &arguments.general));
    match answer.and_then(|answer| answer.print(&verb)) {
        Ok(code) => code,
        // A closed pipe, as in `sinew evaluate ... | head`, is no error.
        Err(Error::Stdout(e)) if e.kind() == std::io::ErrorKind::BrokenPipe => ExitCode::SUCCESS,
        Err(error) => {
            let (message, code) = (output::one_line(&error.to_string()), error.exit_code());
            if arguments.general.json {
                // Where standard output fails, the line below is what is left.
                let _ = answer::print_error(&verb, code, &message);
            }
            tell!("{}: {message}", output::red("error"));
            ExitCode::from(code)
        }
    }
}

fn run(verb: &Verb, general: &General) -> Result<Answer, Error> {
    match verb {
        Verb::Identify(arguments) => verbs::identify::run(arguments, general),
        Verb::Evaluate(arguments) => {
            Progress::during("evaluating", || verbs::evaluate::run(arguments, general))
        }
        Verb::Predict(arguments) => {
            Progress::during("predicting", || verbs::predict::run(arguments, general))
        }
        Verb::Compensate(arguments) => {
            Progress::during("inverting", || verbs::compensate::run(arguments, general))
        }
        Verb::Adapt(arguments) => verbs::adapt::run(arguments, general),
        Verb::Export(arguments) => verbs::export::run(arguments, general),
        Verb::Demo(arguments) => verbs::demo::run(arguments, general),
        Verb::Design(arguments) => verbs::design::run(arguments, general),
        Verb::Calibrate(arguments) => verbs::calibrate::run(arguments, general),
        Verb::Machine(arguments) => verbs::machine::run(arguments, general),
        Verb::Track(arguments) => verbs::run::track(arguments, general),
        Verb::Run(arguments) => verbs::run::run(arguments, general),
        Verb::Log(arguments) => verbs::log::run(arguments, general),
        Verb::Ethercat(arguments) => verbs::ethercat::run(arguments, general),
        Verb::Servos(arguments) => verbs::servos::run(arguments, general),
        Verb::Can(arguments) => verbs::can::run(arguments, general),
        Verb::Link(arguments) => verbs::link::run(arguments, general),
        Verb::Live(arguments) => verbs::live::run(arguments, general),
        Verb::Reproduce(arguments) => verbs::reproduce::run(arguments, general),
        Verb::Twin(arguments) => verbs::twin::run(arguments, general),
        Verb::Example(arguments) => {
            Progress::during("simulating", || verbs::example::run(arguments, general))
        }
        Verb::Doctor(_) => verbs::doctor::run(general),
        Verb::Completions(arguments) => verbs::completions::run(arguments, general),
        Verb::Man(arguments) => verbs::man::run(arguments, general),
    }
}

/// The command line and the name of its verb. A negative number is a value, not a flag, so that the flag's
/// own parser refuses it.
fn parse_arguments() -> Result<(Arguments, String), clap::Error> {
    fn negative_numbers(command: Command) -> Command {
        command.allow_negative_numbers(true).mut_subcommands(negative_numbers)
    }
    let matches = negative_numbers(command()).try_get_matches()?;
    let verb = verb_name(&matches);
    Ok((Arguments::from_arg_matches(&matches)?, verb))
}

/// The verb and the verb within it, separated by a blank.
fn verb_name(matches: &ArgMatches) -> String {
    let Some((verb, inner)) = matches.subcommand() else { return String::new() };
    inner.subcommand_name().map_or_else(|| verb.to_owned(), |inner| format!("{verb} {inner}"))
}

/// The verb, and the verb within it, of a command line that is refused: its first words that name one.
fn verb_asked() -> String {
    let (mut command, mut words) = (Arguments::command(), Vec::new());
    for word in std::env::args_os().skip(1) {
        match command.find_subcommand(&word).cloned() {
            Some(inner) => command = inner,
            None if word.to_string_lossy().starts_with('-') => continue,
            None => break,
        }
        words.push(word.to_string_lossy().into_owned());
    }
    words.join(" ")
}

/// Help and version, or the reason for which the command line is refused; `sinew` alone prints its help.
fn refuse_arguments(error: &clap::Error) -> ExitCode {
    if std::env::args_os().len() < 2 {
        let help = command().render_long_help();
        let help = if output::stdout_is_coloured() { help.ansi().to_string() } else { help.to_string() };
        return if output::print(&help).is_ok() { ExitCode::SUCCESS } else { Error::SYSTEM.into() };
    }
    let words: Vec<String> =
        std::env::args_os().skip(1).map(|word| word.to_string_lossy().into_owned()).collect();
    let verbs: Vec<String> = words.iter().filter(|word| !word.starts_with('-')).cloned().collect();
    let json = words.iter().any(|word| word == "--json");
    if let Some((old, new)) = moved(&verbs).filter(|_| error.kind() == ErrorKind::InvalidSubcommand) {
        let message = format!("`sinew {old}` is now `sinew {new}`");
        if json {
            let _ = answer::print_error(new, Error::BAD_INPUT, &message);
        }
        tell!("{}: {message}", output::red("error"));
        return ExitCode::from(Error::BAD_INPUT);
    }
    let asked = matches!(error.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion);
    if !asked && json {
        let text = error.render().to_string();
        let reason = text.split("\n\n").next().unwrap_or_default().trim_start_matches("error: ");
        let message = reason.split_whitespace().collect::<Vec<_>>().join(" ");
        let _ = answer::print_error(&verb_asked(), Error::BAD_INPUT, &message);
    }
    error.exit()
}
