//! Per-link intermediate results of the dynamics algorithms, in the link's own frame.

use super::vector::{Frame, Vector};
use crate::lanes::{self, Row};
use alloc::vec;
use alloc::vec::Vec;

/// Pose and velocity of one link in several worlds: pose in its parent's frame, velocities in its own.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct LinkState<const N: usize> {
    pub(super) axes: lanes::Frame<N>,
    pub(super) origin: lanes::Vector<N>,
    /// Angular velocity.
    pub(super) omega: lanes::Vector<N>,
    /// Velocity of the origin.
    pub(super) velocity: lanes::Vector<N>,
}

/// Motion of a link: a point at `r` has the acceleration `a + U r` relative to free fall.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct LinkMotion {
    /// Angular velocity.
    pub(super) omega: Vector,
    /// Angular acceleration.
    pub(super) alpha: Vector,
    /// Acceleration of the origin.
    pub(super) a: Vector,
    /// `U = [alpha] + [omega]^2`, row by row.
    pub(super) field: Frame,
}

/// Moment about the origin and force on a link, in its frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Wrench {
    pub(super) moment: Vector,
    pub(super) force: Vector,
}

/// Articulated-body inertia and bias wrench of a link and its subtree, at its origin: with angular
/// acceleration `alpha` and linear acceleration `a`, the moment is `angular alpha + coupling a + moment`, the
/// force `coupling^T alpha + linear a + force`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct ArticulatedBody<const N: usize> {
    pub(super) angular: lanes::Frame<N>,
    pub(super) coupling: lanes::Frame<N>,
    pub(super) linear: lanes::Frame<N>,
    pub(super) moment: lanes::Vector<N>,
    pub(super) force: lanes::Vector<N>,
    /// Velocity-product acceleration: angular and linear.
    pub(super) drift: [lanes::Vector<N>; 2],
    pub(super) acceleration: [lanes::Vector<N>; 2],
}

/// Working memory of forward dynamics in several worlds.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ForwardScratch<const N: usize> {
    pub(super) links: Vec<LinkState<N>>,
    pub(super) bodies: Vec<ArticulatedBody<N>>,
    /// Per velocity: generalised force minus bias, and articulated inertia along the joint axis.
    pub(super) pivots: Vec<[Row<N>; 2]>,
    /// Per velocity: articulated inertia times the joint axis, moment and force.
    pub(super) columns: Vec<[lanes::Vector<N>; 2]>,
}

impl<const N: usize> ForwardScratch<N> {
    pub(crate) fn new(links: usize, nv: usize) -> Self {
        Self {
            links: vec![LinkState::default(); links],
            bodies: vec![ArticulatedBody::default(); links],
            pivots: vec![Default::default(); nv],
            columns: vec![Default::default(); nv],
        }
    }
}
