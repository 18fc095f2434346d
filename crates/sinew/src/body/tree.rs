//! What is left of a robot for mechanics: links, one joint each; what is welded together is one link.

use super::lumped::{Four, Run, Stage, fours, runs, stages};
use super::parts::{JointKind, Parts};
use super::vector::{
    Frame, IDENTITY, Vector, add, compose, frame_about, frame_of, point_inertia, rotate, rotate_symmetric,
    scale, transpose,
};
use alloc::vec;
use alloc::vec::Vec;

/// A rigid body that moves by one joint against its parent. Its frame stands in the joint's anchor; the z of
/// a hinge's or slide's frame is the joint's axis, so that one joint is a turn about z or a shift along it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Link {
    /// The link it moves against; 0 is the ground.
    pub(crate) parent: usize,
    /// How it moves.
    pub(crate) kind: JointKind,
    /// The joint in the list of joints.
    pub(crate) joint: usize,
    /// First of its coordinates.
    pub(crate) q: usize,
    /// First of its velocities.
    pub(crate) v: usize,
    /// Axes of its frame in the parent's, joint at its reference.
    pub(crate) axes: Frame,
    /// Origin of its frame in the parent's, joint at its reference.
    pub(crate) origin: Vector,
    /// Coordinate where the joint moves nothing.
    pub(crate) reference: f64,
    /// Inertia of the rotor seen at each of its velocities.
    pub(crate) armature: f64,
    /// What is welded together in it.
    pub(crate) inertia: Inertia,
}

/// Mass, mass times centre, and inertia about the origin of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Inertia {
    pub(crate) mass: f64,
    pub(crate) moment: Vector,
    pub(crate) about_origin: [f64; 6],
}

impl Inertia {
    pub(crate) fn add(&mut self, other: &Inertia) {
        self.mass += other.mass;
        self.moment = add(self.moment, other.moment);
        for (mine, theirs) in self.about_origin.iter_mut().zip(other.about_origin) {
            *mine += theirs;
        }
    }

    /// Of a body with its centre of mass at `center` and `central` about it, both in a frame at `origin`.
    fn of(mass: f64, center: Vector, central: &[f64; 6], place: &Place) -> Inertia {
        let center = add(place.origin, rotate(&place.axes, center));
        let mut about_origin = rotate_symmetric(&place.axes, central);
        for (entry, extra) in about_origin.iter_mut().zip(point_inertia(mass, center)) {
            *entry += extra;
        }
        Inertia { mass, moment: scale(mass, center), about_origin }
    }
}

/// Where a frame stands: on which link, and how.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Place {
    pub(crate) link: usize,
    pub(crate) axes: Frame,
    pub(crate) origin: Vector,
}

impl Place {
    const WORLD: Place = Place { link: 0, axes: IDENTITY, origin: [0.0; 3] };

    /// A frame given in this one.
    pub(crate) fn inner(&self, position: Vector, axes: &Frame) -> Place {
        Place {
            link: self.link,
            axes: compose(&self.axes, axes),
            origin: add(self.origin, rotate(&self.axes, position)),
        }
    }
}

/// Links with the ground at 0, parents before children, and where each body's frame stands.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Tree {
    pub(crate) links: Vec<Link>,
    /// The same links as inverse dynamics sees them.
    pub(crate) stages: Vec<Stage>,
    pub(crate) fours: Vec<Four>,
    pub(crate) runs: Vec<Run>,
    pub(crate) bodies: Vec<Place>,
    /// The link that each joint moves.
    pub(crate) link_of_joint: Vec<usize>,
    pub(crate) nq: usize,
    pub(crate) nv: usize,
}

impl JointKind {
    /// How many coordinates.
    #[must_use]
    pub fn coordinates(self) -> usize {
        match self {
            JointKind::Hinge | JointKind::Slide => 1,
            JointKind::Ball => 4,
            JointKind::Free => 7,
        }
    }

    /// How many velocities.
    #[must_use]
    pub fn velocities(self) -> usize {
        match self {
            JointKind::Hinge | JointKind::Slide => 1,
            JointKind::Ball => 3,
            JointKind::Free => 6,
        }
    }
}

impl Tree {
    /// Of parts already found valid.
    pub(crate) fn new(parts: &Parts) -> Tree {
        let ground = Link {
            parent: 0,
            kind: JointKind::Free,
            joint: usize::MAX,
            q: 0,
            v: 0,
            axes: IDENTITY,
            origin: [0.0; 3],
            reference: 0.0,
            armature: 0.0,
            inertia: Inertia::default(),
        };
        let bodies = vec![Place::WORLD; parts.bodies.len()];
        let mut tree = Tree {
            links: vec![ground],
            stages: Vec::new(),
            fours: Vec::new(),
            runs: Vec::new(),
            bodies,
            link_of_joint: Vec::new(),
            nq: 0,
            nv: 0,
        };
        let mut joint = 0;
        for (index, body) in parts.bodies.iter().enumerate().skip(1) {
            let parent = tree.bodies[body.parent];
            let mut place = parent.inner(body.position, &frame_of(body.orientation));
            while parts.joints.get(joint).is_some_and(|next| next.body == index) {
                place = tree.push(parts, joint, &place);
                joint += 1;
            }
            tree.bodies[index] = place;
            let inertia = Inertia::of(body.mass, body.center_of_mass, &body.inertia, &place);
            tree.links[place.link].inertia.add(&inertia);
        }
        (tree.stages, tree.fours) = (stages(&tree.links), fours(&tree.links));
        tree.runs = runs(&tree.links);
        tree
    }

    /// A link for one joint of a body whose frame stands at `body`; where that frame stands afterwards.
    fn push(&mut self, parts: &Parts, index: usize, body: &Place) -> Place {
        let joint = &parts.joints[index];
        let free = joint.kind == JointKind::Free;
        let axes = match joint.kind {
            JointKind::Hinge | JointKind::Slide => frame_about(joint.axis),
            JointKind::Ball | JointKind::Free => IDENTITY,
        };
        let anchor = if free { [0.0; 3] } else { joint.anchor };
        let start = if free { Place::WORLD } else { body.inner(anchor, &axes) };
        self.links.push(Link {
            parent: start.link,
            kind: joint.kind,
            joint: index,
            q: self.nq,
            v: self.nv,
            axes: start.axes,
            origin: start.origin,
            reference: joint.reference,
            armature: joint.armature,
            inertia: Inertia::default(),
        });
        self.nq += joint.kind.coordinates();
        self.nv += joint.kind.velocities();
        let link = self.links.len() - 1;
        self.link_of_joint.push(link);
        let axes = transpose(&axes);
        Place { link, axes, origin: scale(-1.0, rotate(&axes, anchor)) }
    }
}
