//! What limits a joint, in words.

use sinew::control::arm::{ArmGains, JointFigures, JointLimit, LimitedBy};
use sinew::machine::{Characteristics, DesignChange};

/// What the words are about.
pub(super) struct Subject<'a> {
    /// rad or m.
    pub(super) unit: &'static str,
    /// Of the muscles.
    pub(super) names: &'a [String],
    pub(super) gains: &'a ArmGains,
    pub(super) found: &'a Characteristics,
}

impl Subject<'_> {
    /// What limits a joint, and which changes of the design would help.
    pub(super) fn sentence(&self, joint: usize, limit: &JointLimit) -> String {
        let Some(figures) = &limit.figures else { return "no muscle moves it".to_owned() };
        let crossing = self.crossing(figures);
        let [band, friction, rest] =
            [self.found.joints[joint].dead_band, figures.friction, figures.rest].map(|x| self.small(x));
        let what = match limit.limited_by {
            LimitedBy::NoMuscle => return "no muscle moves it".to_owned(),
            LimitedBy::NoEncoder => {
                format!("it has no encoder: its position follows from the stretch of its cables; {crossing}")
            }
            LimitedBy::Crossing => format!("{crossing}, at every reversal"),
            LimitedBy::Friction => {
                format!(
                    "uncertain friction: of {band} of dead band {friction} are left to feedback; {crossing}"
                )
            }
            LimitedBy::Rest => format!("its winches rest up to an error of {rest}; {crossing}"),
        };
        let (help, not): (Vec<_>, Vec<_>) =
            limit.changed.iter().partition(|(_, after)| limit.is_helped_by(after));
        let with_number = |(change, after): &&(DesignChange, JointFigures)| {
            format!("a {} ({})", change.name(), self.limiting(limit, after))
        };
        let help: Vec<String> = help.iter().map(with_number).collect();
        let not: Vec<String> = not.iter().map(|(change, _)| format!("a {}", change.name())).collect();
        let verdict = match (help.is_empty(), not.is_empty()) {
            (true, _) => format!("{} would not help", listed(&not, "or")),
            (false, true) => format!("{} would help", listed(&help, "or")),
            (false, false) => {
                format!("{} would help, {} would not", listed(&help, "or"), listed(&not, "or"))
            }
        };
        format!("{what}; {verdict}{}", self.less_damped(limit, figures))
    }

    fn crossing(&self, figures: &JointFigures) -> String {
        let k = figures.slowest;
        format!(
            "{} takes {} ms across {} mm of dead band at {} m/s",
            self.names[k],
            three(1e3 * figures.crossing),
            three(1e3 * self.found.muscles[k].dead_band),
            three(self.gains.muscles[k].max_winch_speed)
        )
    }

    /// The number that limits the joint, with its unit.
    fn limiting(&self, limit: &JointLimit, figures: &JointFigures) -> String {
        let value = figures.limiting(limit.limited_by).unwrap_or(f64::NAN);
        if limit.limited_by == LimitedBy::Crossing {
            return format!("{} ms", three(1e3 * value));
        }
        self.small(value)
    }

    /// An angle or a length in thousandths of its unit.
    fn small(&self, value: f64) -> String {
        format!("{} m{}", three(1e3 * value), self.unit)
    }

    /// Changes that help but leave a cable mode damped less than the joints are.
    fn less_damped(&self, limit: &JointLimit, before: &JointFigures) -> String {
        let worse = limit.changed.iter().filter(|(_, after)| {
            let less = after.damping < 0.9 * before.damping && after.damping < self.gains.damping;
            limit.is_helped_by(after) && less
        });
        let worse = worse.map(|(change, after)| {
            format!(
                "; with a {} the winches damp the cables' mode by a ratio of {:.2}, not {:.2}",
                change.name(),
                after.damping,
                before.damping
            )
        });
        worse.collect()
    }
}

/// Three significant digits, as far as decimals go.
fn three(value: f64) -> String {
    let decimals = (0..=4).find(|k| value.abs() * 10f64.powi(*k) >= 99.5).unwrap_or(4);
    format!("{value:.*}", usize::try_from(decimals).unwrap_or(0))
}

/// `a`, `a or b`, `a, b or c`.
fn listed(items: &[String], last: &str) -> String {
    match items {
        [] => String::new(),
        [one] => one.clone(),
        [first @ .., end] => format!("{} {last} {end}", first.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_are_read_as_sentences() {
        let items = ["a".to_owned(), "b".to_owned(), "c".to_owned()];
        assert_eq!(listed(&items, "or"), "a, b or c");
        assert_eq!(listed(&items[..1], "or"), "a");
        assert_eq!([12.345, 0.5, 123.4].map(three), ["12.3", "0.500", "123"]);
    }
}
