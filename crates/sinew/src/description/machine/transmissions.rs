//! Sheath, cable, drive and sensors of every muscle.

use super::drives::NamedDrive;
use super::fields::{CABLE, LOAD_CELL, WEAKENING, complete, first, keys, overlay};
use super::files::Files;
use super::joints::independent_names;
use super::listing::{Listing, Value, ValueSource, source_of};
use crate::Error;
use crate::body::Tendon;
use crate::description::document::{Entry, Table};
use crate::description::domain::{DELAY, Domain, FINITE, NON_NEGATIVE, POSITIVE};
use crate::description::error::DescriptionError;
use crate::drive::LoadCell;
use crate::machine::{Machine, MuscleDesign};
use crate::predictor::{CableModel, Model};
use crate::transmission::SheathBend;
use crate::transmission::cable::{CableParameters, Weakening, WeakeningForm};
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;

/// Keys of `[every_transmission]`; `[[transmission]]` has `muscle` as well.
pub(super) const TRANSMISSION: [&str; 11] = [
    "near_length_m",
    "sheath_length_m",
    "sheath_bend_rad",
    "bend_by_joint",
    "cable",
    "model",
    "drive",
    "tension_limits_n",
    "load_cell",
    "motor_encoder_counts",
    "delay_s",
];

/// s: the unit of a drive's delay.
const MILLISECOND: f64 = 1e-3;

/// The designs of all muscles.
pub(super) fn read(
    root: &Table<'_>,
    machine: &Machine,
    drives: &[NamedDrive],
    files: &mut Files<'_>,
    listing: &mut Listing,
) -> Result<Vec<MuscleDesign>, DescriptionError> {
    let parts = machine.robot.parts();
    let every = root.table("every_transmission")?;
    every.iter().try_for_each(|table| table.check_keys(&TRANSMISSION))?;
    let names: Vec<&str> = parts.tendons.iter().map(|tendon| tendon.name.as_str()).collect();
    let mut own: Vec<Option<Table<'_>>> = names.iter().map(|_| None).collect();
    let known: Vec<&str> = TRANSMISSION.iter().copied().chain(["muscle"]).collect();
    for (table, _) in root.tables("transmission", "muscle", &known)? {
        let muscle = table.required("muscle")?.name("muscle", &names)?;
        own[muscle] = Some(table);
    }
    if let (Some(every), Some(tendon)) = (&every, parts.tendons.first()) {
        // Checked also where every muscle has a table of its own.
        let reader = Reader { layers: Vec::from([every.clone()]), own_layers: 0, machine, drives };
        let tendon = Tendon { sheath: None, ..tendon.clone() };
        reader.design(&tendon, [None; 2], files, &mut Listing::default())?;
    }
    let mut designs = Vec::new();
    for ((tendon, own), described) in parts.tendons.iter().zip(own).zip(&machine.muscles) {
        listing.begin(&format!("[[transmission]] `{}`", tendon.name));
        let own_layers = usize::from(own.is_some());
        let reader =
            Reader { layers: own.into_iter().chain(every.clone()).collect(), own_layers, machine, drives };
        designs.push(reader.design(tendon, described.tension, files, listing)?);
    }
    Ok(designs)
}

/// Tables of one muscle in order of precedence.
struct Reader<'d, 'a> {
    layers: Vec<Table<'d>>,
    /// How many of them are of this muscle alone.
    own_layers: usize,
    machine: &'a Machine,
    drives: &'a [NamedDrive],
}

impl<'d> Reader<'d, '_> {
    fn design(
        &self,
        tendon: &Tendon,
        tension: [Option<f64>; 2],
        files: &mut Files<'_>,
        listing: &mut Listing,
    ) -> Result<MuscleDesign, DescriptionError> {
        let sheath = self.sheath(tendon, listing)?;
        let mut design = MuscleDesign::in_sheath(Some(sheath));
        design.bend_by_joint = self.bend_by_joint(design.bend, listing)?;
        design.near = self.number("near_length_m", POSITIVE, design.near, listing)?;
        design.model = self.model(files, listing)?;
        let cable = design.model.as_ref().map_or(design.cable, |model| model.parameters);
        let source = if design.model.is_some() { ValueSource::Model } else { ValueSource::Default };
        design.cable = self.cable(cable, source, listing)?;
        let sensors = design.drive;
        if let Some(drive) = self.drive(listing)? {
            design.drive = drive.parameters;
        }
        (design.drive.load_cell, design.drive.has_load_cell) = self.load_cell(sensors.load_cell, listing)?;
        design.drive.encoder.counts =
            self.number("motor_encoder_counts", POSITIVE, sensors.encoder.counts, listing)?;
        let delay = self.number("delay_s", DELAY, sensors.delay_ms * MILLISECOND, listing)?;
        design.drive.delay_ms = delay / MILLISECOND;
        design.tension = self.tension(tension, listing)?;
        if let Some(table) = self.layers.first() {
            design.validate().map_err(|error| table.out_of_domain(error))?;
        }
        Ok(design)
    }

    fn number(
        &self,
        key: &'static str,
        domain: Domain,
        other: f64,
        listing: &mut Listing,
    ) -> Result<f64, DescriptionError> {
        let entry = first(&self.layers, key);
        let number = entry.as_ref().map_or(Ok(other), |entry| entry.number(domain))?;
        listing.number(key, number, source_of(entry.map(|entry| entry.line())));
        Ok(number)
    }

    /// Length and bend: of the muscle's own table, else of its description, else of the table for all.
    fn sheath(&self, tendon: &Tendon, listing: &mut Listing) -> Result<[f64; 2], DescriptionError> {
        let described = tendon.sheath.as_ref().map(|sheath| [sheath.length, sheath.bend]);
        let default = MuscleDesign::in_sheath(None);
        let mut sheath = described.unwrap_or([default.sheath, default.bend]);
        let keys = [("sheath_length_m", POSITIVE), ("sheath_bend_rad", NON_NEGATIVE)];
        for ((key, domain), number) in keys.into_iter().zip(&mut sheath) {
            let layers = if described.is_some() { self.own_layers } else { self.layers.len() };
            let entry = first(&self.layers[..layers], key);
            if let Some(entry) = &entry {
                *number = entry.number(domain)?;
            }
            let other = if described.is_some() { ValueSource::Body } else { ValueSource::Default };
            listing.number(
                key,
                *number,
                entry.map_or(other, |entry| ValueSource::File { line: entry.line() }),
            );
        }
        Ok(sheath)
    }

    /// Change of the sheath's bend with the joints: `[joints]`, or empty.
    fn bend_by_joint(&self, bend: f64, listing: &mut Listing) -> Result<Vec<f64>, DescriptionError> {
        let joints = independent_names(&self.machine.robot);
        let tables = self.inner("bend_by_joint", &joints)?;
        let Some(table) = tables.first() else {
            listing.add("bend_by_joint", Value::None, ValueSource::Default);
            return Ok(Vec::new());
        };
        let refused = |error: Error| table.error(&format!("{error}"));
        let ranges = self.machine.ranges().map_err(refused)?;
        let mut slopes = Vec::new();
        let mut largest: Option<(f64, Entry<'_>)> = None;
        for (name, [low, high]) in joints.iter().zip(&ranges) {
            let entry = first(&tables, name);
            let slope = entry.as_ref().map_or(Ok(0.0), |entry| entry.number(FINITE))?;
            listing.number(
                &format!("bend_by_joint.{name}"),
                slope,
                source_of(entry.as_ref().map(Entry::line)),
            );
            slopes.push(slope);
            let change = slope.abs() * (high - low);
            if let (Some(entry), true) = (entry, largest.as_ref().is_none_or(|(most, _)| change > *most)) {
                largest = Some((change, entry));
            }
        }
        let law = SheathBend::new(bend, slopes.clone(), self.machine.start.clone());
        let most =
            law.map_err(|error| self.layers.first().unwrap_or(table).out_of_domain(error))?.largest(&ranges);
        match largest {
            Some((_, entry)) if most > SheathBend::LARGEST || !most.is_finite() => {
                Err(entry.refuse(&format!(
                    "a number with which the sheath bends by at most 4 pi over the joints' ranges, not by \
                    {most:.3} rad"
                )))
            }
            _ => Ok(slopes),
        }
    }

    /// The tables at a key of this muscle and of all, their keys checked.
    fn inner(&self, key: &str, known: &[&str]) -> Result<Vec<Table<'d>>, DescriptionError> {
        let mut tables = Vec::new();
        for table in &self.layers {
            tables.extend(table.table(key)?);
        }
        tables.iter().try_for_each(|table| table.check_keys(known))?;
        Ok(tables)
    }

    fn cable(
        &self,
        on: CableParameters,
        other: ValueSource,
        listing: &mut Listing,
    ) -> Result<CableParameters, DescriptionError> {
        let tables = self.inner("cable", &keys(CABLE, &["weakening"]))?;
        let mut cable = overlay(&tables, CABLE, on, CableParameters::validate, listing, ("cable.", other))?;
        let mut inner = Vec::new();
        for table in &tables {
            inner.extend(table.table("weakening")?);
        }
        inner.iter().try_for_each(|table| table.check_keys(&keys(WEAKENING, &["form"])))?;
        let zero = Weakening::rational(0.0, 0.0, 0.0);
        if !inner.is_empty() {
            let (on, named) = (cable.weakening, ("cable.weakening.", other));
            let read = if on.is_some() { overlay } else { complete };
            let numbers = read(&inner, WEAKENING, on.unwrap_or(zero), |_| Ok(()), listing, named)?;
            let (entry, forms) = (first(&inner, "form"), WeakeningForm::ALL.map(WeakeningForm::name));
            let form = entry.as_ref().map(|entry| entry.name("form", &forms)).transpose()?;
            let form = form.map_or(numbers.form, |form| WeakeningForm::ALL[form]);
            let source = entry.map_or(other, |entry| ValueSource::File { line: entry.line() });
            listing.text("cable.weakening.form", form.name(), source);
            cable.weakening = Some(Weakening { form, ..numbers });
        } else if cable.weakening.is_none() {
            listing.add("cable.weakening", Value::None, ValueSource::Default);
        }
        Ok(cable)
    }

    /// The cable of an identified model.
    fn model(
        &self,
        files: &mut Files<'_>,
        listing: &mut Listing,
    ) -> Result<Option<CableModel>, DescriptionError> {
        let Some(entry) = first(&self.layers, "model") else {
            listing.add("model", Value::None, ValueSource::Default);
            return Ok(None);
        };
        let path = entry.text("the path of a model file")?;
        let text = files.read(path).map_err(|problem| entry.problem(&format!(": {problem}")))?;
        let model = Model::from_json(&text).map_err(|error| entry.problem(&format!(": {error}")))?;
        let cable = model.estimator.law.cable.map(|cable| cable.model);
        listing.text("model", path, ValueSource::File { line: entry.line() });
        let expected = "a model of a cable, identified with the displacements of both ends";
        cable.map(Some).ok_or_else(|| entry.refuse(expected))
    }

    fn drive(&self, listing: &mut Listing) -> Result<Option<&NamedDrive>, DescriptionError> {
        let Some(entry) = first(&self.layers, "drive") else {
            listing.text("drive", DEFAULT_DRIVE, ValueSource::Default);
            return Ok(None);
        };
        let names: Vec<&str> = self.drives.iter().map(|drive| drive.name.as_str()).collect();
        let index = entry.name("[[drive]]", &names)?;
        listing.text("drive", names[index], ValueSource::File { line: entry.line() });
        Ok(Some(&self.drives[index]))
    }

    /// The load cell, and whether there is one: `load_cell = "none"` says that there is none.
    fn load_cell(&self, on: LoadCell, listing: &mut Listing) -> Result<(LoadCell, bool), DescriptionError> {
        if let Some(entry) = first(&self.layers, "load_cell").filter(Entry::is_text) {
            entry.word(&["none"])?;
            listing.add("load_cell", Value::None, source_of(Some(entry.line())));
            return Ok((on, false));
        }
        // That others have none says nothing about this one.
        let given = |table: &&Table<'_>| table.entry("load_cell").is_some_and(|entry| !entry.is_text());
        let tables =
            self.layers.iter().filter(given).filter_map(|table| table.table("load_cell").transpose());
        let tables = tables.collect::<Result<Vec<_>, _>>()?;
        tables.iter().try_for_each(|table| table.check_keys(&keys(LOAD_CELL, &[])))?;
        let named = ("load_cell.", ValueSource::Default);
        Ok((overlay(&tables, LOAD_CELL, on, LoadCell::validate, listing, named)?, true))
    }

    /// The file's limits, of which the largest tension is at most that of the body's actuator.
    fn tension(
        &self,
        described: [Option<f64>; 2],
        listing: &mut Listing,
    ) -> Result<[Option<f64>; 2], DescriptionError> {
        let Some(entry) = first(&self.layers, "tension_limits_n") else {
            match described[1] {
                Some(most) => {
                    let numbers = Value::Numbers(Vec::from([0.0, most]));
                    listing.add("tension_limits_n", numbers, ValueSource::Body);
                }
                None => listing.add("tension_limits_n", Value::None, ValueSource::Default),
            }
            return Ok(described);
        };
        let [least, most] = entry.numbers(NON_NEGATIVE)?;
        if described[1].is_some_and(|allowed| most > allowed) {
            return Err(
                entry.refuse("at most what the body's actuator allows in its control and force ranges")
            );
        }
        if most <= least {
            return Err(entry.refuse("two numbers that rise"));
        }
        let numbers = Value::Numbers(Vec::from([least, most]));
        listing.add("tension_limits_n", numbers, ValueSource::File { line: entry.line() });
        Ok([Some(least), Some(most)])
    }
}

/// Drives that no muscle has, with their lines.
pub(super) fn unused<'a>(root: &Table<'_>, drives: &'a [NamedDrive]) -> Vec<&'a NamedDrive> {
    let every = root.table("every_transmission").ok().flatten();
    let known: Vec<&str> = TRANSMISSION.iter().copied().chain(["muscle"]).collect();
    let own = root.tables("transmission", "muscle", &known).unwrap_or_default();
    let tables = own.into_iter().map(|(table, _)| table).chain(every);
    let used: Vec<String> = tables
        .filter_map(|table| table.entry("drive").and_then(|entry| entry.text("").ok().map(String::from)))
        .collect();
    drives.iter().filter(|drive| !used.contains(&drive.name)).collect()
}

/// Name of the drive of muscles for which none is named.
pub(super) const DEFAULT_DRIVE: &str = "mc_am";
