//! Drives by the names of their parts in the catalogue, or by numbers.

use super::fields::{MOTOR, REDUCER, WINCH, complete, keys, overlay};
use super::listing::{Listing, ValueSource, source_of};
use crate::description::document::{Entry, Table};
use crate::description::domain::{FROM_ONE, NON_NEGATIVE, POSITIVE};
use crate::description::error::DescriptionError;
use crate::drive::sizing::Design;
use crate::drive::{Catalogue, CatalogueMotor, CatalogueReducer, CatalogueWinch, DriveParameters};
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;

/// Keys of `[[drive]]`.
pub(super) const DRIVE: [&str; 8] =
    ["name", "motor", "reducer", "ratio", "winch", "acceleration_m_per_s2", "max_tension_n", "min_tension_n"];
/// Keys of a motor and of a reducer in numbers, beside those of their structures.
const MOTOR_MORE: [&str; 2] = ["like", "no_load_current_a"];
const REDUCER_MORE: [&str; 3] = ["like", "inertia_kg_m2", "top_speed_rad_per_s"];

/// Parts of the drive of a muscle for which none is named.
pub(super) const DEFAULT_PARTS: [&str; 3] = ["class_35mm_120w", "class_53", "drum_15mm"];

/// A drive of a machine file.
#[derive(Debug, Clone)]
pub(super) struct NamedDrive {
    pub(super) name: String,
    pub(super) line: usize,
    /// With the default's sensors.
    pub(super) parameters: DriveParameters,
}

/// All drives of a file.
pub(super) fn read(root: &Table<'_>, listing: &mut Listing) -> Result<Vec<NamedDrive>, DescriptionError> {
    let tables = root.tables("drive", "name", &DRIVE)?;
    if tables.is_empty() {
        return Ok(Vec::new());
    }
    let catalogue = Catalogue::built_in()?;
    let mut drives = Vec::new();
    for (table, named) in tables {
        listing.begin(&table.place);
        let parameters = drive(&table, &catalogue, listing)?;
        drives.push(NamedDrive { name: named.text, line: named.line, parameters });
    }
    Ok(drives)
}

fn drive(
    table: &Table<'_>,
    catalogue: &Catalogue,
    listing: &mut Listing,
) -> Result<DriveParameters, DescriptionError> {
    let motor = motor(table, catalogue, listing)?;
    let reducer = reducer(table, catalogue, listing)?;
    let ratio = ratio(table, &reducer, listing)?;
    let winch = winch(table, catalogue, listing)?;
    let mut drive = Design::new(&motor, &reducer, ratio, winch.parameters).drive();
    for (key, domain, number) in [
        ("acceleration_m_per_s2", POSITIVE, &mut drive.acceleration),
        ("max_tension_n", POSITIVE, &mut drive.max_tension),
        ("min_tension_n", NON_NEGATIVE, &mut drive.min_tension),
    ] {
        let entry = table.entry(key);
        if let Some(entry) = &entry {
            *number = entry.number(domain)?;
        }
        listing.number(key, *number, source_of(entry.map(|entry| entry.line())));
    }
    drive.validate().map_err(|error| table.out_of_domain(error))?;
    Ok(drive)
}

/// A part of a drive as written.
enum Part<'d, T> {
    /// In the catalogue.
    Named(T),
    /// In numbers, which change the part that the table is like.
    Numbers(Table<'d>, Option<T>),
}

/// The part at a key; `known` are the parts of the catalogue, `other` is the default's name.
fn part<'d, T: Clone>(
    table: &Table<'d>,
    key: &str,
    other: &str,
    known: &[T],
    name: fn(&T) -> &str,
    listing: &mut Listing,
) -> Result<Part<'d, T>, DescriptionError> {
    let names: Vec<&str> = known.iter().map(name).collect();
    let find = |entry: &Entry<'_>| entry.name(&format!("{key} in the catalogue"), &names);
    match table.entry(key) {
        None => {
            let index = names.iter().position(|name| *name == other).unwrap_or(0);
            listing.text(key, other, ValueSource::Default);
            Ok(Part::Named(known[index].clone()))
        }
        Some(entry) if entry.is_text() => {
            let part = &known[find(&entry)?];
            listing.text(key, name(part), ValueSource::File { line: entry.line() });
            Ok(Part::Named(part.clone()))
        }
        Some(entry) if entry.is_table() => {
            let inner = entry.table(format!("{}: {key}", table.place))?;
            let like = inner.entry("like").map(|like| find(&like)).transpose()?;
            Ok(Part::Numbers(inner, like.map(|index| known[index].clone())))
        }
        Some(entry) => {
            Err(entry.refuse(&format!("the name of a {key} in the catalogue, or a table of numbers")))
        }
    }
}

/// A number beside those of a structure.
fn extra(
    table: &Table<'_>,
    key: &str,
    other: f64,
    listing: &mut Listing,
    prefix: &str,
) -> Result<f64, DescriptionError> {
    let entry = table.entry(key);
    let number = entry.as_ref().map_or(Ok(other), |entry| entry.number(NON_NEGATIVE))?;
    listing.number(&format!("{prefix}{key}"), number, source_of(entry.map(|entry| entry.line())));
    Ok(number)
}

fn motor(
    table: &Table<'_>,
    catalogue: &Catalogue,
    listing: &mut Listing,
) -> Result<CatalogueMotor, DescriptionError> {
    let read = part(table, "motor", DEFAULT_PARTS[0], &catalogue.motors, |motor| &motor.name, listing)?;
    let (inner, like) = match read {
        Part::Named(motor) => return Ok(motor),
        Part::Numbers(inner, like) => (inner, like),
    };
    inner.check_keys(&keys(MOTOR, &MOTOR_MORE))?;
    let whole = like.is_some();
    let mut motor = like.unwrap_or_else(|| CatalogueMotor {
        no_load_current: 0.0,
        name: String::new(),
        ..catalogue.motors[0].clone()
    });
    let (layers, own) = ([inner.clone()], motor.parameters);
    let read = if whole { overlay } else { complete };
    motor.parameters =
        read(&layers, MOTOR, own, |motor| motor.validate(), listing, ("motor.", ValueSource::Catalogue))?;
    motor.no_load_current = extra(&inner, "no_load_current_a", motor.no_load_current, listing, "motor.")?;
    Ok(motor)
}

fn reducer(
    table: &Table<'_>,
    catalogue: &Catalogue,
    listing: &mut Listing,
) -> Result<CatalogueReducer, DescriptionError> {
    let read =
        part(table, "reducer", DEFAULT_PARTS[1], &catalogue.reducers, |reducer| &reducer.name, listing)?;
    let (inner, like) = match read {
        Part::Named(reducer) => return Ok(reducer),
        Part::Numbers(inner, like) => (inner, like),
    };
    inner.check_keys(&keys(REDUCER, &REDUCER_MORE))?;
    let whole = like.is_some();
    let mut reducer = like.unwrap_or_else(|| CatalogueReducer {
        inertia: 0.0,
        top_speed: f64::MAX,
        name: String::new(),
        ..catalogue.reducers[0].clone()
    });
    let (layers, own) = ([inner.clone()], reducer.parameters);
    let read = if whole { overlay } else { complete };
    // Every number has a domain of its own: nothing is left to validate.
    reducer.parameters =
        read(&layers, REDUCER, own, |_| Ok(()), listing, ("reducer.", ValueSource::Catalogue))?;
    reducer.inertia = extra(&inner, "inertia_kg_m2", reducer.inertia, listing, "reducer.")?;
    if let Some(entry) = inner.entry("top_speed_rad_per_s") {
        reducer.top_speed = entry.number(POSITIVE)?;
        let line = entry.line();
        listing.number("reducer.top_speed_rad_per_s", reducer.top_speed, ValueSource::File { line });
    }
    // In numbers it has the ratio that is written.
    reducer.ratios = Vec::new();
    Ok(reducer)
}

/// The ratio: of a reducer in the catalogue one of those that it is made with.
fn ratio(
    table: &Table<'_>,
    reducer: &CatalogueReducer,
    listing: &mut Listing,
) -> Result<f64, DescriptionError> {
    let ratios = &reducer.ratios;
    let ratio = match (table.entry("ratio"), ratios.as_slice()) {
        (None, [only]) => *only,
        (None, _) => return Err(table.error("ratio is missing")),
        (Some(entry), _) => {
            let ratio = entry.number(FROM_ONE)?;
            let made = ratios.is_empty() || ratios.iter().any(|known| known.to_bits() == ratio.to_bits());
            if !made {
                let all: Vec<String> = ratios.iter().map(ToString::to_string).collect();
                return Err(entry.refuse(&format!("one of {}, those of {}", all.join(", "), reducer.name)));
            }
            ratio
        }
    };
    listing.number("ratio", ratio, source_of(table.entry("ratio").map(|entry| entry.line())));
    Ok(ratio)
}

fn winch(
    table: &Table<'_>,
    catalogue: &Catalogue,
    listing: &mut Listing,
) -> Result<CatalogueWinch, DescriptionError> {
    let read = part(table, "winch", DEFAULT_PARTS[2], &catalogue.winches, |winch| &winch.name, listing)?;
    let (inner, like) = match read {
        Part::Named(winch) => return Ok(winch),
        Part::Numbers(inner, like) => (inner, like),
    };
    inner.check_keys(&keys(WINCH, &["like"]))?;
    let read = if like.is_some() { overlay } else { complete };
    let mut winch = like.unwrap_or_else(|| catalogue.winches[0].clone());
    winch.parameters = read(
        &[inner],
        WINCH,
        winch.parameters,
        |winch| winch.validate(),
        listing,
        ("winch.", ValueSource::Catalogue),
    )?;
    Ok(winch)
}
