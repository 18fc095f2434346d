//! The pose-independent part of the muscles: sites, surfaces, and the joints that each cable crosses.

use super::spring::{Spring, TendonSpring};
use crate::body::link::{Inertia, Link, LinkFrame, LinkRows};
use crate::body::vector::Vector;
use crate::body::{PathElement, PoseRows, Robot, Tendon, TendonPath, WrapKind};
use crate::lanes::{self, Row};
use alloc::collections::{BTreeMap, BTreeSet};
use alloc::vec;
use alloc::vec::Vec;
use core::ops::Range;

/// A joint velocity that changes the length of a straight segment of cable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Crossing {
    /// Index of the velocity.
    pub(super) velocity: usize,
    /// Index of the moment arm about it.
    pub(super) slot: usize,
    /// +1 when the joint carries the far end of the segment, -1 when it carries the near end.
    pub(super) sign: f64,
}

/// Cable from one site to the next, possibly around a surface.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Span {
    pub(super) from: usize,
    pub(super) to: usize,
    /// Weight of this span in the muscle's length.
    pub(super) fraction: f64,
    /// Whether it begins a branch, so that it does not continue the span before.
    pub(super) begins: bool,
    /// Joints between the two sites.
    pub(super) direct: Range<usize>,
    pub(super) around: Option<Around>,
}

/// Consecutive sites that a cable passes through only while a joint is within a range.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Bypass {
    /// Anchors before and behind them.
    pub(super) before: usize,
    pub(super) behind: usize,
    /// Their anchors, each with its coordinate and the range.
    pub(super) sites: Vec<(usize, usize, [f64; 2])>,
}

/// The surface of a span.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Around {
    pub(super) surface: usize,
    pub(super) side: Option<usize>,
    /// Joints between the first site and the surface.
    pub(super) before: Range<usize>,
    /// Joints between the surface and the second site.
    pub(super) after: Range<usize>,
}

/// A point on a link.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Anchor {
    pub(super) link: usize,
    pub(super) position: Vector,
}

/// A wrapping surface on a link.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Surface {
    pub(super) kind: WrapKind,
    pub(super) radius: f64,
    pub(super) place: LinkFrame,
}

/// One cable.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Cable {
    /// Its spans; empty for a fixed tendon.
    pub(super) spans: Range<usize>,
    /// Its moment arms.
    pub(super) slots: Range<usize>,
    /// Terms of a fixed tendon: coordinate, slot, coefficient.
    pub(super) terms: Vec<(usize, usize, f64)>,
    /// Direction of the end of its sheath, and its link.
    pub(super) sheath_end: Option<Anchor>,
}

/// All data that are the same in every pose.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Topology {
    /// Links that muscles touch or whose weight is held, and their ancestors, each with its index in the
    /// tree.
    pub(super) links: Vec<(usize, Link)>,
    pub(super) anchors: Vec<Anchor>,
    pub(super) surfaces: Vec<Surface>,
    /// First those of the muscles.
    pub(super) cables: Vec<Cable>,
    pub(super) muscles: usize,
    pub(super) springs: Vec<Spring>,
    pub(super) spans: Vec<Span>,
    pub(super) bypasses: Vec<Bypass>,
    pub(super) crossings: Vec<Crossing>,
    /// Velocity index of each moment arm.
    pub(super) columns: Vec<usize>,
}

/// The numbers of a topology in several worlds of one machine, which differ in them alone.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Numbers<const N: usize> {
    pub(super) links: Vec<LinkRows<N>>,
    pub(super) anchors: Vec<lanes::Vector<N>>,
    /// Radius, axes and origin on the link.
    pub(super) surfaces: Vec<(Row<N>, PoseRows<N>)>,
    /// Terms of the fixed tendons, one after the other.
    pub(super) coefficients: Vec<Row<N>>,
    /// Of every cable; zeros where its sheath has no direction.
    pub(super) sheath_ends: Vec<lanes::Vector<N>>,
    pub(super) springs: Vec<TendonSpring<N>>,
}

impl<const N: usize> Numbers<N> {
    /// Those of one machine in all worlds.
    pub(super) fn new(topology: &Topology) -> Self {
        let terms = topology.cables.iter().map(|cable| cable.terms.len()).sum();
        let mut numbers = Self {
            links: vec![LinkRows::default(); topology.links.len()],
            anchors: vec![lanes::Vector::default(); topology.anchors.len()],
            surfaces: vec![Default::default(); topology.surfaces.len()],
            coefficients: vec![Row::default(); terms],
            sheath_ends: vec![lanes::Vector::default(); topology.cables.len()],
            springs: vec![TendonSpring::default(); topology.springs.len()],
        };
        (0..N).for_each(|k| numbers.set(k, topology));
        numbers
    }

    /// Sets those of world `k`, from a topology that is [alike](Topology::is_alike).
    pub(super) fn set(&mut self, k: usize, topology: &Topology) {
        for (rows, (_, link)) in self.links.iter_mut().zip(&topology.links) {
            rows.set(k, link);
        }
        for (row, anchor) in self.anchors.iter_mut().zip(&topology.anchors) {
            row.set(k, anchor.position);
        }
        for ((radius, pose), surface) in self.surfaces.iter_mut().zip(&topology.surfaces) {
            radius.0[k] = surface.radius;
            pose.axes.set(k, surface.place.axes);
            pose.origin.set(k, surface.place.origin);
        }
        let terms = topology.cables.iter().flat_map(|cable| &cable.terms);
        for (row, (.., coefficient)) in self.coefficients.iter_mut().zip(terms) {
            row.0[k] = *coefficient;
        }
        for (row, cable) in self.sheath_ends.iter_mut().zip(&topology.cables) {
            row.set(k, cable.sheath_end.map_or([0.0; 3], |end| end.position));
        }
        for (rows, spring) in self.springs.iter_mut().zip(&topology.springs) {
            rows.set(k, spring);
        }
    }
}

impl Topology {
    /// Whether another one differs in numbers alone: same links, joints, spans and crossings.
    pub(super) fn is_alike(&self, other: &Self) -> bool {
        let link = |(index, link): &(usize, Link)| (*index, link.parent, link.kind, link.q, link.v);
        let surface = |surface: &Surface| (surface.kind, surface.place.link);
        let cable = |cable: &Cable| {
            let sheath = cable.sheath_end.map(|end| end.link);
            (cable.spans.clone(), cable.slots.clone(), sheath, cable.terms.len())
        };
        let term = |cable: &Cable, k: usize| (cable.terms[k].0, cable.terms[k].1);
        let terms = |(one, two): (&Cable, &Cable)| (0..one.terms.len()).all(|k| term(one, k) == term(two, k));
        self.links.iter().map(link).eq(other.links.iter().map(link))
            && self.anchors.iter().map(|at| at.link).eq(other.anchors.iter().map(|at| at.link))
            && self.surfaces.iter().map(surface).eq(other.surfaces.iter().map(surface))
            && self.cables.iter().map(cable).eq(other.cables.iter().map(cable))
            && self.cables.iter().zip(&other.cables).all(terms)
            && self
                .springs
                .iter()
                .map(|spring| spring.cable)
                .eq(other.springs.iter().map(|spring| spring.cable))
            && self.spans == other.spans
            && self.bypasses == other.bypasses
            && self.crossings == other.crossings
            && self.columns == other.columns
    }
}

/// Builds a topology.
struct TopologyBuilder<'a> {
    robot: &'a Robot,
    topology: Topology,
    anchor_of: BTreeMap<usize, usize>,
    surface_of: BTreeMap<usize, usize>,
}

impl Topology {
    /// Of the muscles alone.
    pub(super) fn new(robot: &Robot) -> Topology {
        Self::of(robot, &robot.parts().tendons)
    }

    /// Of muscles and springs; what acts along them is not known yet.
    pub(super) fn with_springs(robot: &Robot) -> Topology {
        let parts = robot.parts();
        let tendons: Vec<Tendon> = parts.tendons.iter().chain(&parts.springs).cloned().collect();
        Topology { muscles: parts.tendons.len(), ..Self::of(robot, &tendons) }
    }

    fn of(robot: &Robot, tendons: &[Tendon]) -> Topology {
        let topology = Topology { muscles: tendons.len(), ..Topology::default() };
        let (anchor_of, surface_of) = (BTreeMap::new(), BTreeMap::new());
        let mut builder = TopologyBuilder { robot, topology, anchor_of, surface_of };
        for tendon in tendons {
            let first = builder.topology.columns.len();
            let mut cable = match &tendon.path {
                TendonPath::Fixed(terms) => builder.sum(terms),
                TendonPath::Spatial(elements) => builder.spatial(elements),
            };
            cable.slots = first..builder.topology.columns.len();
            let axis = tendon.sheath.as_ref().and_then(|sheath| sheath.end_axis);
            cable.sheath_end =
                axis.zip(builder.topology.spans.get(cable.spans.start)).and_then(|(axis, span)| {
                    let TendonPath::Spatial(elements) = &tendon.path else { return None };
                    let first = elements.iter().find_map(|element| match element {
                        PathElement::Site(site) => Some(*site),
                        _ => None,
                    })?;
                    let body = &robot.tree.bodies[robot.parts().sites[first].body];
                    let position = crate::body::vector::rotate(&body.axes, axis);
                    Some(Anchor { link: builder.topology.anchors[span.from].link, position })
                });
            builder.topology.cables.push(cable);
        }
        builder.collect_links();
        builder.topology
    }
}

impl TopologyBuilder<'_> {
    fn sum(&mut self, terms: &[(usize, f64)]) -> Cable {
        let start = self.topology.spans.len();
        let mut cable = Cable { spans: start..start, slots: 0..0, terms: Vec::new(), sheath_end: None };
        for &(joint, coefficient) in terms {
            let (q, v) = (self.robot.coordinates_of(joint).start, self.robot.velocities_of(joint).start);
            cable.terms.push((q, self.topology.columns.len(), coefficient));
            self.topology.columns.push(v);
        }
        cable
    }

    fn spatial(&mut self, elements: &[PathElement]) -> Cable {
        let start = self.topology.spans.len();
        let pieces = self.pieces(elements);
        let first = self.topology.columns.len();
        let mut columns = BTreeSet::new();
        for piece in &pieces {
            let (from, to) = (self.topology.anchors[piece.from].link, self.topology.anchors[piece.to].link);
            let mut stops = [Some(from), None, Some(to)];
            if let Some((surface, _)) = piece.around {
                stops[1] = Some(self.topology.surfaces[surface].place.link);
            }
            let stops: Vec<usize> = stops.into_iter().flatten().collect();
            for pair in stops.windows(2) {
                columns.extend(self.between(pair[0], pair[1]).into_iter().map(|(velocity, _)| velocity));
            }
        }
        self.topology.columns.extend(columns);
        for piece in pieces {
            let (from, to) = (self.topology.anchors[piece.from].link, self.topology.anchors[piece.to].link);
            let direct = self.cross(from, to, first);
            let around = piece.around.map(|(surface, side)| {
                let link = self.topology.surfaces[surface].place.link;
                let (before, after) = (self.cross(from, link, first), self.cross(link, to, first));
                Around { surface, side, before, after }
            });
            let Piece { from, to, fraction, begins, .. } = piece;
            self.topology.spans.push(Span { from, to, fraction, begins, direct, around });
        }
        let spans = start..self.topology.spans.len();
        Cable { spans, slots: 0..0, terms: Vec::new(), sheath_end: None }
    }

    /// Pairs of consecutive sites, with the surface between them.
    fn pieces(&mut self, elements: &[PathElement]) -> Vec<Piece> {
        let (mut pieces, mut fraction, mut begins) = (Vec::new(), 1.0, true);
        let (mut last, mut around, mut open) = (None, None, None);
        for element in elements {
            match *element {
                PathElement::Pulley(divisor) => (last, fraction, begins) = (None, 1.0 / divisor, true),
                PathElement::Wrap { wrap, side } => {
                    around = Some((self.surface(wrap), side.map(|side| self.anchor(side))));
                }
                PathElement::Site(site) => {
                    let to = self.anchor(site);
                    self.bypass(site, to, last, &mut open);
                    if let Some(from) = last {
                        pieces.push(Piece { from, to, fraction, begins, around: around.take() });
                        begins = false;
                    }
                    last = Some(to);
                }
            }
        }
        pieces
    }

    /// Notes a site that is not always active, or the end of a run of such sites.
    fn bypass(&mut self, site: usize, anchor: usize, last: Option<usize>, open: &mut Option<Bypass>) {
        match (self.robot.parts().sites[site].active, last) {
            (Some((joint, range)), Some(before)) => {
                let q = self.robot.coordinates_of(joint).start;
                let run = open.get_or_insert(Bypass { before, behind: anchor, sites: Vec::new() });
                run.sites.push((anchor, q, range));
            }
            _ => {
                let run = open.take().map(|run| Bypass { behind: anchor, ..run });
                self.topology.bypasses.extend(run);
            }
        }
    }

    fn anchor(&mut self, site: usize) -> usize {
        let place = self.robot.site_place(site);
        // A site that is not always active is elsewhere on every cable.
        if self.robot.parts().sites[site].active.is_some() {
            self.anchor_of.remove(&site);
        }
        let anchors = &mut self.topology.anchors;
        *self.anchor_of.entry(site).or_insert_with(|| {
            anchors.push(Anchor { link: place.link, position: place.origin });
            anchors.len() - 1
        })
    }

    fn surface(&mut self, wrap: usize) -> usize {
        let place = self.robot.wrap_place(wrap);
        let part = &self.robot.parts().wraps[wrap];
        let surfaces = &mut self.topology.surfaces;
        *self.surface_of.entry(wrap).or_insert_with(|| {
            surfaces.push(Surface { kind: part.kind, radius: part.radius, place });
            surfaces.len() - 1
        })
    }

    /// Velocities of the joints between two links, +1 for those that carry the second link, -1 for the first.
    fn between(&self, first: usize, second: usize) -> Vec<(usize, f64)> {
        let links = &self.robot.tree.links;
        let (mut a, mut b, mut found) = (first, second, Vec::new());
        // Parents precede their children: the link of higher index is never an ancestor of the other.
        while a != b {
            let (at, sign) = if a > b { (a, -1.0) } else { (b, 1.0) };
            let link = &links[at];
            found.extend((link.v..link.v + link.kind.velocities()).map(|velocity| (velocity, sign)));
            if a > b { a = link.parent } else { b = link.parent }
        }
        found
    }

    fn cross(&mut self, first: usize, second: usize, slots: usize) -> Range<usize> {
        let start = self.topology.crossings.len();
        for (velocity, sign) in self.between(first, second) {
            let own = &self.topology.columns[slots..];
            let slot = slots + own.iter().position(|&column| column == velocity).unwrap_or_default();
            self.topology.crossings.push(Crossing { velocity, slot, sign });
        }
        start..self.topology.crossings.len()
    }

    /// Collects the links that the topology needs, parents first.
    fn collect_links(&mut self) {
        let links = &self.robot.tree.links;
        let topology = &mut self.topology;
        let ends = topology.anchors.iter().map(|anchor| anchor.link);
        let held = (0..links.len()).filter(|&link| links[link].held != Inertia::default());
        let mut needed = BTreeSet::new();
        for link in ends.chain(held).chain(topology.surfaces.iter().map(|surface| surface.place.link)) {
            let mut at = link;
            while at != 0 && needed.insert(at) {
                at = links[at].parent;
            }
        }
        topology.links = needed.into_iter().map(|index| (index, links[index].clone())).collect();
    }
}

/// Two consecutive sites and the surface between them.
struct Piece {
    from: usize,
    to: usize,
    fraction: f64,
    begins: bool,
    around: Option<(usize, Option<usize>)>,
}
