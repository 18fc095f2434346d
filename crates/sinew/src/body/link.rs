//! Rigid links of the tree, their inertia, and frames fixed to them.

use super::parts::JointKind;
use super::vector::{
    Frame, IDENTITY, Vector, add, compose, point_inertia, rotate, rotate_symmetric, scale, sub,
};
use crate::lanes::{self, Row};

/// A rigid body that moves by one joint relative to its parent. The origin of its frame is the joint's
/// anchor; the z axis of a hinge's or slide's frame is the joint's axis, so that the joint is a rotation
/// about z or a translation along it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Link {
    /// The parent link; 0 is the ground.
    pub(crate) parent: usize,
    /// Kind of the joint.
    pub(crate) kind: JointKind,
    /// Index of the joint.
    pub(crate) joint: usize,
    /// Index of its first coordinate.
    pub(crate) q: usize,
    /// Index of its first velocity.
    pub(crate) v: usize,
    /// Axes of its frame in the parent's, joint at its reference.
    pub(crate) axes: Frame,
    /// Origin of its frame in the parent's, joint at its reference.
    pub(crate) origin: Vector,
    /// Coordinate at which the joint is at its reference.
    pub(crate) reference: f64,
    /// Inertia of the rotor seen at each of its velocities.
    pub(crate) armature: f64,
    /// Sum over the bodies welded into it.
    pub(crate) inertia: Inertia,
    /// Sum over these bodies of the mass whose weight is held.
    pub(crate) held: Inertia,
}

/// Mass, mass times centre, and inertia about the origin of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Inertia {
    pub(crate) mass: f64,
    pub(crate) moment: Vector,
    pub(crate) about_origin: [f64; 6],
}

impl Link {
    /// Mass that gravity pulls at the joints, and its first moment.
    pub(crate) fn weighing(&self) -> (f64, Vector) {
        (self.inertia.mass - self.held.mass, sub(self.inertia.moment, self.held.moment))
    }
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
    pub(crate) fn new(mass: f64, center: Vector, central: &[f64; 6], place: &LinkFrame) -> Inertia {
        let center = add(place.origin, rotate(&place.axes, center));
        let mut about_origin = rotate_symmetric(&place.axes, central);
        for (entry, extra) in about_origin.iter_mut().zip(point_inertia(mass, center)) {
            *entry += extra;
        }
        Inertia { mass, moment: scale(mass, center), about_origin }
    }
}

/// The numbers of a link in several worlds, which differ in them alone.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct LinkRows<const N: usize> {
    pub(crate) axes: lanes::Frame<N>,
    pub(crate) origin: lanes::Vector<N>,
    pub(crate) reference: Row<N>,
    pub(super) armature: Row<N>,
    pub(super) mass: Row<N>,
    pub(super) moment: lanes::Vector<N>,
    pub(super) about_origin: [Row<N>; 6],
    /// Mass whose weight is held, and its first moment.
    pub(super) held: (Row<N>, lanes::Vector<N>),
}

impl<const N: usize> LinkRows<N> {
    /// Sets the numbers of world `k`.
    pub(crate) fn set(&mut self, k: usize, link: &Link) {
        self.axes.set(k, link.axes);
        self.origin.set(k, link.origin);
        self.moment.set(k, link.inertia.moment);
        (self.reference.0[k], self.armature.0[k]) = (link.reference, link.armature);
        self.mass.0[k] = link.inertia.mass;
        self.held.0.0[k] = link.held.mass;
        self.held.1.set(k, link.held.moment);
        for (row, entry) in self.about_origin.iter_mut().zip(link.inertia.about_origin) {
            row.0[k] = entry;
        }
    }
}

impl From<&Link> for LinkRows<1> {
    fn from(link: &Link) -> Self {
        let mut rows = Self::default();
        rows.set(0, link);
        rows
    }
}

/// A frame fixed to a link.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LinkFrame {
    pub(crate) link: usize,
    pub(crate) axes: Frame,
    pub(crate) origin: Vector,
}

impl LinkFrame {
    pub(crate) const WORLD: LinkFrame = LinkFrame { link: 0, axes: IDENTITY, origin: [0.0; 3] };

    /// A frame given in this one.
    pub(crate) fn inner(&self, position: Vector, axes: &Frame) -> LinkFrame {
        LinkFrame {
            link: self.link,
            axes: compose(&self.axes, axes),
            origin: add(self.origin, rotate(&self.axes, position)),
        }
    }
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
