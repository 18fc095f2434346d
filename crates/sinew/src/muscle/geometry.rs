use super::surface::{Contact, cylinder, sphere};
use super::topology::{Around, Span, Surface, Topology};
use crate::body::vector::{Vector, cross, dot, norm, rotate, scale, sub, unrotate};
use crate::body::{Pose, Poses, Robot, WrapKind};
use crate::error::{Error, check_entries, check_length};
use alloc::vec;
use alloc::vec::Vec;

/// A span of cable in one pose.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Strand {
    /// Direction in which it leaves its first site.
    pub(super) out: Vector,
    /// Direction in which it comes to its second site.
    pub(super) into: Vector,
    pub(super) length: f64,
    /// The surface it touches, if it does.
    pub(super) contact: Option<Contact>,
    /// Angle by which it turns on the surface, rad.
    pub(super) angle: f64,
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
    nq: usize,
    pub(super) nv: usize,
}

/// Lengths, moment arms and contact points of the muscles in one pose, written by [`Muscles::evaluate`].
#[derive(Debug, Clone, PartialEq)]
pub struct Geometry {
    pub(super) poses: Poses,
    pub(super) points: Vec<Vector>,
    pub(super) surfaces: Vec<Pose>,
    pub(super) strands: Vec<Strand>,
    pub(super) lengths: Vec<f64>,
    pub(super) arms: Vec<f64>,
}

impl Geometry {
    /// Memory for the muscles of a robot; not evaluated yet.
    #[must_use]
    pub fn new(robot: &Robot, muscles: &Muscles) -> Geometry {
        let topology = &muscles.topology;
        let poses = Poses::new(robot);
        let surfaces = topology.surfaces.iter().map(|_| robot.body_pose(&poses, 0)).collect();
        Geometry {
            poses,
            points: vec![[0.0; 3]; topology.anchors.len()],
            surfaces,
            strands: vec![Strand::default(); topology.spans.len()],
            lengths: vec![0.0; topology.cables.len()],
            arms: vec![0.0; topology.columns.len()],
        }
    }

    /// Lengths, m: `[muscles]`.
    #[must_use]
    pub fn lengths(&self) -> &[f64] {
        &self.lengths
    }

    /// Moment arms of all muscles one after the other, each about the joints it crosses only
    /// ([`Muscles::columns`]).
    #[must_use]
    pub fn moment_arms(&self) -> &[f64] {
        &self.arms
    }
}

impl Muscles {
    /// The muscles of a robot.
    #[must_use]
    pub fn new(robot: &Robot) -> Muscles {
        Muscles { topology: Topology::new(robot), nq: robot.nq(), nv: robot.nv() }
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
        slots.and_then(|slots| geometry.arms.get(slots)).unwrap_or_default()
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
        for (index, link) in &topology.links {
            geometry.poses.place(*index, link, q);
        }
        for (point, anchor) in geometry.points.iter_mut().zip(&topology.anchors) {
            *point = geometry.poses.links[anchor.link].point(anchor.position);
        }
        for (pose, surface) in geometry.surfaces.iter_mut().zip(&topology.surfaces) {
            let Surface { place, .. } = surface;
            *pose = geometry.poses.of(place);
        }
        geometry.arms.fill(0.0);
        for (muscle, cable) in topology.cables.iter().enumerate() {
            let mut total = 0.0;
            for &(coordinate, slot, coefficient) in &cable.terms {
                total += coefficient * q[coordinate];
                geometry.arms[slot] = -coefficient;
            }
            for index in cable.spans.clone() {
                total += self.evaluate_span(index, geometry);
            }
            geometry.lengths[muscle] = total;
        }
        check_entries("lengths", &geometry.lengths, topology.cables.len())?;
        check_entries("moment arms", &geometry.arms, topology.columns.len())
    }

    /// Evaluates one span, adds its moment arms, and returns its weighted length.
    #[inline]
    fn evaluate_span(&self, index: usize, geometry: &mut Geometry) -> f64 {
        let span = &self.topology.spans[index];
        let (start, end) = (geometry.points[span.from], geometry.points[span.to]);
        let contact = span.around.as_ref().and_then(|around| self.wrap(span, around, geometry));
        let strand = match (&span.around, contact) {
            (Some(around), Some(contact)) => {
                let Contact { into, out, length, angle, .. } = contact;
                self.accumulate_moment_arms(around.before.clone(), span.fraction, start, into, geometry);
                self.accumulate_moment_arms(around.after.clone(), span.fraction, end, out, geometry);
                Strand { out: into, into: out, length, contact: Some(contact), angle }
            }
            _ => {
                let way = sub(end, start);
                let length = norm(way);
                // MuJoCo's direction of a segment of zero length.
                let u = if length < super::circle::TINY { [1.0, 0.0, 0.0] } else { scale(1.0 / length, way) };
                self.accumulate_moment_arms(span.direct.clone(), span.fraction, start, u, geometry);
                Strand { out: u, into: u, length, contact: None, angle: 0.0 }
            }
        };
        geometry.strands[index] = strand;
        span.fraction * strand.length
    }

    #[inline]
    fn wrap(&self, span: &Span, around: &Around, geometry: &Geometry) -> Option<Contact> {
        let surface = &self.topology.surfaces[around.surface];
        let pose = &geometry.surfaces[around.surface];
        let seen = |anchor: usize| sub(geometry.points[anchor], pose.origin);
        let (ends, side) = ([seen(span.from), seen(span.to)], around.side.map(seen));
        match surface.kind {
            WrapKind::Sphere => sphere(ends, side, surface.radius, &pose.axes),
            WrapKind::Cylinder => {
                let inner = |v| unrotate(&pose.axes, v);
                let contact = cylinder(ends.map(inner), side.map(inner), surface.radius)?;
                let (into, out) = (rotate(&pose.axes, contact.into), rotate(&pose.axes, contact.out));
                Some(Contact { into, out, ..contact })
            }
        }
    }

    /// Adds the moment arms of a straight segment along `u` through `x` about the joints it crosses.
    #[inline]
    fn accumulate_moment_arms(
        &self,
        crossings: core::ops::Range<usize>,
        fraction: f64,
        x: Vector,
        u: Vector,
        geometry: &mut Geometry,
    ) {
        let moment = cross(x, u);
        for crossing in &self.topology.crossings[crossings] {
            let axis = &geometry.poses.motion_axes[crossing.velocity];
            let along = dot(axis.angular, moment) + dot(axis.linear, u);
            geometry.arms[crossing.slot] -= fraction * crossing.sign * along;
        }
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
        self.spread(&geometry.arms, dense)
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
                .map(|slot| geometry.arms[slot] * v[self.topology.columns[slot]])
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
        tau.fill(0.0);
        for (cable, tension) in self.topology.cables.iter().zip(tensions) {
            for slot in cable.slots.clone() {
                tau[self.topology.columns[slot]] += geometry.arms[slot] * tension;
            }
        }
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
        check_length("geometry", geometry.poses.motion_axes.len(), self.nv)?;
        let last = topology.links.last().map_or(0, |(index, _)| *index);
        check_length("geometry", geometry.poses.links.len().max(last + 1), geometry.poses.links.len())
    }
}
