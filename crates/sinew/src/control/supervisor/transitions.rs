//! The modes' transitions: the table from which the supervisor decides and from which the documentation is
//! written.

use super::mode::{Mode, Request};
use alloc::format;
use alloc::string::String;

/// What a transition waits for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Condition {
    /// Nothing.
    Always,
    /// Every cable has its tension.
    Tense,
    /// The reference is near the held pose.
    ReferenceNear,
    /// The tensions are released, or the time for it is over; no fault.
    Released,
    /// The same after a fault.
    ReleasedAfterFault,
    /// A fault that does not allow to go on.
    Fault,
    /// The last command is older than its limit.
    StaleCommand,
}

impl Condition {
    /// In words of the documentation.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Always => "at once",
            Self::Tense => "every cable has its tension",
            Self::ReferenceNear => "the reference is near the held pose",
            Self::Released => "released",
            Self::ReleasedAfterFault => "released after a fault",
            Self::Fault => "fault",
            Self::StaleCommand => "stale command",
        }
    }
}

/// One transition: from a mode, for some goals or for any, once its condition holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Transition {
    /// The mode that is left.
    pub from: Mode,
    /// Goals for which it is left; empty: whatever the goal.
    pub goals: &'static [Request],
    /// What it waits for.
    pub condition: Condition,
    /// The mode that begins.
    pub to: Mode,
}

const fn row(from: Mode, goals: &'static [Request], condition: Condition, to: Mode) -> Transition {
    Transition { from, goals, condition, to }
}

/// Goals that need the drives' power.
const ON: &[Request] = &[Request::GetReady, Request::Pretension, Request::Hold, Request::Run];
/// Goals that need tension.
const TENSE: &[Request] = &[Request::Pretension, Request::Hold, Request::Run];
/// Goals for which a machine under tension is released.
const DOWN: &[Request] = &[Request::SafeStop, Request::GetReady, Request::TurnOff];

/// All transitions; the first row that applies is taken. There are no others.
pub const TRANSITIONS: [Transition; 18] = [
    row(Mode::Off, ON, Condition::Always, Mode::Ready),
    row(Mode::Ready, &[], Condition::Fault, Mode::Fault),
    row(Mode::Ready, &[Request::TurnOff], Condition::Always, Mode::Off),
    row(Mode::Ready, TENSE, Condition::Always, Mode::Pretension),
    row(Mode::Pretension, &[], Condition::Fault, Mode::SafeStop),
    row(Mode::Pretension, DOWN, Condition::Always, Mode::SafeStop),
    row(Mode::Pretension, &[], Condition::Tense, Mode::Hold),
    row(Mode::Hold, &[], Condition::Fault, Mode::SafeStop),
    row(Mode::Hold, DOWN, Condition::Always, Mode::SafeStop),
    row(Mode::Hold, &[Request::Run], Condition::ReferenceNear, Mode::Run),
    row(Mode::Run, &[], Condition::Fault, Mode::SafeStop),
    row(Mode::Run, DOWN, Condition::Always, Mode::SafeStop),
    row(Mode::Run, &[], Condition::StaleCommand, Mode::Hold),
    row(Mode::Run, &[Request::Hold, Request::Pretension], Condition::Always, Mode::Hold),
    row(Mode::SafeStop, &[], Condition::ReleasedAfterFault, Mode::Fault),
    row(Mode::SafeStop, &[], Condition::Released, Mode::Ready),
    row(Mode::Fault, &[Request::Reset], Condition::Always, Mode::Ready),
    row(Mode::Fault, &[Request::TurnOff], Condition::Always, Mode::Off),
];

/// The transition that is taken from a mode with a goal; none where the mode stays.
pub(super) fn next(
    mode: Mode,
    goal: Request,
    mut holds: impl FnMut(Condition) -> bool,
) -> Option<&'static Transition> {
    TRANSITIONS.iter().find(|row| {
        row.from == mode && (row.goals.is_empty() || row.goals.contains(&goal)) && holds(row.condition)
    })
}

/// The transitions as a table and as a diagram, in Markdown.
#[must_use]
pub fn transitions_markdown() -> String {
    let mut text = String::from("| from | goal | condition | to |\n|---|---|---|---|\n");
    for row in &TRANSITIONS {
        let goals = row.goals.iter().map(|goal| format!("`{}`", goal.name()));
        let goals = goals.reduce(|all, goal| format!("{all}, {goal}")).unwrap_or_else(|| "any".into());
        let [from, to] = [row.from.name(), row.to.name()];
        text += &format!("| `{from}` | {goals} | {} | `{to}` |\n", row.condition.name());
    }
    text += "\n```mermaid\nstateDiagram-v2\n    [*] --> off\n";
    for row in &TRANSITIONS {
        let goals = row.goals.iter().map(|goal| String::from(goal.name()));
        let goals = goals.reduce(|all, goal| format!("{all} / {goal}")).unwrap_or_default();
        let label = match (row.goals.is_empty(), row.condition) {
            (false, Condition::Always) => goals,
            (false, condition) => format!("{goals} [{}]", condition.name()),
            (true, condition) => format!("[{}]", condition.name()),
        };
        text += &format!("    {} --> {}: {label}\n", row.from.name(), row.to.name());
    }
    text + "```\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_machine_under_tension_is_never_turned_off_without_being_let_down() {
        for row in TRANSITIONS.iter().filter(|row| row.to == Mode::Off) {
            assert!(matches!(row.from, Mode::Ready | Mode::Fault), "{row:?}");
        }
        for mode in [Mode::Pretension, Mode::Hold, Mode::Run] {
            for goal in Request::ALL {
                let fault = next(mode, goal, |condition| condition == Condition::Fault).map(|row| row.to);
                assert_eq!(fault, Some(Mode::SafeStop), "a fault precedes every goal: {mode:?} {goal:?}");
            }
            let off = next(mode, Request::TurnOff, |condition| condition == Condition::Always);
            assert_eq!(off.map(|row| row.to), Some(Mode::SafeStop));
        }
    }

    #[test]
    fn goals_of_the_table_are_those_that_requests_call_so() {
        for goal in Request::ALL {
            assert_eq!(DOWN.contains(&goal), goal.is_stop(), "{goal:?}");
            assert_eq!(TENSE.contains(&goal), goal.is_under_tension(), "{goal:?}");
        }
    }

    #[test]
    fn tension_is_built_up_in_pretension_alone_and_run_is_entered_from_hold_alone() {
        for row in &TRANSITIONS {
            if row.to.is_controlled() && !row.from.is_controlled() {
                assert_eq!((row.from, row.to), (Mode::Pretension, Mode::Hold));
            }
            if row.to == Mode::Run {
                assert_eq!(row.from, Mode::Hold);
            }
        }
    }

    #[test]
    fn a_fault_is_left_by_a_reset_or_without_power_only() {
        for goal in Request::ALL {
            let to = next(Mode::Fault, goal, |_| true).map(|row| row.to);
            let expected = match goal {
                Request::Reset => Some(Mode::Ready),
                Request::TurnOff => Some(Mode::Off),
                _ => None,
            };
            assert_eq!(to, expected);
        }
    }

    #[test]
    fn every_mode_is_reached_from_every_other() {
        for start in Mode::ALL {
            let mut reached = alloc::vec![start];
            while let Some(more) =
                TRANSITIONS.iter().find(|row| reached.contains(&row.from) && !reached.contains(&row.to))
            {
                reached.push(more.to);
            }
            assert_eq!(reached.len(), Mode::ALL.len(), "{start:?}: {reached:?}");
        }
    }
}
