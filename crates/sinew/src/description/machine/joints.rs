//! What belongs to joints: travel, named poses, start, preferred pose, encoders.

use super::listing::{Listing, Value, ValueSource, source_of};
use crate::body::{JointKind, Key, Parts, Robot};
use crate::description::document::{Entry, Table};
use crate::description::domain::{Domain, FINITE, POSITIVE};
use crate::description::error::DescriptionError;
use crate::drive::JointEncoder;
use crate::trajectory::Redundancy;
use alloc::format;
use alloc::vec::Vec;

/// Keys of the tables of joints.
pub(super) const TRAVEL: [&str; 3] = ["joint", "range_rad", "range_m"];
pub(super) const POSE: [&str; 2] = ["name", "joints"];
pub(super) const REDUNDANCY: [&str; 3] = ["rest", "swing", "weight"];
pub(super) const ENCODER: [&str; 4] = ["counts_per_turn", "resolution_rad", "resolution_m", "none"];

const TURN: f64 = 2.0 * core::f64::consts::PI;

/// Names of the joints that follow no other.
pub(super) fn independent_names(robot: &Robot) -> Vec<&str> {
    let joints = robot.independent_joints().into_iter();
    joints.map(|joint| robot.parts().joints[joint].name.as_str()).collect()
}

/// The joints that follow no other, with their names and kinds.
pub(super) struct Joints<'a> {
    names: Vec<&'a str>,
    kinds: Vec<JointKind>,
    ranges: Vec<Option<[f64; 2]>>,
    /// Index of each in the coordinates of the robot.
    coordinates: Vec<usize>,
}

impl<'a> Joints<'a> {
    pub(super) fn new(robot: &'a Robot) -> Self {
        let joints = robot.independent_joints();
        let all = &robot.parts().joints;
        Self {
            names: independent_names(robot),
            kinds: joints.iter().map(|&joint| all[joint].kind).collect(),
            ranges: joints.iter().map(|&joint| all[joint].range).collect(),
            coordinates: joints.iter().map(|&joint| robot.coordinates_of(joint).start).collect(),
        }
    }

    /// A table from the names of joints to numbers, on top of others.
    fn numbers(
        &self,
        entry: &Entry<'_>,
        place: &str,
        domain: Domain,
        within_range: bool,
        on: &mut [f64],
    ) -> Result<(), DescriptionError> {
        let table = entry.table(format!("{place}: {}", entry.key))?;
        table.check_keys(&self.names)?;
        for entry in table.entries() {
            let number = entry.number(domain)?;
            let Some(joint) = self.names.iter().position(|name| *name == entry.key) else { continue };
            match self.ranges[joint] {
                Some([low, high]) if within_range && !(low..=high).contains(&number) => {
                    return Err(entry.refuse(&format!("a number in the joint's range, {low} to {high}")));
                }
                _ => on[joint] = number,
            }
        }
        Ok(())
    }

    /// Moves coordinates into the ranges.
    fn move_into_ranges(&self, coordinates: &mut [f64]) {
        for (value, range) in coordinates.iter_mut().zip(&self.ranges) {
            if let Some([low, high]) = range {
                *value = value.max(*low).min(*high);
            }
        }
    }

    /// Refuses a pose that is out of the range of a joint.
    fn check_ranges(&self, entry: &Entry<'_>, coordinates: &[f64]) -> Result<(), DescriptionError> {
        for ((value, range), name) in coordinates.iter().zip(&self.ranges).zip(&self.names) {
            if let Some([low, high]) = range
                && !(low..=high).contains(&value)
            {
                let expected =
                    format!("a pose in the range of `{name}`, {low} to {high}, which has it at {value}");
                return Err(entry.refuse(&expected));
            }
        }
        Ok(())
    }

    /// Lists one number per joint.
    fn list(&self, key: &str, numbers: &[f64], source: ValueSource, listing: &mut Listing) {
        for (name, number) in self.names.iter().zip(numbers) {
            listing.number(&format!("{key}.{name}"), *number, source);
        }
    }
}

/// Narrows the ranges of joints.
pub(super) fn travel(
    root: &Table<'_>,
    parts: &mut Parts,
    listing: &mut Listing,
) -> Result<(), DescriptionError> {
    let independent: Vec<usize> = (0..parts.joints.len())
        .filter(|joint| !parts.couplings.iter().any(|coupling| coupling.follower == *joint))
        .collect();
    for (table, _) in root.tables("travel", "joint", &TRAVEL)? {
        let names: Vec<&str> = independent.iter().map(|&joint| parts.joints[joint].name.as_str()).collect();
        let joint = independent[table.required("joint")?.name("joint that follows no other", &names)?];
        let slide = parts.joints[joint].kind == JointKind::Slide;
        let key = one_unit(&table, slide, ["range_rad", "range_m"])?.unwrap_or("range_rad");
        let entry = table.required(if slide { "range_m" } else { key })?;
        let [low, high] = entry.numbers(FINITE)?;
        if high <= low {
            return Err(entry.refuse("two numbers that rise"));
        }
        if let Some([least, most]) = parts.joints[joint].range
            && (low < least || high > most)
        {
            return Err(entry.refuse(&format!("a range within that of the body, {least} to {most}")));
        }
        parts.joints[joint].range = Some([low, high]);
        listing.begin(&table.place);
        let numbers = Value::Numbers(Vec::from([low, high]));
        listing.add(entry.key, numbers, ValueSource::File { line: entry.line() });
    }
    Ok(())
}

/// The one of two keys, one per unit, that a table has; the unit must fit the kind of joint.
fn one_unit<'k>(
    table: &Table<'_>,
    slide: bool,
    [turning, sliding]: [&'k str; 2],
) -> Result<Option<&'k str>, DescriptionError> {
    let (fits, other) = if slide { (sliding, turning) } else { (turning, sliding) };
    if let Some(entry) = table.entry(other) {
        return Err(
            entry.problem(&format!(", but its unit does not fit this kind of joint: expected {fits}"))
        );
    }
    Ok(table.entry(fits).map(|_| fits))
}

/// The named poses of the file, as key poses of the robot.
pub(super) fn poses(
    root: &Table<'_>,
    robot: &Robot,
    listing: &mut Listing,
) -> Result<Vec<Key>, DescriptionError> {
    let joints = Joints::new(robot);
    let mut keys = Vec::new();
    for (table, named) in root.tables("pose", "name", &POSE)? {
        if robot.key(&named.text).is_some() {
            let expected = "a name that no key pose of the body has";
            return Err(table.required("name")?.refuse(expected));
        }
        let mut q = robot.reference_pose();
        let mut independent: Vec<f64> = joints.coordinates.iter().map(|&at| q[at]).collect();
        let entry = table.required("joints")?;
        joints.numbers(&entry, &table.place, FINITE, true, &mut independent)?;
        for (&at, value) in joints.coordinates.iter().zip(&independent) {
            q[at] = *value;
        }
        robot.apply_couplings(&mut q).map_err(|error| table.error(&format!("{error}")))?;
        listing.begin(&table.place);
        joints.list("joints", &independent, ValueSource::File { line: entry.line() }, listing);
        keys.push(Key { name: named.text, q });
    }
    Ok(keys)
}

/// Where motions start: on top of the default.
pub(super) fn start(
    root: &Table<'_>,
    robot: &Robot,
    start: &mut [f64],
    listing: &mut Listing,
) -> Result<(), DescriptionError> {
    let joints = Joints::new(robot);
    let entry = root.entry("start");
    let body = robot.key("start").map_or(ValueSource::Default, |_| ValueSource::Body);
    match &entry {
        None => joints.move_into_ranges(start),
        Some(entry) if entry.is_text() => {
            let names: Vec<&str> = robot.parts().keys.iter().map(|key| key.name.as_str()).collect();
            let key = &robot.parts().keys[entry.name("pose", &names)?];
            for (value, &at) in start.iter_mut().zip(&joints.coordinates) {
                *value = key.q[at];
            }
            joints.check_ranges(entry, start)?;
        }
        Some(entry) if entry.is_table() => joints.numbers(entry, "machine", FINITE, true, start)?,
        Some(entry) => return Err(entry.refuse("the name of a pose, or a table from joints to numbers")),
    }
    listing.begin("machine");
    let source = entry.map_or(body, |entry| ValueSource::File { line: entry.line() });
    joints.list("start", start, source, listing);
    Ok(())
}

/// The preferred pose: on top of the default.
pub(super) fn redundancy(
    root: &Table<'_>,
    robot: &Robot,
    mut rule: Redundancy,
    listing: &mut Listing,
) -> Result<Redundancy, DescriptionError> {
    let joints = Joints::new(robot);
    let table = root.table("redundancy")?;
    table.iter().try_for_each(|table| table.check_keys(&REDUNDANCY))?;
    listing.begin("[redundancy]");
    for (key, domain, numbers) in [
        ("rest", FINITE, &mut rule.rest),
        ("swing", FINITE, &mut rule.swing),
        ("weight", POSITIVE, &mut rule.weight),
    ] {
        let entry = table.as_ref().and_then(|table| table.entry(key));
        if let Some(entry) = &entry {
            joints.numbers(entry, "[redundancy]", domain, false, numbers)?;
        }
        joints.list(key, numbers, source_of(entry.map(|entry| entry.line())), listing);
    }
    Ok(rule)
}

/// The encoder of every joint.
pub(super) fn encoders(
    root: &Table<'_>,
    robot: &Robot,
    listing: &mut Listing,
) -> Result<Vec<Option<JointEncoder>>, DescriptionError> {
    let joints = Joints::new(robot);
    let every = root.table("every_joint_encoder")?;
    every.iter().try_for_each(|table| table.check_keys(&ENCODER))?;
    // Checked also where every joint has a table of its own.
    every.iter().try_for_each(|table| of_unit(table, false).map(drop))?;
    let known: Vec<&str> = ENCODER.iter().copied().chain(["joint"]).collect();
    let mut own: Vec<Option<Table<'_>>> = joints.names.iter().map(|_| None).collect();
    for (table, _) in root.tables("joint_encoder", "joint", &known)? {
        let joint = table.required("joint")?.name("joint that follows no other", &joints.names)?;
        own[joint] = Some(table);
    }
    let mut encoders = Vec::new();
    for ((own, kind), name) in own.iter().zip(&joints.kinds).zip(&joints.names) {
        let slide = *kind == JointKind::Slide;
        listing.begin(&format!("[[joint_encoder]] `{name}`"));
        let read = match (own, &every) {
            (Some(table), _) => encoder(table, slide)?,
            // The table for all may have a key per unit.
            (None, Some(table)) => of_unit(table, slide)?,
            (None, None) => None,
        };
        let default = if slide { JointEncoder::slide() } else { JointEncoder::fourteen_bits() };
        let (encoder, line) = read.map_or((Some(default), None), |(encoder, line)| (encoder, Some(line)));
        let key = if slide { "resolution_m" } else { "resolution_rad" };
        listing.optional(key, encoder.map(|encoder| encoder.resolution), source_of(line));
        encoders.push(encoder);
    }
    Ok(encoders)
}

/// An encoder or none, with its line.
type Read = Option<(Option<JointEncoder>, usize)>;

/// The encoder in a table of one joint, which has exactly one of the keys.
fn encoder(table: &Table<'_>, slide: bool) -> Result<Read, DescriptionError> {
    let [turning, sliding] = [["counts_per_turn", "resolution_rad"].as_slice(), &["resolution_m"]];
    let (fitting, others) = if slide { (sliding, turning) } else { (turning, sliding) };
    if let Some(entry) = others.iter().find_map(|key| table.entry(key)) {
        let fits = fitting.join(" or ");
        return Err(
            entry.problem(&format!(", but its unit does not fit this kind of joint: expected {fits}"))
        );
    }
    let given: Vec<Entry<'_>> = fitting.iter().chain(&["none"]).filter_map(|key| table.entry(key)).collect();
    match given.as_slice() {
        [_] => of_unit(table, slide),
        [] => Err(table.error(&format!("{} or none is missing", fitting.join(", ")))),
        [_, second, ..] => {
            Err(second
                .problem(", but the table says it already: expected one of counts, resolution and none"))
        }
    }
}

/// The encoder for a kind of joint, if the table has one.
fn of_unit(table: &Table<'_>, slide: bool) -> Result<Read, DescriptionError> {
    if let Some(entry) = table.entry("none")
        && entry.flag()?
    {
        return Ok(Some((None, entry.line())));
    }
    // All keys are checked, those of the other unit as well.
    let mut found = None;
    for (key, fits) in [("counts_per_turn", !slide), ("resolution_rad", !slide), ("resolution_m", slide)] {
        let Some(entry) = table.entry(key) else { continue };
        let number = entry.number(POSITIVE)?;
        let resolution = if key == "counts_per_turn" { TURN / number } else { number };
        if fits {
            found = Some((Some(JointEncoder { resolution, ..JointEncoder::slide() }), entry.line()));
        }
    }
    Ok(found)
}
