//! Motors, reducers and winches to choose from, each number with its source.

use super::motor::Motor;
use super::reducer::Reducer;
use super::winch::Winch;
use crate::error::{Error, non_negative, positive, within};
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;
use serde::{Deserialize, Serialize};
use toml::Spanned;

/// Motors, reducers and winches for the design of drives.
///
/// TOML: tables `[[motor]]`, `[[reducer]]`, `[[winch]]`, each with a `name`, a `source`, the names of the
/// numbers that have none in `assumed` (`"all"` for every one), catalogue data, and `parameters` as
/// [`Motor`], [`Reducer`] without its ratio, [`Winch`].
///
/// # Example
/// ```
/// use sinew::drive::{Catalogue, Motor};
/// let catalogue = Catalogue::built_in().expect("a file of this repository");
/// let motor = catalogue.motor("class_35mm_120w").expect("the paper's");
/// assert_eq!(motor.parameters, Motor::class_35_mm());
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Catalogue {
    /// In file order, at least one.
    pub motors: Vec<CatalogueMotor>,
    /// In file order, at least one.
    pub reducers: Vec<CatalogueReducer>,
    /// In file order, at least one.
    pub winches: Vec<CatalogueWinch>,
}

/// A motor with its amplifier.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CatalogueMotor {
    /// Unique among motors.
    pub name: String,
    /// Where its numbers come from.
    pub source: String,
    /// Numbers without a source.
    pub assumed: Vec<String>,
    /// kg.
    #[serde(rename = "mass_kg")]
    pub mass: f64,
    /// No-load current, A.
    #[serde(rename = "no_load_current_a")]
    pub no_load_current: f64,
    /// The motor itself.
    pub parameters: Motor,
}

/// A reducer that comes in several ratios.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CatalogueReducer {
    /// Unique among reducers.
    pub name: String,
    /// Where its numbers come from.
    pub source: String,
    /// Numbers without a source.
    pub assumed: Vec<String>,
    /// Turns of the motor per turn of the winch, each >= 1.
    pub ratios: Vec<f64>,
    /// kg.
    #[serde(rename = "mass_kg")]
    pub mass: f64,
    /// At the motor's shaft, kg m^2.
    #[serde(rename = "inertia_kg_m2")]
    pub inertia: f64,
    /// Continuous torque at the winch, Nm.
    #[serde(rename = "continuous_torque_nm")]
    pub continuous_torque: f64,
    /// Peak torque at the winch, for a second, Nm.
    #[serde(rename = "peak_torque_nm")]
    pub peak_torque: f64,
    /// Of the motor's shaft, rad/s.
    #[serde(rename = "top_speed_rad_per_s")]
    pub top_speed: f64,
    /// Losses and backlash.
    pub parameters: ReducerLosses,
}

/// A [`Reducer`] without its ratio.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReducerLosses {
    /// 1.
    pub efficiency: f64,
    /// Nm at the motor.
    #[serde(rename = "friction_nm")]
    pub friction: f64,
    /// Nm s/rad at the motor.
    #[serde(rename = "viscous_nm_s_per_rad")]
    pub viscous: f64,
    /// rad at the winch.
    #[serde(rename = "backlash_rad")]
    pub backlash: f64,
    /// 1.
    pub ripple: f64,
    /// 1/turn of the motor.
    pub ripple_per_turn: f64,
}

/// A winch.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CatalogueWinch {
    /// Unique among winches.
    pub name: String,
    /// Where its numbers come from.
    pub source: String,
    /// Numbers without a source.
    pub assumed: Vec<String>,
    /// The winch itself.
    pub parameters: Winch,
}

/// The first error in a catalogue.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{line}: {place}: {problem}")]
pub struct CatalogueError {
    /// Line, from 1.
    pub line: usize,
    /// Kind and name of the entry, or column.
    pub place: String,
    /// Field, value and what was expected.
    pub problem: String,
}

impl CatalogueReducer {
    /// The reducer of a ratio.
    #[must_use]
    pub fn reducer(&self, ratio: f64) -> Reducer {
        let ReducerLosses { efficiency, friction, viscous, backlash, ripple, ripple_per_turn } =
            self.parameters;
        Reducer { ratio, efficiency, friction, viscous, backlash, ripple, ripple_per_turn }
    }
}

impl Catalogue {
    /// The catalogue of this repository, `models/motors.toml`.
    ///
    /// # Errors
    /// None: a test reads it.
    pub fn built_in() -> Result<Self, CatalogueError> {
        Self::from_toml(include_str!("../../../../models/motors.toml"))
    }

    /// Reads a catalogue and checks every number.
    ///
    /// # Errors
    /// The first error: line, entry, field, value and what was expected.
    pub fn from_toml(text: &str) -> Result<Self, CatalogueError> {
        let file: File = toml::from_str(text).map_err(|error| {
            let at = error.span().map_or(0, |span| span.start);
            let start = text.get(..at).and_then(|before| before.rfind('\n')).map_or(0, |i| i + 1);
            let column = text.get(start..at).map_or(0, |before| before.chars().count()) + 1;
            CatalogueError {
                line: line(text, at),
                place: format!("column {column}"),
                problem: error.message().into(),
            }
        })?;
        Ok(Self {
            motors: checked(text, "motor", file.motor)?,
            reducers: checked(text, "reducer", file.reducer)?,
            winches: checked(text, "winch", file.winch)?,
        })
    }

    /// A motor by its name.
    #[must_use]
    pub fn motor(&self, name: &str) -> Option<&CatalogueMotor> {
        self.motors.iter().find(|motor| motor.name == name)
    }

    /// A reducer by its name.
    #[must_use]
    pub fn reducer(&self, name: &str) -> Option<&CatalogueReducer> {
        self.reducers.iter().find(|reducer| reducer.name == name)
    }

    /// A winch by its name.
    #[must_use]
    pub fn winch(&self, name: &str) -> Option<&CatalogueWinch> {
        self.winches.iter().find(|winch| winch.name == name)
    }
}

/// The file as written.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    motor: Vec<Spanned<CatalogueMotor>>,
    reducer: Vec<Spanned<CatalogueReducer>>,
    winch: Vec<Spanned<CatalogueWinch>>,
}

trait Entry {
    fn name(&self) -> &str;
    fn provenance(&self) -> (&str, &[String]);
    fn validate(&self) -> Result<(), Error>;
}

impl Entry for CatalogueMotor {
    fn name(&self) -> &str {
        &self.name
    }

    fn provenance(&self) -> (&str, &[String]) {
        (&self.source, &self.assumed)
    }

    fn validate(&self) -> Result<(), Error> {
        positive("mass", self.mass)?;
        non_negative("no_load_current", self.no_load_current)?;
        self.parameters.validate()
    }
}

impl Entry for CatalogueReducer {
    fn name(&self) -> &str {
        &self.name
    }

    fn provenance(&self) -> (&str, &[String]) {
        (&self.source, &self.assumed)
    }

    fn validate(&self) -> Result<(), Error> {
        positive("mass", self.mass)?;
        non_negative("inertia", self.inertia)?;
        positive("continuous_torque", self.continuous_torque)?;
        let peak = self.peak_torque;
        let enough = peak.is_finite() && peak >= self.continuous_torque;
        within("peak_torque", "a finite number >= the continuous torque", peak, enough)?;
        positive("top_speed", self.top_speed)?;
        let count = self.ratios.len();
        within("ratios", "a list of 1..=100 numbers", count as f64, (1..=100).contains(&count))?;
        self.ratios.iter().try_for_each(|ratio| {
            within("ratios", "finite numbers >= 1", *ratio, ratio.is_finite() && *ratio >= 1.0)?;
            self.reducer(*ratio).validate()
        })
    }
}

impl Entry for CatalogueWinch {
    fn name(&self) -> &str {
        &self.name
    }

    fn provenance(&self) -> (&str, &[String]) {
        (&self.source, &self.assumed)
    }

    fn validate(&self) -> Result<(), Error> {
        self.parameters.validate()
    }
}

/// Checks that names are unique, sources are given and every number is in its domain.
fn checked<T: Entry>(text: &str, kind: &str, given: Vec<Spanned<T>>) -> Result<Vec<T>, CatalogueError> {
    let mut known: Vec<T> = Vec::with_capacity(given.len());
    for entry in given {
        let span = entry.span();
        let entry = entry.into_inner();
        let wrong = |key: &str, problem: String| {
            let place =
                if entry.name().is_empty() { kind.to_string() } else { format!("{kind} `{}`", entry.name()) };
            CatalogueError { line: line_of(text, span.start, key), place, problem }
        };
        if entry.name().is_empty() {
            return Err(wrong("name", "name is empty: expected one".into()));
        }
        if known.iter().any(|other| other.name() == entry.name()) {
            return Err(wrong("name", format!("its name is taken already by another {kind}")));
        }
        let (source, assumed) = entry.provenance();
        if source.is_empty() {
            return Err(wrong("source", "source is empty: expected where its numbers come from".into()));
        }
        let of = after(text, span.start);
        if let Some(unknown) = assumed.iter().find(|name| *name != "all" && key_line(of, name).is_none()) {
            return Err(wrong(
                "assumed",
                format!("assumed: expected names of its numbers or `all`, got `{unknown}`"),
            ));
        }
        entry.validate().map_err(|error| {
            let name = if let Error::OutOfDomain { name, .. } = error { name } else { "" };
            wrong(name, error.to_string())
        })?;
        known.push(entry);
    }
    if known.is_empty() {
        let problem = format!("there is no {kind}: expected at least one");
        return Err(CatalogueError { line: 1, place: kind.to_string(), problem });
    }
    Ok(known)
}

fn line(text: &str, at: usize) -> usize {
    text.as_bytes().iter().take(at).filter(|byte| **byte == b'\n').count() + 1
}

/// The text of the entry that starts at `at`: up to the next `[[`.
fn after(text: &str, at: usize) -> &str {
    let rest = text.get(at..).unwrap_or("");
    let header = rest.find('\n').unwrap_or(0);
    let end = rest.get(header..).and_then(|body| body.find("\n[[")).map_or(rest.len(), |end| header + end);
    rest.get(..end).unwrap_or(rest)
}

/// Lines below the start of an entry at which a number stands whose name, its unit aside, is `name`.
fn key_line(entry: &str, name: &str) -> Option<usize> {
    entry.lines().position(|written| {
        let is_key = |part: &str| {
            let key = part.trim_start().trim_start_matches("parameters").trim_start_matches([' ', '=', '{']);
            let rest = key.strip_prefix(name);
            rest.is_some_and(|rest| rest.contains('=') && rest.starts_with(['_', ' ', '=']))
        };
        let written = written.split('#').next().unwrap_or("");
        written.split(',').any(is_key)
    })
}

fn line_of(text: &str, at: usize, name: &str) -> usize {
    line(text, at) + key_line(after(text, at), name).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::ToString;

    const OURS: &str = include_str!("../../../../models/motors.toml");

    #[test]
    fn the_catalogues_drive_of_the_paper_equals_the_twins() {
        let catalogue = Catalogue::built_in().unwrap();
        assert_eq!(catalogue.motor("class_35mm_120w").unwrap().parameters, Motor::class_35_mm());
        assert_eq!(catalogue.reducer("class_53").unwrap().reducer(53.0), Reducer::ratio_53());
        assert_eq!(catalogue.winch("drum_15mm").unwrap().parameters, Winch::fifteen_millimetres());
        assert!(catalogue.motors.len() >= 5 && catalogue.reducers.len() >= 4);
    }

    #[test]
    fn errors_name_the_line_the_value_and_the_expected_domain() {
        let wrong = |from: &str, to: &str| {
            assert!(OURS.contains(from), "{from}");
            let text = OURS.replacen(from, to, 1);
            let changed = text.lines().zip(OURS.lines()).position(|(a, b)| a != b).unwrap() + 1;
            let error = Catalogue::from_toml(&text).unwrap_err();
            assert_eq!(error.line, changed, "{error}");
            error.to_string()
        };
        let has = |text: String, parts: &[&str]| {
            assert!(parts.iter().all(|part| text.contains(part)), "{text}: {parts:?}");
        };
        has(
            wrong("resistance_ohm = 0.568", "resistance_ohm = -1.0"),
            &["maxon_re35_24v", "resistance", "> 0", "-1"],
        );
        has(
            wrong("resistance_ohm = 0.568", "resistance_ohm = nan"),
            &["maxon_re35_24v", "resistance", "NaN"],
        );
        has(wrong("resistance_ohm = 0.568", "resistance_ohms = 0.568"), &["resistance_ohms", "expected"]);
        has(wrong("resistance_ohm = 0.568", "resistance_ohm = \"low\""), &["column", "low"]);
        has(
            wrong("efficiency = 0.72", "efficiency = 1.2"),
            &["maxon_gp42c_3", "efficiency", "(0, 1]", "1.2"],
        );
        has(wrong("ratios = [53.0]", "ratios = []"), &["class_53", "ratios"]);
        has(wrong("\"viscous_nm_s_per_rad\"", "\"colour\""), &["assumed", "colour"]);
        has(wrong("name = \"drum_20mm\"", "name = \"drum_15mm\""), &["taken"]);
        has(wrong("{ radius_m = 0.020", "{ radius_m = 0.0"), &["drum_20mm", "radius", "> 0"]);
    }

    #[test]
    fn an_empty_or_cut_catalogue_is_refused() {
        assert!(Catalogue::from_toml("").is_err());
        let empty = Catalogue::from_toml("motor = []\nreducer = []\nwinch = []").unwrap_err();
        assert!(empty.to_string().contains("at least one"));
        for cut in (0..OURS.len()).step_by(97) {
            let _ = Catalogue::from_toml(&OURS[..cut]);
        }
    }

    #[test]
    fn what_is_no_catalogue_is_refused_where_it_stands() {
        for (text, place) in [
            ("colour = 1", "1: column 1: "),
            ("motor = []\nreducer = []\nwinch = []\n  colour = 1", "4: column 3: "),
            ("motor = []\nreducer = []\n \"\u{e9}\" = 1", "3: column 2: "),
        ] {
            let error = Catalogue::from_toml(text).unwrap_err().to_string();
            assert!(error.starts_with(place) && error.contains("unknown field"), "{error}");
        }
    }

    #[test]
    fn every_kind_of_part_says_where_its_numbers_come_from() {
        for (kind, name) in
            [("motor", "maxon_re35_24v"), ("reducer", "maxon_gp32c_3"), ("winch", "drum_15mm")]
        {
            let at = OURS.find(&format!("name = \"{name}\"")).unwrap();
            let (before, entry) = OURS.split_at(at);
            let changed = |key: &str, to: &str| {
                let start = entry.find(&format!("\n{key} = ")).unwrap() + 1;
                let end = start + entry[start..].find('\n').unwrap();
                let error =
                    Catalogue::from_toml(&format!("{before}{}{to}{}", &entry[..start], &entry[end..]))
                        .unwrap_err();
                assert_eq!(error.line, line(OURS, at + start), "{error}");
                assert_eq!(error.place, format!("{kind} `{name}`"));
                error.problem
            };
            assert!(changed("source", "source = \"\"").contains("source is empty"));
            // A number of no part, the beginning of one's name, and a number of another part further below.
            let foreign = if kind == "winch" { "backlash_rad" } else { "lead_m" };
            for number in ["colour", "r", "assume", foreign] {
                let problem = changed("assumed", &format!("assumed = [\"{number}\"]"));
                assert!(problem.contains(number), "{problem}");
            }
        }
    }

    #[test]
    fn a_reducers_torques_and_ratios_are_finite_and_in_their_order() {
        let reducer = Catalogue::built_in().unwrap().reducers.swap_remove(0);
        let wrong = |change: &dyn Fn(&mut CatalogueReducer)| {
            let mut reducer = reducer.clone();
            change(&mut reducer);
            reducer.validate().unwrap_err().to_string()
        };
        assert!(reducer.validate().is_ok());
        assert!(wrong(&|r| r.peak_torque = 0.9 * r.continuous_torque).starts_with("peak_torque"));
        assert!(wrong(&|r| r.peak_torque = f64::INFINITY).starts_with("peak_torque"));
        for ratio in [0.5, f64::INFINITY, f64::NAN] {
            assert!(wrong(&|r| r.ratios.push(ratio)).starts_with("ratios"), "{ratio}");
        }
    }
}
