//! From the text of a catalogue to motors, reducers, winches and cords.

use super::fields::{CORD, Field, MOTOR, REDUCER, WINCH, complete, keys};
use super::listing::{Listing, ValueSource};
use crate::Error;
use crate::description::document::{Document, Named, Table};
use crate::description::domain::{FROM_ONE, NON_NEGATIVE, POSITIVE};
use crate::description::error::DescriptionError;
use crate::drive::{
    Catalogue, CatalogueCord, CatalogueMotor, CatalogueReducer, CatalogueWinch, Cord, Motor, ReducerLosses,
    Winch,
};
use alloc::string::{String, ToString};
use alloc::vec::Vec;

/// Keys of every entry, and those of a motor and of a reducer beside them.
const ENTRY: [&str; 4] = ["name", "source", "assumed", "parameters"];
const OF_MOTOR: [&str; 2] = ["mass_kg", "no_load_current_a"];
const WORDS_OF_MOTOR: [&str; 4] = ["mass_kg", "no_load_current_a", "drives", "reducer"];
const OF_REDUCER: [&str; 6] =
    ["ratios", "mass_kg", "inertia_kg_m2", "continuous_torque_nm", "peak_torque_nm", "top_speed_rad_per_s"];
/// The word in `assumed` for every number of an entry.
const ALL: &str = "all";
/// Ratios that one reducer comes in.
const MAX_RATIOS: usize = 100;

impl Catalogue {
    /// The catalogue of this repository, `models/motors.toml`.
    ///
    /// # Errors
    /// None: a test reads it.
    pub fn built_in() -> Result<Self, DescriptionError> {
        Self::from_toml("the built-in catalogue", sinew_models::MOTORS)
    }

    /// Reads a catalogue and checks every number; `file` names the text in errors.
    ///
    /// TOML: tables `[[motor]]`, `[[reducer]]`, `[[winch]]` and, where there are any, `[[cord]]`, each with a
    /// `name`, a `source`, the keys of the numbers that have none in `assumed` (`"all"` for every one),
    /// catalogue data, and `parameters` as [`Motor`], [`ReducerLosses`], [`Winch`], [`Cord`]. A motor of
    /// `drives` is offered only to their machines; one with a `reducer` comes with that alone.
    ///
    /// # Errors
    /// The first error: file, line, entry, key, value and what was expected.
    pub fn from_toml(file: &str, text: &str) -> Result<Self, DescriptionError> {
        let document = Document::new(file, text);
        let table = document.parse()?;
        let root = document.root(&table, "catalogue");
        root.check_keys(&["motor", "reducer", "winch", "cord"])?;
        let motors = entries(&root, "motor", &WORDS_OF_MOTOR, motor)?;
        let mut reducers = entries(&root, "reducer", &OF_REDUCER, reducer)?;
        entries(&root, "motor", &WORDS_OF_MOTOR, |table, _| {
            let Some(entry) = table.entry("reducer") else { return Ok(()) };
            let name = entry.text("a name")?;
            match reducers.iter_mut().find(|reducer| reducer.name == name) {
                Some(own) => own.built_in = true,
                None => return Err(entry.refuse("the name of a [[reducer]]")),
            }
            Ok(())
        })?;
        Ok(Self { motors, reducers, winches: entries(&root, "winch", &[], winch)?, cords: cords(&root)? })
    }
}

/// Name, source and assumed numbers of an entry.
struct Head {
    name: String,
    source: String,
    assumed: Vec<String>,
}

fn entries<T>(
    root: &Table<'_>,
    kind: &str,
    own: &[&'static str],
    read: impl FnMut(&Table<'_>, Named) -> Result<T, DescriptionError>,
) -> Result<Vec<T>, DescriptionError> {
    let found = any_entries(root, kind, own, read)?;
    if found.is_empty() {
        let none = alloc::format!("there is no {kind}: expected at least one table [[{kind}]]");
        return Err(root.error(&none));
    }
    Ok(found)
}

fn any_entries<T>(
    root: &Table<'_>,
    kind: &str,
    own: &[&'static str],
    read: impl FnMut(&Table<'_>, Named) -> Result<T, DescriptionError>,
) -> Result<Vec<T>, DescriptionError> {
    let known: Vec<&str> = ENTRY.iter().chain(own).copied().collect();
    let (tables, mut read) = (root.tables(kind, "name", &known)?, read);
    tables.into_iter().map(|(table, named)| read(&table, named)).collect()
}

/// From the thinnest to the thickest.
fn cords(root: &Table<'_>) -> Result<Vec<CatalogueCord>, DescriptionError> {
    let mut cords = any_entries(root, "cord", &[], cord)?;
    cords.sort_by(|a, b| a.parameters.diameter.total_cmp(&b.parameters.diameter));
    Ok(cords)
}

/// `own` are the numbers beside the parameters.
fn head<T>(
    table: &Table<'_>,
    named: Named,
    own: &[&'static str],
    fields: &[Field<T>],
) -> Result<Head, DescriptionError> {
    let source = table.required("source")?.text("where its numbers come from")?.to_string();
    let mut numbers = keys(fields, own);
    numbers.insert(0, ALL);
    let assumed = table.required("assumed")?.words(&numbers)?;
    Ok(Head { name: named.text, source, assumed: assumed.into_iter().map(ToString::to_string).collect() })
}

/// All numbers of the table `parameters`.
fn parameters<T>(
    table: &Table<'_>,
    fields: &[Field<T>],
    on: T,
    validate: fn(&T) -> Result<(), Error>,
) -> Result<T, DescriptionError> {
    let inner = table.required("parameters")?.inner_table(&keys(fields, &[]))?;
    complete(&[inner], fields, on, validate, &mut Listing::default(), ("", ValueSource::Catalogue))
}

/// A name, where one is said.
fn word(table: &Table<'_>, key: &str) -> Result<Option<String>, DescriptionError> {
    table.entry(key).map(|entry| entry.text("a name").map(ToString::to_string)).transpose()
}

fn motor(table: &Table<'_>, named: Named) -> Result<CatalogueMotor, DescriptionError> {
    let Head { name, source, assumed } = head(table, named, &OF_MOTOR, MOTOR)?;
    Ok(CatalogueMotor {
        name,
        source,
        assumed,
        mass: table.required("mass_kg")?.number(POSITIVE)?,
        no_load_current: table.required("no_load_current_a")?.number(NON_NEGATIVE)?,
        drives: word(table, "drives")?,
        reducer: word(table, "reducer")?,
        parameters: parameters(table, MOTOR, Motor::class_35_mm(), |motor| motor.validate())?,
    })
}

fn reducer(table: &Table<'_>, named: Named) -> Result<CatalogueReducer, DescriptionError> {
    let Head { name, source, assumed } = head(table, named, &OF_REDUCER, REDUCER)?;
    let made = table.required("ratios")?;
    let ratios = made.list(FROM_ONE)?;
    if !(1..=MAX_RATIOS).contains(&ratios.len()) {
        return Err(made.refuse("a list of 1..=100 numbers"));
    }
    let continuous_torque = table.required("continuous_torque_nm")?.number(POSITIVE)?;
    let peak = table.required("peak_torque_nm")?;
    let peak_torque = peak.number(POSITIVE)?;
    if peak_torque < continuous_torque {
        return Err(peak.refuse("a finite number >= the continuous torque"));
    }
    let losses = ReducerLosses {
        efficiency: 1.0,
        friction: 0.0,
        viscous: 0.0,
        backlash: 0.0,
        ripple: 0.0,
        ripple_per_turn: 1.0,
    };
    Ok(CatalogueReducer {
        name,
        source,
        assumed,
        ratios,
        mass: table.required("mass_kg")?.number(POSITIVE)?,
        inertia: table.required("inertia_kg_m2")?.number(NON_NEGATIVE)?,
        continuous_torque,
        peak_torque,
        top_speed: table.required("top_speed_rad_per_s")?.number(POSITIVE)?,
        built_in: false,
        // Every number has a domain of its own: nothing is left to validate.
        parameters: parameters(table, REDUCER, losses, |_| Ok(()))?,
    })
}

fn winch(table: &Table<'_>, named: Named) -> Result<CatalogueWinch, DescriptionError> {
    let Head { name, source, assumed } = head(table, named, &[], WINCH)?;
    let parameters = parameters(table, WINCH, Winch::fifteen_millimetres(), |winch| winch.validate())?;
    Ok(CatalogueWinch { name, source, assumed, parameters })
}

fn cord(table: &Table<'_>, named: Named) -> Result<CatalogueCord, DescriptionError> {
    let Head { name, source, assumed } = head(table, named, &[], CORD)?;
    let none = Cord { diameter: 0.0, breaking_load: 0.0, stiffness: 0.0, friction: 0.0, drag: 0.0 };
    // Every number has a domain of its own: nothing is left to validate.
    Ok(CatalogueCord { name, source, assumed, parameters: parameters(table, CORD, none, |_| Ok(()))? })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive::Reducer;
    use std::format;

    const OURS: &str = sinew_models::MOTORS;

    fn refused(text: &str) -> DescriptionError {
        Catalogue::from_toml("motors.toml", text).unwrap_err()
    }

    #[test]
    fn the_catalogues_drive_of_the_paper_equals_the_twins() {
        let catalogue = Catalogue::built_in().unwrap();
        assert_eq!(catalogue.motor("class_35mm_120w").unwrap().parameters, Motor::class_35_mm());
        assert_eq!(catalogue.reducer("class_53").unwrap().reducer(53.0), Reducer::ratio_53());
        assert_eq!(catalogue.winch("drum_15mm").unwrap().parameters, Winch::fifteen_millimetres());
        assert!(catalogue.motors.len() >= 5 && catalogue.reducers.len() >= 4);
    }

    #[test]
    fn cords_come_from_the_thinnest_to_the_thickest_and_may_be_missing() {
        let cords = Catalogue::built_in().unwrap().cords;
        let rises = |of: fn(&Cord) -> f64| {
            cords.windows(2).all(|pair| of(&pair[0].parameters) < of(&pair[1].parameters))
        };
        assert!(cords.len() >= 5 && rises(|cord| cord.diameter));
        // Of one make, a thicker cord holds more and is stiffer.
        for make in ["braid", "steel"] {
            let same: Vec<_> = cords.iter().filter(|cord| cord.name.starts_with(make)).collect();
            let holds = |of: fn(&Cord) -> f64| {
                same.windows(2).all(|pair| of(&pair[0].parameters) < of(&pair[1].parameters))
            };
            assert!(same.len() > 2 && holds(|cord| cord.breaking_load) && holds(|cord| cord.stiffness));
        }
        let without = &OURS[..OURS.find("[[cord]]").unwrap()];
        assert!(Catalogue::from_toml("motors.toml", without).unwrap().cords.is_empty());
    }

    /// What the catalogue says with one text in the place of another; the error is in the changed line.
    fn wrong(from: &str, to: &str) -> String {
        assert!(OURS.contains(from), "{from}");
        let text = OURS.replacen(from, to, 1);
        let changed = text.lines().zip(OURS.lines()).position(|(a, b)| a != b).unwrap() + 1;
        let error = refused(&text);
        assert_eq!(error.line, changed, "{error}");
        error.to_string()
    }

    #[test]
    fn errors_name_the_line_the_value_and_the_expected_domain() {
        let has = |text: String, parts: &[&str]| {
            assert!(parts.iter().all(|part| text.contains(part)), "{text}: {parts:?}");
        };
        let ohm = "resistance_ohm = 0.568";
        has(wrong(ohm, "resistance_ohm = -1.0"), &["maxon_re35_24v", "resistance_ohm is -1.0", "> 0"]);
        has(wrong(ohm, "resistance_ohm = nan"), &["maxon_re35_24v", "resistance_ohm is nan", "finite"]);
        has(wrong(ohm, "resistance_ohms = 0.568"), &["`resistance_ohms`", "expected `resistance_ohm`?"]);
        has(wrong(ohm, "resistance_ohm = \"low\""), &["resistance_ohm is \"low\"", "number"]);
        has(
            wrong("efficiency = 0.72", "efficiency = 1.2"),
            &["maxon_gp42c_3", "efficiency is 1.2", "(0, 1]"],
        );
        has(wrong("ratios = [53.0]", "ratios = []"), &["class_53", "ratios is []", "1..=100"]);
        for ratio in ["0.5", "inf", "nan", "\"53\""] {
            has(wrong("ratios = [53.0]", &format!("ratios = [53.0, {ratio}]")), &["ratios", ratio, ">= 1"]);
        }
        has(wrong("\"viscous_nm_s_per_rad\"", "\"colour\""), &["assumed", "colour"]);
        let gears = "reducer = \"feetech_sts3215_12v_gears\"";
        has(wrong(gears, "reducer = \"gears\""), &["feetech_sts3215_12v", "gears", "[[reducer]]"]);
        has(wrong("name = \"drum_20mm\"", "name = \"drum_15mm\""), &["a name of its own"]);
        has(wrong("{ radius_m = 0.020", "{ radius_m = 0.0"), &["drum_20mm", "radius_m is 0.0", "> 0"]);
    }

    #[test]
    fn a_peak_torque_is_finite_and_no_less_than_the_continuous_one() {
        let start = OURS.find("[[reducer]]").unwrap();
        let line = OURS[start..].lines().find(|line| line.starts_with("peak_torque_nm")).unwrap();
        for peak in ["1e-9", "inf", "0"] {
            let message = wrong(line, &format!("peak_torque_nm = {peak}"));
            assert!(message.contains("peak_torque_nm is") && message.contains("expected"), "{message}");
        }
    }

    #[test]
    fn an_empty_or_cut_catalogue_is_refused() {
        for empty in ["", "motor = []\nreducer = []\nwinch = []"] {
            assert!(refused(empty).to_string().contains("no motor: expected at least one"));
        }
        for cut in (0..OURS.len()).step_by(97) {
            let _ = Catalogue::from_toml("motors.toml", &OURS[..cut]);
        }
    }

    #[test]
    fn what_is_no_catalogue_is_refused_where_it_stands() {
        for (text, line) in
            [("colour = 1", 1), ("motor = []\n  colour = 1", 2), ("motor = []\n \"\u{e9}\" = 1", 2)]
        {
            let error = refused(text);
            assert_eq!((error.line, &*error.place), (line, "catalogue"), "{error}");
            assert!(error.problem.contains("is no key of it: expected one of `motor`"), "{error}");
        }
        assert!(refused("motor = [").to_string().starts_with("motors.toml:1: column "));
    }

    #[test]
    fn every_kind_of_part_says_where_its_numbers_come_from() {
        for (kind, name) in [
            ("motor", "maxon_re35_24v"),
            ("reducer", "maxon_gp32c_3"),
            ("winch", "drum_15mm"),
            ("cord", "steel_0_5mm"),
        ] {
            let at = OURS.find(&format!("name = \"{name}\"")).unwrap();
            let (before, entry) = OURS.split_at(at);
            let changed = |key: &str, to: &str| {
                let start = entry.find(&format!("\n{key} = ")).unwrap() + 1;
                let end = start + entry[start..].find('\n').unwrap();
                let error = refused(&format!("{before}{}{to}{}", &entry[..start], &entry[end..]));
                assert_eq!(error.line, OURS[..at + start].matches('\n').count() + 1, "{error}");
                assert_eq!(error.place, format!("[[{kind}]] `{name}`"));
                error.problem
            };
            assert!(changed("source", "source = \"\"").contains("expected where its numbers come from"));
            // A number of no part, the beginning of one's name, and a number of another part.
            let foreign = if kind == "winch" || kind == "cord" { "backlash_rad" } else { "lead_m" };
            for number in ["colour", "r", "assume", foreign] {
                let problem = changed("assumed", &format!("assumed = [\"{number}\"]"));
                assert!(problem.contains(number), "{problem}");
            }
        }
    }
}
