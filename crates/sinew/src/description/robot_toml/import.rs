//! From the file as written to parts: names become indices.

use super::top_level::{MACHINE_KEYS, ROBOT_KEYS};
use super::written::{self as w, Finite, Vector};
use crate::body::{
    Actuator, ActuatorKind, Body, Coupling, Geom, GeomKind, Joint, JointKind, Key, Parts, PathElement,
    SheathGeometry, Site, Tendon, TendonPath, Wrap, WrapKind,
};
use crate::description::Description;
use crate::description::deserialized::refused;
use crate::description::document::Document;
use crate::description::error::DescriptionError;
use crate::description::mjcf;
use crate::description::orientation::{IDENTITY, unit, z_to};
use crate::description::origin::{Keys, Origins};
use crate::description::spelling::near;
use alloc::collections::BTreeMap;
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;
use toml::Spanned;

/// Name and text of a file, for the positions of errors.
struct Source<'a> {
    file: &'a str,
    text: &'a str,
}

impl Source<'_> {
    fn line(&self, at: usize) -> usize {
        self.text.as_bytes().iter().take(at).filter(|byte| **byte == b'\n').count() + 1
    }

    /// Records the first line of every table.
    fn describe(&self, written: &w::File, origins: &mut Origins) {
        origins.set_keys(self.file, self.text);
        let ends: Vec<usize> =
            self.text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n').map(|(at, _)| at).collect();
        let mut all = |kind: &'static str, first: usize, starts: &mut dyn Iterator<Item = usize>| {
            for (index, start) in starts.enumerate() {
                origins.set(kind, first + index, self.file, ends.partition_point(|&end| end < start) + 1);
            }
        };
        all("body", 1, &mut written.body.iter().map(|table| table.span().start));
        all("joint", 0, &mut written.joint.iter().map(|table| table.span().start));
        all("site", 0, &mut written.site.iter().map(|table| table.span().start));
        all("wrap", 0, &mut written.wrap.iter().map(|table| table.span().start));
        all("geom", 0, &mut written.geom.iter().map(|table| table.span().start));
        all("tendon", 0, &mut written.muscle.iter().map(|table| table.span().start));
        all("coupling", 0, &mut written.coupling.iter().map(|table| table.span().start));
        all("actuator", 0, &mut written.actuator.iter().map(|table| table.span().start));
        all("key", 0, &mut written.key.iter().map(|table| table.span().start));
    }

    fn error(&self, at: usize, place: &str, problem: &str) -> DescriptionError {
        let (file, line) = (self.file.to_string(), self.line(at));
        DescriptionError { file, line, place: place.to_string(), problem: problem.to_string() }
    }

    /// The line, within the table at `at`, of the name that the message quotes, else of the key that begins it,
    /// else that of the table.
    fn field(&self, at: usize, problem: &str) -> usize {
        let quoted = problem.split('`').nth(1).map(|name| format!("\"{name}\""));
        let rest = self.text.get(at..).unwrap_or("").lines().enumerate();
        let mut table = rest.take_while(|(index, line)| *index == 0 || !line.starts_with('['));
        if let Some((index, _)) =
            table.find(|(_, line)| quoted.as_ref().is_some_and(|name| line.contains(name)))
        {
            return self.line(at) + index;
        }
        let key: String = problem.chars().take_while(|c| c.is_ascii_alphanumeric() || *c == '_').collect();
        Keys::of(self.text).line(self.line(at), &key)
    }

    fn parse(&self) -> Result<w::File, DescriptionError> {
        toml::from_str(self.text).map_err(|error| {
            let document = Document::new(self.file, self.text);
            let span = error.span().unwrap_or(0..0);
            document
                .parse()
                .map_or_else(|error| error, |table| refused(&document, &table, span, error.message()))
        })
    }
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

    fn find(&self, name: &str) -> Result<usize, String> {
        let found = self.places.get(name).copied();
        found.ok_or_else(|| {
            let known: Vec<&str> = self.places.keys().map(String::as_str).collect();
            format!("`{name}`: there is no {} of that name (before it){}", self.kind, near(name, &known))
        })
    }

    fn take(&mut self, name: &str, place: usize) -> Result<(), String> {
        if name.is_empty() {
            return Err("name is empty".to_string());
        }
        match self.places.insert(name.to_string(), place) {
            None => Ok(()),
            Some(_) => Err(format!("name is taken already by another {}", self.kind)),
        }
    }
}

fn vector<const N: usize>(given: Vector<N>, other: [f64; N]) -> [f64; N] {
    given.map_or(other, |given| given.0)
}

fn number(given: Option<Finite>) -> f64 {
    given.map_or(0.0, |x| x.0)
}

fn range(given: Vector<2>) -> Option<[f64; 2]> {
    given.map(|given| given.0)
}

/// Refuses unknown outermost keys, and a machine file whose body is in another file.
fn check_top_level(file: &str, text: &str, others: &[&str]) -> Result<(), DescriptionError> {
    let document = Document::new(file, text);
    let table = document.parse()?;
    let root = document.root(&table);
    let keys: Vec<&str> = ROBOT_KEYS.iter().chain(others).copied().collect();
    root.check_keys(&keys)?;
    match root.entry("body") {
        Some(entry) if entry.is_text() => Err(entry.refuse("tables [[body]] in a robot file")),
        _ => Ok(()),
    }
}

/// Reads a robot from this project's TOML, or from a machine file that contains it.
///
/// # Errors
///
/// The first error: file, line, table and key, the value and what was expected.
pub fn from_toml(file: &str, text: &str) -> Result<Description, DescriptionError> {
    let source = Source { file, text };
    check_top_level(file, text, &MACHINE_KEYS)?;
    let written = source.parse()?;
    let mut parts = Parts { name: written.name.clone(), gravity: [0.0, 0.0, -9.81], ..Parts::default() };
    parts.gravity = vector(written.gravity_m_per_s2, parts.gravity);
    parts.bodies.push(Body {
        name: "world".to_string(),
        parent: 0,
        position: [0.0; 3],
        orientation: IDENTITY,
        mass: 0.0,
        center_of_mass: [0.0; 3],
        inertia: [0.0; 6],
    });
    let mut bodies = Names::new("body", parts.bodies.iter().map(|body| &body.name));
    each(&source, "body", &written.body, |b| &b.name, |b| body(&mut parts, &mut bodies, b))?;
    let mut joints = Names::new("joint", core::iter::empty());
    each(&source, "joint", &written.joint, |j| &j.name, |j| joint(&mut parts, &bodies, &mut joints, j))?;
    if !parts.joints.is_sorted_by_key(|joint| joint.body) {
        return Err(source.error(
            0,
            "joint",
            "joints stand in another order than their bodies: expected the same",
        ));
    }
    each(&source, "coupling", &written.coupling, |c| &c.follower, |c| coupling(&mut parts, &joints, c))?;
    muscles(&mut parts, &source, &written)?;
    let mut keys = Names::new("key", core::iter::empty());
    each(
        &source,
        "key",
        &written.key,
        |k| &k.name,
        |k| {
            keys.take(&k.name, parts.keys.len())?;
            parts.keys.push(Key { name: k.name.clone(), q: k.q.iter().map(|x| x.0).collect() });
            Ok(())
        },
    )?;
    let mut origins = Origins::new(file);
    source.describe(&written, &mut origins);
    Ok(Description { parts, warnings: Vec::new(), origins })
}

/// Adds the sites, wraps, muscles and actuators of a file to a robot whose bodies come from elsewhere.
pub(in crate::description) fn add_muscles(
    parts: &mut Parts,
    origins: &mut Origins,
    file: &str,
    text: &str,
) -> Result<(), DescriptionError> {
    let source = Source { file, text };
    check_top_level(file, text, &[])?;
    let written = source.parse()?;
    let first =
        written.body.first().map(|b| b.span().start).or(written.joint.first().map(|j| j.span().start));
    if let Some(at) = first {
        return Err(source.error(
            at,
            "body, joint",
            "these come from the URDF: expected sites, wraps, muscles, actuators",
        ));
    }
    source.describe(&written, origins);
    muscles(parts, &source, &written)
}

fn muscles(parts: &mut Parts, source: &Source<'_>, written: &w::File) -> Result<(), DescriptionError> {
    let bodies = Names::new("body", parts.bodies.iter().map(|body| &body.name));
    let joints = Names::new("joint", parts.joints.iter().map(|joint| &joint.name));
    let mut sites = Names::new("site", parts.sites.iter().map(|site| &site.name));
    each(source, "site", &written.site, |s| &s.name, |s| site(parts, &bodies, &mut sites, s))?;
    let mut wraps = Names::new("wrap", parts.wraps.iter().map(|wrap| &wrap.name));
    each(source, "wrap", &written.wrap, |s| &s.name, |s| wrap(parts, &bodies, &mut wraps, s))?;
    each(source, "geom", &written.geom, |s| &s.body, |s| geom(parts, &bodies, s))?;
    let mut tendons = Names::new("muscle", parts.tendons.iter().map(|tendon| &tendon.name));
    each(
        source,
        "muscle",
        &written.muscle,
        |m| &m.name,
        |m| {
            tendons.take(&m.name, parts.tendons.len())?;
            parts.tendons.push(muscle(&sites, &wraps, &joints, m)?);
            Ok(())
        },
    )?;
    let mut actuators = Names::new("actuator", core::iter::empty());
    each(
        source,
        "actuator",
        &written.actuator,
        |a| &a.name,
        |a| {
            actuators.take(&a.name, parts.actuators.len())?;
            parts.actuators.push(actuator(&tendons, a)?);
            Ok(())
        },
    )
}

/// Reads every table of a kind and adds its position to errors.
fn each<T>(
    source: &Source<'_>,
    kind: &str,
    tables: &[Spanned<T>],
    name: impl Fn(&T) -> &String,
    mut read: impl FnMut(&T) -> Result<(), String>,
) -> Result<(), DescriptionError> {
    for table in tables {
        let written = table.get_ref();
        read(written).map_err(|problem| {
            let at = table.span().start;
            let mut error = source.error(at, &format!("[[{kind}]] `{}`", name(written)), &problem);
            error.line = source.field(at, &problem);
            error
        })?;
    }
    Ok(())
}

fn body(parts: &mut Parts, bodies: &mut Names, b: &w::Body) -> Result<(), String> {
    let parent =
        b.parent.as_deref().map_or(Ok(0), |parent| bodies.find(parent).map_err(|e| format!("parent {e}")))?;
    bodies.take(&b.name, parts.bodies.len())?;
    let inertia = b.inertia_kg_m2.map_or([0.0; 6], |tensor| tensor.0);
    parts.bodies.push(Body {
        name: b.name.clone(),
        parent,
        position: vector(b.position_m, [0.0; 3]),
        orientation: vector(b.orientation_wxyz, IDENTITY),
        mass: number(b.mass_kg),
        center_of_mass: vector(b.center_of_mass_m, [0.0; 3]),
        inertia,
    });
    Ok(())
}

fn joint(parts: &mut Parts, bodies: &Names, joints: &mut Names, j: &w::Joint) -> Result<(), String> {
    let body = bodies.find(&j.body).map_err(|e| format!("body {e}"))?;
    joints.take(&j.name, parts.joints.len())?;
    let slide = j.kind == w::JointKind::Slide;
    // The unit in a key must fit the kind of joint.
    let misfit = |[turning, sliding]: [&str; 2]| match slide {
        true => Err(format!("{turning}: its unit does not fit a slide: expected {sliding}")),
        false => Err(format!("{sliding}: its unit does not fit a joint that turns: expected {turning}")),
    };
    let one = |keys, turning: Option<Finite>, sliding: Option<Finite>| match (slide, turning, sliding) {
        (true, Some(_), _) | (false, _, Some(_)) => misfit(keys),
        (_, turning, sliding) => Ok(number(turning.or(sliding))),
    };
    if if slide { j.range_rad.is_some() } else { j.range_m.is_some() } {
        misfit(["range_rad", "range_m"])?;
    }
    if j.axis.is_none() && matches!(j.kind, w::JointKind::Hinge | w::JointKind::Slide) {
        return Err("axis is missing".to_string());
    }
    parts.joints.push(Joint {
        name: j.name.clone(),
        body,
        kind: match j.kind {
            w::JointKind::Hinge => JointKind::Hinge,
            w::JointKind::Slide => JointKind::Slide,
            w::JointKind::Ball => JointKind::Ball,
            w::JointKind::Free => JointKind::Free,
        },
        anchor: vector(j.anchor_m, [0.0; 3]),
        axis: vector(j.axis, [0.0, 0.0, 1.0]),
        reference: one(["reference_rad", "reference_m"], j.reference_rad, j.reference_m)?,
        range: range(j.range_rad.or(j.range_m)),
        armature: one(["armature_kg_m2", "armature_kg"], j.armature_kg_m2, j.armature_kg)?,
        damping: one(
            ["damping_nm_s_per_rad", "damping_n_s_per_m"],
            j.damping_nm_s_per_rad,
            j.damping_n_s_per_m,
        )?,
        friction: one(["friction_nm", "friction_n"], j.friction_nm, j.friction_n)?,
        stiffness: one(
            ["stiffness_nm_per_rad", "stiffness_n_per_m"],
            j.stiffness_nm_per_rad,
            j.stiffness_n_per_m,
        )?,
        spring_reference: one(
            ["spring_reference_rad", "spring_reference_m"],
            j.spring_reference_rad,
            j.spring_reference_m,
        )?,
    });
    Ok(())
}

fn coupling(parts: &mut Parts, joints: &Names, c: &w::Coupling) -> Result<(), String> {
    let find = |key: &str, name: &str| joints.find(name).map_err(|problem| format!("{key} {problem}"));
    let follower = find("follower", &c.follower)?;
    let leader = c.leader.as_deref().map(|leader| find("leader", leader)).transpose()?;
    parts.couplings.push(Coupling { follower, leader, coefficients: c.coefficients.0 });
    Ok(())
}

fn site(parts: &mut Parts, bodies: &Names, sites: &mut Names, s: &w::Site) -> Result<(), String> {
    let body = bodies.find(&s.body).map_err(|e| format!("body {e}"))?;
    sites.take(&s.name, parts.sites.len())?;
    let (position, orientation) = (vector(s.position_m, [0.0; 3]), vector(s.orientation_wxyz, IDENTITY));
    parts.sites.push(Site { name: s.name.clone(), body, position, orientation });
    Ok(())
}

fn wrap(parts: &mut Parts, bodies: &Names, wraps: &mut Names, s: &w::Wrap) -> Result<(), String> {
    let body = bodies.find(&s.body).map_err(|e| format!("body {e}"))?;
    wraps.take(&s.name, parts.wraps.len())?;
    parts.wraps.push(Wrap {
        name: s.name.clone(),
        body,
        kind: match s.kind {
            w::WrapKind::Sphere => WrapKind::Sphere,
            w::WrapKind::Cylinder => WrapKind::Cylinder,
        },
        radius: s.radius_m.0,
        position: vector(s.position_m, [0.0; 3]),
        orientation: vector(s.orientation_wxyz, IDENTITY),
    });
    Ok(())
}

/// The parts of a shape are validated with those of the robot, but for what depends on how it is written.
fn geom(parts: &mut Parts, bodies: &Names, s: &w::Geom) -> Result<(), String> {
    let body = bodies.find(&s.body).map_err(|e| format!("body {e}"))?;
    let kind = GeomKind::from_word(&s.kind).ok_or_else(|| {
        let words: Vec<&str> = GeomKind::WORDS.iter().map(|(_, word)| *word).collect();
        format!("kind {:?}: expected {}", s.kind, words.join(", "))
    })?;
    let mut place = (vector(s.position_m, [0.0; 3]), vector(s.orientation_wxyz, IDENTITY));
    let mut given: Vec<f64> = s.size_m.iter().map(|size| size.0).collect();
    if let Some(w::Numbers([a, b, c, d, e, f])) = s.ends_m {
        if !matches!(kind, GeomKind::Capsule | GeomKind::Cylinder) || given.len() != 1 {
            return Err("ends_m: expected a capsule or a cylinder with one size, its radius".to_string());
        }
        if s.position_m.is_some() || s.orientation_wxyz.is_some() {
            return Err(
                "ends_m stands beside position_m or orientation_wxyz: expected one of them".to_string()
            );
        }
        let along = [d - a, e - b, f - c];
        let axis = unit(along).ok_or("ends_m has both ends in one point: expected a length > 0")?;
        given.push(0.5 * libm::sqrt(along.iter().map(|x| x * x).sum()));
        place = ([(a + d) / 2.0, (b + e) / 2.0, (c + f) / 2.0], z_to(axis));
    }
    if given.len() != kind.sizes() || given.iter().any(|size| *size <= 0.0) {
        return Err(format!("size_m: expected {} numbers > 0 for a {}", kind.sizes(), s.kind));
    }
    let size = core::array::from_fn(|i| given.get(i).copied().unwrap_or(0.0));
    parts.geoms.push(Geom { body, kind, size, position: place.0, orientation: place.1 });
    Ok(())
}

fn muscle(sites: &Names, wraps: &Names, joints: &Names, m: &w::Muscle) -> Result<Tendon, String> {
    let path_element = |s: &w::PathElement| match (&s.site, &s.wrap, &s.side, s.pulley) {
        (Some(site), None, None, None) => sites.find(site).map(PathElement::Site),
        (None, Some(wrap), side, None) => {
            let side = side.as_deref().map(|side| sites.find(side)).transpose()?;
            wraps.find(wrap).map(|wrap| PathElement::Wrap { wrap, side })
        }
        (None, None, None, Some(divisor)) => Ok(PathElement::Pulley(divisor.0)),
        _ => Err("not an element of a path: expected one of `site`, `wrap` (with `side` or not), `pulley`"
            .to_string()),
    };
    let term = |term: &w::Term| joints.find(&term.joint).map(|joint| (joint, term.coefficient.0));
    let within = |key: &'static str| move |problem: String| format!("{key}: {problem}");
    let path = match (&m.path, &m.joints) {
        (Some(path), None) if path.is_empty() => {
            return Err("path is []: expected at least two sites".to_string());
        }
        (None, Some(terms)) if terms.is_empty() => {
            return Err("joints is []: expected at least one joint".to_string());
        }
        (Some(path), None) => TendonPath::Spatial(
            path.iter().map(path_element).collect::<Result<_, _>>().map_err(within("path"))?,
        ),
        (None, Some(terms)) => {
            TendonPath::Fixed(terms.iter().map(term).collect::<Result<_, _>>().map_err(within("joints"))?)
        }
        _ => return Err("expected either `path` or `joints`".to_string()),
    };
    let sheath = m.sheath.as_ref().map(|sheath| SheathGeometry {
        length: sheath.length_m.0,
        bend: sheath.bend_rad.0,
        end_axis: sheath.end_axis.map(|axis| axis.0),
    });
    Ok(Tendon {
        name: m.name.clone(),
        path,
        sheath,
        range: range(m.length_range_m),
        damping: number(m.damping_n_s_per_m),
        stiffness: number(m.stiffness_n_per_m),
        spring_length: range(m.spring_length_m),
    })
}

fn actuator(tendons: &Names, a: &w::Actuator) -> Result<Actuator, String> {
    let kind = ActuatorKind::from_word(&a.kind).ok_or_else(|| {
        let words = ActuatorKind::WORDS.map(|(_, word)| word).join(", ");
        format!("kind is `{}`: expected one of {words}", a.kind)
    })?;
    let known = mjcf::law(kind.word());
    for (key, value) in &a.law {
        if !known.contains(&key.as_str()) {
            return Err(format!("law: `{key}` is no attribute of MJCF's <{}>", kind.word()));
        }
        mjcf::finite(value).map_err(|problem| format!("law: `{key}` {problem}"))?;
    }
    Ok(Actuator {
        name: a.name.clone(),
        kind,
        tendon: tendons.find(&a.muscle).map_err(|problem| format!("muscle {problem}"))?,
        gear: a.gear.0,
        control_range: range(a.control_range),
        force_range: range(a.force_range_n),
        law: a.law.clone(),
    })
}
