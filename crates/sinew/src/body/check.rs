//! Validation of a description: numbers finite and physical, indices in range, names unique.

use super::part_error::PartError;
use super::parts::{Actuator, Coupling, Joint, JointKind, Parts, PathElement, Tendon, TendonPath};
use super::symmetric;
use alloc::collections::BTreeSet;
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec;
use alloc::vec::Vec;

/// Largest magnitude of a number of a robot, in SI units: squares and products of such numbers are still
/// finite.
const LARGEST: f64 = 1e12;
const AT_MOST_LARGEST: &str = "a number of magnitude up to 1e12";
/// Deviation from unit length that counts as rounding.
const UNIT_TOLERANCE: f64 = 1e-3;

/// Identity of a part, for errors.
struct Part<'a> {
    kind: &'static str,
    index: usize,
    name: &'a str,
}

impl Part<'_> {
    #[expect(clippy::needless_pass_by_value, reason = "literals, numbers and fresh text come alike")]
    fn invalid(&self, field: &'static str, expected: impl ToString, got: impl ToString) -> PartError {
        PartError {
            kind: self.kind,
            index: self.index,
            name: self.name.to_string(),
            field,
            expected: expected.to_string(),
            got: got.to_string(),
        }
    }

    fn finite(&self, field: &'static str, values: &[f64]) -> Result<(), PartError> {
        match values.iter().find(|value| !value.is_finite() || value.abs() > LARGEST) {
            Some(value) if !value.is_finite() => Err(self.invalid(field, "finite", value)),
            Some(value) => Err(self.invalid(field, AT_MOST_LARGEST, format!("{value:e}"))),
            None => Ok(()),
        }
    }

    fn not_negative(&self, field: &'static str, value: f64) -> Result<(), PartError> {
        if value.is_finite() && value >= 0.0 {
            return self.finite(field, &[value]);
        }
        Err(self.invalid(field, "a finite number >= 0", value))
    }

    fn positive(&self, field: &'static str, value: f64) -> Result<(), PartError> {
        if value.is_finite() && value > 0.0 {
            return self.finite(field, &[value]);
        }
        Err(self.invalid(field, "a finite number > 0", value))
    }

    fn below(&self, field: &'static str, index: usize, count: usize) -> Result<(), PartError> {
        if index < count {
            return Ok(());
        }
        Err(self.invalid(field, format!("below {count}, the length of its list"), index))
    }

    /// Normalises a direction or orientation that is unit within the tolerance.
    fn unit(&self, field: &'static str, vector: &mut [f64]) -> Result<(), PartError> {
        self.finite(field, vector)?;
        let length = libm::sqrt(vector.iter().map(|x| x * x).sum());
        if (length - 1.0).abs() > UNIT_TOLERANCE {
            return Err(self.invalid(field, "of unit length", format!("{vector:?}, of length {length}")));
        }
        if (length - 1.0).abs() > f64::EPSILON {
            vector.iter_mut().for_each(|x| *x /= length);
        }
        Ok(())
    }

    fn range(&self, field: &'static str, range: Option<[f64; 2]>) -> Result<(), PartError> {
        let Some([low, high]) = range else { return Ok(()) };
        // NaN fails this; one-sided limits are infinite.
        if low <= high {
            let ends = [low, high].map(|end| if end.is_finite() { end } else { 0.0 });
            return self.finite(field, &ends);
        }
        Err(self.invalid(field, "a low end not above the high end", format!("[{low}, {high}]")))
    }
}

/// Returns the first error; normalises directions.
pub(super) fn check(parts: &mut Parts) -> Result<(), PartError> {
    let robot = Part { kind: "robot", index: 0, name: &parts.name };
    robot.finite("gravity", &parts.gravity)?;
    if parts.bodies.is_empty() {
        return Err(robot.invalid("its list of bodies", "at least the world", "empty"));
    }
    names(parts)?;
    bodies(parts)?;
    joints(parts)?;
    surfaces(parts)?;
    active(parts)?;
    let (sites, wraps, joints) = (parts.sites.len(), parts.wraps.len(), &parts.joints);
    for (kind, tendons) in [("tendon", &mut parts.tendons), ("spring", &mut parts.springs)] {
        for (index, tendon) in tendons.iter_mut().enumerate() {
            check_tendon((kind, index), tendon, sites, wraps, joints)?;
        }
    }
    couplings(parts)?;
    actuators(parts)?;
    keys(parts)
}

fn names(parts: &Parts) -> Result<(), PartError> {
    /// Characters that every format can hold: XML has neither control characters nor these two.
    fn printable(c: char) -> bool {
        !c.is_control() && !matches!(c, '\u{fffe}' | '\u{ffff}')
    }
    fn once<'a>(kind: &'static str, names: impl Iterator<Item = &'a String>) -> Result<(), PartError> {
        let mut seen = BTreeSet::new();
        for (index, name) in names.enumerate() {
            if !name.chars().all(printable) {
                let expected = "printable, as it must be in every file";
                return Err(Part { kind, index, name }.invalid("its name", expected, format!("{name:?}")));
            }
            if !name.is_empty() && !seen.insert(name) {
                return Err(Part { kind, index, name }.invalid("its name", "its own", "taken already"));
            }
        }
        Ok(())
    }
    once("robot", core::iter::once(&parts.name))?;
    once("body", parts.bodies.iter().map(|part| &part.name))?;
    once("joint", parts.joints.iter().map(|part| &part.name))?;
    once("site", parts.sites.iter().map(|part| &part.name))?;
    once("wrap", parts.wraps.iter().map(|part| &part.name))?;
    once("tendon", parts.tendons.iter().chain(&parts.springs).map(|part| &part.name))?;
    once("actuator", parts.actuators.iter().map(|part| &part.name))?;
    once("key", parts.keys.iter().map(|part| &part.name))
}

fn bodies(parts: &mut Parts) -> Result<(), PartError> {
    for (index, body) in parts.bodies.iter_mut().enumerate() {
        let part = Part { kind: "body", index, name: &body.name };
        if index > 0 && body.parent >= index || index == 0 && body.parent != 0 {
            return Err(part.invalid("its parent", "a body before it", body.parent));
        }
        part.finite("its position", &body.position)?;
        part.unit("its orientation", &mut body.orientation)?;
        part.not_negative("its mass", body.mass)?;
        part.finite("its gravity compensation", &[body.gravity_compensation])?;
        part.finite("its center of mass", &body.center_of_mass)?;
        part.finite("its inertia", &body.inertia)?;
        physical(&part, &body.inertia)?;
    }
    Ok(())
}

/// No distribution of mass has a principal moment above the sum of the two others, or below zero.
fn physical(part: &Part, inertia: &[f64; 6]) -> Result<(), PartError> {
    let [a, b, c] = principal_moments(inertia);
    let slack = 1e-8 * (a.abs() + b.abs() + c.abs());
    let shown = format!("[{a}, {b}, {c}]");
    if a < -slack {
        return Err(part.invalid("its inertia", "without negative principal moments", shown));
    }
    if a + b < c - slack {
        let expected = "physical (no principal moment above the sum of the two others)";
        return Err(part.invalid("its inertia", expected, shown));
    }
    Ok(())
}

/// Eigenvalues in rising order.
fn principal_moments(inertia: &[f64; 6]) -> [f64; 3] {
    let [xx, yy, zz, xy, xz, yz] = *inertia;
    let mut matrix = [xx, xy, xz, xy, yy, yz, xz, yz, zz];
    symmetric::eigen(&mut matrix, &mut [0.0; 9], 3);
    let mut moments = [matrix[0], matrix[4], matrix[8]];
    moments.sort_by(f64::total_cmp);
    moments
}

fn joints(parts: &mut Parts) -> Result<(), PartError> {
    let mut last = 0;
    let count = parts.bodies.len();
    for index in 0..parts.joints.len() {
        let (before, rest) = parts.joints.split_at_mut(index);
        let joint = &mut rest[0];
        let part = Part { kind: "joint", index, name: &joint.name };
        part.below("its body", joint.body, count)?;
        if joint.body == 0 || joint.body < last {
            return Err(part.invalid("its body", "one that moves, in the order of bodies", joint.body));
        }
        last = joint.body;
        if matches!(joint.kind, JointKind::Hinge | JointKind::Slide) {
            part.unit("its axis", &mut joint.axis)?;
        }
        part.finite("its anchor", &joint.anchor)?;
        part.finite("its reference", &[joint.reference, joint.spring_reference])?;
        part.finite("its flex", &[joint.flex])?;
        part.range("its range", joint.range)?;
        part.not_negative("its armature", joint.armature)?;
        part.not_negative("its damping", joint.damping)?;
        part.not_negative("its friction", joint.friction)?;
        part.not_negative("its stiffness", joint.stiffness)?;
        let parent = parts.bodies[joint.body].parent;
        together(&part, joint, before, parent)?;
    }
    Ok(())
}

/// Combinations of joints that may act on one body.
fn together(part: &Part, joint: &Joint, before: &[Joint], parent: usize) -> Result<(), PartError> {
    let mut others = before.iter().rev().take_while(|other| other.body == joint.body).map(|other| other.kind);
    let free = joint.kind == JointKind::Free;
    if free && parent != 0 {
        return Err(part.invalid(
            "its body",
            "a child of the world, as the joint is free",
            "deeper in the tree",
        ));
    }
    if others.clone().any(|other| free || other == JointKind::Free) {
        return Err(part.invalid("its body", "without another joint beside a free one", "with another"));
    }
    let turns = matches!(joint.kind, JointKind::Hinge | JointKind::Ball);
    if turns && others.any(|other| other == JointKind::Ball) {
        return Err(part.invalid("its body", "without another turn after a ball", "with one"));
    }
    Ok(())
}

fn surfaces(parts: &mut Parts) -> Result<(), PartError> {
    let bodies = parts.bodies.len();
    for (index, site) in parts.sites.iter_mut().enumerate() {
        let part = Part { kind: "site", index, name: &site.name };
        part.below("its body", site.body, bodies)?;
        part.finite("its position", &site.position)?;
        part.unit("its orientation", &mut site.orientation)?;
    }
    for (index, wrap) in parts.wraps.iter_mut().enumerate() {
        let part = Part { kind: "wrap", index, name: &wrap.name };
        part.below("its body", wrap.body, bodies)?;
        part.positive("its radius", wrap.radius)?;
        part.finite("its position", &wrap.position)?;
        part.unit("its orientation", &mut wrap.orientation)?;
    }
    for (index, geom) in parts.geoms.iter_mut().enumerate() {
        let part = Part { kind: "geom", index, name: "" };
        part.below("its body", geom.body, bodies)?;
        geom.size[..geom.kind.sizes()].iter().try_for_each(|size| part.positive("its size", *size))?;
        part.finite("its size", &geom.size)?;
        part.finite("its position", &geom.position)?;
        part.unit("its orientation", &mut geom.orientation)?;
    }
    for (index, mesh) in parts.meshes.iter_mut().enumerate() {
        let part = Part { kind: "mesh", index, name: &mesh.file };
        part.below("its body", mesh.body, bodies)?;
        part.finite("its scale", &mesh.scale)?;
        part.finite("its position", &mesh.position)?;
        part.finite("its reference position", &mesh.reference_position)?;
        part.unit("its orientation", &mut mesh.orientation)?;
        part.unit("its reference orientation", &mut mesh.reference_orientation)?;
    }
    Ok(())
}

/// Ranges in which paths pass through a site; the ends of a path are always on it.
fn active(parts: &Parts) -> Result<(), PartError> {
    for (index, site) in parts.sites.iter().enumerate() {
        let Some((joint, range)) = site.active else { continue };
        let part = Part { kind: "site", index, name: &site.name };
        part.below("the joint of its active range", joint, parts.joints.len())?;
        if !matches!(parts.joints[joint].kind, JointKind::Hinge | JointKind::Slide) {
            let name = &parts.joints[joint].name;
            return Err(part.invalid("the joint of its active range", "a hinge or a slide", name));
        }
        part.range("its active range", Some(range))?;
    }
    let passed = |element: &PathElement| match element {
        PathElement::Site(site) => parts.sites.get(*site).is_some_and(|site| site.active.is_some()),
        _ => false,
    };
    for (kind, tendons) in [("tendon", &parts.tendons), ("spring", &parts.springs)] {
        for (index, tendon) in tendons.iter().enumerate() {
            let TendonPath::Spatial(elements) = &tendon.path else { continue };
            let solid = |at: Option<&PathElement>| !at.is_some_and(|at| matches!(at, PathElement::Site(_)));
            let between = (0..elements.len()).filter(|&at| passed(&elements[at])).all(|at| {
                !solid(at.checked_sub(1).and_then(|before| elements.get(before)))
                    && !solid(elements.get(at + 1))
            });
            if !between {
                let expected =
                    "with a site before and behind every one with an active range, and no wrap beside it";
                return Err(Part { kind, index, name: &tendon.name }.invalid("its path", expected, "without"));
            }
        }
    }
    Ok(())
}

fn check_tendon(
    (kind, index): (&'static str, usize),
    tendon: &mut Tendon,
    sites: usize,
    wraps: usize,
    joints: &[Joint],
) -> Result<(), PartError> {
    let part = Part { kind, index, name: &tendon.name };
    match &tendon.path {
        TendonPath::Spatial(elements) => check_path(&part, elements, sites, wraps)?,
        TendonPath::Fixed(terms) => check_sum(&part, terms, joints)?,
    }
    if let Some(sheath) = &mut tendon.sheath {
        part.not_negative("the length of its sheath", sheath.length)?;
        part.not_negative("the bend of its sheath", sheath.bend)?;
        if let Some(axis) = &mut sheath.end_axis {
            part.unit("the end axis of its sheath", axis)?;
        }
    }
    part.range("its range", tendon.range)?;
    part.range("its spring length", tendon.spring_length)?;
    part.not_negative("its damping", tendon.damping)?;
    part.not_negative("its stiffness", tendon.stiffness)
}

fn check_path(part: &Part, elements: &[PathElement], sites: usize, wraps: usize) -> Result<(), PartError> {
    let field = "its path";
    for (at, element) in elements.iter().enumerate() {
        match *element {
            PathElement::Site(site) => part.below("a site of its path", site, sites)?,
            PathElement::Pulley(divisor) => part.positive("the divisor of its pulley", divisor)?,
            PathElement::Wrap { wrap, side } => {
                part.below("a wrap of its path", wrap, wraps)?;
                part.below("a side site of its path", side.unwrap_or(0), sites.max(1))?;
                let site = |at: Option<usize>| {
                    at.and_then(|at| elements.get(at)).is_some_and(|s| matches!(s, PathElement::Site(_)))
                };
                if !site(at.checked_sub(1)) || !site(at.checked_add(1)) {
                    let got = format!("not so at element {at}");
                    return Err(part.invalid(field, "with a site before and after every wrap", got));
                }
            }
        }
    }
    for branch in elements.split(|element| matches!(element, PathElement::Pulley(_))) {
        let count = branch.iter().filter(|element| matches!(element, PathElement::Site(_))).count();
        // A pulley may come first.
        let nothing = branch.is_empty() && matches!(elements.first(), Some(PathElement::Pulley(_)));
        if count < 2 && !nothing {
            let expected = "through at least two sites, in each branch of a tackle";
            return Err(part.invalid(field, expected, format!("through {count}")));
        }
    }
    if elements.is_empty() || elements.iter().all(|element| matches!(element, PathElement::Pulley(_))) {
        return Err(part.invalid(field, "through at least two sites", "through none"));
    }
    Ok(())
}

fn check_sum(part: &Part, terms: &[(usize, f64)], joints: &[Joint]) -> Result<(), PartError> {
    if terms.is_empty() {
        return Err(part.invalid("its path", "a sum of at least one joint", "empty"));
    }
    let mut seen = BTreeSet::new();
    for &(joint, coefficient) in terms {
        part.below("a joint of its path", joint, joints.len())?;
        part.finite("a coefficient of its path", &[coefficient])?;
        if !matches!(joints[joint].kind, JointKind::Hinge | JointKind::Slide) {
            return Err(part.invalid("a joint of its path", "a hinge or a slide", &joints[joint].name));
        }
        if !seen.insert(joint) {
            return Err(part.invalid("a joint of its path", "named once", &joints[joint].name));
        }
    }
    Ok(())
}

fn couplings(parts: &Parts) -> Result<(), PartError> {
    let mut leader_of: Vec<Option<usize>> = vec![None; parts.joints.len()];
    let mut follows = vec![false; parts.joints.len()];
    let joint = |index: usize, field: &'static str, which: usize| {
        let part = Part { kind: "coupling", index, name: "" };
        part.below(field, which, parts.joints.len())?;
        let joint = &parts.joints[which];
        if !matches!(joint.kind, JointKind::Hinge | JointKind::Slide) {
            return Err(part.invalid(
                field,
                "a hinge or a slide",
                format!("{:?} `{}`", joint.kind, joint.name),
            ));
        }
        Ok(part)
    };
    for (index, coupling) in parts.couplings.iter().enumerate() {
        let Coupling { follower, leader, coefficients, pieces } = coupling;
        let part = joint(index, "its follower", *follower)?;
        if let Some(leader) = *leader {
            joint(index, "its leader", leader)?;
            leader_of[*follower] = Some(leader);
        }
        part.finite("its coefficients", coefficients)?;
        part.finite("its pieces", pieces.as_flattened())?;
        if let Some(pair) = pieces.windows(2).find(|pair| pair[0][0] >= pair[1][0]) {
            let got = format!("{} before {}", pair[0][0], pair[1][0]);
            return Err(part.invalid("its pieces", "in rising order of their starts", got));
        }
        if core::mem::replace(&mut follows[*follower], true) {
            let name = &parts.joints[*follower].name;
            return Err(part.invalid(
                "its follower",
                "a joint that follows nothing else",
                format!("`{name}`"),
            ));
        }
    }
    circles(parts, &leader_of)
}

/// Couplings may be chained, but not in a circle.
fn circles(parts: &Parts, leader_of: &[Option<usize>]) -> Result<(), PartError> {
    // 0: not visited, 1: on the present chain, 2: known to end.
    let mut state = vec![0_u8; leader_of.len()];
    for (index, coupling) in parts.couplings.iter().enumerate() {
        let mut chain = Vec::new();
        let mut at = Some(coupling.follower);
        while let Some(joint) = at.filter(|&joint| state[joint] < 2) {
            if state[joint] == 1 {
                let part = Part { kind: "coupling", index, name: "" };
                let name = &parts.joints[joint].name;
                return Err(part.invalid("its leader", "independent of its follower", format!("`{name}`")));
            }
            state[joint] = 1;
            chain.push(joint);
            at = leader_of[joint];
        }
        chain.into_iter().for_each(|joint| state[joint] = 2);
    }
    Ok(())
}

fn actuators(parts: &Parts) -> Result<(), PartError> {
    for (index, actuator) in parts.actuators.iter().enumerate() {
        let part = Part { kind: "actuator", index, name: &actuator.name };
        part.below("its tendon", actuator.tendon, parts.tendons.len())?;
        part.finite("its gear", &[actuator.gear])?;
        part.range("its control range", actuator.control_range)?;
        part.range("its force range", actuator.force_range)?;
        law(&part, actuator)?;
    }
    Ok(())
}

/// Attributes must be representable in every file format.
fn law(part: &Part<'_>, actuator: &Actuator) -> Result<(), PartError> {
    for (name, value) in &actuator.law {
        if name.is_empty() || !name.bytes().all(|byte| byte.is_ascii_lowercase()) {
            return Err(part.invalid("a name in its law", "small letters", name));
        }
        if value.chars().any(char::is_control) {
            return Err(part.invalid("its law", "text without control characters", format!("{value:?}")));
        }
    }
    Ok(())
}

fn keys(parts: &mut Parts) -> Result<(), PartError> {
    let kinds: Vec<JointKind> = parts.joints.iter().map(|joint| joint.kind).collect();
    let nq: usize = kinds.iter().map(|kind| kind.coordinates()).sum();
    for (index, key) in parts.keys.iter_mut().enumerate() {
        let part = Part { kind: "key", index, name: &key.name };
        if key.q.len() != nq {
            return Err(part.invalid("its number of coordinates", nq, key.q.len()));
        }
        part.finite("its coordinates", &key.q)?;
        let mut at = 0;
        for kind in &kinds {
            let end = at + kind.coordinates();
            if matches!(kind, JointKind::Ball | JointKind::Free) {
                part.unit("a quaternion of its coordinates", &mut key.q[end - 4..end])?;
            }
            at = end;
        }
    }
    Ok(())
}
