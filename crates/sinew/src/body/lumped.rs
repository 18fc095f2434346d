//! Link data for inverse dynamics: inertia along hinge axes is lumped into the parent link (base parameters),
//! and joint rotations are evaluated four at a time.

use super::link::{Inertia, Link};
use super::parts::JointKind;
use super::vector::{Frame, IDENTITY, Vector, add, add_scaled, rotate, scale};
use crate::math::sincos_all;
use alloc::vec::Vec;

/// Constant data of a link.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LumpedLink {
    /// Origin in the parent's frame, joint at its reference.
    pub(crate) origin: Vector,
    pub(crate) mass: f64,
    /// Mass times centre.
    pub(crate) moment: Vector,
    /// Second moments `xx, yy, zz, xy, xz, yz` of the mass: the integral of `r r^T`.
    pub(crate) second: [f64; 6],
    pub(crate) armature: f64,
}

impl LumpedLink {
    fn new(link: &Link) -> LumpedLink {
        let Inertia { mass, moment, about_origin: [xx, yy, zz, xy, xz, yz] } = link.inertia;
        let half = 0.5 * (xx + yy + zz);
        let second = [half - xx, half - yy, half - zz, -xy, -xz, -yz];
        LumpedLink { origin: link.origin, mass, moment, second, armature: link.armature }
    }

    /// Adds mass distributed along a line through `origin` with direction `axis`: mass, first and second
    /// moment.
    fn add_line_mass(&mut self, mass: f64, first: f64, second: f64, origin: Vector, axis: Vector) {
        self.mass += mass;
        self.moment = add(self.moment, add_scaled(scale(mass, origin), first, axis));
        for (entry, (i, j)) in self.second.iter_mut().zip([(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)]) {
            let mixed = axis[i] * origin[j] + origin[i] * axis[j];
            *entry += second * axis[i] * axis[j] + first * mixed + mass * origin[i] * origin[j];
        }
    }
}

/// One entry per link. Mass on a hinge's axis has the same motion on the parent and on the link; the part of
/// the inertia that is equivalent to mass on the axis is moved to the parent, so that a hinge's link keeps
/// neither mass nor moments along its axis. The joint forces are unchanged and cost fewer operations.
pub(crate) fn lumped_links(links: &[Link]) -> Vec<LumpedLink> {
    let mut lumped_links: Vec<LumpedLink> = links.iter().map(LumpedLink::new).collect();
    for (index, link) in links.iter().enumerate().skip(1).rev() {
        if link.kind == JointKind::Hinge {
            let own = &mut lumped_links[index];
            let (mass, first, second) = (own.mass, own.moment[2], own.second[2]);
            (own.mass, own.moment[2], own.second[2]) = (0.0, 0.0, 0.0);
            let axis = rotate(&link.axes, IDENTITY[2]);
            lumped_links[link.parent].add_line_mass(mass, first, second, link.origin, axis);
        }
    }
    lumped_links
}

/// A serial chain of hinges, or a single link of another kind. Only its last link may have further children.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LinkChain {
    /// Parent of the first link.
    pub(crate) parent: usize,
    pub(crate) first: usize,
    pub(crate) last: usize,
    /// Index of the first velocity; those of hinges are consecutive.
    pub(crate) v: usize,
    pub(crate) hinges: bool,
    /// Whether the last link has children.
    pub(crate) carries: bool,
}

/// All links but the ground, parents before children.
pub(crate) fn chains(links: &[Link]) -> Vec<LinkChain> {
    let mut forks = alloc::vec![false; links.len()];
    for (index, link) in links.iter().enumerate().skip(1) {
        forks[link.parent] |= link.parent + 1 != index;
    }
    let mut chains: Vec<LinkChain> = Vec::new();
    for (index, link) in links.iter().enumerate().skip(1) {
        let hinges = link.kind == JointKind::Hinge;
        match chains.last_mut() {
            Some(chain) if chain.hinges && hinges && chain.last == link.parent && !forks[link.parent] => {
                chain.last = index;
            }
            _ => chains.push(LinkChain {
                parent: link.parent,
                first: index,
                last: index,
                v: link.v,
                hinges,
                carries: false,
            }),
        }
    }
    let mut carrying = alloc::vec![false; links.len()];
    for chain in &chains {
        carrying[chain.parent] = true;
    }
    for chain in &mut chains {
        chain.carries = carrying[chain.last];
    }
    chains
}

/// Axes of four links in their parents' frames, as a structure of arrays.
pub(crate) type Axes = [[[f64; 4]; 3]; 3];

/// Four links, joints at their references, and their rotation angles `fraction q - reference` about z.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct LinkQuad {
    axes: Axes,
    q: [usize; 4],
    /// 1 for hinges, 0 for other joints.
    fraction: [f64; 4],
    reference: [f64; 4],
}

/// All links, the ground first.
pub(crate) fn quads(links: &[Link]) -> Vec<LinkQuad> {
    let mut quads = alloc::vec![LinkQuad::default(); links.len().div_ceil(4)];
    for (index, link) in links.iter().enumerate() {
        let (quad, lane) = (&mut quads[index / 4], index % 4);
        if link.kind == JointKind::Hinge {
            (quad.q[lane], quad.fraction[lane], quad.reference[lane]) = (link.q, 1.0, link.reference);
        }
        set_axes(&mut quad.axes, lane, &link.axes);
    }
    quads
}

/// The axes of one lane.
#[inline(always)]
pub(crate) fn axes_of([x, y, z]: &Axes, lane: usize) -> Frame {
    [
        [x[0][lane], x[1][lane], x[2][lane]],
        [y[0][lane], y[1][lane], y[2][lane]],
        [z[0][lane], z[1][lane], z[2][lane]],
    ]
}

pub(crate) fn set_axes(quad: &mut Axes, lane: usize, axes: &Frame) {
    for (rows, axis) in quad.iter_mut().zip(axes) {
        for (row, entry) in rows.iter_mut().zip(axis) {
            row[lane] = *entry;
        }
    }
}

impl LinkQuad {
    /// The axes with hinges at `q`.
    #[inline(always)]
    pub(crate) fn turned(&self, q: &[f64], turned: &mut Axes) {
        let (mut sine, mut cosine) = ([0.0; 4], [0.0; 4]);
        let angle = [self.angle(q, 0), self.angle(q, 1), self.angle(q, 2), self.angle(q, 3)];
        sincos_all(&angle, &mut sine, &mut cosine);
        let ([x, y, z], [along, across, axis]) = (&self.axes, turned);
        for i in 0..3 {
            for lane in 0..4 {
                along[i][lane] = cosine[lane] * x[i][lane] + sine[lane] * y[i][lane];
                across[i][lane] = cosine[lane] * y[i][lane] - sine[lane] * x[i][lane];
            }
        }
        *axis = *z;
    }

    #[inline(always)]
    fn angle(&self, q: &[f64], lane: usize) -> f64 {
        self.fraction[lane] * q[self.q[lane]] - self.reference[lane]
    }
}
