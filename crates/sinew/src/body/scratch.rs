use super::link::Inertia;
use super::link_state::{ForwardScratch, LinkMotion, Wrench};
use super::lumped::Axes;
use super::robot::Robot;
use super::vector::{Frame, Vector};
use alloc::vec;
use alloc::vec::Vec;

/// Preallocated working memory of the dynamics of one robot. It holds no results.
#[derive(Debug, Clone, PartialEq)]
pub struct Scratch {
    /// Of forward dynamics and velocities.
    pub(super) forward: ForwardScratch<1>,
    /// Poses in the parents' frames.
    pub(super) places: Vec<(Frame, Vector)>,
    /// Axes in the parents' frames.
    pub(super) turned: Vec<Axes>,
    /// Motion of links with children other than the next link.
    pub(super) motions: Vec<LinkMotion>,
    pub(super) wrenches: Vec<Wrench>,
    pub(super) composite: Vec<Inertia>,
    /// Zeros, one for each velocity.
    pub(super) rest: Vec<f64>,
}

impl Scratch {
    /// Working memory for one robot.
    #[must_use]
    pub fn new(robot: &Robot) -> Scratch {
        let (links, nv) = (robot.tree.links.len(), robot.nv());
        Scratch {
            forward: ForwardScratch::new(links, nv),
            places: vec![Default::default(); links],
            turned: vec![Axes::default(); links.div_ceil(4)],
            motions: vec![LinkMotion::default(); links],
            wrenches: vec![Wrench::default(); links],
            composite: vec![Inertia::default(); links],
            rest: vec![0.0; nv],
        }
    }
}
