use super::surface::{Contact, cylinder, sphere};
use super::topology::{Around, Bypass, Numbers, Span, Topology};
use crate::body::{PoseRows, Robot, WrapKind};
use crate::error::{Error, check_entries, check_length};
use crate::lanes::{Mask, Row, Vector};
use alloc::vec;
use alloc::vec::Vec;
use core::ops::Range;

/// A span of cable in one pose of several worlds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Strand<const N: usize> {
    /// Direction in which it leaves its first site.
    pub(super) out: Vector<N>,
    /// Direction in which it comes to its second site.
    pub(super) into: Vector<N>,
    pub(super) length: Row<N>,
    /// Where it touches its surface.
    pub(super) touches: Mask<N>,
    /// Length before the surface, and angle between the cable and the radius there.
    pub(super) before: Row<N>,
    pub(super) graze: Row<N>,
    /// Angle by which it turns on the surface, rad.
    pub(super) angle: Row<N>,
}

/// The muscles of a robot: every tendon is one, spatial or fixed.
///
/// ```text
/// l(q),    R = -dl/dq,    l' = -R v,    tau = R^T F
/// ```
///
/// A straight segment of direction `u` through `x` that crosses a joint changes its length with the joint:
/// `dl/dq = +-(w . (x x u) + s . u)`, with the joint's motion axis `(w, s)` at the world's origin. Only the
/// joints that a muscle crosses are evaluated.
///
/// # Assumes
/// Cables are straight between sites and surfaces, taut, without thickness; cylinders have no ends.
///
/// # Source
/// `mujoco2012`, whose rules decide where a cable wraps.
#[derive(Debug, Clone, PartialEq)]
pub struct Muscles {
    pub(super) topology: Topology,
    pub(super) numbers: Numbers<1>,
    nq: usize,
    pub(super) nv: usize,
}

/// Lengths, moment arms and contact points of the muscles in one pose, written by [`Muscles::evaluate`].
#[derive(Debug, Clone, PartialEq)]
pub struct Geometry<const N: usize = 1> {
    pub(super) links: Vec<PoseRows<N>>,
    pub(super) motion_axes: Vec<[Vector<N>; 2]>,
    pub(super) points: Vec<Vector<N>>,
    pub(super) surfaces: Vec<PoseRows<N>>,
    pub(super) strands: Vec<Strand<N>>,
    pub(super) lengths: Vec<[f64; N]>,
    pub(super) arms: Vec<[f64; N]>,
}

impl<const N: usize> Geometry<N> {
    /// Memory for so many links and velocities.
    pub(super) fn with_size(topology: &Topology, links: usize, nv: usize) -> Self {
        let (none, at) = (Row::default(), Vector::default());
        let (length, before, graze, angle) = (none, none, none, none);
        let strand = Strand { out: at, into: at, length, touches: Mask::NONE, before, graze, angle };
        Self {
            links: vec![PoseRows::world(); links],
            motion_axes: vec![[at; 2]; nv],
            points: vec![at; topology.anchors.len()],
            surfaces: vec![PoseRows::world(); topology.surfaces.len()],
            strands: vec![strand; topology.spans.len()],
            lengths: vec![[0.0; N]; topology.cables.len()],
            arms: vec![[0.0; N]; topology.columns.len()],
        }
    }
}

impl Geometry {
    /// Memory for the muscles of a robot; not evaluated yet.
    #[must_use]
    pub fn new(robot: &Robot, muscles: &Muscles) -> Geometry {
        Self::with_size(&muscles.topology, robot.tree.links.len(), robot.nv())
    }

    /// Lengths, m: `[muscles]`.
    #[must_use]
    pub fn lengths(&self) -> &[f64] {
        self.lengths.as_flattened()
    }

    /// Moment arms of all muscles one after the other, each about the joints it crosses only
    /// ([`Muscles::columns`]).
    #[must_use]
    pub fn moment_arms(&self) -> &[f64] {
        self.arms.as_flattened()
    }
}

impl Topology {
    /// Lengths and moment arms in one pose of every world, `q: [nq]`.
    #[inline(always)]
    pub(super) fn evaluate<const N: usize>(
        &self,
        numbers: &Numbers<N>,
        q: &[[f64; N]],
        geometry: &mut Geometry<N>,
    ) {
        for ((index, link), rows) in self.links.iter().zip(&numbers.links) {
            let pose = geometry.links[link.parent].child(link, rows, q);
            geometry.links[*index] = pose;
            for k in 0..link.kind.velocities() {
                geometry.motion_axes[link.v + k] = pose.motion_axis(link.kind, k);
            }
        }
        for ((point, anchor), position) in geometry.points.iter_mut().zip(&self.anchors).zip(&numbers.anchors)
        {
            *point = geometry.links[anchor.link].point(*position);
        }
        self.bypass(q, geometry);
        let surfaces = self.surfaces.iter().zip(&numbers.surfaces);
        for (pose, (surface, (_, place))) in geometry.surfaces.iter_mut().zip(surfaces) {
            *pose = geometry.links[surface.place.link].inner(&place.axes, place.origin);
        }
        geometry.arms.fill([0.0; N]);
        let mut coefficients = numbers.coefficients.iter();
        for (muscle, cable) in self.cables.iter().enumerate() {
            let mut total = Row::default();
            for (&(coordinate, slot, _), coefficient) in cable.terms.iter().zip(&mut coefficients) {
                total += *coefficient * Row(q[coordinate]);
                geometry.arms[slot] = (-*coefficient).0;
            }
            for index in cable.spans.clone() {
                total += self.evaluate_span(numbers, index, geometry);
            }
            geometry.lengths[muscle] = total.0;
        }
    }

    /// Puts sites that are not active halfway on the straight line between those before and behind, where
    /// they change neither length nor moment arms nor bend.
    #[inline(always)]
    fn bypass<const N: usize>(&self, q: &[[f64; N]], geometry: &mut Geometry<N>) {
        let points = &mut geometry.points;
        for Bypass { before, behind, sites } in &self.bypasses {
            let mut before = *before;
            for (index, &(anchor, coordinate, range)) in sites.iter().enumerate() {
                let mut next = points[*behind];
                for &(later, coordinate, range) in sites[index + 1..].iter().rev() {
                    next = Vector::select(is_active(Row(q[coordinate]), range), points[later], next);
                }
                let halfway = Row::all(0.5) * (points[before] + next);
                let active = is_active(Row(q[coordinate]), range);
                points[anchor] = Vector::select(active, points[anchor], halfway);
                before = anchor;
            }
        }
    }

    /// Evaluates one span, adds its moment arms, and returns its weighted length.
    #[inline(always)]
    fn evaluate_span<const N: usize>(
        &self,
        numbers: &Numbers<N>,
        index: usize,
        geometry: &mut Geometry<N>,
    ) -> Row<N> {
        let span = &self.spans[index];
        let (start, end) = (geometry.points[span.from], geometry.points[span.to]);
        let around = span.around.as_ref();
        // No closures: in a kernel they would be compiled for the baseline.
        let (mut contact, mut touches) = (None, Mask::NONE);
        if let Some(around) = around {
            contact = self.wrap(numbers, span, around, geometry);
        }
        if let Some(contact) = &contact {
            touches = contact.at;
        }
        let none = Row::default();
        let mut strand =
            Strand { out: start, into: start, length: none, touches, before: none, graze: none, angle: none };
        if !touches.all() {
            let way = end - start;
            let length = way.norm();
            // MuJoCo's direction of a segment of zero length.
            let point = length.less(Row::all(super::circle::TINY));
            let u = Vector::select(point, Vector::all([1.0, 0.0, 0.0]), (1.0 / length) * way);
            self.accumulate_moment_arms(span.direct.clone(), span.fraction, [start, u], !touches, geometry);
            (strand.out, strand.into, strand.length) = (u, u, length);
        }
        if let (Some(around), Some(contact), true) = (around, contact, touches.any()) {
            let Contact { into, out, .. } = contact;
            self.accumulate_moment_arms(
                around.before.clone(),
                span.fraction,
                [start, into],
                touches,
                geometry,
            );
            self.accumulate_moment_arms(around.after.clone(), span.fraction, [end, out], touches, geometry);
            strand = Strand {
                out: Vector::select(touches, into, strand.out),
                into: Vector::select(touches, out, strand.into),
                length: touches.select(contact.length, strand.length),
                touches,
                before: contact.free[0],
                graze: contact.touch.1,
                angle: touches.select(contact.angle, none),
            };
        }
        geometry.strands[index] = strand;
        span.fraction * strand.length
    }

    #[inline(always)]
    fn wrap<const N: usize>(
        &self,
        numbers: &Numbers<N>,
        span: &Span,
        around: &Around,
        geometry: &Geometry<N>,
    ) -> Option<Contact<N>> {
        let pose = &geometry.surfaces[around.surface];
        let (radius, _) = numbers.surfaces[around.surface];
        let points = &geometry.points;
        let ends = [points[span.from] - pose.origin, points[span.to] - pose.origin];
        let mut side = None;
        if let Some(anchor) = around.side {
            side = Some(points[anchor] - pose.origin);
        }
        match self.surfaces[around.surface].kind {
            WrapKind::Sphere => sphere(ends, side, radius, &pose.axes),
            WrapKind::Cylinder => {
                let ends = [pose.axes.unrotate(ends[0]), pose.axes.unrotate(ends[1])];
                if let Some(seen) = side {
                    side = Some(pose.axes.unrotate(seen));
                }
                let contact = cylinder(ends, side, radius)?;
                let (into, out) = (pose.axes.rotate(contact.into), pose.axes.rotate(contact.out));
                Some(Contact { into, out, ..contact })
            }
        }
    }

    /// Adds the moment arms of a straight segment along `u` through `x` about the joints it crosses.
    #[inline(always)]
    fn accumulate_moment_arms<const N: usize>(
        &self,
        crossings: Range<usize>,
        fraction: f64,
        [x, u]: [Vector<N>; 2],
        worlds: Mask<N>,
        geometry: &mut Geometry<N>,
    ) {
        let moment = x.cross(u);
        for crossing in &self.crossings[crossings] {
            let [angular, linear] = geometry.motion_axes[crossing.velocity];
            let along = angular.dot(moment) + linear.dot(u);
            let arm = worlds.select((fraction * crossing.sign) * along, Row::default());
            let arms = &mut geometry.arms[crossing.slot];
            *arms = (Row(*arms) - arm).0;
        }
    }

    /// Joint torques of tensions.
    #[inline(always)]
    pub(super) fn torque<const N: usize>(
        &self,
        geometry: &Geometry<N>,
        tensions: &[[f64; N]],
        tau: &mut [[f64; N]],
    ) {
        tau.fill([0.0; N]);
        for (cable, tension) in self.cables.iter().zip(tensions) {
            for slot in cable.slots.clone() {
                let tau = &mut tau[self.columns[slot]];
                *tau = (Row(*tau) + Row(geometry.arms[slot]) * Row(*tension)).0;
            }
        }
    }
}

/// Where a coordinate is within a range.
#[inline(always)]
fn is_active<const N: usize>(q: Row<N>, [low, high]: [f64; 2]) -> Mask<N> {
    !(q.less(Row::all(low)) | Row::all(high).less(q))
}

impl Muscles {
    /// The muscles of a robot.
    #[must_use]
    pub fn new(robot: &Robot) -> Muscles {
        let topology = Topology::new(robot);
        Muscles { numbers: Numbers::new(&topology), topology, nq: robot.nq(), nv: robot.nv() }
    }

    /// Number of muscles.
    #[must_use]
    pub fn count(&self) -> usize {
        self.topology.cables.len()
    }

    /// The velocities that a muscle's moment arms are about, in rising order for spatial tendons; empty for
    /// an index out of range.
    #[must_use]
    pub fn columns(&self, muscle: usize) -> &[usize] {
        self.topology.cables.get(muscle).map_or(&[], |cable| &self.topology.columns[cable.slots.clone()])
    }

    /// A muscle's moment arms, `R = -dl/dq`, in the order of [`columns`](Muscles::columns).
    #[must_use]
    pub fn arms<'a>(&self, geometry: &'a Geometry, muscle: usize) -> &'a [f64] {
        let slots = self.topology.cables.get(muscle).map(|cable| cable.slots.clone());
        slots.and_then(|slots| geometry.moment_arms().get(slots)).unwrap_or_default()
    }

    /// Lengths and moment arms of all muscles.
    ///
    /// # Shapes
    /// `q: [nq]`, as [`Robot`] has it.
    ///
    /// # Errors
    /// [`Error::WrongLength`], and [`Error::EntryOutOfDomain`] where a coordinate is not finite.
    pub fn evaluate(&self, q: &[f64], geometry: &mut Geometry) -> Result<(), Error> {
        check_entries("q", q, self.nq)?;
        self.check(geometry)?;
        let topology = &self.topology;
        topology.evaluate(&self.numbers, q.as_chunks().0, geometry);
        check_entries("lengths", geometry.lengths(), topology.cables.len())?;
        check_entries("moment arms", geometry.moment_arms(), topology.columns.len())
    }

    /// The whole matrix of moment arms, zeros where a muscle does not cross a joint.
    ///
    /// # Shapes
    /// `dense: [muscles x nv]`, row by row.
    ///
    /// # Errors
    /// [`Error::WrongLength`] names the slice.
    pub fn dense(&self, geometry: &Geometry, dense: &mut [f64]) -> Result<(), Error> {
        self.check(geometry)?;
        self.spread(geometry.moment_arms(), dense)
    }

    /// Sparse rows to a whole matrix.
    pub(super) fn spread(&self, sparse: &[f64], dense: &mut [f64]) -> Result<(), Error> {
        check_length("dense", dense.len(), self.count() * self.nv)?;
        dense.fill(0.0);
        for (muscle, cable) in self.topology.cables.iter().enumerate() {
            for slot in cable.slots.clone() {
                dense[muscle * self.nv + self.topology.columns[slot]] = sparse[slot];
            }
        }
        Ok(())
    }

    /// Rates of the muscle lengths: `l' = -R v`, m/s.
    ///
    /// # Shapes
    /// `v: [nv]`, `rates: [muscles]`.
    ///
    /// # Errors
    /// [`Error::WrongLength`], and [`Error::EntryOutOfDomain`] where a velocity is not finite.
    pub fn velocities(&self, geometry: &Geometry, v: &[f64], rates: &mut [f64]) -> Result<(), Error> {
        self.check(geometry)?;
        check_entries("v", v, self.nv)?;
        check_length("rates", rates.len(), self.count())?;
        for (cable, rate) in self.topology.cables.iter().zip(rates.iter_mut()) {
            *rate = -cable
                .slots
                .clone()
                .map(|slot| geometry.moment_arms()[slot] * v[self.topology.columns[slot]])
                .sum::<f64>();
        }
        Ok(())
    }

    /// Joint torques of tensions: `tau = R^T F`.
    ///
    /// # Shapes
    /// `tensions: [muscles]`, N; `tau: [nv]`, Nm or N.
    ///
    /// # Errors
    /// [`Error::WrongLength`], and [`Error::EntryOutOfDomain`] where a tension is not finite.
    pub fn torque(&self, geometry: &Geometry, tensions: &[f64], tau: &mut [f64]) -> Result<(), Error> {
        self.check(geometry)?;
        check_entries("tensions", tensions, self.count())?;
        check_length("tau", tau.len(), self.nv)?;
        self.topology.torque(geometry, tensions.as_chunks().0, tau.as_chunks_mut().0);
        Ok(())
    }

    /// Checks that the geometry was built for these muscles.
    pub(super) fn check(&self, geometry: &Geometry) -> Result<(), Error> {
        let topology = &self.topology;
        check_length("geometry", geometry.lengths.len(), topology.cables.len())?;
        check_length("geometry", geometry.arms.len(), topology.columns.len())?;
        check_length("geometry", geometry.strands.len(), topology.spans.len())?;
        check_length("geometry", geometry.points.len(), topology.anchors.len())?;
        check_length("geometry", geometry.surfaces.len(), topology.surfaces.len())?;
        check_length("geometry", geometry.motion_axes.len(), self.nv)?;
        let last = topology.links.last().map_or(0, |(index, _)| *index);
        check_length("geometry", geometry.links.len().max(last + 1), geometry.links.len())
    }
}
