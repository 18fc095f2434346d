use super::check::check;
use super::geom::{MeshGeom, TriangleSurface};
use super::link::{Link, LinkFrame};
use super::part_error::PartError;
use super::parts::{Body, JointKind, Parts};
use super::tree::Tree;
use super::vector::{add_scaled, frame_of, point_inertia, scale, sub};
use crate::error::{Error, check_entries, non_negative};
use alloc::string::String;
use alloc::sync::Arc;
use alloc::vec;
use alloc::vec::Vec;

/// A validated robot with the data that its mechanics need. Immutable.
///
/// Coordinates `q: [nq]` and velocities `v: [nv]` are MuJoCo's, joints in order: a hinge or slide has one of
/// each; a ball a unit quaternion and the angular velocity in the body's frame; a free joint position in
/// the world and quaternion, linear velocity in the world and angular velocity in the body's frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Robot {
    parts: Parts,
    pub(crate) tree: Tree,
    /// Couplings, leaders before followers.
    pub(super) followers: Vec<usize>,
}

impl Robot {
    /// Validates a description. Directions and quaternions within 1e-3 of unit length are normalised.
    ///
    /// # Errors
    /// [`PartError`] names the first invalid part, the property, what is required of it and what it is.
    pub fn new(mut parts: Parts) -> Result<Robot, PartError> {
        check(&mut parts)?;
        let tree = Tree::new(&parts);
        let followers = in_order(&parts);
        Ok(Robot { parts, tree, followers })
    }

    /// Gives the shapes of other files their triangles, for drawings; none where `surface` gives none.
    pub fn read_meshes(&mut self, mut surface: impl FnMut(&MeshGeom) -> Option<Arc<TriangleSurface>>) {
        for mesh in &mut self.parts.meshes {
            mesh.surface = surface(mesh);
        }
    }

    /// The same robot with a point mass on a body.
    ///
    /// | symbol   | argument   | unit | domain     | meaning                        |
    /// |----------|------------|------|------------|--------------------------------|
    /// | m        | `mass`     | kg   | >= 0       | mass of the payload             |
    /// |          | `position` | m    | finite     | where, in the body's frame      |
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] for a mass below zero, or a body out of range; [`Error::EntryOutOfDomain`] for
    /// a position that is not finite.
    pub fn with_payload(&self, body: usize, position: [f64; 3], mass: f64) -> Result<Robot, Error> {
        non_negative("mass of the payload", mass)?;
        check_entries("position of the payload", &position, 3)?;
        let mut parts = self.parts.clone();
        let Some(carrier) = parts.bodies.get_mut(body) else {
            return Err(Error::OutOfDomain {
                name: "body of the payload",
                expected: "an index of a body",
                got: body as f64,
            });
        };
        if carrier.gravity_compensation == 0.0 {
            add_point_mass(carrier, position, mass);
        } else if mass > 0.0 {
            // A body of its own, because what holds the weight of the carrier does not know of it.
            parts.bodies.push(Body {
                name: String::new(),
                parent: body,
                position,
                orientation: [1.0, 0.0, 0.0, 0.0],
                mass,
                center_of_mass: [0.0; 3],
                inertia: [0.0; 6],
                gravity_compensation: 0.0,
            });
        }
        Ok(Robot::new(parts)?)
    }

    /// The description, as validated.
    #[must_use]
    pub fn parts(&self) -> &Parts {
        &self.parts
    }

    /// Number of coordinates.
    #[must_use]
    pub fn nq(&self) -> usize {
        self.tree.nq
    }

    /// Number of velocities.
    #[must_use]
    pub fn nv(&self) -> usize {
        self.tree.nv
    }

    /// A body by its name.
    #[must_use]
    pub fn body(&self, name: &str) -> Option<usize> {
        self.parts.bodies.iter().position(|part| part.name == name)
    }

    /// A joint by its name.
    #[must_use]
    pub fn joint(&self, name: &str) -> Option<usize> {
        self.parts.joints.iter().position(|part| part.name == name)
    }

    /// A site by its name.
    #[must_use]
    pub fn site(&self, name: &str) -> Option<usize> {
        self.parts.sites.iter().position(|part| part.name == name)
    }

    /// A tendon by its name.
    #[must_use]
    pub fn tendon(&self, name: &str) -> Option<usize> {
        self.parts.tendons.iter().position(|part| part.name == name)
    }

    /// A key pose by its name.
    #[must_use]
    pub fn key(&self, name: &str) -> Option<&[f64]> {
        self.parts.keys.iter().find(|part| part.name == name).map(|key| key.q.as_slice())
    }

    /// Range of a joint's coordinates in `q`; empty for an index out of range.
    #[must_use]
    pub fn coordinates_of(&self, joint: usize) -> core::ops::Range<usize> {
        self.link_of(joint).map_or(0..0, |link| link.q..link.q + link.kind.coordinates())
    }

    /// Range of a joint's velocities in `v`; empty for an index out of range.
    #[must_use]
    pub fn velocities_of(&self, joint: usize) -> core::ops::Range<usize> {
        self.link_of(joint).map_or(0..0, |link| link.v..link.v + link.kind.velocities())
    }

    /// The joints that follow no other, in order.
    #[must_use]
    pub fn independent_joints(&self) -> Vec<usize> {
        let follows = |joint: usize| self.parts.couplings.iter().any(|coupling| coupling.follower == joint);
        (0..self.parts.joints.len()).filter(|&joint| !follows(joint)).collect()
    }

    /// The joint that a velocity belongs to.
    #[must_use]
    pub fn joint_of_velocity(&self, velocity: usize) -> Option<usize> {
        let mut links = self.moving_links();
        links
            .find(|link| (link.v..link.v + link.kind.velocities()).contains(&velocity))
            .map(|link| link.joint)
    }

    /// The pose with all joints at their references.
    #[must_use]
    pub fn reference_pose(&self) -> Vec<f64> {
        let mut q = vec![0.0; self.nq()];
        for link in self.moving_links() {
            let joint = &self.parts.joints[link.joint];
            let mine = &mut q[link.q..link.q + link.kind.coordinates()];
            match link.kind {
                JointKind::Hinge | JointKind::Slide => mine[0] = joint.reference,
                JointKind::Ball => mine[0] = 1.0,
                JointKind::Free => {
                    let body = &self.parts.bodies[joint.body];
                    mine[..3].copy_from_slice(&body.position);
                    mine[3..].copy_from_slice(&body.orientation);
                }
            }
        }
        q
    }

    /// The same with hinges and slides where their springs are at rest: the pose in which tendons have the
    /// lengths at which springs without other ones are slack.
    pub(crate) fn spring_pose(&self) -> Vec<f64> {
        let mut q = self.reference_pose();
        for link in self.moving_links() {
            if let JointKind::Hinge | JointKind::Slide = link.kind {
                q[link.q] = self.parts.joints[link.joint].spring_reference;
            }
        }
        q
    }

    /// Mass of all moving links, kg.
    #[must_use]
    pub fn moving_mass(&self) -> f64 {
        self.moving_links().map(|link| link.inertia.mass).sum()
    }

    /// Frame of a site on its link.
    pub(crate) fn site_place(&self, site: usize) -> LinkFrame {
        let site = &self.parts.sites[site];
        self.tree.bodies[site.body].inner(site.position, &frame_of(site.orientation))
    }

    /// Frame of a wrapping surface on its link.
    pub(crate) fn wrap_place(&self, wrap: usize) -> LinkFrame {
        let wrap = &self.parts.wraps[wrap];
        self.tree.bodies[wrap.body].inner(wrap.position, &frame_of(wrap.orientation))
    }

    /// All links except the ground.
    pub(crate) fn moving_links(&self) -> impl Iterator<Item = &Link> {
        self.tree.links.iter().skip(1)
    }

    fn link_of(&self, joint: usize) -> Option<&Link> {
        self.tree.link_of_joint.get(joint).map(|&link| &self.tree.links[link])
    }

    /// Checks the number of coordinates and that all are finite.
    pub(crate) fn check_coordinates(&self, q: &[f64]) -> Result<(), Error> {
        check_entries("q", q, self.nq())
    }

    /// Checks one finite value per velocity.
    pub(crate) fn check_velocities(&self, name: &'static str, v: &[f64]) -> Result<(), Error> {
        check_entries(name, v, self.nv())
    }
}

/// Adds a point mass to a body: inertia about the common centre, by Steiner's theorem.
fn add_point_mass(body: &mut Body, position: [f64; 3], mass: f64) {
    let total = body.mass + mass;
    if total <= 0.0 {
        return;
    }
    let moment = add_scaled(scale(body.mass, body.center_of_mass), mass, position);
    let center = scale(1.0 / total, moment);
    let own = point_inertia(body.mass, sub(body.center_of_mass, center));
    let added = point_inertia(mass, sub(position, center));
    for (entry, extra) in body.inertia.iter_mut().zip(own.iter().zip(added)) {
        *entry += extra.0 + extra.1;
    }
    (body.mass, body.center_of_mass) = (total, center);
}

/// Topological order of the couplings: leaders before followers.
fn in_order(parts: &Parts) -> Vec<usize> {
    let mut coupling_of = vec![None; parts.joints.len()];
    for (index, coupling) in parts.couplings.iter().enumerate() {
        coupling_of[coupling.follower] = Some(index);
    }
    let (mut order, mut done) = (Vec::new(), vec![false; parts.couplings.len()]);
    for index in 0..parts.couplings.len() {
        let mut chain = Vec::new();
        let mut at = Some(index);
        while let Some(coupling) = at.filter(|&coupling| !done[coupling]) {
            done[coupling] = true;
            chain.push(coupling);
            at = parts.couplings[coupling].leader.and_then(|leader| coupling_of[leader]);
        }
        order.extend(chain.into_iter().rev());
    }
    order
}
