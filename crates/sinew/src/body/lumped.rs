//! Inertia as inverse dynamics needs it: what a hinge cannot feel of its own belongs to what carries it.

use super::parts::JointKind;
use super::tree::{Inertia, Link};
use super::vector::{Frame, IDENTITY, Vector, add, add_scaled, rotate, scale};
use alloc::vec::Vec;
use wide::f64x2;

/// What is constant of a link, laid out for two vectors at a time.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Stage {
    /// Axes in the parent's frame, joint at its reference; every entry twice.
    pub(crate) axes: [[f64x2; 3]; 3],
    pub(crate) mass: f64,
    /// Mass times centre.
    pub(crate) moment: Vector,
    /// Second moments `xx, yy, zz, xy, xz, yz` of the mass: the integral of `r r^T`.
    pub(crate) second: [f64; 6],
    /// Whether there is nothing to feel.
    pub(crate) weightless: bool,
}

/// Every entry twice.
#[inline]
pub(crate) fn twice(axes: &Frame) -> [[f64x2; 3]; 3] {
    axes.map(|axis| axis.map(f64x2::splat))
}

impl Stage {
    fn new(link: &Link) -> Stage {
        let Inertia { mass, moment, about_origin: [xx, yy, zz, xy, xz, yz] } = link.inertia;
        let half = 0.5 * (xx + yy + zz);
        let second = [half - xx, half - yy, half - zz, -xy, -xz, -yz];
        Stage { axes: twice(&link.axes), mass, moment, second, weightless: false }
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
        let own = &mut stages[index];
        let nothing = |value: &f64| value.abs() < f64::MIN_POSITIVE;
        own.weightless = own.moment.iter().chain(&own.second).chain([&own.mass]).all(nothing);
    }
    stages
}
