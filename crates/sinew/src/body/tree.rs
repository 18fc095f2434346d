//! The kinematic tree: links with one joint each; bodies welded together are one link.

use super::link::{Inertia, Link, LinkFrame, LinkRows};
use super::lumped::{LinkChain, LinkQuad, LumpedLink, chains, lumped_links, quads};
use super::parts::{JointKind, Parts};
use super::vector::{IDENTITY, frame_about, frame_of, rotate, scale, transpose};
use alloc::vec;
use alloc::vec::Vec;

/// Links with the ground at 0, parents before children, and the frame of each body.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Tree {
    pub(crate) links: Vec<Link>,
    /// The same as forward kinematics and dynamics need them.
    pub(crate) rows: Vec<LinkRows<1>>,
    /// The same links as inverse dynamics needs them.
    pub(crate) lumped_links: Vec<LumpedLink>,
    pub(crate) quads: Vec<LinkQuad>,
    pub(crate) chains: Vec<LinkChain>,
    pub(crate) bodies: Vec<LinkFrame>,
    /// The link that each joint moves.
    pub(crate) link_of_joint: Vec<usize>,
    pub(crate) nq: usize,
    pub(crate) nv: usize,
}

impl Tree {
    /// Of valid parts.
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
            held: Inertia::default(),
        };
        let bodies = vec![LinkFrame::WORLD; parts.bodies.len()];
        let mut tree = Tree {
            links: vec![ground],
            rows: Vec::new(),
            lumped_links: Vec::new(),
            quads: Vec::new(),
            chains: Vec::new(),
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
            let inertia = Inertia::new(body.mass, body.center_of_mass, &body.inertia, &place);
            tree.links[place.link].inertia.add(&inertia);
            let held = body.gravity_compensation * body.mass;
            tree.links[place.link].held.add(&Inertia::new(held, body.center_of_mass, &[0.0; 6], &place));
        }
        (tree.lumped_links, tree.quads) = (lumped_links(&tree.links), quads(&tree.links));
        tree.chains = chains(&tree.links);
        tree.rows = tree.links.iter().map(LinkRows::from).collect();
        tree
    }

    /// Adds a link for one joint of the body with the frame `body`; returns that frame on the new link.
    fn push(&mut self, parts: &Parts, index: usize, body: &LinkFrame) -> LinkFrame {
        let joint = &parts.joints[index];
        let free = joint.kind == JointKind::Free;
        let axes = match joint.kind {
            JointKind::Hinge | JointKind::Slide => frame_about(joint.axis),
            JointKind::Ball | JointKind::Free => IDENTITY,
        };
        let anchor = if free { [0.0; 3] } else { joint.anchor };
        let start = if free { LinkFrame::WORLD } else { body.inner(anchor, &axes) };
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
            held: Inertia::default(),
        });
        self.nq += joint.kind.coordinates();
        self.nv += joint.kind.velocities();
        let link = self.links.len() - 1;
        self.link_of_joint.push(link);
        let axes = transpose(&axes);
        LinkFrame { link, axes, origin: scale(-1.0, rotate(&axes, anchor)) }
    }
}
