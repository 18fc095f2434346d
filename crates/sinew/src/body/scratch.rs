use super::link::Inertia;
use super::link_state::{ArticulatedBody, LinkMotion, LinkState, Wrench};
use super::lumped::Axes;
use super::robot::Robot;
use alloc::vec;
use alloc::vec::Vec;

/// Preallocated working memory of the dynamics of one robot. It holds no results.
#[derive(Debug, Clone, PartialEq)]
pub struct Scratch {
    pub(super) links: Vec<LinkState>,
    /// Axes in the parents' frames.
    pub(super) turned: Vec<Axes>,
    /// Motion of links with children other than the next link.
    pub(super) motions: Vec<LinkMotion>,
    pub(super) wrenches: Vec<Wrench>,
    pub(super) composite: Vec<Inertia>,
    pub(super) articulated: Vec<ArticulatedBody>,
    /// Zeros, one for each velocity.
    pub(super) rest: Vec<f64>,
    /// Per velocity: generalised force minus bias, and articulated inertia along the joint axis.
    pub(super) pivots: Vec<[f64; 2]>,
    /// Per velocity: articulated inertia times the joint axis, moment and force.
    pub(super) columns: Vec<[f64; 6]>,
}

impl Scratch {
    /// Working memory for one robot.
    #[must_use]
    pub fn new(robot: &Robot) -> Scratch {
        let (links, nv) = (robot.tree.links.len(), robot.nv());
        Scratch {
            links: vec![LinkState::default(); links],
            turned: vec![Axes::default(); links.div_ceil(4)],
            motions: vec![LinkMotion::default(); links],
            wrenches: vec![Wrench::default(); links],
            composite: vec![Inertia::default(); links],
            articulated: vec![ArticulatedBody::default(); links],
            rest: vec![0.0; nv],
            pivots: vec![[0.0; 2]; nv],
            columns: vec![[0.0; 6]; nv],
        }
    }
}
