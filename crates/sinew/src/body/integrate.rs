use super::parts::JointKind;
use super::robot::Robot;
use super::vector::{quaternion_of, quaternion_product, rotation_of, scale, unit_quaternion};
use crate::error::{Error, check_length, finite};

impl Robot {
    /// Integrates coordinates over `dt` at constant velocity; angular velocities are in the body's frame.
    ///
    /// ```text
    /// q <- q (+) v dt;    quaternion <- quaternion * exp(omega dt / 2)
    /// ```
    ///
    /// # Shapes
    /// `q: [nq]`, `v: [nv]`.
    ///
    /// # Errors
    /// [`Error::WrongLength`], and [`Error::OutOfDomain`] where an entry or `dt` is not finite.
    pub fn integrate(&self, q: &mut [f64], v: &[f64], dt: f64) -> Result<(), Error> {
        self.check_coordinates(q)?;
        self.check_velocities("v", v)?;
        finite("dt", dt)?;
        for link in self.moving_links() {
            let v = &v[link.v..link.v + link.kind.velocities()];
            let q = &mut q[link.q..link.q + link.kind.coordinates()];
            match link.kind {
                JointKind::Hinge | JointKind::Slide => q[0] += v[0] * dt,
                JointKind::Ball => turn(q, v, dt),
                JointKind::Free => {
                    for k in 0..3 {
                        q[k] += v[k] * dt;
                    }
                    turn(&mut q[3..], &v[3..], dt);
                }
            }
        }
        Ok(())
    }

    /// The velocity that leads from one pose to another in unit time: the inverse of
    /// [`integrate`](Robot::integrate).
    ///
    /// # Shapes
    /// `from` and `to: [nq]`, `v: [nv]`.
    ///
    /// # Errors
    /// As [`integrate`](Robot::integrate).
    pub fn difference(&self, from: &[f64], to: &[f64], v: &mut [f64]) -> Result<(), Error> {
        self.check_coordinates(from)?;
        self.check_coordinates(to)?;
        check_length("v", v.len(), self.nv())?;
        for link in self.moving_links() {
            let range = link.q..link.q + link.kind.coordinates();
            let (from, to) = (&from[range.clone()], &to[range]);
            let v = &mut v[link.v..link.v + link.kind.velocities()];
            match link.kind {
                JointKind::Hinge | JointKind::Slide => v[0] = to[0] - from[0],
                JointKind::Ball => v.copy_from_slice(&turn_between(from, to)),
                JointKind::Free => {
                    for k in 0..3 {
                        v[k] = to[k] - from[k];
                    }
                    v[3..].copy_from_slice(&turn_between(&from[3..], &to[3..]));
                }
            }
        }
        Ok(())
    }
}

fn turn(q: &mut [f64], omega: &[f64], dt: f64) {
    let now = unit_quaternion([q[0], q[1], q[2], q[3]]);
    let step = quaternion_of(scale(dt, [omega[0], omega[1], omega[2]]));
    q.copy_from_slice(&unit_quaternion(quaternion_product(now, step)));
}

fn turn_between(from: &[f64], to: &[f64]) -> [f64; 3] {
    let from = unit_quaternion([from[0], -from[1], -from[2], -from[3]]);
    rotation_of(quaternion_product(from, unit_quaternion([to[0], to[1], to[2], to[3]])))
}
