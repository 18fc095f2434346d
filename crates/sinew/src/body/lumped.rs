//! A robot as inverse dynamics needs it: what a hinge cannot feel of its own belongs to what carries it, and
//! hinges are turned four at a time.

use super::link::{Inertia, Link};
use super::parts::JointKind;
use super::vector::{Frame, IDENTITY, Vector, add, add_scaled, rotate, scale};
use crate::math::sincos_all;
use alloc::vec::Vec;

/// What is constant of a link.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Stage {
    /// Origin in the parent's frame, joint at its reference.
    pub(crate) origin: Vector,
    pub(crate) mass: f64,
    /// Mass times centre.
    pub(crate) moment: Vector,
    /// Second moments `xx, yy, zz, xy, xz, yz` of the mass: the integral of `r r^T`.
    pub(crate) second: [f64; 6],
    pub(crate) armature: f64,
}

impl Stage {
    fn new(link: &Link) -> Stage {
        let Inertia { mass, moment, about_origin: [xx, yy, zz, xy, xz, yz] } = link.inertia;
        let half = 0.5 * (xx + yy + zz);
        let second = [half - xx, half - yy, half - zz, -xy, -xz, -yz];
        Stage { origin: link.origin, mass, moment, second, armature: link.armature }
    }

    /// Takes over mass spread along a line through `origin` along `axis`: mass, first and second moment.
    fn take(&mut self, mass: f64, first: f64, second: f64, origin: Vector, axis: Vector) {
        self.mass += mass;
        self.moment = add(self.moment, add_scaled(scale(mass, origin), first, axis));
        for (entry, (i, j)) in self.second.iter_mut().zip([(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)]) {
            let mixed = axis[i] * origin[j] + origin[i] * axis[j];
            *entry += second * axis[i] * axis[j] + first * mixed + mass * origin[i] * origin[j];
        }
    }
}

/// One stage per link. Mass on a hinge's axis moves with the hinge's parent as well as with its child; all
/// that can be seen as lying there goes to the parent, so that a hinge's link keeps neither mass nor
/// moments along its axis. Forces of inverse dynamics stay the same, and take less to find.
pub(crate) fn stages(links: &[Link]) -> Vec<Stage> {
    let mut stages: Vec<Stage> = links.iter().map(Stage::new).collect();
    for (index, link) in links.iter().enumerate().skip(1).rev() {
        if link.kind == JointKind::Hinge {
            let own = &mut stages[index];
            let (mass, first, second) = (own.mass, own.moment[2], own.second[2]);
            (own.mass, own.moment[2], own.second[2]) = (0.0, 0.0, 0.0);
            let axis = rotate(&link.axes, IDENTITY[2]);
            stages[link.parent].take(mass, first, second, link.origin, axis);
        }
    }
    stages
}

/// Links that stand one on the other: hinges, or a single link of another kind. Only the last may carry more.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Run {
    /// What the first stands on.
    pub(crate) parent: usize,
    pub(crate) first: usize,
    pub(crate) last: usize,
    /// First of the velocities; those of hinges follow each other.
    pub(crate) v: usize,
    pub(crate) hinges: bool,
    /// Whether something stands on the last.
    pub(crate) carries: bool,
}

/// All links but the ground, parents before children.
pub(crate) fn runs(links: &[Link]) -> Vec<Run> {
    let mut forks = alloc::vec![false; links.len()];
    for (index, link) in links.iter().enumerate().skip(1) {
        forks[link.parent] |= link.parent + 1 != index;
    }
    let mut runs: Vec<Run> = Vec::new();
    for (index, link) in links.iter().enumerate().skip(1) {
        let hinges = link.kind == JointKind::Hinge;
        match runs.last_mut() {
            Some(run) if run.hinges && hinges && run.last == link.parent && !forks[link.parent] => {
                run.last = index;
            }
            _ => runs.push(Run {
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
    for run in &runs {
        carrying[run.parent] = true;
    }
    for run in &mut runs {
        run.carries = carrying[run.last];
    }
    runs
}

/// Axes of four links in their parents' frames, entry by entry.
pub(crate) type Axes = [[[f64; 4]; 3]; 3];

/// Four links side by side, joints at their references, and how they turn: by `share q - reference` about their z.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Four {
    axes: Axes,
    q: [usize; 4],
    /// 1 for hinges; what else there is does not turn.
    share: [f64; 4],
    reference: [f64; 4],
}

/// All links, the ground first.
pub(crate) fn fours(links: &[Link]) -> Vec<Four> {
    let mut fours = alloc::vec![Four::default(); links.len().div_ceil(4)];
    for (index, link) in links.iter().enumerate() {
        let (four, lane) = (&mut fours[index / 4], index % 4);
        if link.kind == JointKind::Hinge {
            (four.q[lane], four.share[lane], four.reference[lane]) = (link.q, 1.0, link.reference);
        }
        set_axes(&mut four.axes, lane, &link.axes);
    }
    fours
}

/// The axes of one of four.
#[inline(always)]
pub(crate) fn axes_of([x, y, z]: &Axes, lane: usize) -> Frame {
    [
        [x[0][lane], x[1][lane], x[2][lane]],
        [y[0][lane], y[1][lane], y[2][lane]],
        [z[0][lane], z[1][lane], z[2][lane]],
    ]
}

pub(crate) fn set_axes(four: &mut Axes, lane: usize, axes: &Frame) {
    for (rows, axis) in four.iter_mut().zip(axes) {
        for (row, entry) in rows.iter_mut().zip(axis) {
            row[lane] = *entry;
        }
    }
}

impl Four {
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
        self.share[lane] * q[self.q[lane]] - self.reference[lane]
    }
}
