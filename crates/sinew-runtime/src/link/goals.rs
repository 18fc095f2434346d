//! What sessions and requests make of the goal of a linked machine: the table from which the cycle decides
//! and from which the documentation is written.

use sinew::control::supervisor::{Mode, Request};
use sinew_link::host::Input;
use std::fmt::Write as _;

/// What happens to the session of the client that commands. Watchers, and clients that are refused, are none
/// of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SessionEvent {
    /// A client's session begins.
    Begins,
    /// Its client asks for something, whatever it is.
    Asks,
    /// It ends, by a Goodbye or because nothing came for too long.
    Ends,
    /// No other has begun for the time of `unattended_s`.
    Unattended,
}

impl SessionEvent {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Begins, Self::Asks, Self::Ends, Self::Unattended];

    /// In words of the documentation.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Begins => "a session begins",
            Self::Asks => "its client asks for a mode",
            Self::Ends => "it ends: Goodbye, or nothing for 0.5 s",
            Self::Unattended => "none begins for `unattended_s` then",
        }
    }

    /// What an input of the link is, and what it asks for.
    pub(super) fn from_input(input: &Input) -> (Self, Request) {
        match input {
            Input::Begins => (Self::Begins, Request::None),
            Input::Ends => (Self::Ends, Request::None),
            Input::Command(command) => {
                (Self::Asks, Request::from_number(command.request.number()).unwrap_or(Request::None))
            }
        }
    }
}

/// What becomes of the goal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Then {
    /// It stays what it is.
    Stays,
    /// It is what the client asks for.
    IsAsked,
    /// It is this.
    Is(Request),
}

/// A row: an event, the modes and goals in which it counts, and what becomes of the goal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GoalRow {
    /// What happens.
    pub event: SessionEvent,
    /// Modes; empty: any.
    pub modes: &'static [Mode],
    /// Goals; empty: any.
    pub goals: &'static [Request],
    /// The goal from then on.
    pub then: Then,
}

/// Goals under tension.
const TENSE: &[Request] = &[Request::Pretension, Request::Hold, Request::Run];
/// Modes of a machine that is released or has a fault.
const STOPPED: &[Mode] = &[Mode::SafeStop, Mode::Fault];

const fn row(event: SessionEvent, modes: &'static [Mode], goals: &'static [Request], then: Then) -> GoalRow {
    GoalRow { event, modes, goals, then }
}

/// All rows; the first that applies counts. Every event has one for every mode and goal.
pub const GOAL_ROWS: [GoalRow; 7] = [
    row(SessionEvent::Begins, &[], &[], Then::Stays),
    row(SessionEvent::Asks, &[], &[], Then::IsAsked),
    row(SessionEvent::Ends, STOPPED, TENSE, Then::Is(Request::SafeStop)),
    row(SessionEvent::Ends, &[], TENSE, Then::Is(Request::Hold)),
    row(SessionEvent::Ends, &[], &[], Then::Stays),
    row(SessionEvent::Unattended, &[], TENSE, Then::Is(Request::SafeStop)),
    row(SessionEvent::Unattended, &[], &[], Then::Stays),
];

/// The goal after an event, by the table; `asked` is what a client asks for, nothing in a sign of life.
#[must_use]
pub fn goal_after((event, asked): (SessionEvent, Request), mode: Mode, goal: Request) -> Request {
    let row = GOAL_ROWS.iter().find(|row| {
        row.event == event
            && (row.modes.is_empty() || row.modes.contains(&mode))
            && (row.goals.is_empty() || row.goals.contains(&goal))
    });
    match row.map(|row| row.then) {
        Some(Then::Is(request)) => request,
        Some(Then::IsAsked) if asked != Request::None => asked,
        _ => goal,
    }
}

/// The table, in Markdown.
#[must_use]
pub fn goals_markdown() -> String {
    let listed = |names: Vec<&str>| {
        let quoted = names.iter().map(|name| format!("`{name}`"));
        quoted.reduce(|all, name| format!("{all}, {name}")).unwrap_or_else(|| "any".to_owned())
    };
    let mut text = "| event | mode | goal | goal from then on |\n|---|---|---|---|\n".to_owned();
    for row in &GOAL_ROWS {
        let modes = listed(row.modes.iter().map(|mode| mode.name()).collect());
        let goals = listed(row.goals.iter().map(|goal| goal.name()).collect());
        let then = match row.then {
            Then::Stays => "the same".to_owned(),
            Then::IsAsked => "what it asks for".to_owned(),
            Then::Is(request) => format!("`{}`", request.name()),
        };
        let _ = writeln!(text, "| {} | {modes} | {goals} | {then} |", row.event.name());
    }
    text
}

/// The goal of a linked machine, and since when nobody has been there to change it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Goal {
    request: Request,
    /// Machine time of the end of the last session, ns; none before the first and while there is one.
    left_at: Option<u64>,
    /// How long a machine under tension is held then, ns.
    unattended_ns: u64,
}

impl Goal {
    /// The pose is held until the first client asks for something else.
    pub(super) fn new(unattended_ns: u64) -> Self {
        Self { request: Request::Hold, left_at: None, unattended_ns }
    }

    /// What is asked of the supervisor.
    pub(super) fn request(&self) -> Request {
        self.request
    }

    /// After an event at a machine time, ns; whether the goal has changed.
    pub(super) fn follow(&mut self, event: (SessionEvent, Request), mode: Mode, now: u64) -> bool {
        let before = self.request;
        self.request = goal_after(event, mode, before);
        self.left_at = (event.0 == SessionEvent::Ends).then_some(now);
        self.request != before
    }

    /// What becomes of it because time goes on.
    pub(super) fn pass(&mut self, mode: Mode, now: u64) {
        if self.left_at.is_some_and(|left| now.saturating_sub(left) >= self.unattended_ns) {
            self.follow((SessionEvent::Unattended, Request::None), mode, now);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An event that asks for nothing.
    fn silent(event: SessionEvent) -> (SessionEvent, Request) {
        (event, Request::None)
    }

    fn asks(request: Request) -> (SessionEvent, Request) {
        (SessionEvent::Asks, request)
    }

    #[test]
    fn a_stop_is_weakened_by_a_request_alone_and_nothing_but_a_request_asks_for_motion() {
        for mode in Mode::ALL {
            for goal in Request::ALL {
                for event in SessionEvent::ALL {
                    let after = goal_after(silent(event), mode, goal);
                    if goal.is_stop() || goal == Request::Reset {
                        assert_eq!(after, goal, "{event:?} {mode:?}");
                    }
                    assert!(
                        after == goal || after.is_stop() || after == Request::Hold,
                        "{event:?} {after:?}"
                    );
                    assert!(after != Request::Hold || goal.is_under_tension(), "{event:?} {mode:?} {goal:?}");
                }
                for asked in Request::ALL.into_iter().filter(|asked| *asked != Request::None) {
                    assert_eq!(goal_after(asks(asked), mode, goal), asked);
                }
            }
        }
    }

    #[test]
    fn every_event_has_a_row_for_every_mode_and_goal() {
        for event in SessionEvent::ALL {
            let last = GOAL_ROWS.iter().rfind(|row| row.event == event).unwrap();
            assert!(last.modes.is_empty() && last.goals.is_empty(), "{event:?}");
        }
    }

    #[test]
    fn a_machine_that_is_let_down_stays_down_when_its_client_goes_whatever_was_to_come_next() {
        for mode in [Mode::SafeStop, Mode::Fault] {
            for goal in TENSE {
                assert_eq!(goal_after(silent(SessionEvent::Ends), mode, *goal), Request::SafeStop);
            }
        }
    }

    #[test]
    fn a_machine_that_is_left_is_held_for_a_time_and_then_let_down_unless_a_client_comes() {
        for came in [None, Some(silent(SessionEvent::Begins)), Some(asks(Request::Run))] {
            let mut goal = Goal::new(100);
            goal.pass(Mode::Hold, 1_000_000);
            assert_eq!(goal.request(), Request::Hold, "before the first client indefinitely");
            goal.follow(silent(SessionEvent::Begins), Mode::Hold, 1000);
            goal.follow(asks(Request::Run), Mode::Hold, 1000);
            goal.pass(Mode::Run, 9000);
            assert!(goal.follow(silent(SessionEvent::Ends), Mode::Run, 9000));
            goal.pass(Mode::Run, 9099);
            assert_eq!(goal.request(), Request::Hold);
            if let Some(event) = came {
                goal.follow(event, Mode::Hold, 9099);
            }
            goal.pass(Mode::Hold, 9100);
            goal.pass(Mode::Hold, 99_000);
            let expected = match came {
                None => Request::SafeStop,
                Some((SessionEvent::Asks, asked)) => asked,
                Some(_) => Request::Hold,
            };
            assert_eq!(goal.request(), expected);
        }
    }

    const BEGIN: &str = "<!-- goals -->\n";
    const END: &str = "<!-- end of goals -->\n";

    /// Writes the table where `SINEW_LINK_WRITE` is set.
    #[test]
    fn the_table_of_the_documentation_is_that_of_the_code() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/link.md");
        let page = std::fs::read_to_string(path).unwrap();
        let (before, rest) = page.split_once(BEGIN).expect("the mark before the table");
        let (written, after) = rest.split_once(END).expect("the mark after the table");
        if std::env::var_os("SINEW_LINK_WRITE").is_some() {
            std::fs::write(path, format!("{before}{BEGIN}\n{}\n{END}{after}", goals_markdown())).unwrap();
            return;
        }
        assert_eq!(written.trim(), goals_markdown().trim(), "run this test with SINEW_LINK_WRITE=1");
    }
}
