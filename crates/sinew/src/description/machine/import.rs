//! From the text of a machine file, and of the files that it names, to a machine.

use super::devices::{self, Bus, BusReader};
use super::files::{Files, ReadFile};
use super::listing::{Listing, Setting};
use super::places::Places;
use super::{drives, joints, safety, springs, task, transmissions};
use crate::body::{Parts, Robot};
use crate::description::Description;
use crate::description::document::{Document, Entry, Table};
use crate::description::error::{DescriptionError, Warning};
use crate::description::mesh_file::joined;
use crate::description::mjcf::from_mjcf;
use crate::description::names::named;
use crate::description::osim::from_osim;
use crate::description::robot_toml::{self, MACHINE_KEYS, ROBOT_KEYS};
use crate::description::urdf::from_urdf;
use crate::machine::Machine;
use crate::trajectory::Redundancy;
use alloc::format;
use alloc::string::ToString;
use alloc::vec::Vec;

/// A machine with the origin of all its values.
#[derive(Debug, Clone, PartialEq)]
pub struct MachineDescription {
    /// The machine.
    pub machine: Machine,
    /// Every value that is not part of the body, with its origin.
    pub settings: Vec<Setting>,
    /// Ignored content.
    pub warnings: Vec<Warning>,
    /// Where its parts are written: for what is refused only when the machine is used.
    pub places: Places,
}

/// Reads a machine from its TOML.
///
/// `file` names the text in errors; `read` gives the text of the files that it names: the body, the muscles
/// of a body in URDF, identified models of cables, files that a body in MJCF includes. What identifies
/// devices on their bus is left out: see [`machine_on_bus`].
///
/// # Errors
/// The first error: file, line, table, key, the value and what was expected.
///
/// # Example
/// ```
/// use sinew::description::machine_from_toml;
/// let leg = r#"<mujoco><worldbody><body name="shank">
///   <joint name="knee" axis="0 1 0" range="0 90"/><inertial pos="0 0 -0.2" mass="1" diaginertia="0.01 0.01 0.001"/>
/// </body></worldbody><tendon>
///   <fixed name="extensor"><joint joint="knee" coef="0.03"/></fixed>
///   <fixed name="flexor"><joint joint="knee" coef="-0.03"/></fixed>
/// </tendon></mujoco>"#;
/// let text = r#"
/// body = "leg.xml"
/// [every_transmission]
/// sheath_length_m = 0.4
/// "#;
/// let read = machine_from_toml("leg.toml", text, &mut |_| Ok(leg.to_string()))?;
/// assert_eq!((read.machine.muscles.len(), read.machine.muscles[0].sheath), (2, 0.4));
/// # Ok::<(), sinew::description::DescriptionError>(())
/// ```
pub fn machine_from_toml(
    file: &str,
    text: &str,
    read: &mut ReadFile<'_>,
) -> Result<MachineDescription, DescriptionError> {
    machine_in(file, text, read, None)
}

/// As [`machine_from_toml`], with what identifies its devices on a bus.
///
/// # Errors
/// As [`machine_from_toml`], and those of the bus.
pub fn machine_on_bus(
    file: &str,
    text: &str,
    read: &mut ReadFile<'_>,
    bus: &mut dyn BusReader,
) -> Result<MachineDescription, DescriptionError> {
    machine_in(file, text, read, Some(bus))
}

fn machine_in(
    file: &str,
    text: &str,
    read: &mut ReadFile<'_>,
    bus: Bus<'_>,
) -> Result<MachineDescription, DescriptionError> {
    let document = Document::new(file, text);
    let table = document.parse()?;
    let root = document.root(&table, "machine");
    let mut files = Files::new(file, read);
    let description = body(&root, &mut files)?;
    machine(&root, description, &mut files, bus)
}

/// A machine of which the body alone is described: everything else is a default.
///
/// # Errors
/// As [`Description::robot`]; a robot that cannot be a machine, for example one without muscles.
pub fn machine_of(description: Description) -> Result<MachineDescription, DescriptionError> {
    let file = description.origins.file().to_string();
    let document = Document::new(&file, "");
    let table = document.parse()?;
    let none = &mut |_: super::FileReference<'_>| Err("is not read".to_string());
    machine(&document.root(&table, "machine"), description, &mut Files::new(&file, none), None)
}

/// Reads the robot of a machine file or of a robot file: its body, with the travel and the poses of the
/// machine file. It may be one that cannot be a machine.
///
/// # Errors
/// As [`machine_from_toml`].
pub fn robot_from_toml(
    file: &str,
    text: &str,
    read: &mut ReadFile<'_>,
) -> Result<(Robot, Vec<Warning>), DescriptionError> {
    let document = Document::new(file, text);
    let table = document.parse()?;
    let root = document.root(&table, "machine");
    let description = body(&root, &mut Files::new(file, read))?;
    robot(&root, description, &mut Listing::default())
}

/// Whether a TOML file has keys that no robot file has.
///
/// # Errors
/// As [`machine_from_toml`], for text that is no TOML.
pub fn has_machine_keys(file: &str, text: &str) -> Result<bool, DescriptionError> {
    let document = Document::new(file, text);
    let table = document.parse()?;
    let root = document.root(&table, "machine");
    let named = root.entry("body").is_some_and(|entry| entry.is_text());
    Ok(named || MACHINE_KEYS.iter().any(|key| root.entry(key).is_some()))
}

/// The description of the body: of the tables in the same file, or of another file.
fn body(root: &Table<'_>, files: &mut Files<'_>) -> Result<Description, DescriptionError> {
    let keys: Vec<&str> = ROBOT_KEYS.iter().chain(&MACHINE_KEYS).copied().collect();
    root.check_keys(&keys)?;
    match (root.entry("body"), root.entry("muscles")) {
        (Some(entry), muscles) if entry.is_text() => body_file(root, &entry, muscles.as_ref(), files),
        (_, Some(muscles)) => Err(muscles.problem(", but the body is none in URDF: expected no such key")),
        _ => robot_toml::description(root),
    }
}

fn body_file(
    root: &Table<'_>,
    entry: &Entry<'_>,
    muscles: Option<&Entry<'_>>,
    files: &mut Files<'_>,
) -> Result<Description, DescriptionError> {
    let path = entry.text("the path of a robot file")?;
    if let Some(other) = ROBOT_KEYS
        .iter()
        .filter(|key| !["body", "name", "spring"].contains(*key))
        .find_map(|key| root.entry(key))
    {
        let expected = format!("`{}` stands beside the file of a body: expected in {path}", other.key);
        return Err(other.bare(&expected));
    }
    let extension = path.rsplit_once('.').map(|(_, extension)| extension.to_ascii_lowercase());
    if !matches!(extension.as_deref(), Some("toml" | "xml" | "mjcf" | "urdf" | "osim")) {
        return Err(entry.refuse("a file that ends in .toml, .xml, .urdf or .osim"));
    }
    if let (Some(muscles), false) = (muscles, extension.as_deref() == Some("urdf")) {
        return Err(muscles.problem(", but the body is none in URDF: expected no such key"));
    }
    let reason = |entry: &Entry<'_>, problem: &str| entry.problem(&format!(": {problem}"));
    let mut read =
        |entry: &Entry<'_>, path: &str| files.read(path).map_err(|problem| reason(entry, &problem));
    let text = read(entry, path)?;
    let mut description = match extension.as_deref() {
        Some("toml") => {
            let shown = files.display(path);
            let document = Document::new(&shown, &text);
            let table = document.parse()?;
            let root = document.root(&table, "robot");
            root.check_keys(&ROBOT_KEYS)?;
            robot_toml::description(&root)?
        }
        Some("urdf") => {
            let muscles = match muscles {
                Some(entry) => {
                    let path = entry.text("the path of a TOML file")?;
                    Some((path, read(entry, path)?))
                }
                None => None,
            };
            let muscles = muscles.map(|(path, text)| (files.display(path), text));
            let muscles = muscles.as_ref().map(|(name, text)| (name.as_str(), text.as_str()));
            from_urdf(&files.display(path), &text, muscles)?
        }
        Some("osim") => from_osim(&files.display(path), &text)?,
        _ => {
            let shown = files.display(path);
            from_mjcf(&shown, &text, &mut |file| files.include(file, path))?
        }
    };
    // Meshes are named relative to the body's file.
    if let Some((folder, _)) = path.rsplit_once('/') {
        for mesh in &mut description.parts.meshes {
            mesh.file = joined(folder, &mesh.file);
        }
    }
    if let Some(name) = root.entry("name") {
        description.parts.name = name.text("a name")?.to_string();
    }
    robot_toml::add_springs(root, &mut description)?;
    Ok(description)
}

/// The robot with the travel and the poses of the machine file.
fn robot(
    root: &Table<'_>,
    mut description: Description,
    listing: &mut Listing,
) -> Result<(Robot, Vec<Warning>), DescriptionError> {
    joints::travel(root, &mut description.parts, listing)?;
    let (robot, warnings) = description.robot()?;
    let poses = joints::poses(root, &robot, listing)?;
    if poses.is_empty() {
        return Ok((robot, warnings));
    }
    let mut parts: Parts = robot.parts().clone();
    parts.keys.extend(poses);
    let robot = Robot::new(parts).map_err(|error| root.error(&error.to_string()))?;
    Ok((robot, warnings))
}

/// The machine of a described body and of the other tables.
fn machine(
    root: &Table<'_>,
    mut description: Description,
    files: &mut Files<'_>,
    mut bus: Bus<'_>,
) -> Result<MachineDescription, DescriptionError> {
    description.parts = named(&description.parts);
    if let Some(Warning { file, line, what, .. }) =
        description.warnings.iter().find(|warning| warning.changes_forces)
    {
        let (file, place) = (file.clone(), "body".to_string());
        let problem = format!("{what}, but changes its forces: expected a body without it");
        return Err(DescriptionError { file, line: *line, place, problem });
    }
    let mut listing = Listing::default();
    springs::divide(root, &mut description);
    let origins = description.origins.clone();
    let (robot, mut warnings) = robot(root, description, &mut listing)?;
    let places = Places::new(root, &robot, &origins);
    let mut machine = Machine::from_robot(&robot).map_err(|error| places.error(error))?;
    let list = &mut listing;
    joints::start(root, &robot, &mut machine.start, list)?;
    machine.task = task::task(root, &robot, list)?;
    machine.redundancy = joints::redundancy(root, &robot, Redundancy::near(&machine.start), list)?;
    machine.paths = task::paths(root, machine.task, list)?;
    machine.period = task::period(root, list)?;
    machine.payload = task::payload(root, machine.payload_site(), list)?;
    let drives = drives::read(root, list)?;
    machine.muscles = transmissions::read(root, &machine, &drives, files, list)?;
    springs::list(root, robot.parts(), list);
    machine.encoders = joints::encoders(root, &robot, list)?;
    machine.devices = devices::read(root, &machine, &mut bus, list)?;
    machine.tolerances = task::tolerances(root, list)?;
    machine.rules = task::rules(root, list)?;
    machine.safety = safety::safety(root, &machine, list)?;
    machine.validate().map_err(|error| places.error(error))?;
    for drive in transmissions::unused(root, &drives) {
        let what = format!("drive `{}` belongs to no muscle: it has no effect", drive.name);
        warnings.push(Warning {
            file: root.file().to_string(),
            line: drive.line,
            what,
            changes_forces: false,
        });
    }
    Ok(MachineDescription { machine, settings: listing.settings, warnings, places })
}
