//! State of an import: frames, bodies and coordinates by name, parts and warnings so far.

use super::function::Function;
use crate::body::{Body, Coupling, Joint, JointKind, Key, Parts, Robot};
use crate::description::attributes::Attributes;
use crate::description::error::{DescriptionError, Warning};
use crate::description::mjcf::{HERE, Place};
use crate::description::orientation::{IDENTITY, euler, rotate};
use crate::description::origin::Origins;
use crate::description::tree::Tree;
use alloc::collections::{BTreeMap, BTreeSet};
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;

/// A coordinate of a joint of the file.
#[derive(Debug, Clone, Copy)]
pub(super) struct Coordinate {
    pub(super) element: usize,
    /// The joint that it is; `None`: constant.
    pub(super) joint: Option<usize>,
    pub(super) value: f64,
    pub(super) range: Option<[f64; 2]>,
    pub(super) locked: bool,
}

/// A frame with an offset from another, and what it belongs to.
#[derive(Debug, Clone, Copy)]
struct Offset<'a> {
    element: usize,
    owner: &'a str,
}

/// A joint that follows a function of a coordinate, and the element that says so.
struct Tie<'a> {
    follower: usize,
    element: usize,
    coordinate: &'a str,
    function: Function,
}

/// What has been read of a file so far.
pub(super) struct Model<'a> {
    pub(super) tree: &'a Tree,
    pub(super) element: usize,
    pub(super) parts: Parts,
    pub(super) warnings: Vec<Warning>,
    pub(super) origins: Origins,
    /// Elements of the bodies and of the ground.
    pub(super) bodies: BTreeMap<&'a str, usize>,
    /// Indices of bodies that stand in the tree.
    pub(super) placed: BTreeMap<&'a str, usize>,
    pub(super) coordinates: BTreeMap<&'a str, Coordinate>,
    offsets: BTreeMap<&'a str, Vec<Offset<'a>>>,
    warned: BTreeSet<String>,
    /// Joints that follow coordinates.
    ties: Vec<Tie<'a>>,
}

/// Last name of a path to a component, and the one before it.
fn ends(path: &str) -> (&str, Option<&str>) {
    let mut names = path.rsplit('/');
    (names.next().unwrap_or_default(), names.next().filter(|name| !name.is_empty()))
}

pub(super) fn child<'a>(tree: &'a Tree, element: usize, name: &str) -> Option<Attributes<'a>> {
    let found = tree.elements[element].children.iter().copied().find(|&e| tree.elements[e].name == name);
    found.map(|element| Attributes::own(tree, element))
}

/// The objects of a set, or of a list, within an element.
pub(super) fn objects<'a>(tree: &'a Tree, element: usize, set: &str) -> Vec<Attributes<'a>> {
    let Some(set) = child(tree, element, set) else { return Vec::new() };
    let list = child(tree, set.element, "objects").unwrap_or(set);
    let children = &tree.elements[list.element].children;
    let objects = children.iter().filter(|&&object| tree.elements[object].attribute("name").is_some());
    objects.map(|&object| Attributes::own(tree, object)).collect()
}

/// The frame that an element's translation and rotation describe.
pub(super) fn place(at: Attributes<'_>, rotation: &str) -> Result<Place, DescriptionError> {
    let angles = at.array_or(rotation, [0.0; 3])?;
    let turned = angles.iter().any(|angle| *angle != 0.0);
    let orientation = if turned { euler(angles, *b"xyz") } else { IDENTITY };
    Ok(Place { position: at.array_or("translation", [0.0; 3])?, orientation })
}

/// The place of a point in the body of its frame.
pub(super) fn place_on(frame: Place, at: Attributes<'_>) -> Result<[f64; 3], DescriptionError> {
    let location = at.array("location")?.ok_or_else(|| at.error("location", "is missing"))?;
    Ok(frame.point(location))
}

/// The outer frame in the inner one.
pub(super) fn inverse(place: Place) -> Place {
    let orientation = conjugate(place.orientation);
    Place { position: rotate(orientation, place.position).map(|x| -x), orientation }
}

pub(super) fn conjugate([w, x, y, z]: [f64; 4]) -> [f64; 4] {
    [w, -x, -y, -z]
}

pub(super) fn still(name: &str, parent: usize, place: Place) -> Body {
    Body {
        name: name.to_string(),
        parent,
        position: place.position,
        orientation: place.orientation,
        mass: 0.0,
        center_of_mass: [0.0; 3],
        inertia: [0.0; 6],
        gravity_compensation: 0.0,
    }
}

impl<'a> Model<'a> {
    /// Gravity, and every body, frame and coordinate by name.
    pub(super) fn new(tree: &'a Tree, at: Attributes<'a>, file: &str) -> Result<Model<'a>, DescriptionError> {
        let parts = Parts {
            name: at.text("name").unwrap_or_default().to_string(),
            gravity: at.array_or("gravity", [0.0, -9.80665, 0.0])?,
            bodies: Vec::from([still("world", 0, HERE)]),
            ..Parts::default()
        };
        let mut model = Model {
            tree,
            element: at.element,
            parts,
            warnings: Vec::new(),
            origins: Origins::new(file),
            bodies: BTreeMap::new(),
            placed: BTreeMap::from([("ground", 0)]),
            coordinates: BTreeMap::new(),
            offsets: BTreeMap::new(),
            warned: BTreeSet::new(),
            ties: Vec::new(),
        };
        let ground = child(tree, at.element, "Ground");
        for body in ground.into_iter().chain(objects(tree, at.element, "BodySet")) {
            let name =
                if tree.elements[body.element].name == "Ground" { "ground" } else { body.required("name")? };
            if model.bodies.insert(name, body.element).is_some() {
                return Err(body.error("name", "is taken already by another body"));
            }
            model.list_offsets(body, "components", name)?;
        }
        for joint in objects(tree, at.element, "JointSet") {
            let name = joint.required("name")?;
            model.list_offsets(joint, "frames", name)?;
            for coordinate in objects(tree, joint.element, "coordinates") {
                model.list_coordinate(coordinate)?;
            }
        }
        model.list_offsets(at, "components", "")?;
        model.list_offsets(at, "ComponentSet", "")?;
        Ok(model)
    }

    fn list_offsets(
        &mut self,
        at: Attributes<'a>,
        list: &str,
        owner: &'a str,
    ) -> Result<(), DescriptionError> {
        for frame in objects(self.tree, at.element, list) {
            if self.tree.elements[frame.element].name == "PhysicalOffsetFrame" {
                let offset = Offset { element: frame.element, owner };
                self.offsets.entry(frame.required("name")?).or_default().push(offset);
            }
        }
        Ok(())
    }

    fn list_coordinate(&mut self, at: Attributes<'a>) -> Result<(), DescriptionError> {
        let range = at.array("range")?;
        if let Some([low, high]) = range
            && low > high
        {
            let problem = format!("is {low} {high}: expected a low end not above the high end");
            return Err(at.error("range", problem));
        }
        if at.flag("prescribed", false)? {
            let what = "`prescribed` of a <Coordinate> is not read: the coordinate is free here";
            self.left_out(at.element, "prescribed", what, true);
        }
        let value = at.number_or("default_value", 0.0)?;
        let locked = at.flag("locked", false)?;
        let coordinate = Coordinate { element: at.element, joint: None, value, range, locked };
        if self.coordinates.insert(at.required("name")?, coordinate).is_some() {
            return Err(at.error("name", "is taken already by another coordinate"));
        }
        Ok(())
    }

    /// The coordinate that a path to it names.
    pub(super) fn coordinate(
        &self,
        at: Attributes<'_>,
        attribute: &str,
        path: &str,
    ) -> Result<(&'a str, Coordinate), DescriptionError> {
        let found = self.coordinates.get_key_value(ends(path).0);
        let found = found.map(|(name, coordinate)| (*name, *coordinate));
        found.ok_or_else(|| {
            at.error(attribute, format!("is `{path}`, but there is no coordinate of that name"))
        })
    }

    /// Name of the body that a socket's frame belongs to, and the frame in it; `owner` has frames of its own.
    pub(super) fn frame(
        &self,
        mut at: Attributes<'a>,
        mut socket: &str,
        mut owner: &'a str,
    ) -> Result<(&'a str, Place), DescriptionError> {
        let mut within = HERE;
        for _ in 0..=self.offsets.len() {
            let path = at.required(socket)?;
            let (name, before) = ends(path);
            let name = if name == ".." { owner } else { name };
            if let Some((body, _)) = self.bodies.get_key_value(name)
                && (name == owner || !self.offsets.contains_key(name))
            {
                return Ok((body, within));
            }
            let offsets = self.offsets.get(name).map_or(&[][..], Vec::as_slice);
            let of = |owner: &str| offsets.iter().find(|offset| offset.owner == owner);
            let mut found = before.filter(|name| *name != "..").and_then(of).or_else(|| of(owner));
            if let ([only], None) = (offsets, found) {
                found = Some(only);
            }
            let Some(Offset { element, owner: next }) = found else {
                let problem = format!("is `{path}`, but there is no one frame of that name");
                return Err(at.error(socket, problem));
            };
            (at, socket, owner) = (Attributes::own(self.tree, *element), "socket_parent", next);
            within = place(at, "orientation")?.of(within);
        }
        Err(at.error(socket, "leads in a circle: expected a frame that stands on a body"))
    }

    /// The same as the index of the body.
    pub(super) fn on_body(
        &self,
        at: Attributes<'a>,
        socket: &str,
    ) -> Result<(usize, Place), DescriptionError> {
        let (name, place) = self.frame(at, socket, "")?;
        let index = self.placed.get(name).copied();
        let missing = || at.error(socket, format!("is on the body `{name}`, which no joint holds"));
        Ok((index.ok_or_else(missing)?, place))
    }

    /// Adds a joint of a body; its index. Names that are taken get that of the body before them.
    pub(super) fn add_joint(
        &mut self,
        name: &str,
        body: usize,
        turn: bool,
        axis: [f64; 3],
        anchor: [f64; 3],
    ) -> usize {
        let taken = self.parts.joints.iter().any(|joint| joint.name == name);
        let name = if taken { format!("{}:{name}", self.parts.bodies[body].name) } else { name.to_string() };
        self.parts.joints.push(Joint {
            name,
            body,
            kind: if turn { JointKind::Hinge } else { JointKind::Slide },
            anchor,
            axis,
            reference: 0.0,
            range: None,
            armature: 0.0,
            damping: 0.0,
            friction: 0.0,
            stiffness: 0.0,
            spring_reference: 0.0,
            flex: 0.0,
        });
        self.parts.joints.len() - 1
    }

    /// Lets a joint follow a function of a coordinate, once all coordinates are known.
    pub(super) fn follow(
        &mut self,
        follower: usize,
        at: Attributes<'_>,
        coordinate: &'a str,
        function: Function,
    ) {
        self.ties.push(Tie { follower, element: at.element, coordinate, function });
    }

    /// Makes couplings of all that follows a coordinate.
    pub(super) fn couple(&mut self) {
        for Tie { follower, element, coordinate, function } in core::mem::take(&mut self.ties) {
            let Coordinate { joint: leader, value, .. } = self.coordinates[coordinate];
            let Function { coefficients, pieces } =
                if leader.is_some() { function } else { Function::line(function.value(value), 0.0) };
            self.describe("coupling", self.parts.couplings.len(), element);
            self.parts.couplings.push(Coupling { follower, leader, coefficients, pieces });
        }
    }

    /// Records file and line of a part.
    pub(super) fn describe(&mut self, kind: &'static str, index: usize, element: usize) {
        let element = &self.tree.elements[element];
        self.origins.set(kind, index, &self.tree.files[element.file], element.line);
    }

    /// Warns once per kind of what is left out.
    pub(super) fn left_out(&mut self, element: usize, kind: &str, what: &str, changes_forces: bool) {
        if self.warned.insert(kind.to_string()) {
            let at = &self.tree.elements[element];
            let (file, line, what) = (self.tree.files[at.file].clone(), at.line, what.to_string());
            self.warnings.push(Warning { file, line, what, changes_forces });
        }
    }

    /// Adds the pose of the file.
    pub(super) fn finish(&mut self) {
        let Ok(robot) = Robot::new(self.parts.clone()) else { return };
        let mut q = robot.reference_pose();
        for Coordinate { joint, value, .. } in self.coordinates.values() {
            if let Some(joint) = *joint {
                q[robot.coordinates_of(joint).start] = *value;
            }
        }
        if robot.apply_couplings(&mut q).is_ok() {
            self.parts.keys.push(Key { name: "default".to_string(), q });
        }
    }
}
