//! The compensation variants that experiments compare: the one list from which tables, files and command
//! lines derive.

use crate::Error;
use serde::{Deserialize, Serialize};
use std::cmp::Ordering;
use std::fmt;
use std::str::FromStr;

/// How transmission losses of the cables are compensated.
///
/// `None`, `Capstan` and `Paper` command drive tensions. The others command winch speeds and, on the arm,
/// differ in where the state of the cables comes from.
///
/// Serialized by [`name`](Self::name), and ordered by it, as keys of a map in a file are.
///
/// # Example
/// ```
/// use sinew_lab::CompensationVariant;
/// let variant: CompensationVariant = "no_observer".parse()?;
/// assert_eq!(variant, CompensationVariant::NoObserver);
/// assert!(!CompensationVariant::BENCH.contains(&variant));
/// # Ok::<(), sinew_lab::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CompensationVariant {
    /// No compensation: the drive tension is the tension desired at the anchor.
    None,
    /// Static capstan with one friction angle and a pretension per cable (7, 8).
    Capstan,
    /// The networks of `yuan2023` (17).
    Paper,
    /// The inverse of a model that was identified from a log alone.
    Inverted,
    /// Winch speeds from encoders and an integral; anchor tensions are not estimated.
    NoObserver,
    /// Winch speeds from cable observers, without the joints' disturbance observer.
    NoDisturbanceObserver,
    /// Winch speeds from cable observers: the default.
    Observer,
    /// Winch speeds from the true state of the cables: the upper bound of what compensation can reach.
    Perfect,
}

impl CompensationVariant {
    /// All variants, in the order of tables.
    pub const ALL: [Self; 8] = [
        Self::None,
        Self::Capstan,
        Self::Paper,
        Self::Inverted,
        Self::NoObserver,
        Self::NoDisturbanceObserver,
        Self::Observer,
        Self::Perfect,
    ];

    /// The variants of an arm's controller, in the order of tables.
    pub const ARM: [Self; 7] = [
        Self::None,
        Self::Capstan,
        Self::Paper,
        Self::NoObserver,
        Self::NoDisturbanceObserver,
        Self::Observer,
        Self::Perfect,
    ];

    /// The variants that a single cable on the two-drive bench can be calibrated for, in the order of tables.
    pub const BENCH: [Self; 5] = [Self::None, Self::Capstan, Self::Paper, Self::Inverted, Self::Observer];

    /// Name in files and on command lines.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Capstan => "capstan",
            Self::Paper => "paper",
            Self::Inverted => "inverted",
            Self::NoObserver => "no_observer",
            Self::NoDisturbanceObserver => "no_disturbance_observer",
            Self::Observer => "observer",
            Self::Perfect => "perfect",
        }
    }

    /// One line on what the variant does, for help texts.
    #[must_use]
    pub const fn summary(self) -> &'static str {
        match self {
            Self::None => "drive tensions, no compensation",
            Self::Capstan => "drive tensions, static capstan model",
            Self::Paper => "drive tensions, the networks of Yuan et al. (2023)",
            Self::Inverted => "winch speeds, a model identified from a log, inverted; its drag adapted",
            Self::NoObserver => "winch speeds from encoders, no cable observer",
            Self::NoDisturbanceObserver => "winch speeds, cable observers, no joint disturbance observer",
            Self::Observer => "winch speeds, cable observers",
            Self::Perfect => "winch speeds, true state of the cables",
        }
    }
}

impl fmt::Display for CompensationVariant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for CompensationVariant {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self, Error> {
        let found = Self::ALL.into_iter().find(|variant| variant.name() == name);
        found.ok_or_else(|| Error::experiment("compensation variant", EXPECTED_NAMES, &name))
    }
}

const EXPECTED_NAMES: &str =
    "none, capstan, paper, inverted, no_observer, no_disturbance_observer, observer or perfect";

impl Ord for CompensationVariant {
    fn cmp(&self, other: &Self) -> Ordering {
        self.name().cmp(other.name())
    }
}

impl PartialOrd for CompensationVariant {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_parse_print_and_serialize_alike() {
        for variant in CompensationVariant::ALL {
            assert_eq!(variant.name().parse::<CompensationVariant>().unwrap(), variant);
            assert_eq!(variant.to_string(), variant.name());
            assert_eq!(serde_json::to_string(&variant).unwrap(), format!("\"{variant}\""));
            assert!(EXPECTED_NAMES.contains(variant.name()));
        }
        assert!("Observer".parse::<CompensationVariant>().is_err());
    }
}
