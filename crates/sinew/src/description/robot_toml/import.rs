//! From the tables of a file to parts: names become indices.

use super::top_level::{MACHINE_KEYS, ROBOT_KEYS};
use crate::body::{
    Actuator, ActuatorKind, Body, Coupling, Geom, GeomKind, Joint, JointKind, Key, Parts, PathElement,
    SheathGeometry, Site, Tendon, TendonPath, Wrap, WrapKind,
};
use crate::description::Description;
use crate::description::document::{Document, Entry, Table};
use crate::description::domain::FINITE;
use crate::description::error::DescriptionError;
use crate::description::mjcf;
use crate::description::orientation::{IDENTITY, unit, z_to};
use crate::description::origin::Origins;
use alloc::collections::BTreeMap;
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;

/// Keys of each kind of table.
const BODY: [&str; 8] = [
    "name",
    "parent",
    "position_m",
    "orientation_wxyz",
    "mass_kg",
    "center_of_mass_m",
    "inertia_kg_m2",
    "gravity_compensation",
];
/// Keys in `rad` and `nm` belong to hinges and balls, those in `m` and `n` to slides.
const JOINT: [&str; 19] = [
    "name",
    "body",
    "kind",
    "anchor_m",
    "axis",
    "reference_rad",
    "reference_m",
    "range_rad",
    "range_m",
    "armature_kg_m2",
    "armature_kg",
    "damping_nm_s_per_rad",
    "damping_n_s_per_m",
    "friction_nm",
    "friction_n",
    "stiffness_nm_per_rad",
    "stiffness_n_per_m",
    "spring_reference_rad",
    "spring_reference_m",
];
const COUPLING: [&str; 4] = ["follower", "leader", "coefficients", "pieces"];
const SITE: [&str; 5] = ["name", "body", "position_m", "orientation_wxyz", "active"];
const ACTIVE: [&str; 3] = ["joint", "range_rad", "range_m"];
const WRAP: [&str; 6] = ["name", "body", "kind", "radius_m", "position_m", "orientation_wxyz"];
const GEOM: [&str; 6] = ["body", "kind", "size_m", "ends_m", "position_m", "orientation_wxyz"];
const MUSCLE: [&str; 8] = [
    "name",
    "path",
    "joints",
    "sheath",
    "length_range_m",
    "damping_n_s_per_m",
    "stiffness_n_per_m",
    "spring_length_m",
];
/// Without a path or joints it is along the tendon of that name.
const SPRING: [&str; 7] =
    ["name", "path", "joints", "stiffness_n_per_m", "slack_lengths_m", "damping_n_s_per_m", "one_sided"];
/// A length that no pose reaches, m: of springs that push nowhere.
const NEVER: f64 = -1e3;
const PATH_ELEMENT: [&str; 4] = ["site", "wrap", "side", "pulley"];
const TERM: [&str; 2] = ["joint", "coefficient"];
const SHEATH: [&str; 3] = ["length_m", "bend_rad", "end_axis"];
const ACTUATOR: [&str; 7] = ["name", "muscle", "kind", "gear", "control_range", "force_range_n", "law"];
const KEY: [&str; 2] = ["name", "q"];

/// What a file beside a URDF describes.
const MUSCLE_FILE_KEYS: [&str; 6] = ["site", "wrap", "geom", "muscle", "spring", "actuator"];

const JOINT_KINDS: [(JointKind, &str); 4] = [
    (JointKind::Hinge, "hinge"),
    (JointKind::Slide, "slide"),
    (JointKind::Ball, "ball"),
    (JointKind::Free, "free"),
];
const WRAP_KINDS: [(WrapKind, &str); 2] = [(WrapKind::Sphere, "sphere"), (WrapKind::Cylinder, "cylinder")];

/// Reads a robot from this project's TOML, or from a machine file that contains it.
///
/// SI units; orientations are quaternions `[w, x, y, z]`; parts refer to each other by name, and the first
/// body is `world`. Keys are optional where a default stands.
///
/// | table | keys | default |
/// |---|---|---|
/// | | `name`; `gravity_m_per_s2` | empty; `[0, 0, -9.81]` |
/// | `[[body]]` | `name`; `parent`, a body before it; `position_m`, `orientation_wxyz` in the parent; `mass_kg`, `center_of_mass_m`, `inertia_kg_m2 = [xx, yy, zz]` or with `xy, xz, yz`; `gravity_compensation`, fraction of its weight that is held | world; zero |
/// | `[[joint]]` | `name`, `body`, `kind` (hinge, slide, ball, free), `axis` of a hinge or slide; `anchor_m`; of joints that turn `range_rad`, `reference_rad`, `armature_kg_m2`, `damping_nm_s_per_rad`, `friction_nm`, `stiffness_nm_per_rad`, `spring_reference_rad`; of slides the same in `m`, `kg`, `n_s_per_m`, `n`, `n_per_m` | no range; zero |
/// | `[[site]]` | `name`, `body`; `position_m`, `orientation_wxyz` in the body; `active = { joint, range_rad }` (`range_m` of a slide): elsewhere paths go past it, straight from the site before to the one behind | its frame; always |
/// | `[[wrap]]` | `name`, `body`, `kind` (sphere, cylinder about z), `radius_m`; `position_m`, `orientation_wxyz` | its frame |
/// | `[[geom]]` | for drawings: `body`, `kind` (sphere, capsule, cylinder, ellipsoid, box), `size_m` (radius; radius and half length; half axes or half lengths); `position_m`, `orientation_wxyz`; or, of a capsule or cylinder of one size, its radius, both ends of its axis `ends_m = [x, y, z, x, y, z]` | its frame |
/// | `[[muscle]]` | `name`; a `path` of `{ site }`, `{ wrap, side }` and `{ pulley }`, the number that divides the lengths after it; or `joints` of `{ joint, coefficient }`, m per rad or 1; `sheath = { length_m, bend_rad, end_axis }`, `length_range_m`, `damping_n_s_per_m`, `stiffness_n_per_m`, `spring_length_m` (two numbers) | no sheath, no range, zero |
/// | `[[spring]]` | `name`; `path` or `joints` as a muscle, or the name is that of a tendon; `stiffness_n_per_m`; `slack_lengths_m`, two, between which it is slack; `damping_n_s_per_m`; `one_sided = true`: it never pushes | those of the tendon; zero, the length where the joints' springs are at rest |
/// | `[[coupling]]` | `follower`, `leader` (joints), `coefficients`: five, of the powers 0 to 4 of the leader's coordinate, rad or m; or a curve of `pieces`, each `[x, a, b, c, d]`: from `x` of the leader on `a + b s + c s^2 + d s^3` with `s` from there | no leader: a constant |
/// | `[[actuator]]` | `name`, `muscle`, `kind` (MJCF's element), `gear`: force at the muscle per unit of control, negative for a pull; `control_range` (N where the gear is -1), `force_range_n`, `law`: MJCF's attributes as texts | none |
/// | `[[key]]` | `name`, `q`: the coordinates of all joints in order, rad or m, of balls and free joints with quaternions | none |
///
/// # Errors
///
/// The first error: file, line, table and key, the value and what was expected.
pub fn from_toml(file: &str, text: &str) -> Result<Description, DescriptionError> {
    let document = Document::new(file, text);
    let table = document.parse()?;
    let root = document.root(&table, "robot");
    let keys: Vec<&str> = ROBOT_KEYS.iter().chain(&MACHINE_KEYS).copied().collect();
    root.check_keys(&keys)?;
    description(&root)
}

/// The robot of a document whose outermost keys are known.
pub(in crate::description) fn description(root: &Table<'_>) -> Result<Description, DescriptionError> {
    let mut reader = Reader { root, parts: Parts::default(), origins: Origins::new(root.file()) };
    if let Some(name) = root.entry("name") {
        reader.parts.name = name.string()?.to_string();
    }
    reader.parts.gravity = numbers(root, "gravity_m_per_s2", [0.0, 0.0, -9.81])?;
    reader.origins.set_keys(root.file(), root.text());
    reader.bodies()?;
    reader.joints()?;
    reader.couplings()?;
    reader.muscles_and_their_parts()?;
    reader.keys()?;
    Ok(Description { parts: reader.parts, warnings: Vec::new(), origins: reader.origins })
}

/// Adds the springs of a machine file to a body from elsewhere.
pub(in crate::description) fn add_springs(
    root: &Table<'_>,
    description: &mut Description,
) -> Result<(), DescriptionError> {
    let Description { parts, origins, .. } = description;
    let mut reader = Reader { root, parts: core::mem::take(parts), origins: core::mem::take(origins) };
    reader.origins.set_keys(root.file(), root.text());
    let done = reader.springs();
    (*parts, *origins) = (reader.parts, reader.origins);
    done
}

/// The names and lines of the springs of a file whose tables have been read.
pub(in crate::description) fn spring_tables(root: &Table<'_>) -> Vec<(String, usize)> {
    let tables = root.tables("spring", "name", &SPRING).unwrap_or_default();
    tables.into_iter().map(|(table, named)| (named.text, table.line())).collect()
}

/// Adds the sites, wraps, shapes, muscles, springs and actuators of a file to a robot whose bodies come from
/// elsewhere.
pub(in crate::description) fn add_muscles(
    parts: Parts,
    mut origins: Origins,
    file: &str,
    text: &str,
) -> Result<(Parts, Origins), DescriptionError> {
    let document = Document::new(file, text);
    let table = document.parse()?;
    let root = document.root(&table, "robot");
    root.check_keys(&ROBOT_KEYS)?;
    if let Some(entry) = root.entries().into_iter().find(|entry| !MUSCLE_FILE_KEYS.contains(&entry.key)) {
        let known = MUSCLE_FILE_KEYS.join("]], [[");
        return Err(entry.bare(&format!("{} comes from the URDF: expected tables [[{known}]]", entry.key)));
    }
    origins.set_keys(file, text);
    let mut reader = Reader { root: &root, parts, origins };
    reader.muscles_and_their_parts()?;
    Ok((reader.parts, reader.origins))
}

/// Names of one kind, each with its index.
struct Names {
    kind: &'static str,
    places: BTreeMap<String, usize>,
}

impl Names {
    fn new<'a>(kind: &'static str, known: impl Iterator<Item = &'a String>) -> Names {
        Names { kind, places: known.enumerate().map(|(i, name)| (name.clone(), i)).collect() }
    }

    fn find(&self, entry: &Entry<'_>) -> Result<usize, DescriptionError> {
        let name = entry.text(&format!("the name of a {}", self.kind))?;
        self.places.get(name).copied().ok_or_else(|| {
            let known: Vec<&str> = self.places.keys().map(String::as_str).collect();
            entry.unknown_name(self.kind, &known)
        })
    }

    /// That of a key, which is required.
    fn required(&self, table: &Table<'_>, key: &str) -> Result<usize, DescriptionError> {
        self.find(&table.required(key)?)
    }
}

/// The number at a key, which may be missing.
fn number(table: &Table<'_>, key: &str) -> Result<f64, DescriptionError> {
    table.entry(key).map_or(Ok(0.0), |entry| entry.number(FINITE))
}

/// The numbers at a key, which may be missing.
fn numbers<const N: usize>(
    table: &Table<'_>,
    key: &str,
    other: [f64; N],
) -> Result<[f64; N], DescriptionError> {
    Ok(optional(table, key)?.unwrap_or(other))
}

fn optional<const N: usize>(table: &Table<'_>, key: &str) -> Result<Option<[f64; N]>, DescriptionError> {
    table.entry(key).map(|entry| entry.numbers(FINITE)).transpose()
}

/// The kind of a part and its word.
fn kind<K: Copy>(
    table: &Table<'_>,
    known: &[(K, &'static str)],
) -> Result<(K, &'static str), DescriptionError> {
    let words: Vec<&str> = known.iter().map(|(_, word)| *word).collect();
    Ok(known[table.required("kind")?.word(&words)?])
}

/// Position and orientation in the frame of a body.
fn pose(table: &Table<'_>) -> Result<([f64; 3], [f64; 4]), DescriptionError> {
    Ok((numbers(table, "position_m", [0.0; 3])?, numbers(table, "orientation_wxyz", IDENTITY)?))
}

/// The tables of one document, and the parts that are read from them.
struct Reader<'r> {
    root: &'r Table<'r>,
    parts: Parts,
    origins: Origins,
}

impl<'r> Reader<'r> {
    /// Remembers the line of a part.
    fn describe(&mut self, kind: &'static str, index: usize, table: &Table<'_>) {
        self.origins.set(kind, index, self.root.file(), table.line());
    }

    fn body_names(&self) -> Names {
        Names::new("body", self.parts.bodies.iter().map(|body| &body.name))
    }

    fn joint_names(&self) -> Names {
        Names::new("joint", self.parts.joints.iter().map(|joint| &joint.name))
    }

    fn bodies(&mut self) -> Result<(), DescriptionError> {
        self.parts.bodies.push(Body {
            name: "world".to_string(),
            parent: 0,
            position: [0.0; 3],
            orientation: IDENTITY,
            mass: 0.0,
            center_of_mass: [0.0; 3],
            inertia: [0.0; 6],
            gravity_compensation: 0.0,
        });
        let mut bodies = Names { kind: "body before it", ..self.body_names() };
        for (table, named) in self.root.tables("body", "name", &BODY)? {
            // Bodies stand after their parents.
            let parent = table.entry("parent").map_or(Ok(0), |parent| bodies.find(&parent))?;
            let index = self.parts.bodies.len();
            if bodies.places.insert(named.text.clone(), index).is_some() {
                return Err(table.required("name")?.refuse("another name than that of the world"));
            }
            self.describe("body", index, &table);
            let (position, orientation) = pose(&table)?;
            self.parts.bodies.push(Body {
                name: named.text,
                parent,
                position,
                orientation,
                mass: number(&table, "mass_kg")?,
                center_of_mass: numbers(&table, "center_of_mass_m", [0.0; 3])?,
                gravity_compensation: number(&table, "gravity_compensation")?,
                inertia: table.entry("inertia_kg_m2").map_or(Ok([0.0; 6]), |entry| inertia(&entry))?,
            });
        }
        Ok(())
    }

    fn joints(&mut self) -> Result<(), DescriptionError> {
        let bodies = self.body_names();
        for (table, named) in self.root.tables("joint", "name", &JOINT)? {
            let body = bodies.required(&table, "body")?;
            if self.parts.joints.last().is_some_and(|last| last.body > body) {
                return Err(table
                    .error("stands after a joint of a later body: expected joints in the order of bodies"));
            }
            self.describe("joint", self.parts.joints.len(), &table);
            self.parts.joints.push(joint(&table, named.text, body)?);
        }
        Ok(())
    }

    fn couplings(&mut self) -> Result<(), DescriptionError> {
        let joints = self.joint_names();
        for (table, _) in self.root.tables("coupling", "follower", &COUPLING)? {
            self.describe("coupling", self.parts.couplings.len(), &table);
            let pieces = match table.entry("pieces") {
                Some(entry) => entry.rows(FINITE)?,
                None => Vec::new(),
            };
            let coefficients = match table.entry("coefficients") {
                None if !pieces.is_empty() => [0.0; 5],
                _ => table.required("coefficients")?.numbers(FINITE)?,
            };
            self.parts.couplings.push(Coupling {
                follower: joints.required(&table, "follower")?,
                leader: table.entry("leader").map(|leader| joints.find(&leader)).transpose()?,
                coefficients,
                pieces,
            });
        }
        Ok(())
    }

    /// All that may stand in a file beside a URDF.
    fn muscles_and_their_parts(&mut self) -> Result<(), DescriptionError> {
        self.sites()?;
        self.wraps()?;
        self.geoms()?;
        self.muscles()?;
        self.springs()?;
        self.actuators()
    }

    fn sites(&mut self) -> Result<(), DescriptionError> {
        let (bodies, joints) = (self.body_names(), self.joint_names());
        for (table, named) in self.root.tables("site", "name", &SITE)? {
            self.describe("site", self.parts.sites.len(), &table);
            let body = bodies.required(&table, "body")?;
            let (position, orientation) = pose(&table)?;
            let mut active = None;
            if let Some(entry) = table.entry("active") {
                let inner = entry.inner_table(&ACTIVE)?;
                let joint = joints.required(&inner, "joint")?;
                let slide = self.parts.joints[joint].kind == JointKind::Slide;
                let range = inner.required(if slide { "range_m" } else { "range_rad" })?;
                active = Some((joint, range.numbers(FINITE)?));
            }
            self.parts.sites.push(Site { name: named.text, body, position, orientation, active });
        }
        Ok(())
    }

    fn wraps(&mut self) -> Result<(), DescriptionError> {
        let bodies = self.body_names();
        for (table, named) in self.root.tables("wrap", "name", &WRAP)? {
            self.describe("wrap", self.parts.wraps.len(), &table);
            let body = bodies.required(&table, "body")?;
            let (kind, _) = kind(&table, &WRAP_KINDS)?;
            let radius = table.required("radius_m")?.number(FINITE)?;
            let (position, orientation) = pose(&table)?;
            self.parts.wraps.push(Wrap { name: named.text, body, kind, radius, position, orientation });
        }
        Ok(())
    }

    fn geoms(&mut self) -> Result<(), DescriptionError> {
        let bodies = self.body_names();
        for (table, _) in self.root.tables_about("geom", "body", &GEOM)? {
            self.describe("geom", self.parts.geoms.len(), &table);
            let body = bodies.required(&table, "body")?;
            self.parts.geoms.push(geom(&table, body)?);
        }
        Ok(())
    }

    fn muscles(&mut self) -> Result<(), DescriptionError> {
        let sites = Names::new("site", self.parts.sites.iter().map(|site| &site.name));
        let wraps = Names::new("wrap", self.parts.wraps.iter().map(|wrap| &wrap.name));
        let joints = self.joint_names();
        for (table, named) in self.root.tables("muscle", "name", &MUSCLE)? {
            self.describe("tendon", self.parts.tendons.len(), &table);
            let path = path(&table, &sites, &wraps, &joints)?
                .ok_or_else(|| table.error("expected either `path` or `joints`"))?;
            self.parts.tendons.push(Tendon {
                name: named.text,
                path,
                sheath: table.entry("sheath").map(|entry| sheath(&entry)).transpose()?,
                range: optional(&table, "length_range_m")?,
                damping: number(&table, "damping_n_s_per_m")?,
                stiffness: number(&table, "stiffness_n_per_m")?,
                spring_length: optional(&table, "spring_length_m")?,
            });
        }
        Ok(())
    }

    fn springs(&mut self) -> Result<(), DescriptionError> {
        let sites = Names::new("site", self.parts.sites.iter().map(|site| &site.name));
        let wraps = Names::new("wrap", self.parts.wraps.iter().map(|wrap| &wrap.name));
        let joints = self.joint_names();
        for (table, named) in self.root.tables("spring", "name", &SPRING)? {
            let along = self.parts.tendons.iter().position(|tendon| tendon.name == named.text);
            let spring = match (path(&table, &sites, &wraps, &joints)?, along) {
                (Some(path), None) => {
                    self.describe("spring", self.parts.springs.len(), &table);
                    self.parts.springs.push(Tendon {
                        name: named.text,
                        path,
                        sheath: None,
                        range: None,
                        damping: 0.0,
                        stiffness: table.required("stiffness_n_per_m")?.number(FINITE)?,
                        spring_length: None,
                    });
                    self.parts.springs.last_mut()
                }
                (None, Some(tendon)) => self.parts.tendons.get_mut(tendon),
                (Some(_), Some(_)) => {
                    return Err(table.error(
                        "has a path and the name of a tendon: expected one of them, or another name",
                    ));
                }
                (None, None) => None,
            };
            let Some(spring) = spring else {
                return Err(table.error("expected `path`, `joints` or the name of a tendon of the body"));
            };
            for (key, value) in
                [("stiffness_n_per_m", &mut spring.stiffness), ("damping_n_s_per_m", &mut spring.damping)]
            {
                *value = table.entry(key).map_or(Ok(*value), |entry| entry.number(FINITE))?;
            }
            spring.spring_length = optional(&table, "slack_lengths_m")?.or(spring.spring_length);
            if let Some(entry) = table.entry("one_sided")
                && entry.flag()?
            {
                let Some([low, _]) = &mut spring.spring_length else {
                    return Err(entry.bare("one_sided: expected `slack_lengths_m` beside it"));
                };
                *low = NEVER;
            }
        }
        Ok(())
    }

    fn actuators(&mut self) -> Result<(), DescriptionError> {
        let tendons = Names::new("muscle", self.parts.tendons.iter().map(|tendon| &tendon.name));
        for (table, named) in self.root.tables("actuator", "name", &ACTUATOR)? {
            self.describe("actuator", self.parts.actuators.len(), &table);
            // The MJCF element.
            let (kind, word) = kind(&table, &ActuatorKind::WORDS)?;
            self.parts.actuators.push(Actuator {
                name: named.text,
                kind,
                tendon: tendons.required(&table, "muscle")?,
                gear: table.required("gear")?.number(FINITE)?,
                control_range: optional(&table, "control_range")?,
                force_range: optional(&table, "force_range_n")?,
                law: table.entry("law").map_or(Ok(BTreeMap::new()), |entry| law(&entry, word))?,
            });
        }
        Ok(())
    }

    fn keys(&mut self) -> Result<(), DescriptionError> {
        for (table, named) in self.root.tables("key", "name", &KEY)? {
            self.describe("key", self.parts.keys.len(), &table);
            // All coordinates, joints in order, rad or m; quaternions [w, x, y, z].
            let q = table.required("q")?.list(FINITE)?;
            self.parts.keys.push(Key { name: named.text, q });
        }
        Ok(())
    }
}

/// `[xx, yy, zz]` or `[xx, yy, zz, xy, xz, yz]`.
fn inertia(entry: &Entry<'_>) -> Result<[f64; 6], DescriptionError> {
    match entry.list(FINITE)?[..] {
        [xx, yy, zz] => Ok([xx, yy, zz, 0.0, 0.0, 0.0]),
        [xx, yy, zz, xy, xz, yz] => Ok([xx, yy, zz, xy, xz, yz]),
        _ => Err(entry.refuse("3 or 6 numbers")),
    }
}

fn joint(table: &Table<'_>, name: String, body: usize) -> Result<Joint, DescriptionError> {
    let (kind, _) = kind(table, &JOINT_KINDS)?;
    let what = if kind == JointKind::Slide { "a slide" } else { "a joint that turns" };
    // The unit in a key must fit the kind of joint.
    let fitting = |turning: &'static str, sliding: &'static str| {
        let (fits, other) = if kind == JointKind::Slide { (sliding, turning) } else { (turning, sliding) };
        match table.entry(other) {
            Some(entry) => {
                Err(entry.bare(&format!("{other}: its unit does not fit {what}: expected {fits}")))
            }
            None => Ok(fits),
        }
    };
    let one = |turning, sliding| number(table, fitting(turning, sliding)?);
    if table.entry("axis").is_none() && matches!(kind, JointKind::Hinge | JointKind::Slide) {
        return Err(table.error("axis is missing"));
    }
    Ok(Joint {
        name,
        body,
        kind,
        anchor: numbers(table, "anchor_m", [0.0; 3])?,
        axis: numbers(table, "axis", [0.0, 0.0, 1.0])?,
        reference: one("reference_rad", "reference_m")?,
        range: optional(table, fitting("range_rad", "range_m")?)?,
        armature: one("armature_kg_m2", "armature_kg")?,
        damping: one("damping_nm_s_per_rad", "damping_n_s_per_m")?,
        friction: one("friction_nm", "friction_n")?,
        stiffness: one("stiffness_nm_per_rad", "stiffness_n_per_m")?,
        spring_reference: one("spring_reference_rad", "spring_reference_m")?,
        flex: 0.0,
    })
}

/// The shape of a body: between both ends of a capsule or cylinder, else at a position. Parts of a shape are
/// validated with those of the robot, but for what depends on how it is written.
fn geom(table: &Table<'_>, body: usize) -> Result<Geom, DescriptionError> {
    let (kind, word) = kind(table, &GeomKind::WORDS)?;
    let sizes = table.required("size_m")?;
    let mut given = sizes.list(FINITE)?;
    let (mut position, mut orientation) = pose(table)?;
    if let Some(entry) = table.entry("ends_m") {
        let [a, b, c, d, e, f] = entry.numbers(FINITE)?;
        if !matches!(kind, GeomKind::Capsule | GeomKind::Cylinder) || given.len() != 1 {
            return Err(entry.bare("ends_m: expected a capsule or a cylinder with one size, its radius"));
        }
        if ["position_m", "orientation_wxyz"].iter().any(|key| table.entry(key).is_some()) {
            return Err(
                entry.bare("ends_m stands beside position_m or orientation_wxyz: expected one of them")
            );
        }
        let along = [d - a, e - b, f - c];
        let one_point = || entry.bare("ends_m has both ends in one point: expected a length > 0");
        orientation = z_to(unit(along).ok_or_else(one_point)?);
        position = [(a + d) / 2.0, (b + e) / 2.0, (c + f) / 2.0];
        given.push(0.5 * libm::sqrt(along.iter().map(|x| x * x).sum()));
    }
    if given.len() != kind.sizes() || given.iter().any(|size| *size <= 0.0) {
        return Err(sizes.refuse(&format!("{} numbers > 0 for a {word}", kind.sizes())));
    }
    let size = core::array::from_fn(|i| given.get(i).copied().unwrap_or(0.0));
    Ok(Geom { body, kind, size, position, orientation })
}

/// The path of a muscle or spring; none where it has neither a path nor joints.
fn path(
    table: &Table<'_>,
    sites: &Names,
    wraps: &Names,
    joints: &Names,
) -> Result<Option<TendonPath>, DescriptionError> {
    match (table.entry("path"), table.entry("joints")) {
        (Some(path), None) => Ok(Some(TendonPath::Spatial(elements(&path, sites, wraps)?))),
        (None, Some(terms)) => Ok(Some(TendonPath::Fixed(self::terms(&terms, joints)?))),
        (None, None) => Ok(None),
        (Some(_), Some(_)) => Err(table.error("expected either `path` or `joints`")),
    }
}

/// Sites, wraps and pulleys of a muscle, from its origin to its insertion.
fn elements(path: &Entry<'_>, sites: &Names, wraps: &Names) -> Result<Vec<PathElement>, DescriptionError> {
    let tables = path.inner_tables(&PATH_ELEMENT)?;
    if tables.is_empty() {
        return Err(path.refuse("at least two sites"));
    }
    let element = |table: &Table<'_>| {
        let [site, wrap, side, pulley] = PATH_ELEMENT.map(|key| table.entry(key));
        match (site, wrap, side, pulley) {
            (Some(site), None, None, None) => sites.find(&site).map(PathElement::Site),
            (None, Some(wrap), side, None) => {
                let side = side.map(|side| sites.find(&side)).transpose()?;
                wraps.find(&wrap).map(|wrap| PathElement::Wrap { wrap, side })
            }
            (None, None, None, Some(divisor)) => divisor.number(FINITE).map(PathElement::Pulley),
            _ => Err(table.error(
                "not an element of a path: expected one of `site`, `wrap` (with `side` or not), `pulley`",
            )),
        }
    };
    tables.iter().map(element).collect()
}

/// The joints of a muscle whose length is a weighted sum of their coordinates.
fn terms(entry: &Entry<'_>, joints: &Names) -> Result<Vec<(usize, f64)>, DescriptionError> {
    let tables = entry.inner_tables(&TERM)?;
    if tables.is_empty() {
        return Err(entry.refuse("at least one joint"));
    }
    let term = |table: &Table<'_>| {
        Ok((joints.required(table, "joint")?, table.required("coefficient")?.number(FINITE)?))
    };
    tables.iter().map(term).collect()
}

fn sheath(entry: &Entry<'_>) -> Result<SheathGeometry, DescriptionError> {
    let table = entry.inner_table(&SHEATH)?;
    Ok(SheathGeometry {
        length: table.required("length_m")?.number(FINITE)?,
        bend: table.required("bend_rad")?.number(FINITE)?,
        end_axis: optional(&table, "end_axis")?,
    })
}

/// Gain, bias and dynamics as attributes of the MJCF element.
fn law(entry: &Entry<'_>, element: &str) -> Result<BTreeMap<String, String>, DescriptionError> {
    let attribute = |entry: Entry<'_>| {
        let value = entry.string()?;
        mjcf::finite(value).map_err(|problem| entry.bare(&format!("{} {problem}", entry.key)))?;
        Ok((entry.key.to_string(), value.to_string()))
    };
    entry.inner_table(&mjcf::law(element))?.entries().into_iter().map(attribute).collect()
}
