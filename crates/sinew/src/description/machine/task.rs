//! Task, closed paths, payload, tolerances and the constants of the controller's rules.

use super::fields::{CONTROL, TOLERANCES, keys, overlay};
use super::listing::{Listing, Value, ValueSource, source_of};
use crate::body::Robot;
use crate::description::document::Table;
use crate::description::domain::{FINITE, NON_NEGATIVE, PERIOD, POSITIVE};
use crate::description::error::DescriptionError;
use crate::machine::{ControlRules, DEFAULT_PERIOD, NamedPath, Task, Tolerances};
use crate::trajectory::{EndPointPath, Loop};
use alloc::string::{String, ToString};
use alloc::vec::Vec;

/// Keys of the tables.
pub(super) const TASK: [&str; 3] = ["space", "endpoint", "axes"];
pub(super) const PATH: [&str; 4] = ["name", "shape", "center_m", "amplitude_m"];
pub(super) const PAYLOAD: [&str; 1] = ["mass_kg"];

const AXES: [&str; 3] = ["x", "y", "z"];
const SPACES: [&str; 2] = ["endpoint", "joints"];

/// What the machine tracks.
pub(super) fn task(root: &Table<'_>, robot: &Robot, listing: &mut Listing) -> Result<Task, DescriptionError> {
    let table = root.table("task")?;
    table.iter().try_for_each(|table| table.check_keys(&TASK))?;
    let entry = |key: &str| table.as_ref().and_then(|table| table.entry(key));
    let sites: Vec<&str> = robot.parts().sites.iter().map(|site| site.name.as_str()).collect();
    let (space, endpoint, axes) = (entry("space"), entry("endpoint"), entry("axes"));
    let joints = space.as_ref().map(|space| Ok::<_, DescriptionError>(space.name("space", &SPACES)? == 1));
    let joints = joints.transpose()?;
    listing.begin("[task]");
    if joints == Some(true) {
        if let Some(entry) = endpoint.or(axes) {
            return Err(
                entry.problem(", but the task is in the space of the joints: expected none, or no `space`")
            );
        }
        listing.text("space", SPACES[1], source_of(space.map(|space| space.line())));
        return Ok(Task::Joints);
    }
    let site = match &endpoint {
        Some(entry) => Some(entry.name("site", &sites)?),
        None => robot.site("endpoint"),
    };
    let tracked = axes.as_ref().map_or(Ok(AXES.to_vec()), |entry| match entry.words(&AXES)? {
        words if words.is_empty() => Err(entry.refuse("at least one of `x`, `y`, `z`")),
        words => Ok(words),
    })?;
    let Some(site) = site else {
        if let Some(entry) = space.or(axes) {
            let problem = ", but there is no end point: expected the key `endpoint`, or a site of that name";
            return Err(entry.problem(problem));
        }
        listing.text("space", SPACES[1], ValueSource::Default);
        return Ok(Task::Joints);
    };
    listing.text("space", SPACES[0], source_of(space.map(|space| space.line())));
    let source = endpoint.map_or(ValueSource::Body, |entry| ValueSource::File { line: entry.line() });
    listing.text("endpoint", sites[site], source);
    let names: Vec<String> =
        AXES.iter().filter(|axis| tracked.contains(axis)).map(ToString::to_string).collect();
    listing.add("axes", Value::Texts(names), source_of(axes.map(|axes| axes.line())));
    Ok(Task::EndPoint { site, axes: AXES.map(|axis| tracked.contains(&axis)) })
}

/// The closed paths of the end point.
pub(super) fn paths(
    root: &Table<'_>,
    task: Task,
    listing: &mut Listing,
) -> Result<Vec<NamedPath>, DescriptionError> {
    let mut paths = Vec::new();
    for (table, named) in root.tables("path", "name", &PATH)? {
        if task == Task::Joints {
            return Err(table.error("is a path of the end point, but the task is in the space of the joints"));
        }
        if RESERVED.contains(&named.text.as_str()) || named.text.contains([':', '/', '\\', '.']) {
            let expected = "a name that is no word of the option --path and has none of `:`, `.`, `/`, `\\`";
            return Err(table.required("name")?.refuse(expected));
        }
        let shape = table.required("shape")?;
        let shape_index = shape.name("shape", &["sine", "saddle"])?;
        let center = table.required("center_m")?;
        let amplitude = table.required("amplitude_m")?;
        let path = EndPointPath::Loop {
            shape: if shape_index == 0 { Loop::Sine } else { Loop::Saddle },
            center: center.numbers(FINITE)?,
            amplitude: amplitude.number(POSITIVE)?,
        };
        path.validate().map_err(|error| table.out_of_domain(error))?;
        listing.begin(&table.place);
        let file = |line| ValueSource::File { line };
        listing.text("shape", ["sine", "saddle"][shape_index], file(shape.line()));
        if let EndPointPath::Loop { center: c, amplitude: a, .. } = &path {
            listing.add("center_m", Value::Numbers(c.to_vec()), file(center.line()));
            listing.number("amplitude_m", *a, file(amplitude.line()));
        }
        paths.push(NamedPath { name: named.text, path });
    }
    Ok(paths)
}

/// Names that mean other motions where a path is chosen.
const RESERVED: [&str; 1] = ["tour"];

/// Period of the control cycle, s: a whole number of nanoseconds, as clocks and recordings count it.
pub(super) fn period(root: &Table<'_>, listing: &mut Listing) -> Result<f64, DescriptionError> {
    let entry = root.entry("period_s");
    let period = entry.as_ref().map_or(Ok(DEFAULT_PERIOD), |entry| entry.number(PERIOD))?;
    listing.begin("control cycle");
    listing.number("period_s", period, source_of(entry.map(|entry| entry.line())));
    Ok(libm::round(1e9 * period) / 1e9)
}

/// Mass at the end point, kg.
pub(super) fn payload(
    root: &Table<'_>,
    end_point: Option<usize>,
    listing: &mut Listing,
) -> Result<f64, DescriptionError> {
    let table = root.table("payload")?;
    table.iter().try_for_each(|table| table.check_keys(&PAYLOAD))?;
    let entry = table.map(|table| table.required("mass_kg")).transpose()?;
    let mass = entry.as_ref().map_or(Ok(0.0), |entry| entry.number(NON_NEGATIVE))?;
    if let (Some(entry), None, true) = (&entry, end_point, mass > 0.0) {
        return Err(entry.problem(
            ", but there is no end point that carries it: expected 0, a site of the body as `endpoint` \
                    in [task], or a site `endpoint`",
        ));
    }
    listing.begin("[payload]");
    listing.number("mass_kg", mass, source_of(entry.map(|entry| entry.line())));
    Ok(mass)
}

/// Tolerances of manufacture.
pub(super) fn tolerances(root: &Table<'_>, listing: &mut Listing) -> Result<Tolerances, DescriptionError> {
    let table = root.table("tolerances")?;
    table.iter().try_for_each(|table| table.check_keys(&keys(TOLERANCES, &[])))?;
    listing.begin("[tolerances]");
    let layers: Vec<Table<'_>> = table.into_iter().collect();
    let named = ("", ValueSource::Default);
    overlay(&layers, TOLERANCES, Tolerances::default(), Tolerances::validate, listing, named)
}

/// Constants of the rules for the controller's gains.
pub(super) fn rules(root: &Table<'_>, listing: &mut Listing) -> Result<ControlRules, DescriptionError> {
    let table = root.table("control")?;
    table.iter().try_for_each(|table| table.check_keys(&keys(CONTROL, &[])))?;
    listing.begin("[control]");
    let layers: Vec<Table<'_>> = table.into_iter().collect();
    let named = ("", ValueSource::Default);
    overlay(&layers, CONTROL, ControlRules::default(), ControlRules::validate, listing, named)
}
