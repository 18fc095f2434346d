//! The verbs by what one wants to do with them, and where earlier ones have gone.

use super::Arguments;
use clap::{Command, CommandFactory};

/// The groups of `--help`.
const GROUPS: [(&str, &[&str]); 6] = [
    (
        "Identify a transmission",
        &["identify", "evaluate", "predict", "compensate", "adapt", "export", "demo"],
    ),
    ("Describe and design a machine", &["machine", "design", "calibrate"]),
    ("Run it", &["track", "run", "live", "link", "ethercat", "servos", "can"]),
    ("Look at what happened", &["log"]),
    ("Simulate a cable, reproduce the paper", &["twin", "reproduce"]),
    ("Begin", &["example", "doctor"]),
];

/// Earlier spellings and the present ones.
const MOVED: [(&str, &str); 13] = [
    ("arm inspect", "machine body"),
    ("arm evaluate", "machine evaluate"),
    ("arm convert", "machine convert"),
    ("arm", "machine"),
    ("bench run", "twin bench"),
    ("bench plan", "twin plan"),
    ("bench", "twin"),
    ("drive size", "design drive"),
    ("drive", "design drive"),
    ("plot", "log plot"),
    ("replay", "log replay"),
    ("study", "design study"),
    ("tension", "design tension"),
];

/// Width of the text of `--help`.
const WIDTH: usize = 98;
/// Where the descriptions of verbs begin.
const INDENT: usize = 15;

/// The command line, with its verbs in groups.
pub(crate) fn command() -> Command {
    let command = Arguments::command();
    let group = |(title, verbs): &(&str, &[&str])| {
        let rows = verbs.iter().filter_map(|verb| command.find_subcommand(verb)).map(row);
        format!("{title}:\n{}\n", rows.collect::<String>())
    };
    let groups: String = GROUPS.iter().map(group).collect();
    let template = "{about-with-newline}\n{usage-heading} {usage}\n\n";
    command.help_template(format!("{template}{groups}Options:\n{{options}}{{after-help}}"))
}

/// A verb and the first paragraph of its help, wrapped.
fn row(verb: &Command) -> String {
    let about = verb.get_about().map(ToString::to_string).unwrap_or_default();
    let mut lines = vec![format!("  {:<width$}", verb.get_name(), width = INDENT - 2)];
    for word in about.split_whitespace() {
        let last = lines.last_mut().map_or(0, |line| line.len());
        if last + word.len() >= WIDTH {
            lines.push(" ".repeat(INDENT));
        }
        if let Some(line) = lines.last_mut() {
            *line += if line.trim_end().len() < INDENT { "" } else { " " };
            *line += word;
        }
    }
    lines.join("\n") + "\n"
}

/// The present spelling of the verbs with which a command line begins, where they are earlier ones: both.
pub(crate) fn moved(words: &[String]) -> Option<(&'static str, &'static str)> {
    let begins = |(old, _): &&(&str, &str)| {
        old.split(' ').enumerate().all(|(k, w)| words.get(k).is_some_and(|x| x == w))
    };
    MOVED.iter().find(begins).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_verb_that_is_shown_stands_in_one_group() {
        let command = Arguments::command();
        let shown = command.get_subcommands().filter(|verb| !verb.is_hide_set()).map(Command::get_name);
        let grouped: Vec<&str> = GROUPS.iter().flat_map(|(_, verbs)| verbs.iter().copied()).collect();
        let mut shown: Vec<&str> = shown.collect();
        let mut sorted = grouped;
        sorted.sort_unstable();
        shown.sort_unstable();
        assert_eq!(sorted, shown);
    }

    #[test]
    fn earlier_spellings_lead_to_verbs_that_exist() {
        for (old, new) in MOVED {
            let words: Vec<String> = old.split(' ').map(str::to_owned).collect();
            assert_eq!(moved(&words), Some((old, new)));
            let found =
                new.split(' ').try_fold(Arguments::command(), |c, word| c.find_subcommand(word).cloned());
            assert!(found.is_some(), "{new}");
        }
        assert_eq!(moved(&["machine".to_owned()]), None);
    }
}
