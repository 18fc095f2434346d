use super::forward_dynamics::Articulated;
use super::inverse_dynamics::{Motion, Wrench};
use super::lumped::Axes;
use super::robot::Robot;
use super::tree::Inertia;
use super::vector::{Frame, Vector};
use alloc::vec;
use alloc::vec::Vec;

/// Pose and velocity of one link: pose in its parent's frame, velocities in its own.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Moving {
    pub(super) axes: Frame,
    pub(super) origin: Vector,
    /// Angular velocity.
    pub(super) omega: Vector,
    /// Velocity of the origin.
    pub(super) velocity: Vector,
}

/// Room to work in, for one robot: the dynamics never allocate. Nothing in it is a result.
#[derive(Debug, Clone, PartialEq)]
pub struct Scratch {
    pub(super) links: Vec<Moving>,
    /// Axes in the parents' frames.
    pub(super) turned: Vec<Axes>,
    /// Of the links that others than the next one stand on.
    pub(super) motions: Vec<Motion>,
    pub(super) wrenches: Vec<Wrench>,
    pub(super) composite: Vec<Inertia>,
    pub(super) articulated: Vec<Articulated>,
    /// Zeros, one for each velocity.
    pub(super) rest: Vec<f64>,
    /// Per velocity: force left over and inertia felt.
    pub(super) pivots: Vec<[f64; 2]>,
    /// Per velocity: what the articulated body resists with.
    pub(super) columns: Vec<[f64; 6]>,
}

impl Scratch {
    /// For one robot.
    #[must_use]
    pub fn new(robot: &Robot) -> Scratch {
        let (links, nv) = (robot.tree.links.len(), robot.nv());
        Scratch {
            links: vec![Moving::default(); links],
            turned: vec![Axes::default(); links.div_ceil(4)],
            motions: vec![Motion::default(); links],
            wrenches: vec![Wrench::default(); links],
            composite: vec![Inertia::default(); links],
            articulated: vec![Articulated::default(); links],
            rest: vec![0.0; nv],
            pivots: vec![[0.0; 2]; nv],
            columns: vec![[0.0; 6]; nv],
        }
    }
}
