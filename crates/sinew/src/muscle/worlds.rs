use super::geometry::Geometry;
use super::spring::Spring;
use super::topology::{Numbers, Topology};
use crate::body::link::{Link, LinkRows};
use crate::body::{ForwardScratch, Held, JointSpring, Robot, Tendon, accelerations, hold};
use crate::lanes::{Mask, Row, Vector};
use alloc::sync::Arc;
use alloc::vec;
use alloc::vec::Vec;

/// Muscles, springs and bodies of several worlds of one machine of hinges and slides: same tree, routes and
/// joints, other numbers. Couplings of joints are not held.
#[derive(Debug, Clone)]
pub(crate) struct MuscleWorlds<const N: usize> {
    /// Whose numbers the worlds have: robots that were built apart differ here, copies, whose numbers never
    /// change, do not.
    built: [Arc<()>; N],
    pub(super) topology: Topology,
    pub(super) numbers: Numbers<N>,
    links: Vec<Link>,
    bodies: Vec<LinkRows<N>>,
    joint_springs: Vec<JointSpring<N>>,
    gravity: Vector<N>,
    /// Memory for what holds bodies, one for every link; none where no weight is held.
    held: Vec<Held<N>>,
    pub(super) geometry: Geometry<N>,
    scratch: ForwardScratch<N>,
    /// Forces on the joints: `[nv]`.
    pub(super) torque: Vec<[f64; N]>,
}

impl MuscleWorlds<1> {
    /// Of one robot of hinges and slides.
    pub(super) fn new(robot: &Robot) -> Self {
        let (topology, links, nv) = (topology(robot), robot.tree.links.clone(), robot.nv());
        Self {
            built: [Arc::new(())],
            numbers: Numbers::new(&topology),
            bodies: robot.tree.rows.clone(),
            joint_springs: robot.parts().joints.iter().map(JointSpring::from).collect(),
            gravity: Vector::all(robot.parts().gravity),
            held: vec![Held::default(); if robot.is_compensated() { links.len() } else { 0 }],
            geometry: Geometry::with_size(&topology, links.len(), nv),
            scratch: ForwardScratch::new(links.len(), nv),
            torque: vec![[0.0]; nv],
            topology,
            links,
        }
    }

    /// The same in every world.
    pub(crate) fn repeated<const N: usize>(&self) -> MuscleWorlds<N> {
        let Self { topology, links, torque, .. } = self;
        let mut worlds = MuscleWorlds {
            built: core::array::from_fn(|_| Arc::new(())),
            numbers: Numbers::new(topology),
            bodies: vec![LinkRows::default(); links.len()],
            joint_springs: vec![JointSpring::default(); self.joint_springs.len()],
            gravity: Vector::default(),
            held: vec![Held::default(); self.held.len()],
            geometry: Geometry::with_size(topology, links.len(), torque.len()),
            scratch: ForwardScratch::new(links.len(), torque.len()),
            torque: vec![[0.0; N]; torque.len()],
            topology: topology.clone(),
            links: links.clone(),
        };
        (0..N).for_each(|k| worlds.set(k, self));
        worlds
    }
}

impl<const N: usize> MuscleWorlds<N> {
    /// Whether a world differs in numbers alone.
    pub(crate) fn is_alike(&self, world: &MuscleWorlds<1>) -> bool {
        let link = |link: &Link| (link.parent, link.kind, link.q, link.v);
        self.built.iter().any(|built| Arc::ptr_eq(built, &world.built[0]))
            || self.links.iter().map(link).eq(world.links.iter().map(link))
                && self.held.len() == world.held.len()
                && self.topology.is_alike(&world.topology)
    }

    /// Sets the numbers of world `k`, which is [alike](Self::is_alike).
    pub(crate) fn set(&mut self, k: usize, world: &MuscleWorlds<1>) {
        if Arc::ptr_eq(&self.built[k], &world.built[0]) {
            return;
        }
        self.built[k].clone_from(&world.built[0]);
        self.numbers.set(k, &world.topology);
        for (rows, link) in self.bodies.iter_mut().zip(&world.links) {
            rows.set(k, link);
        }
        for (spring, one) in self.joint_springs.iter_mut().zip(&world.joint_springs) {
            spring.set(k, one);
        }
        self.gravity.set(k, world.gravity.at(0));
    }

    /// Lengths and moment arms, `q: [nq]`.
    #[inline(always)]
    pub(crate) fn evaluate(&mut self, q: &[[f64; N]]) {
        self.topology.evaluate(&self.numbers, q, &mut self.geometry);
    }

    /// Lengths, m, of the muscles, then of the springs.
    pub(crate) fn lengths(&self) -> &[[f64; N]] {
        &self.geometry.lengths
    }

    /// `phi` of a muscle, rad.
    #[inline(always)]
    pub(crate) fn bend(&self, muscle: usize) -> Row<N> {
        self.topology.bend(&self.numbers, &self.geometry, muscle)
    }

    /// Springs, dampers and what holds bodies in the evaluated pose.
    #[inline(always)]
    pub(super) fn passive(&mut self, q: &[[f64; N]], v: &[[f64; N]]) {
        for (((torque, spring), q), v) in self.torque.iter_mut().zip(&self.joint_springs).zip(q).zip(v) {
            *torque = spring.force(spring.stretch(Row(*q)), Row(*v)).0;
        }
        self.add_tendon_springs(v);
        self.add_held();
    }

    /// Tensions, springs, dampers and what holds bodies in the evaluated pose.
    #[inline(always)]
    pub(crate) fn forces(&mut self, q: &[[f64; N]], v: &[[f64; N]], tensions: &[[f64; N]]) {
        self.topology.torque(&self.geometry, tensions, &mut self.torque);
        for (((torque, spring), q), v) in self.torque.iter_mut().zip(&self.joint_springs).zip(q).zip(v) {
            *torque = (Row(*torque) + spring.force(spring.stretch(Row(*q)), Row(*v))).0;
        }
        self.add_tendon_springs(v);
        self.add_held();
    }

    #[inline(always)]
    fn add_held(&mut self) {
        let Self { links, bodies, gravity, geometry, held, torque, .. } = self;
        if !held.is_empty() {
            let of = (|index: usize| geometry.links[index], |k: usize| geometry.motion_axes[k]);
            hold(links, bodies, *gravity, of, held, torque);
        }
    }

    #[inline(always)]
    fn add_tendon_springs(&mut self, v: &[[f64; N]]) {
        let Self { topology, numbers, geometry, torque, .. } = self;
        for (&Spring { cable, .. }, spring) in topology.springs.iter().zip(&numbers.springs) {
            let slots = topology.cables[cable].slots.clone();
            let crossed = || topology.columns[slots.clone()].iter().zip(&geometry.arms[slots.clone()]);
            let mut rate = Row::default();
            crossed().for_each(|(column, arm)| rate += -Row(*arm) * Row(v[*column]));
            let tension = spring.tension(Row(geometry.lengths[cable]), rate);
            crossed().for_each(|(&column, arm)| {
                torque[column] = (Row(torque[column]) + Row(*arm) * tension).0;
            });
        }
    }

    /// Accelerations under [`torque`](Self::torque), `a: [nv]`; of every world the first link that moves
    /// nothing with mass, 0 where there is none.
    #[inline(always)]
    pub(super) fn accelerations(&mut self, q: &[[f64; N]], v: &[[f64; N]], a: &mut [[f64; N]]) -> [usize; N] {
        let Self { links, bodies, gravity, torque, scratch, .. } = self;
        accelerations(links, bodies, *gravity, [q, v, torque], scratch, a)
    }

    /// Accelerations under tensions and these forces beside, and whether they are finite.
    #[inline(always)]
    pub(crate) fn accelerate(
        &mut self,
        [q, v, tensions, external]: [&[[f64; N]]; 4],
        a: &mut [[f64; N]],
    ) -> Mask<N> {
        self.forces(q, v, tensions);
        for (torque, external) in self.torque.iter_mut().zip(external) {
            *torque = (Row(*torque) + Row(*external)).0;
        }
        let singular = self.accelerations(q, v, a);
        let mut sound = finite(a);
        for (sound, singular) in sound.0.iter_mut().zip(singular) {
            *sound &= if singular == 0 { !0 } else { 0 };
        }
        sound
    }

    /// Whether lengths and moment arms are finite.
    #[inline(always)]
    pub(crate) fn is_finite(&self) -> Mask<N> {
        finite(&self.geometry.lengths) & finite(&self.geometry.arms)
    }
}

/// Muscles and springs of a robot, with what acts along them.
fn topology(robot: &Robot) -> Topology {
    let (parts, mut topology) = (robot.parts(), Topology::with_springs(robot));
    let tendons = || parts.tendons.iter().chain(&parts.springs);
    let acts = |tendon: &Tendon| tendon.stiffness > 0.0 || tendon.damping > 0.0;
    if !tendons().any(acts) {
        return topology;
    }
    let mut at_rest = Geometry::<1>::with_size(&topology, robot.tree.links.len(), robot.nv());
    topology.evaluate(&Numbers::new(&topology), robot.spring_pose().as_chunks().0, &mut at_rest);
    let spring = |((cable, tendon), length): ((usize, &Tendon), &f64)| {
        let slack = tendon.spring_length.unwrap_or([*length; 2]);
        let Tendon { stiffness, damping, .. } = *tendon;
        acts(tendon).then_some(Spring { cable, stiffness, damping, slack })
    };
    topology.springs = tendons().enumerate().zip(at_rest.lengths()).filter_map(spring).collect();
    topology
}

/// The worlds in which all entries are finite.
#[inline(always)]
fn finite<const N: usize>(rows: &[[f64; N]]) -> Mask<N> {
    let mut finite = !Mask::NONE;
    for row in rows {
        finite = finite & Row(*row).is_finite();
    }
    finite
}
